//! Depth where there is no geometry, as the photographs agree on it.
//!
//! Lidar ends a few degrees above the horizon, and meshes have holes. What a picture shows there
//! is still in the photographs; only its depth is missing. On a coarse grid of cells every cell
//! gets hypotheses: the inverse depth diffused from what is known around it, a backdrop beyond the
//! scene, and some between. The photographs are looked up at each; the one on which the nearest
//! two that see it agree best, over a window, wins. The records of the picture are then completed
//! by places that are marked as inferred: they are coloured like others, and measure nothing.

use flaneur_scene::{PosedCamera, View};
use wgpu::util::DeviceExt as _;

use crate::diffuse::DiffusePass;
use crate::frustum::Frustum;
use crate::photographs::atlas::Atlas;
use crate::screen::{Marks, ScreenPass, WHOLE_WGSL, marked_pass, screen_pass, screen_pass_with};
use crate::shade::photograph::Drawn;
use crate::surface::{self, PLACE_WGSL, POSITION_FORMAT, Rays};
use crate::targets::Targets;
use crate::tiles::{Shown, TilePass};
use crate::{Gpu, lens, memory, octahedral, shade};

mod grid;
pub(crate) mod reference;
mod sight;
#[cfg(test)]
mod tests;

use grid::{COST_FORMAT, Cells, INVERSE_FORMAT};
pub(crate) use grid::{Grid, MAX_RIGS};
use grid::{KNOWN_FORMAT, RAY_FORMAT};
pub(crate) use grid::{RANK_FORMAT, SIGHT_FORMAT};
pub(crate) use sight::{BRIGHTNESS_WGSL, Part, RECORDS, SightPass, Sights, UNIFORM, texture_of};

const INFERENCE_WGSL: &str = include_str!("inference.wgsl");

/// How many times the scene's extent away the backdrop is: what is so far moves less than a
/// pixel between photographs.
pub(crate) const BACKDROP: f64 = 4.0;
/// Range of the backdrop of a scene without geometry, metres.
pub(crate) const LONE_BACKDROP_M: f64 = 1000.0;
/// Farthest that the eye may have moved since the picture before for its depths to count,
/// metres.
const SAME_WALK_M: f64 = 0.5;

pub(crate) mod gpu_data {
    use crate::lens::gpu_data::Lens;

    /// Mirrors `Inference` in inference.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Inference {
        pub(crate) size: [u32; 2],
        pub(crate) cells: [u32; 2],
        pub(crate) step: u32,
        pub(crate) hypotheses: u32,
        pub(crate) diffused_index: u32,
        pub(crate) rigs: u32,
        pub(crate) backdrop: f32,
        pub(crate) has_before: u32,
        pub(crate) padding: [u32; 2],
    }

    /// Mirrors `Before` in choose.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Before {
        pub(crate) lens: Lens,
        pub(crate) right: [f32; 3],
        pub(crate) step: f32,
        pub(crate) down: [f32; 3],
        pub(crate) padding_0: u32,
        pub(crate) forward: [f32; 3],
        pub(crate) padding_1: u32,
        pub(crate) eye: [f32; 3],
        pub(crate) padding_2: u32,
    }
}

/// Every shader of this pass, by name.
pub(crate) fn sources() -> [(&'static str, String); 8] {
    let plain = |own: &str| [INFERENCE_WGSL, WHOLE_WGSL, own].concat();
    let places = [octahedral::WGSL, PLACE_WGSL].concat();
    let gather = plain(include_str!("gather.wgsl"));
    let hypotheses = plain(include_str!("places.wgsl"));
    let fill = [INFERENCE_WGSL, include_str!("fill.wgsl")].concat();
    let choose = plain(include_str!("choose.wgsl"));
    [
        ("gather", [&places, &gather[..]].concat()),
        ("places", [&places, &hypotheses[..]].concat()),
        ("sight", sight::wgsl()),
        ("cost", plain(include_str!("cost.wgsl"))),
        ("window", plain(include_str!("window.wgsl"))),
        ("choose", [lens::WGSL, &choose[..]].concat()),
        ("settle", plain(include_str!("settle.wgsl"))),
        ("fill", [&surface::ray_wgsl(), &places, &fill[..]].concat()),
    ]
}

/// What is remembered of a picture for the next of whoever looks.
#[derive(Debug)]
pub(crate) struct Past {
    camera: PosedCamera,
    grid: Grid,
    settled: wgpu::TextureView,
}

impl Past {
    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        memory::of_texture(self.settled.texture())
    }
}

/// The pipelines of this pass, and what it remembers of the picture before.
#[derive(Debug)]
pub(crate) struct InferPass {
    gather: ScreenPass,
    diffuse: DiffusePass,
    places: ScreenPass,
    sight: SightPass,
    cost: ScreenPass,
    windows: [ScreenPass; 2],
    choose: ScreenPass,
    settle: ScreenPass,
    /// One a lens model.
    fill: [ScreenPass; lens::MODELS],
    cells: Option<Cells>,
    past: Option<Past>,
}

