use flaneur_scene::Polygon;
use glam::DVec2;
use object_store::ObjectStoreExt;
use object_store::memory::InMemory;
use proptest::prelude::*;

use super::*;

fn square(x: f64, y: f64, side: f64) -> Vec<DVec2> {
    [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
        .iter()
        .map(|(dx, dy)| DVec2::new(x + dx, y + dy))
        .collect()
}

fn building(i: u32, at: DVec2) -> Footprint {
    let hole = square(at.x + 1.0 / 3.0, at.y + 0.1, 0.7);
    Footprint {
        id: format!("b{i}"),
        polygons: vec![
            Polygon { rings: vec![square(at.x, at.y, 3.3), hole] },
            Polygon { rings: vec![square(at.x + 4.0, at.y, 0.1 + f64::from(i) * 1e-9)] },
        ],
        base_m: 39.7 + f64::from(i) / 7.0,
        height_m: 18.3,
        uncertainty_m: 0.5,
        attributes: format!(
            r#"{{"n":{i},"ratio":{},"name":"Nº {i}","flag":{},"mixed":{},"tags":["a",{i}]}}"#,
            f64::from(i) + 1.0 / 3.0,
            i.is_multiple_of(2),
            if i.is_multiple_of(2) { "\"x\"" } else { "1.5" },
        ),
    }
}

fn city(n: u32) -> Vec<Footprint> {
    let place = |i: u32| DVec2::new(f64::from(i % 40), f64::from(i / 40)) * 11.7;
    (0..n).map(|i| building(i, DVec2::new(651_143.297_675_11, 6_861_442.9) + place(i))).collect()
}

fn write(footprints: &[Footprint]) -> Vec<u8> {
    let mut columns = AttributeColumns::default();
    for footprint in footprints {
        columns.observe(&serde_json::from_str(&footprint.attributes).expect("an object"));
    }
    let crs = Crs::parse("EPSG:2154", None).expect("known");
    let mut writer = FootprintsWriter::new(&crs, columns).expect("room for a temporary file");
    for footprint in footprints {
        writer.push(footprint).expect("valid");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("footprints.fgb");
    writer.finish(&path).expect("writable");
    std::fs::read(path).expect("written")
}

async fn read_all(bytes: &[u8], region: Region) -> Result<Vec<Footprint>, LayerError> {
    let store: Arc<dyn ObjectStore> = Arc::new(InMemory::new());
    let path = Path::from("s/footprints.fgb");
    store.put(&path, bytes.to_vec().into()).await.expect("memory");
    let mut cursor = open(store, path, bytes.len() as u64, region).await?;
    let mut footprints = Vec::new();
    while let Some(footprint) = cursor.next().await? {
        footprints.push(footprint);
    }
    Ok(footprints)
}

fn sorted(mut footprints: Vec<Footprint>) -> Vec<Footprint> {
    footprints.sort_by(|a, b| a.id.cmp(&b.id));
    footprints
}

#[tokio::test]
async fn everything_comes_back_bit_for_bit() {
    for n in [1, 2, 16, 17, 300] {
        let city = city(n);
        let found = read_all(&write(&city), Region::All).await.expect("valid");
        assert!(sorted(found) == sorted(city), "{n} footprints");
    }
}

#[tokio::test]
async fn a_region_gives_what_meets_it_and_nothing_else() {
    let city = city(1000);
    let bytes = write(&city);
    let centre = DVec2::new(651_143.0 + 200.0, 6_861_443.0 + 100.0);
    let regions = [
        Region::Box(Bounds2 { min: centre - 40.0, max: centre + 55.0 }),
        Region::Box(Bounds2 { min: centre, max: centre }),
        Region::Box(Bounds2 { min: centre + 1e6, max: centre + 2e6 }),
        Region::Box(Bounds2 { min: centre - 1e9, max: centre + 1e9 }),
        Region::Disc { centre, radius_m: 33.0 },
        Region::Disc { centre, radius_m: 0.0 },
    ];
    for region in regions {
        let expected: Vec<Footprint> =
            city.iter().filter(|f| region.meets(&f.bounds())).cloned().collect();
        let found = read_all(&bytes, region).await.expect("valid");
        let (found_count, expected_count) = (found.len(), expected.len());
        assert!(
            sorted(found) == sorted(expected),
            "{region:?}: {found_count} footprints instead of {expected_count}, or others"
        );
    }
}

#[tokio::test]
async fn attributes_beyond_the_columns_are_kept() {
    let tags: Vec<String> = (0..2000).map(|i| format!("\"tag:{i}\":{i}")).collect();
    let attributes = format!("{{{}}}", tags.join(","));
    let building = Footprint { attributes: attributes.clone(), ..building(0, DVec2::ZERO) };
    let found = read_all(&write(&[building]), Region::All).await.expect("valid");
    assert_eq!(found[0].attributes, attributes);
}

#[tokio::test]
async fn any_truncation_is_an_error() {
    let bytes = write(&city(40));
    for cut in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        let error = read_all(&bytes[..cut], Region::All).await.expect_err("cut short");
        assert!(matches!(error, LayerError::Damaged { .. }), "cut at {cut}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    /// Whatever a few bytes are changed to, reading ends, and without a panic. Half of the
    /// changes fall into the header and the index, where the sizes are.
    #[test]
    fn damage_does_not_panic(
        edits in prop::collection::vec((any::<bool>(), any::<u32>(), any::<u8>()), 1..6),
        region in any::<bool>(),
    ) {
        let mut bytes = DAMAGE_BASE.with(Clone::clone);
        for (front, at, value) in edits {
            let span = if front { 2000.min(bytes.len()) } else { bytes.len() };
            bytes[at as usize % span] = value;
        }
        let centre = DVec2::new(651_200.0, 6_861_460.0);
        let region = if region { Region::Disc { centre, radius_m: 30.0 } } else { Region::All };
        let _ = futures::executor::block_on(read_all(&bytes, region));
    }
}

thread_local! {
    static DAMAGE_BASE: Vec<u8> = write(&city(60));
}
