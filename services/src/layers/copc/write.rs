//! Writing a COPC file front to back, node by node.

use std::fs::File;
use std::io::{self, BufWriter, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;

use flaneur_scene::{NodeKey, OctreeCube};
use glam::{DVec3, IVec3};
use laz::laszip::{ChunkTable, ChunkTableEntry};
use laz::record::{LayeredPointRecordCompressor, RecordCompressor};
use laz::{LazVlr, LazVlrBuilder};

use super::checksums;
use super::hierarchy::{NodeEntry, hierarchy_pages};
use super::vlr::{Evlr, Vlr, padded};

/// What is known of a point source before its points are written.
#[derive(Clone, Debug)]
pub struct CopcHeader {
    /// LAS file source id.
    pub file_source_id: u16,
    /// LAS global encoding.
    pub global_encoding: u16,
    /// LAS project id.
    pub guid: [u8; 16],
    /// LAS system identifier.
    pub system_identifier: [u8; 32],
    /// Day of the year and year of the file's making.
    pub creation: (u16, u16),
    /// Point data record format: 6, 7 or 8.
    pub point_format: u8,
    /// Bytes of extra attributes behind each record.
    pub extra_bytes: u16,
    /// Scale factors.
    pub scale: DVec3,
    /// Offsets.
    pub offset: DVec3,
    /// The octree.
    pub cube: OctreeCube,
    /// Records before the points, besides those that make the file a COPC.
    pub vlrs: Vec<Vlr>,
    /// Records behind the points, besides the octree's index and its checksums.
    pub evlrs: Vec<Evlr>,
}

/// What is known of a point source once all of its points have been seen.
#[derive(Clone, Debug, PartialEq)]
pub struct CopcSummary {
    /// Number of points.
    pub point_count: u64,
    /// Number of points by return, the first return first.
    pub by_return: [u64; 15],
    /// Least raw coordinates.
    pub min: IVec3,
    /// Greatest raw coordinates.
    pub max: IVec3,
    /// Least and greatest GPS time.
    pub gps_time: (f64, f64),
}

/// A COPC file in the making. It is no valid file before [`CopcWriter::finish`].
pub struct CopcWriter {
    out: BufWriter<File>,
    position: u64,
    header: CopcHeader,
    laz: LazVlr,
    vlr_bytes: Vec<u8>,
    points_start: u64,
    entries: Vec<NodeEntry>,
    chunks: ChunkTable,
}

const HEADER_LENGTH: u16 = 375;
const COPC_INFO_LENGTH: usize = 160;

impl CopcHeader {
    /// Bytes of an uncompressed record.
    pub fn record_length(&self) -> u16 {
        base_record_length(self.point_format) + self.extra_bytes
    }

    /// The LASzip description of the records, in chunks of varying size.
    pub fn laz_vlr(&self) -> LazVlr {
        LazVlrBuilder::default()
            .with_point_format(self.point_format, self.extra_bytes)
            .expect("formats 6, 7 and 8 are known to the compressor")
            .with_variable_chunk_size()
            .build()
    }
}

/// Bytes of a record of format 6, 7 or 8 without extra bytes.
pub(crate) fn base_record_length(point_format: u8) -> u16 {
    match point_format {
        6 => 30,
        7 => 36,
        _ => 38,
    }
}

/// The chunk of a node with these records.
///
/// # Errors
/// Where there are more than 2³² records.
pub fn compress_node<'a>(
    laz: &LazVlr,
    records: impl Iterator<Item = &'a [u8]>,
) -> io::Result<Vec<u8>> {
    let mut compressor = NodeCompressor::new(laz)?;
    for record in records {
        compressor.push(record)?;
    }
    Ok(compressor.finish()?.0)
}

/// The chunk of a node in the making, record by record.
pub struct NodeCompressor {
    compressor: LayeredPointRecordCompressor<'static, Cursor<Vec<u8>>>,
    points: u32,
}

