//! LAS and LAZ files made byte by byte, so that every attribute and every lie is possible.

use std::io::Cursor;

use laz::laszip::LazItemRecordBuilder;
use laz::{LasZipCompressor, LazVlr, LazVlrBuilder};

use crate::ingest::points::las_header::RECORD_LENGTHS;
use crate::layers::copc::Vlr;

/// Numbers that look random and are the same every time (SplitMix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
}

/// A file to be.
#[derive(Clone)]
pub(super) struct MadeFile {
    pub(super) minor: u8,
    pub(super) format: u8,
    pub(super) extra: u16,
    pub(super) scale: [f64; 3],
    pub(super) offset: [f64; 3],
    pub(super) global_encoding: u16,
    pub(super) vlrs: Vec<Vlr>,
    pub(super) evlrs: Vec<Vlr>,
    pub(super) records: Vec<Vec<u8>>,
}

impl MadeFile {
    pub(super) fn new(format: u8, extra: u16) -> Self {
        Self {
            minor: if format >= 6 { 4 } else { 3 },
            format,
            extra,
            scale: [0.001, 0.001, 0.01],
            offset: [650_000.0, 6_860_000.0, 0.0],
            global_encoding: if format >= 6 { 16 } else { 0 },
            vlrs: Vec::new(),
            evlrs: Vec::new(),
            records: Vec::new(),
        }
    }

    /// Adds points at these raw coordinates, all other attributes random.
    pub(super) fn with_points(
        mut self,
        random: &mut Random,
        raw: impl IntoIterator<Item = [i32; 3]>,
    ) -> Self {
        let length = usize::from(RECORD_LENGTHS[usize::from(self.format)] + self.extra);
        for raw in raw {
            let mut record: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
            for (axis, value) in raw.iter().enumerate() {
                record[4 * axis..][..4].copy_from_slice(&value.to_le_bytes());
            }
            // A GPS time that is a number: the reader used for comparison compares numbers.
            // Adjusted times are negative before September 2011.
            let time = (random.next() >> 11) as f64 * 1e-6 - 1e9;
            match self.format {
                1 | 3..=5 => record[20..28].copy_from_slice(&time.to_le_bytes()),
                6.. => record[22..30].copy_from_slice(&time.to_le_bytes()),
                _ => {}
            }
            // Class 28 is mistaken for "overlap" by that reader, which looks at four bits.
            if self.format < 6 && record[15] & 31 == 28 {
                record[15] ^= 1;
            }
            // The compressor subtracts packet offsets and sizes, and debug builds refuse to
            // let these overflow: waveforms lie one behind the other, as a scanner writes them.
            let wave = match self.format {
                4 => Some(28),
                5 => Some(34),
                9 => Some(30),
                10 => Some(38),
                _ => None,
            };
            if let Some(at) = wave {
                let offset = 60 + 256 * self.records.len() as u64;
                record[at + 1..at + 9].copy_from_slice(&offset.to_le_bytes());
                record[at + 9..at + 13]
                    .copy_from_slice(&(200 + random.below(57) as u32).to_le_bytes());
            }
            self.records.push(record);
        }
        self
    }

