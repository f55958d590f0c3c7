//! Having every shader compiled before anything is timed.
//!
//! Drivers compile a pipeline when it is made, and again when it first draws. A few surfaces, points and
//! photographs that no scene holds are rendered once by the very renderer that is to walk, at the
//! walk's size, and dropped again.

use std::sync::Arc;

use flaneur_renderer::{RenderError, Renderer};
use flaneur_scene::{
    IdError, ImageId, ImageUpdate, MeshTile, MeshVertex, NodeKey, PointChunk, PointNodeId,
    PointStations, SceneUpdate, SurfaceClass, TileKey, TileLayer, View,
};
use glam::{DVec3, UVec2};

use crate::exit::Exit;

const PHOTOGRAPH: UVec2 = UVec2::splat(64);
/// How far ahead the surfaces lie, metres.
const AHEAD_M: f64 = 8.0;
/// Points a side, and between them, metres: near ones appear large, far ones small.
const POINTS: (i32, f64) = (24, 0.4);

/// Renders what is not there. The renderer must be empty, and is so again.
pub(super) fn warm_up(renderer: &mut Renderer, view: &View) -> Result<(), Exit> {
    let eye = view.eye();
    let to_world = view.camera.cam_from_world.transpose();
    let at = |x: f64, y: f64, z: f64| to_world * DVec3::new(x, y, z);
    let mut added = vec![wall(eye, at), points(eye, at)];
    for (name, aside) in [("warm/1", -0.5), ("warm/2", 0.5)] {
        added.push(photograph(name, view, at(aside, 0.0, 0.0)).map_err(Exit::failed)?);
    }
    apply(renderer, &added)?;
    // The first depth maps and gains of photographs, then the frame as it goes on.
    for _ in 0..2 {
        renderer.render(view)?;
    }
    let dropped: Vec<SceneUpdate> = added.iter().map(drop_of).collect();
    apply(renderer, &dropped)?;
    renderer.render(view)?;
    renderer.cut();
    Ok(())
}

fn apply(renderer: &mut Renderer, updates: &[SceneUpdate]) -> Result<(), RenderError> {
    updates.iter().try_for_each(|update| renderer.apply(update.clone()).map(|_| ()))
}

/// Across the lower half of the view: the upper half shows nothing, so that depths are inferred there.
fn wall(origin: DVec3, at: impl Fn(f64, f64, f64) -> DVec3) -> SceneUpdate {
    let normal = at(0.0, 0.0, -1.0).as_vec3().to_array();
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, 0.0], [-1.0, 0.0]];
    let vertex = |[x, y]: [f64; 2]| MeshVertex {
        position: at(AHEAD_M * x, AHEAD_M * y, AHEAD_M).as_vec3().to_array(),
        normal,
        uncertainty_m: 0.1,
        class: SurfaceClass::Wall,
    };
    SceneUpdate::Mesh(Arc::new(MeshTile {
        key: TileKey { layer: TileLayer::Footprints, x: 0, y: 0 },
        origin,
        vertices: corners.map(vertex).to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
    }))
}

/// On a plane that leads away from the eye.
fn points(origin: DVec3, at: impl Fn(f64, f64, f64) -> DVec3) -> SceneUpdate {
    let (side, spacing_m) = POINTS;
    let place = |i: i32| {
        let (x, z) = (f64::from(i % side - side / 2), f64::from(1 + i / side));
        at(spacing_m * x, 1.0, spacing_m * z).as_vec3().to_array()
    };
    SceneUpdate::Points(Arc::new(PointChunk {
        id: PointNodeId { source: 0, key: NodeKey::ROOT },
        origin,
        positions: (0..side * side).map(place).collect(),
        colours: Vec::new(),
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        stations: PointStations::default(),
        spacing_m: spacing_m as f32,
        spacings_m: Vec::new(),
    }))
}

/// A grey one with a few shades, which looks where the view does.
fn photograph(name: &str, view: &View, aside: DVec3) -> Result<SceneUpdate, IdError> {
    let mut camera = view.camera;
    camera.centre += aside;
    camera.lens = camera.lens.scaled_to(PHOTOGRAPH);
    let pixels = PHOTOGRAPH.x * PHOTOGRAPH.y;
    let shade = |i: u32| [(96 + 8 * (i % 16)) as u8; 3];
    let rgba = (0..pixels).flat_map(|i| shade(i).into_iter().chain([255])).collect();
    Ok(SceneUpdate::Image(Arc::new(ImageUpdate {
        id: name.parse::<ImageId>()?,
        level: 0,
        camera,
        size: PHOTOGRAPH,
        rgba,
        uncertainty_m: 0.0,
    })))
}

fn drop_of(update: &SceneUpdate) -> SceneUpdate {
    match update {
        SceneUpdate::Mesh(tile) => SceneUpdate::DropMesh(tile.key),
        SceneUpdate::Points(chunk) => SceneUpdate::DropPoints(chunk.id),
        SceneUpdate::Image(image) => SceneUpdate::DropImage(image.id.clone()),
        drop => drop.clone(),
    }
}
