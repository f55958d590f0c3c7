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

mod eliminate;
mod error;
mod track;

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::blocks::Blocks;
use eliminate::Eliminated;
use track::Track;

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
}
