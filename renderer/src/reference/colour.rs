//! From what a pixel shows to its colour, by mode.

use flaneur_scene::{SurfaceClass, srgb_from_linear};
use glam::DVec3;

use super::rigs::Blend;
use crate::Mode;
use crate::depth_map::reference::POINT_NOISE_M;

/// What a pixel shows, as far as its colour goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    /// Along the axis, metres.
    pub(super) depth_m: f64,
    /// Unit, towards the eye, world axes.
    pub(super) normal: DVec3,
    pub(super) what: What,
    pub(super) blend: Option<Blend>,
}

/// Whose surface it is.
#[derive(Clone, Copy, Debug)]
pub(super) enum What {
    Mesh {
        uncertainty_m: f64,
        class: SurfaceClass,
    },
    Point {
        colour: Option<[u8; 3]>,
    },
    /// No geometry: where the photographs agree.
    Inferred,
    /// Neither geometry nor a photograph: the colours around.
    Completed,
}

/// The colour of a pixel, sRGB, 0 to 1.
pub(super) fn colour(pixel: &Pixel, mode: Mode) -> DVec3 {
    let blended = |linear: DVec3| linear.map(srgb_from_linear).min(DVec3::ONE);
    match (mode, &pixel.blend) {
        (Mode::Depth, _) => DVec3::splat(10.0 / (10.0 + pixel.depth_m)),
        (Mode::Normals, _) => 0.5 + 0.5 * pixel.normal,
        (Mode::Uncertainty, _) if matches!(pixel.what, What::Inferred) => DVec3::new(0.8, 0.1, 0.8),
        (Mode::Uncertainty, _) if matches!(pixel.what, What::Completed) => {
            DVec3::new(0.4, 0.05, 0.4)
        }
        (Mode::Uncertainty, blend) => {
            let metres = match pixel.what {
                What::Mesh { uncertainty_m, .. } => uncertainty_m,
                What::Point { .. } | What::Inferred | What::Completed => POINT_NOISE_M,
            };
            // A tenth of a metre in the middle, a factor of ten to either end.
            let t = (0.5 + 0.5 * (metres.max(0.01) / 0.1).log10()).clamp(0.0, 1.0);
            let ramp = DVec3::new((2.0 * t).min(1.0), (2.0 - 2.0 * t).min(1.0), 0.1);
            ramp * if blend.is_some() { 0.9 } else { 0.45 }
        }
        (Mode::Sources, Some(blend)) => blended(blend.mark),
        (Mode::Hybrid | Mode::Mesh | Mode::Points, Some(blend)) => blended(blend.colour),
        _ => own_colour(pixel),
    }
}

/// A point's own colour, else a grey of its class lit from above.
fn own_colour(pixel: &Pixel) -> DVec3 {
    let lit = 0.65 + 0.35 * pixel.normal.dot(DVec3::new(0.35, 0.2, 0.9).normalize());
    match pixel.what {
        What::Point { colour: Some(bytes) } => {
            DVec3::from_array(bytes.map(|byte| f64::from(byte) / 255.0))
        }
        What::Point { colour: None } | What::Inferred | What::Completed => DVec3::splat(0.55) * lit,
        What::Mesh { class, .. } => {
            lit * match class {
                SurfaceClass::Ground => DVec3::new(0.50, 0.50, 0.48),
                SurfaceClass::Wall => DVec3::new(0.66, 0.65, 0.62),
                SurfaceClass::Roof => DVec3::new(0.60, 0.56, 0.54),
            }
        }
    }
}
