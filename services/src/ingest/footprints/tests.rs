use std::path::Path;

use las::{Builder, Point, Writer};
use rand::{RngExt, SeedableRng};

use super::*;
use crate::ingest::street::{FootprintsFormat, GroundSpec, HeightSource};
use crate::ingest::{BadInput, Warnings};

/// A survey's folder, and a job that works in it.
struct Desk {
    folder: tempfile::TempDir,
    job: Job,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let job = Job::new(folder.path(), 256 << 20);
        Self { folder, job }
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path
    }

    fn ingest(&self, spec: FootprintsSpec, crs: &Crs) -> Result<Vec<Footprint>, IngestError> {
        let staged = ingest_footprints(&self.job, &[spec], crs, None, &[])?;
        Ok(staged.map(|staged| stored(&staged)).unwrap_or_default())
    }

    fn refusal(&self, spec: FootprintsSpec, crs: &Crs) -> BadInput {
        match self.ingest(spec, crs) {
            Err(IngestError::BadInput(fault)) => *fault,
            other => panic!("not refused: {other:?}"),
        }
    }
}

/// What the staged layer holds, by identifier.
fn stored(staged: &StagedFootprints) -> Vec<Footprint> {
    let bytes = std::fs::read(&staged.file).expect("staged");
    let store: std::sync::Arc<dyn object_store::ObjectStore> =
        std::sync::Arc::new(object_store::memory::InMemory::new());
    let path = object_store::path::Path::from("footprints.fgb");
    futures::executor::block_on(async {
        let size = bytes.len() as u64;
        object_store::ObjectStoreExt::put(&store, &path, bytes.into()).await.expect("memory");
        let region = flaneur_scene::Region::All;
        let mut cursor =
            crate::layers::footprints::open(store, path, size, region).await.expect("valid");
        let mut footprints = Vec::new();
        while let Some(footprint) = cursor.next().await.expect("valid") {
            footprints.push(footprint);
        }
        assert_eq!(footprints.len() as u64, staged.count);
        footprints.sort_by(|a, b| a.id.cmp(&b.id));
        footprints
    })
}

fn spec(path: PathBuf, height: Option<HeightSource>) -> FootprintsSpec {
    FootprintsSpec { path, format: None, height, uncertainty_m: 0.5 }
}

fn constant() -> Option<HeightSource> {
    Some(HeightSource::Constant(10.0))
}

fn lambert() -> Crs {
    Crs::parse("EPSG:2154", None).expect("known")
}

fn local() -> Crs {
    Crs::parse("local", None).expect("local")
}

fn collection(features: &[&str]) -> String {
    format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
}

fn feature(coordinates: &str) -> String {
    format!(
        r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":{coordinates}}}}}"#
    )
}

