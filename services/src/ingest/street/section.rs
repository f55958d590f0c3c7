//! One table of a `street.toml`, read strictly: every fault names its line.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::{BadInput, IngestError};

/// The file being read.
pub(super) struct Document<'a> {
    /// Its path, for messages.
    pub(super) file: &'a Path,
    /// Its text.
    pub(super) text: &'a str,
}

/// A table of it, such as `[scene]` or the second `[[points]]`.
pub(super) struct Section<'a> {
    /// The file.
    pub(super) document: &'a Document<'a>,
    /// How people call it: `[[points]]`.
    pub(super) name: &'a str,
    /// Where it begins.
    pub(super) start: usize,
    /// Its entries.
    pub(super) table: &'a DeTable<'a>,
}

/// The value of a key.
pub(super) struct Entry<'a> {
    section: &'a Section<'a>,
    key: &'static str,
    value: &'a Spanned<DeValue<'a>>,
}

impl Document<'_> {
    /// `line 12`, counted from 1.
    pub(super) fn place(&self, offset: usize) -> String {
        let before = self.text.get(..offset).unwrap_or(self.text);
        format!("line {}", before.bytes().filter(|&byte| byte == b'\n').count() + 1)
    }

    /// A fault at a place of the file.
    pub(super) fn fault(
        &self,
        offset: usize,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> IngestError {
        BadInput::error(self.file, self.place(offset), problem, remedy)
    }

    /// The text at a span, shortened for a message.
    fn excerpt(&self, span: Range<usize>) -> String {
        let text = self.text.get(span).unwrap_or_default();
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if line.chars().count() > 60 {
            line.chars().take(57).chain("...".chars()).collect()
        } else {
            line
        }
    }
}

impl<'a> Section<'a> {
    /// An error at the first key that is not one of `known`.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), IngestError> {
        check_keys(self.document, self.name, self.table, known)
    }

    /// A fault of the section as a whole.
    pub(super) fn fault(
        &self,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> IngestError {
        self.document.fault(self.start, problem, remedy)
    }

    /// The value of `key`, where it is given.
    pub(super) fn get(&'a self, key: &'static str) -> Option<Entry<'a>> {
        self.table.get(key).map(|value| Entry { section: self, key, value })
    }

    /// The value of `key`; `example` shows how it would be written.
    pub(super) fn require(
        &'a self,
        key: &'static str,
        example: &str,
    ) -> Result<Entry<'a>, IngestError> {
        self.get(key).ok_or_else(|| {
            self.fault(format!("{} has no `{key}`", self.name), format!("add {key} = {example}"))
        })
    }

    /// A number of metres that is not negative, 0 where absent.
    pub(super) fn uncertainty(&self) -> Result<f64, IngestError> {
        self.get("uncertainty_m").map_or(Ok(0.0), |entry| entry.positive_or_zero())
    }
}

impl<'a> Entry<'a> {
    /// A fault of this value.
    pub(super) fn fault(&self, problem: &str, remedy: impl Into<String>) -> IngestError {
        let document = self.section.document;
        let (key, section) = (self.key, self.section.name);
        let value = document.excerpt(self.value.span());
        document.fault(
            self.value.span().start,
            format!("`{key}` of {section} is {value}: {problem}"),
            remedy,
        )
    }

    /// The file that it stands in.
    pub(super) fn document(&self) -> &'a Document<'a> {
        self.section.document
    }

    /// `line 12, path`.
    pub(super) fn place(&self) -> String {
        format!("{}, {}", self.section.document.place(self.value.span().start), self.key)
    }

