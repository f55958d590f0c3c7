//! A group of files to a COPC, sorted on disk, for points that do not fit in memory.
//!
//! 1. Count: positions are read once to count points in a grid, and nodes that fit in memory
//!    are chosen as buckets.
//! 2. Distribute: everything is read again, and each record goes to its bucket on disk.
//! 3. Build: one bucket after the other is read. First it gives to each node above it the
//!    sample that falls inside the bucket, exactly as [`super::tree`] would sample; the rest
//!    is a tree of its own. At last the nodes above are written.
//!
//! A bucket too dense for the grid is divided again in the same way, and points that no
//! cell tells apart end up in one leaf, compressed as it is read.
//!
//! The disk holds all records uncompressed once, besides the finished file; twice where a
//! bucket is divided again.

use std::collections::HashSet;
use std::io::{self, Read};
use std::path::Path;

use flaneur_scene::NodeKey;
use glam::IVec3;
use rayon::prelude::*;

use super::build::{
    Built, Records, keys_of, merge_by_file, rekey, summary_of, write_error, write_nodes,
};
use super::convert::Conversion;
use super::decode::{Attributes, decode_chunk};
use super::file::{Chunk, PointFile};
use super::group::Group;
use super::moments::SharedMoments;
use super::morton::{CELL_LEVELS, Grid, node_at};
use super::ordered::{for_each_ordered, window_within};
use super::plan::{CountGrid, Plan};
use super::scan::{MOST_CHUNK_POINTS, raw_position};
use super::spool::{Regions, Samples};
use super::summary::finished;
use super::tree::{
    Key, LEAF_POINTS, LEAST_CHILD, build_tree, code_base, sample_to_end, suitable_grid_bits,
};
use crate::ingest::{IngestError, Job, Stage, Unit};
use crate::layers::copc::{CopcSummary, CopcWriter, NodeCompressor, compress_node};

/// Bytes that the index of a point takes while a tree is built.
const KEY_BYTES: usize = size_of::<Key>();

/// Whether all of the group's points can be sorted in memory. Three fifths of the budget are
/// for records and keys, the rest for what is being read and written.
pub(super) fn fits_in_memory(job: &Job, group: &Group) -> bool {
    let bytes = (group.layout.record_length() + KEY_BYTES) as u64;
    let fits = job.memory / 5 * 3 / bytes;
    group.point_count() <= fits.min(u64::from(u32::MAX))
}

/// Builds the group's COPC at `path`, in the memory that the job allows: no less than what
/// four leaves take, some 20 MB, and what the threads read and write, some 10 MB each.
pub(super) fn build_on_disk(job: &Job, group: &Group, path: &Path) -> Result<Built, IngestError> {
    let length = group.layout.record_length();
    let (counts, mut grid) = count(job, group)?;
    let grid_bits = suitable_grid_bits(|bits| counts.occupied(bits));
    grid.set_spacing(grid_bits);

    let capacity = job.memory / 2 / (length + KEY_BYTES) as u64;
    let capacity = capacity.clamp(4 * LEAF_POINTS as u64, u64::from(u32::MAX));
    let deepest = CELL_LEVELS - grid_bits;
    let plan = counts.plan(capacity, deepest);
    let moments = SharedMoments::default();
    let (mut regions, summary) = distribute(job, group, &grid, &plan, path, &moments)?;

    let summary = finished(summary);
    let stage = job.stage("write points", summary.point_count, Unit::Points);
    let folder = path.parent().unwrap_or(path);
    let mut builder = Builder {
        job,
        grid,
        grid_bits,
        capacity,
        length,
        path,
        folder,
        writer: CopcWriter::create(path, group.copc_header(grid.cube))
            .map_err(|source| write_error(path, source))?,
        samples: Samples::create(folder).map_err(|source| write_error(folder, source))?,
        sampled: HashSet::new(),
        stage: &*stage,
    };
    builder.add_buckets(&mut regions, &plan)?;
    builder.add_samples()?;
    builder.writer.finish(&summary).map_err(|source| write_error(path, source))?;
    Ok(Built { summary, cube: grid.cube, moments })
}

/// Counts the group's points around the root.
fn count(job: &Job, group: &Group) -> Result<(CountGrid, Grid), IngestError> {
    let layout = &group.layout;
    let around = |(min, max)| Grid::around(min, max, layout.scale, layout.offset);
    // The headers' bounds are usually true, and then one pass is enough.
    let mut bounds = claimed_bounds(group);
    loop {
        let grid = around(bounds);
        let counts = CountGrid::new(NodeKey::ROOT);
        let actual = count_in(job, group, &grid, &counts)?;
        if actual == bounds {
            return Ok((counts, grid));
        }
        bounds = actual;
    }
}

