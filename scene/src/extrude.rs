//! From footprints and terrain to triangles.

mod bridge;

use glam::{DVec2, DVec3};

use bridge::one_ring;

use crate::{
    Footprint, GroundTile, MeshTile, MeshVertex, Polygon, SurfaceClass, TileKey, TileLayer,
};

/// The walls and flat roofs of `footprints`, as one tile.
///
/// Walls reach `skirt_m` below each base, so that no gap opens over falling ground. Rings may
/// wind either way; normals point out of the building. Polygons without area, and those with a
/// coordinate that is no number, give no triangles; a building of height 0 is a slab at its base.
pub fn extrude_footprints(
    key: TileKey,
    origin: DVec3,
    footprints: &[Footprint],
    skirt_m: f64,
) -> MeshTile {
    let mut tile = MeshTile { key, origin, vertices: Vec::new(), indices: Vec::new() };
    for footprint in footprints {
        let foot = footprint.base_m - skirt_m;
        let top = footprint.base_m + footprint.height_m;
        let delta = footprint.uncertainty_m as f32;
        let numbers = foot.is_finite() && top.is_finite() && delta.is_finite();
        for polygon in footprint.polygons.iter().filter(|polygon| numbers && has_area(polygon)) {
            for (index, ring) in polygon.rings.iter().enumerate() {
                // The outer ring runs counter-clockwise and holes clockwise when the
                // building is on the left of every edge.
                let reversed = (signed_area(ring) < 0.0) == (index == 0);
                walls(&mut tile, ring, reversed, foot, top, delta);
            }
            roof(&mut tile, polygon, top, delta);
        }
    }
    tile
}

/// The terrain of `tile` as triangles; cells with an unknown corner are left out.
pub fn triangulate_ground(tile: &GroundTile) -> MeshTile {
    let base = tile.heights.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    let origin = tile.origin.extend(f64::from(base));
    let key = TileKey { layer: TileLayer::Ground, x: tile.index.0, y: tile.index.1 };
    let mut mesh = MeshTile { key, origin, vertices: Vec::new(), indices: Vec::new() };
    let (columns, rows) = (tile.columns as usize, tile.rows() as usize);
    let at = |c: usize, r: usize| {
        let height = tile.heights[r * columns + c];
        height.is_finite().then(|| {
            DVec3::new(
                tile.origin.x + c as f64 * tile.spacing_m,
                tile.origin.y + r as f64 * tile.spacing_m,
                f64::from(height),
            )
        })
    };
    for r in 1..rows {
        for c in 1..columns {
            let corners = (at(c - 1, r - 1), at(c, r - 1), at(c, r), at(c - 1, r));
            if let (Some(sw), Some(se), Some(ne), Some(nw)) = corners {
                let delta = tile.uncertainty_m as f32;
                push_triangle(&mut mesh, [sw, se, ne], SurfaceClass::Ground, delta);
                push_triangle(&mut mesh, [sw, ne, nw], SurfaceClass::Ground, delta);
            }
        }
    }
    mesh
}

fn walls(tile: &mut MeshTile, ring: &[DVec2], reversed: bool, foot: f64, top: f64, delta: f32) {
    for i in 0..ring.len() {
        let (mut a, mut b) = (ring[i], ring[(i + 1) % ring.len()]);
        if reversed {
            (a, b) = (b, a);
        }
        if a == b || top <= foot {
            continue;
        }
        let (a0, b0, b1, a1) = (a.extend(foot), b.extend(foot), b.extend(top), a.extend(top));
        push_triangle(tile, [a0, b0, b1], SurfaceClass::Wall, delta);
        push_triangle(tile, [a0, b1, a1], SurfaceClass::Wall, delta);
    }
}

fn roof(tile: &mut MeshTile, polygon: &Polygon, top: f64, delta: f32) {
    let Some(&first) = polygon.rings.first().and_then(|ring| ring.first()) else { return };
    let outline = one_ring(polygon, first);
    let flat: Vec<f64> = outline.iter().flat_map(|p| p.to_array()).collect();
    // Without holes: where holes cross other rings, earcut's own way of joining them may never
    // end.
    let Ok(triangles) = earcutr::earcut(&flat, &[], 2) else { return };
    let vertex = |i: usize| (outline[i] + first).extend(top);
    for t in triangles.chunks_exact(3) {
        let corners = [vertex(t[0]), vertex(t[1]), vertex(t[2])];
        let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
        let corners = if up < 0.0 { [corners[0], corners[2], corners[1]] } else { corners };
        push_triangle(tile, corners, SurfaceClass::Roof, delta);
    }
}

fn push_triangle(
    tile: &mut MeshTile,
    corners: [DVec3; 3],
    class: SurfaceClass,
    uncertainty_m: f32,
) {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let Some(normal) = normal.try_normalize() else { return };
    for corner in corners {
        tile.indices
            .push(u32::try_from(tile.vertices.len()).expect("a tile has fewer than 2^32 vertices"));
        tile.vertices.push(MeshVertex {
            position: (corner - tile.origin).as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            uncertainty_m,
            class,
        });
    }
}

/// Whether a polygon can be extruded: its coordinates are numbers and its outer ring has an area.
fn has_area(polygon: &Polygon) -> bool {
    let finite = polygon.rings.iter().flatten().all(|vertex| vertex.is_finite());
    finite && polygon.rings.first().is_some_and(|ring| signed_area(ring).abs() > 0.0)
}

/// Twice the signed area of a ring, positive counter-clockwise, relative to its first vertex.
fn signed_area(ring: &[DVec2]) -> f64 {
    let Some(&first) = ring.first() else { return 0.0 };
    (0..ring.len()).map(|i| (ring[i] - first).perp_dot(ring[(i + 1) % ring.len()] - first)).sum()
}

#[cfg(test)]
mod tests;
