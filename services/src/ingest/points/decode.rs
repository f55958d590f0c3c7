//! From a chunk's bytes to its records, as the file stores them.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;
use std::thread;

use laz::las::selective::DecompressionSelection;
use laz::laszip::LazItemType;
use laz::record::{
    LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor,
};
use laz::{LasZipError, LazItem};

use super::file::{Chunk, Encoding, PointFile, read_error};
use super::las_header::COPY_AGAIN;
use crate::ingest::{BadInput, IngestError};

/// Which attributes a caller needs. Only the layered form of LAZ can leave some out; what
/// is left out holds some other point's value.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Attributes {
    All,
    /// Position, class and return number.
    Geometry,
}

/// Records handed on at a time.
const BATCH_RECORDS: u64 = 8_192;

/// The longest compressed chunk that is read: it is held in memory whole, once per thread.
/// Writers put 50 000 to some millions of points in one, of 3 to 20 bytes each.
const MOST_CHUNK_BYTES: u64 = 256 << 20;

/// Calls `sink` with the records of `chunk`, in order, a few thousand at a time.
///
/// # Errors
/// [`BadInput`] naming the point where the bytes stop making sense. The decoder panics on
/// some damaged input; that is caught here and reported in the same way.
pub(super) fn decode_chunk(
    file: &PointFile,
    chunk: &Chunk,
    attributes: Attributes,
    sink: &mut dyn FnMut(&[u8]) -> Result<(), IngestError>,
) -> Result<(), IngestError> {
    let mut source = File::open(&file.path).map_err(|source| read_error(&file.path, source))?;
    source.seek(SeekFrom::Start(chunk.offset)).map_err(|source| read_error(&file.path, source))?;
    let items = match &file.encoding {
        Encoding::LazStream { items } => {
            let source = SequentialPointRecordDecompressor::new(BufReader::new(source));
            return Decoder { file, chunk, items }.run(source, attributes, sink);
        }
        Encoding::Plain => None,
        Encoding::Laz { items, layered } => Some((items, *layered)),
    };
    if chunk.bytes > MOST_CHUNK_BYTES {
        let problem = format!("a chunk of {} bytes is longer than {MOST_CHUNK_BYTES}", chunk.bytes);
        let remedy = "write the file again in smaller chunks";
        return Err(BadInput::error(&file.path, point(chunk, 0), problem, remedy));
    }
    let mut bytes = vec![0; chunk.bytes as usize];
    source.read_exact(&mut bytes).map_err(|source| read_error(&file.path, source))?;
    let Some((items, layered)) = items else {
        let batch = BATCH_RECORDS as usize * usize::from(file.header.record_length);
        return bytes.chunks(batch).try_for_each(sink);
    };
    let decoder = Decoder { file, chunk, items };
    if layered {
        decoder.check_layers(&bytes)?;
        decoder.run(LayeredPointRecordDecompressor::new(Cursor::new(bytes)), attributes, sink)
    } else {
        decoder.run(SequentialPointRecordDecompressor::new(Cursor::new(bytes)), attributes, sink)
    }
}

struct Decoder<'a> {
    file: &'a PointFile,
    chunk: &'a Chunk,
    items: &'a Vec<LazItem>,
}

impl Decoder<'_> {
    fn run<R>(
        &self,
        mut decompressor: impl RecordDecompressor<R>,
        attributes: Attributes,
        sink: &mut dyn FnMut(&[u8]) -> Result<(), IngestError>,
    ) -> Result<(), IngestError> {
        self.guarded(0, || decompressor.set_fields_from(self.items))?;
        decompressor.set_selection(match attributes {
            Attributes::All => DecompressionSelection::all(),
            Attributes::Geometry => {
                DecompressionSelection::base().decompress_z().decompress_classification()
            }
        });
        let record = usize::from(self.file.header.record_length);
        let mut batch = vec![0; BATCH_RECORDS.min(self.chunk.points) as usize * record];
        let mut done = 0;
        while done < self.chunk.points {
            let records = BATCH_RECORDS.min(self.chunk.points - done);
            let batch = &mut batch[..records as usize * record];
            self.guarded(done, || decompressor.decompress_many(batch).map_err(LasZipError::from))?;
            sink(batch)?;
            done += records;
        }
        Ok(())
    }

    /// Runs a step of the decoder, and turns its errors and panics into ours.
    fn guarded(
        &self,
        done: u64,
        step: impl FnOnce() -> Result<(), LasZipError>,
    ) -> Result<(), IngestError> {
        let problem = match quiet_catch_unwind(step) {
            Ok(Ok(())) => return Ok(()),
            Ok(Err(LasZipError::IoError(e))) if e.kind() == io::ErrorKind::UnexpectedEof => {
                "the compressed points end too early".into()
            }
            Ok(Err(error)) => format!("the compressed points are damaged ({error})"),
            Err(_) => "the compressed points are damaged".into(),
        };
        Err(BadInput::error(&self.file.path, point(self.chunk, done), problem, COPY_AGAIN))
    }

    /// Checks the sizes of the layers, for each of which the decoder takes that much memory
    /// before it reads. A chunk is: the first record, the number of points, the layers'
    /// sizes, the layers.
    fn check_layers(&self, bytes: &[u8]) -> Result<(), IngestError> {
        let layers: usize = self.items.iter().map(|item| layer_count(item.item_type())).sum();
        let record = usize::from(self.file.header.record_length);
        let table = bytes.get(record..record + 4 + 4 * layers);
        let mut values = table
            .unwrap_or_default()
            .chunks_exact(4)
            .map(|value| u64::from(u32::from_le_bytes([value[0], value[1], value[2], value[3]])));
        let points = values.next();
        let sum: u64 = values.sum();
        let room = bytes.len().saturating_sub(record + 4 + 4 * layers) as u64;
        let problem = if points != Some(self.chunk.points) {
            format!("the chunk holds {points:?} points instead of {}", self.chunk.points)
        } else if sum > room {
            format!("the chunk's layers take {sum} bytes, where it has {room}")
        } else {
            return Ok(());
        };
        Err(BadInput::error(&self.file.path, point(self.chunk, 0), problem, COPY_AGAIN))
    }
}

/// Layers in which LASzip stores an item of formats 6 to 10.
fn layer_count(item: LazItemType) -> usize {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(bytes) => usize::from(bytes),
        _ => 1,
    }
}

fn point(chunk: &Chunk, done: u64) -> String {
    format!("point {}", chunk.first_point + done)
}

/// Catches a panic without the message that it would leave on standard error: the decoder's
/// assertions are how it notices damage, and the user gets our one line instead. Other
/// threads, and other panics of this one, are reported as before.
fn quiet_catch_unwind<T>(step: impl FnOnce() -> T) -> thread::Result<T> {
    thread_local! {
        static QUIET: Cell<bool> = const { Cell::new(false) };
    }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let hook = take_hook();
        set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                hook(panic);
            }
        }));
    });
    QUIET.set(true);
    let result = catch_unwind(AssertUnwindSafe(step));
    QUIET.set(false);
    result
}
