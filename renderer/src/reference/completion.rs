//! Colours for what no photograph reaches, of pixels that are inferred or ground.

use flaneur_scene::View;
use glam::{DVec3, DVec4, UVec2};

use super::field::Field;
use super::rigs::MAX_SIDE;
use crate::complete;
use crate::complete::reference::{beside, completed};

/// The colours of pixels of one kind, spread over all cells of a grid.
#[derive(Clone, Debug)]
pub(super) struct Completion {
    /// Pixels a side of a cell.
    step: f64,
    colours: Field<DVec4>,
}

/// A colour, and how far it is to be relied upon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coloured {
    /// Linear.
    pub(super) colour: DVec3,
    /// See [`super::Pixel::doubt`].
    pub(super) doubt: f64,
}

/// The colours of surfaces, for the points beside.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    /// Pixels a side of a cell.
    step: f64,
    /// Linear, times the weights.
    colours: Field<DVec3>,
    weights: Field<f64>,
}

impl Beside {
    /// From the pixels of a view that show surfaces and are coloured, linear.
    pub(super) fn new(view: &View, surfaces: &Field<Option<DVec3>>) -> Option<Self> {
        let grid = complete::grid(view.size(), MAX_SIDE)?;
        let (colours, weights) = beside(surfaces, grid);
        Some(Self { step: grid.step.into(), colours, weights })
    }

    /// What a pixel has whose own colour is `own`; both are linear.
    pub(super) fn mixed(&self, pixel: UVec2, own: DVec3) -> DVec3 {
        let cell = (pixel.as_dvec2() + 0.5) / self.step;
        self.colours.between(cell) + (1.0 - self.weights.between(cell)) * own
    }
}

impl Completion {
    /// From the pixels of a view that are of the kind and coloured; `None` where there are none.
    pub(super) fn new(view: &View, of_kind: &Field<Option<Coloured>>) -> Option<Self> {
        let grid = complete::grid(view.size(), MAX_SIDE)?;
        // Doubts spread as colours do.
        let picture = of_kind.each(|pixel| pixel.map(|p| p.colour.extend(p.doubt)));
        Some(Self { step: grid.step.into(), colours: completed(&picture, grid)? })
    }

    /// What a pixel takes.
    pub(super) fn at(&self, pixel: UVec2) -> Coloured {
        let spread = self.colours.between((pixel.as_dvec2() + 0.5) / self.step);
        Coloured { colour: spread.truncate(), doubt: spread.w }
    }
}