#[test]
fn geojson_keeps_coordinates_holes_and_attributes() {
    let desk = Desk::new();
    let text = r#"{
      "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::2154"}},
      "type": "FeatureCollection", "bbox": [1, 2, 3, 4],
      "features": [
        {"geometry": {"coordinates": [[
            [[651143.29767511, 6861442.905745622, 41.5], [651160, 6861442.9, 40.25], [651160, 6861460, 42], [651143.29767511, 6861442.905745622, 41.5]],
            [[651150, 6861445], [651152, 6861445], [651152, 6861447]]],
            [[[651170, 6861442], [651180, 6861442], [651180, 6861452]]]], "type": "MultiPolygon"},
         "type": "Feature", "id": "bati.1",
         "properties": {"h": "18.3", "n": 7, "name": "Opéra", "nothing": null, "deep": {"a": [1, 2.5]}}},
        {"type": "Feature", "properties": {"ID": 42, "h": 6.5}, "geometry": {"type": "GeometryCollection", "geometries": [
            {"type": "Polygon", "coordinates": [[[651200, 6861442], [651210, 6861442], [651210, 6861452], [651200, 6861442]]]}]}},
        {"type": "Feature", "properties": null, "geometry": {"type": "Polygon", "coordinates":
            [[[651300, 6861442], [651310, 6861442], [651310, 6861452], [651300, 6861442]]]}}
      ]}"#;
    let path = desk.file("city.geojson", text);
    let height = Some(HeightSource::Property("h".to_owned()));
    let found = desk.ingest(spec(path, height), &lambert()).expect("valid");
    let ids: Vec<&str> = found.iter().map(|f| f.id.as_str()).collect();
    assert_eq!(ids, ["42", "bati.1", "city.geojson:2"]);

    let bati = &found[1];
    assert_eq!(bati.polygons.len(), 2);
    assert_eq!(bati.polygons[0].rings.len(), 2);
    assert_eq!(bati.polygons[0].rings[0].len(), 3, "the repeated last vertex is dropped");
    let first = bati.polygons[0].rings[0][0];
    assert_eq!(first.x.to_bits(), 651_143.297_675_11_f64.to_bits());
    assert_eq!(first.y.to_bits(), 6_861_442.905_745_622_f64.to_bits());
    assert_eq!((bati.base_m, bati.height_m, bati.uncertainty_m), (40.25, 18.3, 0.5));
    let attributes: Value = serde_json::from_str(&bati.attributes).expect("JSON");
    let expected =
        serde_json::json!({"h": "18.3", "n": 7, "name": "Opéra", "deep": {"a": [1, 2.5]}});
    assert_eq!(attributes, expected);

    assert_eq!((found[0].base_m, found[0].height_m), (0.0, 6.5), "flat, and no ground");
    let lent = found[2].height_m;
    assert!(lent == 6.5 || lent == 18.3, "a footprint without height borrows one: {lent}");
    let warnings = desk.job.warnings();
    assert_eq!(warnings.counts()["absent-height"], 1);
    assert!(warnings.messages("absent-height")[0].contains("city.geojson:2"), "{warnings:?}");
    assert_eq!(warnings.counts()["no-ground"], 1);
}

#[test]
fn what_cannot_be_extruded_is_left_out_and_named() {
    let desk = Desk::new();
    let good = feature("[[[0,0],[10,0],[10,10],[0,10],[0,0]]]");
    let bad = [
        (feature("[[[0,0],[10,10],[10,0],[0,10],[0,0]]]"), "crosses itself near"),
        (feature("[[[0,0],[10,0],[0,0]]]"), "2 points"),
        (feature("[[[5,5],[5,5],[5,5],[5,5]]]"), "1 points"),
        (feature("[[]]"), "no points"),
        (feature("[]"), "no points"),
        (feature("[[[0,0],[10,0],[20,0],[0,0]]]"), "area is 0 m²"),
        (feature("[[[0,0],[null,0],[10,10],[0,0]]]"), "vertex at [NaN, 0]"),
        (feature("[[[0,0],[1e12,0],[10,10],[0,0]]]"), "vertex at [1000000000000, 0]"),
        (feature("[[0,0],[10,0],[10,10]]"), "nested 2 deep"),
        (feature("[[[0,0],[10,0],[[10,10]]]]"), "unevenly"),
        (feature("[[[0],[10],[20]]]"), "1 numbers"),
        (feature("[[[0,0],[10,0],[10,10],[0,10]],[[-5,5],[15,5],[15,6],[-5,6]]]"), "crosses"),
        (r#"{"type":"Feature","geometry":null,"properties":{}}"#.to_owned(), "no geometry"),
        (
            r#"{"type":"Feature","geometry":{"type":"Point","coordinates":[1,2]},"properties":{}}"#
                .to_owned(),
            "type \"Point\"",
        ),
    ];
    let features: Vec<&str> =
        std::iter::once(good.as_str()).chain(bad.iter().map(|(text, _)| text.as_str())).collect();
    let path = desk.file("bad.geojson", &collection(&features));
    let found = desk.ingest(spec(path, constant()), &local()).expect("not fatal");
    assert_eq!(found.len(), 1);
    let warnings = desk.job.warnings();
    let lines = warnings.lines();
    for (index, (_, reason)) in bad.iter().enumerate() {
        let id = format!("\"bad.geojson:{}\"", index + 1);
        let line = lines.iter().find(|line| line.contains(&id));
        let line = line.unwrap_or_else(|| panic!("no warning for {id}: {lines:#?}"));
        assert!(line.contains(reason), "{line:?} does not say {reason:?}");
    }
    let left_out = warnings.counts()["degenerate-polygon"] + warnings.counts()["not-a-footprint"];
    assert_eq!(left_out, bad.len() as u64);
}

#[test]
fn a_bad_hole_or_part_costs_only_itself() {
    let desk = Desk::new();
    let multi = r#"{"type":"Feature","id":"m","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[
        [[[0,0],[10,0],[10,10],[0,10]],[[1,1],[2,2],[1,1]]], [[[20,0],[30,10],[30,0],[20,10]]]]}}"#;
    let path = desk.file("m.json", &collection(&[multi]));
    let found = desk.ingest(spec(path, constant()), &local()).expect("valid");
    assert_eq!(found[0].polygons.len(), 1);
    assert_eq!(found[0].polygons[0].rings.len(), 1);
    let counts = desk.job.warnings().counts();
    assert_eq!((counts["degenerate-hole"], counts["degenerate-polygon"]), (1, 1));
}

