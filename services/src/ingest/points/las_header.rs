//! The public header of a LAS file, versions 1.0 to 1.4.

use std::path::Path;

use glam::DVec3;

use crate::ingest::{BadInput, IngestError};

/// What to do with a file that cannot be read.
pub(super) const COPY_AGAIN: &str =
    "copy the file again from its source, or pass --skip-damaged to leave it out";

/// No projected CRS reaches this far from its origin, metres: the Earth's circumference
/// is 4·10⁷ m.
pub(super) const FARTHEST_COORDINATE_M: f64 = 1e8;

/// What the header says, as far as it can be true of a file of this length.
#[derive(Clone, Debug)]
pub(super) struct LasHeader {
    pub(super) file_source_id: u16,
    pub(super) global_encoding: u16,
    pub(super) guid: [u8; 16],
    pub(super) system_identifier: [u8; 32],
    /// Day of the year and year.
    pub(super) creation: (u16, u16),
    pub(super) header_length: u64,
    pub(super) points_offset: u64,
    pub(super) vlr_count: u32,
    pub(super) point_format: u8,
    pub(super) compressed: bool,
    pub(super) record_length: u16,
    pub(super) point_count: u64,
    pub(super) scale: DVec3,
    pub(super) offset: DVec3,
    /// As claimed: not to be trusted, and perhaps not even finite.
    pub(super) min: DVec3,
    pub(super) max: DVec3,
    pub(super) evlr_offset: u64,
    pub(super) evlr_count: u32,
}

/// The longest header that is read, LAS 1.4.
pub(super) const LONGEST_HEADER: usize = 375;

/// Bytes of a record without extra bytes, by point format.
pub(super) const RECORD_LENGTHS: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

impl LasHeader {
    /// Reads the header from the first [`LONGEST_HEADER`] bytes (or all there are) of a file
    /// that is `file_length` bytes long.
    pub(super) fn parse(file: &Path, bytes: &[u8], file_length: u64) -> Result<Self, IngestError> {
        let bad = |place: &str, problem: String, remedy: &str| {
            BadInput::error(file, format!("header, {place}"), problem, remedy)
        };
        if bytes.get(..4) != Some(b"LASF") {
            return Err(bad(
                "signature",
                format!("{:?} instead of \"LASF\"", String::from_utf8_lossy(head(bytes, 4))),
                "give a LAS, LAZ or COPC file",
            ));
        }
        let fields = Fields { file, bytes };
        let [major, version_minor] = fields.get(24)?;
        if major != 1 || version_minor > 4 {
            return Err(bad(
                "version",
                format!("{major}.{version_minor} is not between 1.0 and 1.4"),
                "convert the file to LAS 1.4",
            ));
        }
        let header_length = fields.u16(94)?;
        let least_length = [227, 227, 227, 235, 375][usize::from(version_minor)];
        if header_length < least_length {
            return Err(bad(
                "header size",
                format!("{header_length} bytes, where LAS 1.{version_minor} has {least_length}"),
                COPY_AGAIN,
            ));
        }
        let points_offset = u64::from(fields.u32(96)?);
        if points_offset < u64::from(header_length) || points_offset > file_length {
            return Err(bad(
                "offset to point data",
                format!(
                    "{points_offset} lies outside the file, between the header's end at \
                     {header_length} and its own end at {file_length}"
                ),
                COPY_AGAIN,
            ));
        }
        let [format_byte] = fields.get(104)?;
        let point_format = format_byte & 0x3f;
        let record_length = fields.u16(105)?;
        let Some(&least_length) = RECORD_LENGTHS.get(usize::from(point_format)) else {
            return Err(bad(
                "point format",
                format!("{point_format} is not between 0 and 10"),
                COPY_AGAIN,
            ));
        };
        if record_length < least_length {
            return Err(bad(
                "point record length",
                format!("{record_length} bytes, where format {point_format} has {least_length}"),
                COPY_AGAIN,
            ));
        }
        let scale = fields.vector(131, 8)?;
        let offset = fields.vector(155, 8)?;
        check_scale(scale).map_err(|problem| {
            bad("scale factors", problem, "correct the header's scale factors")
        })?;
        check_offset(offset)
            .map_err(|problem| bad("offsets", problem, "correct the header's offsets"))?;
        let legacy_count = u64::from(fields.u32(107)?);
        let (evlr_offset, evlr_count, point_count) = if version_minor == 4 {
            let count = fields.u64(247)?;
            let count = if count == 0 { legacy_count } else { count };
            (fields.u64(235)?, fields.u32(243)?, count)
        } else {
            (0, 0, legacy_count)
        };
        Ok(Self {
            file_source_id: fields.u16(4)?,
            global_encoding: fields.u16(6)?,
            guid: fields.get(8)?,
            system_identifier: fields.get(26)?,
            creation: (fields.u16(90)?, fields.u16(92)?),
            header_length: u64::from(header_length),
            points_offset,
            vlr_count: fields.u32(100)?,
            point_format,
            compressed: format_byte & 0x80 != 0,
            record_length,
            point_count,
            scale,
            offset,
            max: fields.vector(179, 16)?,
            min: fields.vector(187, 16)?,
            evlr_offset,
            evlr_count,
        })
    }

