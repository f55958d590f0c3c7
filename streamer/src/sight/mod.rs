//! What a view sees, as far as mesh tells: a few hundred rays, and where each meets something.
//!
//! It decides what comes first, and nothing else: mesh lacks cars and trees, and what it hides may show all the
//! same.

mod surface;

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{Bounds3, MeshTile, Ray, SceneUpdate, TileKey, View};
use glam::{DVec2, UVec2};

use surface::{Surface, within};

/// Rays of a view, along x and y.
const GRID: UVec2 = UVec2::new(24, 12);
/// What stands so near behind or before a surface may show, metres.
const MARGIN_M: f64 = 1.0;

/// The mesh that the receiver holds.
#[derive(Debug, Default)]
pub(crate) struct Surfaces {
    tiles: BTreeMap<TileKey, Surface>,
}

impl Surfaces {
    /// Takes note of what the receiver is told.
    pub(crate) fn note(&mut self, update: &SceneUpdate) {
        match update {
            SceneUpdate::Mesh(tile) => self.insert(tile),
            SceneUpdate::DropMesh(key) => _ = self.tiles.remove(key),
            _ => {}
        }
    }

    fn insert(&mut self, tile: &Arc<MeshTile>) {
        self.tiles.remove(&tile.key);
        self.tiles.extend(Surface::of(tile).map(|surface| (tile.key, surface)));
    }

    /// What `view` sees of it.
    pub(crate) fn sight(&self, view: &View) -> Sight {
        let cells = (0..GRID.y).flat_map(|y| (0..GRID.x).map(move |x| (x, y)));
        let places = cells.map(|(x, y)| {
            let cell = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            cell / GRID.as_dvec2() * view.size().as_dvec2()
        });
        let rays = places.filter_map(|pixel| view.ray(pixel)).map(|ray| (ray, self.meets(&ray)));
        Sight { rays: rays.collect(), is_blind: self.tiles.is_empty() }
    }

    /// The depth at which a ray first meets something.
    fn meets(&self, ray: &Ray) -> Option<f64> {
        let mut tiles: Vec<(f64, &Surface)> =
            self.tiles.values().filter_map(|tile| Some((tile.entered(ray)?, tile))).collect();
        tiles.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut nearest = None;
        for (from, tile) in tiles {
            let most = nearest.unwrap_or(f64::INFINITY);
            if from > most {
                break;
            }
            nearest = tile.meets(ray, most).or(nearest);
        }
        nearest
    }
}

/// Rays of a view.
#[derive(Debug)]
pub(crate) struct Sight {
    rays: Vec<(Ray, Option<f64>)>,
    is_blind: bool,
}

impl Sight {
    /// Whether nothing at all is known of what there is.
    pub(crate) fn is_blind(&self) -> bool {
        self.is_blind
    }

    /// The rays, evenly over the picture, each with the depth at which it meets something.
    pub(crate) fn rays(&self) -> &[(Ray, Option<f64>)] {
        &self.rays
    }

    /// The rays along which something within `bounds` may show: the index of each, the depth there, and whether
    /// that is where it meets something rather than before.
    pub(crate) fn through(&self, bounds: Bounds3) -> impl Iterator<Item = (usize, f64, bool)> {
        self.rays.iter().enumerate().filter_map(move |(index, (ray, depth))| {
            let (from, to) = within(&bounds, ray)?;
            match *depth {
                Some(depth) if depth + MARGIN_M < from => None,
                Some(depth) if depth - MARGIN_M <= to => Some((index, depth, true)),
                _ => Some((index, 0.5 * (from + to.min(depth.unwrap_or(to))), false)),
            }
        })
    }
}

#[cfg(test)]
mod tests;
