//! Who is asked where the nearest rigs have spoken, against f64.

use flaneur_scene::View;
use glam::{DVec3, UVec2};

use super::reference::{UNHEARD, at_most, heard};
use super::{MAX_RIGS, RestPass, SAID_FORMAT, Spoken, rigs_of};
use crate::depths::SHOWS_MESH;
use crate::kernel_tests::channels::{Channels, draw, orientations, record_words, texels};
use crate::kernel_tests::{gpu, noise, read};
use crate::octahedral::{plane_code, vector};
use crate::reference::field::{Field, cells};
use crate::screen::{WHOLE_WGSL, screen_pass};
use crate::shade::CHOICE_FORMAT;
use crate::shade::photograph::{Drawn, gpu_data::Photograph};
use crate::shade::reference::park_weight;
use crate::tiles::{Shown, TILE, TilePass, tiles_of};
use crate::tolerances::{AT_MOST_RELATIVE, HEARD_STEP};

/// Tiles at two borders are cut.
const SIZE: UVec2 = UVec2::new(75, 52);

/// Depths are kept to 24 bits.
const ROUNDED: f32 = 1.0 / (1 << 24) as f32;

/// A rig's cameras, relative to the eye, the square of its distance from there, and its weight.
struct Rig {
    index: usize,
    cameras: Vec<DVec3>,
    eye_distance_2: f64,
    weight: f64,
}

/// Rigs behind the two nearest: `count` of them, some with cameras that are decimetres apart.
fn rigs(count: usize) -> Vec<Rig> {
    (0..count)
        .map(|i| {
            let t = i as f64;
            let at = DVec3::new(3.0 * (1.3 * t).sin(), 5.0 + 4.0 * t, 0.3 * (0.7 * t).cos());
            let apart = if i % 2 == 0 { 0.0 } else { 0.3 };
            let cameras = vec![at, at + DVec3::new(apart, 0.2 * apart, 0.0)];
            let weight = 1.0 / (1.0 + t);
            Rig { index: i + 2, cameras, eye_distance_2: at.length_squared(), weight }
        })
        .collect()
}

fn drawn(rigs: &[Rig]) -> Vec<Drawn> {
    let all = rigs.len() + 2;
    let photographs = rigs.iter().flat_map(|rig| {
        rig.cameras.iter().map(move |centre| {
            let data = Photograph {
                centre: centre.as_vec3().to_array(),
                eye_distance_2: rig.eye_distance_2 as f32,
                rig_weight: rig.weight as f32,
                rig_floor: (all - 1 - rig.index) as f32 / all as f32,
                ..Default::default()
            };
            Drawn::of_rig(data, rig.index)
        })
    });
    photographs.collect()
}

/// One pixel: where what it shows lies, the code of its normal, and what the nearest have said; or nothing.
type Pixel = Option<(DVec3, u32, f64)>;

/// Places on both sides of a street, on its ground and anywhere; of which some are not seen by the nearest, and
/// some columns of tiles by them alone.
fn picture() -> Field<Pixel> {
    Field::new(SIZE, |cell| {
        let random = |seed| f64::from(noise(cell, seed));
        let place = DVec3::new(16.0 * random(0) - 8.0, 30.0 * random(1), 4.0 * random(2) - 2.0);
        let normal = DVec3::new(random(3) - 0.5, random(4) - 0.5, random(5) - 0.4).normalize();
        let usual = 10f64.powf(3.0 * random(6) - 5.0);
        let said = match (cell.x / TILE, random(7)) {
            (0, _) => 100.0 * usual,
            (_, r) if r < 0.2 => 0.0,
            _ => usual,
        };
        (random(8) > 0.1).then(|| (place.as_vec3().as_dvec3(), plane_code(normal.as_vec3()), said))
    })
}

/// The depths and, of each tile, who is asked.
fn on_device(picture: &Field<Pixel>, rest: &[Drawn]) -> (Vec<f32>, Vec<u32>) {
    let positions = record_words(&picture.each(|pixel| match pixel {
        Some((place, ..)) => {
            let [x, y, z] = place.as_vec3().to_array().map(f32::to_bits);
            [x, y, z, SHOWS_MESH]
        }
        None => [0; 4],
    }));
    let codes = orientations(&picture.each(|pixel| pixel.map_or(0, |(_, code, _)| code)));
    let said = picture.each(|pixel| [0.0, 0.0, 0.0, pixel.map_or(0.0, |(.., said)| said as f32)]);
    let nearest = Channels::holding(&said).view();
    let drawn = |format| {
        gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    };
    let said = drawn(SAID_FORMAT).create_view(&Default::default());
    let choice = drawn(CHOICE_FORMAT);
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, SIZE);
    let shown = Shown { view: &view, size: SIZE, positions: &positions };
    let boxes = TilePass::new(gpu()).boxes(gpu(), &mut encoder, shown);
    let spoken = Spoken {
        positions: &positions,
        orientations: &codes,
        nearest: &nearest,
        said: &said,
        choice: &choice.create_view(&Default::default()),
    };
    let boxes = RestPass::new(gpu()).limit(gpu(), &mut encoder, rest, spoken, &boxes);
    let asked: Vec<u32> = read(encoder, &boxes.asked);
    for (found, pixel) in texels(&said).values.iter().zip(&picture.values) {
        assert_eq!(found[0], pixel.map_or(0.0, |(.., said)| said as f32), "what was said");
    }
    (depths(&choice), asked)
}

