#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate self as flaneur_renderer;

mod align;
mod bindings;
mod camera;
mod complete;
#[cfg(test)]
mod constant_tests;
mod depth_map;
mod depths;
mod diffuse;
mod enlarge;
mod error;
mod forward;
mod frame;
mod frame_budget;
mod frustum;
mod gains;
mod gpu;
mod history;
mod infer;
#[cfg(test)]
mod kernel_tests;
mod layers;
mod lens;
mod memory;
mod mesh;
mod octahedral;
mod photographs;
mod pick;
mod pinhole;
mod points;
pub mod reference;
mod renderer;
mod rest;
mod screen;
mod settings;
mod shade;
#[cfg(test)]
mod shader_tests;
mod splat;
mod stages;
mod surface;
mod targets;
mod tiles;
#[cfg(test)]
mod tolerances;

/// Colours as they are encoded, and linear, to be put before the shaders that turn one into the other.
pub(crate) const SRGB_WGSL: &str = include_str!("srgb.wgsl");

pub use error::RenderError;
pub use forward::memory::TexturingMemory;
pub use frame::{Frame, FrameStats, Surface};
pub use frame_budget::{BudgetStanding, FrameBudget};
pub use gpu::Gpu;
pub use memory::{Applied, MemoryReport};
pub use pick::{Picked, PickedSurface, Sight};
pub use renderer::Renderer;
pub use screen::screen_pipeline;
pub use settings::{Mode, Settings, SplatNormals, SplatRoute, Texturing};
pub use stages::PassTime;
