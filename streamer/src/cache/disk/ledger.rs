//! Whose turn it is to write, and who wrote last.

use std::fs::{File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

/// How long a writer waits for its turn. The others' turns last milliseconds: whoever holds
/// on for longer has been stopped.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often it asks meanwhile.
const POLL: Duration = Duration::from_millis(1);

/// A file that is locked by whoever writes to the folder, with the name of who did so last:
/// where that is another, what is known of the folder is out of date.
#[derive(Debug)]
pub(super) struct Ledger {
    file: File,
    /// Ours; no other writer's, be it in this process or another.
    name: [u8; 8],
}

impl Ledger {
    /// Opens the file, or makes it.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        // The standard library's source of randomness: keys of a new hasher.
        Ok(Self { file, name: RandomState::new().hash_one(path).to_le_bytes() })
    }

    /// Waits for the turn to write, and takes it until the guard is dropped. A process that is
    /// killed loses it at once.
    ///
    /// # Errors
    /// [`io::ErrorKind::TimedOut`] where another does not end its turn.
    pub(super) fn turn(&self) -> io::Result<Turn<'_>> {
        let started = Instant::now();
        loop {
            match self.file.try_lock() {
                Ok(()) => return Ok(Turn { ledger: self }),
                Err(TryLockError::WouldBlock) if started.elapsed() < PATIENCE => {
                    thread::sleep(POLL);
                }
                Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::TimedOut.into()),
                Err(TryLockError::Error(error)) => return Err(error),
            }
        }
    }
}

/// The turn to write.
#[derive(Debug)]
pub(super) struct Turn<'a> {
    ledger: &'a Ledger,
}

impl Turn<'_> {
    /// Enters our name; gives whether it was there already, so that nobody else has written
    /// since. To be done before anything is changed: whoever comes after a writer that was
    /// killed finds its name, and looks.
    pub(super) fn claim(&self) -> io::Result<bool> {
        let mut file = &self.ledger.file;
        let mut last = Vec::new();
        file.rewind()?;
        file.take(self.ledger.name.len() as u64).read_to_end(&mut last)?;
        if last == self.ledger.name {
            return Ok(true);
        }
        file.rewind()?;
        file.write_all(&self.ledger.name)?;
        Ok(false)
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        // Where this fails, closing the file ends the turn.
        drop(self.ledger.file.unlock());
    }
}

#[cfg(test)]
mod tests;
