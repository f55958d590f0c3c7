//! Points textured by the homographies of their planes.
//!
//! The point that a pixel shows lies on a plane, and a plane between two pinholes is a homography:
//! computed once a point and photograph by the vertex stage, it takes the pixels of the view
//! straight to the photograph. The poster of Devaux and Brédif has it evaluated at every pixel of
//! a point's sprite, or else the photograph's coordinates interpolated between the corners of a
//! splat. Both are here, beside the deferred way that projects the position of every pixel.
//!
//! The pixels are first gathered into sprites, one for each point and plane on which it is
//! shown: a box around the pixels that the point won. Those are what the vertex stage draws, so
//! that points nobody sees cost nothing. Mesh stays with the deferred way. So do points
//! in views with a lens, whose pixels no linear map reaches, and in orthographic ones.

use wgpu::util::DeviceExt as _;

use crate::bindings::bind_group;
use crate::camera::gpu_data::Camera;
use crate::settings::Texturing;
use crate::surface::PLACE_WGSL;
use crate::targets::Targets;
use crate::{Gpu, camera, octahedral, shade, splat};

pub(crate) mod memory;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;

const HOMOGRAPHY_WGSL: &str = include_str!("homography.wgsl");

/// Corners of a sprite: a strip of two triangles.
pub(crate) const CORNERS: u32 = 4;

/// The shader that gathers sprites.
pub(crate) fn gather_wgsl() -> String {
    [camera::WGSL, octahedral::WGSL, PLACE_WGSL, include_str!("gather.wgsl")].concat()
}

/// The shader that colours them; `None` where they are none.
pub(crate) fn sprites_wgsl(texturing: Texturing) -> Option<String> {
    let method = match texturing {
        Texturing::Deferred => return None,
        Texturing::Homography => include_str!("by_homography.wgsl"),
        Texturing::Barycentric => include_str!("by_corners.wgsl"),
    };
    let (colour, sprites) = (shade::colour_wgsl(), include_str!("sprites.wgsl"));
    let parts = [&colour, camera::WGSL, splat::PLANE_WGSL, HOMOGRAPHY_WGSL, sprites, method];
    Some(parts.concat())
}

pub(crate) mod gpu_data {
    use crate::camera::gpu_data::Camera;

    /// Mirrors `View` in gather.wgsl and sprites.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct View {
        pub(crate) camera: Camera,
        pub(crate) index_stride: u32,
        pub(crate) padding_0: u32,
        pub(crate) padding_1: u32,
        pub(crate) padding_2: u32,
    }
}

/// The pipelines of this pass, and its buffers, kept between frames.
#[derive(Debug)]
pub(crate) struct ForwardPass {
    texturing: Texturing,
    gather: Gather,
    colour: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    buffers: Option<Buffers>,
}

#[derive(Debug)]
struct Gather {
    layout: wgpu::BindGroupLayout,
    claim: wgpu::ComputePipeline,
    gather: wgpu::ComputePipeline,
}

#[derive(Debug)]
struct Buffers {
    homes: wgpu::Buffer,
    reaches: wgpu::Buffer,
    sprites: wgpu::Buffer,
}

/// Where the splat pass left the index of the point that each pixel shows.
#[derive(Clone, Debug)]
pub(crate) struct Indices<'a> {
    pub(crate) words: wgpu::BufferBinding<'a>,
    /// Words between the indices of two pixels.
    pub(crate) stride: u32,
    /// All indices are lower.
    pub(crate) end: u64,
}

/// The sprites of a frame.
#[derive(Debug)]
pub(crate) struct Sprites<'a> {
    pub(crate) texturing: Texturing,
    pub(crate) module: &'a wgpu::ShaderModule,
    /// Of their group, the third.
    pub(crate) layout: &'a wgpu::BindGroupLayout,
    pub(crate) group: wgpu::BindGroup,
    /// Of an indirect draw.
    pub(crate) arguments: wgpu::Buffer,
}

