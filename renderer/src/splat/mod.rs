//! Points as perspective-correct discs, by compute.
//!
//! Each point stands for a disc on a plane through it, which faces the eye or has the normal of
//! the point's neighbours; a pixel inside takes the depth of that plane on its own ray. The
//! nearest disc has the pixel, and among equally near ones that of lowest index, by one atomic
//! of 64 bits or two phases of 32. The same pass fills the view's buffers and the photographs'
//! depth maps.

use crate::bindings::bind_group;
use crate::camera::gpu_data::Camera;
use crate::points::{DrawList, PointStore};
use crate::settings::{SplatNormals, SplatRoute};
use crate::{Gpu, Settings, camera, octahedral};

use quads::Quads;
use resolve::Resolve;
use run::{Run, uploaded};

mod nearest;
pub(crate) mod quads;
pub(crate) mod reference;
mod resolve;
mod run;
#[cfg(test)]
mod tests;

pub(crate) use nearest::{Nearest, Route};
pub(crate) use resolve::{WINNERS_FORMAT, WINNING_NORMALS_FORMAT};
#[cfg(test)]
pub(crate) use resolve::{gpu_data as resolve_data, wgsl as resolve_wgsl};

/// The radius of the circle around a square pixel: smaller discs may miss every centre.
pub(crate) const MIN_RADIUS_PX: f32 = 0.708;
/// Largest radius of a disc on a view, pixels.
pub(crate) const MAX_RADIUS_PX: f32 = 96.0;
/// Discs whose box has more pixels are drawn as quads, unless the settings say otherwise. On
/// lavapipe quads are as fast from 1000 pixels on, and a tenth faster from 4000.
const QUADS_FROM_PX_IN_SOFTWARE: u32 = 1024;
/// On hardware the threads beside a large disc wait for its loop.
const QUADS_FROM_PX: u32 = 128;
/// Largest radius of a disc on a depth map, texels.
pub(crate) const MAX_MAP_RADIUS_PX: f32 = 12.0;
/// Largest radius of a disc on a depth map, metres.
pub(crate) const MAX_MAP_RADIUS_M: f32 = 0.1;
/// Discs on depth maps that face the photograph lie behind their point by this share of their
/// radius: the surface they stand for may be inclined by up to atan 2.5 = 68° without hiding
/// itself.
pub(crate) const MAP_PUSH: f32 = 2.5;
/// The same for discs on the plane of their neighbours, which are off by a few degrees.
pub(crate) const MAP_PUSH_ON_PLANE: f32 = 0.25;

/// The plane of a disc, to be put before the shaders that use it.
pub(crate) const PLANE_WGSL: &str = include_str!("plane.wgsl");
/// A block that is drawn.
const DRAWN_WGSL: &str = include_str!("drawn.wgsl");
/// The shader that empties buffers.
pub(crate) const FILL_WGSL: &str = include_str!("fill.wgsl");

/// The shader that draws discs by compute.
pub(crate) fn wgsl(route: Route, normals: SplatNormals) -> String {
    let (octahedral, normals) = match normals {
        SplatNormals::Eye => ("", include_str!("eye.wgsl")),
        SplatNormals::Estimated => (octahedral::WGSL, include_str!("estimated.wgsl")),
    };
    let (postpone, splat) = (include_str!("postpone.wgsl"), include_str!("splat.wgsl"));
    [&disc_wgsl(route), octahedral, normals, DRAWN_WGSL, postpone, splat].concat()
}

/// The shader that draws large discs as quads.
pub(crate) fn quads_wgsl(route: Route) -> String {
    [&disc_wgsl(route), include_str!("quads.wgsl")].concat()
}

/// What both need.
fn disc_wgsl(route: Route) -> String {
    let nearest = match route {
        Route::Atomic32 => include_str!("nearest_32.wgsl"),
        Route::Atomic64 => include_str!("nearest_64.wgsl"),
    };
    let (disc, large, job) =
        (include_str!("disc.wgsl"), include_str!("large.wgsl"), include_str!("job.wgsl"));
    [camera::WGSL, PLANE_WGSL, disc, large, job, nearest].concat()
}

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;

    /// Mirrors `Job` in job.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Job {
        pub(crate) camera: Camera,
        pub(crate) phase: u32,
        pub(crate) first_block: u32,
        pub(crate) end_block: u32,
        pub(crate) stride: u32,
        pub(crate) min_radius_px: f32,
        pub(crate) max_radius_px: f32,
        pub(crate) push: f32,
        pub(crate) push_on_plane: f32,
        pub(crate) most_pixels: u32,
        pub(crate) padding_0: u32,
        pub(crate) padding_1: u32,
        pub(crate) padding_2: u32,
    }
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct SplatPass {
    route: SplatRoute,
    atomic_32: wgpu::ComputePipeline,
    /// Where the device has such atomics.
    atomic_64: Option<wgpu::ComputePipeline>,
    quads: Quads,
    /// Discs of more pixels than this are drawn as quads.
    most_pixels: u32,
    resolve: Resolve,
    fill: wgpu::ComputePipeline,
    /// Stands in for indices where only depth is wanted.
    no_indices: wgpu::Buffer,
}

/// Where a view's points go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewTarget<'a> {
    pub(crate) nearest: &'a Nearest,
    pub(crate) winners: &'a wgpu::TextureView,
    pub(crate) winning_normals: &'a wgpu::TextureView,
    pub(crate) canvas: &'a wgpu::TextureView,
}

