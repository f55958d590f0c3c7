//! The scenes that are on the device.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use flaneur_renderer::Gpu;
use flaneur_streamer::{Client, Servers, StreamOptions, Streamer};
use tokio::sync::Mutex;
use tonic::Status;

use super::feeder::{Feeder, Note};
use super::residents::FeederId;
use super::stage::Stage;
use super::wanted::{Wanted, Wish};
use super::{RenderOptions, refuse};

/// Scenes by name, opened when somebody wants them.
pub(super) struct Scenes {
    servers: Servers,
    options: Arc<RenderOptions>,
    open: Mutex<Open>,
}

struct Open {
    gpu: Gpu,
    by_name: HashMap<String, Entry>,
    /// One whose shaders are compiled already.
    spare: Option<Stage>,
    /// How often scenes were asked for.
    uses: u64,
}

struct Entry {
    scene: Arc<OpenScene>,
    /// When it was last asked for.
    used: u64,
}

/// A scene on the device, and where it comes from.
pub(super) struct OpenScene {
    /// From which those of its visitors come.
    pub(super) streamer: Streamer,
    pub(super) stage: Stage,
    feeders: AtomicU64,
}

/// One who looks at a scene; leaves it when dropped.
pub(super) struct Visit {
    pub(super) scene: Arc<OpenScene>,
    pub(super) feeder: Arc<Feeder>,
    pub(super) notes: tokio::sync::mpsc::UnboundedReceiver<Note>,
}

impl Scenes {
    pub(super) fn new(servers: Servers, gpu: Gpu, options: Arc<RenderOptions>) -> Self {
        let spare = Some(Stage::start(&gpu, &options));
        let open = Mutex::new(Open { gpu, by_name: HashMap::new(), spare, uses: 0 });
        Self { servers, options, open }
    }

    /// The scene as it is published now.
    ///
    /// # Errors
    /// Where there is none of that name, its server does not answer, or too many others are being
    /// looked at.
    pub(super) async fn open(&self, name: &str) -> Result<Arc<OpenScene>, Status> {
        let client = Client::new(self.servers.clone(), name);
        let info = client.scene().await.map_err(|e| refuse::of_stream(&e))?;
        if let Some(scene) = self.open.lock().await.known(name, &info.version).await? {
            return Ok(scene);
        }
        // Whatever its server takes for it, nobody waits for the others.
        let options = StreamOptions::default();
        let streamer = Streamer::connect_with(self.servers.clone(), name, options)
            .await
            .map_err(|e| refuse::of_stream(&e))?;
        let mut open = self.open.lock().await;
        // Another may have been quicker.
        if let Some(scene) = open.known(name, &streamer.info().version).await? {
            return Ok(scene);
        }
        open.by_name.remove(name);
        open.make_room(self.options.scenes)?;
        let stage = match open.spare.take() {
            Some(stage) => stage,
            None => Stage::start(&open.gpu, &self.options),
        };
        let scene = Arc::new(OpenScene { streamer, stage, feeders: AtomicU64::new(0) });
        let entry = Entry { scene: Arc::clone(&scene), used: open.uses };
        open.by_name.insert(name.to_owned(), entry);
        Ok(scene)
    }
}

impl Open {
    /// A scene that is open at this version, which is asked for once more.
    async fn known(&mut self, name: &str, version: &str) -> Result<Option<Arc<OpenScene>>, Status> {
        if self.has_failed() {
            self.start_over().await?;
        }
        self.uses += 1;
        let entry = self.by_name.get_mut(name);
        let current = entry.filter(|entry| entry.scene.streamer.info().version == version);
        Ok(current.map(|entry| {
            entry.used = self.uses;
            Arc::clone(&entry.scene)
        }))
    }

    /// Whether a driver failed so that the thread that used it has ended.
    fn has_failed(&self) -> bool {
        let stages = self.by_name.values().map(|entry| &entry.scene.stage);
        stages.chain(&self.spare).any(Stage::has_ended)
    }

    /// Opens the device anew. Those who looked are told by their own frames, and come again.
    async fn start_over(&mut self) -> Result<(), Status> {
        tracing::error!("the graphics driver failed: it is opened anew");
        self.by_name.clear();
        self.spare = None;
        let gpu = tokio::task::spawn_blocking(Gpu::new).await;
        let gpu = gpu.map_err(|e| Status::internal(e.to_string()))?;
        self.gpu = gpu.map_err(|e| refuse::of_render(&e))?;
        Ok(())
    }

    /// Closes the scene that was asked for longest ago and that nobody looks at, where there are
    /// `most`.
    fn make_room(&mut self, most: usize) -> Result<(), Status> {
        while self.by_name.len() >= most.max(1) {
            let idle =
                self.by_name.iter().filter(|(_, entry)| Arc::strong_count(&entry.scene) == 1);
            let Some(name) = idle.min_by_key(|(_, entry)| entry.used).map(|(name, _)| name.clone())
            else {
                return Err(refuse::busy("scenes are being looked at"));
            };
            self.by_name.remove(&name);
        }
        Ok(())
    }
}

impl Visit {
    pub(super) fn new(scene: Arc<OpenScene>, wanted: Wanted, wish: Wish) -> Self {
        let id: FeederId = scene.feeders.fetch_add(1, Ordering::Relaxed);
        let (feeder, notes) = Feeder::new(id, wanted, wish);
        Self { scene, feeder: Arc::new(feeder), notes }
    }

    pub(super) fn stage(&self) -> &Stage {
        &self.scene.stage
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        self.scene.stage.leave(self.feeder.id);
    }
}
