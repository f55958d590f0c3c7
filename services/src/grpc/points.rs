//! `PointService`.

use std::collections::VecDeque;

use flaneur_proto::{FieldError, MAX_KEYS, v1};
use flaneur_scene::NodeKey;
use futures::stream::{self, StreamExt, TryStreamExt};
use tonic::{Request, Response, Status};

use super::octrees::{Chunk, Octree};
use super::pieces::{Part, Payload, parts};
use super::{MessageStream, Services, status};
use crate::layers::copc::{Page, PageAddress, PageEntry, PageItem};
use crate::layers::stations;
use crate::store::{PointsLayer, Scene};

/// Entries of a message, each of at most 41 bytes: a page with more comes in several.
const MESSAGE_ENTRIES: usize = 16_384;

#[tonic::async_trait]
impl v1::point_service_server::PointService for Services {
    type GetHierarchyStream = MessageStream<v1::HierarchyPage>;
    type StreamChunksStream = MessageStream<v1::PointChunk>;

    async fn get_hierarchy(
        &self,
        request: Request<v1::GetHierarchyRequest>,
    ) -> Result<Response<Self::GetHierarchyStream>, Status> {
        let request = request.into_inner();
        let page = request.page.map(NodeKey::try_from).transpose();
        let page = page.map_err(|e: FieldError| status::invalid(&e.within("page")))?;
        let scene = self.scene(&request.scene).await?;
        let layer = source(&scene, &request.source)?;
        let octree = self.octrees.open(&scene, layer).await?;
        let (first, all) = match page {
            Some(key) => (octree.page_of(key).await?, false),
            None => (octree.root(), true),
        };
        let budget = octree.page_budget();
        let walk = Walk { octree, all, waiting: VecDeque::from([first]), budget };
        let source = layer.source.clone();
        let pages = stream::try_unfold(walk, Walk::next)
            .map_ok(move |page| stream::iter(messages(&source, &page)).map(Ok))
            .try_flatten();
        Ok(Response::new(pages.boxed()))
    }

    async fn stream_chunks(
        &self,
        request: Request<v1::StreamChunksRequest>,
    ) -> Result<Response<Self::StreamChunksStream>, Status> {
        let request = request.into_inner();
        if request.nodes.len() > MAX_KEYS {
            return Err(status::too_many("nodes", request.nodes.len(), MAX_KEYS));
        }
        let mut keys = Vec::with_capacity(request.nodes.len());
        for (position, key) in request.nodes.into_iter().enumerate() {
            keys.push(
                NodeKey::try_from(key)
                    .map_err(|e| status::invalid(&e.within(format_args!("nodes[{position}]"))))?,
            );
        }
        let scene = self.scene(&request.scene).await?;
        let layer = source(&scene, &request.source)?;
        let octree = self.octrees.open(&scene, layer).await?;
        let mut chunks = Vec::with_capacity(keys.len());
        for key in keys {
            chunks.push(octree.chunk(key).await?);
        }
        let (store, path, _) = super::object(&scene, &layer.file)?;
        let payload = move |chunk: Chunk| {
            Ok(Payload {
                path: path.clone(),
                range: chunk.offset..chunk.offset + u64::from(chunk.byte_size),
                what: octree.what.clone(),
                key: chunk,
            })
        };
        let source = layer.source.clone();
        let chunks = parts(store, self.ahead.clone(), chunks, payload);
        let chunks = chunks.map_ok(move |part: Part<Chunk>| {
            let chunk = &part.payload.key;
            v1::PointChunk {
                source: source.clone(),
                key: Some(chunk.key.into()),
                point_count: chunk.point_count,
                total_bytes: part.payload.total(),
                offset: part.offset,
                data: part.data,
            }
        });
        Ok(Response::new(chunks.boxed()))
    }

    async fn get_stations(
        &self,
        request: Request<v1::GetStationsRequest>,
    ) -> Result<Response<v1::GetStationsResponse>, Status> {
        let request = request.into_inner();
        let scene = self.scene(&request.scene).await?;
        let layer = source(&scene, &request.source)?;
        let stations = match &layer.stations {
            None => v1::Stations::default(),
            Some(file) => {
                let (store, path, size) = super::object(&scene, file)?;
                let stations = stations::read(&*store, &path, size).await;
                let what = format!("the stations of point source {:?}", layer.source);
                stations.map_err(|e| status::of_layer(&what, &e))?
            }
        };
        Ok(Response::new(v1::GetStationsResponse { stations: Some(stations) }))
    }
}

/// Pages from the root down, read as the client takes them.
struct Walk {
    octree: Octree,
    all: bool,
    waiting: VecDeque<PageAddress>,
    /// Bytes of pages that may still be read.
    budget: u64,
}

impl Walk {
    async fn next(mut self) -> Result<Option<(std::sync::Arc<Page>, Self)>, Status> {
        let Some(address) = self.waiting.pop_front() else { return Ok(None) };
        self.budget = self.budget.checked_sub(u64::from(address.byte_size)).ok_or_else(|| {
            tracing::error!(octree = self.octree.what, "pages of the hierarchy overlap");
            Status::data_loss(format!("{} cannot be read", self.octree.what))
        })?;
        let page = self.octree.page(address).await?;
        if self.all {
            self.waiting.extend(page.entries.iter().filter_map(|entry| match entry.item {
                PageItem::Page(address) => Some(address),
                PageItem::Node { .. } => None,
            }));
        }
        Ok(Some((page, self)))
    }
}

/// The point source of that name, or the only one where the name is empty.
fn source<'a>(scene: &'a Scene, name: &str) -> Result<&'a PointsLayer, Status> {
    let layers = &scene.manifest.points;
    if name.is_empty() {
        return match layers.as_slice() {
            [only] => Ok(only),
            [] => Err(status::not_found("point source", "", &in_scene(scene))),
            several => Err(status::invalid(&FieldError::new(
                "source",
                format!("is empty, but the scene has {} point sources", several.len()),
            ))),
        };
    }
    layers
        .iter()
        .find(|layer| layer.source == name)
        .ok_or_else(|| status::not_found("point source", format!("{name:?}"), &in_scene(scene)))
}

fn in_scene(scene: &Scene) -> String {
    format!("scene {:?}", scene.folder.name())
}

fn messages(source: &str, page: &Page) -> Vec<v1::HierarchyPage> {
    let entry = |entry: &PageEntry| {
        let key = Some(entry.key.into());
        match entry.item {
            PageItem::Node { point_count, byte_size, crc32, .. } => {
                v1::HierarchyEntry { key, point_count, byte_size, crc32, is_page: false }
            }
            PageItem::Page(_) => v1::HierarchyEntry { key, is_page: true, ..Default::default() },
        }
    };
    page.entries
        .chunks(MESSAGE_ENTRIES)
        .map(|entries| v1::HierarchyPage {
            source: source.to_owned(),
            page: Some(page.address.key.into()),
            entries: entries.iter().map(entry).collect(),
        })
        .collect()
}
