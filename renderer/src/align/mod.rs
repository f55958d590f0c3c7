//! Makes the two nearest photographs agree before they are blended.
//!
//! Poses are off by centimetres, and depths too: two photographs of the same pole then show it
//! twice, a few pixels apart. On a coarse grid both are looked up at what the picture shows, and
//! the small displacement between them is found, coarse levels first, by Lucas and Kanade's
//! method. Each photograph is then looked up displaced by its share: as much as the eye is nearer
//! to the other, so that at a photograph's own place that photograph stays as it is.
//!
//! Equations and reasons are in reference.rs.

use flaneur_scene::View;
use glam::UVec2;
use wgpu::util::DeviceExt as _;

use crate::depth_map::DepthMaps;
use crate::infer::{Evidence, Grid, Part, RECORDS, SightPass, Sights, UNIFORM, texture_of};
use crate::screen::{Region, ScreenPass, WHOLE_WGSL, screen_pass};
use crate::shade::photograph::Drawn;
use crate::targets::Targets;
use crate::tiles::Tiled;
use crate::{Gpu, infer, memory, shade};

mod level;
pub(crate) mod reference;
mod sheet;
#[cfg(test)]
mod tests;

use level::{DISPLACEMENT_FORMAT, FOUR_FORMAT, Level, SOLVED_FORMAT, TWO_FORMAT, WARPED_FORMAT};
use sheet::Sheet;

const LUCAS_KANADE_WGSL: &str = include_str!("lucas_kanade.wgsl");
const ALIGNMENT_WGSL: &str = include_str!("alignment.wgsl");

/// Depth maps.
const MAPS: wgpu::BindingType = texture_of(
    wgpu::TextureSampleType::Float { filterable: false },
    wgpu::TextureViewDimension::D2Array,
);

/// Offsets as the shading pass filters them.
pub(crate) const OFFSET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Most levels, each with cells twice as large as those of the one before.
const LEVELS: u32 = 3;
/// Fewest cells along the shorter side of a level: windows are small against the picture.
const LEAST_CELLS: u32 = 20;
/// How much farther than the second rig the third must be for the two to be aligned in full, as a
/// share: where they change places nothing is displaced, so that nothing jumps.
const APART: f64 = 0.25;
/// Share of their weight that the other rigs lose where two are aligned in full.
pub(crate) const ALONE: f64 = 0.95;

pub(crate) mod gpu_data {
    /// Mirrors `Alignment` in alignment.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Alignment {
        pub(crate) cells: [u32; 2],
        pub(crate) origin: [u32; 2],
        pub(crate) step: f32,
        pub(crate) coarser_step: f32,
        pub(crate) share: f32,
        pub(crate) across: u32,
    }

    /// Mirrors `Axes` in turn.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Axes {
        pub(crate) right: [f32; 3],
        pub(crate) padding_0: u32,
        pub(crate) down: [f32; 3],
        pub(crate) padding_1: u32,
    }
}

/// Every shader of this pass, by name.
pub(crate) fn sources() -> [(&'static str, String); 8] {
    let whole = WHOLE_WGSL;
    let sight = include_str!("sight.wgsl");
    [
        (
            "align sight",
            [
                &shade::colour_wgsl(),
                shade::TILE_WGSL,
                infer::BRIGHTNESS_WGSL,
                ALIGNMENT_WGSL,
                sight,
            ]
            .concat(),
        ),
        ("pair", [ALIGNMENT_WGSL, whole, include_str!("pair.wgsl")].concat()),
        ("pattern", [ALIGNMENT_WGSL, whole, include_str!("pattern.wgsl")].concat()),
        ("warp", [ALIGNMENT_WGSL, whole, include_str!("warp.wgsl")].concat()),
        ("along", [whole, include_str!("along.wgsl")].concat()),
        ("solve", [ALIGNMENT_WGSL, LUCAS_KANADE_WGSL, whole, include_str!("solve.wgsl")].concat()),
        ("smooth", [whole, include_str!("smooth.wgsl")].concat()),
        ("turn", [whole, include_str!("turn.wgsl")].concat()),
    ]
}

/// How the two nearest rigs share the displacement between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    /// Of the nearest, 0 to a half.
    pub(crate) nearest: f64,
    /// How much of it all is applied, 0 to 1.
    pub(crate) applied: f64,
}

