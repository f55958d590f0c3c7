//! Photographs: those of the nearest panoramas that see what the view sees, each at the level that
//! the view can show; and of every district around one panorama, coarse.

use std::collections::BTreeSet;
use std::sync::Arc;

use flaneur_proto::v1;
use flaneur_scene::{
    CUBE_FACES, IdError, ImageId, Panorama, PosedCamera, Projection, RigCamera, View,
};
use glam::UVec2;

use super::districts::representatives;
use super::samples::Samples;
use crate::FetchLimits;
use crate::sight::Sight;

/// Longest side of the level that is shown until the finer one has come, pixels.
const FIRST_SIDE_PX: u32 = 100;

/// A stored image to be shown: one photograph, or several faces of one sphere.
#[derive(Clone, Debug)]
pub(crate) struct WantedImage {
    /// The panorama.
    pub(crate) panorama: Arc<Panorama>,
    /// Index of the camera among the panorama's.
    pub(crate) camera: usize,
    /// The photographs that it gives and that are wanted, with their cameras at level 0. For a
    /// sphere also the index of each one's cube face.
    pub(crate) photographs: Photographs,
    /// The level that the view asks for.
    pub(crate) level: u32,
    /// A coarse level to begin with: at least `level`.
    pub(crate) first_level: u32,
    /// How much of the picture it decides wherever things are, 0 to 1: of all together at most 1.
    pub(crate) share_anywhere: f64,
    /// The same of what is there, as far as that is known.
    pub(crate) share: f64,
    /// Octaves of the picture that each level lacks of what the view could show, times the share that
    /// they are lacking in; up to `first_level`.
    pub(crate) lacking: Vec<f64>,
}

impl WantedImage {
    /// The camera that took it.
    pub(crate) fn rig_camera(&self) -> &RigCamera {
        &self.panorama.cameras[self.camera]
    }

    /// What a level of it is, for people.
    pub(crate) fn name(&self, level: u32) -> String {
        format!("photograph {}/{} at level {level}", self.panorama.id, self.rig_camera().id)
    }

    /// How a request names a level of it.
    pub(crate) fn key(&self, level: u32, layer: v1::ImageLayer) -> v1::ImageKey {
        v1::ImageKey {
            panorama: self.panorama.id.clone(),
            camera: self.rig_camera().id.clone(),
            level,
            layer: layer.into(),
        }
    }

    /// The levels that are fetched one after the other: all from the coarse one on, as each costs a
    /// fraction of the next.
    pub(crate) fn steps(&self) -> impl Iterator<Item = u32> + use<> {
        (self.level..=self.first_level).rev()
    }

    /// Pixels of its photographs at `level`.
    fn pixels(&self, level: u32) -> u64 {
        let size = photograph_size(&self.rig_camera().projection, level);
        u64::from(size.x) * u64::from(size.y) * self.photographs.len() as u64
    }
}

/// Of one photograph of a stored image's level.
fn photograph_size(projection: &Projection, level: u32) -> UVec2 {
    let size = projection.level_size(level);
    match projection {
        Projection::Pinhole(_) => size,
        Projection::Equirectangular { .. } => UVec2::splat(size.x / 4),
    }
}

/// The images that `view` wants, nearest panorama first, without those that `excluded` names.
///
/// `panoramas` are candidates in any order, of which the nearest [`FetchLimits::panoramas`] count.
/// Where the levels wanted hold more than [`FetchLimits::image_pixels`], all are taken coarser
/// alike, and the farthest left out where that does not help. Last come those of the panoramas that
/// stand for the districts around the eye, at their first level. What is wanted does not depend on
/// `sight`, which says what of it matters most. A panorama counts as if it were `favour` times nearer than
/// it is: what is held stays while the view wavers.
pub(crate) fn choose_photographs(
    panoramas: Vec<Arc<Panorama>>,
    view: &View,
    sight: &Sight,
    limits: &FetchLimits,
    excluded: &(dyn Fn(&ImageId) -> bool + Send + Sync),
    favour: &dyn Fn(&Panorama) -> f64,
) -> Result<Vec<WantedImage>, IdError> {
    let mut panoramas = panoramas;
    let distance = |p: &Panorama| p.position.distance(view.eye()) / favour(p);
    panoramas.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.id.cmp(&b.id)));
    let mut names = BTreeSet::new();
    panoramas.retain(|panorama| names.insert(panorama.id.clone()));
    let standing: BTreeSet<String> = representatives(&panoramas, view.eye().truncate(), favour);
    let samples = Samples::anywhere(view);
    let (mut wanted, mut coarse, mut rigs) = (Vec::new(), Vec::new(), 0);
    for panorama in panoramas {
        if rigs < limits.panoramas {
            let images = images_of(&panorama, &samples, limits.image_side, excluded)?;
            rigs += usize::from(!images.is_empty());
            wanted.extend(images);
        } else if standing.contains(&panorama.id) {
            coarse.extend(images_of(&panorama, &samples, limits.image_side, excluded)?);
        }
    }
    coarse.iter_mut().for_each(|image| image.level = image.first_level);
    let coarse_pixels: u64 = coarse.iter().map(|image| image.pixels(image.level)).sum();
    let for_fine = limits.image_pixels.saturating_sub(coarse_pixels);
    let finest = |image: &WantedImage, bias: u32| {
        (image.level + bias).min(image.rig_camera().level_count().saturating_sub(1))
    };
    let total = |bias: u32| -> u64 { wanted.iter().map(|i| i.pixels(finest(i, bias))).sum() };
    let bias = (0..32).find(|&bias| total(bias) <= for_fine).unwrap_or(32);
    for image in &mut wanted {
        image.level = finest(image, bias);
        image.first_level = image.first_level.max(image.level);
    }
    wanted.append(&mut coarse);
    // Images without coarser levels may still be too large together.
    let mut pixels = 0;
    wanted.retain(|image| {
        pixels += image.pixels(image.level);
        pixels <= limits.image_pixels
    });
    samples.set_shares(&mut wanted);
    wanted.iter_mut().for_each(|image| image.share_anywhere = image.share);
    if !sight.is_blind() {
        Samples::seen(view, sight).set_shares(&mut wanted);
    }
    Ok(wanted)
}

