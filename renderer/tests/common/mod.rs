//! A small street that is known exactly: boxes on a ground, each surface painted by a smooth
//! function of its position, photographed by tracing rays in f64.

#![allow(dead_code, unreachable_pub, reason = "each test file is a crate and uses its share")]

#[path = "../../src/tolerances.rs"]
pub mod tolerances;

use std::sync::Arc;

use flaneur_renderer::{Frame, Gpu, Renderer, Settings};
use flaneur_scene::{
    Distortion, ImageId, ImageUpdate, Lens, MeshTile, MeshVertex, NodeKey, PointChunk, PointNodeId,
    PointStations, PosedCamera, SceneUpdate, SurfaceClass, TileKey, TileLayer, View,
    srgb_from_linear,
};
use glam::{DVec2, DVec3, UVec2};

/// An axis-aligned box relative to the street's origin, metres.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    pub min: DVec3,
    pub max: DVec3,
}

/// Boxes on a square of ground around an origin.
#[derive(Clone, Debug)]
pub struct Street {
    pub origin: DVec3,
    pub blocks: Vec<Block>,
    /// Half the side of the ground, metres; 0 for none.
    pub ground_m: f64,
    /// Share by which spots of half a metre lighten and darken the colours, 0 to 1; those are smooth, so
    /// that resampling them loses little.
    pub spots: f64,
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub distance: f64,
    /// Relative to the street's origin.
    pub position: DVec3,
    pub normal: DVec3,
    /// Which block; the ground comes after the last.
    pub object: usize,
}

pub fn block(min: [f64; 3], max: [f64; 3]) -> Block {
    Block { min: min.into(), max: max.into() }
}

impl Street {
    /// A wall along the east of a street, a pole before it, and a box further on.
    pub fn with_pole(origin: DVec3) -> Self {
        let blocks = vec![
            block([6.0, -20.0, 0.0], [10.0, 20.0, 9.0]),
            block([3.0, 1.0, 0.0], [3.3, 1.3, 6.0]),
            block([-9.0, 4.0, 0.0], [-5.0, 14.0, 7.0]),
        ];
        Self { origin, blocks, ground_m: 30.0, spots: 0.0 }
    }