#[test]
fn damaged_files_are_refused_with_place_and_remedy() {
    let desk = Desk::new();
    let whole = collection(&[&feature("[[[0,0],[10,0],[10,10]]]")]);
    let cases = [
        ("cut.json", &whole[..whole.len() - 3], "EOF while parsing"),
        ("not.json", "{\"hello\": 1}", "its \"type\" is \"\""),
        ("table.csv", "x,y\n1,2\n", "neither as JSON nor as FlatGeobuf"),
        ("empty.json", "", "neither as JSON nor as FlatGeobuf"),
        (
            "text.json",
            r#"{"type":"FeatureCollection","features":[{"geometry":{"type":"Polygon","coordinates":[[["a"]]]}}]}"#,
            "line 1, column",
        ),
        (
            "nan.json",
            r#"{"type":"FeatureCollection","features":[{"geometry":{"type":"Polygon","coordinates":[[[NaN,0]]]}}]}"#,
            "line 1, column",
        ),
        ("list.json", r#"{"type":"FeatureCollection"}"#, "without \"features\""),
        ("fgb.fgb", "fgb\u{3}fgb\u{1}", "byte"),
        (
            "old.city.json",
            r#"{"type":"CityJSON","version":"0.9","CityObjects":{},"vertices":[]}"#,
            "version is \"0.9\"",
        ),
        ("part.city.json", r#"{"type":"CityJSON","version":"1.1","CityObjects":{"#, "EOF"),
    ];
    for (name, text, expected) in cases {
        let path = desk.file(name, text);
        let fault = desk.refusal(spec(path.clone(), constant()), &local());
        let said = format!("{}: {}", fault.place, fault.problem);
        assert!(said.contains(expected), "{name}: {fault}");
        assert_eq!(fault.file, path);
        assert!(!fault.remedy.is_empty());
    }
    let absent = desk.refusal(spec(desk.folder.path().join("absent.json"), constant()), &local());
    assert!(absent.problem.contains("No such file"), "{absent}");

    let mut desk = Desk::new();
    desk.job.skip_damaged = true;
    let path = desk.file("not.json", "{");
    assert_eq!(desk.ingest(spec(path, constant()), &local()).expect("skipped"), []);
    assert_eq!(desk.job.warnings().counts()["damaged-file"], 1);
}

#[test]
fn another_crs_is_refused_naming_both() {
    let desk = Desk::new();
    let polygon = feature("[[[651000,6861000],[651010,6861000],[651010,6861010]]]");
    for named in ["urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:32631"] {
        let crs = format!(r#""crs":{{"type":"name","properties":{{"name":"{named}"}}}},"#);
        let text = collection(&[&polygon]).replacen('{', &format!("{{{crs}"), 1);
        let fault = desk.refusal(spec(desk.file("c.json", &text), constant()), &lambert());
        assert!(fault.problem.contains(named) && fault.problem.contains("EPSG:2154"), "{fault}");
    }
    let degrees = collection(&[&feature("[[[2.33,48.85],[2.34,48.85],[2.34,48.86]]]")]);
    let fault = desk.refusal(spec(desk.file("d.json", &degrees), constant()), &lambert());
    assert!(fault.problem.contains("look like degrees"), "{fault}");

    let heights = Some(HeightSource::Property("hauteur".to_owned()));
    let fault =
        desk.refusal(spec(desk.file("h.json", &collection(&[&polygon])), heights), &lambert());
    assert!(fault.problem.contains("\"hauteur\""), "{fault}");
}

#[test]
fn an_oversized_feature_is_refused_before_it_fills_the_memory() {
    let desk = Desk::new();
    let long = format!(r#"{{"properties":{{"a":"{}"}}}}"#, "x".repeat(70 << 20));
    let path = desk.file("long.json", &collection(&[&long]));
    let fault = desk.refusal(spec(path, constant()), &local());
    assert!(fault.problem.contains("a single feature is longer than"), "{}", fault.problem);

    let mut desk = Desk::new();
    desk.job = Job::new(desk.folder.path(), 20_000);
    let polygon = feature("[[[0,0],[10,0],[10,10]]]");
    let path = desk.file("many.json", &collection(&vec![polygon.as_str(); 200]));
    let fault = desk.refusal(spec(path, constant()), &local());
    assert!(fault.remedy.contains("--memory"), "{fault}");
}

#[test]
fn flatgeobuf_in_is_flatgeobuf_out() {
    let desk = Desk::new();
    let features: Vec<String> = (0..40)
        .map(|i| {
            let x = f64::from(i) * 20.0 + 0.1;
            format!(
                r#"{{"type":"Feature","id":"b{i:02}","properties":{{"h":{},"tag":"t{i}"}},"geometry":{{"type":"Polygon","coordinates":[[[{x},0],[{},0],[{},7.7]]]}}}}"#,
                f64::from(i) + 0.5,
                x + 10.0,
                x + 10.0
            )
        })
        .collect();
    let features: Vec<&str> = features.iter().map(String::as_str).collect();
    let path = desk.file("in.json", &collection(&features));
    let height = || Some(HeightSource::Property("h".to_owned()));
    let first = desk.ingest(spec(path, height()), &local()).expect("valid");
    let again = desk.folder.path().join("again.fgb");
    std::fs::rename(desk.folder.path().join("footprints.fgb"), &again).expect("renamed");
    let second = desk.ingest(spec(again.clone(), height()), &local()).expect("valid");
    assert_eq!(first.len(), 40);
    for (a, b) in first.iter().zip(&second) {
        assert_eq!((&a.id, &a.polygons, a.height_m), (&b.id, &b.polygons, b.height_m));
        assert_eq!(a.attributes, b.attributes);
    }
    let bytes = std::fs::read(&again).expect("a file");
    std::fs::write(&again, &bytes[..bytes.len() - 200]).expect("a file");
    let fault = desk.refusal(spec(again, height()), &local());
    assert!(fault.place.starts_with("byte"), "{fault}");
}

/// A house of 10 × 8 m with a ridge, floor and walls, as CityJSON of integers.
fn house(objects: &str) -> String {
    format!(
        r#"{{"type":"CityJSON","version":"1.1","CityObjects":{{{objects}}},
        "transform":{{"scale":[0.001,0.001,0.001],"translate":[85000.5,447000.25,-1.5]}},
        "vertices":[[0,0,0],[10000,0,0],[10000,8000,0],[0,8000,0],
                    [0,0,3000],[10000,0,3000],[10000,8000,3000],[0,8000,3000],
                    [0,4000,6000],[10000,4000,6000]],
        "metadata":{{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/7415"}}}}"#
    )
}

const FLOOR: &str = "[[3,2,1,0]]";
const WALLS_AND_ROOF: &str =
    "[[0,1,5,4]],[[1,2,6,9,5]],[[2,3,7,6]],[[3,0,4,8,7]],[[4,5,9,8]],[[8,9,6,7]]";

#[test]
fn cityjson_buildings_stand_on_their_floor_or_their_projection() {
    let rd = Crs::parse("EPSG:28992", None).expect("known");
    let geometry = |kind: &str, lod: &str, boundaries: &str, semantics: &str| {
        format!(r#"{{"type":"{kind}","lod":{lod},"boundaries":{boundaries}{semantics}}}"#)
    };
    let ground_surface = r#","semantics":{"surfaces":[{"type":"WallSurface"},{"type":"GroundSurface"}],"values":[[1,0,0,0,0,0,0]]}"#;
    let solids = [
        geometry("Solid", "\"2.2\"", &format!("[[{FLOOR},{WALLS_AND_ROOF}]]"), ground_surface),
        geometry("Solid", "2", &format!("[[{FLOOR},{WALLS_AND_ROOF}]]"), ""),
        geometry("MultiSurface", "\"1.3\"", &format!("[{WALLS_AND_ROOF}]"), ""),
        geometry(
            "CompositeSurface",
            "1",
            "[[[0,1,2]],[[0,2,3]],[[4,6,5]],[[4,7,6]],[[8,9,4]]]",
            "",
        ),
    ];
    for solid in &solids {
        let desk = Desk::new();
        let lod0 = geometry("MultiSurface", "\"0\"", "[[[4,5,6]]]", "");
        let objects = format!(
            r#""b":{{"type":"Building","geometry":[{lod0},{solid}],"attributes":{{"year":1650}}}},
               "r":{{"type":"Road","geometry":[{lod0}]}}"#
        );
        let path = desk.file("house.json", &house(&objects));
        let found = desk.ingest(spec(path, None), &rd).expect("valid");
        assert_eq!(found.len(), 1, "a road is no building");
        // A wall may add a vertex in the middle of a side, but moves none.
        let bounds = found[0].bounds();
        assert_eq!(bounds.min, DVec2::new(85_000.5, 447_000.25), "{solid}");
        assert_eq!(
            bounds.max,
            DVec2::new(10_000.0 * 0.001 + 85_000.5, 8000.0 * 0.001 + 447_000.25)
        );
        assert_eq!((found[0].polygons.len(), found[0].polygons[0].rings.len()), (1, 1), "{solid}");
        assert!((outline::area(&found[0].polygons[0].rings[0]) - 80.0).abs() < 1e-9, "{solid}");
        assert!((found[0].base_m + found[0].height_m - 4.5).abs() < 1e-12);
        assert_eq!(found[0].attributes, r#"{"year":1650}"#);
    }
}

#[test]
fn parts_inherit_and_courtyards_are_holes() {
    let desk = Desk::new();
    // A floor of eight triangles around a courtyard, looking down.
    let text = r#"{"vertices":[[0,0,0],[9,0,0],[9,9,0],[0,9,0],[3,3,0],[6,3,0],[6,6,0],[3,6,0],[0,0,5]],
      "CityObjects":{
        "part":{"type":"BuildingPart","parents":["whole"],"attributes":{"name":"part"},"geometry":[
          {"type":"MultiSurface","lod":"1.2","boundaries":[[[0,4,1]],[[1,4,5]],[[1,5,2]],[[2,5,6]],[[2,6,3]],[[3,6,7]],[[3,7,0]],[[0,7,4]],[[0,1,8]]]}]},
        "whole":{"type":"Building","children":["part"],"attributes":{"name":"whole","year":1900}},
        "broken":{"type":"Building","geometry":[{"type":"MultiSurface","lod":1,"boundaries":[[[0,1,99]]]}]}},
      "type":"CityJSON","version":"2.0"}"#;
    let path = desk.file("court.json", text);
    let height = Some(HeightSource::Property("year".to_owned()));
    let found = desk.ingest(spec(path, height), &local()).expect("valid");
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].attributes, r#"{"name":"part","year":1900}"#);
    let rings: Vec<usize> = found[0].polygons[0].rings.iter().map(Vec::len).collect();
    assert_eq!(rings, [4, 4], "an outline and a courtyard");
    let warnings = desk.job.warnings();
    assert!(warnings.messages("not-a-footprint")[0].contains("vertex 99"), "{warnings:?}");
}

#[test]
fn heights_come_from_the_roof_points_inside() {
    let desk = Desk::new();
    let mut header = Builder::from((1, 2));
    header.point_format = las::point::Format::new(0).expect("format 0");
    let scale = las::Transform { scale: 0.001, offset: 0.0 };
    header.transforms = las::Vector { x: scale, y: scale, z: scale };
    let file = desk.folder.path().join("roofs.las");
    let mut writer =
        Writer::from_path(&file, header.into_header().expect("a header")).expect("a file");
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let mut add = |x: f64, y: f64, z: f64, class: u8| {
        let mut point = Point { x, y, z, ..Point::default() };
        point.classification = las::point::Classification::new(class).expect("a class");
        writer.write_point(point).expect("in range");
    };
    // Building i, 20 m apart, has a flat roof 8 + i m above a ground of 2 m; trees hang over it.
    for i in 0..4 {
        for _ in 0..2000 {
            let (x, y) = (rng.random_range(0.0..18.0), rng.random_range(0.0..14.0));
            let inside = (2.0..12.0).contains(&x) && (2.0..12.0).contains(&y);
            let roof = 10.0 + f64::from(i) + rng.random_range(-0.03..0.03);
            let (z, class) = if inside { (roof, 6) } else { (2.0, 2) };
            add(f64::from(i) * 20.0 + x, y, z, class);
            if inside && x > 9.0 {
                add(f64::from(i) * 20.0 + x, y, 19.0, 5);
            }
        }
    }
    writer.close().expect("written");
    let square = |x: f64| {
        feature(&format!("[[[{},2],[{},2],[{},12],[{},12]]]", x + 2.0, x + 12.0, x + 12.0, x + 2.0))
    };
    let features: Vec<String> = (0..5).map(|i| square(f64::from(i) * 20.0)).collect();
    let features: Vec<&str> = features.iter().map(String::as_str).collect();
    let path = desk.file("b.json", &collection(&features));
    let ground = crate::ingest::ground::ingest_ground(
        &desk.job,
        Some(&GroundSpec::Constant { height_m: 2.0 }),
        &local(),
        &[],
        Bounds2 { min: DVec2::ZERO, max: DVec2::new(100.0, 20.0) },
    )
    .expect("valid")
    .expect("some");
    let ground = Ground::open(&ground).expect("staged");
    let specs = [spec(path, Some(HeightSource::Points))];
    let staged = ingest_footprints(&desk.job, &specs, &local(), Some(&ground), &[file])
        .expect("valid")
        .expect("some");
    let found = stored(&staged);
    for (i, footprint) in found.iter().take(4).enumerate() {
        // The noise of the roof is 3 cm.
        assert!((footprint.height_m - 8.0 - i as f64).abs() < 0.03, "{i}: {}", footprint.height_m);
        assert_eq!(footprint.base_m, 2.0);
    }
    // The fifth has no points and takes the median of the others.
    assert!((8.0..=11.1).contains(&found[4].height_m), "{}", found[4].height_m);
    assert_eq!(desk.job.warnings().counts()["no-points-inside"], 1);
    let extent = footprint_extent(&desk.job, &specs, &local()).expect("valid");
    assert_eq!((extent.min, extent.max), (DVec2::new(2.0, 2.0), DVec2::new(92.0, 12.0)));
}

fn data(path: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(path);
    if !path.exists() {
        eprintln!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

fn lines(warnings: &Warnings) -> String {
    warnings.lines().join("\n")
}

#[test]
fn paris_footprints() {
    let (Some(path), Some(dtm)) = (data("paris/buildingFootprint.json"), data("paris/dtm.json"))
    else {
        return;
    };
    let desk = Desk::new();
    let specs = [spec(path, Some(HeightSource::Property("hauteur".to_owned())))];
    let extent = footprint_extent(&desk.job, &specs, &lambert()).expect("valid");
    let ground = GroundSpec::PointsJson { path: dtm };
    let ground =
        crate::ingest::ground::ingest_ground(&desk.job, Some(&ground), &lambert(), &[], extent);
    let ground = Ground::open(&ground.expect("valid").expect("some")).expect("staged");
    let staged = ingest_footprints(&desk.job, &specs, &lambert(), Some(&ground), &[])
        .expect("valid")
        .expect("some");
    let found = stored(&staged);
    eprintln!(
        "paris: {} of 540, {:?}\n{}",
        found.len(),
        staged.bounds,
        lines(&desk.job.warnings())
    );
    assert!(found.len() >= 535, "{} footprints", found.len());
    assert!(found.iter().all(|f| (0.0..80.0).contains(&f.height_m) && f.base_m > 30.0));
    assert!(found.iter().all(|f| f.attributes.contains("\"hauteur\"")));
}

#[test]
fn delft_heights_from_points_agree_with_the_published_model() {
    let files: Vec<PathBuf> = [
        "delft/buildings.geojson",
        "delft/cityjson_lod1.json",
        "delft/ahn3_cropped_1.laz",
        "delft/ahn3_cropped_2.laz",
    ]
    .into_iter()
    .filter_map(data)
    .collect();
    let [buildings, model, points @ ..] = files.as_slice() else { return };
    let rd = Crs::parse("EPSG:28992", None).expect("known");
    let desk = Desk::new();
    let specs = [spec(buildings.clone(), Some(HeightSource::Points))];
    let extent = footprint_extent(&desk.job, &specs, &rd).expect("valid");
    let ground = GroundSpec::Points { classes: Some(vec![2]) };
    let ground =
        crate::ingest::ground::ingest_ground(&desk.job, Some(&ground), &rd, points, extent);
    let ground = Ground::open(&ground.expect("valid").expect("some")).expect("staged");
    let staged = ingest_footprints(&desk.job, &specs, &rd, Some(&ground), points)
        .expect("valid")
        .expect("some");
    let found = stored(&staged);
    eprintln!(
        "delft: {} of 160, {:?}\n{}",
        found.len(),
        staged.bounds,
        lines(&desk.job.warnings())
    );

    let city = Desk::new();
    let height = Some(HeightSource::Property("measuredHeight".to_owned()));
    let mut model_spec = spec(model.clone(), height);
    model_spec.format = Some(FootprintsFormat::CityJson);
    let model = city.ingest(model_spec, &rd).expect("valid");
    eprintln!("delft model: {} buildings\n{}", model.len(), lines(&city.job.warnings()));
    // Both have the identifier of the national register.
    let measured: std::collections::HashMap<String, f64> = model
        .iter()
        .filter_map(|f| {
            let attributes: Value = serde_json::from_str(&f.attributes).ok()?;
            attributes.get("measuredHeight")?;
            Some((attributes.get("lokaalid")?.as_str()?.to_owned(), f.height_m))
        })
        .collect();
    let mut errors: Vec<f64> =
        found.iter().filter_map(|f| Some(f.base_m + f.height_m - measured.get(&f.id)?)).collect();
    errors.sort_by(f64::total_cmp);
    let at = |q: f64| errors[((errors.len() - 1) as f64 * q) as usize];
    eprintln!(
        "delft: {} heights, difference from measuredHeight: {:?} at 5, 25, 50, 75, 95 %",
        errors.len(),
        [0.05, 0.25, 0.5, 0.75, 0.95].map(at)
    );
    assert!(errors.len() > 100 && at(0.5).abs() < 0.2);
}
