//! The base mesh: which tiles, how coarse, and which footprint belongs to which.

use std::collections::BTreeSet;

use flaneur_scene::{Bounds2, Bounds3, Footprint, SceneInfo, TileKey, TileLayer};
use glam::DVec2;

use super::cone::ViewCone;
use crate::ViewRequest;

/// Nodes of the terrain may appear this far apart, pixels. Terrain leaves the plane between them by
/// a few hundredths of that: about a pixel. Half of it takes a fifth to two thirds more triangles, and changes the picture
/// of a street by 0.2 of 255 (RMS).
const GROUND_SPACING_PX: f64 = 48.0;
/// Of the nodes of a tile of terrain every so many at least are wanted.
const MAX_STEP: u32 = 8;
/// Nodes along a tile of terrain, the last one its neighbour's. What is finer or coarser than the
/// store has is not asked for.
const GROUND_CELLS: f64 = 64.0;

/// Most tiles of terrain along a view's reach: what a scene says of itself may be anything.
const MOST_TILES: f64 = 256.0;

/// A tile of mesh that a view wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TileChoice {
    /// Which.
    pub(crate) key: TileKey,
    /// Of terrain, every so many nodes; 1 for buildings.
    pub(crate) step: u32,
    /// From the eye, in the plan, metres.
    pub(crate) distance_m: f64,
    /// Whether the view may see something of it.
    pub(crate) seen: bool,
}

/// The tiles of terrain and buildings that a view wants, nearest first. Those that are `held` stay up to
/// [`ViewRequest::steadiness`] times as far away.
pub(crate) fn choose_tiles(
    scene: &SceneInfo,
    request: &ViewRequest,
    held: &BTreeSet<TileKey>,
) -> Vec<TileChoice> {
    let eye = request.view.eye().truncate();
    let radius_m = request.limits.mesh_radius_m;
    let farthest_m = radius_m * request.steadiness;
    let cone = ViewCone::new(&request.view);
    let choice = |key, bounds: Bounds2, spacing_m: Option<f64>| {
        let distance_m = bounds.distance(eye);
        let tall = Bounds3 {
            min: bounds.min.extend(scene.bounds.min.z),
            max: bounds.max.extend(scene.bounds.max.z),
        };
        let density = request.view.pixels_a_metre(distance_m.max(1.0));
        let fits = |step: u32| {
            spacing_m.is_some_and(|m| f64::from(step) * m * density <= GROUND_SPACING_PX)
        };
        let mut step = 1;
        while step < MAX_STEP && fits(2 * step) {
            step *= 2;
        }
        TileChoice { key, step, distance_m, seen: cone.meets(&tall) }
    };
    let mut tiles = Vec::new();
    if let Some(layout) = &scene.ground {
        let reach_m = farthest_m.min(0.5 * MOST_TILES * layout.tile_m);
        let disc = Bounds2 { min: eye - reach_m, max: eye + reach_m };
        tiles.extend(layout.tiles(&disc).map(|(x, y)| {
            let key = TileKey { layer: TileLayer::Ground, x, y };
            choice(key, layout.bounds((x, y)), Some(layout.tile_m / GROUND_CELLS))
        }));
    }
    if scene.footprints > 0 {
        let keys = wanted_tiles(eye, farthest_m, &scene.bounds.plan()).into_iter();
        tiles.extend(keys.map(|key| choice(key, FootprintGrid::bounds(key), None)));
    }
    tiles.retain(|tile| {
        let reach_m = if held.contains(&tile.key) { farthest_m } else { radius_m };
        tile.distance_m <= reach_m
    });
    tiles.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m).then(a.key.cmp(&b.key)));
    tiles
}

/// The grid in which footprints become tiles of mesh, aligned with the world. A footprint
/// belongs to the tile that holds the middle of its rectangle, so a tile is the same
/// whichever view asks for it.
pub(crate) struct FootprintGrid;

impl FootprintGrid {
    /// Length of a tile's side, metres.
    pub(crate) const TILE_M: f64 = 64.0;

    /// The tile that `footprint` belongs to; `None` where it has no vertices, or lies where no
    /// projected CRS reaches.
    pub(crate) fn key(footprint: &Footprint) -> Option<TileKey> {
        let bounds = footprint.bounds();
        if bounds.is_empty() {
            return None;
        }
        key_at(bounds.min.midpoint(bounds.max))
    }

    /// The rectangle of a tile.
    pub(crate) fn bounds(key: TileKey) -> Bounds2 {
        let min = DVec2::new(f64::from(key.x), f64::from(key.y)) * Self::TILE_M;
        Bounds2 { min, max: min + Self::TILE_M }
    }

    /// Sorts the footprints of a tile, so that it is the same in whichever order they come.
    pub(crate) fn sort(footprints: &mut [Footprint]) {
        footprints.sort_by(|a, b| {
            let place = |f: &Footprint| f.bounds().min.to_array();
            let [ax, ay] = place(a);
            let [bx, by] = place(b);
            a.id.cmp(&b.id).then(ax.total_cmp(&bx)).then(ay.total_cmp(&by))
        });
    }
}