impl Shares {
    /// For distances from the eye to the nearest rigs, metres, nearest first. `None` where there
    /// are no two.
    pub(crate) fn new(distances_m: &[f64]) -> Option<Self> {
        let (&first, &second) = (distances_m.first()?, distances_m.get(1)?);
        let nearest = if second > 0.0 { first / (first + second) } else { 0.5 };
        let apart = distances_m.get(2).map_or(1.0, |third| (third / second - 1.0) / APART);
        // Zero over zero is no distance between the second and the third.
        let t = if apart.is_nan() { 0.0 } else { apart.clamp(0.0, 1.0) };
        Some(Self { nearest, applied: t * t * (3.0 - 2.0 * t) })
    }
}

/// The pipelines of this pass, and its textures.
#[derive(Debug)]
pub(crate) struct AlignPass {
    sight: SightPass,
    pair: ScreenPass,
    pattern: ScreenPass,
    warp: ScreenPass,
    along: ScreenPass,
    solve: ScreenPass,
    smooth: ScreenPass,
    turn: ScreenPass,
    /// Finest first.
    levels: Vec<Level>,
    sheet: Option<Sheet>,
    nowhere: wgpu::TextureView,
    offsets: wgpu::TextureView,
}

impl AlignPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let [(_, sight), pair, pattern, warp, along, solve, smooth, turn] = sources();
        let pass = |(label, wgsl): (&'static str, String), formats: &[wgpu::TextureFormat]| {
            screen_pass(gpu, label, &wgsl, formats)
        };
        let one = |format| level::texture(gpu, UVec2::ONE, format);
        Self {
            sight: SightPass::new(
                gpu,
                &sight,
                &[(0, UNIFORM), (1, RECORDS), (2, RECORDS), (3, MAPS), (4, MAPS), (6, UNIFORM)],
            ),
            pair: pass(pair, &[WARPED_FORMAT]),
            pattern: pass(pattern, &[WARPED_FORMAT]),
            warp: pass(warp, &[WARPED_FORMAT, DISPLACEMENT_FORMAT]),
            along: pass(along, &[FOUR_FORMAT, TWO_FORMAT]),
            solve: pass(solve, &[SOLVED_FORMAT]),
            smooth: pass(smooth, &[DISPLACEMENT_FORMAT]),
            turn: pass(turn, &[OFFSET_FORMAT]),
            levels: Vec::new(),
            sheet: None,
            nowhere: one(DISPLACEMENT_FORMAT),
            offsets: one(OFFSET_FORMAT),
        }
    }

    /// What [`AlignPass::bytes`] is once a picture was drawn on `finest`.
    pub(crate) fn bytes_for(finest: Grid) -> u64 {
        let grids = levels(finest);
        let sheet = Sheet::bytes_for(&grids);
        let levels = grids.into_iter().map(Level::bytes_for).sum::<u64>();
        levels
            + sheet
            + memory::of_texels(OFFSET_FORMAT, finest.cells, 1)
            + memory::of_texels(DISPLACEMENT_FORMAT, glam::UVec2::ONE, 1)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let levels = self.levels.iter().map(Level::bytes).sum::<u64>();
        let views = [&self.nowhere, &self.offsets].map(|view| memory::of_texture(view.texture()));
        let sheet = self.sheet.as_ref().map_or(0, Sheet::bytes);
        levels + sheet + views.iter().sum::<u64>()
    }

    /// Gives its textures back, but where they are those of `finest`.
    pub(crate) fn release_but(&mut self, gpu: &Gpu, finest: Option<Grid>) {
        if self.levels.first().is_some_and(|level| Some(level.grid) != finest) {
            self.levels.clear();
            self.sheet = None;
            // Bound in any case, so never without.
            self.offsets = level::texture(gpu, glam::UVec2::ONE, OFFSET_FORMAT);
        }
    }

    /// How much of the world's offsets each photograph takes, one after the other; and fills the
    /// texture of [`AlignPass::offsets`] where any takes some.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        asked: Tiled<'_>,
        evidence: Evidence<'_>,
        maps: &DepthMaps,
        targets: &Targets,
    ) -> Option<Shares> {
        let rigs = evidence.photographs.chunk_by(|a, b| a.rig == b.rig);
        let distances: Vec<f64> =
            rigs.filter_map(|rig| rig.first()).map(|drawn| drawn.rig_distance_m).collect();
        let shares = Shares::new(&distances).filter(|shares| shares.applied > 0.0)?;
        self.resize(gpu, evidence.view)?;
        let nearest = evidence.of_nearest(2);
        let tiles = asked.pass.lists(gpu, encoder, nearest, false, asked.boxes)?;
        let uniform = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("align"),
                contents,
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let frame = uniform(bytemuck::bytes_of(evidence.frame));
        let texture = wgpu::BindingResource::TextureView;
        let (map_mesh, map_points) = (maps.mesh_view(), maps.points_view());
        let sheet = self.sheet.as_ref()?;
        // Each level's, for the first rig and for the second, which lies beside it.
        let alignments: Vec<[wgpu::Buffer; 2]> = self
            .levels
            .iter()
            .zip(coarser_steps(&self.levels))
            .map(|(level, coarser_step)| {
                [0, sheet.across()].map(|aside| {
                    uniform(bytemuck::bytes_of(&gpu_data::Alignment {
                        cells: level.grid.cells.to_array(),
                        origin: (level.region.origin + UVec2::new(aside, 0)).to_array(),
                        step: level.grid.step as f32,
                        coarser_step: coarser_step as f32,
                        share: shares.nearest as f32,
                        across: sheet.across(),
                    }))
                })
            })
            .collect();
        let mut parts = Vec::new();
        for (level, of_rigs) in self.levels.iter().zip(&alignments) {
            for (rig, alignment) in of_rigs.iter().enumerate() {
                let aside = UVec2::new(rig as u32 * sheet.across(), 0);
                let region = Region { origin: level.region.origin + aside, ..level.region };
                let inputs = vec![
                    (0, frame.as_entire_binding()),
                    (1, texture(&targets.records.positions)),
                    (2, texture(&targets.records.orientations)),
                    (3, texture(&map_mesh)),
                    (4, texture(&map_points)),
                    (6, alignment.as_entire_binding()),
                ];
                parts.push(Part { rig, region: Some(region), inputs });
            }
        }
        let sights = Sights { shown: &sheet.sights, ranks: &sheet.ranks, parts };
        self.sight.draw(gpu, encoder, evidence, &tiles, sights);
        let (mut pairs, mut patterns) = (Vec::new(), Vec::new());
        for (level, [alignment, _]) in self.levels.iter().zip(&alignments) {
            let region = Some(level.region);
            let alignment = alignment.as_entire_binding();
            let read = vec![alignment, texture(&sheet.sights)];
            patterns.push((region, [&read[..], &[texture(&sheet.sums)]].concat()));
            pairs.push((region, read));
        }
        self.pair.draw_parts(gpu, encoder, pairs, &[&sheet.sums]);
        self.pattern.draw_parts(gpu, encoder, patterns, &[&sheet.patterns]);
        let mut coarser = &self.nowhere;
        for (level, [alignment, _]) in self.levels.iter().zip(&alignments).rev() {
            let bindings =
                vec![alignment.as_entire_binding(), texture(&sheet.patterns), texture(coarser)];
            self.warp.draw(gpu, encoder, bindings, &[&level.warped, &level.displaced]);
            let [four, two] = &level.sums;
            self.along.draw(gpu, encoder, vec![texture(&level.warped)], &[four, two]);
            let bindings = vec![
                alignment.as_entire_binding(),
                texture(four),
                texture(two),
                texture(&level.displaced),
            ];
            self.solve.draw(gpu, encoder, bindings, &[&level.solved]);
            let bindings = vec![texture(&level.solved)];
            self.smooth.draw(gpu, encoder, bindings, &[&level.smoothed]);
            coarser = &level.smoothed;
        }
        let axes = uniform(bytemuck::bytes_of(&axes(evidence.view)));
        let bindings = vec![axes.as_entire_binding(), texture(coarser)];
        self.turn.draw(gpu, encoder, bindings, &[&self.offsets]);
        Some(shares)
    }

    /// World offsets, metres a metre of depth, over cells of [`AlignPass::step`] pixels.
    pub(crate) fn offsets(&self) -> &wgpu::TextureView {
        &self.offsets
    }

    /// Pixels a side of a cell.
    pub(crate) fn step(&self) -> u32 {
        self.levels.first().map_or(1, |level| level.grid.step)
    }

    /// What both rigs show of all levels, and where: how far to the right the second is.
    #[cfg(test)]
    pub(crate) fn last_sights(&self) -> Option<(&wgpu::TextureView, u32)> {
        self.sheet.as_ref().map(|sheet| (&sheet.sights, sheet.across()))
    }

    /// Each level, finest first: where it lies in what both show, and the displacement.
    #[cfg(test)]
    pub(crate) fn last_levels(&self) -> impl Iterator<Item = (Grid, UVec2, &wgpu::TextureView)> {
        self.levels.iter().map(|level| (level.grid, level.region.origin, &level.smoothed))
    }

    fn resize(&mut self, gpu: &Gpu, view: &View) -> Option<()> {
        let max_side = gpu.device.limits().max_texture_dimension_2d;
        let finest = Grid::alone(view.size(), max_side)?;
        if self.levels.first().is_none_or(|level| level.grid != finest) {
            self.offsets = level::texture(gpu, finest.cells, OFFSET_FORMAT);
            let grids = levels(finest);
            let regions = sheet::regions(&grids);
            self.sheet = Some(Sheet::new(gpu, &grids));
            let levels = std::iter::zip(grids, regions);
            self.levels = levels.map(|(grid, region)| Level::new(gpu, grid, region)).collect();
        }
        Some(())
    }
}