    /// The first surface that a ray from `from` (relative to the origin) meets.
    pub fn trace(&self, from: DVec3, direction: DVec3) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        let mut offer = |distance: f64, normal: DVec3, object: usize| {
            if distance > 1e-9 && nearest.is_none_or(|hit| distance < hit.distance) {
                let position = from + direction * distance;
                nearest = Some(Hit { distance, position, normal, object });
            }
        };
        for (object, block) in self.blocks.iter().enumerate() {
            let to_min = (block.min - from) / direction;
            let to_max = (block.max - from) / direction;
            let (enter, leave) = (to_min.min(to_max), to_min.max(to_max));
            let distance = enter.max_element();
            if distance > 0.0 && distance <= leave.min_element() {
                let axis = (0..3).find(|&a| enter[a] == distance).unwrap_or(0);
                let mut normal = DVec3::ZERO;
                normal[axis] = -direction[axis].signum();
                offer(distance, normal, object);
            }
        }
        if self.ground_m > 0.0 && direction.z < 0.0 {
            let distance = -from.z / direction.z;
            let at = from + direction * distance;
            if at.truncate().abs().max_element() <= self.ground_m {
                offer(distance, DVec3::Z, self.blocks.len());
            }
        }
        nearest
    }

    /// Linear colour of a surface: smooth, but for the spots, and different for each object.
    pub fn paint(&self, hit: &Hit) -> DVec3 {
        let p = hit.position;
        let phase = hit.object as f64 * 2.1;
        let spots = 1.0 + self.spots * (9.0 * p.y + 3.0 * p.x).sin() * (7.0 * p.z).cos();
        let wave = |a: f64, b: f64| spots * (0.45 + 0.3 * (a + phase).sin() * (b - phase).cos());
        DVec3::new(
            wave(1.9 * p.x + 2.3 * p.y, 1.7 * p.z),
            wave(2.9 * p.z, 1.3 * p.y - 0.9 * p.x),
            wave(0.7 * p.y + 0.5 * p.x, 0.6 * p.z + 1.0),
        )
    }

    /// What each pixel of a camera sees, from its centre: sRGB 0 to 1, and the hit.
    pub fn picture(&self, camera: &PosedCamera) -> Vec<Option<(Hit, DVec3)>> {
        pixels(camera.lens.size)
            .map(|pixel| {
                let d = camera.lens.unproject(pixel)?;
                let world = camera.cam_from_world.transpose() * d;
                let hit = self.trace(camera.centre - self.origin, world)?;
                Some((hit, self.paint(&hit).to_array().map(srgb_from_linear).into()))
            })
            .collect()
    }

    /// A photograph without mask; what it sees of the sky is magenta.
    pub fn photograph(&self, id: &str, camera: PosedCamera) -> ImageUpdate {
        let rgba = self
            .picture(&camera)
            .iter()
            .flat_map(|seen| {
                let colour = seen.as_ref().map_or(DVec3::new(1.0, 0.0, 1.0), |(_, c)| *c);
                let [r, g, b] = colour.to_array().map(|c| (c * 255.0).round() as u8);
                [r, g, b, 255]
            })
            .collect();
        ImageUpdate {
            id: id.parse::<ImageId>().expect("test name"),
            level: 0,
            camera,
            size: camera.lens.size,
            rgba,
            uncertainty_m: 0.0,
        }
    }

    /// The objects as one tile of mesh.
    pub fn mesh(&self, objects: &[usize], uncertainty_m: f32) -> MeshTile {
        let mut tile = MeshTile {
            key: TileKey { layer: TileLayer::Footprints, x: 0, y: 0 },
            origin: self.origin,
            vertices: Vec::new(),
            indices: Vec::new(),
        };
        for &object in objects {
            for (corners, normal) in self.faces(object) {
                let first = tile.vertices.len() as u32;
                let class = if normal.z == 0.0 {
                    SurfaceClass::Wall
                } else if object == self.blocks.len() {
                    SurfaceClass::Ground
                } else {
                    SurfaceClass::Roof
                };
                tile.vertices.extend(corners.map(|corner| MeshVertex {
                    position: corner.as_vec3().to_array(),
                    normal: normal.as_vec3().to_array(),
                    uncertainty_m,
                    class,
                }));
                tile.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
            }
        }
        tile
    }

    /// Points on a square grid over the faces of the objects.
    pub fn points(&self, objects: &[usize], spacing_m: f64) -> PointChunk {
        let mut positions = Vec::new();
        for &object in objects {
            for ([a, b, _, d], _) in self.faces(object) {
                let steps = |edge: DVec3| (edge.length() / spacing_m).ceil().max(1.0) as u32;
                let (along, across) = (steps(b - a), steps(d - a));
                for i in 0..=along {
                    for j in 0..=across {
                        let s = f64::from(i) / f64::from(along);
                        let t = f64::from(j) / f64::from(across);
                        let p = a + (b - a) * s + (d - a) * t;
                        positions.push(p.as_vec3().to_array());
                    }
                }
            }
        }
        PointChunk {
            id: PointNodeId { source: 0, key: NodeKey::ROOT },
            origin: self.origin,
            positions,
            colours: Vec::new(),
            intensities: Vec::new(),
            classes: Vec::new(),
            normals: Vec::new(),
            stations: PointStations::default(),
            spacing_m: spacing_m as f32,
            spacings_m: Vec::new(),
        }
    }

    /// Four corners, counter-clockwise from outside, and the outward normal of each face.
    fn faces(&self, object: usize) -> Vec<([DVec3; 4], DVec3)> {
        let Some(&Block { min, max }) = self.blocks.get(object) else {
            let g = self.ground_m;
            let corner = |x: f64, y: f64| DVec3::new(x * g, y * g, 0.0);
            let corners = [corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)];
            return vec![(corners, DVec3::Z)];
        };
        let at = |x: f64, y: f64, z: f64| min + (max - min) * DVec3::new(x, y, z);
        vec![
            ([at(1., 0., 0.), at(1., 1., 0.), at(1., 1., 1.), at(1., 0., 1.)], DVec3::X),
            ([at(0., 1., 0.), at(0., 0., 0.), at(0., 0., 1.), at(0., 1., 1.)], -DVec3::X),
            ([at(1., 1., 0.), at(0., 1., 0.), at(0., 1., 1.), at(1., 1., 1.)], DVec3::Y),
            ([at(0., 0., 0.), at(1., 0., 0.), at(1., 0., 1.), at(0., 0., 1.)], -DVec3::Y),
            ([at(0., 0., 1.), at(1., 0., 1.), at(1., 1., 1.), at(0., 1., 1.)], DVec3::Z),
        ]
    }
}

/// A camera at `at` (relative to `origin`), angles in degrees.
pub fn camera(
    origin: DVec3,
    at: [f64; 3],
    heading: f64,
    pitch: f64,
    fov: f64,
    size: UVec2,
) -> PosedCamera {
    let eye = origin + DVec3::from_array(at);
    let [heading, pitch, fov] = [heading, pitch, fov].map(f64::to_radians);
    View::look(eye, heading, pitch, fov, size).camera
}

/// One of each model, for pictures of some 320 pixels by 240.
pub const DISTORTIONS: [Distortion; 3] = [
    Distortion::RadialPixels {
        centre: DVec2::new(158.0, 123.0),
        k: [-5e-6, 4e-11, -1e-16],
        limit_px: 400.0,
    },
    Distortion::Brown { k: [0.2, 0.1, 0.0], p: [0.01, -0.008] },
    Distortion::Fisheye { k: [-0.02, 0.004, 0.0, 0.0] },
];