/// The depths that a texture holds.
fn depths(choice: &wgpu::Texture) -> Vec<f32> {
    const LOAD: &str = "
@group(0) @binding(0) var depths: texture_depth_2d;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4(textureLoad(depths, vec2<i32>(at.xy), 0));
}";
    let found = Channels::<1>::new(SIZE);
    let format = found.view().texture().format();
    let load = screen_pass(gpu(), "load", &[WHOLE_WGSL, LOAD].concat(), &[format]);
    let of_depth = choice.create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        ..Default::default()
    });
    draw(&load, vec![wgpu::BindingResource::TextureView(&of_depth)], &found.view());
    found.read().values.into_iter().map(|[depth]| depth).collect()
}

/// Whoever has a say at a pixel is let through and asked about its tile; and who is far from having one is not.
#[test]
fn whoever_counts_is_asked() {
    let rigs = rigs(6);
    let rest = drawn(&rigs);
    let picture = picture();
    let (depths, asked) = on_device(&picture, &rest);
    let bounds = rigs_of(&rest);
    let columns = tiles_of(SIZE).x;
    let mut of_tiles = vec![0; asked.len()];
    let (mut counted, mut left_out, mut saved) = (0, 0, 0);
    for (cell, depth) in cells(SIZE).zip(depths) {
        let Some((place, code, said)) = picture.at(cell) else {
            assert_eq!(depth, 1.0);
            continue;
        };
        let n = vector(code).as_dvec3();
        let tile = (cell.y / TILE * columns + cell.x / TILE) as usize;
        for (rig, bound) in rigs.iter().zip(&bounds) {
            let weights = rig
                .cameras
                .iter()
                .map(|centre| rig.weight * park_weight(n, place, *centre, rig.eye_distance_2));
            let weight = weights.fold(0.0, f64::max);
            let let_through = depth <= bound.floor + ROUNDED;
            if heard(weight, said) > 0.0 {
                counted += 1;
                assert!(let_through, "{cell} {weight} {said}");
                assert!(asked[tile] >> rig.index & 1 == 1, "{cell}");
            }
            let centre = DVec3::from_array(bound.centre.map(f64::from));
            let reach = f64::from(bound.reach);
            let most = rig.weight * at_most(n, place, centre, reach, rig.eye_distance_2);
            if most * (1.0 + AT_MOST_RELATIVE) < UNHEARD * said {
                left_out += 1;
                saved += u32::from(!let_through);
            } else {
                of_tiles[tile] |= 1 << rig.index;
            }
        }
    }
    for (asked, may_be) in asked.iter().zip(of_tiles) {
        assert_eq!(asked & !may_be, 0, "asked for nothing");
    }
    println!("{counted} count, {left_out} do not, of which {saved} are spared");
    // Farther rigs that count let nearer ones through.
    assert!(counted > 2000 && left_out > 5000 && 2 * saved > left_out, "{counted} {left_out}");
}

/// Beyond the rigs that have a bit of their own, all are asked.
#[test]
fn many_rigs_are_asked_together() {
    let rigs = rigs(MAX_RIGS + 5);
    let rest = drawn(&rigs);
    let known = rigs_of(&rest);
    assert_eq!(known.len(), MAX_RIGS);
    let (depths, asked) = on_device(&picture(), &rest);
    let last = known.last().expect("rigs");
    assert_eq!((last.index, last.floor), (31, rest.last().expect("rigs").data.rig_floor));
    assert!(asked.iter().all(|bits| bits >> 31 == 1));
    let through =
        cells(SIZE).zip(depths).filter(|(_, depth)| *depth <= last.floor + ROUNDED).count();
    assert!(through > 2000, "{through}");
}

/// Nothing jumps where a weight begins to be heard, and nothing changes where nobody has spoken.
#[test]
fn hearing_is_continuous() {
    assert_eq!(heard(0.3, 0.0), 0.3);
    assert_eq!(heard(UNHEARD, 1.0), 0.0);
    let (mut before, mut weight) = (0.0, 0.0);
    for i in 0..20_000 {
        weight = 5e-6 * f64::from(i);
        let now = heard(weight, 1.0);
        assert!(now >= before && now <= weight && now - before < HEARD_STEP);
        before = now;
    }
    assert_eq!(before, weight, "it ends up as a whole");
}
