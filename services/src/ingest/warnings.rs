//! What ingest could not use, and went on without.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Warnings by kind: all are counted, the first of each kind are kept.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warnings {
    kinds: BTreeMap<String, Kind>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Kind {
    count: u64,
    messages: Vec<String>,
}

impl Warnings {
    /// Messages that are kept of a kind: a hostile file must not fill the memory with them.
    pub const KEPT: usize = 200;

    /// Notes one.
    pub fn add(&mut self, kind: &str, message: String) {
        let kind = match self.kinds.get_mut(kind) {
            Some(kind) => kind,
            None => self.kinds.entry(kind.to_owned()).or_default(),
        };
        kind.count += 1;
        if kind.messages.len() < Self::KEPT {
            kind.messages.push(message);
        }
    }

    /// Notes all of another's.
    pub fn append(&mut self, other: &Self) {
        for (name, from) in &other.kinds {
            let to = self.kinds.entry(name.clone()).or_default();
            to.count += from.count;
            let room = Self::KEPT.saturating_sub(to.messages.len());
            to.messages.extend(from.messages.iter().take(room).cloned());
        }
    }

    /// The same with paths below `folder` written relative to it, so that what is published
    /// does not depend on where the survey lay.
    #[must_use]
    pub fn relative_to(&self, folder: &Path) -> Self {
        let prefix = format!("{}/", folder.display());
        let mut warnings = self.clone();
        for message in warnings.kinds.values_mut().flat_map(|kind| &mut kind.messages) {
            *message = message.replace(&prefix, "");
        }
        warnings
    }

    /// How many there are of each kind.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.kinds.iter().map(|(name, kind)| (name.clone(), kind.count)).collect()
    }

    /// The kept messages of a kind, in order.
    pub fn messages(&self, kind: &str) -> &[String] {
        self.kinds.get(kind).map_or(&[], |kind| &kind.messages)
    }

    /// Whether nothing was noted.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// What [`Warnings::lines`] gave.
    pub fn from_lines(lines: &[String]) -> Self {
        let mut warnings = Self::default();
        for line in lines {
            let (name, message) = line.split_once(": ").unwrap_or(("other", line));
            let more = message.strip_prefix("and ").and_then(|rest| rest.strip_suffix(" more"));
            match (more.and_then(|number| number.parse::<u64>().ok()), warnings.kinds.get_mut(name))
            {
                (Some(more), Some(kind)) => kind.count = kind.count.saturating_add(more),
                _ => warnings.add(name, message.to_owned()),
            }
        }
        warnings
    }

    /// One line each, `kind: message`, and one more for each kind of which not all are kept.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (name, kind) in &self.kinds {
            lines.extend(kind.messages.iter().map(|message| format!("{name}: {message}")));
            let more = kind.count.saturating_sub(kind.messages.len() as u64);
            if more > 0 {
                lines.push(format!("{name}: and {more} more"));
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_counted_and_the_first_kept() {
        let mut warnings = Warnings::default();
        for i in 0..250 {
            warnings.add("absent-image", format!("image {i}"));
        }
        let mut all = Warnings::default();
        all.add("damaged-file", "a.laz".into());
        all.append(&warnings);
        all.append(&warnings);
        assert_eq!(all.counts()["absent-image"], 500);
        assert_eq!(all.messages("absent-image").len(), Warnings::KEPT);
        assert_eq!(all.messages("absent-image")[0], "image 0");
        assert_eq!(all.lines().last().map(String::as_str), Some("damaged-file: a.laz"));
        assert_eq!(Warnings::from_lines(&all.lines()), all);
        assert!(all.lines().contains(&"absent-image: and 300 more".to_owned()));
    }
}