impl NodeCompressor {
    /// An empty chunk.
    pub fn new(laz: &LazVlr) -> io::Result<Self> {
        let mut compressor = LayeredPointRecordCompressor::new(Cursor::new(Vec::new()));
        compressor.set_fields_from(laz.items()).map_err(io::Error::other)?;
        Ok(Self { compressor, points: 0 })
    }

    /// Adds a record.
    pub fn push(&mut self, record: &[u8]) -> io::Result<()> {
        let too_many = || io::Error::other("a node of more than 2^32 points");
        self.points = self.points.checked_add(1).ok_or_else(too_many)?;
        self.compressor.compress_next(record)
    }

    /// The chunk, and how many records it holds.
    pub fn finish(mut self) -> io::Result<(Vec<u8>, u32)> {
        self.compressor.done()?;
        Ok((self.compressor.into_inner().into_inner(), self.points))
    }
}

impl CopcWriter {
    /// Begins the file at `path`, replacing what is there.
    pub fn create(path: &Path, header: CopcHeader) -> io::Result<Self> {
        let laz = header.laz_vlr();
        let mut laz_data = Vec::new();
        laz.write_to(&mut laz_data)?;
        let mut vlr_bytes =
            Vlr::new(LazVlr::USER_ID, LazVlr::RECORD_ID, LazVlr::DESCRIPTION, laz_data).to_bytes();
        for vlr in &header.vlrs {
            vlr_bytes.extend(vlr.to_bytes());
        }
        let info_length = Vlr::HEADER_LENGTH + COPC_INFO_LENGTH as u64;
        let points_start = u64::from(HEADER_LENGTH) + info_length + vlr_bytes.len() as u64;
        u32::try_from(points_start)
            .map_err(|_| io::Error::other("the variable length records exceed 4 GiB"))?;
        let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
        // Zeros where the header will stand: a file that was cut short is no LAS file.
        let position = points_start + 8;
        io::copy(&mut io::repeat(0).take(position), &mut out)?;
        Ok(Self {
            out,
            position,
            header,
            laz,
            vlr_bytes,
            points_start,
            entries: Vec::new(),
            chunks: ChunkTable::default(),
        })
    }

    /// The LASzip description of the records.
    pub fn laz_vlr(&self) -> &LazVlr {
        &self.laz
    }

    /// Adds a node whose chunk was made by [`compress_node`]. Each node is added once, and
    /// with each node all nodes above it must be added at some time.
    pub fn add_node(&mut self, key: NodeKey, point_count: u32, chunk: &[u8]) -> io::Result<()> {
        let too_large = |_| io::Error::other("a node's chunk exceeds 2 GiB");
        let byte_size = i32::try_from(chunk.len()).map_err(too_large)?.unsigned_abs();
        i32::try_from(point_count).map_err(too_large)?;
        self.out.write_all(chunk)?;
        let (offset, crc32) = (self.position, crc32fast::hash(chunk));
        self.entries.push(NodeEntry { key, offset, byte_size, point_count, crc32 });
        self.chunks.push(ChunkTableEntry {
            point_count: u64::from(point_count),
            byte_count: u64::from(byte_size),
        });
        self.position += u64::from(byte_size);
        Ok(())
    }