    /// Extra bytes behind each record.
    pub(super) fn extra_bytes(&self) -> u16 {
        self.record_length - RECORD_LENGTHS[usize::from(self.point_format)]
    }
}

/// Little-endian fields of a header that may be cut short.
struct Fields<'a> {
    file: &'a Path,
    bytes: &'a [u8],
}

impl Fields<'_> {
    fn get<const N: usize>(&self, at: usize) -> Result<[u8; N], IngestError> {
        self.bytes.get(at..at + N).and_then(|field| field.try_into().ok()).ok_or_else(|| {
            let problem = format!("the file ends after {} bytes", self.bytes.len());
            BadInput::error(self.file, format!("header, byte {at}"), problem, COPY_AGAIN)
        })
    }

    fn u16(&self, at: usize) -> Result<u16, IngestError> {
        self.get(at).map(u16::from_le_bytes)
    }

    fn u32(&self, at: usize) -> Result<u32, IngestError> {
        self.get(at).map(u32::from_le_bytes)
    }

    fn u64(&self, at: usize) -> Result<u64, IngestError> {
        self.get(at).map(u64::from_le_bytes)
    }

    fn f64(&self, at: usize) -> Result<f64, IngestError> {
        self.get(at).map(f64::from_le_bytes)
    }

    fn vector(&self, at: usize, stride: usize) -> Result<DVec3, IngestError> {
        Ok(DVec3::new(self.f64(at)?, self.f64(at + stride)?, self.f64(at + 2 * stride)?))
    }
}

fn check_scale(scale: DVec3) -> Result<(), String> {
    // The largest raw coordinate is 2³¹: beyond this scale it leaves f64's exact range of
    // micrometres, and no survey is that coarse.
    let valid = |s: f64| (1e-12..=1e6).contains(&s);
    match "xyz".chars().zip(scale.to_array()).find(|(_, s)| !valid(*s)) {
        Some((axis, s)) => Err(format!("{axis} is {s}, not between 1e-12 and 1e6")),
        None => Ok(()),
    }
}

fn check_offset(offset: DVec3) -> Result<(), String> {
    let valid = |o: f64| o.abs() <= 1e12;
    match "xyz".chars().zip(offset.to_array()).find(|(_, o)| !valid(*o)) {
        Some((axis, o)) => Err(format!("{axis} is {o}, not between -1e12 and 1e12")),
        None => Ok(()),
    }
}

fn head(bytes: &[u8], n: usize) -> &[u8] {
    &bytes[..n.min(bytes.len())]
}
