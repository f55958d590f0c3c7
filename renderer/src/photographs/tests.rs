//! Where photographs are kept.

use glam::UVec2;

use super::atlas::{Atlas, NoPlace};
use super::layout::Layout;
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

/// Of so many layers at most.
fn layout(layers: u32) -> Layout {
    let limits =
        wgpu::Limits { max_texture_array_layers: layers, ..wgpu::Limits::downlevel_defaults() };
    Layout::new(&wgpu::Limits { max_texture_dimension_2d: 16_384, ..limits })
}

#[test]
fn where_an_array_is_full_the_next_larger_one_serves() {
    let mut layout = layout(2);
    let size = UVec2::splat(1024);
    let arrays: Vec<usize> =
        (0..7).map(|_| layout.take(size, u64::MAX).expect("room").array).collect();
    assert_eq!(arrays, [0, 0, 1, 1, 1, 1, 1], "two layers, and four in each of the next");
    // Of the largest nothing takes the place.
    let large = UVec2::splat(8000);
    for _ in 0..2 {
        layout.take(large, u64::MAX).expect("room");
    }
    assert_eq!(layout.take(large, u64::MAX), Err(NoPlace::Memory));
}

#[test]
fn what_the_device_refused_is_not_asked_for_again() {
    let mut layout = layout(256);
    let size = UVec2::splat(1024);
    for _ in 0..4 {
        layout.take(size, u64::MAX).expect("room");
    }
    assert_eq!(layout.layers()[0], 4);
    // Half as much again is refused: one more is tried, and then none.
    assert_eq!(layout.take(size, u64::MAX).expect("room").layer, 4);
    assert_eq!(layout.layers()[0], 6);
    layout.refused(0, 6, 4);
    assert_eq!(layout.take(size, u64::MAX).expect("room").layer, 4);
    assert_eq!(layout.layers()[0], 5);
    layout.refused(0, 5, 4);
    let place = layout.take(size, u64::MAX).expect("room in the next array");
    assert_eq!((place.array, layout.layers()), (1, [4, 1, 0, 0]));
    layout.refused(1, 1, 0);
    layout.refused(2, 1, 0);
    layout.refused(3, 1, 0);
    assert_eq!(layout.take(size, u64::MAX), Err(NoPlace::Memory));
}
