//! A group of files to a COPC, in memory.

use std::io;
use std::path::{Path, PathBuf};

use flaneur_scene::{NodeKey, OctreeCube};
use rayon::prelude::*;

use super::convert::Conversion;
use super::decode::{Attributes, decode_chunk};
use super::file::{Chunk, PointFile};
use super::group::Group;
use super::las_header::FARTHEST_COORDINATE_M;
use super::moments::SharedMoments;
use super::morton::{Grid, code};
use super::ordered::{for_each_ordered, window_within};
use super::scan::raw_position;
use super::summary::{NO_POINTS, finished, include, merge};
use super::tree::{Key, NodePoints, build_tree, occupied_cells, suitable_grid_bits};
use crate::ingest::{BadInput, IngestError, Job, Stage, Unit};
use crate::layers::copc::{CopcSummary, CopcWriter, compress_node};

/// Builds the group's COPC at `path`.
pub(super) fn build_in_memory(job: &Job, group: &Group, path: &Path) -> Result<Built, IngestError> {
    let length = group.layout.record_length();
    let moments = SharedMoments::default();
    let (records, summary) = read_all(job, group, &moments)?;
    let mut grid = Grid::around(summary.min, summary.max, group.layout.scale, group.layout.offset);

    let stage = job.stage("sort points", summary.point_count, Unit::Points);
    let mut keys = keys_of(&records, length, &grid, 0);
    keys.par_sort_unstable();
    job.check()?;
    let grid_bits = suitable_grid_bits(|bits| occupied_cells(&keys, bits));
    grid.set_spacing(grid_bits);
    let rekey = |keys: &mut [Key], base| rekey(keys, &records, length, &grid, base);
    let nodes = build_tree(&mut keys, NodeKey::ROOT, grid_bits, &rekey);
    stage.advance(summary.point_count);
    drop(stage);

    let stage = job.stage("write points", summary.point_count, Unit::Points);
    let summary = finished(summary);
    let mut writer = CopcWriter::create(path, group.copc_header(grid.cube))
        .map_err(|source| write_error(path, source))?;
    write_nodes(
        job,
        &mut writer,
        path,
        Records { bytes: &records, length },
        &keys,
        &nodes,
        &*stage,
    )?;
    writer.finish(&summary).map_err(|source| write_error(path, source))?;
    Ok(Built { summary, cube: grid.cube, moments })
}

/// What is known of a COPC that was built.
pub(super) struct Built {
    pub(super) summary: CopcSummary,
    pub(super) cube: OctreeCube,
    pub(super) moments: SharedMoments,
}

/// Records one behind the other, each `length` bytes.
#[derive(Clone, Copy)]
pub(super) struct Records<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) length: usize,
}

impl<'a> Records<'a> {
    pub(super) fn get(self, index: u32) -> &'a [u8] {
        &self.bytes[index as usize * self.length..][..self.length]
    }
}

/// A file of ours that could not be written.
pub(super) fn write_error(path: &Path, source: io::Error) -> IngestError {
    IngestError::io("write", path, source)
}

/// Compresses nodes on all threads and writes them in order. Within a node the records keep
/// the order in which the survey has them: neighbours in time differ least.
pub(super) fn write_nodes(
    job: &Job,
    writer: &mut CopcWriter,
    path: &Path,
    records: Records<'_>,
    keys: &[Key],
    nodes: &[NodePoints],
    stage: &dyn Stage,
) -> Result<(), IngestError> {
    let laz = writer.laz_vlr().clone();
    let compress = |number: usize| {
        job.check()?;
        let node = &nodes[number];
        let mut places: Vec<u32> = keys[node.range.clone()].iter().map(|key| key.index).collect();
        places.sort_unstable();
        let chunk = compress_node(&laz, places.iter().map(|place| records.get(*place)))
            .map_err(|source| write_error(path, source))?;
        Ok((node.key, places.len() as u32, chunk))
    };
    // A compressed chunk is shorter than its records.
    let largest = nodes.iter().map(|node| node.range.len()).max().unwrap_or(0) * records.length;
    let window = window_within(job.memory / 8, largest as u64);
    for_each_ordered(nodes.len(), window, compress, |(key, points, chunk)| {
        stage.advance(u64::from(points));
        writer.add_node(key, points, &chunk).map_err(|source| write_error(path, source))
    })
}

/// Keys of all records, with codes counted from level `base`.
pub(super) fn keys_of(records: &[u8], length: usize, grid: &Grid, base: u32) -> Vec<Key> {
    records
        .par_chunks_exact(length)
        .enumerate()
        .map(|(index, record)| Key::new(code(grid.cell(raw_position(record)), base), index as u32))
        .collect()
}