    /// A text.
    pub(super) fn text(&self) -> Result<&'a str, IngestError> {
        self.value.get_ref().as_str().filter(|text| !text.is_empty()).ok_or_else(|| {
            self.fault("expected a text", format!("write {} = \"...\", in quotes", self.key))
        })
    }

    /// Whether it is a text rather than something else.
    pub(super) fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// Yes or no.
    pub(super) fn truth(&self) -> Result<bool, IngestError> {
        self.value.get_ref().as_bool().ok_or_else(|| {
            self.fault("expected true or false", format!("write {} = false", self.key))
        })
    }

    /// A finite number.
    pub(super) fn number(&self) -> Result<f64, IngestError> {
        number(self.value.get_ref())
            .ok_or_else(|| self.fault("expected a finite number", "write it without quotes"))
    }

    /// A finite number, zero or more.
    pub(super) fn positive_or_zero(&self) -> Result<f64, IngestError> {
        self.number().and_then(|number| {
            if number >= 0.0 {
                Ok(number)
            } else {
                Err(self.fault("expected zero or more", "give it in metres"))
            }
        })
    }

    /// Three finite numbers.
    pub(super) fn three_numbers(&self) -> Result<[f64; 3], IngestError> {
        let items = self.value.get_ref().as_array();
        let numbers: Option<Vec<f64>> =
            items.and_then(|items| items.iter().map(|item| number(item.get_ref())).collect());
        numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
            self.fault(
                "expected three finite numbers",
                format!("write {} = [0.0, 0.0, 0.0]", self.key),
            )
        })
    }

    /// A list of integers 0 to 255 that is not empty.
    pub(super) fn classes(&self) -> Result<Vec<u8>, IngestError> {
        let items = self.value.get_ref().as_array();
        let classes: Option<Vec<u8>> = items.and_then(|items| {
            items
                .iter()
                .map(|item| {
                    let integer = item.get_ref().as_integer()?;
                    u8::from_str_radix(integer.as_str(), integer.radix()).ok()
                })
                .collect()
        });
        classes.filter(|classes| !classes.is_empty()).ok_or_else(|| {
            self.fault(
                "expected a list of LAS classes, 0 to 255",
                format!("write {} = [2]", self.key),
            )
        })
    }

    /// One of a few words.
    pub(super) fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T, IngestError> {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let text = self.text()?;
        choices.iter().find(|(word, _)| *word == text).map(|(_, value)| *value).ok_or_else(|| {
            self.fault("there is no such choice", suggestion(text, &words, "the choices are"))
        })
    }
}

/// An error at the first key of `table` that is not one of `known`.
pub(super) fn check_keys(
    document: &Document<'_>,
    section: &str,
    table: &DeTable<'_>,
    known: &[&str],
) -> Result<(), IngestError> {
    let mut unknown: Vec<_> =
        table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())).collect();
    unknown.sort_by_key(|key| key.span().start);
    match unknown.first() {
        None => Ok(()),
        Some(key) => Err(document.fault(
            key.span().start,
            format!("unknown key `{}` in {section}", key.get_ref()),
            suggestion(key.get_ref(), known, "the keys are"),
        )),
    }
}

/// `did you mean "path"? the keys are name, path`.
fn suggestion(text: &str, known: &[&str], list: &str) -> String {
    let nearest = known.iter().max_by(|a, b| {
        let likeness = |word: &str| strsim::normalized_damerau_levenshtein(text, word);
        likeness(a).total_cmp(&likeness(b))
    });
    let nearest = nearest.map_or(String::new(), |word| format!("did you mean `{word}`? "));
    format!("{nearest}{list} {}", known.join(", "))
}

/// A finite number, written as an integer or a float.
fn number(value: &DeValue<'_>) -> Option<f64> {
    let number = match value {
        DeValue::Integer(integer) => {
            #[expect(clippy::cast_precision_loss, reason = "a coordinate, not an identifier")]
            let number = i64::from_str_radix(integer.as_str(), integer.radix()).ok()? as f64;
            number
        }
        DeValue::Float(float) => float.as_str().parse().ok()?,
        _ => return None,
    };
    Some(number).filter(|number: &f64| number.is_finite())
}
