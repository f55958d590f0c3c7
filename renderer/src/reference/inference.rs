//! Where pixels without geometry are taken to be.

use flaneur_scene::View;
use glam::{DVec3, UVec2};

use super::colour::What;
use super::field::Field;
use super::rigs::{MAX_SIDE, Rigs};
use super::surfaces::{Met, Pixel};
use crate::diffuse::reference::diffused;
use crate::infer::reference::{
    Gathered, LEAST_INVERSE, Looked, Past, chosen, chosen_between, disagreement, gathered,
    hypothesis, judged, median, window,
};
use crate::infer::{BACKDROP, Grid, LONE_BACKDROP_M, MAX_RIGS};
use crate::surface::reference::{RELIEF_M, Shown};

/// Where each cell of a picture that follows no other may be.
#[derive(Clone, Debug)]
pub(super) struct Hypotheses {
    pub(super) grid: Grid,
    pub(super) eye: DVec3,
    pub(super) gathered: Field<Gathered>,
    /// Inverse range of the backdrop, 1/m.
    backdrop: f64,
    /// Inverse ranges, 1/m, of what is known around a cell.
    pub(super) diffused: Field<f64>,
}

/// What a rig shows of the cells: brightness beyond that of the surroundings.
pub(super) type Sights = Field<Option<f64>>;

/// Where the cells are taken to be.
#[derive(Clone, Debug)]
pub(super) struct Inferred {
    step: f64,
    /// Inverse ranges, 1/m.
    pub(super) settled: Field<f64>,
    /// Between which they lie where costs are off.
    pub(super) bounds: [Field<f64>; 2],
}

impl Hypotheses {
    /// For what the pixels of a view show, of a scene whose geometry reaches `extent_m` from the eye,
    /// 0 without any, with so many hypotheses between the backdrop and the diffused depth.
    pub(super) fn new(
        view: &View,
        shown: &Field<Pixel>,
        extent_m: f64,
        between: u32,
    ) -> Option<Self> {
        let grid = Grid::new(view.size(), between, MAX_SIDE)?;
        let picture = Field::new(shown.size, |at| looked(&shown.at(at)));
        let gathered = Field::new(grid.cells, |cell| gathered(&picture, grid.step, cell));
        let range_m = if extent_m > 0.0 { extent_m } else { LONE_BACKDROP_M };
        let backdrop = 1.0 / (BACKDROP * range_m);
        let known = Field::new(grid.cells, |cell| gathered.at(cell).known);
        Some(Self {
            diffused: diffused(&known, backdrop),
            grid,
            eye: view.eye(),
            gathered,
            backdrop,
        })
    }

    /// What each of the rigs that are asked shows, hypothesis by hypothesis.
    pub(super) fn sights(&self, view: &View, rigs: &Rigs<'_>) -> Vec<Vec<Sights>> {
        let asked = rigs.drawn_m().len().min(MAX_RIGS as usize);
        let of = |index: u32, rig: usize| {
            Field::new(self.grid.cells, |cell| self.sight(view, rigs, index, rig, cell))
        };
        (0..self.grid.hypotheses)
            .map(|index| (0..asked).map(|rig| of(index, rig)).collect())
            .collect()
    }

    /// Which of them the photographs agree on, that show `sights`, and the picture before; and which
    /// they may agree on where the costs of two hypotheses differ by up to `noise` more or less.
    pub(super) fn inferred(
        &self,
        sights: &[Vec<Sights>],
        past: Option<&Past>,
        noise: f64,
    ) -> Inferred {
        let size = self.grid.cells;
        let costs = self.costs(sights);
        let choices = Field::new(size, |cell| {
            if self.is_known(cell) {
                return [f64::from(self.last()); 3];
            }
            let spacing = (self.inverse(1.0, cell) - self.inverse(0.0, cell)).abs();
            let judged: Vec<f64> = (0..)
                .zip(&costs)
                .map(|(i, costs)| {
                    let place = self.eye + self.place(i, cell);
                    let kept = past.map_or(0.0, |past| past.kept(place, spacing));
                    judged(costs.at(cell), i, self.last(), kept)
                })
                .collect();
            let [low, high] = chosen_between(&judged, noise);
            [chosen(&judged), low, high]
        });
        // Medians and means between cells grow with each of what they are of.
        let [settled, low, high] = [0, 1, 2].map(|which| {
            let choice = choices.each(|choices| choices[which]);
            Field::new(size, |cell| self.inverse(median(&choice, cell), cell))
        });
        Inferred { step: self.grid.step.into(), settled, bounds: [low, high] }
    }

    /// What the rigs disagree on each hypothesis, averaged over the windows of the cells.
    fn costs(&self, sights: &[Vec<Sights>]) -> Vec<Field<f64>> {
        let size = self.grid.cells;
        let of_hypothesis = |rigs: &Vec<Sights>| {
            let alone = Field::new(size, |cell| disagreement(rigs.iter().map(|rig| rig.at(cell))));
            Field::new(size, |cell| window(&alone, cell))
        };
        sights.iter().map(of_hypothesis).collect()
    }

    fn sight(
        &self,
        view: &View,
        rigs: &Rigs<'_>,
        index: u32,
        rig: usize,
        cell: UVec2,
    ) -> Option<f64> {
        let direction = self.gathered.at(cell).direction;
        if self.is_known(cell) || direction == DVec3::ZERO {
            return None;
        }
        let place = self.place(index, cell);
        let pixels_per_m = view.pixels_a_metre(view.camera.forward().dot(place));
        rigs.stands_out(rig, self.eye + place, pixels_per_m, self.grid.step.into())
    }

    /// Where a hypothesis of a cell is, relative to the eye.
    pub(super) fn place(&self, index: u32, cell: UVec2) -> DVec3 {
        let inverse = self.inverse(index.into(), cell).max(LEAST_INVERSE);
        self.gathered.at(cell).direction / inverse
    }

    /// Known cells are not judged.
    pub(super) fn is_known(&self, cell: UVec2) -> bool {
        self.gathered.at(cell).share > 0.5
    }

    /// Which hypothesis is the diffused depth.
    fn last(&self) -> u32 {
        self.grid.between + 1
    }

    fn inverse(&self, index: f64, cell: UVec2) -> f64 {
        hypothesis(index, self.last(), self.backdrop, self.diffused.at(cell))
    }
}

impl Inferred {
    /// What a pixel shows at a position, completed.
    pub(super) fn filled(&self, view: &View, at: UVec2, pixel: Pixel) -> Pixel {
        if pixel.met.is_some() || pixel.ray == DVec3::ZERO {
            return pixel;
        }
        let cell = (at.as_dvec2() + 0.5) / self.step;
        let direction = pixel.ray.normalize();
        let position = direction / self.settled.between(cell).max(LEAST_INVERSE);
        let shown = Shown {
            is_point: false,
            depth_m: view.camera.forward().dot(position),
            normal: -direction,
            relief_m: RELIEF_M,
        };
        Pixel { met: Some(Met { position, shown, what: What::Inferred }), ..pixel }
    }

    /// By which share the depth of a pixel may be another where costs are off.
    pub(super) fn doubt(&self, at: UVec2) -> f64 {
        let cell = (at.as_dvec2() + 0.5) / self.step;
        let [low, high] = self.bounds.each_ref().map(|bound| bound.between(cell));
        (high - low).abs() / self.settled.between(cell)
    }
}

fn looked(pixel: &Pixel) -> Option<Looked> {
    let range_m = pixel.met.map(|met| met.position.length());
    Some(Looked { direction: pixel.ray.try_normalize()?, range_m })
}
