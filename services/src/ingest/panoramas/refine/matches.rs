//! Which corners of two photographs show the same place, looked for where the poses let it be.

use std::collections::HashMap;

use flaneur_scene::Lens;
use glam::{DMat3, DVec2, DVec3};

use super::corners::Corner;

/// A photograph with its corners, as its survey has it.
pub(super) struct Shot {
    /// Index of its panorama.
    pub(super) panorama: usize,
    /// Centre, relative to the drive's origin, metres.
    pub(super) centre: DVec3,
    pub(super) cam_from_world: DMat3,
    /// For the photograph's own size.
    pub(super) lens: Lens,
    pub(super) corners: Vec<Corner>,
    /// Of each corner the direction (x/z, y/z, 1) in the camera's frame.
    pub(super) rays: Vec<DVec3>,
    cells: HashMap<(i32, i32), Vec<u32>>,
}

/// How far from where the poses put it a corner is looked for, radians.
const REACH_RAD: f64 = 0.017;
/// Two patches that show the same are as like as this.
const LEAST_LIKENESS: f32 = 0.85;
/// The best is better than any other candidate by this much.
const LEAST_LEAD: f32 = 0.04;
/// Candidates so near to each other (pixels) are the same corner.
const SAME_PX: f64 = 3.0;
/// What is nearer than so many baselines looks too different.
const NEAREST_BASELINES: f64 = 2.0;
/// Places are tried along a ray at most so often.
const MOST_TRIED: usize = 64;

impl Shot {
    pub(super) fn new(
        panorama: usize,
        centre: DVec3,
        cam_from_world: DMat3,
        lens: Lens,
        corners: Vec<Corner>,
    ) -> Self {
        let (corners, rays): (Vec<Corner>, Vec<DVec3>) = corners
            .into_iter()
            .filter_map(|corner| lens.unproject(corner.pixel).map(|ray| (corner, ray)))
            .unzip();
        let mut shot =
            Self { panorama, centre, cam_from_world, lens, corners, rays, cells: HashMap::new() };
        for (index, corner) in (0u32..).zip(&shot.corners) {
            shot.cells.entry(shot.cell(corner.pixel)).or_default().push(index);
        }
        shot
    }

    /// Focal length, pixels.
    pub(super) fn focal_px(&self) -> f64 {
        0.5 * (self.lens.intrinsics.fx + self.lens.intrinsics.fy)
    }

    fn reach_px(&self) -> f64 {
        (REACH_RAD * self.focal_px()).max(4.0)
    }

    fn cell(&self, pixel: DVec2) -> (i32, i32) {
        let cell = (pixel / self.reach_px()).floor();
        (cell.x as i32, cell.y as i32)
    }

    /// The corners within reach of `pixel`.
    fn near(&self, pixel: DVec2) -> impl Iterator<Item = u32> + '_ {
        let (x, y) = self.cell(pixel);
        let reach = self.reach_px();
        (-1..=1)
            .flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .copied()
            .filter(move |&index| self.corners[index as usize].pixel.distance(pixel) <= reach)
    }

    /// Where this photograph shows what another sees along `ray` (world), from far to near.
    fn places(&self, from: DVec3, ray: DVec3) -> Vec<DVec2> {
        let baseline = from - self.centre;
        let nearest_m = NEAREST_BASELINES * baseline.length();
        let at = |inverse: f64| {
            let pixel = self.lens.project(self.cam_from_world * (ray + inverse * baseline))?;
            self.lens.contains(pixel).then_some(pixel)
        };
        let last = if nearest_m > 0.0 { 1.0 / nearest_m } else { 0.0 };
        let ends = at(0.0).zip(at(last)).map_or(f64::INFINITY, |(a, b)| a.distance(b));
        let parts = (ends / self.reach_px()).ceil().clamp(1.0, MOST_TRIED as f64);
        (0..=parts as usize).filter_map(|part| at(last * part as f64 / parts)).collect()
    }
}

/// Pairs of corners of `a` and `b`, each the best for the other.
pub(super) fn matches(a: &Shot, b: &Shot) -> Vec<(u32, u32)> {
    let mut best_of_b: HashMap<u32, (f32, u32)> = HashMap::new();
    let mut best_of_a: Vec<(u32, u32)> = Vec::new();
    let world_from_a = a.cam_from_world.transpose();
    let mut candidates: Vec<u32> = Vec::new();
    for (index, (corner, ray)) in (0u32..).zip(a.corners.iter().zip(&a.rays)) {
        candidates.clear();
        for place in b.places(a.centre, world_from_a * ray.normalize()) {
            candidates.extend(b.near(place));
        }
        candidates.sort_unstable();
        candidates.dedup();
        let mut best: Option<(f32, u32)> = None;
        let mut second = f32::NEG_INFINITY;
        for &candidate in &candidates {
            let other = &b.corners[candidate as usize];
            let likeness = corner.likeness(other);
            let (most, leader) = best.unwrap_or((f32::NEG_INFINITY, candidate));
            let is_same = b.corners[leader as usize].pixel.distance(other.pixel) < SAME_PX;
            if likeness > most {
                if !is_same {
                    second = second.max(most);
                }
                best = Some((likeness, candidate));
            } else if !is_same {
                second = second.max(likeness);
            }
            let of_b = best_of_b.entry(candidate).or_insert((likeness, index));
            if likeness > of_b.0 {
                *of_b = (likeness, index);
            }
        }
        if let Some((likeness, candidate)) = best
            && likeness >= LEAST_LIKENESS
            && likeness - second >= LEAST_LEAD
        {
            best_of_a.push((index, candidate));
        }
    }
    best_of_a.retain(|(index, candidate)| best_of_b.get(candidate).is_some_and(|b| b.1 == *index));
    best_of_a
}
