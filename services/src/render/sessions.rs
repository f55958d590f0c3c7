//! The sessions that are being watched, by the names that their clients chose.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use flaneur_proto::FieldError;
use tokio_util::sync::CancellationToken;

use super::inputs::Inputs;

/// Lengths of a name: too many to be guessed, and not so many that they fill memory.
const NAME_BYTES: std::ops::RangeInclusive<usize> = 16..=64;

/// Sessions by name.
#[derive(Debug, Default)]
pub(super) struct Sessions {
    by_name: Mutex<HashMap<String, Entry>>,
}

#[derive(Debug)]
struct Entry {
    inputs: Arc<Inputs>,
    /// Ends the stream that watches it.
    superseded: CancellationToken,
}

/// A watched session; ends when it is dropped.
#[derive(Debug)]
pub(super) struct Watched {
    sessions: Arc<Sessions>,
    name: String,
    inputs: Arc<Inputs>,
    /// Cancelled when the session is watched by another stream.
    pub(super) superseded: CancellationToken,
}

/// A session's name, where it is one.
pub(super) fn check_name(name: &str) -> Result<(), FieldError> {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if NAME_BYTES.contains(&name.len()) && name.chars().all(good) {
        return Ok(());
    }
    let problem = "must be 16 to 64 letters, digits, '-' and '_', chosen at random";
    Err(FieldError::new("session", problem))
}

impl Sessions {
    /// Begins to watch; who watched the session before is told.
    pub(super) fn watch(self: &Arc<Self>, name: String, inputs: Arc<Inputs>) -> Watched {
        let superseded = CancellationToken::new();
        let entry = Entry { inputs: Arc::clone(&inputs), superseded: superseded.clone() };
        if let Some(before) = self.locked().insert(name.clone(), entry) {
            before.superseded.cancel();
        }
        Watched { sessions: Arc::clone(self), name, inputs, superseded }
    }

    /// Where a session hears its client.
    pub(super) fn inputs(&self, name: &str) -> Option<Arc<Inputs>> {
        self.locked().get(name).map(|entry| Arc::clone(&entry.inputs))
    }

    fn locked(&self) -> MutexGuard<'_, HashMap<String, Entry>> {
        self.by_name.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let mut by_name = self.sessions.locked();
        // Another stream may watch the session by now.
        if by_name.get(&self.name).is_some_and(|entry| Arc::ptr_eq(&entry.inputs, &self.inputs)) {
            by_name.remove(&self.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_be_guessed() {
        assert!(check_name("0123456789abcdef").is_ok() && check_name(&"x_-9".repeat(16)).is_ok());
        for bad in ["", "0123456789abcde", "0123456789 abcdef", "0123456789abcdé", &"x".repeat(65)]
        {
            assert_eq!(check_name(bad).map_err(|e| e.field), Err("session".to_owned()), "{bad:?}");
        }
    }
}
