//! What a session hands to the thread that renders, and what comes back beside frames.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use flaneur_scene::{ImageId, SceneUpdate};
use flaneur_streamer::Streamer;
use tokio::sync::{Notify, mpsc};

use super::residents::FeederId;
use super::wanted::{Wanted, Wish};

/// Bytes that may wait to be brought to the device. One update may exceed it alone.
const WAITING_BYTES: usize = 16 << 20;

/// What the streamer must be told: the renderer did it by itself.
#[derive(Debug)]
pub(super) enum Note {
    Dropped(SceneUpdate),
    Coarser(ImageId, u32),
}

impl Note {
    /// Tells it.
    pub(super) fn tell(&self, streamer: &Streamer) {
        match self {
            Self::Dropped(update) => streamer.note(update),
            Self::Coarser(image, level) => streamer.note_level(image, *level),
        }
    }
}

/// One who feeds a renderer with what a streamer sends, and wants views of it.
#[derive(Debug)]
pub(super) struct Feeder {
    pub(super) id: FeederId,
    waiting: Mutex<Waiting>,
    wanted: Mutex<(Wanted, Wish)>,
    notes: mpsc::UnboundedSender<Note>,
    /// Told when there is room again.
    pub(super) room: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    updates: VecDeque<SceneUpdate>,
    bytes: usize,
}

impl Feeder {
    /// With the receiver of what its streamer must be told.
    pub(super) fn new(
        id: FeederId,
        wanted: Wanted,
        wish: Wish,
    ) -> (Self, mpsc::UnboundedReceiver<Note>) {
        let (notes, receiver) = mpsc::unbounded_channel();
        let feeder = Self {
            id,
            waiting: Mutex::default(),
            wanted: Mutex::new((wanted, wish)),
            notes,
            room: Notify::new(),
        };
        (feeder, receiver)
    }

    /// The latest view is what is rendered, whatever was wanted when a frame was asked for.
    pub(super) fn want(&self, wanted: Wanted, wish: Wish) {
        *locked(&self.wanted) = (wanted, wish);
    }

    pub(super) fn wanted(&self) -> (Wanted, Wish) {
        locked(&self.wanted).clone()
    }

    pub(super) fn push(&self, update: SceneUpdate) {
        let mut waiting = locked(&self.waiting);
        waiting.bytes += bytes_of(&update);
        waiting.updates.push_back(update);
    }

    pub(super) fn pop(&self) -> Option<SceneUpdate> {
        let mut waiting = locked(&self.waiting);
        let update = waiting.updates.pop_front()?;
        waiting.bytes = waiting.bytes.saturating_sub(bytes_of(&update));
        if waiting.bytes < WAITING_BYTES {
            self.room.notify_one();
        }
        Some(update)
    }

    pub(super) fn has_room(&self) -> bool {
        locked(&self.waiting).bytes < WAITING_BYTES
    }

    pub(super) fn is_empty(&self) -> bool {
        locked(&self.waiting).updates.is_empty()
    }

    pub(super) fn note(&self, note: Note) {
        // Nobody listens once the session has ended.
        drop(self.notes.send(note));
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What an update takes in memory, about.
fn bytes_of(update: &SceneUpdate) -> usize {
    match update {
        SceneUpdate::Mesh(tile) => 32 * tile.vertices.len() + 4 * tile.indices.len(),
        SceneUpdate::Image(image) => image.rgba.len(),
        SceneUpdate::Points(chunk) => 32 * chunk.positions.len(),
        SceneUpdate::DropMesh(_) | SceneUpdate::DropImage(_) | SceneUpdate::DropPoints(_) => 0,
    }
}
