//! Makes a street's layers in the work folder, each from what it needs of the others.

use std::path::PathBuf;
use std::time::Instant;

use flaneur_scene::{Bounds2, Bounds3};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::follow::follow;
use super::footprints::{StagedFootprints, footprint_extent, ingest_footprints};
use super::ground::{Ground, StagedGround, ingest_ground};
use super::panoramas::{StagedPanoramas, ingest_panoramas};
use super::plan::{LayerPlan, Plan};
use super::points::{PointsInput, StagedPoints, ingest_points};
use super::street::Street;
use super::workspace::Workspace;
use super::{IngestError, Job, Warnings};
use crate::crs::Crs;
use crate::layers::delivered;

/// How far beyond everything else outlines get terrain, metres.
const OUTLINES_REACH_M: f64 = 500.0;

/// The finished layers.
#[derive(Default)]
pub(super) struct Built {
    /// Point sources, their names unique.
    pub(super) points: Vec<StagedPoints>,
    /// Panoramas, where there are any.
    pub(super) panoramas: Option<StagedPanoramas>,
    /// Terrain, where there is any.
    pub(super) ground: Option<StagedGround>,
    /// Footprints, where there are any.
    pub(super) footprints: Option<StagedFootprints>,
    /// What was not used.
    pub(super) warnings: Warnings,
    /// Layers that were found finished.
    pub(super) reused: Vec<String>,
    /// Points that were read and stored now, and the seconds that it took.
    pub(super) points_made: (u64, f64),
}

/// Makes the layers, or takes those that are finished.
pub(super) fn build(
    street: &Street,
    crs: &Crs,
    plan: &Plan,
    workspace: &Workspace,
    job: &Job,
) -> Result<Built, IngestError> {
    workspace.keep_only(&plan.layers())?;
    let mut built = Built::default();
    for (spec, layer) in street.points.iter().zip(&plan.points) {
        let started = Instant::now();
        let inputs = [PointsInput { name: spec.name.clone(), files: spec.files.clone() }];
        let (staged, reused) =
            built.layer(workspace, layer, job, |job| ingest_points(job, &inputs))?;
        if !reused {
            let points: u64 = staged.iter().map(|staged| staged.source.point_count).sum();
            built.points_made.0 += points;
            built.points_made.1 += started.elapsed().as_secs_f64();
        }
        built.add_points(staged);
    }
    let point_files: Vec<PathBuf> = built.points.iter().map(|staged| staged.file.clone()).collect();
    if let Some(layer) = &plan.panoramas {
        let make = |job: &Job| ingest_panoramas(job, &street.panoramas, crs);
        built.panoramas = built.layer(workspace, layer, job, make)?.0;
    }
    if let Some(path) = built.panoramas.as_ref().and_then(|panoramas| panoramas.delivered.clone()) {
        let bytes = std::fs::read(&path).map_err(|e| IngestError::io("read", &path, e))?;
        let poses = delivered::decode(&bytes)
            .map_err(|e| IngestError::io("read", &path, std::io::Error::other(e)))?;
        built.points.iter_mut().try_for_each(|staged| follow(job, staged, &poses))?;
    }
    if let Some(layer) = &plan.ground {
        let known = built.bounds().plan();
        let make = |job: &Job| {
            let outlines = footprint_extent(job, &street.footprints, crs)?;
            let extent = ground_extent(known, outlines);
            ingest_ground(job, street.ground.as_ref(), crs, &point_files, extent)
        };
        built.ground = built.layer(workspace, layer, job, make)?.0;
    }
    if let Some(layer) = &plan.footprints {
        let ground = built.ground.as_ref().map(Ground::open).transpose()?;
        let make = |job: &Job| {
            ingest_footprints(job, &street.footprints, crs, ground.as_ref(), &point_files)
        };
        built.footprints = built.layer(workspace, layer, job, make)?.0;
    }
    built.warnings = built.warnings.relative_to(street.root.folder());
    Ok(built)
}

/// Where terrain is wanted: under all that is seen or measured (`known`), and under the
/// outlines near it. A register of a whole city must not make the terrain of a street coarse;
/// where nothing else is known, it is all there is.
fn ground_extent(known: Bounds2, outlines: Bounds2) -> Bounds2 {
    let (mut min, mut max) = (outlines.min, outlines.max);
    if !known.is_empty() {
        min = known.min.min(min.max(known.min - OUTLINES_REACH_M));
        max = known.max.max(max.min(known.max + OUTLINES_REACH_M));
    }
    Bounds2 { min, max }
}

impl Built {
    /// Box around everything, empty where there is nothing.
    pub(super) fn bounds(&self) -> Bounds3 {
        let points = self.points.iter().map(|staged| staged.source.bounds);
        let panoramas = self.panoramas.iter().map(|staged| staged.bounds);
        let ground = self.ground.iter().map(|staged| staged.bounds);
        let footprints = self.footprints.iter().map(|staged| staged.bounds);
        let all = points.chain(panoramas).chain(ground).chain(footprints);
        all.fold(Bounds3::EMPTY, |all, one| all.union(&one))
    }

    fn layer<T: Serialize + DeserializeOwned>(
        &mut self,
        workspace: &Workspace,
        layer: &LayerPlan,
        job: &Job,
        make: impl FnOnce(&Job) -> Result<T, IngestError>,
    ) -> Result<(T, bool), IngestError> {
        let finished = workspace.layer(&layer.name, &layer.fingerprint, job, make)?;
        self.warnings.append(&finished.warnings);
        if finished.reused {
            self.reused.push(layer.name.clone());
        }
        Ok((finished.result, finished.reused))
    }

    /// Adds point sources. A name that an earlier input has taken gets a number, in an order
    /// that does not change.
    fn add_points(&mut self, staged: Vec<StagedPoints>) {
        for mut staged in staged {
            let given = staged.source.name.clone();
            let mut number = 2;
            while self.points.iter().any(|other| other.source.name == staged.source.name) {
                staged.source.name = format!("{given}-{number}");
                number += 1;
            }
            self.points.push(staged);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn terrain_reaches_under_near_outlines_only() {
        let bounds =
            |min: f64, max: f64| Bounds2 { min: DVec2::splat(min), max: DVec2::splat(max) };
        assert_eq!(ground_extent(bounds(0.0, 10.0), bounds(-5.0, 9000.0)), bounds(-5.0, 510.0));
        assert_eq!(ground_extent(bounds(0.0, 10.0), bounds(2.0, 3.0)), bounds(0.0, 10.0));
        assert_eq!(ground_extent(bounds(0.0, 10.0), Bounds2::EMPTY), bounds(0.0, 10.0));
        assert_eq!(ground_extent(Bounds2::EMPTY, bounds(2.0, 3.0)), bounds(2.0, 3.0));
    }
}