fn claimed_bounds(group: &Group) -> (IVec3, IVec3) {
    let mut bounds = (IVec3::MAX, IVec3::MIN);
    for file in &group.files {
        let header = &file.header;
        // `as` turns what is not finite into something that the first pass corrects.
        let raw = |world: glam::DVec3| ((world - header.offset) / header.scale).round().as_ivec3();
        bounds = (bounds.0.min(raw(header.min)), bounds.1.max(raw(header.max)));
    }
    if bounds.0.cmple(bounds.1).all() { bounds } else { (IVec3::ZERO, IVec3::ZERO) }
}

fn count_in(
    job: &Job,
    group: &Group,
    grid: &Grid,
    counts: &CountGrid,
) -> Result<(IVec3, IVec3), IngestError> {
    let stage = job.stage("count points", group.point_count(), Unit::Points);
    let jobs: Vec<_> =
        group.files.iter().flat_map(|file| file.chunks.iter().map(move |c| (file, c))).collect();
    jobs.into_par_iter()
        .map(|(file, chunk)| {
            let (mut min, mut max) = (IVec3::MAX, IVec3::MIN);
            let length = usize::from(file.header.record_length);
            decode_chunk(file, chunk, Attributes::Geometry, &mut |records| {
                job.check()?;
                for record in records.chunks_exact(length) {
                    let raw = raw_position(record);
                    (min, max) = (min.min(raw), max.max(raw));
                    counts.count(grid.cell(raw));
                }
                stage.advance((records.len() / length) as u64);
                Ok(())
            })?;
            Ok((min, max))
        })
        .try_reduce(|| (IVec3::MAX, IVec3::MIN), |a, b| Ok((a.0.min(b.0), a.1.max(b.1))))
}

/// Records of one bucket, and which.
type Share = (usize, Vec<u8>);

/// Reads everything and puts each record in its bucket's region.
fn distribute(
    job: &Job,
    group: &Group,
    grid: &Grid,
    plan: &Plan,
    path: &Path,
    moments: &SharedMoments,
) -> Result<(Regions, CopcSummary), IngestError> {
    let length = group.layout.record_length();
    let folder = path.parent().unwrap_or(path);
    let lengths = plan.buckets.iter().map(|bucket| bucket.points * length as u64);
    let mut regions = Regions::create(folder, lengths, job.memory / 8)
        .map_err(|source| write_error(folder, source))?;
    let stage = job.stage("sort points", group.point_count(), Unit::Points);
    let mut summaries = Vec::new();
    for (number, file) in group.files.iter().enumerate() {
        let most = file.chunks.iter().map(|chunk| chunk.points).max().unwrap_or(0);
        let mut append = |(summary, shares): (CopcSummary, Vec<Share>)| {
            stage.advance(summary.point_count);
            summaries.push((number, summary));
            shares.iter().try_for_each(|(bucket, records)| {
                regions.append(*bucket, records).map_err(|source| spool_error(folder, source))
            })
        };
        if most > MOST_CHUNK_POINTS {
            distribute_in_sequence(job, file, |chunk, records| {
                let summary = summary_of(file, chunk, records, length, moments)?;
                append((summary, shares(records, length, grid, plan)))
            })?;
            continue;
        }
        // A chunk's records are held twice: as they came, and by bucket.
        let window = window_within(job.memory / 8, 2 * most * length as u64);
        let produce = |index: usize| {
            job.check()?;
            let chunk = &file.chunks[index];
            let mut records = Vec::with_capacity(chunk.points as usize * length);
            decode_chunk(file, chunk, Attributes::All, &mut |batch| {
                convert_batch(file, batch, length, &mut records);
                Ok(())
            })?;
            let summary = summary_of(file, chunk, &records, length, moments)?;
            Ok((summary, shares(&records, length, grid, plan)))
        };
        for_each_ordered(file.chunks.len(), window, produce, append)?;
    }
    regions.finish().map_err(|source| spool_error(folder, source))?;
    Ok((regions, merge_by_file(job, group, summaries)))
}

/// Calls `visit` with the converted records of each batch and the chunk that they are.
fn distribute_in_sequence(
    job: &Job,
    file: &PointFile,
    mut visit: impl FnMut(&Chunk, &[u8]) -> Result<(), IngestError>,
) -> Result<(), IngestError> {
    let length = Conversion::of(&file.header).target_length();
    for chunk in &file.chunks {
        let mut part = Chunk { points: 0, ..*chunk };
        let mut records = Vec::new();
        decode_chunk(file, chunk, Attributes::All, &mut |batch| {
            job.check()?;
            records.clear();
            convert_batch(file, batch, length, &mut records);
            part.first_point += part.points;
            part.points = (records.len() / length) as u64;
            visit(&part, &records)
        })?;
    }
    Ok(())
}

