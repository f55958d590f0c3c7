//! Points that were taken on the same drive as photographs follow when the photographs' poses are
//! corrected: one trajectory placed both.
//!
//! The stored points stay as delivered. Their stations ([`flaneur_scene::Station`]) say how those
//! who show them are to move them: by the correction of the poses around. Whether the points are
//! of that drive they tell themselves: see [`thickness`].

mod thickness;

use std::fs;
use std::path::Path;

use flaneur_scene::{Station, StationCorrection};
use glam::{DMat3, DQuat, DVec3};
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::points::StagedPoints;
use super::{IngestError, Job};
use crate::layers::delivered::DeliveredPose;
use crate::layers::stations;
use thickness::Thickness;

/// Corrections are blended among poses that lie as near as this, metres (standard deviation of a
/// normal weight), but no fewer than the nearest.
const BLEND_M: f64 = 2.0;
/// Poses that are blended, at most.
const BLENDED: usize = 16;
/// Stations as near to a pose as this follow it entirely, those as far as that not at all, metres:
/// what was taken elsewhere is of another drive, or a flight.
const NEAR_M: f64 = 10.0;
const FAR_M: f64 = 20.0;
/// Surfaces must become thinner by this share.
const THINNER: f64 = 0.95;

/// Lets the points follow the corrected poses, where these make their surfaces thinner: writes
/// stations that say so, and names their file in `staged`.
///
/// # Errors
///
/// Where a staged file cannot be read, or the job is cancelled.
pub(super) fn follow(
    job: &Job,
    staged: &mut StagedPoints,
    poses: &[DeliveredPose],
) -> Result<(), IngestError> {
    let Some(path) = staged.stations.clone() else { return Ok(()) };
    let bytes = fs::read(&path).map_err(|e| IngestError::io("read", &path, e))?;
    let damaged = |e: String| IngestError::io("read", &path, std::io::Error::other(e));
    let delivered = stations::decode(&bytes).map_err(|e| damaged(e.to_string()))?;
    let corrected = corrected(&delivered, poses);
    if corrected.iter().all(|station| station.correction.is_none()) {
        return Ok(());
    }
    let before = Thickness::of(job, &staged.file, &delivered, &corrected)?;
    let [as_delivered, as_corrected] = before.medians_m();
    let follows = as_corrected < THINNER * as_delivered;
    let source = &staged.source.name;
    tracing::info!(source, as_delivered, as_corrected, follows, "points and corrected poses");
    if follows {
        let path = path.with_extension("corrected.json");
        write(&path, &corrected)?;
        staged.stations = Some(path);
    }
    Ok(())
}

fn write(path: &Path, stations: &[Station]) -> Result<(), IngestError> {
    let failed = |e| IngestError::io("write", path, e);
    let bytes = stations::encode(stations).map_err(|e| failed(std::io::Error::other(e)))?;
    fs::write(path, bytes).map_err(failed)
}

/// The stations, each with the correction of the poses around it.
fn corrected(stations: &[Station], poses: &[DeliveredPose]) -> Vec<Station> {
    let place = |at: DVec3| [at.x, at.y];
    let entries = poses.iter().map(|pose| GeomWithData::new(place(pose.position), pose));
    let tree = RTree::bulk_load(entries.collect());
    let of = |station: &Station| {
        let here = place(station.position);
        let near = tree.nearest_neighbor_iter_with_distance_2(&here).take(BLENDED);
        let around: Vec<(&DeliveredPose, f64)> = near.map(|(entry, d)| (entry.data, d)).collect();
        let correction = around.first().map_or(StationCorrection::default(), |(_, nearest_2)| {
            let share = ((FAR_M - nearest_2.sqrt()) / (FAR_M - NEAR_M)).clamp(0.0, 1.0);
            blended(station.position, &around, *nearest_2, share)
        });
        Station { correction, ..*station }
    };
    stations.iter().map(of).collect()
}

/// The mean motion of poses (with their squared distances), about `pivot`, times `share`.
fn blended(
    pivot: DVec3,
    around: &[(&DeliveredPose, f64)],
    nearest_2: f64,
    share: f64,
) -> StationCorrection {
    let (mut weights, mut middle, mut turn_rad, mut shift_m) =
        (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (pose, distance_2) in around {
        let weight = (0.5 * (nearest_2 - distance_2) / (BLEND_M * BLEND_M)).exp();
        weights += weight;
        middle += weight * (pose.position - pivot);
        turn_rad += weight * pose.turn_rad;
        shift_m += weight * pose.shift_m;
    }
    let [middle, turn_rad, shift_m] = [middle, turn_rad, shift_m].map(|sum| sum * share / weights);
    // About the poses' middle; and what that does to the pivot, `−middle` from there.
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(turn_rad));
    let arm = if share > 0.0 { -middle / share } else { DVec3::ZERO };
    StationCorrection { turn_rad, shift_m: turn * arm - arm + shift_m }
}

#[cfg(test)]
mod tests;
