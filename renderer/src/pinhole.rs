//! Ideal pinholes that cover what a distorted lens sees.
//!
//! Rasterising needs straight lines, so geometry is drawn into an ideal pinhole around the
//! lens's field of view; the lens's own pixels are then looked up in it.

use flaneur_scene::{Distortion, Lens};
use glam::{DVec2, UVec2};

/// Directions further than this from the axis (tangent; 80°) are left to other cameras: an
/// ideal pinhole spends nearly all of its pixels there. As in photograph.wgsl.
pub(crate) const MAX_TANGENT: f64 = 5.67;

/// Pixels around what a lens sees, on each side.
const MARGIN: f64 = 2.0;
/// By how much sides may exceed what is seen of a picture as wide: those of both sides, and one that is
/// begun.
const MARGINS: u32 = 5;

/// Samples a side for measuring what a lens sees.
const SAMPLES: u32 = 33;

/// A pinhole with its own focal lengths: `u = fx x/z + cx`, `v = fy y/z + cy`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pinhole {
    pub(crate) focal: DVec2,
    pub(crate) centre: DVec2,
    pub(crate) size: UVec2,
}

impl Pinhole {
    /// The pinhole whose pixels show what those of `lens` show: the lens itself where it has
    /// no distortion, else one around its field of view that is nowhere coarser, up to
    /// `max_side` and `max_pixels`. `None` for a lens that sees nothing.
    pub(crate) fn for_view(lens: &Lens, max_side: u32, max_pixels: u64) -> Option<Self> {
        let i = lens.intrinsics;
        let focal = DVec2::new(i.fx, i.fy);
        if lens.distortion == Distortion::None {
            return Some(Self { focal, centre: DVec2::new(i.cx, i.cy), size: lens.size });
        }
        let seen = Seen::by(lens)?;
        let wanted = (seen.max - seen.min) * focal * seen.magnification;
        let fits = (f64::from(max_side - MARGINS) / wanted.max_element())
            .min((max_pixels as f64 / (wanted.x * wanted.y)).sqrt() * 0.99)
            .min(1.0);
        Some(Self::around(&seen, focal * (seen.magnification * fits)))
    }

    /// The pinhole around the field of view of `lens` whose longer side has `side` pixels.
    /// `None` for a lens that sees nothing.
    pub(crate) fn for_depth_map(lens: &Lens, side: u32) -> Option<Self> {
        let seen = Seen::by(lens)?;
        let extent = seen.max - seen.min;
        let focal = f64::from(side.saturating_sub(MARGINS).max(1)) / extent.max_element();
        Some(Self::around(&seen, DVec2::splat(focal)))
    }

    fn around(seen: &Seen, focal: DVec2) -> Self {
        let size = ((seen.max - seen.min) * focal).ceil() + 2.0 * MARGIN;
        Self { focal, centre: MARGIN - seen.min * focal, size: size.as_uvec2() }
    }
}

/// What a lens sees, in normalised pinhole coordinates (x/z, y/z).
struct Seen {
    min: DVec2,
    max: DVec2,
    /// Largest ratio of the raw picture's scale to the ideal one's, 1 to 2.
    magnification: f64,
}

impl Seen {
    fn by(lens: &Lens) -> Option<Self> {
        let ray = |x: u32, y: u32| {
            let share = DVec2::new(f64::from(x), f64::from(y)) / f64::from(SAMPLES - 1);
            Some(lens.unproject(share * lens.size.as_dvec2())?.truncate())
        };
        let mut seen = Self { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY, magnification: 1.0 };
        let mut whole = true;
        let mut above: Vec<Option<DVec2>> = vec![None; SAMPLES as usize];
        let raw_step = lens.size.as_dvec2() / f64::from(SAMPLES - 1);
        let focal = DVec2::new(lens.intrinsics.fx, lens.intrinsics.fy);
        for y in 0..SAMPLES {
            let mut left: Option<DVec2> = None;
            for (x, above) in (0..SAMPLES).zip(&mut above) {
                let here = ray(x, y);
                whole &= here.is_some();
                if let Some(p) = here {
                    seen.min = seen.min.min(p);
                    seen.max = seen.max.max(p);
                    for (other, step) in [(left, raw_step.x), (*above, raw_step.y)] {
                        let ideal = other.map_or(0.0, |o| ((p - o) * focal).length());
                        if ideal > 0.0 {
                            seen.magnification = seen.magnification.max(step / ideal);
                        }
                    }
                }
                left = here;
                *above = here;
            }
        }
        if !whole {
            // The limit lies inside the picture, between samples: cover its whole circle.
            let (centre, radius) = limit_circle(lens);
            seen.min = seen.min.min(centre - radius);
            seen.max = seen.max.max(centre + radius);
        }
        seen.min = seen.min.max(DVec2::splat(-MAX_TANGENT));
        seen.max = seen.max.min(DVec2::splat(MAX_TANGENT));
        seen.magnification = seen.magnification.min(2.0);
        let extent = seen.max - seen.min;
        (extent.is_finite() && extent.min_element() > 0.0).then_some(seen)
    }
}

/// Centre and radius, normalised, within which the lens's model holds.
fn limit_circle(lens: &Lens) -> (DVec2, DVec2) {
    let limit = DVec2::splat(lens.distortion.limit());
    match lens.distortion {
        Distortion::RadialPixels { centre, .. } => {
            let i = lens.intrinsics;
            (i.normalised_from_pixel(centre), limit / DVec2::new(i.fx, i.fy))
        }
        _ => (DVec2::ZERO, limit),
    }
}

#[cfg(test)]
mod tests {
    use flaneur_scene::Intrinsics;

    use super::*;

    #[test]
    fn no_side_is_longer_than_the_device_allows() {
        let max_side = 2048;
        let mut tight = 0;
        for i in 0..2000u32 {
            let lens = Lens {
                size: UVec2::new(1500 + 7 * i % 549, 40 + i % 90),
                intrinsics: Intrinsics {
                    fx: 900.0 + f64::from(i) * 0.37,
                    fy: 901.0,
                    cx: 750.3 + f64::from(i % 31),
                    cy: 31.7,
                },
                distortion: Distortion::Brown {
                    k: [-0.1 - f64::from(i % 13) * 0.01, 0.02, 0.0],
                    p: [0.001, -0.0007],
                },
            };
            let pinhole = Pinhole::for_view(&lens, max_side, 1 << 30).expect("it sees something");
            assert!(pinhole.size.max_element() <= max_side, "{lens:?}: {}", pinhole.size);
            tight += u32::from(pinhole.size.max_element() + 2 >= max_side);
            let map = Pinhole::for_depth_map(&lens, 64 + i % 500).expect("it sees something");
            assert!(map.size.max_element() <= 64 + i % 500, "{lens:?}: {}", map.size);
        }
        assert!(tight > 100, "{tight}");
    }
}
