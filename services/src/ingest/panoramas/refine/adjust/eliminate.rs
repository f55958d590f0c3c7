//! Schur's complement: the unknowns of a track's place are solved for, given those of the poses.

use glam::{DMat3, DVec3};

use super::Adjustment;
use super::error::LEAST_DEPTH;
use super::track::Track;
use crate::ingest::panoramas::refine::blocks::{Block, Blocks, Six};

/// What a track becomes once the poses' steps are known.
pub(super) struct Eliminated {
    /// Two axes across the track's direction.
    across: (DVec3, DVec3),
    inverse: DMat3,
    pull: DVec3,
    mixed: Vec<(usize, [DVec3; 6])>,
}

impl Adjustment {
    /// Adds a track to the system of the poses, without its own three unknowns.
    pub(super) fn eliminate(
        &self,
        track: &Track,
        soft_px: f64,
        damping: f64,
        poses: bool,
        normal: &mut Blocks,
        right: &mut [Six],
    ) -> Option<Eliminated> {
        let across = track.direction.any_orthonormal_pair();
        let mut of_place = DMat3::ZERO;
        let mut pull = DVec3::ZERO;
        let mut mixed: Vec<(usize, [DVec3; 6])> = Vec::with_capacity(track.sightings.len());
        for &(camera, seen) in &track.sightings {
            let (centre, rotation, lever) = self.pose(camera);
            let from_anchor = centre - track.anchor;
            let v = track.direction - track.inverse * from_anchor;
            let shown = rotation * v;
            if !(shown.z > LEAST_DEPTH) {
                continue;
            }
            let focal = self.cameras[camera].focal_px;
            let p = shown.truncate() / shown.z;
            let error = focal * (p - seen);
            let weight = 1.0 / (1.0 + error.length_squared() / (soft_px * soft_px));
            // Rows of the derivative of the pixel by the world vector v.
            let by_v = [0, 1].map(|row| {
                let axes = [DVec3::X, DVec3::Y];
                focal / shown.z * (rotation.transpose() * (axes[row] - p[row] * DVec3::Z))
            });
            let by_place =
                by_v.map(|g| DVec3::new(g.dot(across.0), g.dot(across.1), -g.dot(from_anchor)));
            let by_pose = by_v.map(|g| {
                // gᵀ [v]× = (g × v)ᵀ
                let turn = g.cross(v) + track.inverse * g.cross(lever);
                let shift = -track.inverse * g;
                [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z]
            });
            let panorama = self.cameras[camera].panorama;
            let mut block = [DVec3::ZERO; 6];
            for row in 0..2 {
                let j = by_place[row];
                of_place += weight * DMat3::from_cols(j * j.x, j * j.y, j * j.z);
                pull -= weight * error[row] * j;
                if !poses {
                    continue;
                }
                for k in 0..6 {
                    let w = weight * by_pose[row][k];
                    block[k] += w * j;
                    right[panorama][k] -= w * error[row];
                    let sums = normal.diagonal[panorama][k].iter_mut();
                    sums.zip(by_pose[row]).for_each(|(sum, other)| *sum += w * other);
                }
            }
            if poses {
                match mixed.iter_mut().find(|(other, _)| *other == panorama) {
                    Some((_, sum)) => (0..6).for_each(|k| sum[k] += block[k]),
                    None => mixed.push((panorama, block)),
                }
            }
        }
        for k in 0..3 {
            *of_place.col_mut(k) =
                of_place.col(k) + DVec3::AXES[k] * (damping * of_place.col(k)[k]);
        }
        if !(of_place.determinant() > 0.0) {
            return None;
        }
        let inverse = of_place.inverse();
        if !inverse.is_finite() {
            return None;
        }
        for (index, (a, of_a)) in mixed.iter().enumerate() {
            let solved = of_a.map(|row| inverse * row);
            for k in 0..6 {
                right[*a][k] -= solved[k].dot(pull);
            }
            for (b, of_b) in &mixed[index..] {
                let product: Block =
                    std::array::from_fn(|k| std::array::from_fn(|l| solved[k].dot(of_b[l])));
                let (to, transposed) = match a.cmp(b) {
                    std::cmp::Ordering::Equal => (&mut normal.diagonal[*a], false),
                    std::cmp::Ordering::Less => {
                        (normal.above.entry((*a, *b)).or_insert([[0.0; 6]; 6]), false)
                    }
                    std::cmp::Ordering::Greater => {
                        (normal.above.entry((*b, *a)).or_insert([[0.0; 6]; 6]), true)
                    }
                };
                for k in 0..6 {
                    for l in 0..6 {
                        to[k][l] -= if transposed { product[l][k] } else { product[k][l] };
                    }
                }
            }
        }
        Some(Eliminated { across, inverse, pull, mixed })
    }
}

impl Eliminated {
    pub(super) fn apply(&self, track: &mut Track, moves: &[Six]) {
        let mut pull = self.pull;
        for (panorama, block) in &self.mixed {
            (0..6).for_each(|k| pull -= moves[*panorama][k] * block[k]);
        }
        let step = self.inverse * pull;
        let direction = track.direction + step.x * self.across.0 + step.y * self.across.1;
        let length = direction.length();
        if length.is_finite() && length > 0.0 {
            track.direction = direction / length;
            track.inverse = ((track.inverse + step.z) / length).max(0.0);
        }
    }
}
