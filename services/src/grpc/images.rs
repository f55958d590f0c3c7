//! The photographs and masks of panoramas, as they stand in the store.

use std::collections::HashMap;
use std::sync::Arc;

use flaneur_proto::{FieldError, MAX_KEYS, v1};
use flaneur_scene::Region;
use futures::stream::{StreamExt, TryStreamExt};
use tonic::Status;

use super::panoramas::LAYER;
use super::pieces::{Part, Payload, parts};
use super::{MessageStream, Services, status};
use crate::layers::panoramas::{self, image_path, mask_path};
use crate::store::Scene;

/// The cameras of every panorama of a scene, by the panorama's name.
///
/// All of them are held in memory while the scene is in use, about 200 bytes a camera.
pub(super) struct ImageIndex {
    cameras: HashMap<Box<str>, Box<[IndexedCamera]>>,
}

struct IndexedCamera {
    id: Box<str>,
    version: Box<str>,
    mask: Option<(Box<str>, u64)>,
    /// Bytes of each level.
    levels: Box<[u64]>,
}

/// Where an image lies.
struct Located {
    /// Below the scene.
    path: String,
    bytes: u64,
    media_type: &'static str,
}

impl Services {
    /// The parts of the asked images, one image after the other. All keys are looked up before
    /// the first part is read.
    pub(super) async fn images(
        &self,
        scene: Arc<Scene>,
        keys: Vec<v1::ImageKey>,
    ) -> Result<MessageStream<v1::ImagePart>, Status> {
        if keys.len() > MAX_KEYS {
            return Err(status::too_many("images", keys.len(), MAX_KEYS));
        }
        let index = self.image_index(&scene).await?;
        let mut wanted = Vec::with_capacity(keys.len());
        for (position, key) in keys.into_iter().enumerate() {
            let located = index.locate(&scene, &key).map_err(|e| e.at(position))?;
            let path = scene.folder.path(&located.path).map_err(|e| status::of_store(&e))?;
            let what = format!("image {}/{}", key.panorama, key.camera);
            let about = (key, located.media_type);
            wanted.push(Payload { path, range: 0..located.bytes, what, about });
        }
        let parts = parts(scene.folder.object_store(), self.ahead.clone(), wanted);
        let images = parts.map_ok(|part: Part<(v1::ImageKey, &str)>| {
            let (key, media_type) = &part.payload.about;
            v1::ImagePart {
                image: Some(key.clone()),
                media_type: (*media_type).to_owned(),
                total_bytes: part.payload.total(),
                offset: part.offset,
                data: part.data,
            }
        });
        Ok(images.boxed())
    }

    async fn image_index(&self, scene: &Scene) -> Result<Arc<ImageIndex>, Status> {
        let Some(layer) = &scene.manifest.panoramas else {
            return Ok(Arc::new(ImageIndex { cameras: HashMap::new() }));
        };
        let key = super::version_of(scene, &layer.file);
        self.image_indexes.get_or_load(&key, ImageIndex::load(scene, &layer.file)).await
    }
}

impl ImageIndex {
    async fn load(scene: &Scene, file: &crate::store::FileEntry) -> Result<(Self, usize), Status> {
        let (store, path, size) = super::object(scene, file)?;
        let failed = |e| status::of_layer(LAYER, &e);
        let mut cursor = panoramas::open(store, path, size, Region::All).await.map_err(failed)?;
        let mut cameras = HashMap::new();
        let mut bytes = 0;
        while let Some(panorama) = cursor.next().await.map_err(failed)? {
            let indexed: Box<[IndexedCamera]> = panorama
                .cameras
                .into_iter()
                .map(|camera| IndexedCamera {
                    levels: camera.levels.iter().map(|level| level.bytes).collect(),
                    id: camera.id.into(),
                    version: camera.version.into(),
                    mask: camera.mask.map(|mask| (mask.name.into(), mask.image.bytes)),
                })
                .collect();
            bytes +=
                indexed.iter().map(IndexedCamera::bytes).sum::<usize>() + panorama.id.len() + 64;
            cameras.insert(panorama.id.into(), indexed);
        }
        Ok((Self { cameras }, bytes))
    }

    fn locate(&self, scene: &Scene, key: &v1::ImageKey) -> Result<Located, Missing> {
        key.image_id().map_err(Missing::Field)?;
        let missing = |kind, name: String, place| Missing::Thing { kind, name, place };
        let in_scene = format!("scene {:?}", scene.folder.name());
        let cameras = self
            .cameras
            .get(key.panorama.as_str())
            .ok_or_else(|| missing("panorama", format!("{:?}", key.panorama), in_scene.clone()))?;
        let in_panorama = format!("panorama {:?} of {in_scene}", key.panorama);
        let camera = cameras
            .iter()
            .find(|camera| *camera.id == *key.camera)
            .ok_or_else(|| missing("camera", format!("{:?}", key.camera), in_panorama.clone()))?;
        let in_image = format!("image {}/{} of {in_scene}", key.panorama, key.camera);
        match v1::ImageLayer::try_from(key.layer) {
            Ok(v1::ImageLayer::Colour) => match camera.levels.get(key.level as usize) {
                Some(&bytes) => {
                    let path = image_path(&key.panorama, &key.camera, &camera.version, key.level);
                    Ok(Located { path, bytes, media_type: "image/jpeg" })
                }
                None => {
                    let place = format!("{in_image}, which has {}", camera.levels.len());
                    Err(missing("level", key.level.to_string(), place))
                }
            },
            Ok(v1::ImageLayer::Mask) => match &camera.mask {
                Some((mask, bytes)) if key.level == 0 => {
                    let path = mask_path(mask);
                    Ok(Located { path, bytes: *bytes, media_type: "image/png" })
                }
                Some(_) => Err(missing("mask of level", key.level.to_string(), in_image)),
                None => Err(missing("mask", "of its own".to_owned(), in_image)),
            },
            Err(_) => Err(Missing::Field(FieldError::new(
                "layer",
                format!("is {}, which is no layer", key.layer),
            ))),
        }
    }
}

impl IndexedCamera {
    fn bytes(&self) -> usize {
        let mask = self.mask.as_ref().map_or(0, |(mask, _)| mask.len());
        let levels = size_of_val(&*self.levels);
        size_of::<Self>() + self.id.len() + self.version.len() + mask + levels + 64
    }
}

/// Why a key leads to no image.
enum Missing {
    Field(FieldError),
    Thing { kind: &'static str, name: String, place: String },
}

impl Missing {
    /// The status where the key is the request's `position`th.
    fn at(self, position: usize) -> Status {
        match self {
            Self::Field(error) => {
                status::invalid(&error.within(format_args!("images[{position}]")))
            }
            Self::Thing { kind, name, place } => status::not_found(kind, name, &place),
        }
    }
}
