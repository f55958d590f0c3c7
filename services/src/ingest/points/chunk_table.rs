//! Where the chunks of a LAZ file begin, and how many points each holds.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use laz::LazVlr;
use laz::laszip::ChunkTable;

use super::file::{Chunk, read_error};
use super::las_header::{COPY_AGAIN, LasHeader};
use crate::ingest::{BadInput, IngestError};

/// Reads and checks the chunk table: chunks lie one behind the other between the start of
/// the points and the table, and hold as many points as the header says.
///
/// All sizes are checked before memory is taken for them: a chunk starts with an
/// uncompressed record, so there cannot be more chunks than records would fit uncompressed.
pub(super) fn read_chunk_table(
    path: &Path,
    source: &mut File,
    header: &LasHeader,
    laz: &LazVlr,
    length: u64,
) -> Result<Vec<Chunk>, IngestError> {
    let bad = |problem: String| BadInput::error(path, "chunk table", problem, COPY_AGAIN);
    let io = |source| read_error(path, source);
    if header.point_count == 0 {
        return Ok(Vec::new());
    }
    let data_start = header.points_offset + 8;
    let mut u64_at = |position| -> Result<u64, IngestError> {
        let mut bytes = [0; 8];
        source.seek(SeekFrom::Start(position)).map_err(io)?;
        source.read_exact(&mut bytes).map_err(io)?;
        Ok(u64::from_le_bytes(bytes))
    };
    let mut table_start = u64_at(header.points_offset)?;
    if (table_start as i64) < data_start as i64 {
        // A writer that could not seek back put the offset at the end.
        table_start = u64_at(length.saturating_sub(8))?;
    }
    if table_start < data_start || table_start.saturating_add(8) > length {
        return Err(bad(format!(
            "it should begin at byte {table_start}, outside the file of {length} bytes: the file \
             is cut short"
        )));
    }
    source.seek(SeekFrom::Start(table_start + 4)).map_err(io)?;
    let mut bytes = [0; 4];
    source.read_exact(&mut bytes).map_err(io)?;
    let claimed = u64::from(u32::from_le_bytes(bytes));
    let most = (table_start - data_start) / u64::from(header.record_length);
    if claimed > most {
        return Err(bad(format!("{claimed} chunks, where at most {most} have room")));
    }
    source.seek(SeekFrom::Start(table_start)).map_err(io)?;
    let mut reader = BufReader::new(source);
    let table = ChunkTable::read(&mut reader, laz.uses_variable_size_chunks()).map_err(io)?;

    let mut chunks = Vec::with_capacity(table.len());
    let mut first_point = 0u64;
    let mut offset = data_start;
    for entry in table.as_ref() {
        // The decoder reads both as i32 and extends the sign.
        let bytes = u64::from(entry.byte_count as u32);
        let end = offset + bytes;
        if end > table_start {
            return Err(bad(format!(
                "chunk {} ends at byte {end}, behind the table's start at {table_start}",
                chunks.len()
            )));
        }
        let left = header.point_count - first_point;
        let points = if laz.uses_variable_size_chunks() {
            u64::from(entry.point_count as u32)
        } else {
            left.min(u64::from(laz.chunk_size()))
        };
        if points > left {
            break;
        }
        if points > 0 {
            chunks.push(Chunk { first_point, points, offset, bytes });
        }
        first_point += points;
        offset = end;
    }
    if first_point != header.point_count {
        return Err(BadInput::error(
            path,
            "header, point count",
            format!(
                "{} points are promised, and the chunk table accounts for {}",
                header.point_count, first_point
            ),
            COPY_AGAIN,
        ));
    }
    Ok(chunks)
}
