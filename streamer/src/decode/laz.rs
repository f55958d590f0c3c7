//! One chunk of layered LAZ, record by record, with its sizes checked first.
//!
//! A chunk is the first record as it is, the number of records, the byte sizes of the layers,
//! and the layers (LAZ 1.4, compressor 3).

use std::io::Cursor;

use flaneur_scene::PointSource;
use laz::laszip::LazItemType;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor};
use laz::{DecompressionSelection, LazVlr};

/// Reads the records of one chunk.
pub(super) struct Records<'a> {
    decompressor: LayeredPointRecordDecompressor<'a, Cursor<&'a [u8]>>,
    record: Vec<u8>,
    left: u32,
}

impl<'a> Records<'a> {
    /// Prepares to read the `count` records of `chunk`. An error says what does not fit.
    pub(super) fn new(source: &PointSource, chunk: &'a [u8], count: u32) -> Result<Self, String> {
        let vlr = LazVlr::from_buffer(&source.laszip_vlr)
            .map_err(|e| format!("the LASzip record of source {:?}: {e}", source.name))?;
        check_sizes(&vlr, source, chunk, count)?;
        let mut decompressor = LayeredPointRecordDecompressor::new(Cursor::new(chunk));
        decompressor.set_fields_from(vlr.items()).map_err(|e| e.to_string())?;
        if decompressor.record_size() != usize::from(source.record_length) {
            return Err(format!("its records have {} bytes", decompressor.record_size()));
        }
        // Only what a picture needs; the other layers are skipped, not decoded.
        decompressor.set_selection(
            DecompressionSelection::base()
                .decompress_z()
                .decompress_classification()
                .decompress_flags()
                .decompress_intensity()
                .decompress_rgb()
                .decompress_gps_time(),
        );
        Ok(Self { decompressor, record: vec![0; usize::from(source.record_length)], left: count })
    }

    /// The next record, `None` after the last.
    pub(super) fn next(&mut self) -> Option<Result<&[u8], String>> {
        self.left = self.left.checked_sub(1)?;
        Some(match self.decompressor.decompress_next(&mut self.record) {
            Ok(()) => Ok(&self.record),
            Err(error) => Err(error.to_string()),
        })
    }
}

/// Refuses what would make the decompressor take memory on the sender's word.
fn check_sizes(vlr: &LazVlr, source: &PointSource, chunk: &[u8], count: u32) -> Result<(), String> {
    let record_length: u32 = vlr.items().iter().map(|item| u32::from(item.size())).sum();
    if record_length != u32::from(source.record_length) {
        return Err(format!(
            "its LASzip record describes records of {record_length} bytes, the source says {}",
            source.record_length
        ));
    }
    let layers: usize = vlr.items().iter().map(|item| layers(item.item_type())).sum();
    let header = usize::from(source.record_length);
    let too_short = || format!("{} bytes are too few for {layers} layers", chunk.len());
    let (head, sizes) =
        chunk.get(header..).and_then(|b| b.split_at_checked(4)).ok_or_else(too_short)?;
    let stored = u32::from_le_bytes(head.try_into().map_err(|_| too_short())?);
    if stored != count {
        return Err(format!("it holds {stored} points, the hierarchy says {count}"));
    }
    let (sizes, data) = sizes.split_at_checked(4 * layers).ok_or_else(too_short)?;
    let total: u64 = sizes
        .chunks_exact(4)
        .map(|size| u64::from(u32::from_le_bytes([size[0], size[1], size[2], size[3]])))
        .sum();
    if total > data.len() as u64 {
        return Err(format!("its layers claim {total} bytes, {} are there", data.len()));
    }
    Ok(())
}

/// Layers that an item of a record is stored in.
fn layers(item: LazItemType) -> usize {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => usize::from(count),
        _ => 1,
    }
}
