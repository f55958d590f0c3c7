//! Which files can share a COPC without touching a coordinate.

use std::collections::HashSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use flaneur_scene::{GpsTimeKind, OctreeCube};
use glam::DVec3;
use laz::LazVlr;

use super::convert::Conversion;
use super::file::PointFile;
use crate::layers::copc::{CopcHeader, Evlr, Vlr, is_checksums};

/// Files whose records go into one COPC: same scale, offset, point format after conversion,
/// extra bytes, kind of GPS time and CRS.
pub(super) struct Group {
    /// Name of the point source.
    pub(super) name: String,
    pub(super) files: Vec<PointFile>,
    pub(super) layout: Layout,
}

/// What the files of a group share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) point_format: u8,
    pub(super) extra_bytes: u16,
    pub(super) extra_bytes_vlr: Vec<u8>,
    pub(super) scale: DVec3,
    pub(super) offset: DVec3,
    pub(super) gps_time: GpsTimeKind,
    crs: Vec<(u16, Vec<u8>)>,
}

/// LAS global encoding bits.
const ADJUSTED_GPS_TIME: u16 = 1;
const SYNTHETIC_RETURNS: u16 = 1 << 3;
const WKT: u16 = 1 << 4;

const PROJECTION: &str = "LASF_Projection";

impl Layout {
    /// The layout of a file's points, `None` where its records would exceed 64 KiB.
    pub(super) fn of(file: &PointFile) -> Option<Self> {
        let conversion = Conversion::of(&file.header);
        let is_crs = |vlr: &&Vlr| vlr.user_id == Vlr::new(PROJECTION, 0, "", Vec::new()).user_id;
        let mut crs: Vec<_> =
            file.vlrs.iter().filter(is_crs).map(|vlr| (vlr.record_id, vlr.data.clone())).collect();
        crs.sort();
        Some(Self {
            point_format: conversion.target_format(),
            extra_bytes: conversion.target_extra()?,
            extra_bytes_vlr: conversion.extra_bytes_vlr(&file.vlrs),
            scale: file.header.scale,
            offset: file.header.offset,
            gps_time: match file.header.global_encoding & ADJUSTED_GPS_TIME {
                0 => GpsTimeKind::Week,
                _ => GpsTimeKind::Adjusted,
            },
            crs,
        })
    }

    /// Bytes of a record.
    pub(super) fn record_length(&self) -> usize {
        usize::from(crate::layers::copc::base_record_length(self.point_format) + self.extra_bytes)
    }
}

/// Sorts files into groups, in order of their first file. The first is called `name`, the
/// next `name-2` and so on, leaving out names in `taken`, to which all are added.
pub(super) fn group_files(
    name: &str,
    files: Vec<(PointFile, Layout)>,
    taken: &mut HashSet<String>,
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (file, layout) in files {
        match groups.iter_mut().find(|group| group.layout == layout) {
            Some(group) => group.files.push(file),
            None => {
                let name = free_name(name, taken);
                groups.push(Group { name, files: vec![file], layout });
            }
        }
    }
    groups
}

fn free_name(name: &str, taken: &mut HashSet<String>) -> String {
    let mut candidate = name.to_owned();
    let mut number = 1;
    while !taken.insert(candidate.clone()) {
        number += 1;
        candidate = format!("{name}-{number}");
    }
    candidate
}

impl Group {
    /// Points of all files.
    pub(super) fn point_count(&self) -> u64 {
        self.files.iter().map(|file| file.header.point_count).sum()
    }

    /// Records behind the points that are kept, those of equal content once.
    fn distinct_evlrs(&self) -> Vec<Evlr> {
        let mut seen = HashSet::new();
        let all = self.files.iter().flat_map(|file| &file.evlrs);
        all.filter(|evlr| is_kept_evlr(evlr))
            .filter(|evlr| seen.insert((evlr.user_id, evlr.record_id, content_hash(evlr))))
            .cloned()
            .collect()
    }

    /// The header of the group's COPC. The first file's identity stands for all.
    pub(super) fn copc_header(&self, cube: OctreeCube) -> CopcHeader {
        let layout = &self.layout;
        let mut vlrs = Vec::new();
        if !layout.extra_bytes_vlr.is_empty() {
            let descriptors = layout.extra_bytes_vlr.clone();
            vlrs.push(Vlr::new("LASF_Spec", 4, "Extra Bytes Record", descriptors));
        }
        let mut seen = HashSet::new();
        for vlr in self.files.iter().flat_map(|file| &file.vlrs).filter(|vlr| is_kept(vlr)) {
            if seen.insert(vlr) {
                vlrs.push(vlr.clone());
            }
        }
        let evlrs = self.distinct_evlrs();
        let synthetic =
            self.files.iter().any(|file| file.header.global_encoding & SYNTHETIC_RETURNS != 0);
        // Formats 6 to 8 name their CRS in WKT. Where a survey has GeoTIFF keys instead, they
        // stay, and the bit that would hide them from readers is left unset.
        let has_wkt = vlrs.iter().any(|vlr| vlr.is(PROJECTION, 2112))
            || evlrs.iter().any(|evlr| evlr.is(PROJECTION, 2112));
        let has_keys = vlrs.iter().any(|vlr| vlr.is(PROJECTION, 34735));
        let first = &self.files[0].header;
        CopcHeader {
            file_source_id: first.file_source_id,
            global_encoding: if layout.gps_time == GpsTimeKind::Adjusted {
                ADJUSTED_GPS_TIME
            } else {
                0
            } | if synthetic { SYNTHETIC_RETURNS } else { 0 }
                | if has_wkt || !has_keys { WKT } else { 0 },
            guid: first.guid,
            system_identifier: first.system_identifier,
            creation: first.creation,
            point_format: layout.point_format,
            extra_bytes: layout.extra_bytes,
            scale: layout.scale,
            offset: layout.offset,
            cube,
            vlrs,
            evlrs,
        }
    }
}

/// A hash of a record's content; one of its place where it cannot be read, so that copying it
/// later reports why.
fn content_hash(evlr: &Evlr) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let read = File::open(&evlr.file).and_then(|mut file| {
        file.seek(SeekFrom::Start(evlr.offset))?;
        hasher.update_reader(file.take(evlr.length)).map(|_| ())
    });
    if read.is_err() {
        hasher.update(evlr.file.as_os_str().as_encoded_bytes());
        hasher.update(&evlr.offset.to_le_bytes());
    }
    hasher.finalize()
}

/// Records that describe how the input stores its points, and so do not hold for the COPC:
/// LASzip's, COPC's, the extra bytes' (made anew), and LAStools' index by point number.
fn is_kept(vlr: &Vlr) -> bool {
    !(vlr.is(LazVlr::USER_ID, LazVlr::RECORD_ID)
        || vlr.is("copc", 1)
        || vlr.is("copc", 1000)
        || vlr.is("LASF_Spec", 4)
        || vlr.is("LAStools", 30))
}

/// Besides those of [`is_kept`]: the chunks' checksums, and the waveforms themselves, which are
/// not stored.
fn is_kept_evlr(evlr: &Evlr) -> bool {
    !(is_checksums(evlr)
        || evlr.is("copc", 1000)
        || evlr.is("copc", 1)
        || evlr.is("LASF_Spec", WAVEFORM_RECORD)
        || evlr.is("LAStools", 30))
}

/// The record with the waveforms.
pub(super) const WAVEFORM_RECORD: u16 = 65_535;
