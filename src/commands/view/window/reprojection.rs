//! Which pixel of the last frame shows what is to be seen at a pixel of the window.

use flaneur_scene::{Intrinsics, View};
use glam::{DMat3, DVec3};

/// Pixels of `screen`'s picture to pixels of `frame`'s, homogeneous; behind the frame's camera the
/// third coordinate is not positive. Exact as far as the eye has not moved since: K R Rᵀ K⁻¹.
/// Both views are in perspective and without distortion.
pub(super) fn frame_from_screen(frame: &View, screen: &View) -> DMat3 {
    let frame_from_cam = matrix(&frame.camera.lens.intrinsics);
    let cam_from_screen = matrix(&screen.camera.lens.intrinsics).inverse();
    let turn = frame.camera.cam_from_world * screen.camera.cam_from_world.transpose();
    frame_from_cam * turn * cam_from_screen
}

fn matrix(k: &Intrinsics) -> DMat3 {
    DMat3::from_cols(DVec3::X * k.fx, DVec3::Y * k.fy, DVec3::new(k.cx, k.cy, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, UVec2};

    #[test]
    fn what_is_far_stays_where_it_is_while_one_turns() {
        let eye = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let frame = View::look(eye, 0.4, 0.1, 1.0, UVec2::new(640, 480));
        let screen = View::look(eye, 0.7, -0.05, 0.8, UVec2::new(1000, 500));
        let map = frame_from_screen(&frame, &screen);
        for pixel in [DVec2::new(500.0, 250.0), DVec2::new(3.5, 411.0), DVec2::new(990.0, 20.0)] {
            let ray = screen.ray(pixel).expect("a ray");
            let seen = frame.camera.project(ray.origin + ray.direction * 70.0);
            let p = map * pixel.extend(1.0);
            let (expected, _) = seen.expect("ahead");
            assert!((p.truncate() / p.z).distance(expected) < 1e-6, "{pixel}: {p}");
        }
        let behind = View::look(eye, 0.4 + std::f64::consts::PI, -0.1, 1.0, screen.size());
        assert!((frame_from_screen(&frame, &behind) * DVec3::new(500.0, 250.0, 1.0)).z < 0.0);
        let same = frame_from_screen(&screen, &screen) - DMat3::IDENTITY;
        assert!(same.to_cols_array().iter().all(|entry| entry.abs() < 1e-9), "{same}");
    }
}
