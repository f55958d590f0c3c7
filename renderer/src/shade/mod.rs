//! What the photographs say about the places that a picture shows.
//!
//! One rig after the other: a depth test finds the camera that sees each pixel's place best,
//! and its stencil remembers which; then each camera adds its weighted colour where it won.
//! Nearer rigs compare at larger depths and come later, so that nothing has to be cleared between them,
//! and tiles that one camera of a rig alone can see need no choice. The two nearest rigs are drawn
//! by themselves first, and the others where [`crate::rest`] finds that they count.
//! Drawing one photograph at a time keeps everything about it constant for the device, and the
//! early stencil test skips the pixels of its rivals: on software devices both count for more
//! than the extra passes. Last, the sums become a picture.

use std::ops::Range;

use wgpu::util::DeviceExt as _;

use crate::bindings::bind_group;
use crate::complete::Completion;
use crate::depth_map::DepthMaps;
use crate::forward::Sprites;
use crate::frustum::Frustum;
use crate::photographs::atlas::Atlas;
use crate::rest::{HEARD_WGSL, NEAREST, RestPass, Spoken};
use crate::screen::{ScreenPass, VIEWPORT_WGSL, screen_pass_with};
use crate::surface::PLACE_WGSL;
use crate::targets::Targets;
use crate::tiles::Tiled;
use crate::{Gpu, Mode, SRGB_WGSL, depth_map, lens, octahedral};

pub(crate) mod photograph;
mod pipelines;
pub(crate) mod reference;
#[cfg(test)]
mod tests;
mod uniforms;

use photograph::Drawn;
pub(crate) use pipelines::blend_format;
use pipelines::{Key, PhotographPipelines};
pub(crate) use uniforms::PhotographUniforms;

/// The weights, to be put before the shaders that use them.
pub(crate) const BLEND_WGSL: &str = include_str!("blend.wgsl");
/// One photograph, to be put before the shaders that look places up in it, and how it is looked up.
pub(crate) const PHOTOGRAPH_WGSL: &str = include_str!("photograph.wgsl");
/// Photographs over tiles, to be put before the shaders that draw them so.
pub(crate) const TILE_WGSL: &str = include_str!("tile.wgsl");
pub(crate) const TEXEL_WGSL: &str = include_str!("texel.wgsl");

pub(crate) const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Holds which camera of a rig was chosen, and how well it sees.
pub(crate) const CHOICE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;
/// Photographs that a stencil can tell apart.
const MAX_PHOTOGRAPHS: u32 = 255;

/// The shader that finds the best camera of a rig.
pub(crate) fn choose_wgsl() -> String {
    let tiles = [TILE_WGSL, include_str!("over_tiles.wgsl")].concat();
    [lens::WGSL, PHOTOGRAPH_WGSL, &tiles, BLEND_WGSL, include_str!("choose.wgsl")].concat()
}

/// What a photograph says about a place, to be put before the shaders that ask it.
pub(crate) fn colour_wgsl() -> String {
    let parts = [
        lens::WGSL,
        PHOTOGRAPH_WGSL,
        SRGB_WGSL,
        TEXEL_WGSL,
        octahedral::WGSL,
        PLACE_WGSL,
        depth_map::POINT_WGSL,
        depth_map::WGSL,
        BLEND_WGSL,
        HEARD_WGSL,
    ];
    [&parts.concat(), include_str!("colour.wgsl")].concat()
}

/// The shader that adds a photograph's colours where it sees what pixels show.
pub(crate) fn deferred_wgsl() -> String {
    let tiles = [TILE_WGSL, include_str!("over_tiles.wgsl")].concat();
    [&colour_wgsl(), &tiles, include_str!("deferred.wgsl")].concat()
}

/// The shader that makes the picture.
pub(crate) fn compose_wgsl() -> String {
    let shared = [SRGB_WGSL, octahedral::WGSL, PLACE_WGSL, VIEWPORT_WGSL];
    [&shared.concat(), include_str!("compose.wgsl")].concat()
}

pub(crate) mod gpu_data {
    /// Mirrors `Frame` in photograph.wgsl and compose.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Frame {
        pub(crate) forward: [f32; 3],
        pub(crate) focal: f32,
        pub(crate) background: [f32; 3],
        pub(crate) orthographic: u32,
        pub(crate) size: [f32; 2],
        pub(crate) mode: u32,
        pub(crate) depth_test: u32,
    }
}

