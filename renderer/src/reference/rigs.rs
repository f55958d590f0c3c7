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
use crate::infer::reference::{AROUND, COARSER};
use crate::pinhole::Pinhole;
use crate::renderer::MAX_PIXELS;
use crate::rest::reference::{NEAREST, heard};
use crate::shade::photograph::{closeness, mark, rig_weight};
use crate::shade::reference::{OPAQUE, edge_weight, feather_weight, mask_weight, park_weight};
use crate::surface::reference::Shown;

/// Of the ideal picture behind a distorted view, whose field of view alone matters here.
pub(super) const MAX_SIDE: u32 = 8192;

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
    /// Which it is of those that can see something of the view, if it can.
    drawn: Option<usize>,
    cameras: Vec<Camera<'a>>,
}

#[derive(Debug)]
struct Camera<'a> {
    id: &'a ImageId,
    photograph: Photograph<'a>,
    /// Whether it can see something of the view.
    drawn: bool,
    /// Factors of its linear colours.
    gain: DVec3,
}

/// How photographs are displaced at a pixel, so that the nearest two rigs agree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moves {
    /// From a place to where the nearest two rigs that can see something of the view have it, metres.
    pub(super) offsets: [DVec3; 2],
    /// Share of their weight that the others keep.
    pub(super) others: f64,
}

/// Linear colours of a place, blended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend {
    pub(super) colour: DVec3,
    /// The same of the colours that stand for the photographs.
    pub(super) mark: DVec3,
}

