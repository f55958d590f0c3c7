//! What surfaces look like: materials, light, and the colour that a ray brings back.
//!
//! Radiance is linear RGB, relative: a white surface in full sun and skylight is about 1.

mod ground;
mod light;
mod material;
pub(crate) mod noise;
mod pane;
mod shade;
mod sky;
mod tone;
mod wall;

pub(crate) use light::Light;
pub(crate) use material::Material;
pub(crate) use shade::Shader;
pub(crate) use tone::display;
