//! Where the two nearest rigs are to be looked up so that they agree.

use flaneur_scene::View;
use glam::{DVec2, DVec3, UVec2};

use super::field::Field;
use super::rigs::{MAX_SIDE, Moves, Rigs};
use super::surfaces::Pixel;
use crate::align::reference::{Level, displacements};
use crate::align::{self, ALONE, Shares};

/// The displacements between what the two nearest rigs show.
#[derive(Clone, Debug)]
pub(super) struct Aligned {
    pub(super) shares: Shares,
    /// Pixels a side of a cell.
    step: f64,
    /// In pixels of the view.
    pub(super) displacements: Field<DVec2>,
    /// Of the view, over its focal lengths in pixels: world axes.
    right: DVec3,
    down: DVec3,
}

impl Aligned {
    /// For what the pixels of a view show. `None` where there are no two rigs to align, or a third
    /// is as near as the second.
    pub(super) fn new(view: &View, rigs: &Rigs<'_>, shown: &Field<Pixel>) -> Option<Self> {
        let shares = Shares::new(&rigs.drawn_m()).filter(|shares| shares.applied > 0.0)?;
        let levels = levels(view, rigs, shown);
        let axes = view.camera.cam_from_world.transpose();
        let intrinsics = view.camera.lens.intrinsics;
        Some(Self {
            shares,
            step: levels.first()?.step,
            displacements: displacements(&levels, shares.nearest),
            right: axes.x_axis / intrinsics.fx,
            down: axes.y_axis / intrinsics.fy,
        })
    }

    /// How photographs are displaced at a pixel position, at what it shows in that depth, metres.
    pub(super) fn moves(&self, pixel: DVec2, depth_m: f64) -> Moves {
        let displacement = self.displacements.between(pixel / self.step);
        let offset = (self.right * displacement.x + self.down * displacement.y) * depth_m;
        let Shares { nearest, applied } = self.shares;
        Moves {
            offsets: [-nearest, 1.0 - nearest].map(|share| offset * (share * applied)),
            others: 1.0 - ALONE * applied,
        }
    }
}

/// What the two nearest rigs show of the cells of each level, finest first.
pub(super) fn levels(view: &View, rigs: &Rigs<'_>, shown: &Field<Pixel>) -> Vec<Level> {
    align::grids(view.size(), MAX_SIDE)
        .into_iter()
        .map(|grid| Level {
            step: grid.step.into(),
            sights: [0, 1].map(|rig| sights(view, rigs, shown, rig, grid.step, grid.cells)),
        })
        .collect()
}

/// How bright a rig shows what the pixels in the middle of cells show, at their size.
fn sights(
    view: &View,
    rigs: &Rigs<'_>,
    shown: &Field<Pixel>,
    rig: usize,
    step: u32,
    cells: UVec2,
) -> Field<Option<f64>> {
    Field::new(cells, |cell| {
        let pixel = (cell * step + step / 2).min(shown.size - 1);
        let met = shown.at(pixel).met?;
        let pixels_per_m = view.pixels_a_metre(met.shown.depth_m);
        let position = view.eye() + met.position;
        rigs.brightness(rig, position, &met.shown, pixels_per_m, step.into())
    })
}
