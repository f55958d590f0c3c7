//! Which of the farther rigs count where the nearest have spoken.
//!
//! Most of a picture is seen by the two nearest rigs, and what the others would add to it there is less
//! than can be seen. So the nearest are drawn first; then it is found, pixel by pixel, which others
//! may have a share that counts, and only those are drawn, in the tiles that have such pixels, where a depth test
//! lets them through.
//!
//! Equations and reasons are in reference.rs.

use bytemuck::Zeroable as _;
use glam::Vec3;
use wgpu::util::DeviceExt as _;

use crate::bindings::bind_group;
use crate::screen::VIEWPORT_WGSL;
use crate::shade::photograph::Drawn;
use crate::shade::reference::NEAREST_M;
use crate::shade::{BLEND_WGSL, CHOICE_FORMAT};
use crate::surface::PLACE_WGSL;
use crate::tiles::TileBoxes;
use crate::{Gpu, octahedral};

pub(crate) mod reference;
#[cfg(test)]
mod tests;

pub(crate) use reference::NEAREST;

/// What is heard of a photograph, to be put before the shaders that draw those of farther rigs.
pub(crate) const HEARD_WGSL: &str = include_str!("heard.wgsl");

/// The shader that finds out who counts.
pub(crate) fn limit_wgsl() -> String {
    let parts = [octahedral::WGSL, PLACE_WGSL, VIEWPORT_WGSL, BLEND_WGSL, HEARD_WGSL];
    [&parts.concat(), include_str!("limit.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Rig` in limit.wgsl.
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

/// The pipeline of this pass.
#[derive(Debug)]
pub(crate) struct RestPass {
    limit: wgpu::RenderPipeline,
}

/// The weight of what was said of pixels of which the nearest have spoken.
pub(crate) const SAID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// Room for rigs, as in limit.wgsl: one for each bit of a word that says who is asked, less the nearest.
pub(crate) const MAX_RIGS: usize = 30;
/// How many are asked at once, as in limit.wgsl: those of eight, less the nearest.
pub(crate) const AT_ONCE: usize = 6;
/// Stands for all rigs that have no bit of their own.
const LAST_BIT: u32 = 31;
/// Cameras that may be anywhere.
const EVERYWHERE_M: f32 = 1e30;

/// A picture of which the nearest rigs have spoken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spoken<'a> {
    /// What the pixels show, see surface/place.wgsl.
    pub(crate) positions: &'a wgpu::TextureView,
    pub(crate) orientations: &'a wgpu::TextureView,
    /// Linear colours times their weight, and that.
    pub(crate) nearest: &'a wgpu::TextureView,
    /// Of [`SAID_FORMAT`]: takes the weight of what was said.
    pub(crate) said: &'a wgpu::TextureView,
    /// Of [`CHOICE_FORMAT`]: takes the depths behind which rigs do not count.
    pub(crate) choice: &'a wgpu::TextureView,
}

impl RestPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("limit"),
            source: wgpu::ShaderSource::Wgsl(limit_wgsl().into()),
        });
        let limit = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("limit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            // Each instance leaves the least depth.
            depth_stencil: Some(wgpu::DepthStencilState {
                format: CHOICE_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::LessEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(SAID_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { limit }
    }

    /// Finds out where the photographs of `rest` count, ordered by rig; which of them are asked about which
    /// tile is in the boxes that come back.
    pub(crate) fn limit(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        rest: &[Drawn],
        spoken: Spoken<'_>,
        boxes: &TileBoxes,
    ) -> TileBoxes {
        let Spoken { positions, orientations, nearest, said, choice } = spoken;
        let rigs = rigs_of(rest);
        let instances = rigs.len().div_ceil(AT_ONCE) as u32;
        let mut room = [gpu_data::Rig::zeroed(); MAX_RIGS];
        room.iter_mut().zip(rigs).for_each(|(slot, rig)| *slot = rig);
        let rigs = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("rest"),
            contents: bytemuck::cast_slice(&room),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let boxes = boxes.asking_nobody(gpu);
        let view = wgpu::BindingResource::TextureView;
        let group = bind_group(
            gpu,
            "rest",
            &self.limit.get_bind_group_layout(0),
            [
                view(positions),
                view(orientations),
                view(nearest),
                rigs.as_entire_binding(),
                boxes.asked.as_entire_binding(),
            ],
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("rest"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: said,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    // All of it is written.
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: choice,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Discard,
                }),
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.limit);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..instances);
        drop(pass);
        boxes
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