impl SplatPass {
    pub(crate) fn new(gpu: &Gpu, settings: &Settings) -> Self {
        let pipeline = |label, source: String| {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let normals = settings.splat_normals;
        Self {
            route: settings.splat_route,
            atomic_32: pipeline("splat", wgsl(Route::Atomic32, normals)),
            atomic_64: gpu
                .has_64_bit_atomics()
                .then(|| pipeline("splat", wgsl(Route::Atomic64, normals))),
            quads: Quads::new(gpu, settings.shares().large_discs),
            most_pixels: most_pixels(gpu, settings),
            resolve: Resolve::new(gpu, normals),
            fill: pipeline("fill", FILL_WGSL.to_owned()),
            no_indices: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("no indices"),
                size: 4,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.quads.bytes() + self.no_indices.size()
    }

    /// Draws by the route of `settings` from now on, where the device has it.
    pub(crate) fn set_route(&mut self, gpu: &Gpu, settings: &Settings) {
        self.route = settings.splat_route;
        self.most_pixels = most_pixels(gpu, settings);
    }

    /// How views of so many pixels are drawn.
    pub(crate) fn route(&self, gpu: &Gpu, pixels: u64) -> Route {
        let fits = 8 * pixels <= gpu.device.limits().max_storage_buffer_binding_size;
        match self.route {
            SplatRoute::Auto | SplatRoute::Atomic64 if fits && self.atomic_64.is_some() => {
                Route::Atomic64
            }
            _ => Route::Atomic32,
        }
    }

    /// Draws `list` into a view: afterwards `winners` tells which point is seen where.
    pub(crate) fn draw_view(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        camera: &Camera,
        target: ViewTarget<'_>,
    ) {
        for words in target.nearest.words() {
            self.clear(gpu, encoder, words);
        }
        let blocks = uploaded(gpu, list);
        if let Some(blocks) = &blocks {
            let (pipeline, phases): (_, &[u32]) = match (target.nearest.route(), &self.atomic_64) {
                (Route::Atomic64, Some(pipeline)) => (pipeline, &[0]),
                _ => (&self.atomic_32, &[0, 1]),
            };
            let run = Run {
                pipeline,
                targets: target.nearest.bindings(),
                phases,
                job: gpu_data::Job {
                    most_pixels: self.most_pixels,
                    ..job(camera, camera.size[0], MAX_RADIUS_PX, [0.0; 2])
                },
                quads: &self.quads,
                canvas: (self.most_pixels < u32::MAX).then_some((target.nearest, target.canvas)),
            };
            run.encode(gpu, encoder, store, list, blocks);
        }
        self.resolve.draw(gpu, encoder, store, list, blocks.as_ref(), target);
    }

    /// Adds `list` to a depth map, of rows of `stride` texels.
    #[expect(clippy::too_many_arguments, reason = "one argument a source and target")]
    pub(crate) fn draw_depth(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        camera: &Camera,
        depths: &wgpu::BufferBinding<'_>,
        stride: u32,
    ) {
        let Some(blocks) = uploaded(gpu, list) else { return };
        let run = Run {
            pipeline: &self.atomic_32,
            targets: vec![depths.clone(), self.no_indices.as_entire_buffer_binding()],
            phases: &[0],
            job: job(camera, stride, MAX_MAP_RADIUS_PX, [MAP_PUSH, MAP_PUSH_ON_PLANE]),
            quads: &self.quads,
            canvas: None,
        };
        run.encode(gpu, encoder, store, list, &blocks);
    }

    /// Sets every word to "nothing here"; they are a multiple of four.
    pub(crate) fn clear(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        words: wgpu::BufferBinding<'_>,
    ) {
        let bytes = words.size.map_or(words.buffer.size(), std::num::NonZero::get);
        let layout = self.fill.get_bind_group_layout(0);
        let group = bind_group(gpu, "fill", &layout, [wgpu::BindingResource::Buffer(words)]);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.fill);
        pass.set_bind_group(0, &group, &[]);
        // A row of workgroups has a limit of 65535.
        let groups = u32::try_from(bytes.div_ceil(16 * 256)).unwrap_or(u32::MAX);
        let columns = groups.clamp(1, 4096);
        pass.dispatch_workgroups(columns, groups.div_ceil(columns), 1);
    }
}

/// Discs of more pixels than this are drawn as quads.
fn most_pixels(gpu: &Gpu, settings: &Settings) -> u32 {
    let suits = if gpu.is_software() { QUADS_FROM_PX_IN_SOFTWARE } else { QUADS_FROM_PX };
    settings.quads_from_px.unwrap_or(suits)
}

/// A job for all points. `push`: of discs that face the eye, and of those on a plane.
fn job(camera: &Camera, stride: u32, max_radius_px: f32, push: [f32; 2]) -> gpu_data::Job {
    gpu_data::Job {
        camera: *camera,
        phase: 0,
        first_block: 0,
        end_block: 0,
        stride,
        min_radius_px: MIN_RADIUS_PX,
        max_radius_px,
        push: push[0],
        push_on_plane: push[1],
        most_pixels: u32::MAX,
        padding_0: 0,
        padding_1: 0,
        padding_2: 0,
    }
}