/// What depths are inferred from, beside the records of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence<'a> {
    pub(crate) view: &'a View,
    pub(crate) frame: &'a shade::gpu_data::Frame,
    pub(crate) rays: &'a Rays,
    /// Ordered by rig, the nearest first.
    pub(crate) photographs: &'a [Drawn],
    /// What each can see, and its rig.
    pub(crate) frustums: &'a [(&'a Frustum, usize)],
    pub(crate) atlas: &'a Atlas,
    /// From the eye to the farthest resident geometry, metres; 0 without any.
    pub(crate) extent_m: f64,
}

impl<'a> Evidence<'a> {
    /// What the photographs of so many rigs can see.
    pub(crate) fn of_nearest(&self, rigs: usize) -> &'a [(&'a Frustum, usize)] {
        let nearest = self.frustums.chunk_by(|(_, a), (_, b)| a == b).take(rigs);
        &self.frustums[..nearest.map(<[_]>::len).sum()]
    }
}

impl InferPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let [gather, places, _, cost, window, choose, settle, fill] = sources();
        let pass = |(label, wgsl): (&'static str, String), formats: &[wgpu::TextureFormat]| {
            screen_pass(gpu, label, &wgsl, formats)
        };
        let along = |x: bool| {
            let constants = [("ALONG_X", f64::from(u8::from(x)))];
            screen_pass_with(gpu, window.0, &window.1, &[COST_FORMAT], &constants)
        };
        let fill = |model: usize| {
            let constants = [("LENS_MODEL", model as f64)];
            marked_pass(gpu, fill.0, &fill.1, &[POSITION_FORMAT], &constants, Marks::Heeds)
        };
        Self {
            gather: pass(gather, &[RAY_FORMAT, KNOWN_FORMAT]),
            diffuse: DiffusePass::new(gpu, KNOWN_FORMAT),
            places: pass(places, &[POSITION_FORMAT]),
            sight: SightPass::new(gpu, &sight::wgsl(), &[(0, UNIFORM), (1, RECORDS), (6, UNIFORM)]),
            cost: pass(cost, &[COST_FORMAT]),
            windows: [along(true), along(false)],
            choose: pass(choose, &[INVERSE_FORMAT]),
            settle: pass(settle, &[INVERSE_FORMAT]),
            fill: std::array::from_fn(fill),
            cells: None,
            past: None,
        }
    }

    /// What [`InferPass::bytes`] is once a picture was drawn on `grid`.
    pub(crate) fn bytes_for(grid: Grid) -> u64 {
        Cells::bytes_for(grid) + Cells::bytes_of_past(grid)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.cells.as_ref().map_or(0, Cells::bytes) + self.past.as_ref().map_or(0, Past::bytes)
    }

    /// Gives its textures back, but where they are those of `grid`.
    pub(crate) fn release_but(&mut self, grid: Option<Grid>) {
        self.cells.take_if(|cells| Some(cells.grid) != grid);
        self.past.take_if(|past| Some(past.grid) != grid);
    }

    /// What the last picture was inferred from, and what came of it.
    #[cfg(test)]
    pub(crate) fn last_cells(&self) -> Option<LastCells<'_>> {
        let (cells, past) = (self.cells.as_ref()?, self.past.as_ref()?);
        Some(LastCells {
            rays: &cells.rays,
            diffused: &cells.diffused,
            sights: &cells.sight_of_rig,
            settled: &past.settled,
        })
    }

    /// Forgets the picture before.
    pub(crate) fn cut(&mut self) {
        self.past = None;
    }

    /// Remembers another picture than the one before, which is given back.
    pub(crate) fn exchange(&mut self, past: Option<Past>) -> Option<Past> {
        std::mem::replace(&mut self.past, past)
    }

    /// Completes the records of `targets` by inferred places.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        tile_pass: &TilePass,
        evidence: Evidence<'_>,
        grid: Grid,
        targets: &Targets,
    ) {
        self.release_but(Some(grid));
        let view = evidence.view;
        let cells = self.cells.get_or_insert_with(|| Cells::new(gpu, grid));
        let past = self.past.take();
        let before = past.as_ref().map(|past| past.camera);
        let before = before.filter(|b| b.centre.distance(view.eye()) < SAME_WALK_M);

        let rigs = evidence.photographs.chunk_by(|a, b| a.rig == b.rig).count() as u32;
        let range_m = if evidence.extent_m > 0.0 { evidence.extent_m } else { LONE_BACKDROP_M };
        let backdrop = (1.0 / (BACKDROP * range_m)) as f32;
        let inference = gpu_data::Inference {
            size: grid.picture.to_array(),
            cells: grid.cells.to_array(),
            step: grid.step,
            hypotheses: grid.hypotheses,
            diffused_index: grid.between + 1,
            rigs: rigs.min(MAX_RIGS),
            backdrop,
            has_before: u32::from(before.is_some()),
            padding: [0; 2],
        };
        let before = before.map(|before| before_data(&before, view, grid)).unwrap_or_default();
        let uniform = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("infer"),
                contents,
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let frame = uniform(bytemuck::bytes_of(evidence.frame));
        let uniforms =
            (uniform(bytemuck::bytes_of(&inference)), uniform(bytemuck::bytes_of(&before)));
        let (inference, before) = (uniforms.0.as_entire_binding(), uniforms.1.as_entire_binding());
        let texture = wgpu::BindingResource::TextureView;

        let positions = &targets.records.positions;
        let seen = vec![inference.clone(), texture(positions)];
        self.gather.draw(gpu, encoder, seen, &[&cells.rays, &cells.levels.known_layers()[0]]);
        // Without any geometry all is backdrop.
        self.diffuse.draw(gpu, encoder, &cells.levels, [backdrop, 0.0, 0.0]);
        let bindings = vec![inference.clone(), texture(&cells.rays), texture(&cells.diffused)];
        self.places.draw(gpu, encoder, bindings, &[&cells.places]);
        let shown = Shown { view, size: grid.tall(), positions: &cells.places };
        let asked = evidence.of_nearest(MAX_RIGS as usize);
        let boxes = tile_pass.boxes(gpu, encoder, shown);
        let tiles = tile_pass.lists(gpu, encoder, asked, false, &boxes);
        if let Some(tiles) = &tiles {
            for (rig, shown) in cells.sight_of_rig.iter().enumerate().take(rigs as usize) {
                let inputs = vec![
                    (0, frame.as_entire_binding()),
                    (1, texture(&cells.places)),
                    (6, inference.clone()),
                ];
                let parts = vec![Part { rig, region: None, inputs }];
                let sights = Sights { shown, ranks: &cells.ranks, parts };
                self.sight.draw(gpu, encoder, evidence, tiles, sights);
            }
        }
        let [costs, costs_x] = &cells.costs;
        let bindings = vec![inference.clone(), texture(&cells.sights)];
        self.cost.draw(gpu, encoder, bindings, &[costs]);
        let [along_x, along_y] = &self.windows;
        along_x.draw(gpu, encoder, vec![inference.clone(), texture(costs)], &[costs_x]);
        along_y.draw(gpu, encoder, vec![inference.clone(), texture(costs_x)], &[costs]);
        let settled = &cells.settled;
        // Where there is none before, it is not looked at.
        let settled_before = past.as_ref().map_or(settled, |past| &past.settled);
        let bindings = vec![
            inference.clone(),
            texture(&cells.rays),
            texture(costs),
            texture(&cells.diffused),
            before,
            texture(settled_before),
        ];
        self.choose.draw(gpu, encoder, bindings, &[&cells.chosen]);
        let bindings = vec![inference.clone(), texture(&cells.diffused), texture(&cells.chosen)];
        self.settle.draw(gpu, encoder, bindings, &[settled]);
        let mut bindings = evidence.rays.bindings().to_vec();
        bindings.extend([inference, texture(settled)]);
        let fill = evidence.rays.pass(&self.fill);
        fill.draw_marked(gpu, encoder, bindings, &[positions], &targets.marks);

        // By turns: what this picture was compared with is drawn into by the next.
        let free = past.map_or_else(|| Cells::inverses(gpu, grid), |past| past.settled);
        let settled = std::mem::replace(&mut cells.settled, free);
        self.past = Some(Past { camera: view.camera, grid, settled });
    }
}

/// Textures over the cells of the last picture.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct LastCells<'a> {
    pub(crate) rays: &'a wgpu::TextureView,
    pub(crate) diffused: &'a wgpu::TextureView,
    /// One a rig, all hypotheses one below the other.
    pub(crate) sights: &'a [wgpu::TextureView],
    pub(crate) settled: &'a wgpu::TextureView,
}

/// The picture before as that from `view` sees it.
fn before_data(before: &PosedCamera, view: &View, grid: Grid) -> gpu_data::Before {
    let axes = before.cam_from_world.transpose();
    gpu_data::Before {
        lens: lens::gpu_data::Lens::new(&before.lens),
        right: axes.x_axis.as_vec3().to_array(),
        down: axes.y_axis.as_vec3().to_array(),
        forward: axes.z_axis.as_vec3().to_array(),
        eye: (before.centre - view.eye()).as_vec3().to_array(),
        step: grid.step as f32,
        ..Default::default()
    }
}
