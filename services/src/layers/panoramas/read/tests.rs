//! Written tables come back bit for bit, by region, and damage is refused.

use flaneur_scene::{Distortion, Intrinsics, Lens, Mask, Projection, StoredImage, world_from_rig};
use glam::{DVec2, UVec2};
use object_store::memory::InMemory;
use object_store::{ObjectStoreExt, PutPayload};
use proptest::prelude::*;

use super::*;
use crate::layers::panoramas::write;

/// Lambert-93 positions with full mantissas, lenses of every kind.
fn panorama(i: u32) -> Panorama {
    let t = f64::from(i);
    let distortion = match i % 4 {
        0 => Distortion::None,
        1 => Distortion::RadialPixels {
            centre: DVec2::new(1042.178, 1027.565),
            k: [-1.337_915_876_037_518e-7, 3.475_409_773_283_144e-14, -4.441_039_859_188_881e-21],
            limit_px: 2079.0 + t / 7.0,
        },
        2 => Distortion::Brown { k: [0.1 / 3.0, -0.01, 1e-300], p: [1e-3, -2e-3 / 7.0] },
        _ => Distortion::Fisheye { k: [0.1, 0.2, 0.3, 0.1 + 0.2] },
    };
    let size = UVec2::new(1024, 768 + i);
    let lens = Lens {
        size,
        intrinsics: Intrinsics { fx: 1_150.667_857_066_303, fy: 1.0 / 3.0, cx: t.sqrt(), cy: 0.1 },
        distortion,
    };
    let camera = |id: &str, projection| RigCamera {
        id: id.into(),
        position_in_rig: DVec3::new(0.1, -0.2 / 3.0, t.sin()),
        cam_from_rig: world_from_rig(t, 0.1, 0.2),
        projection,
        levels: (1..6).map(|level| StoredImage { bytes: u64::MAX / level, crc32: i }).collect(),
        mask: i.is_multiple_of(2).then(|| Mask {
            name: format!("mask{i}.0123abcd"),
            image: StoredImage { bytes: 1, crc32: u32::MAX },
        }),
        version: "89abcdef".into(),
    };
    Panorama {
        id: format!("p {i}"),
        position: DVec3::new(
            651_187.7 + (t * 0.7).sin() * 500.0,
            6_861_379.1 + t / 3.0,
            39.4 + t / 9.0,
        ),
        world_from_rig: world_from_rig(t * 0.1, 0.3, -0.2),
        time: i.is_multiple_of(3).then(|| "2014-06-16T12:31:34.841Z".into()),
        uncertainty_m: t / 10.0,
        cameras: vec![
            camera("300", Projection::Pinhole(lens)),
            camera("sphere", Projection::Equirectangular { size }),
        ],
    }
}

async fn stored(bytes: Vec<u8>) -> (Arc<dyn ObjectStore>, Path, u64) {
    let (store, path) = (InMemory::new(), Path::from("scene/panoramas.0.fgb"));
    let size = bytes.len() as u64;
    store.put(&path, PutPayload::from(bytes)).await.expect("memory takes it");
    (Arc::new(store), path, size)
}

fn table(count: u32) -> (Vec<Panorama>, Vec<u8>) {
    let panoramas: Vec<Panorama> = (0..count).map(panorama).collect();
    let mut bytes = Vec::new();
    write(&mut bytes, &panoramas, Some(2154)).expect("written");
    (panoramas, bytes)
}

async fn read_bytes(bytes: Vec<u8>, region: Region) -> Result<Vec<Panorama>, LayerError> {
    let (store, path, size) = stored(bytes).await;
    read(store, path, size, region).await
}

#[tokio::test]
async fn everything_comes_back_bit_for_bit() {
    for count in [0, 1, 2, 17, 1000] {
        let (mut expected, bytes) = table(count);
        let mut found = read_bytes(bytes, Region::All).await.expect("read");
        expected.sort_by(|a, b| a.id.cmp(&b.id));
        found.sort_by(|a, b| a.id.cmp(&b.id));
        assert_eq!(found, expected, "{count}");
    }
}

