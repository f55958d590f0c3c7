//! A LAS, LAZ or COPC file that was found sound, as a list of chunks that decode alone.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use laz::laszip::CompressorType;
use laz::{LazItem, LazVlr};

use super::chunk_table::read_chunk_table;
use super::las_header::{COPY_AGAIN, LONGEST_HEADER, LasHeader};
use crate::ingest::{BadInput, IngestError};
use crate::layers::copc::{Evlr, Vlr};

/// An input file whose header, records and chunk table agree with its length.
#[derive(Clone, Debug)]
pub(super) struct PointFile {
    pub(super) path: PathBuf,
    pub(super) header: LasHeader,
    pub(super) vlrs: Vec<Vlr>,
    pub(super) evlrs: Vec<Evlr>,
    pub(super) encoding: Encoding,
    /// In the order of their points.
    pub(super) chunks: Vec<Chunk>,
}

/// How the points of a file are stored.
#[derive(Clone, Debug)]
pub(super) enum Encoding {
    /// LAS.
    Plain,
    /// LAZ; `layered` is the form of formats 6 to 10.
    Laz { items: Vec<LazItem>, layered: bool },
    /// The oldest LAZ: one stream from the first point to the last.
    LazStream { items: Vec<LazItem> },
}

/// Points that decode without those before them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    /// Index of the first point in the file.
    pub(super) first_point: u64,
    pub(super) points: u64,
    /// Where the chunk begins in the file, bytes.
    pub(super) offset: u64,
    /// Its length, bytes.
    pub(super) bytes: u64,
}

/// Points of a chunk of an uncompressed file, where the size is ours to choose.
const PLAIN_CHUNK_POINTS: u64 = 50_000;

/// The most that all records before the points may hold: they are kept in memory.
const MOST_VLR_BYTES: u64 = 64 << 20;

impl PointFile {
    /// Reads everything but the points.
    pub(super) fn open(path: &Path) -> Result<Self, IngestError> {
        let mut source = File::open(path).map_err(|source| read_error(path, source))?;
        let length = source.metadata().map_err(|source| read_error(path, source))?.len();
        let mut start = Vec::new();
        source
            .by_ref()
            .take(LONGEST_HEADER as u64)
            .read_to_end(&mut start)
            .map_err(|source| read_error(path, source))?;
        let header = LasHeader::parse(path, &start, length)?;
        let vlrs = read_vlrs(path, &mut source, &header)?;
        let evlrs = read_evlrs(path, &mut source, &header, length)?;
        let (encoding, chunks) = if header.compressed {
            laz_chunks(path, &mut source, &header, &vlrs, length)?
        } else {
            (Encoding::Plain, plain_chunks(path, &header, length)?)
        };
        Ok(Self { path: path.to_owned(), header, vlrs, evlrs, encoding, chunks })
    }
}

/// A file that could not be read although it is there, or is not.
pub(super) fn read_error(path: &Path, source: io::Error) -> IngestError {
    if source.kind() == io::ErrorKind::UnexpectedEof {
        return BadInput::error(path, "", "the file ends too early", COPY_AGAIN);
    }
    IngestError::Io {
        action: "read",
        path: path.to_owned(),
        source,
        remedy: "check that the file is there and readable".into(),
    }
}

fn read_vlrs(path: &Path, source: &mut File, h: &LasHeader) -> Result<Vec<Vlr>, IngestError> {
    let mut left = h.points_offset - h.header_length;
    if u64::from(h.vlr_count) * Vlr::HEADER_LENGTH > left.min(MOST_VLR_BYTES) {
        return Err(BadInput::error(
            path,
            "header, number of variable length records",
            format!("{} records do not fit before the points at {}", h.vlr_count, h.points_offset),
            COPY_AGAIN,
        ));
    }
    source.seek(SeekFrom::Start(h.header_length)).map_err(|source| read_error(path, source))?;
    let mut source = io::BufReader::new(source);
    let mut held = 0;
    let mut vlrs = Vec::with_capacity(h.vlr_count as usize);
    for index in 0..h.vlr_count {
        let mut head = [0; Vlr::HEADER_LENGTH as usize];
        let mut data = Vec::new();
        let too_long = |length: u64| {
            let place = format!("variable length record {index}");
            let problem = format!("its {length} bytes reach beyond the start of the points");
            BadInput::error(path, place, problem, COPY_AGAIN)
        };
        left = left.checked_sub(Vlr::HEADER_LENGTH).ok_or_else(|| too_long(0))?;
        source.read_exact(&mut head).map_err(|source| read_error(path, source))?;
        let length = u64::from(u16::from_le_bytes([head[20], head[21]]));
        left = left.checked_sub(length).ok_or_else(|| too_long(length))?;
        held += length;
        if held > MOST_VLR_BYTES {
            return Err(too_long(held));
        }
        data.resize(length as usize, 0);
        source.read_exact(&mut data).map_err(|source| read_error(path, source))?;
        let (user_id, record_id, description) = identity(&head);
        vlrs.push(Vlr { user_id, record_id, description: description(22), data });
    }
    Ok(vlrs)
}

