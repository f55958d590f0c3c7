//! Poses of a drive, made to agree with its photographs.
//!
//! A survey's poses come from GPS and inertial sensors: attitudes are a constant off, places wander by
//! a decimetre. Photographs of the same wall know better how they stand to each other. Corners
//! ([`corners`]) are looked for again where poses let them be ([`mod@matches`]), joined to tracks
//! ([`tracks`]), and a bundle adjustment ([`adjust`]) gives every panorama a small turn and a small shift.
//! What the survey says holds the whole in its place: a correction costs what its uncertainty makes of it.
//!
//! Nothing is corrected unless the photographs say clearly that it should be: see [`Verdict`].

mod adjust;
mod blocks;
mod corners;
mod matches;
mod tracks;

use std::collections::{BTreeSet, HashSet};

use flaneur_scene::Lens;
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::budget::Budget;
use super::draft::{Draft, DraftCamera, DraftLens, DraftMask};
use super::photograph::Photograph;
use crate::ingest::street::MaskColour;
use crate::ingest::{IngestError, Job, Unit};
use crate::layers::delivered::DeliveredPose;
use adjust::{Adjustment, Camera, Correction, Prior};
use corners::{Corner, Grey};
use matches::Shot;
use tracks::Sighting;

/// What the photographs of a drive say of its poses.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    /// Too few places are seen by several photographs.
    Unknown,
    /// They agree with the photographs, or nothing near them agrees much better.
    Right,
    /// They are off.
    Off,
    /// What would agree is farther from them than can be believed.
    Absurd { metres: f64, degrees: f64 },
}

/// Corners of a photograph, at most.
const MOST_CORNERS: usize = 800;
/// With fewer nothing can be said.
const FEWEST_CORNERS: usize = 100;
/// Bytes of a corner, all told.
const CORNER_BYTES: u64 = 256;
/// A photograph is compared with its neighbours of these ranks by distance.
const RANKS: [usize; 8] = [0, 1, 2, 3, 4, 6, 9, 13];
/// Panoramas farther apart are not compared, metres.
const FARTHEST_M: f64 = 25.0;
/// Cameras whose axes are turned by more do not show the same: cosine.
const LEAST_COSINE: f64 = 0.8;
/// Sightings that a panorama has on average, at least.
const FEWEST_SIGHTINGS: usize = 60;
/// Poses whose photographs disagree by less, pixels in the median, are right.
const RIGHT_PX: f64 = 0.5;
/// Others are off only if the corrected ones disagree by less than this share of it.
const OFF_SHARE: f64 = 0.6;
/// Standard deviation of a place of which the survey says nothing, metres.
const UNKNOWN_SHIFT_M: f64 = 0.1;
/// Standard deviation of attitudes, about each axis: mountings are surveyed to a degree or so.
const TURN_DEG: f64 = 3.0;
/// Corrections beyond so many standard deviations are absurd.
const ABSURD: f64 = 5.0;
/// Directions farther off a camera's axis (x/z, y/z) are left alone.
const WIDEST: f64 = 1.7;

/// Corrects the poses of one drive where they need it, and says what they were; nothing where they
/// stay. Progress and warnings go to the job.
pub(super) fn refine(job: &Job, drafts: &mut [Draft]) -> Result<Vec<DeliveredPose>, IngestError> {
    let Some(origin) = drafts.first().map(|draft| draft.position) else { return Ok(Vec::new()) };
    let shots = shots(job, drafts, origin)?;
    let pairs = pairs(drafts, &shots);
    let progress = job.stage("poses", pairs.len() as u64, Unit::Items);
    let found: Vec<_> = pairs
        .par_iter()
        .map(|&(a, b)| {
            job.check()?;
            let sighting = |shot: usize, corner| (shot as u32, corner);
            let matches = matches::matches(&shots[a], &shots[b]);
            progress.advance(1);
            Ok(matches.into_iter().map(|(i, j)| (sighting(a, i), sighting(b, j))).collect())
        })
        .collect::<Result<Vec<Vec<_>>, IngestError>>()?;
    let tracks = tracks::tracks(&found.concat());
    let mut delivered = adjustment(drafts, &shots, &tracks, origin);
    let before_px = delivered.median_px();
    let mut refined = delivered.clone();
    refined.refine(|| job.check())?;
    let after_px = refined.median_px();
    let verdict = verdict(&refined, before_px, after_px);
    tracing::info!(
        ?verdict,
        tracks = tracks.len(),
        before_px,
        after_px,
        "poses against photographs"
    );
    match verdict {
        Verdict::Unknown | Verdict::Right => Ok(Vec::new()),
        Verdict::Absurd { metres, degrees } => {
            job.warn(
                "poses",
                format!(
                    "photographs disagree by {before_px:.1} pixels; poses with which they would \
                     agree are up to {metres:.2} m and {degrees:.1}° from those delivered, which stay"
                ),
            );
            Ok(Vec::new())
        }
        Verdict::Off => Ok(apply(drafts, &refined.corrections)),
    }
}

