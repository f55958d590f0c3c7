//! Places that a view may see, at which photographs are compared with it and with each other.

use flaneur_scene::{Distortion, PosedCamera, View};
use glam::{DVec2, DVec3, UVec2};

use super::photographs::WantedImage;
use crate::sight::Sight;

/// Points of the view, along x, y and depth.
const GRID: UVec2 = UVec2::new(16, 9);
/// Their depths, metres along the view's axis.
const DEPTHS_M: [f64; 9] = [1.5, 2.5, 4.0, 6.5, 10.0, 16.0, 25.0, 50.0, 100.0];
/// A photograph is at least as sharp as the view at this share of the points, the others
/// being so close to the eye that no photograph could be.
const SHARP_SHARE: f64 = 0.75;
/// Part of an image's size by which the undistorted image may exceed it on each side.
const DISTORTION_MARGIN: f64 = 0.25;
/// Keeps weights finite where the eye, or a point, is at a photograph's centre, metres.
const NEAREST_M: f64 = 0.5;

/// Where nothing is met: the sky, and what is as far, metres.
const SKY_M: f64 = 100.0;

/// Points in front of the view, with the view's pixels a metre there.
pub(super) struct Samples {
    eye: DVec3,
    points: Vec<(DVec3, f64)>,
}

impl Samples {
    /// Wherever something may be.
    pub(super) fn anywhere(view: &View) -> Self {
        let size = view.size().as_dvec2();
        let mut points = Vec::new();
        for (x, y) in (0..GRID.y).flat_map(|y| (0..GRID.x).map(move |x| (x, y))) {
            let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / GRID.as_dvec2() * size;
            let Some(ray) = view.ray(at) else { continue };
            for depth in DEPTHS_M {
                points.push((ray.origin + ray.direction * depth, view.pixels_a_metre(depth)));
            }
        }
        Self { eye: view.eye(), points }
    }

    /// Where something is, as far as that is known.
    pub(super) fn seen(view: &View, sight: &Sight) -> Self {
        let points = sight.rays().iter().map(|(ray, met)| {
            let depth = met.unwrap_or(SKY_M);
            (ray.origin + ray.direction * depth, view.pixels_a_metre(depth))
        });
        Self { eye: view.eye(), points: points.collect() }
    }

    /// How many times sharper than the view a photograph is, at [`SHARP_SHARE`] of the points
    /// that both see; `None` where there are none.
    pub(super) fn sharpness(&self, photograph: &PosedCamera) -> Option<f64> {
        let mut ratios: Vec<f64> = self
            .points
            .iter()
            .filter_map(|(point, density)| {
                let depth = seen_depth(photograph, *point)?;
                Some(photograph.lens.intrinsics.fy / depth / density)
            })
            .collect();
        let index = ((1.0 - SHARP_SHARE) * ratios.len() as f64) as usize;
        (index < ratios.len()).then(|| *ratios.select_nth_unstable_by(index, f64::total_cmp).1)
    }

    /// Notes in `images` how much of the picture each decides: its weight at every point among the
    /// weights of all, by the distances of equation 4 of Park et al. And what each of its levels
    /// lacks of the sharpness that the view could show there.
    pub(super) fn set_shares(&self, images: &mut [WantedImage]) {
        let weights: Vec<Vec<Weight>> = images.iter().map(|image| self.weights(image)).collect();
        let mut sums = vec![0.0; self.points.len()];
        for (sum, weight) in weights.iter().flat_map(|of_one| std::iter::zip(0.., of_one)) {
            sums[sum] += weight.weight;
        }
        let count = self.points.len().max(1) as f64;
        for (image, weights) in images.iter_mut().zip(&weights) {
            let mut lacking = vec![0.0; image.first_level as usize + 1];
            let mut share = 0.0;
            for (weight, sum) in weights.iter().zip(&sums).filter(|(w, _)| w.weight > 0.0) {
                let part = weight.weight / sum / count;
                share += part;
                for (level, lacking) in lacking.iter_mut().enumerate() {
                    *lacking += part * (level as f64 - weight.enough).max(0.0);
                }
            }
            (image.share, image.lacking) = (share, lacking);
        }
    }

    /// The weight of an image at each point: that of the photograph of it that sees it.
    fn weights(&self, image: &WantedImage) -> Vec<Weight> {
        let nearest_2 = NEAREST_M * NEAREST_M;
        let mut weights = vec![Weight::default(); self.points.len()];
        for (_, photograph, _) in &image.photographs {
            let eye_2 = photograph.centre.distance_squared(self.eye) + nearest_2;
            for (weight, (point, density)) in weights.iter_mut().zip(&self.points) {
                let Some(depth) = seen_depth(photograph, *point) else { continue };
                let place_2 = photograph.centre.distance_squared(*point) + nearest_2;
                let found = 1.0 / (place_2 * eye_2);
                if found > weight.weight {
                    let sharpness = photograph.lens.intrinsics.fy / depth / density;
                    *weight = Weight { weight: found, enough: sharpness.log2().max(0.0) };
                }
            }
        }
        weights
    }
}

/// What an image says about a point.
#[derive(Clone, Copy, Debug, Default)]
struct Weight {
    weight: f64,
    /// The level from which on, upwards, it is no sharper than the view.
    enough: f64,
}

/// Depth of a point in a photograph, `None` where that does not see it.
///
/// The photograph's distortion is left out, and its image taken a margin larger instead: this decides
/// what is fetched, not where it is shown.
fn seen_depth(photograph: &PosedCamera, point: DVec3) -> Option<f64> {
    let lens = &photograph.lens;
    let margin = match lens.distortion {
        Distortion::None => 0.0,
        Distortion::RadialPixels { .. } | Distortion::Brown { .. } => DISTORTION_MARGIN,
        // Up to a half turn: all that lies in front.
        Distortion::Fisheye { .. } => f64::INFINITY,
    };
    let p_cam = photograph.cam_from_world(point);
    if !(p_cam.z > 0.0) {
        return None;
    }
    let size = lens.size.as_dvec2();
    let pixel = lens.intrinsics.pixel_from_normalised(p_cam.truncate() / p_cam.z) / size;
    ((pixel - 0.5).abs().max_element() <= 0.5 + margin).then_some(p_cam.z)
}
