//! Pyramids against the lens that they enclose.

use flaneur_scene::{Distortion, Intrinsics, Lens, PosedCamera, View};
use glam::{DVec2, DVec3, UVec2};

use crate::frustum::Frustum;
use crate::pinhole::Pinhole;

#[test]
fn what_a_lens_sees_lies_inside_its_pyramid() {
    let size = UVec2::new(640, 480);
    let intrinsics = Intrinsics { fx: 300.0, fy: 290.0, cx: 330.0, cy: 230.0 };
    let eye = DVec3::new(651_187.3, 6_861_353.6, 42.8);
    let pose = View::look(eye, 1.0, 0.2, 1.0, size).camera;
    for distortion in [
        Distortion::None,
        Distortion::Brown { k: [-0.2, 0.03, 0.0], p: [1e-3, -2e-3] },
        Distortion::Fisheye { k: [-0.02, 0.004, 0.0, 0.0] },
    ] {
        let camera = PosedCamera { lens: Lens { size, intrinsics, distortion }, ..pose };
        let map = Pinhole::for_depth_map(&camera.lens, 512).expect("a pinhole");
        let frustum = Frustum::new(&camera, &map);
        for i in 0..400u32 {
            let share = DVec2::new(f64::from(i % 20), f64::from(i / 20)) / 19.0;
            let Some(ray) = camera.lens.unproject(share * size.as_dvec2()) else { continue };
            let at = camera.cam_from_world.transpose() * (ray * 30.0);
            let inside = |p: DVec3| frustum.planes().iter().all(|(n, on)| n.dot(p - on) >= 0.0);
            assert!(inside(camera.centre + at), "{share} {distortion:?}");
            // What lies on the other side of the centre does not.
            assert!(!inside(camera.centre - at), "{share} {distortion:?}");
        }
    }
}
