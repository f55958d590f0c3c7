use super::*;
use crate::decode::surveyed::nearest_point;
use flaneur_scene::{
    Bounds3, GpsTimeKind, NodeKey, OctreeCube, PointStations, Station, StationCorrection,
};
use glam::DVec3;
use laz::LazVlrBuilder;
use laz::record::{LayeredPointRecordCompressor, RecordCompressor};
use proptest::prelude::*;

const CENTRE: DVec3 = DVec3::new(651_234.5, 6_861_234.5, 40.0);
const ID: PointNodeId = PointNodeId { source: 3, key: NodeKey { level: 1, x: 0, y: 1, z: 0 } };

/// A source of point format 7 with two extra bytes.
fn source() -> PointSource {
    let vlr = LazVlrBuilder::default()
        .with_point_format(7, 2)
        .expect("format 7")
        .with_variable_chunk_size()
        .build();
    let mut laszip_vlr = Vec::new();
    vlr.write_to(&mut laszip_vlr).expect("memory");
    PointSource {
        name: "drive".into(),
        point_count: 3,
        bounds: Bounds3 { min: CENTRE - 50.0, max: CENTRE + 50.0 },
        cube: OctreeCube { centre: CENTRE, half_size_m: 50.0, spacing_m: 0.5 },
        point_format: 7,
        record_length: 38,
        scale: DVec3::splat(0.001),
        offset: DVec3::new(651_000.0, 6_861_000.0, 0.0),
        laszip_vlr,
        extra_bytes_vlr: Vec::new(),
        gps_time: GpsTimeKind::Week,
    }
}

/// A record: stored coordinates, intensity, class, flags, colour.
fn record(xyz: [i32; 3], intensity: u16, class: u8, flags: u8, colour: [u16; 3]) -> Vec<u8> {
    let mut record: Vec<u8> = xyz.iter().flat_map(|v| v.to_le_bytes()).collect();
    record.extend(intensity.to_le_bytes());
    record.extend([0x11, flags, class, 0]);
    record.extend([0; 2]); // scan angle
    record.extend([7, 0]); // point source
    record.extend(1.5f64.to_le_bytes());
    record.extend(colour.iter().flat_map(|v| v.to_le_bytes()));
    record.extend([1, 2]); // extra bytes
    assert_eq!(record.len(), 38);
    record
}

fn compress(source: &PointSource, records: &[Vec<u8>]) -> Vec<u8> {
    let vlr = laz::LazVlr::from_buffer(&source.laszip_vlr).expect("written above");
    let mut compressor = LayeredPointRecordCompressor::new(std::io::Cursor::new(Vec::new()));
    compressor.set_fields_from(vlr.items()).expect("layered items");
    for record in records {
        compressor.compress_next(record).expect("memory");
    }
    compressor.done().expect("memory");
    compressor.into_inner().into_inner()
}

fn node(points: u32, chunk: &[u8]) -> Node {
    let byte_size = u32::try_from(chunk.len()).expect("small");
    Node { key: ID.key, point_count: points, byte_size, crc32: crc32fast::hash(chunk) }
}

fn three() -> Vec<Vec<u8>> {
    vec![
        record([190_000, 260_000, 5_000], 10, 2, 0, [0x1200, 0x3400, 0xff00]),
        record([190_001, 260_500, 5_001], 20, 6, WITHHELD, [0; 3]),
        record([200_000, 250_000, 39_999], 30, 6, 0, [0xffff, 0, 0x8000]),
    ]
}

/// Positions to within f32's rounding of a 50 m cell, 2⁻²⁴ · 75 m < 5 µm; the rest exactly;
/// the withheld point gone.
#[test]
fn points_come_back() {
    let source = source();
    let chunk = compress(&source, &three());
    let points = decode_points(&source, ID, &node(3, &chunk), &chunk, &Track::through(&[]), true)
        .expect("sound");
    assert_eq!(points.id, ID);
    assert_eq!(points.classes, [2, 6]);
    assert_eq!(points.intensities, [10, 30]);
    assert_eq!(points.normals, [[0.0; 3]; 2], "two points are no surface");
    assert_eq!(points.colours, [[18, 52, 254], [255, 0, 128]]);
    assert!((f64::from(points.spacing_m) - 0.25).abs() < 1e-9);
    let want =
        [DVec3::new(651_190.0, 6_861_260.0, 5.0), DVec3::new(651_200.0, 6_861_250.0, 39.999)];
    for (got, want) in points.positions.iter().zip(want) {
        let got = points.origin + glam::Vec3::from_array(*got).as_dvec3();
        assert!(got.distance(want) < 1e-5, "{got} {want}");
    }
}

