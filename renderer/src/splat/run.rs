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

/// The blocks of a draw list on the device; `None` for an empty one: buffers cannot be empty.
pub(super) fn uploaded(gpu: &Gpu, list: &DrawList) -> Option<wgpu::Buffer> {
    (!list.blocks.is_empty()).then(|| {
        gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("point draw list"),
            contents: bytemuck::cast_slice(&list.blocks),
            usage: wgpu::BufferUsages::STORAGE,
        })
    })
}

/// One run over the points of a list.
pub(super) struct Run<'a> {
    pub(super) pipeline: &'a wgpu::ComputePipeline,
    /// Bound from 3 on.
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
        drawn: &wgpu::Buffer,
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
                let bind_group = self.bind_group(gpu, store, *page, drawn, binding.clone());
                pass.set_bind_group(0, &bind_group, &[]);
                // A page has at most 8192 blocks, far below the limit of a row of workgroups.
                pass.dispatch_workgroups(strip(blocks), STRIPS, 1);
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
        drawn: &wgpu::Buffer,
        job: wgpu::BufferBinding<'_>,
    ) -> wgpu::BindGroup {
        let (points, normals) = store.page(page);
        let targets = self.targets.iter().cloned().map(wgpu::BindingResource::Buffer);
        let mut resources = vec![
            (0, wgpu::BindingResource::Buffer(job)),
            (1, points.as_entire_binding()),
            (2, drawn.as_entire_binding()),
        ];
        resources.extend((3..).zip(targets));
        resources.extend(normals.map(|normals| (5, normals.as_entire_binding())));
        resources.extend(self.quads.bindings());
        bind_group_at(gpu, "splat", &self.pipeline.get_bind_group_layout(0), resources)
    }
}

/// Blocks of the longest strip, whole runs.
fn strip(blocks: &std::ops::Range<u32>) -> u32 {
    (blocks.end - blocks.start).div_ceil(STRIPS * RUN) * RUN
}
