//! The G-buffer's planes, in f64.

#[cfg(test)]
use glam::DVec3;

/// Depth, metres, that stands for "no mesh here". Finite, so that sums with it stay finite.
pub(crate) const NO_MESH_M: f64 = 1e30;

/// Depth along the axis at which the ray of direction `ray` (depth 1) meets the plane
/// `n · p = d`, everything relative to the eye. `None` where it never does, in front.
#[cfg(test)]
pub(crate) fn plane_depth(n: DVec3, d: f64, ray: DVec3) -> Option<f64> {
    let depth = d / n.dot(ray);
    (depth.is_finite() && depth > 0.0).then_some(depth)
}
