//! A face of the cube around a panorama, resampled from its equirectangular photograph.

use flaneur_scene::{CubeFace, Lens};
use glam::{DVec2, UVec2};
use rayon::prelude::*;

use super::feather::feathered;
use super::{Mask, Picture};

/// Samples a pixel along each axis. A face is sampled a little more coarsely than its source
/// in its middle, and up to four times more coarsely near the poles.
const SAMPLES: u32 = 2;
/// A pixel whose corners span more than this part of the source's width holds the pole, or
/// nearly: between its corners azimuths are not interpolated.
const MAX_SPAN: f64 = 1.0 / 64.0;

/// The pixels of `face`, `side` a side, sRGB with straight alpha: each the mean of bilinear
/// samples of `source`. A pixel with any sample that `mask` hides has alpha 0, the others how far
/// they lie inside the mask on this face.
///
/// Where a sample lies in the source is interpolated between the corners of its pixel: the
/// error is below 0.002 of a source pixel for faces of 64 pixels or more.
pub(crate) fn cube_face(
    source: &Picture,
    mask: Option<&Mask>,
    face: &CubeFace,
    side: u32,
) -> Vec<u8> {
    let mut rgba = vec![0; 4 * side as usize * side as usize];
    let sphere = Sphere { face: *face, lens: CubeFace::lens(side), size: source.size };
    rgba.par_chunks_mut((4 * side as usize).max(1)).enumerate().for_each(|(row, pixels)| {
        let y = row as f64;
        // Positions at the corners above and below the row, each shared by two pixels.
        let corners = |y: f64| -> Vec<DVec2> {
            (0..=side).map(|x| sphere.position(DVec2::new(f64::from(x), y))).collect()
        };
        let (above, below) = (corners(y), corners(y + 1.0));
        for (x, pixel) in pixels.chunks_exact_mut(4).enumerate() {
            let cell = [above[x], above[x + 1], below[x], below[x + 1]];
            let corner = DVec2::new(x as f64, y);
            pixel.copy_from_slice(&sphere.pixel(source, mask, corner, cell));
        }
    });
    if mask.is_some() {
        let shown: Vec<bool> = rgba.chunks_exact(4).map(|pixel| pixel[3] > 0).collect();
        for (pixel, alpha) in rgba.chunks_exact_mut(4).zip(feathered(UVec2::splat(side), &shown)) {
            pixel[3] = alpha;
        }
    }
    rgba
}

/// The mapping from a face to its source.
struct Sphere {
    face: CubeFace,
    lens: Lens,
    size: UVec2,
}

impl Sphere {
    /// Where a point of the face lies in the source, in units of the source's size.
    fn position(&self, at: DVec2) -> DVec2 {
        let normalised = self.lens.intrinsics.normalised_from_pixel(at);
        let d_rig = self.face.cam_from_rig().transpose() * normalised.extend(1.0);
        CubeFace::equirectangular_from_rig(d_rig, self.size) / self.size.as_dvec2()
    }

    /// The pixel whose top-left corner is `corner`, its corners at `cell` in the source.
    fn pixel(
        &self,
        source: &Picture,
        mask: Option<&Mask>,
        corner: DVec2,
        mut cell: [DVec2; 4],
    ) -> [u8; 4] {
        // All azimuths on the same side of the seam as the first.
        let first = cell[0].x;
        for position in &mut cell {
            position.x -= (position.x - first).round();
        }
        let span = cell.iter().map(|p| (p.x - first).abs()).fold(0.0, f64::max);
        let (mut sum, mut shown) = ([0.0; 3], true);
        for sample in 0..SAMPLES * SAMPLES {
            let within = DVec2::new(f64::from(sample % SAMPLES), f64::from(sample / SAMPLES));
            let within = (within + 0.5) / f64::from(SAMPLES);
            let mut position = if span > MAX_SPAN {
                self.position(corner + within)
            } else {
                let top = cell[0].lerp(cell[1], within.x);
                let bottom = cell[2].lerp(cell[3], within.x);
                top.lerp(bottom, within.y)
            };
            position.x -= position.x.floor();
            for (sum, value) in sum.iter_mut().zip(bilinear(source, position)) {
                *sum += value;
            }
            shown &= mask.is_none_or(|mask| mask.shows(position));
        }
        let count = f64::from(SAMPLES * SAMPLES);
        let [r, g, b] = sum.map(|value| (value / count).round() as u8);
        [r, g, b, if shown { 255 } else { 0 }]
    }
}

