//! By how much nodes of points lower the expected error of the picture.
//!
//! Points put photographs in their place. Where depth is known to within *s*, what a photograph shows from
//! a baseline *b* away is displaced by *s f b / (d (d + b))* pixels at the distance *d*, and of a picture
//! that is displaced by *x* pixels the octaves of spatial frequency are wrong whose waves are shorter than
//! that: about ½ log₂ (1 + (2x)²) of them. Without points *s* is what mesh alone is off, with them it is their
//! spacing. Where there are no photographs, points are the picture: they lack the octaves that
//! are finer than their spacing.
//!
//! A node needs nothing of what is above it to be shown, and adds little where finer ones are. So what a node
//! gains, summed over rays of the view, depends on what came before it, and only falls with that (it is
//! submodular): nodes are taken one after the other, always the one that gains most a byte, and a
//! gain is computed again only when it would be its turn (Minoux, 1978).

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use flaneur_scene::{PointNodeId, PointSource, View};

use super::gain::FIRST_OCTAVES;
use crate::choose::WantedNode;
use crate::sight::Sight;

/// How far surfaces are from the mesh that stands for them, where no points say it: balconies, cars, and
/// what a footprint leaves out.
const UNMEASURED_M: f64 = 1.0;
/// What a node counts where it lies before the surface that mesh shows: it may hold a car or a tree, or
/// nothing.
const BEFORE: f64 = 0.2;
/// Depths before a surface at which points are told apart: every octave of metres, and beyond.
const DEPTHS: usize = 8;
/// A point shows no more than so much around it, metres.
const LARGEST_SPLAT_M: f64 = 0.5;
/// Where the points of a node cover at least so much of where it may show, coarser ones add nothing.
const DENSE: f64 = 0.5;
/// What any node gains, as a share of what its points would cover: they hide things from photographs where the
/// view does not see them, and stand between others.
const LEAST: f64 = 0.002;

/// The gain of each of `wanted`, if those that gain most a byte come first, and `held` are there. `baseline_m`
/// is the way from the eye to the nearest photograph, `None` where there is none.
pub(super) fn of_nodes(
    wanted: &[WantedNode],
    sources: &[PointSource],
    held: &BTreeSet<PointNodeId>,
    view: &View,
    sight: &Sight,
    baseline_m: Option<f64>,
) -> Vec<f64> {
    let mut course = Course::new(Error { view, baseline_m }, sight);
    let nodes: Vec<Node> =
        wanted.iter().map(|wanted| Node::new(wanted, sources, view, sight)).collect();
    let (there, lacking): (Vec<usize>, Vec<usize>) =
        (0..wanted.len()).partition(|&index| held.contains(&wanted[index].id));
    there.into_iter().for_each(|index| course.take(&nodes[index]));
    let turn = |course: &Course<'_>, index: usize| {
        let gain = course.gain(&nodes[index]);
        Turn { rate: gain / f64::from(wanted[index].node.byte_size.max(1)), gain, index }
    };
    let mut queue: BinaryHeap<Turn> = lacking.into_iter().map(|i| turn(&course, i)).collect();
    let mut gains = vec![0.0; wanted.len()];
    while let Some(stale) = queue.pop() {
        let fresh = turn(&course, stale.index);
        if queue.peek().is_some_and(|next| next.rate > fresh.rate) {
            queue.push(fresh);
            continue;
        }
        gains[fresh.index] = fresh.gain;
        course.take(&nodes[fresh.index]);
    }
    gains
}

/// Where a node may show.
struct Node {
    spacing_m: f64,
    places: Vec<Place>,
    /// How much of them its points cover, 0 to 1.
    density: f64,
    least: f64,
}

/// Where a ray passes it.
struct Place {
    ray: usize,
    depth: f64,
    /// Which of the ray's depths that is; the last is the surface.
    stretch: usize,
    /// Share of the picture.
    weight: f64,
}

