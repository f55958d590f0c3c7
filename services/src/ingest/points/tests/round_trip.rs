//! Nothing is lost: the points that another reader finds in the COPC are those it finds in
//! the inputs.

use std::path::{Path, PathBuf};

use las::Point;

use super::Workplace;
use super::made::{MadeFile, Random, street};
use crate::ingest::points::StagedPoints;

/// All attributes of a point, comparable. `scan_angle` in the steps of its format.
type Attributes = (
    [u64; 3],
    (u16, u8, u8, u8, bool, bool, bool, bool, bool),
    (u8, i32, u8, u16, u8),
    u64,
    Option<[u16; 3]>,
    Option<u16>,
    Vec<u8>,
);

/// `whole_degrees` where the survey had no finer scan angles.
fn attributes(point: Point, whole_degrees: bool) -> Attributes {
    let mut extra = point.extra_bytes;
    if let Some(wave) = point.waveform {
        extra.push(wave.wave_packet_descriptor_index);
        extra.extend(wave.byte_offset_to_waveform_data.to_le_bytes());
        extra.extend(wave.waveform_packet_size_in_bytes.to_le_bytes());
        for value in [wave.return_point_waveform_location, wave.x_t, wave.y_t, wave.z_t] {
            extra.extend(value.to_le_bytes());
        }
    }
    let step = if whole_degrees { 1.0 } else { 0.006 };
    (
        [point.x, point.y, point.z].map(f64::to_bits),
        (
            point.intensity,
            point.return_number,
            point.number_of_returns,
            point.scan_direction as u8,
            point.is_edge_of_flight_line,
            point.is_synthetic,
            point.is_key_point,
            point.is_withheld,
            point.is_overlap,
        ),
        (
            point.classification.into(),
            (point.scan_angle / step).round() as i32,
            point.user_data,
            point.point_source_id,
            point.scanner_channel,
        ),
        point.gps_time.unwrap_or(0.0).to_bits(),
        point.color.map(|colour| [colour.red, colour.green, colour.blue]),
        point.nir,
        extra,
    )
}

fn read(path: &Path, whole_degrees: bool) -> Vec<Attributes> {
    let mut reader = las::Reader::from_path(path).unwrap();
    let points = reader.read_all().unwrap();
    points.points().map(|point| attributes(point.unwrap(), whole_degrees)).collect()
}

fn read_copc(staged: &StagedPoints, whole_degrees: bool) -> Vec<Attributes> {
    let mut reader = las::CopcReader::from_path(&staged.file).unwrap();
    let points = reader.query(las::copc::LodSelection::All, las::copc::BoundsSelection::All);
    points.unwrap().points().map(|point| attributes(point.unwrap(), whole_degrees)).collect()
}

/// Fails unless the COPC holds the same points as the files together, also when it is read
/// as a plain LAZ.
pub(super) fn assert_same_points(files: &[PathBuf], staged: &StagedPoints, whole_degrees: bool) {
    let mut expected: Vec<_> = files.iter().flat_map(|path| read(path, whole_degrees)).collect();
    expected.sort();
    for mut found in [read_copc(staged, whole_degrees), read(&staged.file, whole_degrees)] {
        assert_eq!(found.len(), expected.len());
        found.sort();
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected);
        }
    }
    assert_eq!(staged.source.point_count, expected.len() as u64);
}

#[test]
fn every_format_keeps_every_attribute() {
    for format in 0..=10 {
        for (extra, compressed) in [(0, false), (0, true), (5, true)] {
            let workplace = Workplace::new();
            let random = &mut Random(u64::from(format) * 10 + u64::from(extra));
            let raw = street(random, 8_000);
            let made = MadeFile::new(format, extra).with_points(random, raw);
            let bytes = if compressed { made.laz(3_001) } else { made.las() };
            let path = workplace.write("survey.las", &bytes);
            let staged = workplace.ingest(&[&path]).unwrap();
            assert_eq!(staged.len(), 1, "format {format}");
            assert_same_points(&[path], &staged[0], format < 6);
            assert_eq!(workplace.warning_kinds(), [] as [&str; 0], "format {format}");
        }
    }
}

#[test]
fn surveys_keep_every_attribute() {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    for name in ["delft", "karlsruhe", "paris"] {
        let Ok(entries) = std::fs::read_dir(data.join(name)) else {
            eprintln!("skipped: no survey {name:?} in {}", data.display());
            continue;
        };
        let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        files.retain(|path| path.extension().is_some_and(|extension| extension == "laz"));
        files.sort();
        let workplace = Workplace::new();
        let paths: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        let staged = workplace.ingest(&paths).unwrap();
        assert_eq!(staged.len(), 1, "{name}: its files share one layout");
        let legacy = las::Reader::from_path(&files[0]).unwrap();
        assert_same_points(&files, &staged[0], !legacy.header().point_format().is_extended);
    }
}
