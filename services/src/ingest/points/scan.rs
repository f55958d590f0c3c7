//! Reading positions and classes of many files with bounded memory.

use std::path::PathBuf;

use glam::DVec3;

use super::decode::{Attributes, decode_chunk};
use super::file::PointFile;
use super::las_header::LasHeader;
use super::moments::GPS_TIME;
use super::ordered::{for_each_ordered, window_within};
use crate::ingest::{IngestError, Job};

/// Some consecutive points, as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScannedPoints {
    /// World positions, metres.
    pub positions: Vec<DVec3>,
    /// GPS times, seconds; empty unless they were asked for.
    pub times_s: Vec<f64>,
    /// LAS classes.
    pub classes: Vec<u8>,
    /// Return numbers, from 1; 0 where the survey does not say.
    pub return_numbers: Vec<u8>,
    /// Numbers of returns of the points' pulses.
    pub return_counts: Vec<u8>,
}

/// Calls `visit` with all points of the LAS, LAZ or COPC `files`, in the files' order, a
/// chunk (about 50 000 points, at most a million) at a time. Chunks decode on all threads while `visit` runs;
/// memory is bounded by a few chunks a thread.
///
/// # Errors
/// [`crate::ingest::BadInput`] for a damaged file, what `visit` returns, or
/// [`IngestError::Cancelled`].
pub fn scan(
    files: &[PathBuf],
    job: &Job,
    visit: impl FnMut(&ScannedPoints) -> Result<(), IngestError> + Send,
) -> Result<(), IngestError> {
    scan_attributes(files, job, Attributes::Geometry, visit)
}

/// As [`scan`], with the points' times, of files whose records have them where formats 6 to 10 do:
/// those that ingest has made.
///
/// # Errors
/// As [`scan`].
pub fn scan_timed(
    files: &[PathBuf],
    job: &Job,
    visit: impl FnMut(&ScannedPoints) -> Result<(), IngestError> + Send,
) -> Result<(), IngestError> {
    scan_attributes(files, job, Attributes::All, visit)
}

fn scan_attributes(
    files: &[PathBuf],
    job: &Job,
    attributes: Attributes,
    mut visit: impl FnMut(&ScannedPoints) -> Result<(), IngestError> + Send,
) -> Result<(), IngestError> {
    for path in files {
        let file = PointFile::open(path)?;
        let most = file.chunks.iter().map(|chunk| chunk.points).max().unwrap_or(0);
        if most > MOST_CHUNK_POINTS {
            scan_in_sequence(&file, job, attributes, &mut visit)?;
            continue;
        }
        for_each_ordered(
            file.chunks.len(),
            window_within(job.memory / 8, most * size_of::<(DVec3, f64, [u8; 3])>() as u64),
            |index| {
                job.check()?;
                let mut points = ScannedPoints::default();
                decode_chunk(&file, &file.chunks[index], attributes, &mut |records| {
                    points.extend(&file.header, records, attributes);
                    Ok(())
                })?;
                Ok(points)
            },
            |points| visit(&points),
        )?;
    }
    Ok(())
}

/// Chunks with more points than this are not held whole. The oldest LAZ files are one chunk.
pub(super) const MOST_CHUNK_POINTS: u64 = 1 << 20;

fn scan_in_sequence(
    file: &PointFile,
    job: &Job,
    attributes: Attributes,
    visit: &mut impl FnMut(&ScannedPoints) -> Result<(), IngestError>,
) -> Result<(), IngestError> {
    for chunk in &file.chunks {
        decode_chunk(file, chunk, attributes, &mut |records| {
            job.check()?;
            let mut points = ScannedPoints::default();
            points.extend(&file.header, records, attributes);
            visit(&points)
        })?;
    }
    Ok(())
}

impl ScannedPoints {
    fn extend(&mut self, header: &LasHeader, records: &[u8], attributes: Attributes) {
        let extended = header.point_format >= 6;
        for record in records.chunks_exact(usize::from(header.record_length)) {
            let raw = raw_position(record);
            self.positions.push(raw.as_dvec3() * header.scale + header.offset);
            if extended && attributes == Attributes::All {
                let time = std::array::from_fn(|i| record[GPS_TIME + i]);
                self.times_s.push(f64::from_le_bytes(time));
            }
            if extended {
                self.return_numbers.push(record[14] & 15);
                self.return_counts.push(record[14] >> 4);
                self.classes.push(record[16]);
            } else {
                self.return_numbers.push(record[14] & 7);
                self.return_counts.push(record[14] >> 3 & 7);
                self.classes.push(record[15] & 31);
            }
        }
    }
}

/// The raw coordinates at the start of a record of any format.
pub(super) fn raw_position(record: &[u8]) -> glam::IVec3 {
    let axis = |at: usize| {
        i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
    };
    glam::IVec3::new(axis(0), axis(4), axis(8))
}