/// The pipelines of this pass.
#[derive(Debug)]
pub(crate) struct ShadePass {
    photographs: PhotographPipelines,
    rest: RestPass,
    /// One a mode.
    compose: [ScreenPass; Mode::ALL.len()],
    filtering: wgpu::Sampler,
    unfiltered: wgpu::Sampler,
}

/// What is done with the photographs of a rig, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// In tiles that several of them can see: which of them sees each pixel's place best.
    Choose,
    /// In the same tiles: colours, each where it was chosen.
    Chosen,
    /// In tiles that only one of them can see: its colours.
    Alone,
}

/// What a frame's photographs are drawn with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'a> {
    /// Ordered by rig, the nearest first.
    pub(crate) photographs: &'a [Drawn],
    /// What each can see, and its rig.
    pub(crate) seen: &'a [(&'a Frustum, usize)],
    /// What the picture shows where.
    pub(crate) tiles: Tiled<'a>,
    pub(crate) maps: &'a DepthMaps,
    /// By which photographs agree, see [`crate::align`].
    pub(crate) offsets: &'a wgpu::TextureView,
    pub(crate) atlas: &'a Atlas,
    /// The points, where they are not textured as the rest is.
    pub(crate) sprites: Option<&'a Sprites<'a>>,
}

/// Photographs that are drawn in one pass.
#[derive(Clone, Debug)]
struct Layer {
    /// Which of the frame's.
    of: Range<usize>,
    /// Whether nearer rigs have spoken before, and depths say who counts.
    of_rest: bool,
}