#[tokio::test]
async fn regions_give_what_a_full_scan_gives() {
    let (all, bytes) = table(1000);
    let (store, path, size) = stored(bytes).await;
    let centre = DVec2::new(651_400.0, 6_861_500.0);
    for half in [0.0, 1.0, 30.0, 200.0, 1e6] {
        let regions = [
            Region::Box(Bounds2 { min: centre - half, max: centre + half }),
            Region::Disc { centre, radius_m: half },
        ];
        for region in regions {
            let found = read(store.clone(), path.clone(), size, region).await.expect("read");
            let mut expected: Vec<&Panorama> = all
                .iter()
                .filter(|p| {
                    let p = p.position.truncate();
                    region.meets(&Bounds2 { min: p, max: p })
                })
                .collect();
            expected.sort_by(|a, b| a.id.cmp(&b.id));
            let mut by_id: Vec<&Panorama> = found.iter().collect();
            by_id.sort_by(|a, b| a.id.cmp(&b.id));
            assert_eq!(by_id, expected, "{region:?}");
            if matches!(region, Region::Disc { .. }) {
                let distances: Vec<f64> =
                    found.iter().map(|p| p.position.truncate().distance(centre)).collect();
                assert!(distances.is_sorted(), "{distances:?}");
            }
        }
    }
}

/// Everything but the head of the file and the target's neighbourhood is overwritten: what is
/// not needed is not read, or it would be found damaged.
#[tokio::test]
async fn a_small_region_reads_a_small_part() {
    const HEAD: usize = 1 << 20; // header and index take 0.5 MB
    const NEIGHBOURHOOD: usize = 2 << 20; // two of the reader's pieces
    let (all, mut bytes) = table(10_000);
    let target = &all[5000];
    let name = target.id.as_bytes();
    let at = bytes.windows(name.len()).position(|w| w == name).expect("the id is in the file");
    assert!(bytes.len() > HEAD + 4 * NEIGHBOURHOOD, "{}", bytes.len());
    for (i, byte) in bytes.iter_mut().enumerate().skip(HEAD) {
        if i.abs_diff(at) > NEIGHBOURHOOD {
            *byte = 0xff;
        }
    }
    let disc = Region::Disc { centre: target.position.truncate(), radius_m: 0.01 };
    let found = read_bytes(bytes.clone(), disc).await.expect("read");
    assert_eq!(found, std::slice::from_ref(target));
    assert!(read_bytes(bytes, Region::All).await.is_err());
}

#[tokio::test]
async fn damage_is_named_with_its_place() {
    let (_, bytes) = table(50);
    let message = |bytes: Vec<u8>| async {
        read_bytes(bytes, Region::All).await.expect_err("damaged").to_string()
    };
    for (length, place) in
        [(0, "byte 0"), (11, "byte 0"), (300, "byte 8"), (bytes.len() - 1, "past its range")]
    {
        let text = message(bytes[..length].to_vec()).await;
        assert!(text.contains(place) && text.contains("panoramas.0.fgb"), "{length}: {text}");
    }
    let mut magic = bytes.clone();
    magic[1] = b'x';
    assert!(message(magic).await.contains("byte 0"));
    let mut header = bytes.clone();
    header[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message(header).await.contains("header of 4294967295 bytes"));
}

#[test]
fn not_a_number_is_refused() {
    let mut poisoned = panorama(0);
    poisoned.position.y = f64::NAN;
    assert!(write(Vec::new(), [&poisoned], None).is_err());
}

proptest! {
    /// No byte of the file can make the reader panic or take more memory than the file.
    #[test]
    fn flipped_bytes_never_panic(at in 0.0..1.0, value: u8, run in 1..9_usize) {
        let (_, mut bytes) = table(40);
        let start = (at * bytes.len() as f64) as usize;
        let end = bytes.len().min(start + run);
        bytes[start..end].fill(value);
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        let disc = Region::Disc { centre: DVec2::new(651_187.0, 6_861_385.0), radius_m: 300.0 };
        for region in [Region::All, disc] {
            let _ = runtime.block_on(read_bytes(bytes.clone(), region));
        }
    }
}
