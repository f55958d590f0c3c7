//! Records on disk while they are sorted. The files have no name: they vanish with the
//! process, however it ends.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use flaneur_scene::NodeKey;

/// A file of regions of known length, each filled front to back through a buffer.
pub(super) struct Regions {
    file: File,
    regions: Vec<Region>,
    buffer_bytes: usize,
}

struct Region {
    start: u64,
    length: u64,
    written: u64,
    buffer: Vec<u8>,
}

impl Regions {
    /// Regions of these lengths in bytes, in a file in `folder`. All buffers together take
    /// at most `memory` bytes, or 4 kB a region where that is more.
    pub(super) fn create(
        folder: &Path,
        lengths: impl Iterator<Item = u64>,
        memory: u64,
    ) -> io::Result<Self> {
        let mut start = 0;
        let regions: Vec<_> = lengths
            .map(|length| {
                let region = Region { start, length, written: 0, buffer: Vec::new() };
                start += length;
                region
            })
            .collect();
        let share = memory / regions.len().max(1) as u64;
        let buffer_bytes = share.clamp(4 << 10, 1 << 20) as usize;
        Ok(Self { file: tempfile::tempfile_in(folder)?, regions, buffer_bytes })
    }

    /// Adds to a region. An error where it would overflow, which a caller that counted
    /// beforehand sees only if its source changed since.
    pub(super) fn append(&mut self, region: usize, bytes: &[u8]) -> io::Result<()> {
        let region = &mut self.regions[region];
        let used = region.written + (region.buffer.len() + bytes.len()) as u64;
        if used > region.length {
            return Err(io::Error::other("the input changed while it was read"));
        }
        if region.buffer.len() + bytes.len() > self.buffer_bytes {
            region.flush(&mut self.file)?;
        }
        if bytes.len() >= self.buffer_bytes {
            return region.write(&mut self.file, bytes);
        }
        if region.buffer.capacity() == 0 {
            region.buffer.reserve_exact(self.buffer_bytes);
        }
        region.buffer.extend_from_slice(bytes);
        Ok(())
    }

    /// Ends the filling, and gives the buffers' memory back.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        for region in &mut self.regions {
            region.flush(&mut self.file)?;
            region.buffer = Vec::new();
            if region.written != region.length {
                return Err(io::Error::other("the input changed while it was read"));
            }
        }
        Ok(())
    }

    /// The content of a region.
    pub(super) fn read(&mut self, region: usize) -> io::Result<Vec<u8>> {
        let region = &self.regions[region];
        let mut bytes = vec![0; region.length as usize];
        self.file.seek(SeekFrom::Start(region.start))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// A reader of a region's content.
    pub(super) fn reader(&mut self, region: usize) -> io::Result<io::Take<&mut File>> {
        let region = &self.regions[region];
        self.file.seek(SeekFrom::Start(region.start))?;
        Ok((&mut self.file).take(region.length))
    }
}

impl Region {
    fn flush(&mut self, file: &mut File) -> io::Result<()> {
        let mut buffer = std::mem::take(&mut self.buffer);
        self.write(file, &buffer)?;
        buffer.clear();
        self.buffer = buffer;
        Ok(())
    }

    fn write(&mut self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        file.seek(SeekFrom::Start(self.start + self.written))?;
        file.write_all(bytes)?;
        self.written += bytes.len() as u64;
        Ok(())
    }
}

/// Records of the nodes above the buckets, in pieces as they come.
pub(super) struct Samples {
    file: File,
    end: u64,
    pieces: BTreeMap<NodeKey, Vec<(u64, usize)>>,
}

impl Samples {
    pub(super) fn create(folder: &Path) -> io::Result<Self> {
        Ok(Self { file: tempfile::tempfile_in(folder)?, end: 0, pieces: BTreeMap::new() })
    }

    /// Adds records to a node.
    pub(super) fn append(&mut self, node: NodeKey, bytes: &[u8]) -> io::Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(bytes)?;
        self.pieces.entry(node).or_default().push((self.end, bytes.len()));
        self.end += bytes.len() as u64;
        Ok(())
    }

    /// The nodes that have records, by level.
    pub(super) fn nodes(&self) -> Vec<NodeKey> {
        self.pieces.keys().copied().collect()
    }

    /// A node's records, in the order in which they came.
    pub(super) fn read(&mut self, node: NodeKey) -> io::Result<Vec<u8>> {
        let pieces = self.pieces.get(&node).map(Vec::as_slice).unwrap_or_default();
        let mut bytes = vec![0; pieces.iter().map(|piece| piece.1).sum()];
        let mut left = bytes.as_mut_slice();
        for (start, length) in pieces {
            let (target, rest) = left.split_at_mut(*length);
            self.file.seek(SeekFrom::Start(*start))?;
            self.file.read_exact(target)?;
            left = rest;
        }
        Ok(bytes)
    }
}
