//! The point pass on a street and close to a wall: time by route, by normals and by the size
//! from which discs are drawn as quads. `cargo bench -p flaneur-renderer --bench splat`.
//!
//! Every row of a scene and a kind of normals must give the same picture, or the run fails.

use flaneur_renderer::{Gpu, Mode, RenderError, Renderer, Settings, SplatNormals, SplatRoute};
use flaneur_scene::{NodeKey, PointChunk, PointNodeId, PointStations, SceneUpdate, View};
use glam::{DVec3, UVec2};

/// Frames of which the least and the median time are taken: on a machine that others use, the
/// least is the better comparison.
const FRAMES: usize = 9;
/// The size at which the project states its targets.
const SIZE: UVec2 = UVec2::new(1024, 512);
const EYE: DVec3 = DVec3::new(651_187.0, 6_861_353.0, 44.0);

/// Points of a street canyon before the eye, and how far apart they are.
struct Scene {
    name: &'static str,
    spacing_m: f64,
    length_m: f64,
}

const SCENES: [Scene; 3] = [
    Scene { name: "street", spacing_m: 0.052, length_m: 80.0 },
    Scene { name: "street, fine", spacing_m: 0.036, length_m: 80.0 },
    Scene { name: "street, coarse: large discs", spacing_m: 0.3, length_m: 80.0 },
];

fn main() -> Result<(), RenderError> {
    let gpu = Gpu::new()?;
    println!("{}, {}x{}, ms of {FRAMES} frames", gpu.adapter_name(), SIZE.x, SIZE.y);
    println!(
        "{:<28} {:>9}  {:<10} {:<9} {:>6}  {:>7} {:>7}",
        "scene", "points", "route", "normals", "quads", "least", "median"
    );
    for scene in &SCENES {
        let chunks = scene.chunks();
        for normals in [SplatNormals::Eye, SplatNormals::Estimated] {
            let mut picture = None;
            for (route, quads) in routes(&gpu) {
                let settings = Settings {
                    splat_normals: normals,
                    splat_route: route,
                    quads_from_px: Some(quads),
                    ..Settings::default()
                };
                let mut renderer = Renderer::with_settings(&gpu, settings);
                for chunk in &chunks {
                    renderer.apply(SceneUpdate::Points(std::sync::Arc::new(chunk.clone())))?;
                }
                let (times, points, rgba) = measure(&mut renderer)?;
                let same = picture.get_or_insert_with(|| rgba.clone()) == &rgba;
                assert!(same, "{route:?} with quads from {quads} px gives another picture");
                let quads = if quads == u32::MAX { "none".into() } else { quads.to_string() };
                println!(
                    "{:<28} {points:>9}  {:<10} {:<9} {quads:>6}  {:>7.2} {:>7.2}",
                    scene.name,
                    format!("{route:?}"),
                    format!("{normals:?}"),
                    times[0],
                    times[times.len() / 2],
                );
            }
        }
    }
    Ok(())
}

fn routes(gpu: &Gpu) -> Vec<(SplatRoute, u32)> {
    let mut routes = vec![SplatRoute::Atomic32];
    if gpu.has_64_bit_atomics() {
        routes.push(SplatRoute::Atomic64);
    }
    let quads = [u32::MAX, 4096, 1024, 128];
    routes.into_iter().flat_map(|route| quads.map(|quads| (route, quads))).collect()
}

/// Times of the point pass in milliseconds, ascending; points drawn, and the picture.
fn measure(renderer: &mut Renderer) -> Result<(Vec<f64>, u64, Vec<u8>), RenderError> {
    let view = View::look(EYE, 0.0, 0.0, 1.2, SIZE);
    let warm = renderer.render_as(&view, Mode::PointsColour)?;
    let mut times = Vec::new();
    for _ in 0..FRAMES {
        let (_, passes) = renderer.render_timed(&view, Mode::PointsColour)?;
        let points = passes.iter().find(|pass| pass.pass == "points");
        times.extend(points.map(|pass| pass.time.as_secs_f64() * 1e3));
    }
    times.sort_by(f64::total_cmp);
    Ok((times, warm.stats.points_drawn, warm.rgba))
}

impl Scene {
    /// Ground and two facades, 16 m apart and 10 m high, in slabs of 2 m; in each, points come
    /// column by column.
    fn chunks(&self) -> Vec<PointChunk> {
        let slab_m = 2.0;
        let steps = |length: f64| (length / self.spacing_m) as u32;
        let at = |i: u32| f64::from(i) * self.spacing_m;
        (0..(self.length_m / slab_m) as u32)
            .map(|slab| {
                let origin = EYE + DVec3::new(0.0, 1.0 + slab_m * f64::from(slab), -2.0);
                let (mut positions, mut normals) = (Vec::new(), Vec::new());
                for along in 0..steps(slab_m) {
                    for i in 0..steps(16.0) {
                        positions.push(DVec3::new(at(i) - 8.0, at(along), 0.0));
                        normals.push([0.0, 0.0, 1.0]);
                    }
                    for i in 0..steps(10.0) {
                        for side in [-8.0, 8.0] {
                            positions.push(DVec3::new(side, at(along), at(i)));
                            normals.push([1.0, 0.0, 0.0]);
                        }
                    }
                }
                let colour = |p: &DVec3| [p.x, p.y, p.z].map(|v| (128.0 + 12.0 * v) as u8);
                PointChunk {
                    id: PointNodeId { source: 0, key: NodeKey { level: 6, x: slab, y: 0, z: 0 } },
                    origin,
                    colours: positions.iter().map(colour).collect(),
                    positions: positions.iter().map(|p| p.as_vec3().to_array()).collect(),
                    intensities: Vec::new(),
                    classes: Vec::new(),
                    normals,
                    stations: PointStations::default(),
                    spacing_m: self.spacing_m as f32,
                    spacings_m: Vec::new(),
                }
            })
            .collect()
    }
}
