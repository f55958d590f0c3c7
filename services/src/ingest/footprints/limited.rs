//! A reader that stops at features of absurd size, so that a file cannot ask for any amount of
//! memory.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

/// The most bytes of text between two features, or in one.
pub(super) const MOST_BYTES: u64 = 64 << 20;

/// Bytes of a file, of which at most [`MOST_BYTES`] are given between two calls of
/// [`Allowance::renew`].
pub(super) struct Limited {
    source: BufReader<File>,
    left: Rc<Cell<u64>>,
}

/// Renews what a [`Limited`] may give.
#[derive(Clone)]
pub(super) struct Allowance(Rc<Cell<u64>>);

impl Limited {
    pub(super) fn open(path: &Path) -> io::Result<(Self, Allowance)> {
        let left = Rc::new(Cell::new(MOST_BYTES));
        let mut source = BufReader::with_capacity(1 << 16, File::open(path)?);
        // Some programs begin their files with a mark that is no JSON.
        let mark = *b"\xef\xbb\xbf";
        if io::BufRead::fill_buf(&mut source)?.starts_with(&mark) {
            io::BufRead::consume(&mut source, mark.len());
        }
        Ok((Self { source, left: Rc::clone(&left) }, Allowance(left)))
    }
}

impl Allowance {
    pub(super) fn renew(&self) {
        self.0.set(MOST_BYTES);
    }

    /// Allows any number of bytes, until it is renewed: for what is read over and not kept.
    pub(super) fn lift(&self) {
        self.0.set(u64::MAX);
    }
}

impl Read for Limited {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.left.get();
        if left == 0 {
            let problem = format!("a single feature is longer than {MOST_BYTES} bytes");
            return Err(io::Error::other(problem));
        }
        let length = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        let read = self.source.read(&mut buffer[..length])?;
        self.left.set(left - read as u64);
        Ok(read)
    }
}