fn verdict(refined: &Adjustment, before_px: f64, after_px: f64) -> Verdict {
    let sightings: usize = refined.sightings().iter().sum();
    if sightings < FEWEST_SIGHTINGS * refined.places.len() {
        return Verdict::Unknown;
    }
    if before_px < RIGHT_PX || after_px > OFF_SHARE * before_px {
        return Verdict::Right;
    }
    let corrections = refined.corrections.iter().zip(&refined.priors);
    let share = |(correction, prior): (&Correction, &Prior)| {
        let shift = correction.shift.length() / prior.shift_m;
        shift.max(correction.turn_rad().length() / prior.turn_rad)
    };
    if corrections.map(share).fold(0.0, f64::max) > ABSURD {
        let most =
            |of: fn(&Correction) -> f64| refined.corrections.iter().map(of).fold(0.0, f64::max);
        let degrees = most(|correction| correction.turn_rad().length()).to_degrees();
        return Verdict::Absurd { metres: most(|correction| correction.shift.length()), degrees };
    }
    Verdict::Off
}

fn apply(drafts: &mut [Draft], corrections: &[Correction]) -> Vec<DeliveredPose> {
    let one = |(draft, correction): (&mut Draft, &Correction)| {
        let delivered = DeliveredPose::new(
            draft.id.clone(),
            draft.position,
            draft.world_from_rig,
            correction.turn_rad(),
            correction.shift,
        );
        draft.world_from_rig = correction.turn * draft.world_from_rig;
        draft.position += correction.shift;
        delivered
    };
    drafts.iter_mut().zip(corrections).map(one).collect()
}

fn adjustment(
    drafts: &[Draft],
    shots: &[Shot],
    tracks: &[Vec<Sighting>],
    origin: DVec3,
) -> Adjustment {
    let places: Vec<DVec3> = drafts.iter().map(|draft| draft.position - origin).collect();
    let prior = |draft: &Draft| Prior {
        shift_m: if draft.uncertainty_m > 0.0 { draft.uncertainty_m } else { UNKNOWN_SHIFT_M },
        turn_rad: TURN_DEG.to_radians(),
    };
    let camera = |shot: &Shot| Camera {
        panorama: shot.panorama,
        lever: shot.centre - places[shot.panorama],
        cam_from_world: shot.cam_from_world,
        focal_px: shot.focal_px(),
    };
    let sighting = |&(shot, corner): &Sighting| {
        let ray = shots[shot as usize].rays[corner as usize];
        (shot as usize, DVec2::new(ray.x, ray.y))
    };
    let cameras = shots.iter().map(camera).collect();
    let sightings = tracks.iter().map(|track| track.iter().map(sighting).collect());
    let priors = drafts.iter().map(prior).collect();
    Adjustment::new(places.clone(), priors, cameras, sightings)
}

/// Pairs of photographs that may show the same, by their indices.
fn pairs(drafts: &[Draft], shots: &[Shot]) -> Vec<(usize, usize)> {
    let place = |draft: &Draft| draft.position.to_array();
    let entries = drafts.iter().enumerate().map(|(i, draft)| GeomWithData::new(place(draft), i));
    let tree = RTree::bulk_load(entries.collect());
    let mut of_panorama: Vec<Vec<usize>> = vec![Vec::new(); drafts.len()];
    for (index, shot) in shots.iter().enumerate() {
        of_panorama[shot.panorama].push(index);
    }
    let mut pairs = BTreeSet::new();
    for (index, draft) in drafts.iter().enumerate() {
        let here = place(draft);
        let near = tree.nearest_neighbor_iter_with_distance_2(&here);
        let others = near
            .take_while(|(_, distance_2)| *distance_2 <= FARTHEST_M * FARTHEST_M)
            .filter(|(other, _)| other.data != index)
            .take(1 + RANKS[RANKS.len() - 1]);
        for (rank, (other, _)) in others.enumerate() {
            if !RANKS.contains(&rank) {
                continue;
            }
            for &a in &of_panorama[index] {
                for &b in &of_panorama[other.data] {
                    if look_alike(&shots[a], &shots[b]) {
                        pairs.insert((a.min(b), a.max(b)));
                    }
                }
            }
        }
    }
    pairs.into_iter().collect()
}

