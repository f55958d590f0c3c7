//! `FootprintService`.

use flaneur_proto::v1;
use futures::stream::{self, StreamExt};
use prost::Message;
use tonic::{Request, Response, Status};

use super::{MAX_MESSAGE_BYTES, MessageStream, Services, status};
use crate::layers::footprints::{self, FootprintCursor};

/// A batch is sent once it holds this many bytes: a street's worth of buildings.
const BATCH_BYTES: usize = 128 << 10;

/// Name of the layer in messages.
const LAYER: &str = "the footprints";

#[tonic::async_trait]
impl v1::footprint_service_server::FootprintService for Services {
    type StreamFootprintsStream = MessageStream<v1::FootprintBatch>;

    async fn stream_footprints(
        &self,
        request: Request<v1::StreamFootprintsRequest>,
    ) -> Result<Response<Self::StreamFootprintsStream>, Status> {
        let request = request.into_inner();
        let region = request.region().map_err(|e| status::invalid(&e))?;
        let scene = self.scene(&request.scene).await?;
        let Some(layer) = &scene.manifest.footprints else {
            return Ok(Response::new(stream::empty().boxed()));
        };
        let (store, path, size) = super::object(&scene, &layer.file)?;
        let cursor = footprints::open(store, path, size, region).await;
        let cursor = cursor.map_err(|e| status::of_layer(LAYER, &e))?;
        let batches = Batches { cursor, kept: None, geometry_only: request.geometry_only };
        let batches = stream::try_unfold(batches, Batches::next);
        Ok(Response::new(batches.boxed()))
    }
}

/// Footprints, batch by batch, read as the client takes them.
struct Batches {
    cursor: FootprintCursor,
    /// Read already, for the next batch.
    kept: Option<v1::Footprint>,
    /// Attributes stay behind.
    geometry_only: bool,
}

impl Batches {
    async fn next(mut self) -> Result<Option<(v1::FootprintBatch, Self)>, Status> {
        let mut batch = v1::FootprintBatch::default();
        let mut bytes = 0;
        while bytes < BATCH_BYTES {
            let footprint = match self.kept.take() {
                Some(footprint) => footprint,
                None => match self.read().await? {
                    Some(footprint) => footprint,
                    None => break,
                },
            };
            let size = footprint.encoded_len();
            if size > MAX_MESSAGE_BYTES {
                let what = format!("footprint {:?}", footprint.id);
                return Err(status::too_large(&what, size, MAX_MESSAGE_BYTES));
            }
            if bytes + size > MAX_MESSAGE_BYTES {
                self.kept = Some(footprint);
                break;
            }
            bytes += size;
            batch.footprints.push(footprint);
        }
        Ok((!batch.footprints.is_empty()).then_some((batch, self)))
    }

    async fn read(&mut self) -> Result<Option<v1::Footprint>, Status> {
        let footprint = self.cursor.next().await.map_err(|e| status::of_layer(LAYER, &e))?;
        Ok(footprint.map(|footprint| {
            let mut message = v1::Footprint::from(footprint);
            if self.geometry_only {
                message.attributes_json.clear();
            }
            message
        }))
    }
}
