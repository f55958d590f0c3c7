//! Photographs and their masks.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, PoisonError};

use flaneur_proto::{FieldError, v1};
use flaneur_scene::{CUBE_FACES, ImageId, ImageUpdate, Panorama, Projection, Region, SceneUpdate};
use futures::{Stream, StreamExt, TryStreamExt, future, stream};
use glam::UVec2;

use super::{BATCHES, Fetch, Known};
use crate::choose::{WantedImage, choose_photographs};
use crate::client::Payload;
use crate::decode::{Mask, Picture, cube_face, damaged, decode_mask, decode_picture};
use crate::{Client, StreamError};

/// Images a request.
const BATCH_IMAGES: usize = 4;
/// Candidates that are looked at for each panorama that may be used: some see nothing of
/// what the view sees.
const CANDIDATES: usize = 4;
/// Largest stored image that is taken, in pixels.
const MAX_PIXELS: u64 = 1 << 28;

/// One image to be fetched at one level.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// The image.
    pub(super) image: WantedImage,
    /// The level.
    level: u32,
}

/// Masks by name.
type Masks = HashMap<String, Arc<Mask>>;

impl Fetch {
    /// The images that the view wants, from the nearest panoramas.
    pub(super) async fn wanted_images(&self) -> Result<Vec<WantedImage>, StreamError> {
        let request = &self.request;
        if self.scene.panoramas == 0 {
            return Ok(Vec::new());
        }
        let radius_m = request.limits.panorama_radius_m;
        let disc = Region::Disc { centre: request.view.eye().truncate(), radius_m };
        let mut panoramas = std::pin::pin!(self.client.panoramas(disc).await?);
        let mut candidates: Vec<Arc<Panorama>> = Vec::new();
        while let Some(panorama) = panoramas.try_next().await? {
            let photographs = panorama.photographs().map_err(|e| bad_id(&e))?;
            if !photographs.iter().all(|(id, _)| (request.excluded)(id)) {
                candidates.push(Arc::new(panorama));
            }
            if candidates.len() == CANDIDATES * request.limits.panoramas {
                break;
            }
        }
        choose_photographs(candidates, &request.view, &request.limits, &*request.excluded)
            .map_err(|e| bad_id(&e))
    }

    /// What is to be fetched of `images`: first a coarse level of those that the receiver does
    /// not hold, later the wanted level of those that it holds at another.
    pub(super) fn image_steps(&self, images: &[WantedImage]) -> (Vec<Step>, Vec<Step>) {
        let (mut first, mut finer) = (Vec::new(), Vec::new());
        for image in images {
            let held = |id: &ImageId| self.resident.images.get(id).copied();
            let mut new = image.clone();
            new.photographs.retain(|(id, ..)| held(id).is_none());
            if !new.photographs.is_empty() {
                first.push(Step { level: image.first_level, image: new });
            }
            let mut rest = image.clone();
            rest.photographs
                .retain(|(id, ..)| held(id).unwrap_or(image.first_level) != image.level);
            if !rest.photographs.is_empty() {
                finer.push(Step { level: image.level, image: rest });
            }
        }
        (first, finer)
    }

    /// The updates that bring `steps`, in their order.
    pub(super) fn image_updates<'a>(
        &'a self,
        steps: &[Step],
        masks: &'a Masks,
    ) -> impl Stream<Item = Result<Vec<SceneUpdate>, StreamError>> + use<'a> {
        let batches: Vec<Vec<Step>> = steps.chunks(BATCH_IMAGES).map(<[Step]>::to_vec).collect();
        stream::iter(
            batches.into_iter().map(|batch| image_batch(&self.client, &self.known, batch, masks)),
        )
        .buffered(BATCHES)
    }
}

/// The photograph `id` of `panorama` as it is stored, at its finest level; `None` where the
/// panorama has none of that name.
pub(crate) async fn photograph(
    client: &Client,
    known: &Known,
    panorama: &Arc<Panorama>,
    id: &ImageId,
) -> Result<Option<Arc<ImageUpdate>>, StreamError> {
    let Some(image) = WantedImage::finest(panorama, id).map_err(|e| bad_id(&e))? else {
        return Ok(None);
    };
    let masks = masks(client, known, std::slice::from_ref(&image)).await?;
    let step = Step { image, level: 0 };
    let updates = image_batch(client, known, vec![step], &masks).await?;
    Ok(updates.into_iter().find_map(|update| match update {
        SceneUpdate::Image(image) => Some(image),
        _ => None,
    }))
}

