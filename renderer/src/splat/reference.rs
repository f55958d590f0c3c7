//! Discs on the planes of points, in f64.
//!
//! The disc of a point P, camera frame, eye at the origin, has radius r and lies in the plane
//! N · (X − P) = 0. A pixel at the normalised position m′ sees X = z (m′, 1), or in an
//! orthographic view X = (m′, z), and shows the disc where |X − P| ≤ r.
//!
//! N faces the eye, N = v with v the unit vector towards P, unless the point has a normal n. Then
//! with c = n · v it is `v + (n − c v) c / max(c², c₀²)`: along n where the plane is seen at more
//! than asin c₀ = 6°, the same for −n, and from there back to v where it is seen edge-on, which
//! two estimates of one plane would otherwise show from either side.
//!
//! The device does not intersect rays. With q = P / P_z, ρ = r / P_z, δ = m′ − m and
//! g = N_xy / (N · q), the plane is at z = P_z / (1 + s), s = g · δ, and X − P is
//! `P_z (δ − s q) / (1 + s)` in its plane, so that the disc is the conic
//! |δ|² − 2 s (m · δ) + s² |q|² ≤ ρ² (1 + s)², an ellipse for ρ < 1, whose box follows from the
//! inverse of its matrix. The tests hold this against the intersection here.

#[cfg(test)]
use glam::DVec2;
use glam::DVec3;

use super::MIN_RADIUS_PX;

/// Cosine below which a disc turns back towards the eye.
pub(crate) const LEAST_COSINE: f64 = 0.1;

/// A point in the camera's frame, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) position: DVec3,
    /// Zero where it has none.
    pub(crate) normal: DVec3,
    /// Of the disc that is drawn.
    pub(crate) radius_m: f64,
}

/// What a pixel shows: depth along the axis in metres, and which point.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    pub(crate) depth_m: f64,
    pub(crate) index: usize,
}

/// The radius in metres with which a point is drawn that is stored with `stored_m`: at least
/// what covers a pixel, at most what bounds the work, `largest_px` pixels, and half the depth.
/// `focal_px` is the smaller of the camera's two.
pub(crate) fn drawn_radius(stored_m: f64, p: DVec3, focal_px: f64, largest_px: f32) -> f64 {
    let pixel_m = p.z / focal_px;
    let off_axis = p.length() / p.z;
    stored_m
        .max(f64::from(MIN_RADIUS_PX) * pixel_m)
        .min(f64::from(largest_px) * pixel_m / off_axis)
        .min(0.5 * p.z)
}

/// The normal of a point's disc, of any length.
pub(crate) fn disc_normal(toward: DVec3, n: DVec3) -> DVec3 {
    let c = n.dot(toward);
    toward + (n - c * toward) * c / (c * c).max(LEAST_COSINE * LEAST_COSINE)
}

/// The same for an orthographic view, whose `focal_px` is in pixels a metre.
pub(crate) fn drawn_radius_without_perspective(
    stored_m: f64,
    focal_px: f64,
    largest_px: f32,
) -> f64 {
    stored_m.clamp(f64::from(MIN_RADIUS_PX) / focal_px, f64::from(largest_px) / focal_px)
}

/// Depth of a point's disc on the ray `z direction`; `None` off the disc.
#[cfg(test)]
pub(crate) fn disc_depth(point: &Point, direction: DVec3) -> Option<f64> {
    depth_along(point, point.position.normalize(), DVec3::ZERO, direction)
}

/// Depth of a point's disc on the ray `origin + z direction`, where the eye looks at the point
/// in the direction `toward`; `None` off the disc.
pub(crate) fn depth_along(
    point: &Point,
    toward: DVec3,
    origin: DVec3,
    direction: DVec3,
) -> Option<f64> {
    let n = disc_normal(toward, point.normal);
    let z = n.dot(point.position - origin) / n.dot(direction);
    let off = origin + direction * z - point.position;
    (z > 0.0 && off.length() <= point.radius_m).then_some(z)
}

/// The nearest disc at a pixel: lowest depth, then lowest index.
#[cfg(test)]
pub(crate) fn nearest(
    points: &[Point],
    focal: DVec2,
    centre: DVec2,
    pixel: DVec2,
) -> Option<Shown> {
    let direction = ((pixel - centre) / focal).extend(1.0);
    points
        .iter()
        .enumerate()
        .filter_map(|(index, point)| Some(Shown { depth_m: disc_depth(point, direction)?, index }))
        .min_by(|a, b| a.depth_m.total_cmp(&b.depth_m))
}
