//! Runs over the points of a list.

use wgpu::util::DeviceExt as _;

use super::quads::Quads;
use super::{Nearest, gpu_data};
use crate::Gpu;
use crate::bindings::bind_group_at;
use crate::points::{DrawList, PointStore};

/// Strips that a page's blocks are dealt out to; `STRIPS` in splat.wgsl.
const STRIPS: u32 = 16;
/// Blocks that a strip has on end; `RUN` in splat.wgsl.
const RUN: u32 = 32;
/// Uniforms start at multiples of this on every device.
const JOB_STRIDE: usize = 256;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct PaddedJob {
    job: gpu_data::Job,
    padding: [u32; (JOB_STRIDE - size_of::<gpu_data::Job>()) / 4],
}

/// A draw list on the device.
#[derive(Debug)]
pub(super) struct Uploaded {
    pub(super) blocks: wgpu::Buffer,
    pub(super) placements: wgpu::Buffer,
}

impl Uploaded {
    /// `None` for an empty list: buffers cannot be empty.
    pub(super) fn new(gpu: &Gpu, list: &DrawList) -> Option<Self> {
        let buffer = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("point draw list"),
                contents,
                usage: wgpu::BufferUsages::STORAGE,
            })
        };
        (!list.blocks.is_empty()).then(|| Self {
            blocks: buffer(bytemuck::cast_slice(&list.blocks)),
            placements: buffer(bytemuck::cast_slice(&list.placements)),
        })
    }
}

/// One run over the points of a list.
pub(super) struct Run<'a> {
    pub(super) pipeline: &'a wgpu::ComputePipeline,
    /// Bound from 4 on.
    pub(super) targets: Vec<wgpu::BufferBinding<'a>>,
    pub(super) phases: &'static [u32],
    /// What all jobs share.
    pub(super) job: gpu_data::Job,
    pub(super) quads: &'a Quads,
    /// Where quads are drawn, if the job leaves any discs to them.
    pub(super) canvas: Option<(&'a Nearest, &'a wgpu::TextureView)>,
}

impl Run<'_> {
    /// Every phase over every page, and then over the large discs.
    pub(super) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        store: &PointStore,
        list: &DrawList,
        uploaded: &Uploaded,
    ) {
        let jobs: Vec<PaddedJob> = self
            .phases
            .iter()
            .flat_map(|&phase| list.pages.iter().map(move |(_, blocks)| (phase, blocks)))
            .map(|(phase, blocks)| {
                let job = gpu_data::Job {
                    phase,
                    first_block: blocks.start,
                    end_block: blocks.end,
                    strip: strip(blocks),
                    ..self.job
                };
                PaddedJob { job, padding: [0; _] }
            })
            .collect();
        let jobs = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("splat jobs"),
            contents: bytemuck::cast_slice(&jobs),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
        });
        let mut offsets = (0..).step_by(JOB_STRIDE);
        for _ in self.phases {
            let mut job = None;
            self.quads.reset(encoder);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(self.pipeline);
            for ((page, blocks), offset) in list.pages.iter().zip(&mut offsets) {
                let binding = wgpu::BufferBinding {
                    buffer: &jobs,
                    offset,
                    size: std::num::NonZero::new(size_of::<gpu_data::Job>() as u64),
                };
                let bind_group = self.bind_group(gpu, store, *page, uploaded, binding.clone());
                pass.set_bind_group(0, &bind_group, &[]);
                // A page has at most 8192 blocks, far below the limit of a row of workgroups.
                pass.dispatch_workgroups(STRIPS * strip(blocks), 1, 1);
                job = Some(binding);
            }
            drop(pass);
            if let (Some(job), Some((nearest, canvas))) = (job, self.canvas) {
                self.quads.draw(gpu, encoder, job, nearest, canvas);
            }
        }
    }

    fn bind_group(
        &self,
        gpu: &Gpu,
        store: &PointStore,
        page: usize,
        uploaded: &Uploaded,
        job: wgpu::BufferBinding<'_>,
    ) -> wgpu::BindGroup {
        let (points, normals) = store.page(page);
        let targets = self.targets.iter().cloned().map(wgpu::BindingResource::Buffer);
        let mut resources = vec![
            (0, wgpu::BindingResource::Buffer(job)),
            (1, points.as_entire_binding()),
            (2, uploaded.blocks.as_entire_binding()),
            (3, uploaded.placements.as_entire_binding()),
        ];
        resources.extend((4..).zip(targets));
        resources.extend(normals.map(|normals| (6, normals.as_entire_binding())));
        resources.extend(self.quads.bindings());
        bind_group_at(gpu, "splat", &self.pipeline.get_bind_group_layout(0), resources)
    }
}

/// Blocks of the longest strip, whole runs.
fn strip(blocks: &std::ops::Range<u32>) -> u32 {
    (blocks.end - blocks.start).div_ceil(STRIPS * RUN) * RUN
}