    /// The file, compressed where `laz` says so.
    pub(super) fn bytes(&self, laz: Option<LazVlr>) -> Vec<u8> {
        let header_length: u16 = [227, 227, 227, 235, 375][usize::from(self.minor)];
        let mut vlrs = self.vlrs.clone();
        if let Some(laz) = &laz {
            let mut data = Vec::new();
            laz.write_to(&mut data).unwrap();
            vlrs.push(Vlr::new(LazVlr::USER_ID, LazVlr::RECORD_ID, "", data));
        }
        let vlr_bytes: Vec<u8> = vlrs.iter().flat_map(Vlr::to_bytes).collect();
        let points_offset = usize::from(header_length) + vlr_bytes.len();
        let length = RECORD_LENGTHS[usize::from(self.format)] + self.extra;
        let count = self.records.len();
        let raw = |record: &Vec<u8>, axis: usize| {
            i32::from_le_bytes(record[4 * axis..][..4].try_into().unwrap())
        };

        let mut bytes = b"LASF".to_vec();
        bytes.extend(7u16.to_le_bytes());
        bytes.extend(self.global_encoding.to_le_bytes());
        bytes.extend(*b"0123456789abcdef");
        bytes.extend([1, self.minor]);
        bytes.extend([b's'; 64]);
        bytes.extend([30, 0]);
        bytes.extend(2019u16.to_le_bytes());
        bytes.extend(header_length.to_le_bytes());
        bytes.extend((points_offset as u32).to_le_bytes());
        bytes.extend((vlrs.len() as u32).to_le_bytes());
        bytes.push(self.format | if laz.is_some() { 0x80 } else { 0 });
        bytes.extend(length.to_le_bytes());
        bytes.extend(if self.format < 6 { count as u32 } else { 0 }.to_le_bytes());
        bytes.extend([0; 20]);
        for value in self.scale.into_iter().chain(self.offset) {
            bytes.extend(value.to_le_bytes());
        }
        for axis in 0..3 {
            let world = |raw: i32| f64::from(raw) * self.scale[axis] + self.offset[axis];
            let values = || self.records.iter().map(|record| raw(record, axis));
            bytes.extend(world(values().max().unwrap_or(0)).to_le_bytes());
            bytes.extend(world(values().min().unwrap_or(0)).to_le_bytes());
        }
        bytes.resize(usize::from(header_length), 0);
        if self.minor == 4 {
            bytes[247..255].copy_from_slice(&(count as u64).to_le_bytes());
        }
        bytes.extend(vlr_bytes);
        match laz {
            None => bytes.extend(self.records.iter().flatten()),
            Some(laz) => {
                let mut cursor = Cursor::new(bytes);
                cursor.set_position(points_offset as u64);
                let mut compressor = LasZipCompressor::new(cursor, laz).unwrap();
                compressor.reserve_offset_to_chunk_table().unwrap();
                for record in &self.records {
                    compressor.compress_one(record).unwrap();
                }
                compressor.done().unwrap();
                bytes = compressor.into_inner().into_inner();
            }
        }
        if self.minor == 4 && !self.evlrs.is_empty() {
            let start = bytes.len() as u64;
            bytes[235..243].copy_from_slice(&start.to_le_bytes());
            bytes[243..247].copy_from_slice(&(self.evlrs.len() as u32).to_le_bytes());
            for evlr in &self.evlrs {
                bytes.extend([0; 2]);
                bytes.extend(evlr.user_id);
                bytes.extend(evlr.record_id.to_le_bytes());
                bytes.extend((evlr.data.len() as u64).to_le_bytes());
                bytes.extend(evlr.description);
                bytes.extend(&evlr.data);
            }
        }
        bytes
    }

    pub(super) fn las(&self) -> Vec<u8> {
        self.bytes(None)
    }

    /// In chunks of `chunk` points.
    pub(super) fn laz(&self, chunk: u32) -> Vec<u8> {
        let items =
            LazItemRecordBuilder::default_for_point_format_id(self.format, self.extra).unwrap();
        self.bytes(Some(LazVlrBuilder::new(items).with_fixed_chunk_size(chunk).build()))
    }
}

/// Raw coordinates spread over a street: mostly ground and two facades.
pub(super) fn street(random: &mut Random, count: usize) -> Vec<[i32; 3]> {
    (0..count)
        .map(|_| {
            let (along, across) = (random.below(80_000) as i32, random.below(12_000) as i32);
            match random.below(3) {
                0 => [along, across, random.below(20) as i32],
                1 => [along, random.below(100) as i32, across / 10],
                _ => [along, 12_000 - random.below(100) as i32, across / 10],
            }
        })
        .collect()
}