impl Blend {
    /// One that no photograph stands for.
    pub(super) fn of_colour(colour: DVec3) -> Self {
        Self { colour, mark: colour }
    }
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
        let pinhole = Pinhole::for_view(&view.camera.lens, MAX_SIDE, MAX_PIXELS);
        let frustum = pinhole.map(|pinhole| Frustum::of_view(view, &pinhole));
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
                drawn: None,
                cameras: images
                    .into_iter()
                    .filter_map(|image| {
                        let side = settings.depth_map_side;
                        let points = if settings.refine_by_points { points } else { &[] };
                        let photograph = Photograph::new(image, side, mesh, points)?;
                        let drawn = frustum.as_ref().is_some_and(|f| photograph.frustum().meets(f));
                        Some(Camera { id: &image.id, photograph, drawn, gain: DVec3::ONE })
                    })
                    .collect(),
            })
            .collect();
        let mut drawn = 0..;
        for rig in &mut rigs {
            rig.drawn =
                rig.cameras.iter().any(|camera| camera.drawn).then(|| drawn.next()).flatten();
        }
        if settings.exposure_gains {
            expose(&mut rigs);
        }
        Self { eye, rigs, depth_test: settings.depth_test }
    }

    /// From the eye to the rigs that can see something of the view, metres.
    pub(super) fn drawn_m(&self) -> Vec<f64> {
        self.drawn().map(|rig| rig.nearest_2.sqrt()).collect()
    }

    /// How bright the rig, of those that can see something of the view, shows a place (world) in a
    /// picture that has `pixels_per_m` there, and pixels `step` times as wide; `None` where it does not see it.
    pub(super) fn brightness(
        &self,
        rig: usize,
        position: DVec3,
        shown: &Shown,
        pixels_per_m: f64,
        step: f64,
    ) -> Option<f64> {
        let (_, Camera { photograph, gain, .. }, seen) =
            self.drawn().nth(rig)?.best(position, self.eye)?;
        let (colour, inside) = photograph.look_up(&seen, pixels_per_m, step);
        let sees = photograph.visible_share(shown, &seen) > 0.5 && inside >= OPAQUE;
        sees.then(|| brightness(colour * *gain))
    }

    /// By how much brighter the rig, of those that can see something of the view, shows a place (world)
    /// than what is around it, in a picture as in [`Rigs::brightness`], through the camera that sees
    /// it best of those that show it; `None` where none does.
    pub(super) fn stands_out(
        &self,
        rig: usize,
        position: DVec3,
        pixels_per_m: f64,
        step: f64,
    ) -> Option<f64> {
        let rig = self.drawn().nth(rig)?;
        let shows = |camera: &&Camera<'_>| {
            let seen = camera.photograph.sees(position);
            seen.is_some_and(|s| camera.photograph.look_up(&s, pixels_per_m, step).1 >= OPAQUE)
        };
        let (_, Camera { photograph, gain, .. }, seen) =
            best(rig.cameras.iter().filter(shows), rig.nearest_2, position, self.eye)?;
        let (colour, _) = photograph.look_up(&seen, pixels_per_m, step);
        let around = photograph.surroundings(&seen, pixels_per_m, step, AROUND, COARSER);
        let mean = around.map(|colour| brightness(colour * *gain)).iter().sum::<f64>() / 4.0;
        Some(brightness(colour * *gain) - mean)
    }

    fn drawn(&self) -> impl Iterator<Item = &Rig<'a>> {
        self.rigs.iter().filter(|rig| rig.drawn.is_some())
    }

    #[cfg(test)]
    pub(super) fn gains(&self) -> Vec<(ImageId, DVec3)> {
        let cameras = self.rigs.iter().flat_map(|rig| &rig.cameras);
        cameras.map(|camera| (camera.id.clone(), camera.gain)).collect()
    }

    /// What the best camera of each rig says about a place (world), together; `None` where none
    /// of them sees it. `off` is the share of its distance by which it may be, `pixels_per_m` the scale of
    /// the picture there.
    /// `moves` are for photographs that are aligned.
    pub(super) fn blend(
        &self,
        position: DVec3,
        shown: &Shown,
        off: f64,
        pixels_per_m: f64,
        moves: Option<Moves>,
    ) -> Option<Blend> {
        let (mut sum, mut colours, mut marks) = (0.0, DVec3::ZERO, DVec3::ZERO);
        let mut said = 0.0;
        for (order, rig) in self.rigs.iter().enumerate() {
            let (offset, share) = moves.map_or((DVec3::ZERO, 1.0), |moves| match rig.drawn {
                Some(drawn @ (0 | 1)) => (moves.offsets[drawn], 1.0),
                _ => (DVec3::ZERO, moves.others),
            });
            let Some((score, Camera { id, photograph, gain, .. }, seen)) =
                rig.best(position, self.eye)
            else {
                continue;
            };
            let visible =
                if self.depth_test { photograph.visible_share(shown, &seen) } else { 1.0 };
            let found = if offset == DVec3::ZERO {
                seen
            } else {
                photograph.displaced(&seen, position + offset)
            };
            let (colour, inside) = photograph.look_up_unsure(&found, pixels_per_m, self.eye, off);
            let weight = park_weight(shown.normal, position, photograph.centre(), rig.nearest_2)
                * feather_weight(score)
                * mask_weight(inside)
                * edge_weight(visible)
                * rig.weight
                * share;
            let weight = if order < NEAREST {
                said += weight;
                weight
            } else {
                heard(weight, said)
            };
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
    /// The camera that sees a place best, and its score.
    fn best(&self, position: DVec3, eye: DVec3) -> Option<(f64, &Camera<'_>, Seen)> {
        best(self.cameras.iter(), self.nearest_2, position, eye)
    }
}

/// Of the cameras of a rig the one that sees a place best, and its score: furthest inside its border,
/// unless the eye is so close that it is in one camera rather than in the others. Of equals the first.
fn best<'a, 'b: 'a>(
    cameras: impl Iterator<Item = &'a Camera<'b>>,
    nearest_2: f64,
    position: DVec3,
    eye: DVec3,
) -> Option<(f64, &'a Camera<'b>, Seen)> {
    let mut best: Option<(f64, &Camera<'_>, Seen)> = None;
    for camera in cameras {
        let Some(seen) = camera.photograph.sees(position) else { continue };
        let distance_2 = camera.photograph.centre().distance_squared(eye);
        let score = seen.border * closeness(distance_2, nearest_2);
        if best.as_ref().is_none_or(|(other, ..)| score > *other) {
            best = Some((score, camera, seen));
        }
    }
    best
}

/// Gives those of the photographs that can see something of the view the gains on which they agree.
fn expose(rigs: &mut [Rig<'_>]) {
    let used: Vec<Exposed<'_, '_>> = rigs
        .iter()
        .flat_map(|rig| rig.cameras.iter().map(move |camera| (rig, camera)))
        .filter(|(_, camera)| camera.drawn)
        .map(|(rig, camera)| Exposed {
            photograph: &camera.photograph,
            nearest_2: rig.nearest_2,
            rig_weight: rig.weight,
        })
        .collect();
    let gains = exposure::gains(&used);
    let drawn = rigs.iter_mut().flat_map(|rig| &mut rig.cameras).filter(|camera| camera.drawn);
    drawn.zip(gains).for_each(|(camera, gain)| camera.gain = gain);
}

/// About as bright as a linear colour looks.
fn brightness(linear: DVec3) -> f64 {
    // The weights of luminance of IEC 61966-2-1.
    linear.dot(DVec3::new(0.2126, 0.7152, 0.0722)).max(0.0).sqrt()
}
