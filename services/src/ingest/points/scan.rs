//! Reading positions and classes of many files with bounded memory.

use std::path::PathBuf;

use glam::DVec3;

use super::decode::{Attributes, decode_chunk};
use super::file::{Chunk, PointFile};
use super::ordered::for_each_ordered;
use crate::ingest::{IngestError, Job};

/// Some consecutive points, as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScannedPoints {
    /// World positions, metres.
    pub positions: Vec<DVec3>,
    /// LAS classes.
    pub classes: Vec<u8>,
    /// Return numbers, from 1; 0 where the survey does not say.
    pub return_numbers: Vec<u8>,
    /// Numbers of returns of the points' pulses.
    pub return_counts: Vec<u8>,
}

/// Calls `visit` with all points of the LAS, LAZ or COPC `files`, in the files' order, a
/// chunk (about 50 000 points) at a time. Chunks decode on all threads while `visit` runs;
/// memory is bounded by a few chunks a thread.
///
/// # Errors
/// [`crate::ingest::BadInput`] for a damaged file, what `visit` returns, or
/// [`IngestError::Cancelled`].
pub fn scan(
    files: &[PathBuf],
    job: &Job,
    mut visit: impl FnMut(&ScannedPoints) -> Result<(), IngestError> + Send,
) -> Result<(), IngestError> {
    for path in files {
        let file = PointFile::open(path)?;
        for_each_ordered(
            file.chunks.len(),
            |index| {
                job.check()?;
                scan_chunk(&file, &file.chunks[index])
            },
            |points| visit(&points),
        )?;
    }
    Ok(())
}

fn scan_chunk(file: &PointFile, chunk: &Chunk) -> Result<ScannedPoints, IngestError> {
    let mut points = ScannedPoints::default();
    let record_length = usize::from(file.header.record_length);
    let extended = file.header.point_format >= 6;
    decode_chunk(file, chunk, Attributes::Geometry, &mut |records| {
        for record in records.chunks_exact(record_length) {
            let raw = raw_position(record);
            points.positions.push(raw.as_dvec3() * file.header.scale + file.header.offset);
            if extended {
                points.return_numbers.push(record[14] & 15);
                points.return_counts.push(record[14] >> 4);
                points.classes.push(record[16]);
            } else {
                points.return_numbers.push(record[14] & 7);
                points.return_counts.push(record[14] >> 3 & 7);
                points.classes.push(record[15] & 31);
            }
        }
        Ok(())
    })?;
    Ok(points)
}

/// The raw coordinates at the start of a record of any format.
pub(super) fn raw_position(record: &[u8]) -> glam::IVec3 {
    let axis = |at: usize| {
        i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
    };
    glam::IVec3::new(axis(0), axis(4), axis(8))
}
