//! The terrain under the street: one height everywhere, a list of heights, the points of some
//! LAS classes, or what lies under all points. Whatever the source, the result is a grid.

mod fill;
mod frame;
mod list;
mod lowest;
mod morphology;
mod patches;
mod raster;
mod tin;

use std::path::{Path, PathBuf};

use flaneur_scene::{Bounds2, Bounds3, GroundLayout};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::street::GroundSpec;
use super::{BadInput, IngestError, Job};
use crate::crs::Crs;
use crate::layers::ground::{GroundGrid, load, write};
use frame::Frame;

/// How far from the nearest known height the ground is continued, metres. Beyond it, it is
/// unknown.
const REACH_M: f64 = 128.0;

/// The uncertainty of a ground that is the same everywhere, metres: kerbs and gentle slopes.
const CONSTANT_UNCERTAINTY_M: f64 = 0.5;

/// The uncertainty of listed heights, which state none, metres.
const LIST_UNCERTAINTY_M: f64 = 0.2;

/// The most listed heights that are joined by triangles; more are averaged in the grid's cells.
const MOST_VERTICES: usize = 500_000;

/// A ground layer that waits for publication.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StagedGround {
    /// The GeoTIFF.
    pub file: PathBuf,
    /// Its tiles.
    pub layout: GroundLayout,
    /// The box around the known heights.
    pub bounds: Bounds3,
    /// Distance between nodes, metres.
    pub spacing_m: f64,
    /// How far the heights may be off, metres.
    pub uncertainty_m: f64,
}

/// A staged ground in memory.
pub struct Ground(GroundGrid);

/// Makes the ground that `spec` asks for, below `extent` and a little around it, from the
/// street's own `points` where it says so. `None` where the street has no ground, or nothing in
/// it (`extent` is empty).
///
/// # Errors
///
/// Where an input is damaged, no height is found, or the disk is full.
pub fn ingest_ground(
    job: &Job,
    spec: Option<&GroundSpec>,
    crs: &Crs,
    points: &[PathBuf],
    extent: Bounds2,
) -> Result<Option<StagedGround>, IngestError> {
    let Some(spec) = spec.filter(|_| !extent.is_empty()) else { return Ok(None) };
    let grid = match spec {
        GroundSpec::Constant { height_m } => constant(*height_m, &extent),
        GroundSpec::PointsJson { path } => {
            let samples = list::read(job, path)?;
            from_list(job, path, &samples, &extent)?
        }
        GroundSpec::Points { classes: Some(classes) } => {
            from_classes(job, points, classes, &extent)?
        }
        GroundSpec::Points { classes: None } => {
            let frame = Frame::around(&extent, lowest::most_nodes(job));
            lowest::ground(job, points, &frame)?
        }
    };
    let bounds = grid.bounds();
    let file = job.work.join("ground.tif");
    write(&file, &grid, crs).map_err(|error| IngestError::io("write", &file, error))?;
    let layout = grid.layout();
    let (spacing_m, uncertainty_m) = (grid.spacing_m, grid.uncertainty_m);
    Ok(Some(StagedGround { file, layout, bounds, spacing_m, uncertainty_m }))
}

impl Ground {
    /// Loads a staged ground.
    ///
    /// # Errors
    ///
    /// Where the file has gone or is damaged.
    pub fn open(staged: &StagedGround) -> Result<Self, IngestError> {
        load(&staged.file).map(Self).map_err(|error| {
            let remedy = "delete the work folder and run again";
            BadInput::error(&staged.file, "", error.to_string(), remedy)
        })
    }

    /// The height in the world at `p`, metres, where it is known.
    pub fn height(&self, p: DVec2) -> Option<f64> {
        self.0.height(p)
    }

    /// The lowest known height on the outline of `ring`, metres: at its vertices and every
    /// metre or so between them.
    pub fn lowest_along(&self, ring: &[DVec2]) -> Option<f64> {
        const STEP_M: f64 = 1.0;
        const MOST_STEPS: f64 = 1000.0;
        let mut lowest = f64::INFINITY;
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let steps = (a.distance(*b) / STEP_M).ceil().clamp(1.0, MOST_STEPS) as u32;
            for step in 0..steps {
                let p = a.lerp(*b, f64::from(step) / f64::from(steps));
                lowest = lowest.min(self.height(p).unwrap_or(f64::INFINITY));
            }
        }
        lowest.is_finite().then_some(lowest)
    }
}

fn constant(height_m: f64, extent: &Bounds2) -> GroundGrid {
    // A plane needs few nodes.
    let mut grid = Frame::around(extent, 1024).grid();
    grid.heights.fill(height_m as f32);
    grid.uncertainty_m = CONSTANT_UNCERTAINTY_M;
    grid
}

fn from_list(
    job: &Job,
    path: &Path,
    samples: &[DVec3],
    extent: &Bounds2,
) -> Result<GroundGrid, IngestError> {
    let mut heard = Bounds2::EMPTY;
    samples.iter().for_each(|sample| heard.include(sample.truncate()));
    let wanted = Bounds2 {
        min: extent.min.max(heard.min - REACH_M),
        max: extent.max.min(heard.max + REACH_M),
    };
    if wanted.is_empty() {
        let problem = format!(
            "all {} heights lie farther than {REACH_M} m from the street, between {} and {}",
            samples.len(),
            heard.min,
            heard.max
        );
        return Err(BadInput::error(path, "", problem, "give heights in the scene's own CRS"));
    }
    let frame = Frame::around(&wanted, raster::most_nodes(job));
    let mut grid = if samples.len() <= MOST_VERTICES {
        tin::grid(job, samples, &frame)?
    } else {
        let mut mean = raster::Mean::new(&frame);
        samples.iter().for_each(|sample| mean.add(*sample));
        mean.grid()
    };
    grid.uncertainty_m = LIST_UNCERTAINTY_M;
    Ok(grid)
}

fn from_classes(
    job: &Job,
    points: &[PathBuf],
    classes: &[u8],
    extent: &Bounds2,
) -> Result<GroundGrid, IngestError> {
    let frame = Frame::around(extent, raster::most_nodes(job));
    let mut mean = raster::Mean::new(&frame);
    let mut seen = [0u64; 256];
    super::points::scan(points, job, |chunk| {
        for (position, class) in chunk.positions.iter().zip(&chunk.classes) {
            seen[usize::from(*class)] += 1;
            if classes.contains(class) {
                mean.add(*position);
            }
        }
        Ok(())
    })?;
    if mean.is_empty() {
        let held: Vec<_> = (0..256).filter(|class| seen[*class] > 0).collect();
        let file = points.first().map_or(Path::new("points"), PathBuf::as_path);
        return Err(BadInput::error(
            file,
            "",
            format!("no point is of the ground classes {classes:?}; the classes are {held:?}"),
            "choose one of them in [ground], or leave out \"classes\" to use the lowest points",
        ));
    }
    Ok(mean.grid())
}

#[cfg(test)]
mod tests;
