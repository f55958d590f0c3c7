//! Completed colours on the device against their reference.

use flaneur_scene::SurfaceClass;
use glam::{DVec3, UVec2};

use super::reference::{beside, completed};
use super::{CompletePass, Shown};
use crate::Surface;
use crate::depths::SHOWS_MESH;
use crate::infer::Grid;
use crate::kernel_tests::channels::{Channels, orientation_words, record_words, texels};
use crate::kernel_tests::{gpu, noise};
use crate::layers::one_layer;
use crate::reference::field::{Field, cells};
use crate::tolerances::COMPLETED;

const PICTURE: UVec2 = UVec2::new(133, 75);

/// What a pixel shows, of which class, and linear colours times their weight, and that.
type Pixel = (u32, u32, [f32; 4]);

const INFERRED: (u32, u32) = (Surface::Completed as u32, 0);
const GROUND: (u32, u32) = (SHOWS_MESH, SurfaceClass::Ground as u32);
const WALL: (u32, u32) = (SHOWS_MESH, SurfaceClass::Wall as u32);

/// Some pixels show ground, some a wall, some nothing, others are inferred; a share is coloured, in patches or
/// alone.
fn picture(share: f32) -> Field<Pixel> {
    Field::new(PICTURE, |at| {
        let (kind, class) = match noise(at / 7, 1) {
            patch if patch < 0.3 => GROUND,
            patch if patch < 0.4 => WALL,
            patch if patch < 0.5 => (0, 0),
            _ => INFERRED,
        };
        let seen = noise(at / 9, 2) < share && noise(at, 3) < share.sqrt();
        let weight = if seen { 0.01 + 3.0 * noise(at, 4) } else { 0.0 };
        // Dark in some places, bright in others.
        let channel = |i: u32| noise(at / 20, 5) * noise(at, 6 + i) * weight;
        (kind, class, [channel(0), channel(1), channel(2), weight])
    })
}

/// The colours of those that are of a kind and coloured.
fn coloured(picture: &Field<Pixel>, of: (u32, u32)) -> Field<Option<DVec3>> {
    picture.each(|&(kind, class, sum)| {
        let [r, g, b, weight] = sum.map(f64::from);
        let counts = (kind, class) == of && weight > 0.0;
        counts.then(|| DVec3::new(r, g, b) / weight)
    })
}

/// The textures of a picture: positions, orientations, and what photographs say.
fn textures(picture: &Field<Pixel>) -> [wgpu::TextureView; 3] {
    [
        record_words(&picture.each(|&(kind, ..)| [0, 0, 1.0f32.to_bits(), kind])),
        orientation_words(&picture.each(|&(_, class, _)| [0, class])),
        Channels::holding(&picture.each(|&(.., sum)| sum)).view(),
    ]
}

/// Of what was inferred, of the ground, and of all surfaces.
fn on_device(picture: &Field<Pixel>, grid: Grid) -> [Field<[f32; 4]>; 3] {
    let [positions, orientations, blended] = &textures(picture);
    let mut pass = CompletePass::new(gpu());
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let shown = Shown { positions, orientations, blended };
    let completion = pass.draw(gpu(), &mut encoder, Some(grid), shown);
    assert_eq!(completion.spanned, (grid.cells * grid.step).as_vec2());
    gpu().queue.submit([encoder.finish()]);
    [0, 1, 2].map(|layer| texels(&one_layer(completion.colours.texture(), layer)))
}

#[test]
fn colours_agree_with_their_reference() {
    let finest = Grid::alone(PICTURE, 8192).expect("a grid");
    for share in [0.02, 0.3, 1.0] {
        let picture = picture(share);
        for times in 0..3 {
            let grid = finest.coarser(times);
            for (found, kind) in on_device(&picture, grid).into_iter().zip([INFERRED, GROUND]) {
                let Some(expected) = completed(&coloured(&picture, kind), grid) else {
                    assert!(share < 0.1 && found.values.iter().all(|&cell| cell == [0.0; 4]));
                    continue;
                };
                let mut most: f64 = 0.0;
                for cell in cells(grid.cells) {
                    let [r, g, b, whole] = found.at(cell).map(f64::from);
                    let off = (DVec3::new(r, g, b) - expected.at(cell)).abs().max_element();
                    most = most.max(off).max((whole - 1.0).abs());
                }
                println!("off by {most} of {share} in {}", grid.cells);
                assert!(most < COMPLETED, "{most} of {share} in {}", grid.cells);
            }
        }
    }
}

/// What points take of the surfaces beside.
#[test]
fn surfaces_colour_what_is_beside_and_nothing_else() {
    let finest = Grid::alone(PICTURE, 8192).expect("a grid");
    for (share, times) in [(0.02, 0), (0.02, 1), (0.3, 0), (0.3, 2), (1.0, 0)] {
        let (picture, grid) = (picture(share), finest.coarser(times));
        let [.., found] = on_device(&picture, grid);
        let [ground, walls] = [GROUND, WALL].map(|kind| coloured(&picture, kind));
        let both = Field::new(PICTURE, |at| ground.at(at).or(walls.at(at)));
        let (colours, weights) = beside(&both, grid);
        let (mut most, mut partly, mut none) = (0.0f64, 0, 0);
        for cell in cells(grid.cells) {
            let [r, g, b, weight] = found.at(cell).map(f64::from);
            let off = (DVec3::new(r, g, b) - colours.at(cell)).abs().max_element();
            most = most.max(off).max((weight - weights.at(cell)).abs());
            partly += u32::from(weight > 0.01 && weight < 0.99);
            none += u32::from(weight == 0.0);
        }
        println!("off by {most} of {share} in {}, {partly} partly, {none} not", grid.cells);
        assert!(most < COMPLETED, "{most} of {share} in {}", grid.cells);
        assert!(share > 0.1 || (partly > 0 && none > 0), "{partly} {none}");
    }
}

#[test]
fn where_nothing_is_coloured_there_is_no_colour() {
    let grid = Grid::alone(PICTURE, 8192).expect("a grid");
    let picture = picture(0.0);
    for (found, kind) in on_device(&picture, grid).into_iter().zip([INFERRED, GROUND]) {
        assert_eq!(completed(&coloured(&picture, kind), grid), None);
        assert!(found.values.iter().all(|&cell| cell == [0.0; 4]));
    }
}

#[test]
fn bytes_are_known_before_they_are_taken() {
    let mut pass = CompletePass::new(gpu());
    let picture = picture(1.0);
    let [positions, orientations, blended] = &textures(&picture);
    let shown = Shown { positions, orientations, blended };
    for grid in [None, Grid::alone(PICTURE, 8192), None] {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let completion = pass.draw(gpu(), &mut encoder, grid, shown);
        let size = completion.colours.texture().size();
        assert_eq!(size.width > 1, grid.is_some());
        assert_eq!(pass.bytes(), grid.map_or(0, CompletePass::bytes_for));
    }
}