/// Whether two cameras look the same way, with the same side up.
fn look_alike(a: &Shot, b: &Shot) -> bool {
    let a_from_b = a.cam_from_world * b.cam_from_world.transpose();
    a_from_b.x_axis.x > LEAST_COSINE && a_from_b.z_axis.z > LEAST_COSINE
}

/// The photographs that can be read, with their corners; spheres are left out. A damaged one is reported
/// when it is stored.
fn shots(job: &Job, drafts: &[Draft], origin: DVec3) -> Result<Vec<Shot>, IngestError> {
    let cameras: Vec<(usize, &Draft, &DraftCamera, Lens)> = drafts
        .iter()
        .enumerate()
        .flat_map(|(index, draft)| draft.cameras.iter().map(move |camera| (index, draft, camera)))
        .filter_map(|(index, draft, camera)| match camera.lens {
            DraftLens::Calibrated(lens) => Some((index, draft, camera, lens)),
            DraftLens::Sphere => None,
        })
        .collect();
    let room = job.memory / 4 / CORNER_BYTES / (cameras.len() as u64).max(1);
    let most = usize::try_from(room).unwrap_or(usize::MAX).min(MOST_CORNERS);
    if cameras.len() < 3 || most < FEWEST_CORNERS {
        return Ok(Vec::new());
    }
    let budget = Budget::new(job.memory / 2);
    let masks: HashSet<&DraftMask> = cameras.iter().filter_map(|c| c.2.mask.as_ref()).collect();
    let masks: Vec<(&DraftMask, Option<Grey>)> =
        masks.into_iter().map(|mask| (mask, grey(&budget, &mask.image))).collect();
    let progress = job.stage("corners", cameras.len() as u64, Unit::Images);
    let found = cameras.par_iter().map(|&(index, draft, camera, lens)| {
        job.check()?;
        progress.advance(1);
        let Some(grey) = grey(&budget, &camera.image) else { return Ok(None) };
        let lens = if lens.size == grey.size() { lens } else { lens.scaled_to(grey.size()) };
        let mask = masks.iter().find(|(mask, _)| camera.mask.as_ref() == Some(mask));
        let is_shown = |pixel: DVec2| {
            let is_in_reach = lens
                .unproject(pixel)
                .is_some_and(|ray| ray.truncate().abs().max_element() <= WIDEST);
            is_in_reach && mask.is_none_or(|(mask, grey)| shows(mask, grey.as_ref(), pixel, lens))
        };
        let corners: Vec<Corner> = grey.corners(most, is_shown);
        let centre = draft.position - origin + draft.world_from_rig * camera.position_in_rig;
        let cam_from_world: DMat3 = camera.cam_from_rig * draft.world_from_rig.transpose();
        Ok(Some(Shot::new(index, centre, cam_from_world, lens, corners)))
    });
    Ok(found.collect::<Result<Vec<Option<Shot>>, IngestError>>()?.into_iter().flatten().collect())
}

fn shows(mask: &DraftMask, grey: Option<&Grey>, pixel: DVec2, lens: Lens) -> bool {
    grey.is_none_or(|grey| {
        let is_white = grey.value(pixel / lens.size.as_dvec2()) >= 127.5;
        is_white == (mask.exclude == MaskColour::Black)
    })
}

/// The brightness of an image file; `None` where it cannot be read within the budget.
fn grey(budget: &Budget, image: &std::path::Path) -> Option<Grey> {
    let photograph = Photograph::inspect(image).ok()?;
    // Brightness, gradients and their sums, besides what decoding takes.
    let _share = budget.take(photograph.memory.saturating_mul(5))?;
    let bytes = photograph.read().ok()?;
    let rgb = photograph.decode(&bytes).ok()?;
    Some(Grey::of_rgb(photograph.size, &rgb))
}

#[cfg(test)]
mod tests;
