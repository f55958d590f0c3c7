//! Ground from the lowest points, where no class says what is ground.
//!
//! Each node takes the lowest of the points around it that does not lie alone. Then the
//! progressive morphological filter of Zhang et al. (2003, "A progressive morphological filter
//! for removing nonground measurements from airborne LIDAR data"): heights are opened (eroded,
//! then dilated) with ever wider windows, and a node that stands out of its opening by more than
//! a slope over that window explains belongs to a car, a wall, a tree or a roof. Of what is left,
//! small patches that no walk over the ground reaches are dropped, and the gaps are filled.

use std::path::{Path, PathBuf};

use super::fill::fill;
use super::frame::Frame;
use super::morphology::{dilate, erode};
use super::patches::drop_small_patches;
use crate::ingest::points::scan;
use crate::ingest::{BadInput, IngestError, Job};
use crate::layers::ground::{GroundGrid, MAX_NODES};

/// LAS classes of noise, below and above.
const NOISE: [u8; 2] = [7, 18];

/// How many of the lowest heights around a node are kept.
const KEPT: usize = 6;

/// Points belong together when they lie within this, metres, above the lowest of them. Echoes from
/// below the ground come alone or in twos.
const TOGETHER_M: f32 = 0.3;

/// Half widths of the windows, metres: a kerb or a person, a car, a lorry, a house, a block.
const HALF_WINDOWS_M: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// The steepest slope that is taken for ground: 1 in 5 is steeper than any road.
const SLOPE: f64 = 0.2;

/// A node may stand out by this much, metres, without any slope: noise and kerbs.
const TOLERANCE_M: f64 = 0.2;

/// And by no more than this, metres, however wide the window: less than a storey.
const MOST_M: f64 = 2.5;

/// The least uncertainty that is stated, metres: the noise of a lidar, which the lowest points
/// are biased by.
const LEAST_UNCERTAINTY_M: f64 = 0.05;

/// The nodes that fit into a quarter of the memory budget.
pub(super) fn most_nodes(job: &Job) -> u64 {
    const NODE_BYTES: u64 = 40;
    (job.memory / 4 / NODE_BYTES).clamp(1024, MAX_NODES)
}

/// The ground below the points of `files`, at the nodes of `frame`.
///
/// # Errors
///
/// Where a file is damaged, or no point lies near the frame.
pub(super) fn ground(
    job: &Job,
    files: &[PathBuf],
    frame: &Frame,
) -> Result<GroundGrid, IngestError> {
    let mut lows = Lows::new(frame.nodes());
    scan(files, job, |chunk| {
        for (position, class) in chunk.positions.iter().zip(&chunk.classes) {
            if let Some(node) = frame.nearest(*position).filter(|_| !NOISE.contains(class)) {
                lows.add(node, position.z as f32);
            }
        }
        Ok(())
    })?;
    let mut grid = frame.grid();
    grid.heights = lows.into_heights();
    if grid.heights.iter().all(|height| height.is_nan()) {
        let file = files.first().map_or(Path::new("points"), PathBuf::as_path);
        let remedy = "check the CRS of the points, or give the ground as a constant or a list";
        return Err(BadInput::error(file, "", "no point lies near the street", remedy));
    }
    job.check()?;
    for window in 0..HALF_WINDOWS_M.len() {
        job.check()?;
        drop_risen(&mut grid, window);
    }
    drop_small_patches(&mut grid, SLOPE, TOLERANCE_M / 2.0);
    grid.uncertainty_m = roughness(&grid).max(LEAST_UNCERTAINTY_M);
    fill(&mut grid);
    Ok(grid)
}

/// The lowest heights around each node, ascending, NaN where there are fewer.
struct Lows(Vec<[f32; KEPT]>);

impl Lows {
    fn new(nodes: usize) -> Self {
        Self(vec![[f32::NAN; KEPT]; nodes])
    }

    fn add(&mut self, node: usize, height: f32) {
        let lows = &mut self.0[node];
        // Comparisons with NaN are false, so an empty place takes any height.
        if let Some(place) = lows.iter().position(|low| !(*low <= height)) {
            lows[place..].rotate_right(1);
            lows[place] = height;
        }
    }

    /// The lowest height of each node that enough others lie just above: two where points are
    /// dense, fewer where the survey is sparse.
    fn into_heights(self) -> Vec<f32> {
        let full = |count: usize| self.0.iter().filter(|lows| !lows[count - 1].is_nan()).count();
        let seen = full(1);
        let others = (1..=2).rev().find(|others| full(others + 2) > seen / 2).unwrap_or(0);
        let height = |lows: &[f32; KEPT]| {
            let together = lows.windows(others + 1).find(|w| w[others] - w[0] <= TOGETHER_M);
            together.map_or(f32::NAN, |w| w[0])
        };
        self.0.iter().map(height).collect()
    }
}

/// Drops nodes that stand out of the opening with a window of [`HALF_WINDOWS_M`].
fn drop_risen(grid: &mut GroundGrid, window: usize) {
    let columns = grid.columns as usize;
    let radius = (HALF_WINDOWS_M[window] / grid.spacing_m).round() as usize;
    if radius == 0 {
        return;
    }
    let narrower = window.checked_sub(1).map_or(0.0, |window| HALF_WINDOWS_M[window]);
    // Zhang's equation 7: slope × (w − w of the window before) + tolerance, in full widths.
    let widened = 2.0 * (HALF_WINDOWS_M[window] - narrower);
    let threshold = (SLOPE * widened + TOLERANCE_M).min(MOST_M) as f32;
    let opened = dilate(&erode(&grid.heights, columns, radius), columns, radius);
    for (height, opened) in grid.heights.iter_mut().zip(opened) {
        if *height - opened > threshold {
            *height = f32::NAN;
        }
    }
}

/// How rough the ground is: the median distance of a node from the middle of its two
/// neighbours in the row, as a standard deviation (× 1.4826 for the median of a normal
/// distribution, / √1.5 for the noise of the neighbours).
fn roughness(grid: &GroundGrid) -> f64 {
    let mut distances: Vec<f32> = grid
        .heights
        .chunks_exact(grid.columns as usize)
        .flat_map(|row| row.windows(3).map(|w| (w[1] - f32::midpoint(w[0], w[2])).abs()))
        .filter(|distance| distance.is_finite())
        .collect();
    if distances.is_empty() {
        return 0.0;
    }
    let middle = distances.len() / 2;
    let (_, median, _) = distances.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) * 1.4826 / 1.5f64.sqrt()
}
