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
}