impl Node {
    fn new(wanted: &WantedNode, sources: &[PointSource], view: &View, sight: &Sight) -> Self {
        let size = view.size().as_dvec2();
        let shown_m = wanted.spacing_m.min(LARGEST_SPLAT_M);
        let shown_px = shown_m * view.pixels_a_metre(wanted.distance_m.max(1.0));
        let covered = f64::from(wanted.node.point_count) * shown_px * shown_px / (size.x * size.y);
        let source = sources.get(usize::from(wanted.id.source)).filter(|_| wanted.seen);
        let bounds = source.map(|source| source.cube.node_bounds(wanted.id.key));
        let share = 1.0 / sight.rays().len().max(1) as f64;
        let passed = bounds.into_iter().flat_map(|bounds| sight.through(bounds));
        let places = passed.map(|(ray, depth, is_surface)| {
            let likely = if is_surface || sight.is_blind() { 1.0 } else { BEFORE };
            let stretch = if is_surface { DEPTHS } else { stretch(depth) };
            Place { ray, depth, stretch, weight: likely * share }
        });
        let places: Vec<Place> = places.collect();
        let shows = places.len() as f64 * share;
        let density = if shows > 0.0 { (covered / shows).min(1.0) } else { 0.0 };
        Self { spacing_m: wanted.spacing_m, places, density, least: LEAST * covered.min(1.0) }
    }
}

/// Which octave of metres a depth is in.
fn stretch(depth: f64) -> usize {
    (depth.max(1.0).log2() as usize).min(DEPTHS - 1)
}

/// What is there, in the course of taking one node after the other.
struct Course<'a> {
    error: Error<'a>,
    /// Between points, of each ray before the surface that it meets, and on it.
    spacings_m: Vec<[f64; DEPTHS + 1]>,
}

impl<'a> Course<'a> {
    /// Nothing is there.
    fn new(error: Error<'a>, sight: &Sight) -> Self {
        Self { error, spacings_m: vec![[f64::INFINITY; DEPTHS + 1]; sight.rays().len()] }
    }

    fn gain(&self, node: &Node) -> f64 {
        let of_place = |place: &Place| {
            let before_m = self.spacings_m[place.ray][place.stretch];
            let octaves = |spacing_m| self.error.octaves(place.depth, spacing_m);
            place.weight * (octaves(before_m) - octaves(node.spacing_m)).max(0.0)
        };
        node.density * node.places.iter().map(of_place).sum::<f64>() + node.least
    }

    fn take(&mut self, node: &Node) {
        if node.density < DENSE {
            return;
        }
        for place in &node.places {
            let spacing_m = &mut self.spacings_m[place.ray][place.stretch];
            *spacing_m = spacing_m.min(node.spacing_m);
        }
    }
}

/// What a picture lacks.
struct Error<'a> {
    view: &'a View,
    baseline_m: Option<f64>,
}

impl Error<'_> {
    /// Octaves that are wrong at a depth, with points so far apart there.
    fn octaves(&self, depth: f64, spacing_m: f64) -> f64 {
        let depth = depth.max(1.0);
        let density = self.view.pixels_a_metre(depth);
        let wrong = match self.baseline_m {
            Some(baseline_m) => {
                let parallax = baseline_m / (depth + baseline_m);
                let displaced_px = spacing_m.min(UNMEASURED_M) * density * parallax;
                0.5 * (2.0 * displaced_px).powi(2).ln_1p() / std::f64::consts::LN_2
            }
            None => (spacing_m * density).max(1.0).log2(),
        };
        wrong.min(FIRST_OCTAVES)
    }
}

/// A node that waits for its turn.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Gain a byte.
    rate: f64,
    gain: f64,
    index: usize,
}

impl Ord for Turn {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rate.total_cmp(&other.rate).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Turn {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Turn {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Turn {}

#[cfg(test)]
mod tests;
