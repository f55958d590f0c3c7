//! Points: LAS, LAZ and COPC files in, COPC files out, with every point and attribute.
//!
//! Files of one input that can share a COPC without touching a raw coordinate do; the
//! others become point sources of their own. The waveforms of formats 4, 5, 9 and 10 are
//! not stored, the packets that point to them are.
//!
//! From the GPS times of the points each source learns where it was taken from, see [`Station`].
//!
//! [`scan()`] reads positions and classes of any such file, for those who measure in them.

mod build;
mod chunk_table;
mod convert;
mod decode;
mod file;
mod group;
mod las_header;
mod moments;
mod morton;
mod ordered;
mod plan;
mod scan;
mod spill;
mod spool;
mod summary;
mod tree;

#[cfg(test)]
mod tests;

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use flaneur_scene::{Bounds3, PointSource, Station};
use serde::{Deserialize, Serialize};

pub use scan::{ScannedPoints, scan, scan_timed};

use self::build::{Built, build_in_memory, part_path, write_error};
use self::file::PointFile;
use self::group::{Group, Layout, WAVEFORM_RECORD, group_files};
use self::spill::{build_on_disk, fits_in_memory};
use super::{BadInput, IngestError, Job};
use crate::layers::stations;

/// Files that a survey names together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PointsInput {
    /// Name of the point source, a file name without its extension.
    pub name: String,
    /// LAS, LAZ or COPC files, in an order that does not change.
    pub files: Vec<PathBuf>,
}

/// A finished COPC in the work folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StagedPoints {
    /// What it holds.
    pub source: PointSource,
    /// Where it is.
    pub file: PathBuf,
    /// The file that says where it was taken from, where the points have times.
    pub stations: Option<PathBuf>,
}

/// Makes a COPC in `job.work` of each input, or several where its files differ in scale,
/// offset, extra bytes, kind of GPS time, CRS, or in the kind of points: those are named
/// `name`, `name-2`, ….
///
/// The same files in the same order give the same bytes, whatever the number of threads.
/// Files without points are left out with a warning.
///
/// # Errors
/// [`BadInput`] for a damaged file, unless the job skips those: then the whole file is left
/// out with a warning. [`IngestError::Io`] where the work folder cannot be written.
pub fn ingest_points(job: &Job, inputs: &[PointsInput]) -> Result<Vec<StagedPoints>, IngestError> {
    let mut names = HashSet::new();
    let mut staged = Vec::new();
    for input in inputs {
        let files = open_files(job, &input.files)?;
        for group in group_files(&input.name, files, &mut names) {
            staged.extend(ingest_group(job, group)?);
        }
    }
    Ok(staged)
}

fn open_files(job: &Job, paths: &[PathBuf]) -> Result<Vec<(PointFile, Layout)>, IngestError> {
    let mut files = Vec::new();
    let mut seen = HashSet::new();
    for path in paths.iter().filter(|path| seen.insert(*path)) {
        job.check()?;
        let opened = PointFile::open(path).and_then(|file| {
            let layout = Layout::of(&file).ok_or_else(|| {
                let problem =
                    format!("records of {} bytes are too long", file.header.record_length);
                BadInput::error(path, "header, point record length", problem, "drop extra bytes")
            })?;
            Ok((file, layout))
        });
        match opened {
            Ok((file, _)) if file.header.point_count == 0 => {
                job.warn("empty-file", format!("{}: holds no points", path.display()));
            }
            Ok(file) => files.push(file),
            Err(IngestError::BadInput(fault)) if job.skip_damaged => warn_damaged(job, &fault),
            Err(error) => return Err(error),
        }
    }
    for (file, _) in &files {
        if file.evlrs.iter().any(|evlr| evlr.is("LASF_Spec", WAVEFORM_RECORD)) {
            let path = file.path.display();
            job.warn("waveforms", format!("{path}: waveforms are not stored, wave packets are"));
        }
    }
    Ok(files)
}

fn warn_damaged(job: &Job, fault: &BadInput) {
    job.warn("damaged-file", format!("left out: {fault}"));
}

/// The group's COPC, `None` where damage leaves no file of it.
fn ingest_group(job: &Job, mut group: Group) -> Result<Option<StagedPoints>, IngestError> {
    fs::create_dir_all(&job.work).map_err(|source| write_error(&job.work, source))?;
    let path = job.work.join(format!("{}.copc.laz", group.name));
    let part = part_path(&path);
    let built = loop {
        let built = if fits_in_memory(job, &group) {
            build_in_memory(job, &group, &part)
        } else {
            build_on_disk(job, &group, &part)
        };
        match built {
            Ok(built) => break built,
            Err(IngestError::BadInput(fault))
                if job.skip_damaged && group.files.iter().any(|f| f.path == fault.file) =>
            {
                warn_damaged(job, &fault);
                group.files.retain(|file| file.path != fault.file);
                if group.files.is_empty() {
                    return Ok(None);
                }
            }
            Err(error) => {
                // Nothing that is not whole stays behind; a kill leaves a `.part` that the
                // next run replaces.
                let _ = fs::remove_file(&part);
                return Err(error);
            }
        }
    };
    fs::rename(&part, &path).map_err(|source| write_error(&path, source))?;
    let (source, taken_from) = point_source(&group, built)?;
    let stations = if taken_from.is_empty() {
        None
    } else {
        let path = job.work.join(format!("{}.stations.json", group.name));
        let bytes = stations::encode(&taken_from).map_err(io::Error::other);
        bytes
            .and_then(|bytes| fs::write(&path, bytes))
            .map_err(|source| write_error(&path, source))?;
        Some(path)
    };
    Ok(Some(StagedPoints { source, file: path, stations }))
}

/// What the group's COPC holds, and where it was taken from.
fn point_source(group: &Group, built: Built) -> Result<(PointSource, Vec<Station>), IngestError> {
    let Built { summary, cube, moments } = built;
    let header = group.copc_header(cube);
    let world = |raw: glam::IVec3| raw.as_dvec3() * header.scale + header.offset;
    let mut laszip_vlr = Vec::new();
    header
        .laz_vlr()
        .write_to(&mut laszip_vlr)
        .map_err(|source| write_error(Path::new(&group.name), source))?;
    let source = PointSource {
        name: group.name.clone(),
        point_count: summary.point_count,
        bounds: Bounds3 { min: world(summary.min), max: world(summary.max) },
        cube,
        point_format: header.point_format,
        record_length: header.record_length(),
        scale: header.scale,
        offset: header.offset,
        laszip_vlr,
        extra_bytes_vlr: group.layout.extra_bytes_vlr.clone(),
        gps_time: group.layout.gps_time,
    };
    Ok((source, moments.stations(header.scale, header.offset)))
}
