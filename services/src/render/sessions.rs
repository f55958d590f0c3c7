//! The sessions that are being watched, by the names that their clients chose.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use flaneur_proto::FieldError;
use tokio::sync::OwnedSemaphorePermit;
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
    /// Its place among all sessions, which it keeps when it is watched again.
    place: Arc<OwnedSemaphorePermit>,
    /// Ends the stream that watches it.
    superseded: CancellationToken,
}

/// A watched session; ends when it is dropped.
#[derive(Debug)]
pub(super) struct Watched {
    sessions: Arc<Sessions>,
    name: String,
    inputs: Arc<Inputs>,
    pub(super) place: Arc<OwnedSemaphorePermit>,
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
    /// Begins to watch; who watched the session before is told. A session that was not watched takes
    /// a `free` place.
    ///
    /// # Errors
    /// Those of `free`: then nothing has changed.
    pub(super) fn watch<E>(
        self: &Arc<Self>,
        name: String,
        inputs: Arc<Inputs>,
        free: impl FnOnce() -> Result<OwnedSemaphorePermit, E>,
    ) -> Result<Watched, E> {
        let mut by_name = self.locked();
        let place = match by_name.get(&name) {
            Some(before) => {
                before.superseded.cancel();
                Arc::clone(&before.place)
            }
            None => Arc::new(free()?),
        };
        let superseded = CancellationToken::new();
        let entry = Entry {
            inputs: Arc::clone(&inputs),
            place: Arc::clone(&place),
            superseded: superseded.clone(),
        };
        by_name.insert(name.clone(), entry);
        drop(by_name);
        Ok(Watched { sessions: Arc::clone(self), name, inputs, place, superseded })
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
    use flaneur_proto::v1;
    use tokio::sync::Semaphore;

    use super::*;

    #[test]
    fn who_watches_a_session_again_keeps_its_place() {
        let view = v1::View {
            eye: Some(v1::Point3::default()),
            extent: Some(v1::view::Extent::FovDeg(60.0)),
            width: 16,
            height: 16,
            ..v1::View::default()
        };
        let update = v1::ViewUpdate { view: Some(view), ..v1::ViewUpdate::default() };
        let inputs = || Arc::new(Inputs::begin(update.clone(), &Arc::default()).expect("good"));
        let (sessions, places) = (Arc::new(Sessions::default()), Arc::new(Semaphore::new(1)));
        let watch = |name: &str| {
            let free = || Arc::clone(&places).try_acquire_owned();
            sessions.watch(name.to_owned(), inputs(), free)
        };
        let first = watch("one").expect("the place");
        let second = watch("one").expect("the same place");
        assert!(first.superseded.is_cancelled() && !second.superseded.is_cancelled());
        assert!(watch("two").is_err(), "there is one place");
        drop(first);
        assert!(watch("two").is_err(), "and the session has it still");
        assert!(sessions.inputs("one").is_some());
        drop(second);
        assert!(sessions.inputs("one").is_none());
        watch("two").expect("it is free");
    }

    #[test]
    fn names_cannot_be_guessed() {
        assert!(check_name("0123456789abcdef").is_ok() && check_name(&"x_-9".repeat(16)).is_ok());
        for bad in ["", "0123456789abcde", "0123456789 abcdef", "0123456789abcdé", &"x".repeat(65)]
        {
            assert_eq!(check_name(bad).map_err(|e| e.field), Err("session".to_owned()), "{bad:?}");
        }
    }
}