/// Gives keys the codes counted from `base`.
pub(super) fn rekey(keys: &mut [Key], records: &[u8], length: usize, grid: &Grid, base: u32) {
    let records = Records { bytes: records, length };
    for key in keys {
        let cell = grid.cell(raw_position(records.get(key.index)));
        *key = Key::new(code(cell, base), key.index);
    }
}

/// All records of a group in the order of its files.
fn read_all(
    job: &Job,
    group: &Group,
    moments: &SharedMoments,
) -> Result<(Vec<u8>, CopcSummary), IngestError> {
    let length = group.layout.record_length();
    let stage = job.stage("read points", group.point_count(), Unit::Points);
    let mut records = vec![0; group.point_count() as usize * length];
    let mut jobs = Vec::new();
    let mut left = records.as_mut_slice();
    for (number, file) in group.files.iter().enumerate() {
        for chunk in &file.chunks {
            let (target, rest) = left.split_at_mut(chunk.points as usize * length);
            jobs.push((number, chunk, target));
            left = rest;
        }
    }
    let summaries: Vec<(usize, CopcSummary)> = jobs
        .into_par_iter()
        .map(|(number, chunk, target)| {
            job.check()?;
            let file = &group.files[number];
            let mut targets = target.chunks_exact_mut(length);
            let conversion = Conversion::of(&file.header);
            decode_chunk(file, chunk, Attributes::All, &mut |batch| {
                for source in batch.chunks_exact(conversion.source_length()) {
                    if let Some(target) = targets.next() {
                        conversion.convert(source, target);
                    }
                }
                Ok(())
            })?;
            let summary = summary_of(file, chunk, target, length, moments)?;
            stage.advance(chunk.points);
            Ok((number, summary))
        })
        .collect::<Result<_, IngestError>>()?;
    let summary = merge_by_file(job, group, summaries);
    Ok((records, summary))
}

/// Counts a chunk's records, and refuses positions where no survey can be.
pub(super) fn summary_of(
    file: &PointFile,
    chunk: &Chunk,
    records: &[u8],
    length: usize,
    moments: &SharedMoments,
) -> Result<CopcSummary, IngestError> {
    let mut summary = NO_POINTS;
    for record in records.chunks_exact(length) {
        include(&mut summary, record);
    }
    let farthest = |raw: glam::IVec3| {
        (raw.as_dvec3() * file.header.scale + file.header.offset).abs().max_element()
    };
    if farthest(summary.min).max(farthest(summary.max)) <= FARTHEST_COORDINATE_M {
        moments.include(records, length);
        return Ok(summary);
    }
    let positions = records.chunks_exact(length).map(raw_position).zip(chunk.first_point..);
    for (raw, number) in positions {
        if farthest(raw) > FARTHEST_COORDINATE_M {
            let position = raw.as_dvec3() * file.header.scale + file.header.offset;
            return Err(BadInput::error(
                &file.path,
                format!("point {number}"),
                format!("coordinates {position} lie more than {FARTHEST_COORDINATE_M:e} m out"),
                "correct the header's scale and offset, or pass --skip-damaged to leave the file out",
            ));
        }
    }
    Ok(summary)
}

/// One summary of all, and a warning for each file whose header misstates its bounds.
pub(super) fn merge_by_file(
    job: &Job,
    group: &Group,
    summaries: impl IntoIterator<Item = (usize, CopcSummary)>,
) -> CopcSummary {
    let mut by_file = vec![NO_POINTS; group.files.len()];
    for (number, summary) in summaries {
        merge(&mut by_file[number], &summary);
    }
    let mut all = NO_POINTS;
    for (file, summary) in group.files.iter().zip(&by_file) {
        merge(&mut all, summary);
        let header = &file.header;
        let min = summary.min.as_dvec3() * header.scale + header.offset;
        let max = summary.max.as_dvec3() * header.scale + header.offset;
        // Writers round the bounds; a step of the scale is no misstatement.
        let inside = (header.min - header.scale).cmple(min).all()
            && (header.max + header.scale).cmpge(max).all();
        if !inside {
            job.warn(
                "header-bounds",
                format!(
                    "{}, header, bounds: {} to {} leave out points, which reach from {min} to \
                     {max}; the points' own bounds are used",
                    file.path.display(),
                    header.min,
                    header.max
                ),
            );
        }
    }
    all
}

/// A file that is made under another name until it is whole.
pub(super) fn part_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}
