//! What photographs show of the same places, measured on the device.
//!
//! Every photograph lends a few places, spread evenly over its depth map; every photograph is
//! then asked for the colour of each, as a mean over a patch wide enough that it does not matter
//! where exactly the photographs stood.

use std::collections::BTreeMap;

use crate::bindings::{bind_group, bind_group_at};
use crate::depth_map::{DepthMaps, POINT_WGSL};
use crate::photographs::atlas::Atlas;
use crate::shade::photograph::{Drawn, Kind};
use crate::shade::{PHOTOGRAPH_WGSL, PhotographUniforms, TEXEL_WGSL};
use crate::stages::Stages;
use crate::targets::read_back;
use crate::{Gpu, RenderError, SRGB_WGSL, lens};

/// Agreement, to be put before the shaders that use it.
pub(crate) const AGREE_WGSL: &str = include_str!("agree.wgsl");
const KNOWN_WGSL: &str = include_str!("known.wgsl");

/// The shader that finds places.
pub(crate) fn spread_wgsl() -> String {
    [lens::WGSL, PHOTOGRAPH_WGSL, AGREE_WGSL, POINT_WGSL, KNOWN_WGSL, include_str!("spread.wgsl")]
        .concat()
}

/// The shader that looks their colours up.
pub(crate) fn measure_wgsl() -> String {
    [
        lens::WGSL,
        PHOTOGRAPH_WGSL,
        SRGB_WGSL,
        TEXEL_WGSL,
        AGREE_WGSL,
        POINT_WGSL,
        KNOWN_WGSL,
        include_str!("measure.wgsl"),
    ]
    .concat()
}

/// Workgroups of places that each photograph lends, by columns and rows, and for how many
/// photographs: fewer each where there are many.
const GRIDS: [(usize, [u32; 2]); 3] = [(20, [2, 2]), (48, [2, 1]), (usize::MAX, [1, 1])];
const GROUP_SIDE: u32 = 8;
const GROUP_PLACES: u32 = GROUP_SIDE * GROUP_SIDE;
const PLACE_BYTES: u64 = 16;
const SAMPLE_BYTES: u64 = 8;

/// Colours of places as photographs show them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    /// How many places each photograph lent.
    pub(crate) places_each: usize,
    /// For each photograph all places, those that the first lent first: linear red, green and
    /// blue, 0 to 1; `None` where it does not see the place.
    pub(crate) colours: Vec<Vec<Option<[f32; 3]>>>,
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct MeasurePass {
    spread: wgpu::ComputePipeline,
    /// One a kind of photograph, made when first needed.
    measure: BTreeMap<Kind, wgpu::ComputePipeline>,
    unfiltered: wgpu::Sampler,
    buffers: Option<Buffers>,
}

/// Places and their colours for so many photographs, kept until there are more or fewer.
#[derive(Debug)]
struct Buffers {
    photographs: usize,
    places: wgpu::Buffer,
    samples: wgpu::Buffer,
    readback: wgpu::Buffer,
}

