//! What cells show of a picture, in cells of all sizes and at its borders.

use glam::{DVec3, UVec2};
use wgpu::BindingResource::TextureView as Texture;

use super::noise;
use crate::diffuse::reference::Known;
use crate::infer::reference::{Looked, gathered};
use crate::infer::{Grid, KNOWN_FORMAT, RAY_FORMAT, gpu_data, sources};
use crate::kernel_tests::channels::{Channels, records, uniform};
use crate::kernel_tests::gpu;
use crate::reference::field::{Field, cells};
use crate::screen::screen_pass;
use crate::tolerances::{CELL_DIRECTION, DIFFUSION_RELATIVE};

const PICTURE: UVec2 = UVec2::new(133, 75);

/// Ranges from half a metre to 50 m in patches, some pixels that show nothing, and some that see
/// nothing.
fn picture() -> Field<([f32; 3], bool)> {
    Field::new(PICTURE, |at| {
        let pixel = (at.as_vec2() + 0.5 - PICTURE.as_vec2() / 2.0) / 90.0;
        let direction = pixel.extend(1.0).normalize();
        let range = 0.5 + 49.5 * noise(at, 2);
        match (noise(at / 11, 1), noise(at, 3)) {
            (patch, _) if patch < 0.2 => ([0.0; 3], false),
            (patch, alone) if patch < 0.5 || alone < 0.3 => (direction.to_array(), false),
            _ => ((direction * range).to_array(), true),
        }
    })
}

#[test]
fn gathering_agrees_with_its_reference() {
    let picture = picture();
    let looked = picture.each(|&(place, shows)| {
        let place = DVec3::from_array(place.map(f64::from));
        let range_m = shows.then(|| place.length());
        Some(Looked { direction: place.try_normalize()?, range_m })
    });
    let finest = Grid::alone(PICTURE, 8192).expect("a grid");
    let (label, wgsl) = sources().into_iter().find(|(label, _)| *label == "gather").expect("it");
    let gather = screen_pass(gpu(), label, &wgsl, &[RAY_FORMAT, KNOWN_FORMAT]);
    let positions = records(PICTURE, &picture.values);
    for times in 0..4 {
        let grid = finest.coarser(times);
        let inference = uniform(&gpu_data::Inference {
            size: PICTURE.to_array(),
            step: grid.step,
            ..super::inference(grid.cells, 0, 0.1)
        });
        let (rays, known) = (Channels::<4>::new(grid.cells), Channels::<4>::new(grid.cells));
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let bindings = vec![inference.as_entire_binding(), Texture(&positions)];
        gather.draw(gpu(), &mut encoder, bindings, &[&rays.view(), &known.view()]);
        gpu().queue.submit([encoder.finish()]);
        let (rays, known) = (rays.read(), known.read());
        let (mut nothing, mut partly) = (0, 0);
        for cell in cells(grid.cells) {
            let expected = gathered(&looked, grid.step, cell);
            let [x, y, z, share] = rays.at(cell).map(f64::from);
            let off = DVec3::new(x, y, z).distance(expected.direction);
            assert!(off < CELL_DIRECTION, "{cell} of {}: {off}", grid.step);
            assert_eq!(share as f32, expected.share as f32, "{cell} of {}", grid.step);
            let [value, .., weight] = known.at(cell).map(f64::from);
            let Known { value: exact, weight: exact_weight } = expected.known;
            assert_eq!(weight, exact_weight, "{cell} of {}", grid.step);
            assert!((value - exact).abs() <= DIFFUSION_RELATIVE * exact, "{value} for {exact}");
            nothing += u32::from(expected.direction == DVec3::ZERO);
            partly += u32::from(share > 0.0 && share < 1.0);
        }
        assert!(partly > 5, "{partly} of {}", grid.step);
        assert!(times > 1 || nothing > 5, "{nothing} of {}", grid.step);
    }
}
