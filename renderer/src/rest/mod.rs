//! Which of the farther rigs count where the nearest have spoken.
//!
//! Most of a picture is seen by the two nearest rigs, and what the others would add to it there is less
//! than can be seen. So the nearest are drawn first; then it is found, pixel by pixel, which others
//! may have a share that counts, and only those are drawn, in the tiles that have such pixels, where a depth test
//! lets them through.
//!
//! Equations and reasons are in reference.rs.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use bytemuck::Zeroable as _;
use glam::{UVec2, Vec3};
use wgpu::util::DeviceExt as _;

use crate::screen::WHOLE_WGSL;
use crate::shade::photograph::Drawn;
use crate::shade::reference::NEAREST_M;
use crate::shade::{BLEND_WGSL, CHOICE_FORMAT, blend_format};
use crate::surface::PLACE_WGSL;
use crate::tiles::{TileBoxes, tiles_of};
use crate::{Gpu, octahedral};

pub(crate) mod reference;
#[cfg(test)]
mod tests;

pub(crate) use reference::NEAREST;

/// What is heard of a photograph, to be put before the shaders that draw those of farther rigs.
pub(crate) const HEARD_WGSL: &str = include_str!("heard.wgsl");

/// The shader that finds out who counts.
pub(crate) fn limit_wgsl() -> String {
    [octahedral::WGSL, PLACE_WGSL, BLEND_WGSL, HEARD_WGSL, include_str!("rest.wgsl")].concat()
}

/// The shader that lets through who counts.
pub(crate) fn admit_wgsl() -> String {
    [WHOLE_WGSL, include_str!("admit.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Rig` in rest.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Rig {
        pub(crate) centre: [f32; 3],
        pub(crate) reach: f32,
        pub(crate) weight: f32,
        pub(crate) floor: f32,
        pub(crate) index: u32,
        pub(crate) padding: u32,
    }
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct RestPass {
    module: wgpu::ShaderModule,
    /// By how many rigs they ask, made when first needed.
    limit: Mutex<BTreeMap<usize, wgpu::ComputePipeline>>,
    admit: wgpu::RenderPipeline,
}

/// What is known of pixels of which the nearest have spoken: two f32.
pub(crate) const LIMITS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;
/// Room for rigs, as in rest.wgsl: one for each bit of a word that says who is asked, less the nearest.
pub(crate) const MAX_RIGS: usize = 30;
/// Stands for all rigs that have no bit of their own.
const LAST_BIT: u32 = 31;
/// Cameras that may be anywhere.
const EVERYWHERE_M: f32 = 1e30;

/// A picture of which the nearest rigs have spoken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spoken<'a> {
    /// Pixels.
    pub(crate) size: UVec2,
    /// What the pixels show, see surface/place.wgsl.
    pub(crate) positions: &'a wgpu::TextureView,
    pub(crate) orientations: &'a wgpu::TextureView,
    /// Linear colours times their weight, and that.
    pub(crate) nearest: &'a wgpu::TextureView,
    /// Of [`LIMITS_FORMAT`]: takes the depth behind which rigs do not count, and the weight of what was said.
    pub(crate) limits: &'a wgpu::TextureView,
}

/// Who counts, to be drawn before the rest.
#[derive(Debug)]
pub(crate) struct Admitted {
    group: wgpu::BindGroup,
}

impl RestPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = |label, source: String| {
            gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        let admit_module = module("admit", admit_wgsl());
        let admit = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("admit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &admit_module,
                entry_point: Some("vs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: CHOICE_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &admit_module,
                entry_point: Some("fs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: blend_format(gpu),
                    blend: None,
                    write_mask: wgpu::ColorWrites::empty(),
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { module: module("limit", limit_wgsl()), limit: Mutex::default(), admit }
    }

    /// Finds out where the photographs of `rest` count, ordered by rig, and tells the tiles.
    pub(crate) fn limit(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        rest: &[Drawn],
        spoken: Spoken<'_>,
        boxes: &TileBoxes,
    ) -> Admitted {
        let Spoken { size, positions, orientations, nearest, limits } = spoken;
        let rigs = rigs_of(rest);
        let pipeline = self.limit_of(gpu, rigs.len());
        let mut room = [gpu_data::Rig::zeroed(); MAX_RIGS];
        room.iter_mut().zip(rigs).for_each(|(slot, rig)| *slot = rig);
        let rigs = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("rest"),
            contents: bytemuck::cast_slice(&room),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let view = wgpu::BindingResource::TextureView;
        let group = |layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]| {
            let entries: Vec<_> = resources
                .iter()
                .zip(0..)
                .map(|(resource, binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: resource.clone(),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("rest"),
                layout,
                entries: &entries,
            })
        };
        let resources = [
            view(positions),
            view(orientations),
            view(nearest),
            rigs.as_entire_binding(),
            view(limits),
            boxes.boxes.as_entire_binding(),
        ];
        let limited = group(&pipeline.get_bind_group_layout(0), &resources);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &limited, &[]);
        let tiles = tiles_of(size);
        pass.dispatch_workgroups(tiles.x, tiles.y, 1);
        Admitted { group: group(&self.admit.get_bind_group_layout(0), &[view(limits)]) }
    }

    fn limit_of(&self, gpu: &Gpu, rigs: usize) -> wgpu::ComputePipeline {
        let mut made = self.limit.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("limit"),
                layout: None,
                module: &self.module,
                entry_point: Some("limit"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("RIGS", rigs as f64)],
                    ..Default::default()
                },
                cache: None,
            })
        };
        made.entry(rigs).or_insert_with(make).clone()
    }

    /// Sets depths behind which whoever counts is seen.
    pub(crate) fn admit(&self, pass: &mut wgpu::RenderPass<'_>, admitted: &Admitted) {
        pass.set_pipeline(&self.admit);
        pass.set_bind_group(0, &admitted.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// What can be said of the rigs of photographs together. Beyond so many rigs, which no default has, all are
/// asked everywhere.
fn rigs_of(photographs: &[Drawn]) -> Vec<gpu_data::Rig> {
    let rigs = photographs.chunk_by(|a, b| a.rig == b.rig).filter_map(rig_of);
    let (mut known, beyond): (Vec<_>, Vec<_>) = rigs.partition(|rig| rig.index < LAST_BIT);
    known.extend(
        beyond
            .into_iter()
            .reduce(|a, b| gpu_data::Rig {
                floor: a.floor.min(b.floor),
                weight: a.weight.max(b.weight),
                ..a
            })
            .map(|rig| gpu_data::Rig { reach: EVERYWHERE_M, index: LAST_BIT, ..rig }),
    );
    known
}

/// The photographs of one rig together.
fn rig_of(photographs: &[Drawn]) -> Option<gpu_data::Rig> {
    let first = photographs.first()?;
    let centre_of = |drawn: &Drawn| Vec3::from_array(drawn.data.centre);
    let sum: Vec3 = photographs.iter().map(centre_of).sum();
    let centre = sum / photographs.len() as f32;
    let far = photographs.iter().map(|drawn| centre_of(drawn).distance(centre));
    // Centres are rounded.
    let reach = far.fold(0.0, f32::max) * 1.001 + 1e-6 * centre.length();
    // What equation 4 has for an eye at the rig itself.
    let nearest_2 = NEAREST_M.powi(2) as f32;
    Some(gpu_data::Rig {
        centre: centre.to_array(),
        reach,
        weight: first.data.rig_weight * nearest_2 / (first.data.eye_distance_2 + nearest_2),
        floor: first.data.rig_floor,
        index: first.rig as u32,
        padding: 0,
    })
}
