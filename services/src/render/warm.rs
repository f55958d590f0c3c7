//! Having shaders compiled before anyone waits for a frame.
//!
//! Drivers compile a pipeline when it is made, again when it first draws, and some once more for
//! textures of another kind. So a new renderer draws a wall, a few points and two photographs of them,
//! and drops them again.

use std::sync::Arc;

use flaneur_renderer::{RenderError, Renderer};
use flaneur_scene::{
    ImageId, ImageUpdate, MeshTile, MeshVertex, NodeKey, PointChunk, PointNodeId, PointStations,
    SceneUpdate, SurfaceClass, TileKey, TileLayer, View,
};
use glam::{DVec3, UVec2};

/// Size of what is drawn, pixels.
const SIZE: UVec2 = UVec2::new(256, 128);
/// Field of view, radians.
const FOV_Y: f64 = 1.0;

/// Draws; nothing of it is left.
pub(super) fn up(renderer: &mut Renderer) -> Result<(), RenderError> {
    let tile = TileKey { layer: TileLayer::Footprints, x: 0, y: 0 };
    let node = PointNodeId { source: 0, key: NodeKey { level: 0, x: 0, y: 0, z: 0 } };
    let images = ["0", "1"].map(|panorama| ImageId::new(panorama, "0"));
    renderer.apply(wall(tile))?;
    renderer.apply(points(node))?;
    for (x, id) in [-0.5, 0.5].into_iter().zip(images.iter().flatten()) {
        renderer.apply(photograph(id, x))?;
    }
    let view = View::look(DVec3::ZERO, 0.0, 0.0, FOV_Y, SIZE);
    renderer.render(&view)?;
    renderer.render(&view)?;
    renderer.apply(SceneUpdate::DropMesh(tile))?;
    renderer.apply(SceneUpdate::DropPoints(node))?;
    for id in images.into_iter().flatten() {
        renderer.apply(SceneUpdate::DropImage(id))?;
    }
    renderer.render(&view)?;
    renderer.cut();
    Ok(())
}

/// Ten metres ahead, below the eye's height.
fn wall(key: TileKey) -> SceneUpdate {
    let vertex = |x: f32, z: f32| MeshVertex {
        position: [x, 10.0, z],
        normal: [0.0, -1.0, 0.0],
        uncertainty_m: 0.3,
        class: SurfaceClass::Wall,
    };
    let vertices = vec![vertex(-5.0, -3.0), vertex(5.0, -3.0), vertex(5.0, 0.0), vertex(-5.0, 0.0)];
    let indices = vec![0, 1, 2, 0, 2, 3];
    SceneUpdate::Mesh(Arc::new(MeshTile { key, origin: DVec3::ZERO, vertices, indices }))
}

fn points(id: PointNodeId) -> SceneUpdate {
    let positions =
        (0..100u8).map(|i| [f32::from(i % 10) - 5.0, 8.0, f32::from(i / 10) * 0.1 - 2.0]);
    SceneUpdate::Points(Arc::new(PointChunk {
        id,
        origin: DVec3::ZERO,
        positions: positions.collect(),
        colours: Vec::new(),
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        stations: PointStations { places: Arc::new([]), of_points: Vec::new() },
        spacing_m: 0.5,
        spacings_m: Vec::new(),
    }))
}

fn photograph(id: &ImageId, x: f64) -> SceneUpdate {
    let view = View::look(DVec3::X * x, 0.0, 0.0, FOV_Y, SIZE);
    let pixels = (SIZE.x * SIZE.y) as usize;
    SceneUpdate::Image(Arc::new(ImageUpdate {
        id: id.clone(),
        level: 0,
        camera: view.camera,
        size: SIZE,
        rgba: [128, 128, 128, 255].repeat(pixels),
        uncertainty_m: 0.1,
    }))
}
