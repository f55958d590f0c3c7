//! Several files: which share a COPC, and what of their headers is kept.

use std::path::Path;

use flaneur_scene::GpsTimeKind;

use super::Workplace;
use super::made::{MadeFile, Random, street};
use super::round_trip::assert_same_points;
use crate::layers::copc::Vlr;

#[test]
fn files_that_differ_in_scale_or_kind_become_sources_of_their_own() {
    let random = &mut Random(11);
    let mut make = |format, extra| {
        let raw = street(random, 3_000);
        MadeFile::new(format, extra).with_points(random, raw)
    };
    let (a, b, mut c, mut d, e) = (make(0, 0), make(1, 0), make(1, 0), make(3, 0), make(1, 4));
    c.scale = [0.01; 3];
    d.global_encoding |= 1;
    let workplace = Workplace::new();
    let files = [("a", &a), ("b", &b), ("c", &c), ("d", &d), ("e", &e)]
        .map(|(name, made)| workplace.write(name, &made.laz(1_000)));
    let staged = workplace.ingest(&files.each_ref().map(|path| path.as_path())).unwrap();
    let names: Vec<_> = staged.iter().map(|staged| staged.source.name.as_str()).collect();
    assert_eq!(names, ["survey", "survey-2", "survey-3", "survey-4"]);
    assert_same_points(&files[..2], &staged[0], true);
    for i in 1..4 {
        assert_same_points(&files[i + 1..=i + 1], &staged[i], true);
    }
    assert_eq!(staged[1].source.scale.to_array(), [0.01; 3]);
    assert_eq!(staged[3].source.record_length, 34);
    let kinds = [0, 2].map(|i| staged[i].source.gps_time);
    assert_eq!(kinds, [GpsTimeKind::Week, GpsTimeKind::Adjusted]);
}

#[test]
fn records_before_and_behind_the_points_are_kept_once() {
    let random = &mut Random(12);
    let note = |text: &str| Vlr::new("surveyor", 7, "a note", text.as_bytes().to_vec());
    let wkt = Vlr::new("LASF_Projection", 2112, "", b"PROJCS[\"here\"]\0".to_vec());
    let descriptors = Vlr::new("LASF_Spec", 4, "", {
        let mut descriptor = vec![0; 192];
        descriptor[2] = 3;
        descriptor[4..10].copy_from_slice(b"height");
        descriptor
    });
    let files = ["first", "second"].map(|own| {
        let raw = street(random, 1_000);
        let mut made = MadeFile::new(8, 2).with_points(random, raw);
        made.vlrs = vec![wkt.clone(), note("both"), descriptors.clone(), note(own)];
        made.evlrs = vec![note("behind"), note(own)];
        made
    });
    let workplace = Workplace::new();
    let paths = [("a", &files[0]), ("b", &files[1])]
        .map(|(name, made)| workplace.write(name, &made.laz(500)));
    let staged = workplace.ingest(&paths.each_ref().map(|path| path.as_path())).unwrap();
    assert_eq!(staged.len(), 1);
    assert_same_points(&paths, &staged[0], false);
    assert_eq!(staged[0].source.extra_bytes_vlr, descriptors.data);

    // An ingest of the result reads all records of either kind.
    let reread = crate::ingest::points::file::PointFile::open(&staged[0].file).unwrap();
    let texts = |data: &[u8]| String::from_utf8_lossy(data).into_owned();
    let before: Vec<_> =
        reread.vlrs.iter().filter(|vlr| vlr.is("surveyor", 7)).map(|v| texts(&v.data)).collect();
    assert_eq!(before, ["both", "first", "second"]);
    assert!(reread.vlrs.contains(&wkt));
    assert!(reread.vlrs[0].is("copc", 1) && reread.evlrs[0].is("copc", 1000));
    let bytes = std::fs::read(&staged[0].file).unwrap();
    assert!(crate::layers::copc::is_checksums(&reread.evlrs[1]));
    let behind: Vec<_> = reread.evlrs[2..]
        .iter()
        .map(|evlr| texts(&bytes[evlr.offset as usize..][..evlr.length as usize]))
        .collect();
    assert_eq!(behind, ["behind", "first", "second"]);
    assert_eq!(reread.header.global_encoding & 16, 16, "the CRS is in WKT");
}

#[test]
fn a_copc_is_an_input_like_any_other() {
    let random = &mut Random(13);
    let raw = street(random, 100_000);
    let made = MadeFile::new(7, 0).with_points(random, raw);
    let workplace = Workplace::new();
    let path = workplace.write("survey.las", &made.las());
    let first = workplace.ingest(&[&path]).unwrap();
    let again = Workplace::new();
    let second = again.ingest(&[&first[0].file]).unwrap();
    assert_same_points(&[path], &second[0], false);
    assert_eq!(first[0].source, second[0].source);
    // Its checksums are made anew.
    let reread = crate::ingest::points::file::PointFile::open(&second[0].file).unwrap();
    assert_eq!(reread.evlrs.len(), 2);
}

#[test]
fn the_copc_begins_as_its_specification_says() {
    let random = &mut Random(14);
    let raw = street(random, 10_000);
    let made = MadeFile::new(6, 0).with_points(random, raw);
    let workplace = Workplace::new();
    let path: &Path = &workplace.write("survey.las", &made.las());
    let staged = workplace.ingest(&[path, path]).unwrap();
    assert_eq!(staged[0].source.point_count, 10_000, "a file named twice counts once");
    let bytes = std::fs::read(&staged[0].file).unwrap();
    assert_eq!(&bytes[..4], b"LASF");
    assert_eq!(bytes[24..26], [1, 4]);
    assert_eq!(bytes[104], 6 | 0x80);
    assert_eq!(&bytes[377..381], b"copc");
    assert_eq!(u16::from_le_bytes([bytes[393], bytes[394]]), 1);
    let f64_at = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let times = |record: &Vec<u8>| f64::from_le_bytes(record[22..30].try_into().unwrap());
    let least = made.records.iter().map(times).fold(f64::INFINITY, f64::min);
    assert_eq!(f64_at(429 + 56), least, "least GPS time");
    assert!(bytes[429 + 72..429 + 160].iter().all(|byte| *byte == 0), "reserved");
    let by_return: u64 =
        (0..15).map(|i| u64::from_le_bytes(bytes[255 + 8 * i..][..8].try_into().unwrap())).sum();
    let returns = made.records.iter().filter(|record| record[14] & 15 > 0).count();
    assert_eq!(by_return, returns as u64);
}