/// The source at `position` (in units of its size), between its four nearest pixels: around
/// the seam, and across the poles as their row continues.
fn bilinear(source: &Picture, position: DVec2) -> [f64; 3] {
    let (width, height) = (source.size.x as usize, source.size.y as usize);
    let at = position * source.size.as_dvec2() - 0.5;
    let (floor, part) = (at.floor(), at - at.floor());
    let column = |offset: f64| (floor.x + offset).rem_euclid(width as f64) as usize % width;
    let row = |offset: f64| (floor.y + offset).clamp(0.0, (height - 1) as f64) as usize;
    let texel =
        |x: usize, y: usize, channel: usize| f64::from(source.rgb[3 * (y * width + x) + channel]);
    let (x0, x1, y0, y1) = (column(0.0), column(1.0), row(0.0), row(1.0));
    std::array::from_fn(|channel| {
        let top = texel(x0, y0, channel) * (1.0 - part.x) + texel(x1, y0, channel) * part.x;
        let bottom = texel(x0, y1, channel) * (1.0 - part.x) + texel(x1, y1, channel) * part.x;
        top * (1.0 - part.y) + bottom * part.y
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::CUBE_FACES;
    use glam::DVec3;
    use std::f64::consts::TAU;

    /// A smooth colour of direction with some detail: up to 12 waves a turn.
    fn colour(d: DVec3) -> [f64; 3] {
        let d = d.normalize();
        let wave = |a: DVec3, f: f64| 127.5 + 120.0 * (f * a.dot(d)).sin();
        [wave(DVec3::X, 12.0), wave(DVec3::new(0.6, 0.8, 0.0), 9.0), wave(DVec3::Z, 12.0)]
    }

    fn panorama(size: UVec2) -> Picture {
        let mut rgb = Vec::new();
        for y in 0..size.y {
            for x in 0..size.x {
                let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size.as_dvec2();
                let (azimuth, elevation) = ((at.x - 0.5) * TAU, (0.5 - at.y) * 0.5 * TAU);
                let d = DVec3::new(
                    azimuth.sin() * elevation.cos(),
                    azimuth.cos() * elevation.cos(),
                    elevation.sin(),
                );
                rgb.extend(colour(d).map(|v| v.round() as u8));
            }
        }
        Picture { size, rgb }
    }

    /// The resampling against the panorama's own equation, at every pixel of every face. The
    /// tolerances: rounding twice to 8 bits gives up to 1; bilinear interpolation flattens
    /// a wave of 12 rad⁻¹ at 512 pixels a turn by (12 · 2π/512)²/8 · 120 ≈ 0.3; the mean over
    /// a pixel as much again.
    #[test]
    fn faces_show_what_the_panorama_shows() {
        let source = panorama(UVec2::new(512, 256));
        let (side, mut worst, mut sum, mut count) = (128, 0.0f64, 0.0, 0.0);
        for face in &CUBE_FACES {
            let rgba = cube_face(&source, None, face, side);
            let lens = CubeFace::lens(side);
            for (index, pixel) in rgba.chunks_exact(4).enumerate() {
                let index = u32::try_from(index).expect("small");
                let at = DVec2::new(f64::from(index % side), f64::from(index / side)) + 0.5;
                let d = face.cam_from_rig().transpose() * lens.unproject(at).expect("pinhole");
                for (got, want) in pixel.iter().zip(colour(d)) {
                    let error = (f64::from(*got) - want).abs();
                    worst = worst.max(error);
                    sum += error;
                    count += 1.0;
                }
                assert_eq!(pixel[3], 255);
            }
        }
        println!("cube faces: mean error {:.3}, max {worst:.3} of 255", sum / count);
        assert!(worst < 2.0, "max error {worst}");
        assert!(sum / count < 0.5, "mean error {}", sum / count);
    }

    #[test]
    fn a_mask_hides_its_part_of_the_sphere() {
        let source = panorama(UVec2::new(64, 32));
        // The lower half of the sphere is hidden.
        let png = {
            let grey = image::GrayImage::from_fn(64, 32, |_, y| {
                image::Luma([if y < 16 { 255 } else { 0 }])
            });
            let mut bytes = std::io::Cursor::new(Vec::new());
            grey.write_to(&mut bytes, image::ImageFormat::Png).expect("memory");
            bytes.into_inner()
        };
        let mask = super::super::decode_mask("mask", &png).expect("a mask");
        let alpha = |face: usize| -> Vec<u8> {
            let rgba = cube_face(&source, Some(&mask), &CUBE_FACES[face], 16);
            rgba.chunks_exact(4).map(|pixel| pixel[3]).collect()
        };
        assert!(alpha(4).iter().all(|&a| a == 255), "up is shown");
        assert!(alpha(5).iter().all(|&a| a == 0), "down is hidden");
        let front = alpha(0);
        assert!(front[..128].iter().all(|&a| a == 255) && front[128..].iter().all(|&a| a == 0));
    }
}