impl ShadePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let compose = |mode: Mode| {
            let constants = [("MODE", f64::from(mode as u8))];
            screen_pass_with(gpu, "compose", &compose_wgsl(), &[PICTURE_FORMAT], &constants)
        };
        Self {
            photographs: PhotographPipelines::new(gpu),
            rest: RestPass::new(gpu),
            compose: Mode::ALL.map(compose),
            unfiltered: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
            filtering: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("offsets and completion"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        }
    }

    /// Adds up what the photographs say about every pixel: the nearest rigs first, then the others where they
    /// count.
    pub(crate) fn draw_photographs(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &gpu_data::Frame,
        sources: Sources<'_>,
        targets: &Targets,
    ) {
        let groups = self.bind_groups(gpu, frame, sources, targets);
        let all = sources.photographs;
        let nearest = all.partition_point(|drawn| drawn.rig < NEAREST);
        if nearest == 0 || nearest == all.len() {
            let layer = Layer { of: 0..all.len(), of_rest: false };
            self.draw_layer(gpu, encoder, sources, layer, &groups, targets);
            return;
        }
        let layer = Layer { of: 0..nearest, of_rest: false };
        self.draw_layer(gpu, encoder, sources, layer, &groups, targets);
        let rest = &all[nearest..];
        let spoken = Spoken {
            positions: &targets.records.positions,
            orientations: &targets.records.orientations,
            nearest: &targets.blended,
            said: &targets.said,
            choice: &targets.choice,
        };
        let boxes = self.rest.limit(gpu, encoder, rest, spoken, sources.tiles.boxes);
        let sources = Sources { tiles: Tiled { boxes: &boxes, ..sources.tiles }, ..sources };
        let layer = Layer { of: nearest..all.len(), of_rest: true };
        self.draw_layer(gpu, encoder, sources, layer, &groups, targets);
    }

    /// Adds up what some of the photographs say.
    fn draw_layer(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        sources: Sources<'_>,
        layer: Layer,
        groups: &Groups,
        targets: &Targets,
    ) {
        let Layer { of, of_rest } = layer;
        // Sprites look for what was chosen everywhere.
        let apart = sources.sprites.is_none();
        let Tiled { pass: tile_pass, boxes } = sources.tiles;
        let seen = &sources.seen[of.clone()];
        let tiles = tile_pass.lists(gpu, encoder, seen, apart, boxes);
        let photographs = &sources.photographs[of.clone()];
        let pipelines = self.photographs.all(gpu, sources, photographs, of_rest);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("photographs"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.blended,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: clear_but(of_rest, wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.choice,
                depth_ops: Some(wgpu::Operations {
                    load: clear_but(of_rest, 0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Discard,
                }),
            }),
            ..Default::default()
        });
        let Some(tiles) = tiles else { return };
        let numbered: Vec<(u32, &Drawn)> = (0..MAX_PHOTOGRAPHS).zip(photographs).collect();
        pass.set_bind_group(0, &groups.frame, &[]);
        let rigs = numbered.chunk_by(|(_, a), (_, b)| a.rig == b.rig).collect::<Vec<_>>();
        for rig in rigs.into_iter().rev() {
            for step in [Step::Choose, Step::Chosen, Step::Alone] {
                for (index, drawn) in rig {
                    let key = Key::of(drawn, sources, of_rest);
                    let Some(all) = pipelines.get(&key) else { continue };
                    pass.set_pipeline(match step {
                        Step::Choose => &all.choose,
                        Step::Chosen => &all.chosen,
                        Step::Alone => &all.alone,
                    });
                    let photograph = groups.photographs.get(of.start + *index as usize);
                    pass.set_bind_group(1, photograph, &[]);
                    if step != Step::Choose {
                        pass.set_bind_group(2, &groups.atlases[drawn.atlas], &[]);
                    }
                    pass.set_stencil_reference(index + 1);
                    tiles.draw(&mut pass, *index, step == Step::Alone);
                    let sprites = sources.sprites.zip(all.sprites.as_ref());
                    if let (Step::Chosen, Some((sprites, pipeline))) = (step, sprites) {
                        pass.set_pipeline(pipeline);
                        pass.set_bind_group(3, &sprites.group, &[]);
                        pass.draw_indirect(&sprites.arguments, 0);
                    }
                }
            }
        }
    }

    /// Makes the picture of the sums.
    pub(crate) fn compose(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &gpu_data::Frame,
        completion: &Completion,
        targets: &Targets,
    ) {
        let spanned = uniform(gpu, bytemuck::bytes_of(&completion.spanned.to_array()));
        let uniform = uniform(gpu, bytemuck::bytes_of(frame));
        let bindings = vec![
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(&targets.records.positions),
            wgpu::BindingResource::TextureView(&targets.records.orientations),
            wgpu::BindingResource::TextureView(&targets.blended),
            wgpu::BindingResource::TextureView(&completion.colours),
            wgpu::BindingResource::Sampler(&self.filtering),
            spanned.as_entire_binding(),
        ];
        let compose = &self.compose[frame.mode as usize % Mode::ALL.len()];
        compose.draw(gpu, encoder, bindings, &[&targets.picture_view()]);
    }

    fn bind_groups(
        &self,
        gpu: &Gpu,
        frame: &gpu_data::Frame,
        sources: Sources<'_>,
        targets: &Targets,
    ) -> Groups {
        let view = wgpu::BindingResource::TextureView;
        let sampler = wgpu::BindingResource::Sampler;
        let of_frame = uniform(gpu, bytemuck::bytes_of(frame));
        let uniforms = PhotographUniforms::new(gpu, sources.photographs);
        let layouts = &self.photographs.layouts;
        let photograph =
            |index| bind_group(gpu, "photograph", &layouts.photograph, [uniforms.of(index)]);
        Groups {
            frame: bind_group(
                gpu,
                "frame",
                &layouts.frame,
                [
                    of_frame.as_entire_binding(),
                    view(&targets.records.positions),
                    view(&targets.records.orientations),
                    view(&sources.maps.mesh_view()),
                    view(&sources.maps.points_view()),
                    sampler(&self.filtering),
                    view(sources.offsets),
                    view(&targets.said),
                    sampler(&self.unfiltered),
                ],
            ),
            photographs: (0..sources.photographs.len()).map(photograph).collect(),
            atlases: atlas_groups(gpu, &layouts.atlas, sources.atlas),
        }
    }
}

/// The textures of an atlas, in the order in which photographs name them.
pub(crate) fn atlas_groups(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    atlas: &Atlas,
) -> Vec<wgpu::BindGroup> {
    let group = |view| bind_group(gpu, "atlas", layout, [wgpu::BindingResource::TextureView(view)]);
    atlas.views().iter().map(group).collect()
}

struct Groups {
    frame: wgpu::BindGroup,
    photographs: Vec<wgpu::BindGroup>,
    atlases: Vec<wgpu::BindGroup>,
}

fn uniform(gpu: &Gpu, contents: &[u8]) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("shade"),
        contents,
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// What is there before stays, or the target is cleared.
fn clear_but<T>(stays: bool, clear: T) -> wgpu::LoadOp<T> {
    if stays { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(clear) }
}
