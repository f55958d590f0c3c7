//! Files that lie, or are damaged: one clear line each, and never a panic.

use std::path::Path;

use super::made::{MadeFile, Random, street};
use super::round_trip::assert_same_points;
use super::{Workplace, fault};
use crate::ingest::IngestError;

fn sound(format: u8) -> MadeFile {
    let random = &mut Random(u64::from(format));
    let raw = street(random, 20_000);
    MadeFile::new(format, 0).with_points(random, raw)
}

/// What an ingest says of these bytes.
fn fault_of(bytes: &[u8]) -> String {
    let workplace = Workplace::new();
    let path = workplace.write("survey.laz", bytes);
    let said = fault(workplace.ingest(&[&path]));
    let left = std::fs::read_dir(&workplace.job.work).map_or(0, Iterator::count);
    assert_eq!(left, 0, "files are left behind after {said:?}");
    let place = path.display().to_string();
    assert!(said.starts_with(&place), "{said:?} does not begin with the file");
    assert!(!said.contains('\n'), "{said:?} is more than one line");
    said[place.len()..].to_owned()
}

fn assert_says(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
}

fn with(mut bytes: Vec<u8>, at: usize, value: &[u8]) -> Vec<u8> {
    bytes[at..at + value.len()].copy_from_slice(value);
    bytes
}

#[test]
fn a_file_cut_short_anywhere_is_refused() {
    for format in [3, 7] {
        let whole = sound(format).laz(5_000);
        for keep in [0, 3, 100, 226, 300, 500, 2_000, whole.len() / 2, whole.len() - 1] {
            let said = fault_of(&whole[..keep]);
            assert_says(&said, &["; "]);
        }
        assert_says(&fault_of(&whole[..whole.len() / 2]), &["chunk table", "cut short", "copy"]);
    }
    let las = sound(3).las();
    assert_says(&fault_of(&las[..las.len() - 1]), &["point count", "20000", "19999", "copy"]);
}

#[test]
fn a_point_count_of_2_to_the_60_is_refused_before_memory_is_taken() {
    let count = (1u64 << 60).to_le_bytes();
    for bytes in [sound(6).las(), sound(6).laz(5_000)] {
        let said = fault_of(&with(bytes, 247, &count));
        assert_says(&said, &["header, point count", "1152921504606846976", "20000"]);
    }
    let legacy = with(sound(1).las(), 107, &u32::MAX.to_le_bytes());
    assert_says(&fault_of(&legacy), &["header, point count", "4294967295"]);
}

#[test]
fn offsets_beyond_the_file_are_refused() {
    let las = sound(6).las();
    let far = (1u64 << 50).to_le_bytes();
    assert_says(&fault_of(&with(las.clone(), 96, &u32::MAX.to_le_bytes())), &["offset to point"]);
    assert_says(&fault_of(&with(las.clone(), 100, &u32::MAX.to_le_bytes())), &["variable length"]);
    let evlrs = with(las.clone(), 243, &1u32.to_le_bytes());
    assert_says(&fault_of(&with(evlrs.clone(), 235, &far)), &["extended variable length"]);
    let many = with(las, 243, &u32::MAX.to_le_bytes());
    let start = (many.len() as u64 - 100).to_le_bytes();
    assert_says(&fault_of(&with(many, 235, &start)), &["number of extended", "4294967295"]);

    let mut made = sound(6);
    made.evlrs = vec![crate::layers::copc::Vlr::new("me", 1, "", vec![0; 100])];
    let bytes = made.las();
    let length_at = bytes.len() - 160 + 20;
    assert_says(&fault_of(&with(bytes, length_at, &far)), &["extended variable length record 0"]);

    let laz = sound(6).laz(5_000);
    let table = 375 + 54 + 40; // the offset of the chunk table stands before the points
    let table = table.max(u32::from_le_bytes(laz[96..100].try_into().unwrap()) as usize);
    assert_says(&fault_of(&with(laz, table, &far)), &["chunk table"]);
}

#[test]
fn a_chunk_table_of_four_billion_chunks_takes_no_memory() {
    let laz = sound(7).laz(5_000);
    let points = u32::from_le_bytes(laz[96..100].try_into().unwrap()) as usize;
    let table = u64::from_le_bytes(laz[points..points + 8].try_into().unwrap()) as usize;
    let said = fault_of(&with(laz, table + 4, &u32::MAX.to_le_bytes()));
    assert_says(&said, &["chunk table", "4294967295 chunks"]);
}

#[test]
fn layers_of_four_gigabytes_take_no_memory() {
    let laz = sound(7).laz(20_000);
    let points = u32::from_le_bytes(laz[96..100].try_into().unwrap()) as usize;
    let first_layer = points + 8 + 36 + 4;
    let said = fault_of(&with(laz, first_layer, &[0xff; 4]));
    assert_says(&said, &["point 0", "layers"]);
}

#[test]
fn scales_and_offsets_that_are_no_numbers_are_refused() {
    for (bad, word) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (0.0, "0"), (-0.01, "-0.01")] {
        let said = fault_of(&with(sound(1).las(), 139, &bad.to_le_bytes()));
        assert_says(&said, &["scale factors", &format!("y is {word}"), "correct"]);
    }
    for bad in [f64::NAN, f64::NEG_INFINITY, 1e300] {
        assert_says(
            &fault_of(&with(sound(1).las(), 155, &bad.to_le_bytes())),
            &["header, offsets", "x is"],
        );
    }
}

