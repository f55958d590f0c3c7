//! Text that is safe inside markup.

use std::fmt;

/// Shows text so that it is text: in an element, and in a quoted attribute.
pub(super) struct Escaped<'a>(pub(super) &'a str);

/// Shows a figure with that many digits after the point; a dash where there is none, and ∞.
pub(super) struct Figure(pub(super) f64, pub(super) usize);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                other => write!(f, "{other}")?,
            }
        }
        Ok(())
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            value if value.is_nan() => f.write_str("–"),
            value if value.is_infinite() => f.write_str("∞"),
            value => write!(f, "{value:.*}", self.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_name_is_markup() {
        let name = "<img src=x onerror=\"a('&')\">";
        let escaped = Escaped(name).to_string();
        assert_eq!(escaped, "&lt;img src=x onerror=&quot;a(&#39;&amp;&#39;)&quot;&gt;");
        assert_eq!(Escaped("02_000025/2 é").to_string(), "02_000025/2 é");
    }

    #[test]
    fn what_was_not_measured_is_a_dash() {
        assert_eq!(Figure(12.976, 2).to_string(), "12.98");
        assert_eq!(Figure(f64::NAN, 2).to_string(), "–");
        assert_eq!(Figure(f64::INFINITY, 2).to_string(), "∞");
    }
}