/// The levels for a picture, finest first, of textures of at most `max_side`.
pub(crate) fn grids(picture: UVec2, max_side: u32) -> Vec<Grid> {
    Grid::alone(picture, max_side).map_or_else(Vec::new, levels)
}

/// The levels below and including the finest, which is first.
fn levels(finest: Grid) -> Vec<Grid> {
    let grids = (0..LEVELS).map(|times| finest.coarser(times));
    grids.filter(|g| *g == finest || g.cells.min_element() >= LEAST_CELLS).collect()
}

/// Of each level the step of the one that is coarser.
fn coarser_steps(levels: &[Level]) -> impl Iterator<Item = u32> {
    levels.iter().skip(1).map(|level| level.grid.step).chain([u32::MAX])
}

/// Gives each photograph of the two nearest rigs its share of the offsets. The others, which show
/// the same a few pixels aside, leave the picture to them as far as they see it.
pub(crate) fn share_out(photographs: &mut [Drawn], shares: Shares, step: u32) {
    let parts = [-shares.nearest, 1.0 - shares.nearest];
    for (index, rig) in photographs.chunk_by_mut(|a, b| a.rig == b.rig).enumerate() {
        for drawn in rig {
            if let Some(part) = parts.get(index) {
                drawn.data.shift = (part * shares.applied) as f32;
                drawn.data.shift_step = step as f32;
            } else {
                drawn.data.rig_weight *= (1.0 - ALONE * shares.applied) as f32;
            }
        }
    }
}

fn axes(view: &View) -> gpu_data::Axes {
    let intrinsics = view.camera.lens.intrinsics;
    let axes = view.camera.cam_from_world.transpose();
    gpu_data::Axes {
        right: (axes.x_axis / intrinsics.fx).as_vec3().to_array(),
        padding_0: 0,
        down: (axes.y_axis / intrinsics.fy).as_vec3().to_array(),
        padding_1: 0,
    }
}
