//! Bundle adjustment: small corrections of poses, and the places of tracks, such that every track
//! is where its photographs show it.
//!
//! A place is homogeneous: a unit direction `d` from a centre `a` that does not move, and its inverse
//! distance ρ, so that what is infinitely far needs no case of its own. A photograph at `c` with the
//! rotation `M` (camera from world) shows it at `M v`, `v = d − ρ (c − a)`. A panorama's
//! correction is a turn `exp([θ]×)` of its rig about the rig's own place, in the world's axes, and a
//! shift of that place. With the lever `l` from there to the camera
//! `∂(M v)/∂θ = M ([v]× + ρ [l]×)`, `∂(M v)/∂shift = −ρ M`.
//! Errors are weighed after Cauchy, corrections cost what the survey's uncertainty makes of them, and
//! places are eliminated first (Schur), so that what is left is a system of 6×6 blocks.

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::blocks::{Block, Blocks, Six};

/// A camera of a panorama.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    /// Index of its panorama.
    pub(super) panorama: usize,
    /// From the rig's place to the camera's, world axes, as the survey has it, metres.
    pub(super) lever: DVec3,
    /// Camera from world axes, as the survey has it.
    pub(super) cam_from_world: DMat3,
    /// Pixels a unit of x/z.
    pub(super) focal_px: f64,
}

/// A place and what shows it.
#[derive(Clone, Debug)]
pub(super) struct Track {
    /// The centre `a`, metres.
    anchor: DVec3,
    /// The unit direction `d`.
    direction: DVec3,
    /// ρ, 1/m, zero or more.
    inverse: f64,
    /// Index of a camera, and where it has the place: (x/z, y/z).
    sightings: Vec<(usize, DVec2)>,
}

/// How a panorama stands to what its survey says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Correction {
    /// Turn about the panorama's place: `world_from_rig = turn · delivered`.
    pub(super) turn: DMat3,
    /// Added to its place, metres.
    pub(super) shift: DVec3,
}

/// Standard deviations of what a survey says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Of a place, metres.
    pub(super) shift_m: f64,
    /// Of an attitude, radians, about each axis.
    pub(super) turn_rad: f64,
}

/// Poses and tracks.
#[derive(Clone, Debug)]
pub(super) struct Adjustment {
    /// Places of the panoramas as the survey has them, metres.
    pub(super) places: Vec<DVec3>,
    pub(super) priors: Vec<Prior>,
    pub(super) cameras: Vec<Camera>,
    pub(super) tracks: Vec<Track>,
    pub(super) corrections: Vec<Correction>,
}

/// Errors from which on, pixels, a sighting begins to count less: first much is allowed.
const SOFT_PX: [f64; 3] = [6.0, 2.0, 1.0];
/// Steps for each of these.
const MOST_STEPS: usize = 12;
/// Steps that gain less than this share of the cost are the last.
const LEAST_GAIN: f64 = 1e-4;
/// Inverse distances at which a track is first looked for, in a row where each is so many times the
/// one before.
const NEAREST_M: f64 = 0.5;
const FARTHEST_M: f64 = 300.0;
const RATIO: f64 = 1.25;
/// Places closer than this to a camera's plane, as a share of their distance, are not seen by it.
const LEAST_DEPTH: f64 = 1e-3;

impl Correction {
    const NONE: Self = Self { turn: DMat3::IDENTITY, shift: DVec3::ZERO };

    /// The turn's axis times its angle.
    pub(super) fn turn_rad(&self) -> DVec3 {
        DQuat::from_mat3(&self.turn).to_scaled_axis()
    }
}

impl Adjustment {
    /// Poses as the survey has them, and tracks where they fit these best.
    pub(super) fn new(
        places: Vec<DVec3>,
        priors: Vec<Prior>,
        cameras: Vec<Camera>,
        sightings: impl IntoIterator<Item = Vec<(usize, DVec2)>>,
    ) -> Self {
        let corrections = vec![Correction::NONE; places.len()];
        let mut all = Self { places, priors, cameras, tracks: Vec::new(), corrections };
        all.tracks = sightings.into_iter().filter_map(|s| all.first_guess(s)).collect();
        all
    }

