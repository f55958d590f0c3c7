//! Colours for what no photograph reaches: for places that were inferred those of the inferred places
//! around, for the ground those of the ground around, and for points those of the surfaces beside.
//!
//! Between photographs, and above them, the sky has holes, and the road where the survey's vehicle always
//! stood in the way. On a coarse grid the colours of either are gathered and diffused; the picture shows them
//! where it has none of its own. Walls and roofs stay as they are: a house that nobody saw shows its shape. So do
//! points, but for those beside something that was seen: the rims of what hides things from photographs.
//!
//! Equations are in reference.rs.

use glam::{UVec2, Vec2};
use wgpu::util::DeviceExt as _;

use crate::diffuse::{DiffusePass, Layers, Levels};
use crate::infer::Grid;
use crate::screen::{ScreenPass, WHOLE_WGSL, screen_pass};
use crate::surface::PLACE_WGSL;
use crate::{Gpu, octahedral};

pub(crate) mod reference;
#[cfg(test)]
mod tests;

/// What every device can filter.
const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// What is inferred, the ground, and all surfaces, in the order of `Colours` in gather.wgsl.
const LAYERS: Layers = Layers { whole: 2, near: 1 };

/// The grid for a picture, of textures of at most `max_side`: colours need no finer one than twice
/// that of depths, and a quarter of its cells is a quarter of the time.
pub(crate) fn grid(picture: UVec2, max_side: u32) -> Option<Grid> {
    Grid::alone(picture, max_side).map(|grid| grid.coarser(1))
}

/// The shader that gathers the colours of cells.
pub(crate) fn gather_wgsl() -> String {
    [octahedral::WGSL, PLACE_WGSL, WHOLE_WGSL, include_str!("gather.wgsl")].concat()
}

/// The pipelines of this pass, and its textures.
#[derive(Debug)]
pub(crate) struct CompletePass {
    gather: ScreenPass,
    diffuse: DiffusePass,
    cells: Option<Cells>,
}

/// Colours over a grid.
#[derive(Debug)]
struct Cells {
    grid: Grid,
    levels: Levels,
}

/// A picture that is to be completed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'a> {
    /// See surface/place.wgsl.
    pub(crate) positions: &'a wgpu::TextureView,
    pub(crate) orientations: &'a wgpu::TextureView,
    /// Linear colours times their weight, and that.
    pub(crate) blended: &'a wgpu::TextureView,
}

/// Colours for what has none.
#[derive(Clone, Debug)]
pub(crate) struct Completion {
    /// Layers of linear colours of each cell, see [`LAYERS`]. Of what is inferred, and of the ground, with a 1, or
    /// 0 where there is no colour for any. Of all surfaces, times a weight of 0 to 1, and that: 1 in cells
    /// where some have a colour, less beside, 0 farther away.
    pub(crate) colours: wgpu::TextureView,
    /// Pixels that the cells cover, a little more than the picture.
    pub(crate) spanned: Vec2,
}

impl CompletePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            gather: screen_pass(
                gpu,
                "gather colours",
                &gather_wgsl(),
                &[COLOUR_FORMAT; LAYERS.count() as usize],
            ),
            diffuse: DiffusePass::new(gpu, COLOUR_FORMAT),
            cells: None,
        }
    }

    /// What [`CompletePass::bytes`] is once a picture was drawn on `grid`.
    pub(crate) fn bytes_for(grid: Grid) -> u64 {
        Levels::bytes_for(grid.cells, LAYERS, COLOUR_FORMAT)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.cells.as_ref().map_or(0, |cells| cells.levels.bytes())
    }

    /// Gives its textures back, but where they are those of `grid`.
    pub(crate) fn release_but(&mut self, grid: Option<Grid>) {
        self.cells.take_if(|cells| Some(cells.grid) != grid);
    }

    /// Colours for what of a picture is inferred, or ground, and has none; without a grid there are none.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        grid: Option<Grid>,
        shown: Shown<'_>,
    ) -> Completion {
        self.release_but(grid);
        let Some(grid) = grid else {
            // Something has to be bound: a cell of which nothing is known.
            let nothing = Levels::new(gpu, UVec2::ONE, LAYERS, COLOUR_FORMAT);
            return Completion { colours: nothing.diffused().clone(), spanned: Vec2::ONE };
        };
        let cells = self.cells.get_or_insert_with(|| {
            let levels = Levels::new(gpu, grid.cells, LAYERS, COLOUR_FORMAT);
            Cells { grid, levels }
        });
        let step = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("complete"),
            contents: bytemuck::bytes_of(&grid.step),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let bindings = vec![
            step.as_entire_binding(),
            wgpu::BindingResource::TextureView(shown.positions),
            wgpu::BindingResource::TextureView(shown.orientations),
            wgpu::BindingResource::TextureView(shown.blended),
        ];
        let gathered: Vec<_> = cells.levels.known_layers().iter().collect();
        self.gather.draw(gpu, encoder, bindings, &gathered);
        self.diffuse.draw(gpu, encoder, &cells.levels, [0.0; 3]);
        Completion {
            colours: cells.levels.diffused().clone(),
            spanned: (grid.cells * grid.step).as_vec2(),
        }
    }
}
