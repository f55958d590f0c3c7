//! `PanoramaService`: the poses. Photographs are in [`super::images`].

use flaneur_proto::v1;
use flaneur_scene::{Panorama, Region};
use futures::stream::{self, StreamExt};
use prost::Message;
use tonic::{Request, Response, Status};

use super::{MAX_MESSAGE_BYTES, MessageStream, Services, status};
use crate::layers::panoramas;

/// Name of the layer in messages.
pub(super) const LAYER: &str = "the panoramas";

#[tonic::async_trait]
impl v1::panorama_service_server::PanoramaService for Services {
    type StreamPanoramasStream = MessageStream<v1::Panorama>;
    type StreamImagesStream = MessageStream<v1::ImagePart>;

    async fn stream_panoramas(
        &self,
        request: Request<v1::StreamPanoramasRequest>,
    ) -> Result<Response<Self::StreamPanoramasStream>, Status> {
        let request = request.into_inner();
        let region = request.region().map_err(|e| status::invalid(&e))?;
        let scene = self.scene(&request.scene).await?;
        let Some(layer) = &scene.manifest.panoramas else {
            return Ok(Response::new(stream::empty().boxed()));
        };
        let (store, path, size) = super::object(&scene, &layer.file)?;
        let failed = |e| status::of_layer(LAYER, &e);
        let stream = if let Region::Disc { .. } = region {
            // Nearest first: they must be known before the first is sent.
            let found = panoramas::read(store, path, size, region).await.map_err(failed)?;
            stream::iter(found).map(message).boxed()
        } else {
            let cursor = panoramas::open(store, path, size, region).await.map_err(failed)?;
            stream::try_unfold(cursor, async |mut cursor| {
                let found = cursor.next().await.map_err(|e| status::of_layer(LAYER, &e))?;
                found.map(|found| Ok((message(found)?, cursor))).transpose()
            })
            .boxed()
        };
        Ok(Response::new(stream))
    }

    async fn stream_images(
        &self,
        request: Request<v1::StreamImagesRequest>,
    ) -> Result<Response<Self::StreamImagesStream>, Status> {
        let request = request.into_inner();
        let scene = self.scene(&request.scene).await?;
        Ok(Response::new(self.images(scene, request.images).await?))
    }
}

fn message(panorama: Panorama) -> Result<v1::Panorama, Status> {
    let message = v1::Panorama::from(panorama);
    let bytes = message.encoded_len();
    if bytes > MAX_MESSAGE_BYTES {
        let what = format!("panorama {:?}", message.id);
        return Err(status::too_large(&what, bytes, MAX_MESSAGE_BYTES));
    }
    Ok(message)
}
