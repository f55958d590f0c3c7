//! Comma-separated values with a header line, as RFC 4180 has them.

/// A record: the line on which it begins, and its fields.
pub(super) type Record = (usize, Vec<String>);

/// The records of `text`; fields may be quoted with `"`, doubled inside. Empty lines are
/// left out. The error is a line and what is wrong there.
pub(super) fn parse(text: &str) -> Result<Vec<Record>, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut records = Vec::new();
    let mut characters = text.chars().peekable();
    let mut line = 1;
    while characters.peek().is_some() {
        let start = line;
        let mut fields = Vec::new();
        loop {
            let mut field = String::new();
            if characters.next_if_eq(&'"').is_some() {
                loop {
                    match characters.next() {
                        Some('"') if characters.next_if_eq(&'"').is_none() => break,
                        Some(c) => {
                            line += usize::from(c == '\n');
                            field.push(c);
                        }
                        None => return Err((start, "a quoted field does not end".into())),
                    }
                }
                if let Some(c) = characters.peek().filter(|c| !matches!(c, ',' | '\r' | '\n')) {
                    return Err((line, format!("{c:?} after a quoted field")));
                }
            } else {
                while let Some(c) = characters.next_if(|c| !matches!(c, ',' | '\n')) {
                    field.push(c);
                }
                field.truncate(field.trim_end().len());
            }
            fields.push(field);
            characters.next_if_eq(&'\r');
            match characters.next() {
                Some(',') => {}
                Some('\n') => {
                    line += 1;
                    break;
                }
                _ => break,
            }
        }
        if fields != [""] {
            records.push((start, fields));
        }
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_lines_and_ends() {
        let text = "\u{feff}id,x\r\n\"a, \"\"b\"\"\",1\r\n\r\n\"two\nlines\", 2 \nlast,";
        let records = parse(text).expect("valid");
        let fields = |i: usize| records[i].1.iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!(fields(0), ["id", "x"]);
        assert_eq!(fields(1), ["a, \"b\"", "1"]);
        assert_eq!(fields(2), ["two\nlines", " 2"]);
        assert_eq!(fields(3), ["last", ""]);
        assert_eq!(records.iter().map(|r| r.0).collect::<Vec<_>>(), [1, 2, 4, 6]);
        assert_eq!(parse("").expect("empty"), []);
    }

    #[test]
    fn broken_quotes_are_named_with_their_line() {
        assert_eq!(parse("a\n\"b").expect_err("open").0, 2);
        assert!(parse("\"a\"b").expect_err("trailing").1.contains("'b'"));
    }
}
