//! One file: a header, the key, the payload.
//!
//! ```text
//! bytes  0..8   "flancac1"
//!        8..12  CRC-32 of bytes 12..32 and the key
//!       12..16  CRC-32 of the payload
//!       16..24  length of the payload
//!       24..28  length of the key
//!       28..32  rank: 0 detail, 1 upper
//!       32..    the key, then the payload, then the end of the file
//! ```
//!
//! Numbers are little-endian.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::SystemTime;

use bytes::Bytes;

use crate::cache::{CacheKey, Checked, Rank};

const MAGIC: [u8; 8] = *b"flancac1";
const HEAD_BYTES: usize = 32;

/// Why a file is not the entry that was looked for.
#[derive(Debug, thiserror::Error)]
pub(super) enum EntryError {
    /// It cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It is a folder, a pipe, or larger than all files together may be.
    #[error("is no file of at most {limit} bytes")]
    NoFile {
        /// What the folder may hold.
        limit: u64,
    },
    /// Its header is of another form, or its bytes have changed.
    #[error("its header is damaged")]
    Header,
    /// It belongs to another payload.
    #[error("holds another key")]
    OtherKey,
    /// It was cut, or something was added.
    #[error("has {found} bytes, its header says {expected}")]
    Length {
        /// As the header says.
        expected: u64,
        /// As it is.
        found: u64,
    },
    /// The payload's bytes have changed.
    #[error("its payload has the checksum {found:08x}, its header says {expected:08x}")]
    Payload {
        /// As the header says.
        expected: u32,
        /// As it is.
        found: u32,
    },
    /// It is sound, but the scene has something else by now.
    #[error("is {found:?}, the scene has {expected:?}")]
    Unexpected {
        /// As the scene says.
        expected: Checked,
        /// As it is.
        found: Checked,
    },
}

/// Name of the file of `key`.
pub(super) fn file_name(key: &CacheKey) -> String {
    blake3::hash(key.as_str().as_bytes()).to_hex().to_string()
}

/// Length of the file of `key` with `payload`.
pub(super) fn file_bytes(key: &CacheKey, payload: &Bytes) -> u64 {
    (HEAD_BYTES + key.as_str().len() + payload.len()) as u64
}

/// Writes a new file; an error leaves none behind that could be taken for a whole one.
pub(super) fn write(path: &Path, key: &CacheKey, payload: &Bytes, rank: Rank) -> io::Result<()> {
    let too_long = |_| io::Error::other("a key of more than 4 GiB");
    let key = key.as_str().as_bytes();
    let mut head = Vec::with_capacity(HEAD_BYTES + key.len());
    head.extend(MAGIC);
    head.extend([0; 4]);
    head.extend(crc32fast::hash(payload).to_le_bytes());
    head.extend((payload.len() as u64).to_le_bytes());
    head.extend(u32::try_from(key.len()).map_err(too_long)?.to_le_bytes());
    head.extend(u32::from(rank == Rank::Upper).to_le_bytes());
    head.extend(key);
    let checksum = crc32fast::hash(&head[12..]);
    head[8..12].copy_from_slice(&checksum.to_le_bytes());
    // Never through a link that something else put there.
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(&head)?;
    file.write_all(payload)
}

/// Reads the entry of `key`, and notes on the file that it was used now. A file is taken for no
/// more than `limit` bytes.
pub(super) fn read(
    path: &Path,
    key: &CacheKey,
    limit: u64,
    expected: Option<Checked>,
) -> Result<(Bytes, Rank), EntryError> {
    // Opening a pipe would wait for whoever writes to it.
    let length = match fs::symlink_metadata(path)? {
        file if file.is_file() && file.len() <= limit => file.len(),
        _ => return Err(EntryError::NoFile { limit }),
    };
    let mut file = File::open(path)?;
    let mut head = [0; HEAD_BYTES];
    exactly(&mut file, &mut head)?;
    let number =
        |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let payload_bytes = u64::from(number(16)) | u64::from(number(20)) << 32;
    let key_bytes = u64::from(number(24));
    if head[..8] != MAGIC || key_bytes > length {
        return Err(EntryError::Header);
    }
    let mut held_key = vec![0; key_bytes as usize];
    exactly(&mut file, &mut held_key)?;
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&head[12..]);
    checksum.update(&held_key);
    if checksum.finalize() != number(8) {
        return Err(EntryError::Header);
    }
    if held_key != key.as_str().as_bytes() {
        return Err(EntryError::OtherKey);
    }
    let whole = (HEAD_BYTES as u64 + key_bytes).saturating_add(payload_bytes);
    if whole != length {
        return Err(EntryError::Length { expected: whole, found: length });
    }
    let mut payload = vec![0; payload_bytes as usize];
    exactly(&mut file, &mut payload)?;
    let found = Checked::of(&payload);
    if found.crc32 != number(12) {
        return Err(EntryError::Payload { expected: number(12), found: found.crc32 });
    }
    if let Some(expected) = expected.filter(|expected| *expected != found) {
        return Err(EntryError::Unexpected { expected, found });
    }
    // Where that is not allowed the entry merely looks older than it is.
    drop(file.set_modified(SystemTime::now()));
    let rank = if number(28) == 1 { Rank::Upper } else { Rank::Detail };
    Ok((payload.into(), rank))
}

/// Fills `bytes`; a file that ends before is damaged.
fn exactly(file: &mut File, bytes: &mut [u8]) -> Result<(), EntryError> {
    file.read_exact(bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => EntryError::Header,
        _ => EntryError::Io(error),
    })
}