/// Each point comes with the place that is nearest in time: the records are of 1.5 s.
#[test]
fn points_know_where_they_were_taken() {
    let source = source();
    let chunk = compress(&source, &three());
    let places = [0.0, 1.6, 3.0].map(|time_s| Station {
        time_s,
        position: CENTRE + 9.0 * time_s,
        correction: StationCorrection::default(),
    });
    let points =
        decode_points(&source, ID, &node(3, &chunk), &chunk, &Track::through(&places), true)
            .expect("sound");
    for point in 0..2 {
        let off_m = points.stations.of_point(point).expect("known").distance(CENTRE + 9.0 * 1.5);
        assert!(off_m < 1.0, "{off_m}");
    }
    let without = decode_points(&source, ID, &node(3, &chunk), &chunk, &Track::through(&[]), true);
    let points = PointChunk { stations: PointStations::default(), ..points };
    assert_eq!(without.expect("sound"), points, "and nothing else changes");
}

/// Points are shown where their station's correction has them; who asks gets them as surveyed.
#[test]
fn corrected_points_are_shown_elsewhere_and_found_as_surveyed() {
    let source = source();
    let chunk = compress(&source, &three());
    let shift = DVec3::new(0.3, -0.2, 0.1);
    let stations = [0.0, 3.0].map(|time_s| Station {
        time_s,
        position: CENTRE,
        correction: StationCorrection { shift_m: shift, ..StationCorrection::default() },
    });
    let decode = |stations: &[Station]| {
        let track = Track::through(stations);
        decode_points(&source, ID, &node(3, &chunk), &chunk, &track, false).expect("sound")
    };
    let (surveyed, shown) = (decode(&[]), decode(&stations));
    let place = |chunk: &PointChunk, point: usize| {
        chunk.origin + glam::Vec3::from_array(chunk.positions[point]).as_dvec3()
    };
    assert_eq!(shown.positions.len(), 2);
    for point in 0..2 {
        let here = place(&shown, point);
        let track = Track::through(&stations);
        let found = nearest_point(&source, &node(3, &chunk), &chunk, &track, here);
        let (distance_m, found) = found.expect("sound").expect("a point");
        assert!(distance_m < 1e-5, "{distance_m}");
        assert!((here - found.position - shift).length() < 1e-5);
        assert!((0..2).any(|other| place(&surveyed, other).distance(found.position) < 1e-5));
    }
}

#[test]
fn contradictions_are_damage() {
    let source = source();
    let chunk = compress(&source, &three());
    let problem = |source: &PointSource, points: u32, chunk: &[u8]| match decode_points(
        source,
        ID,
        &node(points, chunk),
        chunk,
        &Track::through(&[]),
        false,
    )
    .expect_err("damaged")
    {
        StreamError::Damaged { what, problem } => {
            assert!(what.contains("drive"), "{what}");
            problem
        }
        other => panic!("{other}"),
    };
    assert!(problem(&source, 4, &chunk).contains("holds 3 points, the hierarchy says 4"));
    assert!(problem(&source, 3, &chunk[..20]).contains("too few"));
    let cut = &chunk[..chunk.len() - 1];
    assert!(problem(&source, 3, cut).contains("are there"));
    // Layers that claim 4 GiB are refused before memory is taken for them.
    let mut huge = chunk.clone();
    huge[42..46].fill(0xff);
    assert!(problem(&source, 3, &huge).contains("layers claim"));
    let shorter = PointSource { record_length: 36, ..source.clone() };
    assert!(problem(&shorter, 3, &chunk).contains("38"));
    let tiny = PointSource { record_length: 20, ..source.clone() };
    assert!(problem(&tiny, 3, &chunk).contains("20"));
    let far = compress(&source, &[record([i32::MAX, 0, 0], 0, 0, 0, [0; 3])]);
    assert!(problem(&source, 1, &far).contains("from the middle of its node"));
    let nonsense = PointSource { laszip_vlr: vec![3, 0, 1], ..source };
    assert!(problem(&nonsense, 3, &chunk).contains("LASzip"));
}

proptest! {
    /// Whatever one byte of a chunk becomes, decoding ends: with points or with an error. A
    /// panic of the decompressor counts as an error, as it does where chunks are decoded.
    #[test]
    fn a_flipped_byte_is_survived(at in 0usize..200, to: u8) {
        let source = source();
        let mut chunk = compress(&source, &three());
        let index = at % chunk.len();
        chunk[index] = to;
        let node = node(3, &chunk);
        let outcome = std::panic::catch_unwind(|| decode_points(&source, ID, &node, &chunk, &Track::through(&[]), true));
        if let Ok(Ok(points)) = outcome {
            prop_assert!(points.positions.len() <= 3);
            prop_assert!(points.positions.iter().flatten().all(|v| v.is_finite()));
        }
    }
}
