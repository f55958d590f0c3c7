//! Hashes and band-limited noise, the same on every machine.

use glam::{DVec2, IVec2};

/// A well-mixed hash (the finaliser of SplitMix64).
pub(crate) fn mix(a: u32, b: u32) -> u64 {
    let mut x = (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A number in 0..1 that `a` and `b` determine.
pub(crate) fn unit(a: u32, b: u32) -> f64 {
    (mix(a, b) >> 11) as f64 / (1u64 << 53) as f64
}

/// A number in 0..1 for a cell of the plane.
pub(crate) fn cell(at: IVec2, seed: u32) -> f64 {
    let row = mix(at.y as u32, seed);
    unit(at.x as u32, row as u32)
}

/// Smooth noise of wavelength about 1, in 0..1.
pub(crate) fn value(p: DVec2, seed: u32) -> f64 {
    let base = p.floor();
    let f = p - base;
    let w = f * f * (3.0 - 2.0 * f);
    let at = base.as_ivec2();
    let corner = |x: i32, y: i32| cell(at + IVec2::new(x, y), seed);
    let low = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * w.x;
    let high = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * w.x;
    low + (high - low) * w.y
}

/// Fractal noise in −1..1 (mostly within ±0.5): octaves from `wavelength_m` down, each of
/// half the wavelength and half the amplitude; those that a pixel of `footprint_m` cannot
/// resolve fade out, so that pictures do not sparkle.
pub(crate) fn fractal(
    p: DVec2,
    wavelength_m: f64,
    octaves: u32,
    footprint_m: f64,
    seed: u32,
) -> f64 {
    let (mut sum, mut amplitude, mut wavelength) = (0.0, 1.0, wavelength_m);
    for octave in 0..octaves {
        let resolved = fade(wavelength, footprint_m);
        if resolved <= 0.0 {
            break;
        }
        sum +=
            resolved * amplitude * (2.0 * value(p / wavelength, seed.wrapping_add(octave)) - 1.0);
        amplitude *= 0.5;
        wavelength *= 0.5;
    }
    0.5 * sum
}

/// How much of a pattern of `size_m` a pixel of `footprint_m` still shows: 1 where it is
/// resolved, 0 where it averages out.
pub(crate) fn fade(size_m: f64, footprint_m: f64) -> f64 {
    (2.0 - 2.0 * footprint_m / size_m).clamp(0.0, 1.0)
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
