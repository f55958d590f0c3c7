use std::sync::Arc;

use flaneur_scene::{Bounds2, GroundTile, Region, triangulate_ground};
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};
use proptest::prelude::*;

use super::*;
use crate::crs::Crs;
use crate::layers::LayerError;

/// A grid whose every height says where it is.
fn grid(columns: u32, rows: u32) -> GroundGrid {
    let height = |i: u32| {
        if i % 97 == 13 {
            f32::NAN
        } else {
            30.0 + (i / columns) as f32 + (i % columns) as f32 * 1e-3
        }
    };
    GroundGrid {
        origin: DVec2::new(651_000.25, 6_861_000.5),
        spacing_m: 0.5,
        columns,
        rows,
        heights: (0..columns * rows).map(height).collect(),
        uncertainty_m: 0.12,
    }
}

fn written(grid: &GroundGrid, crs: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ground.tif");
    write(&path, grid, &Crs::parse(crs, None).expect("known")).expect("writable");
    std::fs::read(path).expect("written")
}

async fn tiles(bytes: &[u8], region: Region) -> Result<Vec<GroundTile>, LayerError> {
    let store: Arc<dyn ObjectStore> = Arc::new(InMemory::new());
    let path = Path::from("s/ground.tif");
    store.put(&path, bytes.to_vec().into()).await.expect("memory");
    let mut cursor = open(store, path, bytes.len() as u64, region, 1).await?;
    let mut tiles = Vec::new();
    while let Some(tile) = cursor.next().await? {
        tiles.push(tile);
    }
    Ok(tiles)
}

#[tokio::test]
async fn tiles_cover_the_grid_and_share_their_borders() {
    for (columns, rows) in [(2, 2), (64, 65), (65, 64), (66, 130), (200, 131)] {
        let grid = grid(columns, rows);
        let mut seen = vec![false; grid.heights.len()];
        for tile in tiles(&written(&grid, "EPSG:2154"), Region::All).await.expect("valid") {
            assert!((tile.columns, tile.rows()) >= (2, 2), "a tile has at least one cell");
            for (i, height) in tile.heights.iter().enumerate() {
                let (r, c) = (i as u32 / tile.columns, i as u32 % tile.columns);
                let at = tile.origin + DVec2::new(f64::from(c), f64::from(r)) * tile.spacing_m;
                let node = (at - grid.origin) / grid.spacing_m;
                let index = node.y as usize * columns as usize + node.x as usize;
                assert_eq!(height.to_bits(), grid.heights[index].to_bits(), "{columns} × {rows}");
                seen[index] = true;
            }
        }
        assert!(seen.iter().all(|seen| *seen), "{columns} × {rows}: a node is missing");
    }
}

#[tokio::test]
async fn a_region_gives_the_tiles_that_meet_it() {
    let bytes = written(&grid(200, 131), "EPSG:2154");
    let all = tiles(&bytes, Region::All).await.expect("valid");
    let centre = DVec2::new(651_040.0, 6_861_020.0);
    for region in [
        Region::Disc { centre, radius_m: 3.0 },
        Region::Disc { centre, radius_m: 30.0 },
        Region::Box(Bounds2 { min: centre - 500.0, max: centre - 400.0 }),
    ] {
        let found = tiles(&bytes, region).await.expect("valid");
        let expected: Vec<_> = all.iter().filter(|tile| region.meets(&tile.bounds())).collect();
        let indices: Vec<_> = found.iter().map(|tile| tile.index).collect();
        assert_eq!(indices, expected.iter().map(|tile| tile.index).collect::<Vec<_>>());
    }
}

#[test]
fn the_published_decoder_reads_the_same() {
    let grid = grid(100, 70);
    let bytes = written(&grid, "EPSG:28992");
    let mut decoder = tiff::decoder::Decoder::new(std::io::Cursor::new(&bytes)).expect("a TIFF");
    assert_eq!(decoder.dimensions().expect("sizes"), (100, 70));
    let keys = decoder.get_tag_u16_vec(tiff::tags::Tag::GeoKeyDirectoryTag).expect("geo keys");
    assert_eq!(keys[keys.len() - 4..], [3072, 0, 1, 28_992]);
    let tiff::decoder::DecodingResult::F32(image) = decoder.read_image().expect("an image") else {
        panic!("not 32-bit floats");
    };
    for (from_north, line) in image.chunks_exact(100).enumerate() {
        let row = &grid.heights[(69 - from_north) * 100..(70 - from_north) * 100];
        assert!(line.iter().zip(row).all(|(a, b)| a.to_bits() == b.to_bits()), "row {from_north}");
    }
}

#[test]
fn loading_gives_the_grid_and_the_heights_of_its_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ground.tif");
    let mut grid = grid(70, 66);
    grid.heights.iter_mut().enumerate().for_each(|(i, h)| *h = 40.0 + ((i * 37) % 11) as f32 / 7.0);
    write(&path, &grid, &Crs::parse("local", None).expect("local")).expect("writable");
    let loaded = load(&path).expect("valid");
    assert_eq!(loaded, grid);

    let tile = GroundTile {
        index: (0, 0),
        origin: grid.origin,
        spacing_m: grid.spacing_m,
        columns: grid.columns,
        heights: grid.heights.clone(),
        uncertainty_m: 0.0,
    };
    let mesh = triangulate_ground(&tile);
    for triangle in mesh.indices.chunks_exact(3).step_by(31) {
        let corners = [0, 1, 2].map(|i| {
            let p = mesh.vertices[triangle[i] as usize].position;
            mesh.origin + DVec3::new(p[0].into(), p[1].into(), p[2].into())
        });
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let height = loaded.height(middle.truncate()).expect("inside");
        // The mesh's corners are f32 relative to its origin: within 2e-6 m of the grid.
        assert!((height - middle.z).abs() < 1e-5, "{height} against {}", middle.z);
    }
    assert_eq!(loaded.height(grid.origin - 0.01), None);
    assert_eq!(loaded.height(DVec2::NAN), None);
    assert_eq!(loaded.height(grid.origin), Some(f64::from(grid.heights[0])));
}

#[tokio::test]
async fn hostile_sizes_are_errors() {
    let bytes = written(&grid(100, 70), "EPSG:2154");
    for cut in (0..bytes.len()).step_by(997).chain([bytes.len() - 1]) {
        assert!(tiles(&bytes[..cut], Region::All).await.is_err(), "cut at {cut}");
    }
}

thread_local! {
    static DAMAGE_BASE: Vec<u8> = written(&grid(80, 70), "EPSG:2154");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// Changed bytes in the directory, which ends the file, or anywhere: never a panic.
    #[test]
    fn damage_does_not_panic(
        edits in prop::collection::vec((any::<bool>(), any::<u32>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = DAMAGE_BASE.with(Clone::clone);
        let length = bytes.len();
        for (tail, at, value) in edits {
            let span = if tail { 700 } else { length };
            bytes[length - 1 - at as usize % span] = value;
        }
        let _ = futures::executor::block_on(tiles(&bytes, Region::All));
    }
}
