//! Paths of photographs with the panorama and the camera left open.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A path such as `images/{camera}_{panorama:07}.jpg`.
///
/// `{panorama}` (required) and `{camera}` stand for the names in the poses and in the
/// calibration; `{panorama:07}` pads with zeros to at least seven characters.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ImagePattern {
    text: String,
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(String),
    Name { which: Placeholder, width: usize },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Placeholder {
    Panorama,
    Camera,
}

/// Widest zero padding.
const MAX_WIDTH: usize = 32;

impl ImagePattern {
    /// Reads a pattern; the error says what is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            let (name, tail) = after.split_once('}').ok_or_else(|| "'{' without '}'".to_owned())?;
            if !before.is_empty() {
                parts.push(Part::Text(before.to_owned()));
            }
            parts.push(placeholder(name)?);
            rest = tail;
        }
        if !rest.is_empty() {
            parts.push(Part::Text(rest.to_owned()));
        }
        let has_panorama = parts
            .iter()
            .any(|part| matches!(part, Part::Name { which: Placeholder::Panorama, .. }));
        if !has_panorama {
            return Err("no {panorama} in it".to_owned());
        }
        Ok(Self { text: text.to_owned(), parts })
    }

    /// The path of one photograph. What the names hold is not checked: resolve the result
    /// with [`super::Root::resolve`].
    pub fn fill(&self, panorama: &str, camera: &str) -> String {
        let mut path = String::new();
        for part in &self.parts {
            match part {
                Part::Text(text) => path.push_str(text),
                Part::Name { which, width } => {
                    let name = match which {
                        Placeholder::Panorama => panorama,
                        Placeholder::Camera => camera,
                    };
                    for _ in name.chars().count()..*width {
                        path.push('0');
                    }
                    path.push_str(name);
                }
            }
        }
        path
    }

    /// A glob that every filled path matches.
    pub fn glob(&self) -> String {
        self.parts
            .iter()
            .map(|part| match part {
                Part::Text(text) => globset::escape(text),
                Part::Name { .. } => "*".to_owned(),
            })
            .collect()
    }
}

impl fmt::Display for ImagePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl TryFrom<String> for ImagePattern {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::parse(&text)
    }
}

impl From<ImagePattern> for String {
    fn from(pattern: ImagePattern) -> Self {
        pattern.text
    }
}

fn placeholder(inside: &str) -> Result<Part, String> {
    let (name, width) = match inside.split_once(':') {
        None => (inside, 0),
        Some((name, format)) => {
            let width = format
                .strip_prefix('0')
                .and_then(|digits| digits.parse().ok())
                .filter(|width| (1..=MAX_WIDTH).contains(width))
                .ok_or_else(|| {
                    format!("\":{format}\" is no zero padding such as \":07\", up to {MAX_WIDTH}")
                })?;
            (name, width)
        }
    };
    let which = match name {
        "panorama" => Placeholder::Panorama,
        "camera" => Placeholder::Camera,
        _ => return Err(format!("{{{name}}} is neither {{panorama}} nor {{camera}}")),
    };
    Ok(Part::Name { which, width })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_and_pads() {
        let pattern = ImagePattern::parse("a/{camera}-1_{panorama:07}.jpg").expect("valid");
        assert_eq!(pattern.fill("482", "300"), "a/300-1_0000482.jpg");
        assert_eq!(pattern.fill("12345678", "c"), "a/c-1_12345678.jpg");
        assert_eq!(pattern.glob(), "a/*-1_*.jpg");
    }

    #[test]
    fn names_what_is_wrong() {
        for (text, problem) in [
            ("a.jpg", "no {panorama}"),
            ("{panorama", "without '}'"),
            ("{pano}.jpg", "{pano} is neither"),
            ("{panorama:7}.jpg", "\":7\" is no zero padding"),
            ("{panorama:0999}.jpg", "\":0999\""),
        ] {
            let error = ImagePattern::parse(text).expect_err(text);
            assert!(error.contains(problem), "{text}: {error}");
        }
    }
}
