//! From records of any LAS point format to the format that COPC allows for them, without
//! loss: 0, 1, 4, 6 and 9 become 6; 2, 3, 5 and 7 become 7; 8 and 10 become 8.
//!
//! | attribute of formats 0 to 5 | becomes |
//! |---|---|
//! | scan angle rank, whole degrees | scan angle in units of 0.006°, rounded: it rounds back |
//! | class 12, "overlap" | the overlap flag, class 1, as LAS 1.4 has it |
//! | synthetic, key-point, withheld bits of the class | flags |
//! | no GPS time (formats 0 and 2) | GPS time 0 |
//! | wave packet (formats 4, 5, 9, 10) | extra bytes `wave …`, see [`WAVE_FIELDS`] |

use super::las_header::{LasHeader, RECORD_LENGTHS};
use crate::layers::copc::{Vlr, base_record_length};

/// The attributes of a wave packet as they stand in the record, with the types that LAS
/// gives extra bytes: 1 is u8, 5 is u32, 7 is u64, 9 is f32.
const WAVE_FIELDS: [(&str, u8); 7] = [
    ("wave descriptor", 1),
    ("wave packet offset", 7),
    ("wave packet size", 5),
    ("wave return location", 9),
    ("wave x(t)", 9),
    ("wave y(t)", 9),
    ("wave z(t)", 9),
];

/// Bytes of a wave packet.
const WAVE_BYTES: usize = 29;

/// Bytes of an extra-bytes descriptor.
const DESCRIPTOR_BYTES: usize = 192;

/// How the records of a file become those of its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Conversion {
    source_format: u8,
    source_length: u16,
    /// Extra bytes of the input's records.
    source_extra: u16,
}

impl Conversion {
    pub(super) fn of(header: &LasHeader) -> Self {
        Self {
            source_format: header.point_format,
            source_length: header.record_length,
            source_extra: header.extra_bytes(),
        }
    }

    /// The point format of the result.
    pub(super) fn target_format(self) -> u8 {
        match self.source_format {
            0 | 1 | 4 | 6 | 9 => 6,
            2 | 3 | 5 | 7 => 7,
            _ => 8,
        }
    }

    /// Extra bytes of the result, `None` where a record would exceed 64 KiB.
    pub(super) fn target_extra(self) -> Option<u16> {
        let extra = self.source_extra.checked_add(if self.has_wave() { 29 } else { 0 })?;
        base_record_length(self.target_format()).checked_add(extra).map(|_| extra)
    }

    /// Whether the records point to waveforms.
    pub(super) fn has_wave(self) -> bool {
        matches!(self.source_format, 4 | 5 | 9 | 10)
    }

    /// Writes `source`, one record, to `target`, one record of the result.
    pub(super) fn convert(self, source: &[u8], target: &mut [u8]) {
        let source_base = usize::from(RECORD_LENGTHS[usize::from(self.source_format)]);
        let target_base = usize::from(base_record_length(self.target_format()));
        let (base, extra) = source.split_at(source_base);
        let (target, target_extra) = target.split_at_mut(target_base);
        if self.source_format >= 6 {
            target.copy_from_slice(&base[..target_base]);
        } else {
            convert_legacy(self.source_format, base, target);
        }
        target_extra[..extra.len()].copy_from_slice(extra);
        if self.has_wave() {
            target_extra[extra.len()..].copy_from_slice(&base[source_base - WAVE_BYTES..]);
        }
    }

    /// Bytes of the input's records.
    pub(super) fn source_length(self) -> usize {
        usize::from(self.source_length)
    }

    /// Bytes of the result's records.
    pub(super) fn target_length(self) -> usize {
        let wave = if self.has_wave() { WAVE_BYTES } else { 0 };
        usize::from(base_record_length(self.target_format()) + self.source_extra) + wave
    }

    /// The descriptors of the result's extra bytes, from the `vlrs` of the input; empty where
    /// there are none.
    pub(super) fn extra_bytes_vlr(self, vlrs: &[Vlr]) -> Vec<u8> {
        let mut data: Vec<u8> = vlrs
            .iter()
            .filter(|vlr| vlr.is("LASF_Spec", 4))
            .flat_map(|vlr| &vlr.data)
            .copied()
            .collect();
        if !self.has_wave() {
            return data;
        }
        data.truncate(data.len() / DESCRIPTOR_BYTES * DESCRIPTOR_BYTES);
        let described: usize = data.chunks_exact(DESCRIPTOR_BYTES).map(described_bytes).sum();
        let mut undescribed = usize::from(self.source_extra).saturating_sub(described);
        while undescribed > 0 {
            let bytes = undescribed.min(255);
            data.extend(descriptor(&format!("undocumented {undescribed}"), 0, bytes as u8));
            undescribed -= bytes;
        }
        for (name, data_type) in WAVE_FIELDS {
            data.extend(descriptor(name, data_type, 0));
        }
        data
    }
}

fn convert_legacy(format: u8, source: &[u8], target: &mut [u8]) {
    target[..14].copy_from_slice(&source[..14]); // position, intensity
    let (returns, class) = (source[14], source[15]);
    target[14] = (returns & 7) | (returns >> 3 & 7) << 4;
    let overlap = class & 31 == 12;
    target[15] = class >> 5 | u8::from(overlap) << 3 | returns & 0b1100_0000;
    target[16] = if overlap { 1 } else { class & 31 };
    target[17] = source[17]; // user data
    let degrees = f64::from(source[16].cast_signed());
    target[18..20].copy_from_slice(&((degrees / 0.006).round() as i16).to_le_bytes());
    target[20..22].copy_from_slice(&source[18..20]); // point source id
    match format {
        0 => target[22..30].fill(0),
        2 => {
            target[22..30].fill(0);
            target[30..36].copy_from_slice(&source[20..26]);
        }
        3 | 5 => target[22..36].copy_from_slice(&source[20..34]),
        _ => target[22..30].copy_from_slice(&source[20..28]),
    }
}

/// Bytes of a record that a descriptor stands for.
fn described_bytes(descriptor: &[u8]) -> usize {
    let (data_type, options) = (usize::from(descriptor[2]), usize::from(descriptor[3]));
    match data_type {
        0 => options,
        // 11 to 30 are pairs and triples of 1 to 10, as LAS 1.4 had them at first.
        1..=30 => [1, 1, 2, 2, 4, 4, 8, 8, 4, 8][(data_type - 1) % 10] * (1 + (data_type - 1) / 10),
        _ => 0,
    }
}

fn descriptor(name: &str, data_type: u8, options: u8) -> [u8; DESCRIPTOR_BYTES] {
    let mut bytes = [0; DESCRIPTOR_BYTES];
    bytes[2] = data_type;
    bytes[3] = options;
    bytes[4..4 + name.len()].copy_from_slice(name.as_bytes());
    bytes
}