#[test]
fn coordinates_where_no_survey_is_name_the_point() {
    let mut made = sound(6);
    made.scale = [0.1; 3];
    made.records[12_345][4..8].copy_from_slice(&i32::MAX.to_le_bytes());
    made.offset = [0.0; 3];
    assert_says(&fault_of(&made.laz(5_000)), &["point 12345", "214748364.7"]);
}

#[test]
fn other_files_are_refused_by_name() {
    assert_says(&fault_of(b"PK\x03\x04 not a point in it"), &["signature", "LASF", "PK"]);
    assert_says(&fault_of(&with(sound(1).las(), 25, &[5])), &["version", "1.5"]);
    assert_says(&fault_of(&with(sound(1).las(), 104, &[11])), &["point format", "11"]);
    assert_says(&fault_of(&with(sound(1).las(), 105, &[5, 0])), &["record length", "5 bytes"]);
    let workplace = Workplace::new();
    let absent = workplace.ingest(&[Path::new("nowhere.laz")]);
    assert!(matches!(absent, Err(IngestError::Io { .. })), "{absent:?}");
}

#[test]
fn damaged_bytes_never_panic() {
    // Flips bytes all over compressed files. Damage may go unnoticed, as LAZ has no
    // checksums, but then every promised point is there.
    for format in [1, 3, 4, 6, 7, 8] {
        let whole = sound(format).laz(5_000);
        let random = &mut Random(99);
        for _ in 0..40 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len() as u64) as usize;
                bytes[at] = random.next() as u8;
            }
            let workplace = Workplace::new();
            let path = workplace.write("survey.laz", &bytes);
            match workplace.ingest(&[&path]) {
                Ok(staged) => {
                    for staged in staged {
                        las::Reader::from_path(&staged.file).unwrap().read_all().unwrap();
                    }
                }
                Err(IngestError::BadInput(_)) => {}
                Err(other) => panic!("{other}"),
            }
        }
    }
}

#[test]
fn bounds_that_lie_are_replaced_by_the_points_own() {
    let made = sound(1);
    let lies: [f64; 6] = [1.0, 0.0, f64::NAN, f64::INFINITY, -1e300, 1e300];
    let bytes = with(made.laz(5_000), 179, &lies.map(f64::to_le_bytes).concat());
    for memory in [1 << 30, 1 << 18] {
        let mut workplace = Workplace::new();
        workplace.job.memory = memory;
        let path = workplace.write("survey.laz", &bytes);
        let sound = workplace.write("sound.laz", &made.laz(5_000));
        let staged = workplace.ingest(&[&path]).unwrap();
        assert_same_points(&[sound], &staged[0], true);
        assert_eq!(workplace.warning_kinds(), ["header-bounds"]);
        assert!(staged[0].source.bounds.max.x < 650_081.0);
    }
}

#[test]
fn a_file_without_points_is_left_out() {
    let workplace = Workplace::new();
    let empty = [MadeFile::new(1, 0).las(), MadeFile::new(7, 0).laz(5_000)];
    let paths = [("a", &empty[0]), ("b", &empty[1])].map(|(name, b)| workplace.write(name, b));
    let staged = workplace.ingest(&paths.each_ref().map(|path| path.as_path())).unwrap();
    assert!(staged.is_empty());
    assert_eq!(workplace.job.warnings().counts()["empty-file"], 2);
}

#[test]
fn damaged_files_are_left_out_whole_where_the_job_says_so() {
    let whole = sound(7).laz(5_000);
    // Damage that shows at once, and damage that shows when points were already read: a
    // chunk that contradicts the chunk table.
    let cut = whole[..whole.len() / 2].to_vec();
    let points = u32::from_le_bytes(whole[96..100].try_into().unwrap()) as usize;
    let late = with(whole.clone(), points + 8 + 36, &[0xff; 4]);
    for memory in [1 << 30, 1 << 18] {
        let mut workplace = Workplace::new();
        workplace.job.memory = memory;
        workplace.job.skip_damaged = true;
        let files = [("a", &cut), ("b", &whole), ("c", &late)]
            .map(|(name, bytes)| workplace.write(name, bytes));
        let staged = workplace.ingest(&files.each_ref().map(|path| path.as_path())).unwrap();
        assert_eq!(staged.len(), 1);
        assert_same_points(&files[1..2], &staged[0], false);
        assert_eq!(workplace.job.warnings().counts()["damaged-file"], 2);
        let nothing = workplace.ingest(&[&files[2]]).unwrap();
        assert!(nothing.is_empty(), "{nothing:?}");
    }
}

#[test]
fn a_cancelled_job_leaves_nothing() {
    for memory in [1 << 30, 1 << 18] {
        let mut workplace = Workplace::new();
        workplace.job.memory = memory;
        let path = workplace.write("survey.laz", &sound(1).laz(5_000));
        workplace.job.cancel();
        assert!(matches!(workplace.ingest(&[&path]), Err(IngestError::Cancelled)));
        assert_eq!(std::fs::read_dir(&workplace.job.work).map_or(0, Iterator::count), 0);
    }
}
