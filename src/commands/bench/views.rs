//! Views that stand for a scene.

use flaneur_scene::{SceneInfo, View};
use glam::{DVec3, UVec2};

use crate::names::Names;

/// Views near photographs.
const COUNT: usize = 2;
/// How far to the side of a photograph, metres: where nobody stood.
const ASIDE_M: f64 = 1.0;

/// A few views near photographs, spread evenly over the panoramas in the order of their names:
/// each a step to the right of its panorama's first photograph, level, in its direction. In a scene
/// without photographs a view over all of it, from the south.
pub(super) fn chosen(names: &Names, scene: &SceneInfo, fov_deg: f64, size: UVec2) -> Vec<View> {
    let fov = fov_deg.to_radians();
    let mut first_of_each: Vec<_> = names.photographs().iter().collect();
    first_of_each.dedup_by(|a, b| a.0.panorama() == b.0.panorama());
    if first_of_each.is_empty() {
        return vec![over(scene, fov, size)];
    }
    let count = COUNT.min(first_of_each.len());
    let view = |index: usize| {
        let (_, photograph) =
            first_of_each.get((2 * index + 1) * first_of_each.len() / (2 * count))?;
        let forward = photograph.camera.forward();
        // Of a photograph of the sky or the ground, north.
        let heading =
            if forward.truncate().length() > 0.1 { forward.x.atan2(forward.y) } else { 0.0 };
        let right = DVec3::new(heading.cos(), -heading.sin(), 0.0);
        let eye = photograph.camera.centre + ASIDE_M * right;
        Some(View::look(eye, heading, 0.0, fov, size))
    };
    (0..count).filter_map(view).collect()
}

/// All of the scene, from above its southern border.
fn over(scene: &SceneInfo, fov: f64, size: UVec2) -> View {
    let bounds = &scene.bounds;
    let centre = bounds.centre();
    let depth_m = (bounds.max.y - bounds.min.y).max(1.0);
    let eye = DVec3::new(centre.x, bounds.min.y - 0.2 * depth_m, bounds.max.z + 0.3 * depth_m);
    View::look(eye, 0.0, -30f64.to_radians(), fov, size)
}