fn read_evlrs(
    path: &Path,
    source: &mut File,
    h: &LasHeader,
    file_length: u64,
) -> Result<Vec<Evlr>, IngestError> {
    let outside =
        |place: String, problem: String| BadInput::error(path, place, problem, COPY_AGAIN);
    if h.evlr_count == 0 {
        return Ok(Vec::new());
    }
    if h.evlr_offset < h.points_offset || h.evlr_offset > file_length {
        return Err(outside(
            "header, start of extended variable length records".into(),
            format!("{} lies outside the file of {file_length} bytes", h.evlr_offset),
        ));
    }
    if u64::from(h.evlr_count) > (file_length - h.evlr_offset) / Evlr::HEADER_LENGTH {
        return Err(outside(
            "header, number of extended variable length records".into(),
            format!("{} records do not fit in the file of {file_length} bytes", h.evlr_count),
        ));
    }
    let mut evlrs = Vec::new();
    let mut position = h.evlr_offset;
    for index in 0..h.evlr_count {
        let mut head = [0; Evlr::HEADER_LENGTH as usize];
        source.seek(SeekFrom::Start(position)).map_err(|source| read_error(path, source))?;
        source.read_exact(&mut head).map_err(|source| read_error(path, source))?;
        let length = u64::from_le_bytes(std::array::from_fn(|i| head[20 + i]));
        let offset = position + Evlr::HEADER_LENGTH;
        position =
            offset.checked_add(length).filter(|end| *end <= file_length).ok_or_else(|| {
                outside(
                    format!("extended variable length record {index}"),
                    format!("its {length} bytes reach beyond the file's end at {file_length}"),
                )
            })?;
        let (user_id, record_id, description) = identity(&head);
        let description = description(28);
        evlrs.push(Evlr { user_id, record_id, description, file: path.into(), offset, length });
    }
    Ok(evlrs)
}

/// User id, record id, and the description at a place, of a record's header.
fn identity(head: &[u8]) -> ([u8; 16], u16, impl Fn(usize) -> [u8; 32]) {
    let user_id = std::array::from_fn(|i| head[2 + i]);
    let record_id = u16::from_le_bytes([head[18], head[19]]);
    (user_id, record_id, move |at| std::array::from_fn(|i| head[at + i]))
}

fn plain_chunks(path: &Path, h: &LasHeader, length: u64) -> Result<Vec<Chunk>, IngestError> {
    let record = u64::from(h.record_length);
    let room = (length - h.points_offset) / record;
    if h.point_count > room {
        return Err(BadInput::error(
            path,
            "header, point count",
            format!("{} points are promised, and the file has room for {room}", h.point_count),
            COPY_AGAIN,
        ));
    }
    let chunk = |first_point| {
        let points = PLAIN_CHUNK_POINTS.min(h.point_count - first_point);
        let offset = h.points_offset + first_point * record;
        Chunk { first_point, points, offset, bytes: points * record }
    };
    Ok((0..h.point_count).step_by(PLAIN_CHUNK_POINTS as usize).map(chunk).collect())
}

fn laz_chunks(
    path: &Path,
    source: &mut File,
    h: &LasHeader,
    vlrs: &[Vlr],
    length: u64,
) -> Result<(Encoding, Vec<Chunk>), IngestError> {
    let bad = |problem: String| BadInput::error(path, "LASzip record", problem, COPY_AGAIN);
    let vlr = vlrs
        .iter()
        .find(|vlr| vlr.is(LazVlr::USER_ID, LazVlr::RECORD_ID))
        .ok_or_else(|| bad("absent, although the points are compressed".into()))?;
    let laz = LazVlr::from_buffer(&vlr.data).map_err(|error| bad(error.to_string()))?;
    let items = laz.items().clone();
    // Summed wider than the decoder does, which overflows.
    let size: u32 = items.iter().map(|item| u32::from(item.size())).sum();
    if size != u32::from(h.record_length) {
        return Err(bad(format!(
            "records of {size} bytes, where the header says {}",
            h.record_length
        )));
    }
    // The third and fourth bytes are the coder; the first two the compressor, which the
    // decoder's own type keeps to itself.
    let compressor = u16::from_le_bytes([vlr.data[0], vlr.data[1]]);
    let layered = compressor == CompressorType::LayeredChunked as u16;
    if items.iter().any(|item| (item.version() >= 3) != layered) {
        return Err(bad("items of a version that does not go with its compressor".into()));
    }
    if compressor == CompressorType::PointWise as u16 {
        let chunk = Chunk {
            first_point: 0,
            points: h.point_count,
            offset: h.points_offset,
            bytes: length - h.points_offset,
        };
        let chunks = if h.point_count == 0 { Vec::new() } else { vec![chunk] };
        return Ok((Encoding::LazStream { items }, chunks));
    }
    if compressor == CompressorType::None as u16 {
        return Err(bad("says that the points are not compressed, where the header does".into()));
    }
    let chunks = read_chunk_table(path, source, h, &laz, length)?;
    Ok((Encoding::Laz { items, layered }, chunks))
}
