//! Equirectangular panoramas as rigs of six pinhole faces.

use glam::{DMat3, DVec2, DVec3, UVec2};

use crate::{Intrinsics, Lens};

/// One face of the cube around a panorama's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeFace {
    /// The face's camera name.
    pub name: &'static str,
    /// Rows: the face's right, down and forward axes in the rig frame.
    axes: [[f64; 3]; 3],
}

/// The six faces: front, right, back, left, up, down. `up` and `down` keep the
/// panorama's forward direction at the bottom and the top of their image.
pub const CUBE_FACES: [CubeFace; 6] = [
    CubeFace { name: "front", axes: [[1., 0., 0.], [0., 0., -1.], [0., 1., 0.]] },
    CubeFace { name: "right", axes: [[0., -1., 0.], [0., 0., -1.], [1., 0., 0.]] },
    CubeFace { name: "back", axes: [[-1., 0., 0.], [0., 0., -1.], [0., -1., 0.]] },
    CubeFace { name: "left", axes: [[0., 1., 0.], [0., 0., -1.], [-1., 0., 0.]] },
    CubeFace { name: "up", axes: [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] },
    CubeFace { name: "down", axes: [[1., 0., 0.], [0., -1., 0.], [0., 0., -1.]] },
];

impl CubeFace {
    /// Rotation of the face: `p_cam = cam_from_rig p_rig`.
    pub fn cam_from_rig(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.axes).transpose()
    }

    /// The lens of a face of `size` pixels a side: exactly 90° in both directions.
    pub fn lens(size: u32) -> Lens {
        let half = 0.5 * f64::from(size);
        Lens::pinhole(UVec2::splat(size), Intrinsics { fx: half, fy: half, cx: half, cy: half })
    }

    /// Where the direction `d_rig` (any length) lies in an equirectangular image of
    /// `size`: x grows with the azimuth to the right of forward, which is the middle
    /// column; y grows downwards from the zenith. Pixels, corners at integers.
    pub fn equirectangular_from_rig(d_rig: DVec3, size: UVec2) -> DVec2 {
        use std::f64::consts::{PI, TAU};
        let azimuth = d_rig.x.atan2(d_rig.y);
        let elevation = d_rig.z.atan2(d_rig.x.hypot(d_rig.y));
        DVec2::new(azimuth / TAU + 0.5, 0.5 - elevation / PI) * size.as_dvec2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_rotations_and_cover_every_direction_once() {
        for face in CUBE_FACES {
            let m = face.cam_from_rig();
            assert!((m.determinant() - 1.0).abs() < 1e-15, "{}", face.name);
            assert!((m * m.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-15), "{}", face.name);
        }
        let lens = CubeFace::lens(64);
        for d in
            [DVec3::new(0.3, 0.9, 0.1), DVec3::new(-0.2, 0.1, -0.8), DVec3::new(0.7, -0.1, 0.2)]
        {
            let seen = CUBE_FACES
                .iter()
                .filter(|f| lens.project(f.cam_from_rig() * d).is_some_and(|p| lens.contains(p)))
                .count();
            assert_eq!(seen, 1, "{d}");
        }
    }

    #[test]
    fn forward_is_the_middle_of_the_panorama() {
        let size = UVec2::new(400, 200);
        let at = |d| CubeFace::equirectangular_from_rig(d, size);
        assert!(at(DVec3::Y).distance(DVec2::new(200.0, 100.0)) < 1e-12);
        assert!(at(DVec3::X).distance(DVec2::new(300.0, 100.0)) < 1e-12);
        assert!(at(DVec3::Z).y.abs() < 1e-12);
    }

    /// Every direction is seen by some face, at the pixel whose ray leads back to it, and
    /// the faces' edges meet: what one face sees on its border its neighbour sees on its own.
    #[test]
    fn face_pixels_lead_back_to_their_directions() {
        let lens = CubeFace::lens(128);
        let mut seen = [0; 6];
        for i in 0..2000 {
            // A spiral of evenly spread directions.
            let z = 1.0 - (f64::from(i) + 0.5) / 1000.0;
            let azimuth = f64::from(i) * 2.399_963_229_728_653;
            let d = (DVec2::from_angle(azimuth) * (1.0 - z * z).sqrt()).extend(z);
            let mut faces = 0;
            for (face, seen) in CUBE_FACES.iter().zip(&mut seen) {
                let Some(pixel) = lens.project(face.cam_from_rig() * d) else { continue };
                if lens.contains(pixel) {
                    let ray = lens.unproject(pixel).expect("a pinhole sees at every pixel");
                    let back = (face.cam_from_rig().transpose() * ray).normalize();
                    assert!(back.distance(d) < 1e-14, "{} {d} {back}", face.name);
                    *seen += 1;
                    faces += 1;
                }
            }
            assert!(faces >= 1, "{d}");
        }
        // A sixth of the sphere each.
        assert!(seen.iter().all(|n| (320..350).contains(n)), "{seen:?}");
    }

    /// The sphere is written from its definition: azimuth over the width, elevation over the
    /// height, whatever the direction's length.
    #[test]
    fn the_sphere_is_azimuth_by_elevation() {
        let size = UVec2::new(7200, 3600);
        for azimuth in [-179.5_f64, -90.0, -0.01, 0.0, 45.0, 120.0, 179.99] {
            for elevation in [-89.9_f64, -30.0, 0.0, 0.5, 60.0, 89.9] {
                for length in [1e-9, 1.0, 1e9] {
                    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
                    let d = DVec3::new(a.sin() * e.cos(), a.cos() * e.cos(), e.sin()) * length;
                    let found = CubeFace::equirectangular_from_rig(d, size);
                    // 20 pixels a degree; near the zenith the azimuth loses digits.
                    let expected = DVec2::new((azimuth + 180.0) * 20.0, (90.0 - elevation) * 20.0);
                    assert!(found.distance(expected) < 1e-9, "{azimuth} {elevation}: {found}");
                }
            }
        }
        // Straight up and down have no azimuth, but a place.
        for (d, y) in [(DVec3::Z, 0.0), (DVec3::NEG_Z, 3600.0)] {
            let pole = CubeFace::equirectangular_from_rig(d, size);
            assert!(pole.is_finite() && (pole.y - y).abs() < 1e-9, "{pole}");
        }
    }

    #[test]
    fn up_and_down_keep_the_forward_direction_in_the_middle() {
        let lens = CubeFace::lens(2);
        let at = |name: &str, d: DVec3| {
            let face = CUBE_FACES.iter().find(|f| f.name == name).expect("a face");
            lens.project(face.cam_from_rig() * d).expect("in front")
        };
        // Just forward of the zenith is below the middle of `up`; of the nadir, above that of `down`.
        assert!(at("up", DVec3::new(0.0, 0.1, 1.0)).distance(DVec2::new(1.0, 1.1)) < 1e-12);
        assert!(at("down", DVec3::new(0.0, 0.1, -1.0)).distance(DVec2::new(1.0, 0.9)) < 1e-12);
    }
}