fn convert_batch(file: &PointFile, batch: &[u8], length: usize, records: &mut Vec<u8>) {
    let conversion = Conversion::of(&file.header);
    let start = records.len();
    records.resize(start + batch.len() / conversion.source_length() * length, 0);
    let sources = batch.chunks_exact(conversion.source_length());
    for (source, target) in sources.zip(records[start..].chunks_exact_mut(length)) {
        conversion.convert(source, target);
    }
}

/// Records by bucket, in the order in which they came.
fn shares(records: &[u8], length: usize, grid: &Grid, plan: &Plan) -> Vec<Share> {
    let mut places: Vec<(usize, usize)> = records
        .chunks_exact(length)
        .enumerate()
        // Every point was counted. One that was not, because its file changed since, makes
        // its bucket overflow or leaves another short, which the regions notice.
        .map(|(place, record)| {
            (plan.bucket_of(grid.cell(raw_position(record))).unwrap_or(0), place)
        })
        .collect();
    places.sort_unstable();
    places
        .chunk_by(|a, b| a.0 == b.0)
        .map(|share| {
            let records = share.iter().flat_map(|(_, place)| &records[place * length..][..length]);
            (share[0].0, records.copied().collect())
        })
        .collect()
}

struct Builder<'a> {
    job: &'a Job,
    grid: Grid,
    grid_bits: u32,
    /// The most points of a bucket that is built in memory.
    capacity: u64,
    length: usize,
    path: &'a Path,
    folder: &'a Path,
    writer: CopcWriter,
    samples: Samples,
    /// Cells larger than a bucket that have given their point to the sample of a level.
    sampled: HashSet<(u32, NodeKey)>,
    stage: &'a dyn Stage,
}

