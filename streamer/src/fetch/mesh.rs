//! The base mesh around the eye.

use std::collections::BTreeSet;
use std::sync::{Arc, PoisonError};

use flaneur_scene::{
    Bounds2, Region, SceneUpdate, TileKey, extrude_footprints, triangulate_ground,
};

use super::{Fetch, Outlet};
use crate::StreamError;
use crate::choose::{FootprintGrid, wanted_tiles};

/// How far walls reach below their foot, metres: terrain falls away from a building's base by
/// less than that within its own length.
const SKIRT_M: f64 = 2.0;

impl Fetch {
    /// Emits the tiles that the receiver lacks, terrain first; gives all that are wanted.
    pub(super) async fn mesh(&self, outlet: &Outlet<'_>) -> Result<BTreeSet<TileKey>, StreamError> {
        let mut wanted = BTreeSet::new();
        if self.scene.ground.is_some() {
            wanted.append(&mut self.ground(outlet).await?);
        }
        if self.scene.footprints > 0 {
            wanted.append(&mut self.buildings(outlet).await?);
        }
        outlet.progress(0, false).await?;
        Ok(wanted)
    }

    async fn ground(&self, outlet: &Outlet<'_>) -> Result<BTreeSet<TileKey>, StreamError> {
        let centre = self.request.view.eye().truncate();
        let radius_m = self.request.limits.mesh_radius_m;
        let mut tiles = self.client.ground(Region::Disc { centre, radius_m }).await?;
        tiles.sort_by(|a, b| {
            let distance = |tile: &flaneur_scene::GroundTile| tile.bounds().distance(centre);
            distance(a).total_cmp(&distance(b)).then(a.index.cmp(&b.index))
        });
        tiles.dedup_by_key(|tile| tile.index);
        let mut wanted = BTreeSet::new();
        for tile in tiles {
            let what = format!("terrain tile {:?}", tile.index);
            let mesh =
                self.known.decoders.run(&what, move || Ok(triangulate_ground(&tile))).await?;
            wanted.insert(mesh.key);
            if !mesh.indices.is_empty() && !self.resident.tiles.contains(&mesh.key) {
                outlet.update(SceneUpdate::Mesh(Arc::new(mesh))).await?;
            }
        }
        Ok(wanted)
    }

    async fn buildings(&self, outlet: &Outlet<'_>) -> Result<BTreeSet<TileKey>, StreamError> {
        let centre = self.request.view.eye().truncate();
        let nearest_first =
            wanted_tiles(centre, self.request.limits.mesh_radius_m, &self.scene.bounds.plan());
        let wanted: BTreeSet<TileKey> = nearest_first.iter().copied().collect();
        let missing: BTreeSet<TileKey> = {
            let empty = self.known.empty_tiles.lock().unwrap_or_else(PoisonError::into_inner);
            wanted
                .difference(&self.resident.tiles)
                .filter(|k| !empty.contains(k))
                .copied()
                .collect()
        };
        let around = missing.iter().fold(Bounds2::EMPTY, |mut around, &key| {
            let bounds = FootprintGrid::bounds(key);
            around.include(bounds.min);
            around.include(bounds.max);
            around
        });
        if around.is_empty() {
            return Ok(wanted);
        }
        let footprints = self.client.footprints(Region::Box(around)).await?;
        let mut tiles = FootprintGrid::sort(footprints, &missing);
        for key in nearest_first {
            let Some(footprints) = tiles.remove(&key) else { continue };
            let origin = (FootprintGrid::bounds(key).min + 0.5 * FootprintGrid::TILE_M)
                .extend(self.scene.origin.z);
            let extrude = move || Ok(extrude_footprints(key, origin, &footprints, SKIRT_M));
            let mesh = self.known.decoders.run("footprints", extrude).await?;
            if mesh.indices.is_empty() {
                let empty = &self.known.empty_tiles;
                empty.lock().unwrap_or_else(PoisonError::into_inner).insert(key);
            } else {
                outlet.update(SceneUpdate::Mesh(Arc::new(mesh))).await?;
            }
        }
        Ok(wanted)
    }
}