/// The tiles of the footprint grid that meet the disc and the scene, nearest first.
fn wanted_tiles(centre: DVec2, radius_m: f64, scene: &Bounds2) -> Vec<TileKey> {
    let disc = Bounds2 { min: centre - radius_m, max: centre + radius_m };
    let part = Bounds2 { min: disc.min.max(scene.min), max: disc.max.min(scene.max) };
    let (Some(low), Some(high)) = (key_at(part.min), key_at(part.max)) else { return Vec::new() };
    let mut tiles: Vec<(f64, TileKey)> = (low.y..=high.y)
        .flat_map(|y| (low.x..=high.x).map(move |x| (x, y)))
        .map(|(x, y)| TileKey { layer: TileLayer::Footprints, x, y })
        .map(|key| (FootprintGrid::bounds(key).distance(centre), key))
        .filter(|&(distance, _)| distance <= radius_m)
        .collect();
    tiles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    tiles.into_iter().map(|(_, key)| key).collect()
}

fn key_at(position: DVec2) -> Option<TileKey> {
    // Far beyond any CRS, far within i32 once divided by the tile's side.
    let reachable = position.is_finite() && position.abs().max_element() < 1e10;
    let cell = (position / FootprintGrid::TILE_M).floor();
    reachable.then_some(TileKey {
        layer: TileLayer::Footprints,
        x: cell.x as i32,
        y: cell.y as i32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::{GroundLayout, Polygon};

    fn building(id: &str, at: DVec2) -> Footprint {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        Footprint {
            id: id.into(),
            polygons: vec![Polygon { rings: vec![corners.map(|c| at + 10.0 * c).to_vec()] }],
            base_m: 0.0,
            height_m: 10.0,
            uncertainty_m: 0.0,
            attributes: "{}".into(),
        }
    }

    #[test]
    fn a_tile_is_the_same_whatever_the_order_of_arrival() {
        let at = DVec2::new(651_000.0, 6_861_000.0);
        let mut forward: Vec<_> =
            (0..20).map(|i| building(&format!("b{i}"), at + f64::from(i) * 7.0)).collect();
        let mut backward: Vec<_> = forward.iter().rev().cloned().collect();
        FootprintGrid::sort(&mut forward);
        FootprintGrid::sort(&mut backward);
        assert_eq!(forward, backward);
        let key = FootprintGrid::key(&forward[0]).expect("within reach");
        assert!(FootprintGrid::bounds(key).distance(at) < 1e-9);
    }

    #[test]
    fn tiles_are_nearest_first_and_stay_in_the_scene() {
        let scene = Bounds2 { min: DVec2::splat(-1000.0), max: DVec2::splat(1000.0) };
        let tiles = wanted_tiles(DVec2::new(10.0, 10.0), 150.0, &scene);
        assert_eq!((tiles[0].x, tiles[0].y), (0, 0));
        let distance = |key: &TileKey| FootprintGrid::bounds(*key).distance(DVec2::new(10.0, 10.0));
        assert!(tiles.windows(2).all(|pair| distance(&pair[0]) <= distance(&pair[1])));
        assert!(wanted_tiles(DVec2::splat(5000.0), 100.0, &scene).is_empty());
        assert!(wanted_tiles(DVec2::NAN, 100.0, &scene).is_empty());
        // A radius without end is bounded by the scene.
        assert_eq!(wanted_tiles(DVec2::ZERO, 1e9, &scene).len(), 32 * 32);
    }

    fn scene(tile_m: f64) -> SceneInfo {
        let bounds = Bounds3 { min: glam::DVec3::splat(-1e6), max: glam::DVec3::splat(1e6) };
        SceneInfo {
            name: "s".into(),
            crs: "local".into(),
            geographic_origin: None,
            origin: glam::DVec3::ZERO,
            bounds,
            footprints: 0,
            panoramas: 0,
            images: 0,
            ground: Some(GroundLayout {
                origin: DVec2::splat(-1e6),
                tile_m,
                columns: u32::MAX >> 1,
                rows: u32::MAX >> 1,
            }),
            point_sources: Vec::new(),
            version: "1".into(),
        }
    }

    fn keys(scene: &SceneInfo, x: f64, held: &BTreeSet<TileKey>) -> BTreeSet<TileKey> {
        let eye = glam::DVec3::new(x, 0.0, 2.0);
        let view = flaneur_scene::View::look(eye, 0.0, 0.0, 1.0, glam::UVec2::new(64, 32));
        let request = ViewRequest::walking(view);
        choose_tiles(scene, &request, held).into_iter().map(|tile| tile.key).collect()
    }

    #[test]
    fn nothing_flickers_at_the_radius() {
        let scene = scene(64.0);
        let radius_m = crate::FetchLimits::default().mesh_radius_m;
        let border = 64.0 * (radius_m / 64.0).ceil() - radius_m;
        let (mut held, none) = (BTreeSet::new(), BTreeSet::new());
        held = keys(&scene, border + 0.1, &held);
        let fresh = keys(&scene, border - 0.1, &none);
        assert!(!held.is_subset(&fresh), "here tiles would go");
        assert!(held.is_subset(&keys(&scene, border - 0.1, &held)), "but stay where they are held");
    }

    #[test]
    fn terrain_of_endless_tiles_takes_no_endless_memory() {
        let most = MOST_TILES as usize + 2;
        assert!(keys(&scene(1e-3), 0.0, &BTreeSet::new()).len() <= most * most);
    }
}
