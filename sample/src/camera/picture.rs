//! Taking a picture: a ray for every pixel, more where neighbours differ.

use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use crate::geometry::Ray;
use crate::look::noise::{mix, unit};
use crate::look::{Shader, display};
use crate::street::Class;

/// Neighbours whose displayed colours differ by more than this are sampled again.
const CONTRAST: f64 = 0.07;
const EXTRA_SAMPLES: u32 = 4;

/// What a pixel looks along.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    /// The line of sight in the street frame.
    pub(crate) ray: Ray,
    /// Depth along the camera's axis of a point at unit distance along the ray.
    pub(crate) depth_per_metre: f64,
    /// Radiance of the own vehicle where it is in the way.
    pub(crate) vehicle: Option<DVec3>,
}

/// A picture with the truth about every pixel's centre, rows from the top.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    /// Size in pixels.
    pub(crate) size: UVec2,
    /// sRGB.
    pub(crate) rgb: Vec<u8>,
    /// Class ids.
    pub(crate) labels: Vec<u8>,
    /// Depth along the camera's axis in metres, infinite where nothing is met.
    pub(crate) depths: Vec<f32>,
}

#[derive(Clone, Copy)]
struct Sample {
    colour: DVec3,
    surface: u32,
    class: Class,
    depth: f64,
}

/// Takes a picture. `sight` gives the line of sight of a raw pixel position (corners at
/// integers), `None` where the lens sees nothing; `spread` is the angle of a pixel.
pub(crate) fn take(
    shader: &Shader<'_>,
    size: UVec2,
    spread: f64,
    sight: impl Fn(DVec2) -> Option<Sighting> + Sync,
) -> Picture {
    let width = size.x as usize;
    let look = |pixel: DVec2| sample(shader, spread, sight(pixel));
    let position = |index: usize| DVec2::new((index % width) as f64, (index / width) as f64);
    let count = width * size.y as usize;
    let centres: Vec<Sample> =
        (0..count).into_par_iter().map(|index| look(position(index) + 0.5)).collect();
    let rgb: Vec<u8> = (0..count)
        .into_par_iter()
        .flat_map_iter(|index| {
            let mut colour = centres[index].colour;
            if is_edge(&centres, size, index) {
                let seed = mix(index as u32, size.x) as u32;
                for i in 0..EXTRA_SAMPLES {
                    // One sample in each quarter of the pixel.
                    let corner = DVec2::new(f64::from(i & 1), f64::from(i >> 1)) * 0.5;
                    let within = DVec2::new(unit(seed, 2 * i), unit(seed, 2 * i + 1)) * 0.5;
                    colour += look(position(index) + corner + within).colour;
                }
                colour /= f64::from(EXTRA_SAMPLES + 1);
            }
            colour.to_array().map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8)
        })
        .collect();
    Picture {
        size,
        rgb,
        labels: centres.iter().map(|sample| sample.class.id()).collect(),
        depths: centres.iter().map(|sample| sample.depth as f32).collect(),
    }
}

fn sample(shader: &Shader<'_>, spread: f64, sighting: Option<Sighting>) -> Sample {
    let none = |colour, surface, class| Sample { colour, surface, class, depth: f64::INFINITY };
    let Some(sighting) = sighting else {
        return none(DVec3::ZERO, u32::MAX, Class::NoData);
    };
    if let Some(radiance) = sighting.vehicle {
        return none(display(radiance), u32::MAX - 1, Class::OwnVehicle);
    }
    let hit = shader.nearest(&sighting.ray);
    let colour = display(shader.radiance(&sighting.ray, hit.as_ref(), spread));
    match hit {
        None => none(colour, u32::MAX - 2, Class::Sky),
        Some(hit) => Sample {
            colour,
            surface: shader.street.tree.primitive(hit.primitive).surface,
            class: shader.street.surface(&hit).class,
            depth: hit.contact.distance * sighting.depth_per_metre,
        },
    }
}

fn is_edge(centres: &[Sample], size: UVec2, index: usize) -> bool {
    let width = size.x as usize;
    let (column, row) = (index % width, index / width);
    let here = &centres[index];
    let neighbours = [
        (column > 0).then(|| index - 1),
        (column + 1 < width).then(|| index + 1),
        (row > 0).then(|| index - width),
        (row + 1 < size.y as usize).then(|| index + width),
    ];
    neighbours.into_iter().flatten().any(|other| {
        let there = &centres[other];
        here.surface != there.surface || (here.colour - there.colour).abs().max_element() > CONTRAST
    })
}
