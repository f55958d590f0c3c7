//! How high the ground is under someone's feet, as far as it has arrived.

use std::collections::HashMap;
use std::sync::Arc;

use flaneur_scene::{Bounds2, MeshTile, SceneUpdate, TileKey, TileLayer};
use glam::{DVec2, DVec3};

/// The tiles of terrain that the renderer holds.
#[derive(Debug, Default)]
pub(super) struct Ground {
    tiles: HashMap<TileKey, Tile>,
}

#[derive(Debug)]
struct Tile {
    bounds: Bounds2,
    mesh: Arc<MeshTile>,
}

impl Ground {
    /// Takes note of what the renderer is given, or gives up.
    pub(super) fn note(&mut self, update: &SceneUpdate) {
        match update {
            SceneUpdate::Mesh(mesh) if mesh.key.layer == TileLayer::Ground => {
                let mut bounds = Bounds2::EMPTY;
                for vertex in &mesh.vertices {
                    bounds.include((mesh.origin + position(vertex.position)).truncate());
                }
                self.tiles.insert(mesh.key, Tile { bounds, mesh: Arc::clone(mesh) });
            }
            SceneUpdate::DropMesh(key) => drop(self.tiles.remove(key)),
            _ => {}
        }
    }

    /// Height of the ground at a place, world, metres; the highest where there are several.
    pub(super) fn height(&self, place: DVec2) -> Option<f64> {
        let over = self.tiles.values().filter(|tile| tile.bounds.distance(place) <= 0.0);
        over.filter_map(|tile| height_of(&tile.mesh, place)).reduce(f64::max)
    }
}

fn position(vertex: [f32; 3]) -> DVec3 {
    DVec3::from_array(vertex.map(f64::from))
}

/// Height of the mesh above `place`.
fn height_of(mesh: &MeshTile, place: DVec2) -> Option<f64> {
    let place = place - mesh.origin.truncate();
    let heights = mesh.indices.as_chunks::<3>().0.iter().filter_map(|triangle| {
        let mut corners = [DVec3::ZERO; 3];
        for (corner, &index) in corners.iter_mut().zip(triangle) {
            *corner = position(mesh.vertices.get(index as usize)?.position);
        }
        on_triangle(corners, place)
    });
    Some(mesh.origin.z + heights.reduce(f64::max)?)
}

/// Height of a triangle at a place of the plan; `None` beside it and where it stands upright.
fn on_triangle([a, b, c]: [DVec3; 3], place: DVec2) -> Option<f64> {
    let (ab, ac) = ((b - a).truncate(), (c - a).truncate());
    let way = place - a.truncate();
    let area = ab.perp_dot(ac);
    if area.abs() < 1e-12 {
        return None;
    }
    let (u, v) = (way.perp_dot(ac) / area, ab.perp_dot(way) / area);
    // Neighbours share their edges: what lies on one belongs to both.
    let inside = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
    inside.then_some(a.z + u * (b.z - a.z) + v * (c.z - a.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::{GroundTile, triangulate_ground};

    #[test]
    fn the_ground_is_as_high_as_its_grid_says() {
        let origin = DVec2::new(651_000.0, 6_861_000.0);
        let height = |p: DVec2| 35.0 + 0.1 * p.x - 0.05 * p.y;
        let (columns, spacing_m) = (5, 2.0);
        let node = |index: usize| DVec2::new((index % 5) as f64, (index / 5) as f64) * spacing_m;
        let tile = GroundTile {
            index: (0, 0),
            origin,
            spacing_m,
            columns,
            heights: (0..20).map(|index| height(node(index)) as f32).collect(),
            uncertainty_m: 0.1,
        };
        let mesh = Arc::new(triangulate_ground(&tile));
        let mut ground = Ground::default();
        ground.note(&SceneUpdate::Mesh(Arc::clone(&mesh)));
        for place in [DVec2::new(0.0, 0.0), DVec2::new(3.3, 4.1), DVec2::new(8.0, 6.0)] {
            let found = ground.height(origin + place).expect("on the tile");
            assert!((found - height(place)).abs() < 1e-4, "{place}: {found}");
        }
        assert_eq!(ground.height(origin + DVec2::new(8.1, 1.0)), None);
        assert_eq!(ground.height(DVec2::NAN), None);
        ground.note(&SceneUpdate::DropMesh(mesh.key));
        assert_eq!(ground.height(origin + 1.0), None);
    }
}