impl MeasurePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            spread: pipeline(gpu, "places", spread_wgsl(), &[]),
            measure: BTreeMap::new(),
            unfiltered: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
            buffers: None,
        }
    }

    /// What [`MeasurePass::bytes`] is once so many photographs were measured.
    pub(crate) fn bytes_for(photographs: usize) -> u64 {
        if photographs < 2 {
            return 0;
        }
        let [places, samples] = buffer_bytes(photographs);
        places + 2 * samples
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let sizes = |b: &Buffers| b.places.size() + b.samples.size() + b.readback.size();
        self.buffers.as_ref().map_or(0, sizes)
    }

    /// Gives its buffers back, but where they are those of so many photographs.
    pub(crate) fn release_but(&mut self, photographs: usize) {
        self.buffers.take_if(|buffers| buffers.photographs != photographs);
    }

    /// What `photographs`, all seen from the same eye, show of places near them. Waits for the
    /// device.
    pub(crate) fn run(
        &mut self,
        gpu: &Gpu,
        stages: &mut Stages,
        photographs: &[Drawn],
        maps: &DepthMaps,
        atlas: &Atlas,
    ) -> Result<Samples, RenderError> {
        let count = photographs.len();
        let [columns, rows] = grid(count);
        let places_each = columns * rows * GROUP_PLACES;
        let places = u64::from(places_each) * count as u64;
        self.release_but(count);
        let Buffers { places: place_buffer, samples, readback, .. } =
            &*self.buffers.get_or_insert_with(|| Buffers::new(gpu, count));
        let uniforms = PhotographUniforms::new(gpu, photographs);
        for drawn in photographs {
            self.measure.entry(drawn.kind).or_insert_with(|| {
                pipeline(gpu, "measure", measure_wgsl(), &drawn.kind.constants())
            });
        }

        let view = wgpu::BindingResource::TextureView;
        let slice = |buffer, index: u64, bytes| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: index * bytes,
                size: std::num::NonZero::new(bytes),
            })
        };
        let photograph = |pipeline: &wgpu::ComputePipeline, index: u64| {
            let layout = pipeline.get_bind_group_layout(1);
            bind_group(gpu, "measure", &layout, [uniforms.of(index as usize)])
        };
        let (map_mesh, map_points) = (maps.mesh_view(), maps.points_view());
        let atlases = atlas.views();
        {
            let mut pass =
                stages.encoder().begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.spread);
            for index in 0..count as u64 {
                let own = slice(place_buffer, index, u64::from(places_each) * PLACE_BYTES);
                let resources = [(3, view(&map_mesh)), (4, view(&map_points)), (6, own)];
                let layout = self.spread.get_bind_group_layout(0);
                pass.set_bind_group(0, &bind_group_at(gpu, "spread", &layout, resources), &[]);
                pass.set_bind_group(1, &photograph(&self.spread, index), &[]);
                pass.dispatch_workgroups(columns, rows, 1);
            }
            for (index, drawn) in (0..).zip(photographs) {
                let Some(measure) = self.measure.get(&drawn.kind) else { continue };
                pass.set_pipeline(measure);
                let resources = [
                    (3, view(&map_mesh)),
                    (4, view(&map_points)),
                    (6, place_buffer.as_entire_binding()),
                    (7, slice(samples, index, places * SAMPLE_BYTES)),
                    (8, wgpu::BindingResource::Sampler(&self.unfiltered)),
                ];
                let layout = measure.get_bind_group_layout(0);
                pass.set_bind_group(0, &bind_group_at(gpu, "measure", &layout, resources), &[]);
                pass.set_bind_group(1, &photograph(measure, index), &[]);
                let layout = measure.get_bind_group_layout(2);
                let group = bind_group(gpu, "measure", &layout, [view(&atlases[drawn.atlas])]);
                pass.set_bind_group(2, &group, &[]);
                pass.dispatch_workgroups(columns * rows * count as u32, 1, 1);
            }
        }
        stages.encoder().copy_buffer_to_buffer(samples, 0, readback, 0, None);
        stages.submit();
        let bytes = read_back(gpu, readback)?;
        let words: &[[u32; 2]] = &bytemuck::pod_collect_to_vec(&bytes);
        let colours = words
            .chunks_exact(places as usize)
            .map(|of_photograph| of_photograph.iter().map(|&word| unpacked(word)).collect())
            .collect();
        Ok(Samples { places_each: places_each as usize, colours })
    }
}

/// Columns and rows of places that each of so many photographs lends.
pub(crate) fn places(photographs: usize) -> [u32; 2] {
    grid(photographs).map(|groups| groups * GROUP_SIDE)
}

impl Buffers {
    fn new(gpu: &Gpu, photographs: usize) -> Self {
        let buffer = |label, bytes, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let [places, samples] = buffer_bytes(photographs);
        Self {
            photographs,
            places: buffer("places", places, Usage::STORAGE),
            samples: buffer("samples", samples, Usage::STORAGE | Usage::COPY_SRC),
            readback: buffer("samples read back", samples, Usage::COPY_DST | Usage::MAP_READ),
        }
    }
}

/// Bytes of all places that so many photographs lend, and of their colours in all of them.
fn buffer_bytes(photographs: usize) -> [u64; 2] {
    let [columns, rows] = grid(photographs);
    let count = photographs as u64;
    let places = u64::from(columns * rows * GROUP_PLACES) * count;
    [places * PLACE_BYTES, places * count * SAMPLE_BYTES]
}

fn grid(photographs: usize) -> [u32; 2] {
    let fitting = GRIDS.iter().find(|(most, _)| photographs <= *most);
    fitting.map_or([1, 1], |(_, grid)| *grid)
}

/// The colour that measure.wgsl packed.
fn unpacked([rg, b1]: [u32; 2]) -> Option<[f32; 3]> {
    let halves = |word: u32| [word & 0xffff, word >> 16].map(|half| half as f32 / 65535.0);
    let ([r, g], [b, seen]) = (halves(rg), halves(b1));
    (seen > 0.5).then_some([r, g, b])
}

fn pipeline(
    gpu: &Gpu,
    label: &'static str,
    wgsl: String,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}
