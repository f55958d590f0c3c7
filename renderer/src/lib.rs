//! Scene updates and a view in, a frame out, on wgpu.
//!
//! The renderer knows no network and no file format. It holds meshes, points and photographs
//! ([`Renderer::apply`]) and renders the view of any camera by projecting the photographs onto
//! both kinds of geometry ([`Renderer::render`]).
//!
//! # Frames and precision
//!
//! The world is f64; every pass works in f32 relative to its own camera's centre, with axes
//! of the world, and the difference between chunk origin and that centre is taken in f64.
//! Depths are metres along the camera axis.
//!
//! # Layout
//!
//! Each pass is a folder with its host side, its shaders, an f64 reference, and tests that
//! compare the two.

mod camera;
mod depth_map;
mod error;
mod frame;
mod frustum;
mod gpu;
#[cfg(test)]
mod kernel_tests;
mod lens;
mod mesh;
mod photographs;
mod pinhole;
mod points;
mod renderer;
mod settings;
mod shade;
#[cfg(test)]
mod shader_tests;
mod splat;
mod targets;
#[cfg(test)]
mod tolerances;

pub use error::RenderError;
pub use frame::{Frame, FrameStats, Surface};
pub use gpu::Gpu;
pub use renderer::Renderer;
pub use settings::Settings;
