//! Where what one view shows is to be seen in another.

use flaneur_scene::{Intrinsics, View};
use glam::{DMat3, DVec2, DVec3, UVec2};

/// How far ahead things are taken to be where a frame is shown from another eye, metres: a guess that
/// grows what one walks towards.
const AHEAD: f64 = 12.0;
/// An eye that has gone farther than this is taken to have gone so far, metres: well before that.
const FARTHEST: f64 = 6.0;

/// Pixels of `frame`'s picture to pixels of `screen`'s, homogeneous: `K' (R + t nᵀ / d) K⁻¹`, with R and t
/// those of `cam'_from_cam`, and all upright on the plane nᵀ p = d before the frame's camera. Behind the
/// camera the third coordinate is not positive. With one eye it is exact for all there is.
/// Both views are in perspective and without distortion.
pub(super) fn screen_from_frame(frame: &View, screen: &View) -> DMat3 {
    let [from, to] = [&frame.camera, &screen.camera];
    let turn = to.cam_from_world * from.cam_from_world.transpose();
    let step = to.cam_from_world * (from.centre - to.centre).clamp_length_max(FARTHEST);
    let looks = from.cam_from_world.transpose() * DVec3::Z;
    let level = looks.truncate().normalize_or_zero().extend(0.0);
    let plane = from.cam_from_world * level / AHEAD;
    let moved = DMat3::from_cols(step * plane.x, step * plane.y, step * plane.z);
    let cam_from_frame = matrix(&from.lens.intrinsics).inverse();
    matrix(&to.lens.intrinsics) * (turn + moved) * cam_from_frame
}

/// Whether a picture of `from` pixels, brought to another by `map`, fills the other's `to` pixels.
pub(super) fn covers(map: &DMat3, from: UVec2, to: UVec2) -> bool {
    let mut shown = [DVec2::ZERO; 4];
    for (shown, corner) in shown.iter_mut().zip(corners(from)) {
        let p = *map * corner.extend(1.0);
        if p.z <= 1e-9 {
            return false;
        }
        *shown = p.truncate() / p.z;
    }
    // A convex shape contains a rectangle that has its corners on the inner side of every edge. Half a
    // pixel is forgiven: nobody sees it.
    (0..4).all(|index| {
        let (p, q) = (shown[index], shown[(index + 1) % 4]);
        let inward = (q - p).perp();
        corners(to).into_iter().all(|corner| inward.dot(corner - p) >= -0.5 * inward.length())
    })
}

/// Those of a picture, clockwise.
fn corners(size: UVec2) -> [DVec2; 4] {
    let size = size.as_dvec2();
    [DVec2::ZERO, size.with_y(0.0), size, size.with_x(0.0)]
}

fn matrix(k: &Intrinsics) -> DMat3 {
    DMat3::from_cols(DVec3::X * k.fx, DVec3::Y * k.fy, DVec3::new(k.cx, k.cy, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 40.0);

    fn look(eye: DVec3, heading: f64, pitch: f64, fov_y: f64) -> View {
        View::look(eye, heading, pitch, fov_y, UVec2::new(640, 480))
    }

    #[test]
    fn what_is_far_stays_where_it_is_while_one_turns() {
        let frame = look(EYE, 0.4, 0.1, 1.0);
        let screen = View::look(EYE, 0.7, -0.05, 0.8, UVec2::new(1000, 500));
        let map = screen_from_frame(&frame, &screen).inverse();
        for pixel in [DVec2::new(500.0, 250.0), DVec2::new(3.5, 411.0), DVec2::new(990.0, 20.0)] {
            let ray = screen.ray(pixel).expect("a ray");
            let seen = frame.camera.project(ray.origin + ray.direction * 70.0);
            let p = map * pixel.extend(1.0);
            let (expected, _) = seen.expect("ahead");
            assert!((p.truncate() / p.z).distance(expected) < 1e-6, "{pixel}: {p}");
        }
        let behind = View::look(EYE, 0.4 + std::f64::consts::PI, -0.1, 1.0, screen.size());
        let from_behind = screen_from_frame(&frame, &behind).inverse();
        assert!((from_behind * DVec3::new(500.0, 250.0, 1.0)).z < 0.0);
        let same = screen_from_frame(&screen, &screen) - DMat3::IDENTITY;
        assert!(same.to_cols_array().iter().all(|entry| entry.abs() < 1e-9), "{same}");
    }

    #[test]
    fn what_is_twelve_metres_ahead_stays_where_it_is_while_one_walks() {
        let frame = look(EYE, 0.4, 0.1, 1.0);
        let [ahead, right] = [
            DVec3::new(0.4f64.sin(), 0.4f64.cos(), 0.0),
            DVec3::new(0.4f64.cos(), -0.4f64.sin(), 0.0),
        ];
        let screen = look(EYE + ahead * 2.0 + right, 0.5, 0.0, 1.0);
        let map = screen_from_frame(&frame, &screen);
        for (x, z) in [(0.0, 0.0), (3.0, 2.0), (-4.0, -1.5)] {
            let place = EYE + ahead * 12.0 + right * x + DVec3::Z * z;
            let (from, _) = frame.camera.project(place).expect("ahead");
            let (to, _) = screen.camera.project(place).expect("ahead");
            let p = map * from.extend(1.0);
            assert!((p.truncate() / p.z).distance(to) < 1e-6, "{place}");
        }
        // Nothing turns inside out however far one goes.
        for far in [12.0, 50.0, -400.0] {
            let there = look(EYE + ahead * far, 0.4, 0.1, 1.0);
            assert!(screen_from_frame(&frame, &there).determinant() > 0.0, "{far}");
        }
    }

    #[test]
    fn a_wider_frame_covers_a_narrower_one_until_one_turns() {
        let (wide, narrow) = (look(EYE, 0.4, 0.0, 1.2), look(EYE, 0.45, 0.0, 1.0));
        let covers = |frame: &View, screen: &View| {
            super::covers(&screen_from_frame(frame, screen), frame.size(), screen.size())
        };
        assert!(covers(&wide, &narrow) && covers(&wide, &wide) && !covers(&narrow, &wide));
        assert!(!covers(&wide, &look(EYE, 0.7, 0.0, 1.0)));
        assert!(!covers(&wide, &look(EYE, 0.4 + 3.0, 0.0, 1.0)));
    }
}