/// The masks of `images`, by name.
pub(super) async fn masks(
    client: &Client,
    known: &Known,
    images: &[WantedImage],
) -> Result<Masks, StreamError> {
    let mut missing = BTreeMap::new();
    let mut masks = known.masks.lock().unwrap_or_else(PoisonError::into_inner).clone();
    for image in images {
        if let Some(mask) = &image.rig_camera().mask
            && !masks.contains_key(&mask.name)
        {
            missing.insert(mask.name.clone(), image.key(0, v1::ImageLayer::Mask));
        }
    }
    if missing.is_empty() {
        return Ok(masks);
    }
    let keys = missing.values().cloned().collect();
    let mut payloads = client.images(keys, MAX_PIXELS).await?;
    for name in missing.into_keys() {
        let Some(payload) = payloads.next().await? else { break };
        let what = format!("mask {name:?}");
        let decode = {
            let what = what.clone();
            move || decode_mask(&what, &payload.media_type, &payload.bytes)
        };
        let mask = Arc::new(known.decoders.run(&what, decode).await?);
        masks.insert(name.clone(), Arc::clone(&mask));
        let mut kept = known.masks.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(name, mask);
    }
    Ok(masks)
}

/// The updates that bring a few images, in one request.
async fn image_batch(
    client: &Client,
    known: &Known,
    steps: Vec<Step>,
    masks: &Masks,
) -> Result<Vec<SceneUpdate>, StreamError> {
    let mut limit = 0;
    for step in &steps {
        limit = limit.max(step.max_bytes()?);
    }
    let keys =
        steps.iter().map(|step| step.image.key(step.level, v1::ImageLayer::Colour)).collect();
    let mut payloads = client.images(keys, limit).await?;
    let mut decoded = Vec::new();
    for step in steps {
        let Some(payload) = payloads.next().await? else { break };
        let mask = step.image.rig_camera().mask.as_ref().and_then(|mask| masks.get(&mask.name));
        let (what, mask) = (step.name(), mask.cloned());
        let decode = move || step.decode(&payload, mask.as_deref());
        decoded.push(async move { known.decoders.run(&what, decode).await });
    }
    drop(payloads);
    Ok(future::try_join_all(decoded).await?.concat())
}

fn bad_id(error: &flaneur_scene::IdError) -> StreamError {
    StreamError::field("StreamPanoramas")(FieldError::new("id", error.to_string()))
}

impl Step {
    fn name(&self) -> String {
        let camera = &self.image.rig_camera().id;
        format!("photograph {}/{camera} at level {}", self.image.panorama.id, self.level)
    }

    /// Size of the stored image.
    fn size(&self) -> UVec2 {
        self.image.rig_camera().projection.level_size(self.level)
    }

    /// What the stored image may take: no picture takes more than four bytes a pixel and a
    /// header.
    fn max_bytes(&self) -> Result<u64, StreamError> {
        let size = self.size();
        let pixels = u64::from(size.x) * u64::from(size.y);
        if pixels > MAX_PIXELS {
            return Err(damaged(self.name(), format!("{size} pixels are too many")));
        }
        Ok(4 * pixels + (1 << 20))
    }

    fn decode(
        &self,
        payload: &Payload,
        mask: Option<&Mask>,
    ) -> Result<Vec<SceneUpdate>, StreamError> {
        let picture =
            decode_picture(&self.name(), &payload.media_type, &payload.bytes, self.size())?;
        let updates = self.image.photographs.iter().map(|(id, camera, face)| {
            let (size, rgba) = self.pixels(&picture, mask, *face);
            SceneUpdate::Image(Arc::new(ImageUpdate {
                id: id.clone(),
                level: self.level,
                camera: *camera,
                size,
                rgba,
                uncertainty_m: self.image.panorama.uncertainty_m,
            }))
        });
        Ok(updates.collect())
    }

    fn pixels(
        &self,
        picture: &Picture,
        mask: Option<&Mask>,
        face: Option<usize>,
    ) -> (UVec2, Vec<u8>) {
        match (self.image.rig_camera().projection, face.and_then(|face| CUBE_FACES.get(face))) {
            (Projection::Equirectangular { .. }, Some(face)) => {
                let side = (picture.size.x / 4).max(1);
                (UVec2::splat(side), cube_face(picture, mask, face, side))
            }
            _ => (picture.size, picture.masked(mask)),
        }
    }
}
