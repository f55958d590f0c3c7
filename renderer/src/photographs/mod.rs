//! Resident photographs, and which of them a view should use.

use std::collections::BTreeMap;

use flaneur_scene::{Distortion, ImageId, ImageUpdate, Lens, PosedCamera};
use glam::{DMat3, DVec2, DVec3, UVec2};

use crate::frustum::Frustum;
use crate::lens::gpu_data::Lens as LensData;
use crate::pinhole::Pinhole;
use crate::shade::photograph::{Standing, rig_weight};
use crate::{Gpu, RenderError, Settings};

pub(crate) mod atlas;
mod crowd;
mod layout;
mod packing;
#[cfg(test)]
mod tests;

use atlas::{Atlas, NoPlace, Place};
pub(crate) use crowd::Crowded;

/// How far rows of a rotation may be from orthonormal.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// A photograph at the level that is resident.
#[derive(Debug)]
pub(crate) struct Photograph {
    /// Pose, and the lens of level 0.
    pub(crate) camera: PosedCamera,
    /// How far its place may be off, metres.
    pub(crate) uncertainty_m: f32,
    /// Of the resident pixels in their pyramid.
    pub(crate) level: u32,
    /// The lens of the resident level.
    resident: Lens,
    /// The same on the device.
    pub(crate) lens: LensData,
    /// The ideal pinhole of its depth map.
    pub(crate) map: Pinhole,
    pub(crate) frustum: Frustum,
    pub(crate) place: Place,
    /// Whether a mask hides any of its pixels.
    pub(crate) masked: bool,
    /// Another one whenever its pixels or its camera change.
    pub(crate) revision: u64,
}

#[derive(Debug)]
pub(crate) struct PhotographStore {
    photographs: BTreeMap<ImageId, Photograph>,
    pub(crate) atlas: Atlas,
    revision: u64,
}

impl PhotographStore {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { photographs: BTreeMap::new(), atlas: Atlas::new(gpu), revision: 0 }
    }

    /// Adds a photograph or replaces its pixels; gives whether its geometry changed.
    ///
    /// Where there is no room others make it, see [`PhotographStore::plan_room`]; where those are
    /// not enough, they and the photograph stay as they were. Either is noted in `crowded`.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        settings: &Settings,
        update: &ImageUpdate,
        eye: DVec3,
        crowded: &mut Crowded,
    ) -> Result<bool, RenderError> {
        let error = |what: String| RenderError::Image { id: update.id.clone(), what };
        check(update).map_err(error)?;
        let side = settings.depth_map_side;
        let map = Pinhole::for_depth_map(&update.camera.lens, side).ok_or_else(|| {
            error("its lens sees nothing: check focal length and distortion".into())
        })?;
        let most = settings.shares().photographs;
        let place = loop {
            match self.atlas.insert(gpu, update.size, &update.rgba, most) {
                Ok(place) => break place,
                Err(NoPlace::TooLarge { side }) => return Err(too_large(update, side)),
                Err(NoPlace::Memory) => {}
            }
            // The device may turn out to have less than was planned with.
            let Ok(steps) = self.plan_room(update, eye, most) else {
                crowded.refused = true;
                return Ok(false);
            };
            self.make_room(gpu, steps, &update.id, most, crowded);
        };
        let resident = update.camera.lens.scaled_to(update.size);
        let lens = LensData::new(&resident);
        let frustum = Frustum::new(&update.camera, &map);
        self.revision += 1;
        let (camera, revision) = (update.camera, self.revision);
        // What is no number says nothing.
        let stated = Some(update.uncertainty_m).filter(|metres| *metres > 0.0);
        let uncertainty_m = stated.map_or(0.0, |metres| metres.min(100.0)) as f32;
        let photograph = Photograph {
            camera,
            uncertainty_m,
            level: update.level,
            resident,
            lens,
            map,
            frustum,
            place,
            masked: update.rgba.chunks_exact(4).any(|pixel| pixel[3] < u8::MAX),
            revision,
        };
        let before = self.photographs.insert(update.id.clone(), photograph);
        if let Some(before) = &before {
            self.atlas.remove(&before.place);
        }
        Ok(before.is_none_or(|before| before.camera != update.camera))
    }

    /// Gives every photograph a depth map of another size.
    pub(crate) fn set_map_side(&mut self, side: u32) {
        for photograph in self.photographs.values_mut() {
            // It had one at another size, so its lens sees something.
            if let Some(map) = Pinhole::for_depth_map(&photograph.camera.lens, side) {
                photograph.frustum = Frustum::new(&photograph.camera, &map);
                photograph.map = map;
            }
        }
    }

    pub(crate) fn remove(&mut self, id: &ImageId) {
        if let Some(photograph) = self.photographs.remove(id) {
            self.atlas.remove(&photograph.place);
        }
    }

    /// The level at which a photograph is resident.
    pub(crate) fn level(&self, id: &ImageId) -> Option<u32> {
        self.photographs.get(id).map(|photograph| photograph.level)
    }

    pub(crate) fn len(&self) -> usize {
        self.photographs.len()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&ImageId, &Photograph)> {
        self.photographs.iter()
    }

    /// The photographs that can see something of `view`, of the `rigs` rigs nearest to `eye`,
    /// nearest first and each rig's together; at most `limit`. Which rigs those are depends on
    /// the eye alone, so that turning the head changes no pixel.
    pub(crate) fn select(
        &self,
        view: &Frustum,
        eye: DVec3,
        rigs: usize,
        limit: usize,
    ) -> Vec<(&ImageId, &Photograph, Standing)> {
        let mut selected = self.nearest(eye, rigs);
        selected.retain(|(_, photograph, _)| photograph.frustum.meets(view));
        selected.truncate(limit);
        selected
    }

    /// The photographs of the `rigs` rigs nearest to `eye`, nearest first and each rig's together.
    pub(crate) fn nearest(
        &self,
        eye: DVec3,
        rigs: usize,
    ) -> Vec<(&ImageId, &Photograph, Standing)> {
        let mut by_rig: BTreeMap<&str, Vec<(&ImageId, &Photograph)>> = BTreeMap::new();
        for (id, photograph) in &self.photographs {
            by_rig.entry(id.panorama()).or_default().push((id, photograph));
        }
        let mut nearest: Vec<(f64, Vec<(&ImageId, &Photograph)>)> = by_rig
            .into_values()
            .map(|rig| {
                let distance = |(_, p): &(_, &Photograph)| p.camera.centre.distance_squared(eye);
                (rig.iter().map(distance).fold(f64::INFINITY, f64::min), rig)
            })
            .collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let left_out_2 = nearest.get(rigs).map_or(f64::INFINITY, |(distance_2, _)| *distance_2);
        (0..)
            .zip(nearest.into_iter().take(rigs))
            .flat_map(|(rig, (nearest_2, photographs))| {
                let weight = rig_weight(nearest_2.sqrt(), left_out_2.sqrt());
                let standing = Standing { rig, rigs, nearest_2, weight };
                photographs.into_iter().map(move |(id, photograph)| (id, photograph, standing))
            })
            .collect()
    }

    /// Where the texel of a photograph's `pixel` lies, of its resident level: texture, layer, and place
    /// in that.
    pub(crate) fn texel(&self, of: &Photograph, pixel: DVec2) -> (&wgpu::Texture, u32, UVec2) {
        let last = of.resident.size.as_dvec2() - 1.0;
        let pixel = pixel.floor().clamp(DVec2::ZERO, last).as_uvec2();
        (self.atlas.texture(&of.place), of.place.layer, of.place.corner + pixel)
    }
}

