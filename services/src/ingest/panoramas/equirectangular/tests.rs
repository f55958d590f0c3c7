//! The same panoramas in CSV and in GeoJSON, and lists with faults.

use std::fs;

use flaneur_scene::{Region, heading_pitch_roll};
use glam::UVec2;
use serde_json::json;

use super::*;
use crate::ingest::panoramas::tests::survey::jpeg;
use crate::ingest::panoramas::{StagedPanoramas, ingest_panoramas};
use crate::ingest::street::{North, PanoramasSpec, Root};
use crate::layers::panoramas;

const CSV: &str = "image,id,x,y,z,heading_deg,pitch_deg,roll_deg,time,comment\n\
    a.jpg,p1,1000.5,2000.25,30,90,2,-1,2024-05-01T10:00:00Z,\"a, b\"\n\
    b.jpg,p2,1003.5,2000.25,30.5,-10,0,0,,\n";

fn geojson() -> serde_json::Value {
    let feature =
        |id: serde_json::Value, coordinates: serde_json::Value, properties: serde_json::Value| {
            json!({"type": "Feature", "id": id, "properties": properties,
               "geometry": {"type": "Point", "coordinates": coordinates}})
        };
    json!({"type": "FeatureCollection", "features": [
        feature(json!("ignored"), json!([1000.5, 2000.25, 30.0]), json!({
            "id": "p1", "heading_deg": 90, "pitch_deg": 2, "roll_deg": -1, "image": "a.jpg",
            "time": "2024-05-01T10:00:00Z"})),
        feature(json!("p2"), json!([1003.5, 2000.25]), json!({
            "z": 30.5, "heading_deg": -10, "pitch_deg": 0, "roll_deg": 0, "image": "b.jpg"})),
    ]})
}

/// Ingests a list beside images of 200 × 100 pixels.
fn ingest(
    name: &str,
    list: &str,
    crs: &str,
) -> Result<(StagedPanoramas, tempfile::TempDir), String> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join(name), list).expect("written");
    for (i, image) in ["a.jpg", "b.jpg"].into_iter().enumerate() {
        fs::write(folder.path().join(image), jpeg(UVec2::new(200, 100), i as u32))
            .expect("written");
    }
    fs::write(folder.path().join("square.jpg"), jpeg(UVec2::new(100, 100), 0)).expect("written");
    let root = Root::new(folder.path(), true).expect("a root");
    let spec = EquirectangularSpec {
        list: root.folder().join(name),
        images: root.folder().to_owned(),
        heading: North::Grid,
        height_offset_m: 1.5,
        boresight_deg: [0.0; 3],
        uncertainty_m: 0.1,
        root,
    };
    let job = Job::new(folder.path().join("work"), 1 << 26);
    let crs = Crs::parse(crs, None).expect("a CRS");
    let staged = ingest_panoramas(&job, &[PanoramasSpec::Equirectangular(spec)], &crs);
    staged.map(|staged| (staged.expect("panoramas"), folder)).map_err(|e| e.to_string())
}

#[tokio::test]
async fn csv_and_geojson_give_the_same_spheres() {
    use object_store::{ObjectStoreExt, PutPayload, memory::InMemory, path::Path as StorePath};
    let mut tables = Vec::new();
    for (name, list) in [("list.csv", CSV.to_owned()), ("list.geojson", geojson().to_string())] {
        let (staged, _folder) = ingest(name, &list, "local").expect("ingested");
        // 200 and 100 pixels wide.
        assert_eq!((staged.panoramas, staged.images, staged.objects.len()), (2, 2, 4));
        let (store, path) = (std::sync::Arc::new(InMemory::new()), StorePath::from("p.fgb"));
        let bytes = fs::read(&staged.table).expect("the table");
        let size = bytes.len() as u64;
        store.put(&path, PutPayload::from(bytes)).await.expect("stored");
        let mut found = panoramas::read(store, path, size, Region::All).await.expect("read");
        found.sort_by(|a, b| a.id.cmp(&b.id));
        tables.push(found);
    }
    assert_eq!(tables[0], tables[1]);
    let [p1, p2] = tables[0].as_slice() else { panic!("{tables:?}") };
    assert_eq!(p1.position, DVec3::new(1000.5, 2000.25, 31.5));
    assert_eq!((p1.time.as_deref(), p2.time.as_deref()), (Some("2024-05-01T10:00:00Z"), None));
    let angles = heading_pitch_roll(&p1.world_from_rig).map(f64::to_degrees);
    for (found, expected) in angles.into_iter().zip([90.0, 2.0, -1.0]) {
        assert!((found - expected).abs() < 1e-9, "{angles:?}");
    }
    assert_eq!(p1.cameras[0].id, "sphere");
    assert_eq!(p1.cameras[0].projection.size(), UVec2::new(200, 100));
}

#[test]
fn faults_are_named_with_their_place() {
    let csv = |from: &str, to: &str| ("list.csv", CSV.replace(from, to));
    let geo = |change: fn(&mut serde_json::Value)| {
        let mut list = geojson();
        change(&mut list["features"][1]);
        ("list.geojson", list.to_string())
    };
    let cases = [
        (csv("heading_deg", "yaw"), "list.csv, line 1: there is no column \"heading_deg\""),
        (csv("90", "east"), "line 2: heading_deg is \"east\""),
        (csv("90", "NaN"), "line 2: the heading is NaN"),
        (csv("\"a, b\"", "a, b"), "line 2: 11 fields, where the header has 10"),
        (csv("\"a, b\"", "\"a"), "a quoted field does not end"),
        (csv("b.jpg", "../b.jpg"), "line 3: the path \"../b.jpg\" leaves the folder"),
        (csv("p2", "p1"), "line 3: a second panorama \"p1\"; the first is line 2"),
        (csv("p2", "a/b"), "line 3: \"a/b\" cannot be part of an identifier"),
        (csv("b.jpg", "square.jpg"), "square.jpg: it is 100×100 pixels, not twice as wide as high"),
        (
            geo(|f| f["geometry"]["type"] = json!("LineString")),
            "feature 2: its geometry is a \"LineString\"",
        ),
        (geo(|f| f["geometry"] = json!(null)), "feature 2: its geometry is a null"),
        (geo(|f| f["geometry"]["coordinates"] = json!([1])), "its coordinates are [1]"),
        (geo(|f| f["properties"]["z"] = json!(null)), "\"z\" is null"),
        (geo(|f| f["properties"]["image"] = json!(null)), "it has no \"image\""),
        (geo(|f| *f = json!(7)), "feature 2"),
        (("list.geojson", "{".into()), "list.geojson, line 1, column 1"),
        (("list.geojson", "[]".into()), "it has no list of \"features\""),
    ];
    for ((name, list), expected) in cases {
        let message = ingest(name, &list, "local").expect_err(expected);
        assert!(message.contains(expected) && message.contains("; "), "{message}, not {expected}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn degrees_are_refused_in_a_projected_street() {
    let list = CSV.replace("1000.5,2000.25", "2.35,48.85").replace("1003.5,2000.25", "2.36,48.86");
    let message = ingest("list.csv", &list, "EPSG:2154").expect_err("degrees");
    assert!(message.contains("(2.35, 48.85) looks like degrees"), "{message}");
    ingest("list.csv", &list, "local").expect("a local street may be small");
}