    /// The median error of all sightings, pixels, once every track is where it fits best; poses stay.
    pub(super) fn median_px(&mut self) -> f64 {
        for soft_px in SOFT_PX {
            self.settle(soft_px, false);
        }
        let sightings = self.tracks.iter().flat_map(|t| t.sightings.iter().map(move |s| (t, s)));
        let mut errors: Vec<f64> = sightings
            .map(|(track, sighting)| {
                self.error(track, *sighting).map_or(f64::INFINITY, DVec2::length)
            })
            .collect();
        let middle = errors.len() / 2;
        if errors.is_empty() {
            return 0.0;
        }
        *errors.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Corrects the poses. `check` is asked before every step whether to go on.
    pub(super) fn refine<E>(&mut self, check: impl Fn() -> Result<(), E>) -> Result<(), E> {
        for soft_px in SOFT_PX {
            let mut damping = 1e-4;
            let mut cost = self.cost(soft_px);
            for _ in 0..MOST_STEPS {
                check()?;
                let Some(next) = self.step(soft_px, damping, true) else { break };
                let next_cost = next.cost(soft_px);
                if next_cost < cost {
                    let gain = (cost - next_cost) / cost;
                    *self = next;
                    cost = next_cost;
                    damping = (0.2 * damping).max(1e-9);
                    if gain < LEAST_GAIN {
                        break;
                    }
                } else {
                    damping *= 10.0;
                    if damping > 1e3 {
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Sightings of each panorama.
    pub(super) fn sightings(&self) -> Vec<usize> {
        let mut counts = vec![0; self.places.len()];
        for (camera, _) in self.tracks.iter().flat_map(|track| &track.sightings) {
            counts[self.cameras[*camera].panorama] += 1;
        }
        counts
    }

    fn settle(&mut self, soft_px: f64, poses: bool) {
        let mut cost = self.cost(soft_px);
        for _ in 0..MOST_STEPS {
            let Some(next) = self.step(soft_px, 1e-6, poses) else { break };
            let next_cost = next.cost(soft_px);
            if !(next_cost < cost * (1.0 - LEAST_GAIN)) {
                break;
            }
            *self = next;
            cost = next_cost;
        }
    }

    /// Where a track is, if all poses are right: the distance that fits best among many.
    fn first_guess(&self, sightings: Vec<(usize, DVec2)>) -> Option<Track> {
        let (first, seen) = *sightings.first()?;
        let (anchor, cam_from_world, _) = self.pose(first);
        let direction = (cam_from_world.transpose() * seen.extend(1.0)).normalize();
        let mut track = Track { anchor, direction, inverse: 0.0, sightings };
        let mut best = (f64::INFINITY, 0.0);
        let count = ((FARTHEST_M / NEAREST_M).ln() / RATIO.ln()).ceil() as i32;
        let inverses = (0..=count).map(|k| RATIO.powi(k) / FARTHEST_M);
        for inverse in std::iter::once(0.0).chain(inverses) {
            track.inverse = inverse;
            let cost = self.cost_of(&track, SOFT_PX[0]);
            if cost < best.0 {
                best = (cost, inverse);
            }
        }
        track.inverse = best.1;
        best.0.is_finite().then_some(track)
    }

    /// Centre, camera from world axes, and lever of a camera as corrected.
    fn pose(&self, camera: usize) -> (DVec3, DMat3, DVec3) {
        let camera = &self.cameras[camera];
        let Correction { turn, shift } = self.corrections[camera.panorama];
        let lever = turn * camera.lever;
        let centre = self.places[camera.panorama] + shift + lever;
        (centre, camera.cam_from_world * turn.transpose(), lever)
    }

    /// Pixels from where a photograph has a track to where it should; `None` behind it.
    fn error(&self, track: &Track, (camera, seen): (usize, DVec2)) -> Option<DVec2> {
        let (centre, rotation, _) = self.pose(camera);
        let shown = rotation * (track.direction - track.inverse * (centre - track.anchor));
        (shown.z > LEAST_DEPTH)
            .then(|| self.cameras[camera].focal_px * (shown.truncate() / shown.z - seen))
    }

    fn cost_of(&self, track: &Track, soft_px: f64) -> f64 {
        let square = soft_px * soft_px;
        let most = square * 1e6f64.ln();
        let cost = |sighting: &(usize, DVec2)| {
            self.error(track, *sighting).map_or(most, |error| {
                (square * (error.length_squared() / square).ln_1p()).min(most)
            })
        };
        track.sightings.iter().map(cost).sum()
    }

    fn cost(&self, soft_px: f64) -> f64 {
        let corrections = self.corrections.iter().zip(&self.priors).map(|(correction, prior)| {
            correction.shift.length_squared() / (prior.shift_m * prior.shift_m)
                + correction.turn_rad().length_squared() / (prior.turn_rad * prior.turn_rad)
        });
        let tracks = self.tracks.iter().map(|track| self.cost_of(track, soft_px));
        corrections.sum::<f64>() + tracks.sum::<f64>()
    }

    /// One step of Levenberg and Marquardt's; `None` where there is none.
    fn step(&self, soft_px: f64, damping: f64, poses: bool) -> Option<Self> {
        let mut normal = Blocks::zero(self.places.len());
        let mut right = vec![[0.0; 6]; self.places.len()];
        let eliminated: Vec<Option<Eliminated>> = self
            .tracks
            .iter()
            .map(|track| self.eliminate(track, soft_px, damping, poses, &mut normal, &mut right))
            .collect();
        let mut next = self.clone();
        let mut moves = vec![[0.0; 6]; self.places.len()];
        if poses {
            for (index, (correction, prior)) in
                self.corrections.iter().zip(&self.priors).enumerate()
            {
                let (turn, shift) = (correction.turn_rad(), correction.shift);
                for k in 0..3 {
                    let [t, s] = [prior.turn_rad, prior.shift_m].map(|sigma| 1.0 / (sigma * sigma));
                    normal.diagonal[index][k][k] += t;
                    normal.diagonal[index][k + 3][k + 3] += s;
                    right[index][k] -= t * turn[k];
                    right[index][k + 3] -= s * shift[k];
                }
                for k in 0..6 {
                    normal.diagonal[index][k][k] *= 1.0 + damping;
                }
            }
            moves = normal.solve(&right)?;
            for (correction, step) in next.corrections.iter_mut().zip(&moves) {
                let [tx, ty, tz, x, y, z] = *step;
                let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(tx, ty, tz)));
                correction.turn = turn * correction.turn;
                correction.shift += DVec3::new(x, y, z);
            }
        }
        for (track, eliminated) in next.tracks.iter_mut().zip(&eliminated) {
            if let Some(eliminated) = eliminated {
                eliminated.apply(track, &moves);
            }
        }
        Some(next)
    }

    /// Adds a track to the system of the poses, without its own three unknowns.
    fn eliminate(
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

/// What a track becomes once the poses' steps are known.
struct Eliminated {
    /// Two axes across the track's direction.
    across: (DVec3, DVec3),
    inverse: DMat3,
    pull: DVec3,
    mixed: Vec<(usize, [DVec3; 6])>,
}

impl Eliminated {
    fn apply(&self, track: &mut Track, moves: &[Six]) {
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
