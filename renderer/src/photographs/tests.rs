//! Where photographs are kept.

use glam::UVec2;

use super::atlas::{Atlas, NoPlace};
use crate::kernel_tests::gpu;

#[test]
fn a_budget_is_kept_and_given_back() {
    let mut atlas = Atlas::new(gpu());
    let size = UVec2::new(1000, 900);
    let rgba = vec![128; 1000 * 900 * 4];
    // Two layers of 1024 by 1536, a half of that for levels, are 12.6 MB.
    let most = 13_000_000;
    let first = atlas.insert(gpu(), size, &rgba, most).expect("room for one");
    let second = atlas.insert(gpu(), size, &rgba, most).expect("room for two");
    assert_ne!((first.layer, first.corner), (second.layer, second.corner));
    let full = atlas.insert(gpu(), size, &rgba, most);
    assert!(matches!(full, Err(NoPlace::Memory)), "{full:?}");
    atlas.remove(&first);
    assert_eq!(atlas.insert(gpu(), size, &rgba, most).expect("room again"), first);
}

#[test]
fn small_levels_share_a_layer() {
    let mut atlas = Atlas::new(gpu());
    let size = UVec2::new(250, 250);
    let rgba = vec![7; 250 * 250 * 4];
    let layers: Vec<u32> =
        (0..16).map(|_| atlas.insert(gpu(), size, &rgba, u64::MAX).expect("room").layer).collect();
    assert_eq!(layers, [0; 16]);
}
