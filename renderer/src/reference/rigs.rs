//! What the photographs say together about a place.

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{ImageId, ImageUpdate, View};
use glam::DVec3;

use super::discs::Point;
use super::exposure::{self, Exposed};
use super::photograph::{Photograph, Seen};
use super::triangles::Triangles;
use crate::Settings;
use crate::frustum::Frustum;
use crate::pinhole::Pinhole;
use crate::shade::photograph::{closeness, mark, rig_weight};
use crate::shade::reference::{edge_weight, feather_weight, mask_weight, park_weight};
use crate::surface::reference::Shown;

/// Of the ideal picture behind a distorted view, whose field of view alone matters here.
const MAX_SIDE: u32 = 8192;
const MAX_PIXELS: u64 = 1 << 25;

/// The photographs that may colour the pixels of one eye.
#[derive(Debug)]
pub(super) struct Rigs<'a> {
    eye: DVec3,
    rigs: Vec<Rig<'a>>,
    depth_test: bool,
}

#[derive(Debug)]
struct Rig<'a> {
    /// Share of its weight that its place among the nearest rigs leaves it.
    weight: f64,
    /// Squared distance from the eye to its nearest camera, metres.
    nearest_2: f64,
    cameras: Vec<Camera<'a>>,
}

#[derive(Debug)]
struct Camera<'a> {
    id: &'a ImageId,
    photograph: Photograph<'a>,
    /// Factors of its linear colours.
    gain: DVec3,
}

/// Linear colours of a place, blended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend {
    pub(super) colour: DVec3,
    /// The same of the colours that stand for the photographs.
    pub(super) mark: DVec3,
}

impl<'a> Rigs<'a> {
    /// The rigs nearest to the eye of `view`, nearest first.
    pub(super) fn new(
        images: &'a BTreeMap<ImageId, Arc<ImageUpdate>>,
        view: &View,
        settings: &Settings,
        mesh: &'a Triangles,
        points: &[Point],
    ) -> Self {
        let eye = view.eye();
        let mut by_rig: BTreeMap<&str, Vec<&ImageUpdate>> = BTreeMap::new();
        for (id, image) in images {
            by_rig.entry(id.panorama()).or_default().push(image);
        }
        let mut nearest: Vec<(f64, Vec<&ImageUpdate>)> = by_rig
            .into_values()
            .map(|rig| {
                let distance_2 = |image: &&ImageUpdate| image.camera.centre.distance_squared(eye);
                (rig.iter().map(distance_2).fold(f64::INFINITY, f64::min), rig)
            })
            .collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let left_out_m = nearest.get(settings.rigs).map_or(f64::INFINITY, |rig| rig.0.sqrt());
        let mut rigs: Vec<Rig<'_>> = nearest
            .into_iter()
            .take(settings.rigs)
            .map(|(nearest_2, images)| Rig {
                weight: rig_weight(nearest_2.sqrt(), left_out_m),
                nearest_2,
                cameras: images
                    .into_iter()
                    .filter_map(|image| {
                        let side = settings.depth_map_side;
                        let points = if settings.refine_by_points { points } else { &[] };
                        let photograph = Photograph::new(image, side, mesh, points)?;
                        Some(Camera { id: &image.id, photograph, gain: DVec3::ONE })
                    })
                    .collect(),
            })
            .collect();
        if settings.exposure_gains {
            expose(&mut rigs, view);
        }
        Self { eye, rigs, depth_test: settings.depth_test }
    }

    #[cfg(test)]
    pub(super) fn gains(&self) -> Vec<(ImageId, DVec3)> {
        let cameras = self.rigs.iter().flat_map(|rig| &rig.cameras);
        cameras.map(|camera| (camera.id.clone(), camera.gain)).collect()
    }

    /// What the best camera of each rig says about a place (world), together; `None` where none
    /// of them sees it. `pixels_per_m` is the scale of the picture at the place.
    pub(super) fn blend(&self, position: DVec3, shown: &Shown, pixels_per_m: f64) -> Option<Blend> {
        let (mut sum, mut colours, mut marks) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for rig in &self.rigs {
            let Some((score, Camera { id, photograph, gain }, seen)) = rig.best(position, self.eye)
            else {
                continue;
            };
            let visible =
                if self.depth_test { photograph.visible_share(shown, &seen) } else { 1.0 };
            let (colour, inside) = photograph.look_up(&seen, pixels_per_m);
            let weight = park_weight(shown.normal, position, photograph.centre(), rig.nearest_2)
                * feather_weight(score)
                * mask_weight(inside)
                * edge_weight(visible)
                * rig.weight;
            if weight > 0.0 {
                sum += weight;
                colours += colour * *gain * weight;
                marks += DVec3::from_array(mark(id).map(f64::from)) * weight;
            }
        }
        (sum > 0.0).then(|| Blend { colour: colours / sum, mark: marks / sum })
    }
}

impl Rig<'_> {
    /// The camera that sees a place best, and its score: furthest inside its border, unless the
    /// eye is so close that it is in one camera rather than in the others. Of equals the first.
    fn best(&self, position: DVec3, eye: DVec3) -> Option<(f64, &Camera<'_>, Seen)> {
        let mut best: Option<(f64, &Camera<'_>, Seen)> = None;
        for camera in &self.cameras {
            let Some(seen) = camera.photograph.sees(position) else { continue };
            let distance_2 = camera.photograph.centre().distance_squared(eye);
            let score = seen.border * closeness(distance_2, self.nearest_2);
            if best.as_ref().is_none_or(|(other, ..)| score > *other) {
                best = Some((score, camera, seen));
            }
        }
        best
    }
}

/// Gives those of the photographs that can see something of the view the gains on which they agree.
fn expose(rigs: &mut [Rig<'_>], view: &View) {
    let Some(pinhole) = Pinhole::for_view(&view.camera.lens, MAX_SIDE, MAX_PIXELS) else { return };
    let frustum = Frustum::of_view(view, &pinhole);
    let is_used = |camera: &Camera<'_>| camera.photograph.frustum().meets(&frustum);
    let used: Vec<Exposed<'_, '_>> = rigs
        .iter()
        .flat_map(|rig| rig.cameras.iter().map(move |camera| (rig, camera)))
        .filter(|(_, camera)| is_used(camera))
        .map(|(rig, camera)| Exposed {
            photograph: &camera.photograph,
            nearest_2: rig.nearest_2,
            rig_weight: rig.weight,
        })
        .collect();
    let mut gains = exposure::gains(&used).into_iter();
    for camera in rigs.iter_mut().flat_map(|rig| &mut rig.cameras) {
        if is_used(camera) {
            camera.gain = gains.next().unwrap_or(DVec3::ONE);
        }
    }
}