impl Photograph {
    /// The lens of the level that is resident.
    pub(crate) fn resident_lens(&self) -> &Lens {
        &self.resident
    }
}

/// Why `camera` cannot be used, if so.
pub(crate) fn camera_fault(camera: &PosedCamera) -> Option<&'static str> {
    let Lens { size, intrinsics: i, distortion } = camera.lens;
    let rotation = camera.cam_from_world;
    let orthonormal =
        (rotation * rotation.transpose()).abs_diff_eq(DMat3::IDENTITY, ROTATION_TOLERANCE);
    let coefficients = match distortion {
        Distortion::None => true,
        Distortion::RadialPixels { centre, k, limit_px } => {
            centre.is_finite() && k.iter().all(|x| x.is_finite()) && limit_px > 0.0
        }
        Distortion::Brown { k, p } => k.iter().chain(&p).all(|x| x.is_finite()),
        Distortion::Fisheye { k } => k.iter().all(|x| x.is_finite()),
    };
    let focal = |f: f64| f > 0.0 && f.is_finite();
    if size.min_element() == 0 {
        Some("its lens has no pixels")
    } else if !camera.centre.is_finite() {
        Some("its centre is not finite")
    } else if !orthonormal || rotation.determinant() < 0.0 {
        Some("its orientation is no rotation")
    } else if !focal(i.fx) || !focal(i.fy) || !i.cx.is_finite() || !i.cy.is_finite() {
        Some("its focal lengths must be positive and its principal point finite")
    } else if !coefficients {
        Some("its distortion is not finite")
    } else {
        None
    }
}

fn check(update: &ImageUpdate) -> Result<(), String> {
    if let Some(fault) = camera_fault(&update.camera) {
        return Err(fault.to_owned());
    }
    let expected = u64::from(update.size.x) * u64::from(update.size.y) * 4;
    if expected == 0 || expected != update.rgba.len() as u64 {
        return Err(format!(
            "{} bytes cannot be a picture of {}x{} pixels in RGBA",
            update.rgba.len(),
            update.size.x,
            update.size.y
        ));
    }
    Ok(())
}

fn too_large(update: &ImageUpdate, side: u32) -> RenderError {
    let UVec2 { x, y } = update.size;
    let what = format!(
        "{x}x{y} pixels exceed the {side} pixels a side that the device takes: send a coarser level"
    );
    RenderError::Image { id: update.id.clone(), what }
}
