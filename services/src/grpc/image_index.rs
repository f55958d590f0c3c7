//! Which photographs and masks a scene has, and where they lie.

use flaneur_proto::{FieldError, v1};
use flaneur_scene::{Region, RigCamera};
use tonic::Status;

use super::panoramas::LAYER;
use super::status;
use crate::layers::panoramas::{self, image_path, mask_path};
use crate::store::Scene;

/// The cameras of every panorama of a scene.
///
/// All of them are held in memory while the scene is in use, about 200 bytes a camera.
#[derive(Default)]
pub(super) struct ImageIndex {
    /// In the order of their names.
    panoramas: Box<[IndexedPanorama]>,
}

struct IndexedPanorama {
    id: Box<str>,
    cameras: Box<[IndexedCamera]>,
}

struct IndexedCamera {
    id: Box<str>,
    version: Box<str>,
    mask: Option<(Box<str>, u64)>,
    /// Bytes of each level.
    levels: Box<[u64]>,
}

/// An image of an index: what a key is kept as, since a request may have thousands of them.
#[derive(Clone, Copy)]
pub(super) struct IndexedImage {
    panorama: u32,
    camera: u32,
    /// The level of the photograph, or the mask.
    level: Option<u32>,
}

/// An image, in full.
pub(super) struct Located {
    /// What it is asked for by.
    pub(super) key: v1::ImageKey,
    /// Its path below the scene.
    pub(super) path: String,
    pub(super) bytes: u64,
    pub(super) media_type: &'static str,
}

/// Why a key leads to no image.
pub(super) enum Missing {
    Field(FieldError),
    Thing { kind: &'static str, name: String, place: String },
}

impl ImageIndex {
    /// Reads the scene's table of panoramas; gives the bytes that the index takes, too.
    pub(super) async fn load(
        scene: &Scene,
        file: &crate::store::FileEntry,
    ) -> Result<(Self, usize), Status> {
        let (store, path, size) = super::object(scene, file)?;
        let failed = |e| status::of_layer(LAYER, &e);
        let mut cursor = panoramas::open(store, path, size, Region::All).await.map_err(failed)?;
        let mut panoramas = Vec::new();
        let mut bytes = 0;
        while let Some(panorama) = cursor.next().await.map_err(failed)? {
            let cameras: Box<[IndexedCamera]> =
                panorama.cameras.into_iter().map(IndexedCamera::from).collect();
            bytes +=
                cameras.iter().map(IndexedCamera::bytes).sum::<usize>() + panorama.id.len() + 64;
            panoramas.push(IndexedPanorama { id: panorama.id.into(), cameras });
        }
        panoramas.sort_by(|a, b| a.id.cmp(&b.id));
        Ok((Self { panoramas: panoramas.into() }, bytes))
    }

    /// The image that a key of a request to `scene` means.
    pub(super) fn find(&self, scene: &str, key: &v1::ImageKey) -> Result<IndexedImage, Missing> {
        key.image_id().map_err(Missing::Field)?;
        let missing = |kind, name: String, place| Missing::Thing { kind, name, place };
        let in_scene = || format!("scene {scene:?}");
        let in_image = || format!("image {}/{} of {}", key.panorama, key.camera, in_scene());
        let panorama = self
            .panoramas
            .binary_search_by(|panorama| (*panorama.id).cmp(&key.panorama))
            .map_err(|_| missing("panorama", format!("{:?}", key.panorama), in_scene()))?;
        let cameras = &self.panoramas[panorama].cameras;
        let camera = cameras.iter().position(|camera| *camera.id == *key.camera);
        let camera = camera.ok_or_else(|| {
            let in_panorama = format!("panorama {:?} of {}", key.panorama, in_scene());
            missing("camera", format!("{:?}", key.camera), in_panorama)
        })?;
        let IndexedCamera { levels, mask, .. } = &cameras[camera];
        let level = match v1::ImageLayer::try_from(key.layer) {
            Ok(v1::ImageLayer::Colour) if (key.level as usize) < levels.len() => Some(key.level),
            Ok(v1::ImageLayer::Colour) => {
                let place = format!("{}, which has {}", in_image(), levels.len());
                return Err(missing("level", key.level.to_string(), place));
            }
            Ok(v1::ImageLayer::Mask) if mask.is_none() => {
                return Err(missing("mask", "of its own".to_owned(), in_image()));
            }
            Ok(v1::ImageLayer::Mask) if key.level > 0 => {
                return Err(missing("mask of level", key.level.to_string(), in_image()));
            }
            Ok(v1::ImageLayer::Mask) => None,
            Err(_) => {
                let problem = format!("is {}, which is no layer", key.layer);
                return Err(Missing::Field(FieldError::new("layer", problem)));
            }
        };
        // Memory holds fewer.
        Ok(IndexedImage { panorama: panorama as u32, camera: camera as u32, level })
    }

    /// An image that [`ImageIndex::find`] gave; `None` where another index did.
    pub(super) fn locate(&self, image: IndexedImage) -> Option<Located> {
        let panorama = self.panoramas.get(image.panorama as usize)?;
        let camera = panorama.cameras.get(image.camera as usize)?;
        let (path, bytes, media_type, layer) = match image.level {
            Some(level) => {
                let path = image_path(&panorama.id, &camera.id, &camera.version, level);
                let bytes = *camera.levels.get(level as usize)?;
                (path, bytes, "image/jpeg", v1::ImageLayer::Colour)
            }
            None => {
                let (mask, bytes) = camera.mask.as_ref()?;
                (mask_path(mask), *bytes, "image/png", v1::ImageLayer::Mask)
            }
        };
        let key = v1::ImageKey {
            panorama: panorama.id.to_string(),
            camera: camera.id.to_string(),
            level: image.level.unwrap_or(0),
            layer: layer.into(),
        };
        Some(Located { key, path, bytes, media_type })
    }
}

impl From<RigCamera> for IndexedCamera {
    fn from(camera: RigCamera) -> Self {
        Self {
            levels: camera.levels.iter().map(|level| level.bytes).collect(),
            id: camera.id.into(),
            version: camera.version.into(),
            mask: camera.mask.map(|mask| (mask.name.into(), mask.image.bytes)),
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

impl Missing {
    /// The status where the key is the request's `position`th.
    pub(super) fn at(self, position: usize) -> Status {
        match self {
            Self::Field(error) => {
                status::invalid(&error.within(format_args!("images[{position}]")))
            }
            Self::Thing { kind, name, place } => status::not_found(kind, name, &place),
        }
    }
}
