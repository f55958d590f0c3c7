//! The files of a folder: how many bytes they take, and which was used longest ago.

use std::collections::{BTreeSet, HashMap};
use std::fs::{self, DirBuilder, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use bytes::Bytes;

use super::entry;
use super::ledger::Ledger;
use crate::cache::{CacheKey, Rank};

/// The cache's own folder within the one it was given. Nothing outside is touched, and within it
/// only files whose names have the cache's form.
const OWN_FOLDER: &str = "flaneur-payloads-1";
/// The ledger within that.
const LEDGER: &str = "ledger";
/// Added to a name while the file is written.
const PART: &str = ".part";
/// A file takes whole blocks of the disk.
const BLOCK_BYTES: u64 = 4096;

/// The writer's side of the folder. What it knows of the files it finds out in its first turn, and
/// again whenever another process has written since.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    limit: u64,
    ledger: Arc<Ledger>,
    index: Index,
}

impl Folder {
    /// Makes the cache's own folder within `folder`, where it is missing; gives its path.
    pub(super) fn make(folder: &Path) -> io::Result<PathBuf> {
        let path = folder.join(OWN_FOLDER);
        let mut builder = DirBuilder::new();
        builder.recursive(true);
        // What one may see another need not be allowed to.
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(&path)?;
        Ok(path)
    }

    /// Prepares for writing to the cache's own folder at `path`, whose files together may take
    /// `limit` bytes.
    pub(super) fn open(path: PathBuf, limit: u64) -> io::Result<Self> {
        let ledger = Arc::new(Ledger::open(&path.join(LEDGER))?);
        Ok(Self { path, limit, ledger, index: Index::default() })
    }

    /// Does `work` while no other process writes, and with true knowledge of the files.
    pub(super) fn turn<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> io::Result<T>,
    ) -> io::Result<T> {
        let ledger = Arc::clone(&self.ledger);
        let turn = ledger.turn()?;
        if !turn.claim()? {
            self.scan()?;
        }
        work(self)
    }

    /// Writes an entry, in a turn; those used longest ago make room. One that is there already, or
    /// is larger than all may be together, is not written.
    pub(super) fn store(&mut self, key: &CacheKey, payload: &Bytes, rank: Rank) -> io::Result<()> {
        let name = entry::file_name(key);
        let path = self.path.join(&name);
        let length = entry::file_bytes(key, payload);
        if blocks(length) + BLOCK_BYTES > self.limit {
            return Ok(());
        }
        let there = fs::symlink_metadata(&path);
        if there.is_ok_and(|file| file.is_file() && file.len() == length) {
            let used = SystemTime::now();
            // Where that is not allowed the entry merely looks older than it is.
            drop(File::open(&path).and_then(|file| file.set_modified(used)));
            self.index.note(name, used, blocks(length));
            return Ok(());
        }
        self.remove(&name)?;
        self.make_room(blocks(length))?;
        let part = self.path.join(format!("{name}{PART}"));
        gone(fs::remove_file(&part))?;
        let written = entry::write(&part, key, payload, rank);
        if let Err(error) = written.and_then(|()| fs::rename(&part, &path)) {
            drop(fs::remove_file(&part));
            return Err(error);
        }
        self.index.note(name, SystemTime::now(), blocks(length));
        Ok(())
    }

    /// Removes the entry of a file's name, in a turn.
    pub(super) fn remove(&mut self, name: &str) -> io::Result<()> {
        gone(fs::remove_file(self.path.join(name)))?;
        self.index.forget(name);
        Ok(())
    }

    /// Bytes that the files take, in blocks.
    pub(super) fn bytes(&self) -> u64 {
        self.index.bytes + BLOCK_BYTES
    }

    /// Looks at all files. Parts are of writers that were killed: it is our turn.
    fn scan(&mut self) -> io::Result<()> {
        self.index = Index::default();
        for file in fs::read_dir(&self.path)? {
            let file = file?;
            let Ok(name) = file.file_name().into_string() else { continue };
            if name.strip_suffix(PART).is_some_and(is_entry) {
                gone(fs::remove_file(file.path()))?;
            } else if is_entry(&name)
                // Another process may have removed it since.
                && let Ok(metadata) = file.metadata()
                && metadata.is_file()
            {
                self.index.note(name, metadata.modified()?, blocks(metadata.len()));
            }
        }
        self.make_room(0)
    }

    /// Removes files until `bytes` more may be taken.
    fn make_room(&mut self, bytes: u64) -> io::Result<()> {
        while self.bytes() + bytes > self.limit {
            let Some((name, used)) = self.index.oldest() else { break };
            let path = self.path.join(&name);
            // Readers, of this process or another, say on the file that they used it.
            match fs::symlink_metadata(&path).and_then(|file| Ok((file.modified()?, file.len()))) {
                Ok((again, length)) if again > used => {
                    self.index.note(name, again, blocks(length));
                }
                _ => self.remove(&name)?,
            }
        }
        Ok(())
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

/// Names of entries with their size in blocks, by when they were last used.
#[derive(Debug, Default)]
struct Index {
    by_name: HashMap<String, (SystemTime, u64)>,
    by_use: BTreeSet<(SystemTime, String)>,
    bytes: u64,
}

impl Index {
    fn note(&mut self, name: String, used: SystemTime, bytes: u64) {
        self.forget(&name);
        self.by_use.insert((used, name.clone()));
        self.by_name.insert(name, (used, bytes));
        self.bytes += bytes;
    }

    fn forget(&mut self, name: &str) {
        if let Some((name, (used, bytes))) = self.by_name.remove_entry(name) {
            self.by_use.remove(&(used, name));
            self.bytes -= bytes;
        }
    }

    fn oldest(&self) -> Option<(String, SystemTime)> {
        self.by_use.first().map(|(used, name)| (name.clone(), *used))
    }
}

fn blocks(bytes: u64) -> u64 {
    bytes.div_ceil(BLOCK_BYTES).saturating_mul(BLOCK_BYTES)
}

/// Whether a file's name is that of an entry: a hash in lower case.
fn is_entry(name: &str) -> bool {
    name.len() == 2 * blake3::OUT_LEN
        && name.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// A file that is not there need not be removed.
fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
