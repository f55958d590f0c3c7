//! The passes over the grid on the device against their references.

use flaneur_scene::View;
use glam::{DVec3, UVec2};
use wgpu::BindingResource::TextureView as Texture;

use self::device::{inference, pass};
use super::grid::Cells;
use super::reference::{Past, chosen, hypothesis, judged, median};
use super::{Grid, before_data, gpu_data};
use crate::kernel_tests::channels::{Channels, draw, uniform};
use crate::kernel_tests::{gpu, noise};
use crate::reference::field::{Field, cells};
use crate::tolerances::{CHOICE_INDEX, CURVED_COST, DECIDED_COST, LENS_PX, SETTLED_RELATIVE};

mod costs;
mod device;
mod gathering;

/// Of the backdrop, 1/m.
const BACKDROP: f32 = 0.0025;

/// Hypotheses between the backdrop and the diffused one.
const BETWEEN: u32 = 7;
const CELLS: UVec2 = UVec2::new(40, 30);

/// From a little later and to the right of [`view_before`].
fn view() -> View {
    look([30.2, -40.0, 2.0], 21.0)
}

fn view_before() -> View {
    look([30.0, -40.1, 2.0], 20.0)
}

fn look(eye: [f64; 3], heading: f64) -> View {
    let [heading, pitch, fov] = [heading, 10.0, 60.0].map(f64::to_radians);
    View::look(eye.into(), heading, pitch, fov, 4 * CELLS)
}

/// What the choice reads. Costs differ by about as much as what is expected of them.
struct Judged {
    costs: Vec<Field<[f32; 1]>>,
    diffused: Field<[f32; 1]>,
    rays: Field<[f32; 4]>,
    settled_before: Field<[f32; 1]>,
}

impl Judged {
    fn new() -> Self {
        let camera = view().camera;
        let depth = |seed| Field::new(CELLS, move |cell| [0.02 + 0.48 * noise(cell, seed)]);
        let cost = |i| Field::new(CELLS, move |cell| [0.05 + 0.02 * noise(cell, 100 + i)]);
        let rays = Field::new(CELLS, |cell| {
            let ray = camera.lens.unproject(4.0 * (cell.as_dvec2() + 0.5)).expect("a ray");
            let ray = (camera.cam_from_world.transpose() * ray).normalize().as_vec3();
            ray.extend(noise(cell, 1)).to_array()
        });
        Self {
            costs: (0..BETWEEN + 3).map(cost).collect(),
            diffused: depth(2),
            rays,
            settled_before: depth(3),
        }
    }

    /// The costs as the pass reads them: four in a texel, one such below the other.
    fn packed(&self) -> Field<[f32; 4]> {
        let fours = UVec2::new(CELLS.x, CELLS.y * self.costs.len().div_ceil(4) as u32);
        Field::new(fours, |at| {
            let cell = UVec2::new(at.x, at.y % CELLS.y);
            let first = 4 * (at.y / CELLS.y) as usize;
            std::array::from_fn(|i| self.costs.get(first + i).map_or(0.0, |c| c.at(cell)[0]))
        })
    }

    fn chosen_on_device(&self, has_before: bool) -> Field<[f32; 1]> {
        let inference = inference(CELLS, BETWEEN, BACKDROP);
        let inference = gpu_data::Inference { has_before: has_before.into(), ..inference };
        let grid = Grid::new(4 * CELLS, BETWEEN, 8192).expect("a grid");
        assert_eq!((grid.cells.to_array(), grid.step), (inference.cells, inference.step));
        assert_eq!(grid.hypotheses, inference.hypotheses);
        let before = uniform(&before_data(&view_before().camera, &view(), grid));
        let inference = uniform(&inference);
        let [rays, costs] = [&self.rays, &self.packed()].map(|f| Channels::holding(f).view());
        let [diffused, settled] =
            [&self.diffused, &self.settled_before].map(|f| Channels::holding(f).view());
        let found = Channels::<1>::new(CELLS);
        let bindings = vec![
            inference.as_entire_binding(),
            Texture(&rays),
            Texture(&costs),
            Texture(&diffused),
            before.as_entire_binding(),
            Texture(&settled),
        ];
        draw(&pass::<1>("choose", &[]), bindings, &found.view());
        found.read()
    }

