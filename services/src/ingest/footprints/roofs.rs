//! Heights of roofs from the points inside the outlines.

use std::path::PathBuf;

use glam::DVec2;
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::{Placed, outline};
use crate::ingest::{IngestError, Job, points};

/// LAS class of buildings.
const BUILDING: u8 = 6;

/// LAS classes that are no roof: ground, noise, water, rail, road, high noise.
const NO_ROOF: [u8; 6] = [2, 7, 9, 10, 11, 18];

/// Where no point is classified as a building, points this far above the foot count, metres:
/// above people and cars.
const CLEARANCE_M: f64 = 2.0;

/// A height is taken from no fewer points than this.
const LEAST_POINTS: u64 = 4;

/// A flat roof at this share of the heights: near the ridge of a gable, and below chimneys,
/// aerials and what grows over the roof. On an airborne survey of 160 old houses the median of the
/// differences from a published LoD1 model is 6 cm (24 cm at 0.9, −23 cm at 0.75).
const SHARE: f64 = 0.85;

/// Heights kept of a footprint, at most and at least; a sample where there are more.
const MOST_KEPT: u64 = 512;
const LEAST_KEPT: u64 = 16;

/// Sets the height of each footprint to that of its roof above its base: the share [`SHARE`] of the
/// heights of the points inside. Where any point of the survey is classified as a building, only
/// such points count. Footprints with fewer than [`LEAST_POINTS`] keep no height.
///
/// Memory: a bounded sample of heights for each footprint, within an eighth of the budget.
pub(super) fn measure(
    job: &Job,
    footprints: &mut [Placed],
    files: &[PathBuf],
) -> Result<(), IngestError> {
    let rectangles = footprints.iter().enumerate().map(|(index, footprint)| {
        let vertices: Vec<[f64; 2]> = footprint.survey.vertices().map(|v| v.to_array()).collect();
        GeomWithData::new(Rectangle::from_aabb(AABB::from_points(&vertices)), index)
    });
    let index = RTree::bulk_load(rectangles.collect());
    let kept = (job.memory / 8 / (8 * footprints.len().max(1) as u64)).clamp(LEAST_KEPT, MOST_KEPT);
    let mut roofs: Vec<Sample> = footprints.iter().map(|_| Sample::default()).collect();
    let mut others: Vec<Sample> = footprints.iter().map(|_| Sample::default()).collect();
    let mut classified = false;
    let shared: &[Placed] = footprints;
    points::scan(files, job, |chunk| {
        let hits: Vec<(usize, usize)> = chunk
            .positions
            .par_iter()
            .enumerate()
            .flat_map_iter(|(point, position)| {
                let plan = position.truncate();
                let at = plan.to_array();
                let around = index.locate_all_at_point(&at).map(|footprint| footprint.data);
                let inside = around.filter(|footprint| holds(&shared[*footprint], plan));
                inside.map(|footprint| (point, footprint)).collect::<Vec<_>>()
            })
            .collect();
        classified |= chunk.classes.contains(&BUILDING);
        for (point, footprint) in hits {
            let (height, class) = (chunk.positions[point].z, chunk.classes[point]);
            if class == BUILDING {
                roofs[footprint].add(height as f32, kept);
            } else if !classified
                && !NO_ROOF.contains(&class)
                && height > shared[footprint].base_m + CLEARANCE_M
            {
                others[footprint].add(height as f32, kept);
            }
        }
        Ok(())
    })?;
    let samples = if classified { roofs } else { others };
    for (footprint, sample) in footprints.iter_mut().zip(samples) {
        let height = sample.at(SHARE).map(|top| top - footprint.base_m);
        footprint.height_m = height.filter(|height| *height > 0.0);
    }
    Ok(())
}

fn holds(footprint: &Placed, p: DVec2) -> bool {
    footprint.survey.polygons.iter().any(|polygon| outline::contains(polygon, p))
}

/// A sample of bounded size of the heights seen, every one as likely to be in it.
#[derive(Default)]
struct Sample {
    kept: Vec<f32>,
    seen: u64,
}

impl Sample {
    fn add(&mut self, height: f32, most: u64) {
        self.seen += 1;
        if (self.kept.len() as u64) < most {
            self.kept.push(height);
        } else {
            // Vitter's algorithm R, with a hash of the count for its random numbers, so that the
            // same points always give the same height.
            let place = mix(self.seen) % self.seen;
            if let Some(kept) = self.kept.get_mut(place as usize) {
                *kept = height;
            }
        }
    }

    /// The height below which `share` of the sample lies.
    fn at(mut self, share: f64) -> Option<f64> {
        if self.seen < LEAST_POINTS {
            return None;
        }
        let place = ((self.kept.len() - 1) as f64 * share).round() as usize;
        let (_, height, _) = self.kept.select_nth_unstable_by(place, f32::total_cmp);
        Some(f64::from(*height))
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014).
fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