/// The same camera with another lens.
pub fn with_lens(camera: PosedCamera, lens: Lens) -> PosedCamera {
    PosedCamera { lens, ..camera }
}

/// A renderer that holds `updates`.
pub fn renderer(settings: Settings, updates: Vec<SceneUpdate>) -> Renderer {
    static GPU: std::sync::OnceLock<Gpu> = std::sync::OnceLock::new();
    let gpu = GPU.get_or_init(|| Gpu::new().expect("a graphics driver"));
    let mut renderer = Renderer::with_settings(gpu, settings);
    for update in updates {
        renderer.apply(update).expect("a good update");
    }
    renderer
}

pub fn mesh_update(tile: MeshTile) -> SceneUpdate {
    SceneUpdate::Mesh(Arc::new(tile))
}

pub fn image_update(image: ImageUpdate) -> SceneUpdate {
    SceneUpdate::Image(Arc::new(image))
}

pub fn points_update(chunk: PointChunk) -> SceneUpdate {
    SceneUpdate::Points(Arc::new(chunk))
}

/// Centres of the pixels, rows from the top.
pub fn pixels(size: UVec2) -> impl Iterator<Item = DVec2> {
    (0..size.y).flat_map(move |y| {
        (0..size.x).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
    })
}

/// Whether all neighbours of a pixel show the same object with the same normal.
pub fn is_interior(
    picture: &[Option<(Hit, DVec3)>],
    size: UVec2,
    index: usize,
    reach: i64,
) -> bool {
    let (width, height) = (i64::from(size.x), i64::from(size.y));
    let key = |i: usize| {
        picture[i].as_ref().map(|(hit, _)| (hit.object, hit.normal.to_array().map(|x| x as i8)))
    };
    let (x, y) = (index as i64 % width, index as i64 / width);
    (-reach..=reach).all(|dy| {
        (-reach..=reach).all(|dx| {
            let (x, y) = ((x + dx).clamp(0, width - 1), (y + dy).clamp(0, height - 1));
            key((y * width + x) as usize) == key(index)
        })
    })
}

/// How a frame's coloured pixels, away from edges, differ from what the street really looks
/// like there.
#[derive(Clone, Copy, Debug)]
pub struct Likeness {
    pub compared: u32,
    /// Mean over pixels of the largest difference of a channel, 255ths.
    pub mean: f64,
    /// Share of pixels that differ by more than [`tolerances::RESAMPLED_255`].
    pub wrong: f64,
}

impl Street {
    /// Compares a frame with the truth. Pixels within `reach` of an edge are left out.
    pub fn likeness(&self, frame: &Frame, camera: &PosedCamera, reach: i64) -> Likeness {
        let truth = self.picture(camera);
        let (mut compared, mut wrong, mut sum) = (0, 0, 0.0);
        for (i, seen) in truth.iter().enumerate() {
            let Some((_, colour)) = seen else { continue };
            if frame.surfaces[i].is_coloured() && is_interior(&truth, frame.size, i, reach) {
                let off = difference(&frame.rgba, i, *colour);
                compared += 1;
                sum += off;
                wrong += u32::from(off > tolerances::RESAMPLED_255);
            }
        }
        let n = f64::from(compared);
        Likeness { compared, mean: sum / n, wrong: f64::from(wrong) / n }
    }
}

impl Likeness {
    /// Asserts that resampling alone explains the differences.
    pub fn assert_resampled(self, compared: u32) {
        assert!(
            self.compared >= compared
                && self.mean < tolerances::RESAMPLED_MEAN_255
                && self.wrong < tolerances::RESAMPLED_WRONG_SHARE,
            "{self:?}, at least {compared} pixels wanted"
        );
    }
}

/// Writes a frame to the folder named by FLANEUR_TEST_IMAGES, if any, for a person to look at.
pub fn keep(frame: &Frame, name: &str) {
    if let Some(folder) = std::env::var_os("FLANEUR_TEST_IMAGES") {
        let path = std::path::Path::new(&folder).join(format!("{name}.png"));
        let UVec2 { x, y } = frame.size;
        image::save_buffer(path, &frame.rgba, x, y, image::ColorType::Rgba8).expect("written");
    }
}

/// Largest difference of a pixel's channels from the truth, in 255ths.
pub fn difference(rgba: &[u8], index: usize, truth: DVec3) -> f64 {
    let pixel = &rgba[4 * index..4 * index + 3];
    pixel
        .iter()
        .zip(truth.to_array())
        .map(|(&found, expected)| (f64::from(found) - 255.0 * expected).abs())
        .fold(0.0, f64::max)
}
