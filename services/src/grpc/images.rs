//! The photographs and masks of panoramas, as they stand in the store.

use std::sync::Arc;

use flaneur_proto::{MAX_KEYS, v1};
use futures::stream::{StreamExt, TryStreamExt};
use tonic::Status;

use super::image_index::{ImageIndex, IndexedImage};
use super::pieces::{Part, Payload, parts};
use super::{MessageStream, Services, status};
use crate::store::Scene;

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
        let find = |(position, key)| {
            index.find(scene.folder.name(), key).map_err(|missing| missing.at(position))
        };
        let wanted = keys.iter().enumerate().map(find).collect::<Result<Vec<IndexedImage>, _>>()?;
        drop(keys);
        let store = scene.folder.object_store();
        let located = {
            let index = Arc::clone(&index);
            move |image| index.locate(image).ok_or_else(|| Status::internal("an image is lost"))
        };
        let find_again = located.clone();
        let payload = move |image| {
            let located = located(image)?;
            let path = scene.folder.path(&located.path).map_err(|e| status::of_store(&e))?;
            let what = format!("image {}/{}", located.key.panorama, located.key.camera);
            Ok(Payload { path, range: 0..located.bytes, what, key: image })
        };
        let images = parts(store, self.ahead.clone(), wanted, payload);
        let images = images.and_then(move |part: Part<IndexedImage>| {
            let message = find_again(part.payload.key).map(|located| v1::ImagePart {
                image: Some(located.key),
                media_type: located.media_type.to_owned(),
                total_bytes: part.payload.total(),
                offset: part.offset,
                data: part.data,
            });
            std::future::ready(message)
        });
        Ok(images.boxed())
    }

    async fn image_index(&self, scene: &Scene) -> Result<Arc<ImageIndex>, Status> {
        let Some(layer) = &scene.manifest.panoramas else {
            return Ok(Arc::default());
        };
        let key = super::version_of(scene, &layer.file);
        self.image_indexes.get_or_load(&key, ImageIndex::load(scene, &layer.file)).await
    }
}
