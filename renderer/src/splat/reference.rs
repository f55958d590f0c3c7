//! Discs that face the camera, in f64.

use glam::{DVec2, DVec3};

/// What a pixel shows: depth along the axis in metres, and which point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    pub(crate) depth_m: f64,
    pub(crate) index: usize,
    /// Distance of the hit from the disc's centre as a share of its radius.
    pub(crate) share: f64,
}

/// Depth of the disc around `p` (camera frame, radius in metres) on the ray of a pixel, and
/// how far from its centre the ray hits it as a share of the radius; `None` off the disc.
///
/// The disc lies in the plane through `p` with normal `p`: `t p·d = p·p` for the ray `t d`.
pub(crate) fn disc_depth(p: DVec3, radius_m: f64, ray: DVec3) -> Option<(f64, f64)> {
    let t = p.length_squared() / p.dot(ray);
    let share = (ray * t - p).length() / radius_m;
    (t > 0.0 && share <= 1.0).then_some((t, share))
}

/// The nearest disc at a pixel: lowest depth, then lowest index.
pub(crate) fn nearest(
    points: &[(DVec3, f64)],
    focal: DVec2,
    centre: DVec2,
    pixel: DVec2,
) -> Option<Nearest> {
    let ray = ((pixel - centre) / focal).extend(1.0);
    points
        .iter()
        .enumerate()
        .filter_map(|(index, &(p, radius_m))| {
            let (depth_m, share) = disc_depth(p, radius_m, ray)?;
            Some(Nearest { depth_m, index, share })
        })
        .min_by(|a, b| a.depth_m.total_cmp(&b.depth_m))
}