    /// Writes the tables behind the points and the header before them, and has the system
    /// put all of it on the disk.
    pub fn finish(mut self, summary: &CopcSummary) -> io::Result<()> {
        let chunk_table_start = self.position;
        let mut table = Vec::new();
        self.chunks.write_to(&mut table, &self.laz)?;
        self.out.write_all(&table)?;

        let evlr_start = chunk_table_start + table.len() as u64;
        let pages_start = evlr_start + Evlr::HEADER_LENGTH;
        let pages = hierarchy_pages(&self.entries, pages_start);
        self.out.write_all(&Evlr::header_bytes(
            padded("copc"),
            1000,
            padded("EPT hierarchy"),
            pages.entries.len() as u64,
        ))?;
        self.out.write_all(&pages.entries)?;
        self.out.write_all(&checksums::header_bytes(pages.checksums.len() as u64))?;
        self.out.write_all(&pages.checksums)?;
        for evlr in &self.header.evlrs {
            copy_evlr(evlr, &mut self.out)?;
        }

        let mut front = self.las_header(summary, evlr_start);
        front.extend(
            Vlr::new(
                "copc",
                1,
                "COPC info VLR",
                self.copc_info(summary, pages_start, pages.root_bytes),
            )
            .to_bytes(),
        );
        front.append(&mut self.vlr_bytes);
        front.extend(chunk_table_start.to_le_bytes());
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&front)?;
        self.out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
    }

    fn las_header(&self, summary: &CopcSummary, evlr_start: u64) -> Vec<u8> {
        let header = &self.header;
        let mut bytes = Vec::with_capacity(usize::from(HEADER_LENGTH));
        bytes.extend(b"LASF");
        bytes.extend(header.file_source_id.to_le_bytes());
        bytes.extend(header.global_encoding.to_le_bytes());
        bytes.extend(header.guid);
        bytes.extend([1, 4]);
        bytes.extend(header.system_identifier);
        bytes.extend(padded::<32>(concat!("flaneur ", env!("CARGO_PKG_VERSION"))));
        bytes.extend(header.creation.0.to_le_bytes());
        bytes.extend(header.creation.1.to_le_bytes());
        bytes.extend(HEADER_LENGTH.to_le_bytes());
        bytes.extend((self.points_start as u32).to_le_bytes());
        bytes.extend((2 + header.vlrs.len() as u32).to_le_bytes());
        bytes.push(header.point_format | 0x80);
        bytes.extend(header.record_length().to_le_bytes());
        bytes.extend([0; 24]); // legacy counts, which formats above 5 leave zero
        for vector in [header.scale, header.offset] {
            for value in vector.to_array() {
                bytes.extend(value.to_le_bytes());
            }
        }
        let min = summary.min.as_dvec3() * header.scale + header.offset;
        let max = summary.max.as_dvec3() * header.scale + header.offset;
        for (min, max) in min.to_array().into_iter().zip(max.to_array()) {
            bytes.extend(max.to_le_bytes());
            bytes.extend(min.to_le_bytes());
        }
        bytes.extend(0u64.to_le_bytes()); // waveform packets
        bytes.extend(evlr_start.to_le_bytes());
        bytes.extend((2 + header.evlrs.len() as u32).to_le_bytes());
        bytes.extend(summary.point_count.to_le_bytes());
        for count in summary.by_return {
            bytes.extend(count.to_le_bytes());
        }
        bytes
    }

    fn copc_info(&self, summary: &CopcSummary, pages_start: u64, root_page: u64) -> Vec<u8> {
        let cube = &self.header.cube;
        let mut bytes = Vec::with_capacity(COPC_INFO_LENGTH);
        let centre = cube.centre.to_array();
        for value in [centre[0], centre[1], centre[2], cube.half_size_m, cube.spacing_m] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(pages_start.to_le_bytes());
        bytes.extend(root_page.to_le_bytes());
        bytes.extend(summary.gps_time.0.to_le_bytes());
        bytes.extend(summary.gps_time.1.to_le_bytes());
        bytes.resize(COPC_INFO_LENGTH, 0);
        bytes
    }
}

fn copy_evlr(evlr: &Evlr, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&Evlr::header_bytes(
        evlr.user_id,
        evlr.record_id,
        evlr.description,
        evlr.length,
    ))?;
    let mut source = File::open(&evlr.file)?;
    source.seek(SeekFrom::Start(evlr.offset))?;
    let copied = io::copy(&mut source.take(evlr.length), out)?;
    if copied < evlr.length {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
    }
    Ok(())
}
