//! `GroundService`.

use flaneur_proto::v1;
use futures::stream::{self, StreamExt};
use tonic::{Request, Response, Status};

use super::{MessageStream, Services, status};
use crate::layers::ground;

/// Name of the layer in messages.
const LAYER: &str = "the ground";

#[tonic::async_trait]
impl v1::ground_service_server::GroundService for Services {
    type StreamGroundStream = MessageStream<v1::GroundTile>;

    async fn stream_ground(
        &self,
        request: Request<v1::StreamGroundRequest>,
    ) -> Result<Response<Self::StreamGroundStream>, Status> {
        let request = request.into_inner();
        let region = request.region().map_err(|e| status::invalid(&e))?;
        let step = request.checked_step().map_err(|e| status::invalid(&e))?;
        let scene = self.scene(&request.scene).await?;
        let Some(layer) = &scene.manifest.ground else {
            return Ok(Response::new(stream::empty().boxed()));
        };
        let (store, path, size) = super::object(&scene, &layer.file)?;
        let cursor = ground::open(store, path, size, region, step).await;
        let cursor = cursor.map_err(|e| status::of_layer(LAYER, &e))?;
        let tiles = stream::try_unfold(cursor, async |mut cursor| {
            let tile = cursor.next().await.map_err(|e| status::of_layer(LAYER, &e))?;
            let tile = tile.map(v1::GroundTile::try_from).transpose();
            let tile = tile.map_err(|e| status::of_field(LAYER, &e))?;
            Ok(tile.map(|tile| (tile, cursor)))
        });
        Ok(Response::new(tiles.boxed()))
    }
}
