//! What draws the street: a thread of its own, so that nobody who looks ever waits for it.
//!
//! The window says what it wants to see ([`Wish`]; the latest counts) and asks for other things
//! ([`Order`]); the painter streams, draws, and tells ([`News`]).

mod feed;
#[cfg(test)]
mod tests;
mod work;

use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use flaneur_renderer::{BudgetStanding, FrameStats, Gpu, Mode, Settings};
use flaneur_scene::View;
use flaneur_services::place::Found;
use flaneur_streamer::{FetchLimits, Statistics};
use glam::{DVec2, UVec2};
use tokio::sync::{mpsc, watch};

use super::ground::Ground;
use super::opened::Opened;
use crate::exit::Exit;
use work::Work;

/// What is to be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wish {
    pub(super) view: View,
    pub(super) mode: Mode,
    /// The view is about to change: a coarse frame now is better than a fine one later.
    pub(super) moving: bool,
}

/// What else is asked of the painter.
pub(super) enum Order {
    /// What a pixel of a view shows.
    Pick(Box<Click>),
    /// To go over to another scene.
    Open(Box<Opened>),
}

/// Someone clicks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Click {
    /// What they see.
    pub(super) view: View,
    /// Where in its picture.
    pub(super) pixel: DVec2,
    pub(super) purpose: Purpose,
}

/// What someone clicks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// To go there, or face it.
    Go,
    /// To go to the nearest photograph.
    Photograph,
    /// To measure, in a round of the tape.
    Measure(u64),
}

/// What the painter tells.
pub(super) enum News {
    /// A new frame.
    Frame(Box<Shown>),
    /// What a click met.
    Picked(Box<Click>, Option<Box<Found>>),
    /// Something is missing in the picture; the rest goes on.
    Fault(String),
    /// It cannot go on.
    Failed(Exit),
}

/// A frame, and what is to be known of it.
pub(super) struct Shown {
    pub(super) view: View,
    pub(super) mode: Mode,
    pub(super) size: UVec2,
    /// sRGB, rows from the top.
    pub(super) rgba: Vec<u8>,
    pub(super) stats: FrameStats,
    pub(super) took: Duration,
    /// No better one follows for this view.
    pub(super) is_final: bool,
    /// How the frame budget fares, where it holds.
    pub(super) budget: Option<BudgetStanding>,
    pub(super) streamed: Statistics,
    /// Tiles, images and nodes that are still to come.
    pub(super) remaining: u64,
}

/// How the painter works.
#[derive(Clone, Copy, Debug)]
pub(super) struct PaintOptions {
    pub(super) settings: Settings,
    pub(super) limits: FetchLimits,
    /// What a frame may take while the view moves.
    pub(super) budget: Duration,
}

/// A painter at work. It stops when this is dropped, which waits for it.
pub(super) struct Painter {
    wishes: Option<watch::Sender<Option<Wish>>>,
    orders: mpsc::UnboundedSender<Order>,
    ground: Arc<Mutex<Ground>>,
    thread: Option<JoinHandle<()>>,
}

impl Painter {
    /// Starts one, within a tokio runtime. `tell` is called on its thread.
    pub(super) fn start(
        gpu: Gpu,
        opened: Opened,
        options: PaintOptions,
        tell: impl Fn(News) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (wishes, wished) = watch::channel(None);
        let (orders, ordered) = mpsc::unbounded_channel();
        let ground = Arc::<Mutex<Ground>>::default();
        let runtime = tokio::runtime::Handle::current();
        let shared = Arc::clone(&ground);
        let thread = std::thread::Builder::new().name("painter".to_owned()).spawn(move || {
            // What it starts in the background belongs to the runtime.
            let _guard = runtime.enter();
            let mut work = Work::new(gpu, opened.streamer, options, shared);
            if let Err(exit) = runtime.block_on(work.run(wished, ordered, &tell)) {
                tell(News::Failed(exit));
            }
        })?;
        Ok(Self { wishes: Some(wishes), orders, ground, thread: Some(thread) })
    }

    /// What is to be seen from now on.
    pub(super) fn wish(&self, wish: Wish) {
        if let Some(wishes) = &self.wishes {
            wishes.send_if_modified(|before| {
                let news = *before != Some(wish);
                *before = Some(wish);
                news
            });
        }
    }

    /// Asks for something. Whoever has stopped has said so.
    pub(super) fn order(&self, order: Order) {
        drop(self.orders.send(order));
    }

    /// What is known of the ground by now.
    pub(super) fn ground(&self) -> std::sync::MutexGuard<'_, Ground> {
        self.ground.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        // A graphics driver at work must not be torn down by the end of the process.
        self.wishes = None;
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}
