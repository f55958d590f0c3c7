//! Having shaders compiled before anyone waits for a frame.
//!
//! Drivers compile a pipeline when it is made, again when it first draws, and some once more for
//! textures of another kind. Which are made depends on what is drawn: photographs with a mask and
//! without, displaced or not, of the nearest rigs or the others, how many rigs there are, and what is
//! left out of a quick frame. So a new renderer draws a wall, a few points and rigs of photographs of
//! them, in all ways that a walk has, and drops them again.

use std::sync::Arc;

use flaneur_renderer::{FrameBudget, Mode, RenderError, Renderer, Settings};
use flaneur_scene::{
    ImageId, ImageUpdate, MeshTile, MeshVertex, NodeKey, PointChunk, PointNodeId, PointStations,
    SceneUpdate, SurfaceClass, TileKey, TileLayer, View,
};
use glam::{DVec3, UVec2};

use super::RenderOptions;

/// Size of what is drawn, pixels.
const SIZE: UVec2 = UVec2::new(256, 128);
/// Field of view, radians.
const FOV_Y: f64 = 1.0;
/// Of the photographs, pixels: nobody looks at them.
const PHOTOGRAPH: UVec2 = UVec2::new(32, 16);
/// From rig to rig, metres.
const APART_M: f64 = 0.5;

/// Draws; nothing of it is left.
pub(super) fn up(renderer: &mut Renderer, options: &RenderOptions) -> Result<(), RenderError> {
    let exact = options.settings;
    let tile = TileKey { layer: TileLayer::Footprints, x: 0, y: 0 };
    let node = PointNodeId { source: 0, key: NodeKey { level: 0, x: 0, y: 0, z: 0 } };
    renderer.apply(wall(tile))?;
    renderer.apply(points(node))?;
    let mut images = Vec::new();
    for rig in 0..exact.rigs {
        for is_masked in [false, true] {
            let camera = if is_masked { "masked" } else { "whole" };
            let Ok(id) = ImageId::new(&format!("{rig}"), camera) else { continue };
            renderer.apply(photograph(&id, APART_M * (rig + 1) as f64, is_masked))?;
            images.push(id);
        }
    }
    let view = View::look(DVec3::ZERO, 0.0, 0.0, FOV_Y, SIZE);
    renderer.render(&view)?;
    renderer.render(&view)?;
    // As a view's first frame is, with as many rigs as there may be.
    let quick = FrameBudget::new(options.budget).settings(exact);
    for rigs in 1..=exact.rigs {
        renderer.set_settings(Settings { rigs, ..quick });
        renderer.render(&view)?;
    }
    for mode in Mode::ALL {
        renderer.render_as(&view, mode)?;
    }
    renderer.set_settings(exact);
    renderer.apply(SceneUpdate::DropMesh(tile))?;
    renderer.apply(SceneUpdate::DropPoints(node))?;
    for id in images {
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
        colours: vec![[128; 3]; 100],
        intensities: Vec::new(),
        classes: Vec::new(),
        normals: Vec::new(),
        stations: PointStations { places: Arc::new([]), of_points: Vec::new() },
        spacing_m: 0.5,
        spacings_m: Vec::new(),
    }))
}

fn photograph(id: &ImageId, x: f64, is_masked: bool) -> SceneUpdate {
    let view = View::look(DVec3::X * x, 0.0, 0.0, FOV_Y, PHOTOGRAPH);
    let pixels = (PHOTOGRAPH.x * PHOTOGRAPH.y) as usize;
    let mut rgba = [128, 128, 128, 255].repeat(pixels);
    if let Some(first) = rgba.get_mut(3).filter(|_| is_masked) {
        *first = 0;
    }
    SceneUpdate::Image(Arc::new(ImageUpdate {
        id: id.clone(),
        level: 0,
        camera: view.camera,
        size: PHOTOGRAPH,
        rgba,
        uncertainty_m: 0.1,
    }))
}

#[cfg(test)]
mod tests {
    use flaneur_renderer::Gpu;

    use super::*;

    #[test]
    fn nothing_is_left_of_what_was_drawn() {
        let gpu = Gpu::new().expect("a software driver");
        let options = RenderOptions::default();
        let view = View::look(DVec3::ZERO, 0.0, 0.0, FOV_Y, SIZE);
        let mut untouched = Renderer::with_settings(&gpu, options.settings);
        let empty = untouched.render(&view).expect("a frame");
        let mut renderer = Renderer::with_settings(&gpu, options.settings);
        up(&mut renderer, &options).expect("it draws");
        assert_eq!(renderer.settings(), options.settings);
        let frame = renderer.render(&view).expect("a frame");
        assert!(frame.rgba == empty.rgba, "something is seen");
    }
}