impl ForwardPass {
    /// `None` for the deferred way, which needs none.
    pub(crate) fn new(gpu: &Gpu, texturing: Texturing) -> Option<Self> {
        let colour = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("sprites"),
            source: wgpu::ShaderSource::Wgsl(sprites_wgsl(texturing)?.into()),
        });
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let layout = layout(
            gpu,
            "sprites",
            stages,
            &[UNIFORM, UINT_TEXTURE, UINT_TEXTURE, FLOAT_TEXTURE, READ, READ, READ],
        );
        Some(Self { texturing, gather: Gather::new(gpu), colour, layout, buffers: None })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.buffers.as_ref().map_or(0, |b| b.homes.size() + b.reaches.size() + b.sprites.size())
    }

    /// Gives its buffers back.
    pub(crate) fn release(&mut self) {
        self.buffers = None;
    }

    /// Gathers the sprites of what the surface pass left in `targets`, in buffers of at most `room`
    /// bytes. `None` where points are left to the deferred way.
    #[expect(clippy::too_many_arguments, reason = "one argument a source and target")]
    pub(crate) fn gather(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        distorted: bool,
        indices: Indices<'_>,
        targets: &Targets,
        room: u64,
    ) -> Option<Sprites<'_>> {
        let [width, height] = camera.size;
        let bytes = memory::Bytes::of_frame(u64::from(width) * u64::from(height), indices.end);
        let fits = bytes.largest() <= gpu.device.limits().max_storage_buffer_binding_size
            && bytes.total() <= room;
        if distorted || camera.orthographic == 1 || indices.end == 0 || !fits {
            return None;
        }
        if !self.buffers.as_ref().is_some_and(|buffers| buffers.hold(&bytes)) {
            // Freed before it is replaced.
            self.buffers = None;
        }
        let buffers = self.buffers.get_or_insert_with(|| Buffers::new(gpu, &bytes));
        let view = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("sprites"),
            contents: bytemuck::bytes_of(&gpu_data::View {
                camera: *camera,
                index_stride: indices.stride,
                padding_0: 0,
                padding_1: 0,
                padding_2: 0,
            }),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let arguments = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("sprites"),
            contents: bytemuck::bytes_of(&[CORNERS, 0, 0, 0]),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
        });
        encoder.clear_buffer(&buffers.homes, 0, None);
        encoder.clear_buffer(&buffers.reaches, 0, None);
        let texture = wgpu::BindingResource::TextureView;
        let words = wgpu::BindingResource::Buffer;
        let group = bind_group(
            gpu,
            "sprites",
            &self.gather.layout,
            [
                view.as_entire_binding(),
                texture(&targets.records.positions),
                texture(&targets.records.orientations),
                words(indices.words.clone()),
                buffers.homes.as_entire_binding(),
                buffers.reaches.as_entire_binding(),
                buffers.sprites.as_entire_binding(),
                arguments.as_entire_binding(),
            ],
        );
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, &group, &[]);
            for pipeline in [&self.gather.claim, &self.gather.gather] {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(width.div_ceil(16), height.div_ceil(16), 1);
            }
        }
        let group = bind_group(
            gpu,
            "sprites",
            &self.layout,
            [
                view.as_entire_binding(),
                texture(&targets.winners),
                texture(&targets.winning_normals),
                texture(&targets.planes),
                words(indices.words),
                buffers.sprites.as_entire_binding(),
                buffers.reaches.as_entire_binding(),
            ],
        );
        let (module, layout) = (&self.colour, &self.layout);
        Some(Sprites { texturing: self.texturing, module, layout, group, arguments })
    }
}

impl Gather {
    fn new(gpu: &Gpu) -> Self {
        let layout = layout(
            gpu,
            "gather",
            wgpu::ShaderStages::COMPUTE,
            &[UNIFORM, UINT_TEXTURE, UINT_TEXTURE, READ, WRITE, WRITE, WRITE, WRITE],
        );
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("gather"),
            source: wgpu::ShaderSource::Wgsl(gather_wgsl().into()),
        });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("gather"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { claim: pipeline("claim"), gather: pipeline("gather"), layout }
    }
}

impl Buffers {
    fn new(gpu: &Gpu, bytes: &memory::Bytes) -> Self {
        let buffer = |label, size| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            homes: buffer("homes", bytes.homes),
            reaches: buffer("reaches", bytes.reaches),
            sprites: buffer("sprites", bytes.sprites),
        }
    }

    fn hold(&self, bytes: &memory::Bytes) -> bool {
        (bytes.homes..=2 * bytes.homes).contains(&self.homes.size())
            && self.reaches.size() == bytes.reaches
            && self.sprites.size() == bytes.sprites
    }
}

const UNIFORM: wgpu::BindingType = buffer(wgpu::BufferBindingType::Uniform);
const READ: wgpu::BindingType = buffer(wgpu::BufferBindingType::Storage { read_only: true });
const WRITE: wgpu::BindingType = buffer(wgpu::BufferBindingType::Storage { read_only: false });
const UINT_TEXTURE: wgpu::BindingType = texture(wgpu::TextureSampleType::Uint);
const FLOAT_TEXTURE: wgpu::BindingType =
    texture(wgpu::TextureSampleType::Float { filterable: false });

const fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

const fn texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    let view_dimension = wgpu::TextureViewDimension::D2;
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// Of `types`, bound in their order from 0.
fn layout(
    gpu: &Gpu,
    label: &str,
    visibility: wgpu::ShaderStages,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
        .collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}