    /// What each hypothesis of a cell is judged; `None` where rounding decides which cell of the
    /// picture before a hypothesis falls into.
    fn judged(&self, cell: UVec2, past: Option<&Past>) -> Option<Vec<f64>> {
        let [diffused] = self.diffused.at(cell).map(f64::from);
        let [x, y, z, _] = self.rays.at(cell).map(f64::from);
        let inverse = |i| hypothesis(f64::from(i), BETWEEN + 1, f64::from(BACKDROP), diffused);
        (0..BETWEEN + 3)
            .map(|i| {
                let place = view().eye() + DVec3::new(x, y, z) / inverse(i);
                let on_a_border = |past: &Past| {
                    let (pixel, _) = past.camera.project(place).unwrap_or_default();
                    let off = (pixel / past.step - (pixel / past.step).round()).abs();
                    off.min_element() * past.step < LENS_PX
                };
                if past.is_some_and(on_a_border) {
                    return None;
                }
                let kept = past.map_or(0.0, |past| past.kept(place, inverse(1) - inverse(0)));
                let [cost] = self.costs[i as usize].at(cell).map(f64::from);
                Some(judged(cost, i, BETWEEN + 1, kept))
            })
            .collect()
    }
}

/// Whether rounding cannot change which hypothesis is lowest, nor much where its parabola is.
fn is_decided(judged: &[f64]) -> bool {
    let mut sorted: Vec<usize> = (0..judged.len()).collect();
    sorted.sort_by(|&a, &b| judged[a].total_cmp(&judged[b]));
    let best = sorted[0];
    let is_curved = best == 0
        || best + 1 == judged.len()
        || judged[best - 1] + judged[best + 1] - 2.0 * judged[best] > CURVED_COST;
    is_curved && judged[sorted[1]] - judged[best] > DECIDED_COST
}

#[test]
fn the_choice_agrees_with_its_reference() {
    let all = Judged::new();
    let past = Past {
        camera: view_before().camera,
        step: 4.0,
        settled: Field::new(CELLS, |cell| f64::from(all.settled_before.at(cell)[0])),
    };
    let mut by_the_past = 0;
    for past in [None, Some(&past)] {
        let found = all.chosen_on_device(past.is_some());
        let (mut compared, mut asked) = (0, 0);
        for cell in cells(CELLS) {
            let [found] = found.at(cell).map(f64::from);
            if all.rays.at(cell)[3] > 0.5 {
                assert_eq!(found, f64::from(BETWEEN + 1), "{cell} is known");
                continue;
            }
            asked += 1;
            let judged = all.judged(cell, past).filter(|judged| is_decided(judged));
            let Some(judged) = judged else { continue };
            compared += 1;
            let expected = chosen(&judged);
            assert!((found - expected).abs() < CHOICE_INDEX, "{found} for {expected} at {cell}");
            let alone = all.judged(cell, None).map(|judged| chosen(&judged));
            by_the_past += u32::from(alone.is_some_and(|alone| (alone - found).abs() > 0.1));
        }
        assert!(asked > 500 && compared > asked * 8 / 10, "{compared} of {asked}");
    }
    // The past had a say.
    assert!(by_the_past > 50, "{by_the_past}");
}

#[test]
fn lone_choices_settle_as_the_reference_says() {
    let size = UVec2::new(23, 17);
    let chosen = Field::new(size, |cell| [(BETWEEN + 2) as f32 * noise(cell, 7)]);
    let diffused = Field::new(size, |cell| [0.02 + 0.48 * noise(cell, 8)]);
    let inference = uniform(&inference(size, BETWEEN, BACKDROP));
    let [inputs, choices] = [&diffused, &chosen].map(|field| Channels::holding(field).view());
    let found = Channels::<1>::new(size);
    let bindings = vec![inference.as_entire_binding(), Texture(&inputs), Texture(&choices)];
    draw(&pass::<1>("settle", &[]), bindings, &found.view());
    let found = found.read();
    let chosen = Field::new(size, |cell| f64::from(chosen.at(cell)[0]));
    for cell in cells(size) {
        let [found] = found.at(cell).map(f64::from);
        let [diffused] = diffused.at(cell).map(f64::from);
        let index = median(&chosen, cell);
        let expected = hypothesis(index, BETWEEN + 1, f64::from(BACKDROP), diffused);
        assert!((found / expected - 1.0).abs() < SETTLED_RELATIVE, "{found} for {expected}");
    }
}

#[test]
fn bytes_are_known_before_they_are_taken() {
    for (size, between) in [(UVec2::new(96, 64), 7), (UVec2::new(1023, 511), 0)] {
        let grid = Grid::new(size, between, 8192).expect("a grid");
        assert_eq!(Cells::new(gpu(), grid).bytes(), Cells::bytes_for(grid), "{grid:?}");
    }
}
