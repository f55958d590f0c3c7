//! Point nodes.

use std::sync::Arc;

use flaneur_scene::SceneUpdate;
use futures::{Stream, StreamExt, future, stream};

use super::{BATCHES, Fetch};
use crate::StreamError;
use crate::choose::{WantedNode, choose_nodes};
use crate::decode::{Track, decode_points};

/// A batch is closed once it holds so many bytes…
const BATCH_BYTES: u64 = 1 << 20;
/// …or so many nodes.
const BATCH_NODES: usize = 64;

impl Fetch {
    /// The nodes that the view wants, loading pages of the hierarchies as needed.
    pub(super) async fn wanted_nodes(&self) -> Result<Vec<WantedNode>, StreamError> {
        let sources = &self.scene.point_sources;
        let mut hierarchy = self.known.hierarchy.lock().await;
        loop {
            let request = &self.request;
            let missing = match choose_nodes(&hierarchy, sources, &request.view, &request.limits) {
                Ok(wanted) => return Ok(wanted),
                Err(missing) => missing,
            };
            let pages = missing.iter().map(|page| async {
                let source = &sources[usize::from(page.source)].name;
                Ok((*page, self.client.hierarchy_page(source, page.key).await?))
            });
            for (page, entries) in future::try_join_all(pages).await? {
                hierarchy.insert(page, entries).map_err(StreamError::field("GetHierarchy"))?;
            }
        }
    }

    /// The updates that add `nodes`, in their order.
    pub(super) fn point_updates(
        &self,
        nodes: &[WantedNode],
    ) -> impl Stream<Item = Result<Vec<SceneUpdate>, StreamError>> {
        let batches = batches(nodes).into_iter().map(|batch| self.point_batch(batch));
        stream::iter(batches).buffered(BATCHES)
    }

    /// Where a source was taken from, asked for when its first points are.
    async fn track(&self, source_index: usize) -> Result<Arc<Track>, StreamError> {
        let mut tracks = self.known.tracks.lock().await;
        if let Some(track) = tracks.get(&source_index) {
            return Ok(Arc::clone(track));
        }
        let source = &self.scene.point_sources[source_index];
        let track = Arc::new(Track::through(&self.client.stations(&source.name).await?));
        tracks.insert(source_index, Arc::clone(&track));
        Ok(track)
    }

    async fn point_batch(&self, nodes: Vec<WantedNode>) -> Result<Vec<SceneUpdate>, StreamError> {
        let Some(first) = nodes.first() else { return Ok(Vec::new()) };
        let source_index = usize::from(first.id.source);
        let source = &self.scene.point_sources[source_index];
        let normals = self.request.normals;
        let track = self.track(source_index).await?;
        let limit = nodes.iter().map(|wanted| u64::from(wanted.node.byte_size)).max().unwrap_or(0);
        let keys = nodes.iter().map(|wanted| wanted.id.key).collect();
        let mut chunks = self.client.chunks(&source.name, keys, limit).await?;
        let mut decoded = Vec::new();
        for wanted in nodes {
            let Some(chunk) = chunks.next().await? else { break };
            let (scene, track) = (Arc::clone(&self.scene), Arc::clone(&track));
            let what = format!("node {:?} of point source {:?}", wanted.id.key, source.name);
            decoded.push(async move {
                let decode = move || {
                    let source = &scene.point_sources[source_index];
                    decode_points(source, wanted.id, &wanted.node, &chunk.bytes, &track, normals)
                };
                let chunk = self.known.decoders.run(&what, decode).await?;
                Ok(SceneUpdate::Points(Arc::new(chunk)))
            });
        }
        // Room for the next call while these are decoded.
        drop(chunks);
        future::try_join_all(decoded).await
    }
}

/// Runs of nodes of one source, each small enough for one request.
fn batches(nodes: &[WantedNode]) -> Vec<Vec<WantedNode>> {
    let mut batches: Vec<Vec<WantedNode>> = Vec::new();
    let mut bytes = 0;
    for &wanted in nodes {
        let fits = batches.last().is_some_and(|batch| {
            batch.len() < BATCH_NODES
                && bytes < BATCH_BYTES
                && batch.first().is_some_and(|first| first.id.source == wanted.id.source)
        });
        if !fits {
            batches.push(Vec::new());
            bytes = 0;
        }
        bytes += u64::from(wanted.node.byte_size);
        if let Some(batch) = batches.last_mut() {
            batch.push(wanted);
        }
    }
    batches
}
