//! The hybrid rule, in f64.
//!
//! The mesh is uncertain by δ, points by centimetres, so the mesh occludes from its far surface:
//! of the nearest mesh at depth `z_m` and the nearest disc at `z_p` on a ray, the disc is shown
//! where `z_p ≤ z_m + δ`.
//!
//! A disc says where a surface is better than how it is inclined. Where its point P lies within
//! δ of the mesh's plane, or within 15 cm of it however certain the mesh is, it is that surface,
//! better known: it takes the mesh's normal N, and the depth of the plane through P,
//! `N · (P − C) / N · ray`. Where that plane is seen so nearly edge-on that it leaves the disc by
//! more than a fifth to a quarter of its depth, the disc stays as it is.

use glam::DVec3;

/// Where a ray meets the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshHit {
    /// Depth along the axis, metres.
    pub(crate) depth_m: f64,
    /// Unit, towards the eye, world axes.
    pub(crate) normal: DVec3,
    /// The δ of the rule, metres.
    pub(crate) uncertainty_m: f64,
}

/// Where a ray meets a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiscHit {
    /// Depth along the axis, metres.
    pub(crate) depth_m: f64,
    /// The point, relative to the eye, world axes.
    pub(crate) point: DVec3,
    /// Of the disc: unit, world axes.
    pub(crate) normal: DVec3,
    /// Whether that is the surface's own, rather than the direction of the eye.
    pub(crate) has_normal: bool,
}

/// What a ray shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    pub(crate) is_point: bool,
    /// Depth along the axis, metres.
    pub(crate) depth_m: f64,
    pub(crate) normal: DVec3,
    /// How far points of the same surface may stand out of its plane, metres.
    pub(crate) relief_m: f64,
}

/// Physical allowance, metres: how far points of one surface stand out of its plane. Discs of a
/// decimetre do not lie in it, plaster and kerbs are no planes, and drives differ by as much where they
/// agree. Kept apart from the bias of the depth test, see `depth_map/reference.rs`.
pub(crate) const RELIEF_M: f64 = 0.1;
/// Physical allowance, metres: points this near to a mesh are its surface however certain the mesh is.
/// A kerb is 12 to 15 cm high, and a grid of terrain does not follow it, nor the waves of a road.
pub(crate) const SAME_SURFACE_M: f64 = 0.15;

/// What the ray `origin + t direction` shows, relative to the eye, of depth 1 at `t = 1`.
pub(crate) fn shown(
    origin: DVec3,
    direction: DVec3,
    mesh: Option<MeshHit>,
    disc: Option<DiscHit>,
) -> Option<Shown> {
    let Some(disc) =
        disc.filter(|disc| mesh.is_none_or(|m| disc.depth_m <= m.depth_m + m.uncertainty_m))
    else {
        return mesh.map(|mesh| Shown {
            is_point: false,
            depth_m: mesh.depth_m,
            normal: mesh.normal,
            relief_m: mesh.uncertainty_m.max(RELIEF_M),
        });
    };
    let relief_m = if disc.has_normal { RELIEF_M } else { 0.0 };
    let as_it_is = Shown { is_point: true, depth_m: disc.depth_m, normal: disc.normal, relief_m };
    let Some(mesh) = mesh else { return Some(as_it_is) };
    let n = mesh.normal;
    let off_plane = n.dot(disc.point - (origin + direction * mesh.depth_m)).abs();
    let inclined = n.dot(disc.point - origin) / n.dot(direction);
    let near_disc = inclined > 0.8 * disc.depth_m && inclined < 1.25 * disc.depth_m;
    if off_plane <= mesh.uncertainty_m.max(SAME_SURFACE_M) && near_disc {
        return Some(Shown { is_point: true, depth_m: inclined, normal: n, relief_m: RELIEF_M });
    }
    Some(as_it_is)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: DVec3 = DVec3::Z;

    fn wall(depth_m: f64, uncertainty_m: f64) -> MeshHit {
        MeshHit { depth_m, normal: DVec3::new(0.6, 0.0, -0.8), uncertainty_m }
    }

    fn disc(depth_m: f64) -> DiscHit {
        DiscHit { depth_m, point: AHEAD * depth_m, normal: -AHEAD, has_normal: false }
    }

    #[test]
    fn the_mesh_occludes_from_its_far_surface() {
        let at = |z| shown(DVec3::ZERO, AHEAD, Some(wall(10.0, 0.5)), Some(disc(z)));
        assert!(at(10.4).is_some_and(|s| s.is_point && s.depth_m == 10.4));
        assert!(at(10.6).is_some_and(|s| !s.is_point && s.depth_m == 10.0));
        assert_eq!(shown(DVec3::ZERO, AHEAD, None, None), None);
    }

    #[test]
    fn a_point_of_the_wall_is_inclined_as_the_wall_is() {
        let mesh = wall(10.0, 0.0);
        // Beside the ray, on the wall's plane: the ray meets that plane where the wall is.
        let point = DVec3::new(0.04, 0.0, 10.03);
        let hit = DiscHit { depth_m: 10.03, point, normal: -AHEAD, has_normal: false };
        // Exactly certain meshes occlude from where they are.
        assert!(shown(DVec3::ZERO, AHEAD, Some(mesh), Some(hit)).is_some_and(|s| !s.is_point));
        let mesh = wall(10.0, 0.2);
        let found = shown(DVec3::ZERO, AHEAD, Some(mesh), Some(hit)).expect("a surface");
        assert!(found.is_point && (found.depth_m - 10.0).abs() < 1e-12, "{found:?}");
        assert_eq!((found.normal, found.relief_m), (mesh.normal, RELIEF_M));
        // A car before it is not.
        let car = shown(DVec3::ZERO, AHEAD, Some(mesh), Some(disc(8.0))).expect("a surface");
        assert_eq!((car.depth_m, car.normal, car.relief_m), (8.0, -AHEAD, 0.0));
    }
}
