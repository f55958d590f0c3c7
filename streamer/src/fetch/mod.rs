//! Fetching what one view wants, in order.

mod images;
mod mesh;
mod points;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::{Arc, Mutex};

use flaneur_scene::{SceneInfo, SceneUpdate, TileKey};
use futures::{Stream, TryStreamExt};
use tokio::sync::mpsc;

pub(crate) use images::photograph;

use crate::choose::{Hierarchy, WantedNode};
use crate::decode::{Decoders, Mask, Track};
use crate::resident::Resident;
use crate::{Client, Event, Progress, StreamError, ViewRequest};

/// Batches of payloads that are fetched and decoded at once, of each kind.
const BATCHES: usize = 6;

/// What a streamer has learnt about its scene and keeps from view to view.
#[derive(Debug, Default)]
pub(crate) struct Known {
    /// Pages of the point sources.
    hierarchy: tokio::sync::Mutex<Hierarchy>,
    /// Masks by name: few, shared by many photographs.
    masks: Mutex<HashMap<String, Arc<Mask>>>,
    /// Footprint tiles without buildings.
    empty_tiles: Mutex<HashSet<TileKey>>,
    /// Where point sources, by their index, were taken from.
    tracks: tokio::sync::Mutex<HashMap<usize, Arc<Track>>>,
    /// Where payloads are decoded.
    decoders: Decoders,
}

/// The work for one view.
pub(crate) struct Fetch {
    pub(crate) client: Client,
    pub(crate) scene: Arc<SceneInfo>,
    pub(crate) known: Arc<Known>,
    /// What the receiver held when the view was asked for.
    pub(crate) resident: Resident,
    pub(crate) request: ViewRequest,
}

type Sender = mpsc::Sender<Result<Event, StreamError>>;

impl Fetch {
    /// Emits everything, or stops at the first error.
    pub(crate) async fn run(&self, sender: &Sender) -> Result<(), StreamError> {
        let outlet = Outlet { fetch: self, sender };
        // What is wanted of photographs and points is found out while the mesh arrives.
        let (tiles, images, nodes) =
            tokio::try_join!(self.mesh(&outlet), self.wanted_images(), self.wanted_nodes())?;
        let held = |wanted: &WantedNode| {
            let normals = self.resident.nodes.get(&wanted.id);
            normals.is_some_and(|normals| normals.is_none_or(|n| n == self.request.normals))
        };
        let new_nodes: Vec<_> = nodes.iter().filter(|w| !held(w)).copied().collect();
        let (first, finer) = self.image_steps(&images);
        let masks = images::masks(&self.client, &self.known, &images).await?;
        let mut remaining = photographs(&first) + new_nodes.len() + photographs(&finer);
        outlet.pass(self.image_updates(&first, &masks), &mut remaining).await?;
        outlet.pass(self.point_updates(&new_nodes), &mut remaining).await?;
        outlet.pass(self.image_updates(&finer, &masks), &mut remaining).await?;

        let kept_nodes: BTreeSet<_> = nodes.iter().map(|wanted| wanted.id).collect();
        let kept_images: BTreeSet<_> =
            images.iter().flat_map(|image| image.photographs.iter().map(|(id, ..)| id)).collect();
        for key in self.resident.tiles.difference(&tiles) {
            outlet.update(SceneUpdate::DropMesh(*key)).await?;
        }
        for id in self.resident.images.keys().filter(|id| !kept_images.contains(id)) {
            outlet.update(SceneUpdate::DropImage(id.clone())).await?;
        }
        for id in self.resident.nodes.keys().filter(|id| !kept_nodes.contains(id)) {
            outlet.update(SceneUpdate::DropPoints(*id)).await?;
        }
        outlet.progress(0, true).await
    }
}

fn photographs(steps: &[images::Step]) -> usize {
    steps.iter().map(|step| step.image.photographs.len()).sum()
}

/// Where events go.
struct Outlet<'a> {
    fetch: &'a Fetch,
    sender: &'a Sender,
}

impl Outlet<'_> {
    async fn update(&self, update: SceneUpdate) -> Result<(), StreamError> {
        self.send(Event::Update(update)).await
    }

    async fn progress(&self, remaining: usize, finished: bool) -> Result<(), StreamError> {
        let progress = Progress {
            bytes_received: self.fetch.client.bytes_received(),
            requests: self.fetch.client.requests(),
            remaining: remaining as u64,
            finished,
        };
        self.send(Event::Progress(progress)).await
    }

    /// Passes batches of updates on, each followed by a report.
    async fn pass(
        &self,
        batches: impl Stream<Item = Result<Vec<SceneUpdate>, StreamError>>,
        remaining: &mut usize,
    ) -> Result<(), StreamError> {
        let mut batches = std::pin::pin!(batches);
        while let Some(batch) = batches.try_next().await? {
            *remaining = remaining.saturating_sub(batch.len());
            for update in batch {
                self.update(update).await?;
            }
            self.progress(*remaining, false).await?;
        }
        Ok(())
    }

    async fn send(&self, event: Event) -> Result<(), StreamError> {
        self.sender.send(Ok(event)).await.map_err(|_| StreamError::Cancelled)
    }
}
