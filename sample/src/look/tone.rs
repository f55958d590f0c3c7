//! From radiance to the numbers of an image file.

use flaneur_scene::srgb_from_linear;
use glam::DVec3;

/// Radiance times this is what the curve takes.
const EXPOSURE: f64 = 1.55;

/// sRGB values in 0..1 of a linear radiance: a soft shoulder, then the sRGB transfer
/// function.
pub(crate) fn display(radiance: DVec3) -> DVec3 {
    // Linear in the shadows, 1 − e^−x above: highlights roll off without clipping hard.
    (radiance * EXPOSURE).map(|x| srgb_from_linear(shoulder(x.max(0.0))))
}

fn shoulder(x: f64) -> f64 {
    const KNEE: f64 = 0.55;
    if x < KNEE { x } else { KNEE + (1.0 - KNEE) * (1.0 - (-(x - KNEE) / (1.0 - KNEE)).exp()) }
}