impl Builder<'_> {
    fn add_buckets(&mut self, regions: &mut Regions, plan: &Plan) -> Result<(), IngestError> {
        for (number, bucket) in plan.buckets.iter().enumerate() {
            self.job.check()?;
            if bucket.points <= self.capacity {
                let records = regions.read(number).map_err(|source| self.error(source))?;
                self.add_bucket(bucket.key, &records)?;
            } else if bucket.key.level < CELL_LEVELS - self.grid_bits {
                self.divide(regions, number, bucket.key)?;
            } else {
                self.add_leaf(regions, number, bucket.key)?;
            }
        }
        Ok(())
    }

    /// A bucket that fits in memory.
    fn add_bucket(&mut self, node: NodeKey, records: &[u8]) -> Result<(), IngestError> {
        let (length, grid) = (self.length, self.grid);
        let base = code_base(node.level, self.grid_bits);
        let rekey = |keys: &mut [Key], base| rekey(keys, records, length, &grid, base);
        let mut keys = keys_of(records, length, &grid, base);
        keys.par_sort_unstable();
        let mut rest = keys.len();
        for level in 0..node.level {
            let start = self.sample(node, level, &mut keys[..rest], base, records)?;
            rest = start;
        }
        if let Some(parent) = node.parent()
            && rest < LEAST_CHILD
        {
            return self.append_sample(parent, &keys[..rest], records);
        }
        let nodes = build_tree(&mut keys[..rest], node, self.grid_bits, &rekey);
        let records = Records { bytes: records, length };
        write_nodes(self.job, &mut self.writer, self.path, records, &keys, &nodes, self.stage)
    }

    /// Gives the node of `level` above `node` its sample of `keys`; returns how many keys
    /// are left, at the front.
    fn sample(
        &mut self,
        node: NodeKey,
        level: u32,
        keys: &mut [Key],
        base: u32,
        records: &[u8],
    ) -> Result<usize, IngestError> {
        let Some(first) = keys.first() else { return Ok(0) };
        let records_view = Records { bytes: records, length: self.length };
        let cell = self.grid.cell(raw_position(records_view.get(first.index)));
        let cell_level = level + self.grid_bits;
        // A cell that holds several buckets gives one point, of the first of them.
        if cell_level < node.level && !self.sampled.insert((level, node_at(cell, cell_level))) {
            return Ok(keys.len());
        }
        let rest = sample_to_end(keys, cell_level, base);
        self.append_sample(node_at(cell, level), &keys[rest..], records)?;
        Ok(rest)
    }

    fn append_sample(
        &mut self,
        node: NodeKey,
        keys: &[Key],
        records: &[u8],
    ) -> Result<(), IngestError> {
        let records = Records { bytes: records, length: self.length };
        let mut places: Vec<u32> = keys.iter().map(|key| key.index).collect();
        places.sort_unstable();
        let bytes: Vec<u8> =
            places.into_iter().flat_map(|place| records.get(place)).copied().collect();
        self.samples.append(node, &bytes).map_err(|source| self.error(source))
    }

    /// A bucket that is divided further.
    fn divide(
        &mut self,
        regions: &mut Regions,
        number: usize,
        node: NodeKey,
    ) -> Result<(), IngestError> {
        let counts = CountGrid::new(node);
        self.read_pieces(regions, number, |builder, piece| {
            for record in piece.chunks_exact(builder.length) {
                counts.count(builder.grid.cell(raw_position(record)));
            }
            Ok(())
        })?;
        let plan = counts.plan(self.capacity, CELL_LEVELS - self.grid_bits);
        let lengths = plan.buckets.iter().map(|bucket| bucket.points * self.length as u64);
        let mut parts = Regions::create(self.folder, lengths, self.job.memory / 8)
            .map_err(|source| self.error(source))?;
        self.read_pieces(regions, number, |builder, piece| {
            for (bucket, records) in shares(piece, builder.length, &builder.grid, &plan) {
                parts.append(bucket, &records).map_err(|source| builder.error(source))?;
            }
            Ok(())
        })?;
        parts.finish().map_err(|source| self.error(source))?;
        self.add_buckets(&mut parts, &plan)
    }

    /// A bucket that nothing divides, as one chunk: points at one place, in all likelihood,
    /// of which each level above takes one.
    fn add_leaf(
        &mut self,
        regions: &mut Regions,
        number: usize,
        node: NodeKey,
    ) -> Result<(), IngestError> {
        let mut levels = 0..node.level;
        let mut compressor =
            NodeCompressor::new(self.writer.laz_vlr()).map_err(|source| self.error(source))?;
        self.read_pieces(regions, number, |builder, piece| {
            for record in piece.chunks_exact(builder.length) {
                let cell = builder.grid.cell(raw_position(record));
                let sampled = &mut builder.sampled;
                let level = levels.find(|level| {
                    let cell_level = level + builder.grid_bits;
                    cell_level >= node.level || sampled.insert((*level, node_at(cell, cell_level)))
                });
                match level {
                    Some(level) => builder.samples.append(node_at(cell, level), record),
                    None => compressor.push(record),
                }
                .map_err(|source| builder.error(source))?;
            }
            Ok(())
        })?;
        let (chunk, points) = compressor.finish().map_err(|source| self.error(source))?;
        self.stage.advance(u64::from(points));
        self.writer.add_node(node, points, &chunk).map_err(|source| self.error(source))
    }

    fn read_pieces(
        &mut self,
        regions: &mut Regions,
        number: usize,
        mut visit: impl FnMut(&mut Self, &[u8]) -> Result<(), IngestError>,
    ) -> Result<(), IngestError> {
        let mut reader = regions.reader(number).map_err(|source| self.error(source))?;
        let mut piece = Vec::new();
        loop {
            self.job.check()?;
            piece.clear();
            let bytes = (PIECE_RECORDS * self.length) as u64;
            reader.by_ref().take(bytes).read_to_end(&mut piece).map_err(|s| self.error(s))?;
            if piece.is_empty() {
                return Ok(());
            }
            visit(self, &piece)?;
        }
    }

    /// The nodes above the buckets.
    fn add_samples(&mut self) -> Result<(), IngestError> {
        for node in self.samples.nodes() {
            self.job.check()?;
            let records = self.samples.read(node).map_err(|source| self.error(source))?;
            let chunk = compress_node(self.writer.laz_vlr(), records.chunks_exact(self.length));
            let points = (records.len() / self.length) as u32;
            chunk
                .and_then(|chunk| self.writer.add_node(node, points, &chunk))
                .map_err(|source| self.error(source))?;
            self.stage.advance(u64::from(points));
        }
        Ok(())
    }

    fn error(&self, source: io::Error) -> IngestError {
        spool_error(self.folder, source)
    }
}

/// Records of a region held at a time.
const PIECE_RECORDS: usize = 100_000;

/// A failure of the files in `folder` that hold records, or of the inputs to stay the same.
fn spool_error(folder: &Path, source: io::Error) -> IngestError {
    if source.kind() != io::ErrorKind::Other {
        return write_error(folder, source);
    }
    IngestError::Io {
        action: "sort points in",
        path: folder.to_owned(),
        source,
        remedy: "leave the input files as they are during ingest, and run again".into(),
    }
}
