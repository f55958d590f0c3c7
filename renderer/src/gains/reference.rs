//! Whether two photographs see the same place, in f64.
//!
//! A depth map knows, texel by texel, the nearest mesh at `z_m ± δ_m` and the nearest point at
//! `z_p`. Its surface is the point where `z_p ≤ z_m + δ_m`, else the mesh. Unlike the test that
//! keeps photographs from colouring what is hidden, this one is of both sides: a place at depth z
//! agrees with a surface at `z_s ± δ_s` where `|z − z_s| ≤ 15 cm + 2 % z + δ_s`, which allows for
//! the inclination of a surface within a texel, for noise, and for discs that stand out of it.
//! What lies beside the edge of something is then not measured from either side.
//!
//! A place is taken where the surface a footprint's half to each of four sides lies within 20 % of
//! its depth.

use crate::depth_map::reference::Occluders;

/// Depth and uncertainty; `None` where nothing is known.
pub(crate) fn known_surface(texel: Occluders) -> Option<(f64, f64)> {
    let Occluders { mesh_m, mesh_uncertainty_m, point_m } = texel;
    if point_m.is_finite() && point_m <= mesh_m + mesh_uncertainty_m {
        Some((point_m, 0.0))
    } else {
        (mesh_m < crate::mesh::reference::NO_MESH_M).then_some((mesh_m, mesh_uncertainty_m))
    }
}

/// How much nearer z lies than the surface's limits of agreement, metres; negative where it does
/// not agree.
pub(crate) fn agreement(z: f64, (surface_m, uncertainty_m): (f64, f64)) -> f64 {
    0.15 + 0.02 * z + uncertainty_m - (z - surface_m).abs()
}

/// The same for whether a surface beside that at z is the same one.
pub(crate) fn continuity(z: f64, beside_m: f64) -> f64 {
    0.2 * z - (z - beside_m).abs()
}