/// A stored image's photographs: name, camera at level 0, and of a sphere the index of its face.
type Photographs = Vec<(ImageId, PosedCamera, Option<usize>)>;

impl WantedImage {
    /// The stored image of a camera, by its index; `None` where `panorama` has no such camera.
    pub(crate) fn of_camera(
        panorama: &Arc<Panorama>,
        camera: usize,
    ) -> Result<Option<Self>, IdError> {
        let photographs = stored_images(panorama)?.into_iter().nth(camera);
        Ok(photographs.map(|photographs| Self::alone(panorama, camera, photographs)))
    }

    /// The stored image that gives the photograph `id`, at its finest level, with that photograph
    /// alone; `None` where `panorama` has none of that name.
    pub(crate) fn finest(panorama: &Arc<Panorama>, id: &ImageId) -> Result<Option<Self>, IdError> {
        let mut stored = stored_images(panorama)?.into_iter().enumerate();
        Ok(stored.find_map(|(camera, mut photographs)| {
            photographs.retain(|(of_image, ..)| of_image == id);
            (!photographs.is_empty()).then(|| Self::alone(panorama, camera, photographs))
        }))
    }

    /// The image of a camera at its finest level, wanted for itself, whatever a view shows of it.
    fn alone(panorama: &Arc<Panorama>, camera: usize, photographs: Photographs) -> Self {
        Self {
            panorama: Arc::clone(panorama),
            camera,
            photographs,
            level: 0,
            first_level: 0,
            share_anywhere: 1.0,
            share: 1.0,
            lacking: Vec::new(),
        }
    }
}

/// The photographs that each camera's stored image gives, in the cameras' order.
fn stored_images(panorama: &Panorama) -> Result<Vec<Photographs>, IdError> {
    let mut all = panorama.photographs()?.into_iter();
    let of_camera = |camera: &RigCamera| {
        let faces = match camera.projection {
            Projection::Pinhole(_) => 1,
            Projection::Equirectangular { .. } => CUBE_FACES.len(),
        };
        let named = all.by_ref().take(faces).enumerate();
        named.map(|(face, (id, posed))| (id, posed, (faces > 1).then_some(face))).collect()
    };
    Ok(panorama.cameras.iter().map(of_camera).collect())
}

fn images_of(
    panorama: &Arc<Panorama>,
    samples: &Samples,
    most_side: u32,
    excluded: &(dyn Fn(&ImageId) -> bool + Send + Sync),
) -> Result<Vec<WantedImage>, IdError> {
    let mut images = Vec::new();
    let stored = stored_images(panorama)?.into_iter();
    for (index, (camera, stored)) in panorama.cameras.iter().zip(stored).enumerate() {
        let mut photographs = Photographs::new();
        let mut level = u32::MAX;
        for photograph in stored {
            let (id, posed, _) = &photograph;
            if excluded(id) {
                continue;
            }
            if let Some(sharpness) = samples.sharpness(posed) {
                level = level.min(sharpness.log2().max(0.0) as u32);
                photographs.push(photograph);
            }
        }
        if photographs.is_empty() || camera.levels.is_empty() {
            continue;
        }
        let coarsest = camera.level_count() - 1;
        let side = |&level: &u32| camera.projection.level_size(level).max_element();
        let first_level = (0..camera.level_count())
            .find(|level| side(level) <= FIRST_SIDE_PX)
            .unwrap_or(coarsest);
        let finest = (0..=coarsest)
            .find(|&level| photograph_size(&camera.projection, level).max_element() <= most_side)
            .unwrap_or(coarsest);
        images.push(WantedImage {
            panorama: Arc::clone(panorama),
            camera: index,
            photographs,
            level: level.clamp(finest, coarsest),
            first_level,
            share_anywhere: 0.0,
            share: 0.0,
            lacking: Vec::new(),
        });
    }
    Ok(images)
}

#[cfg(test)]
mod tests;
