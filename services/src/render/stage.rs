//! A scene on the device, and the thread that renders it.
//!
//! Whoever wants something from it gives an order and waits for the answer before the next: so all
//! have their turn, in the order in which they asked.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use flaneur_renderer::{Applied, Frame, FrameBudget, Gpu, Mode, Picked, RenderError, Renderer};
use flaneur_scene::{PointNodeId, SceneUpdate, View};
use glam::DVec2;
use tokio::sync::{mpsc, oneshot};

use super::RenderOptions;
use super::feeder::{Feeder, Note};
use super::residents::{FeederId, Residents};
use super::wanted::{Wanted, Wish};
use super::warm;

/// How long a frame waits for what is to be brought to the device, at least; the rest comes with
/// the next one …
const APPLYING: Duration = Duration::from_millis(25);
/// … and as a share of what its budget is, where that is more.
const APPLYING_SHARE: f64 = 0.5;

/// The orders of one scene. The thread ends, and what is on the device is given up, when it is dropped.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    orders: mpsc::UnboundedSender<Order>,
}

/// A frame, and what of it is worth knowing.
#[derive(Debug)]
pub(super) struct Painted {
    pub(super) frame: Frame,
    pub(super) wanted: Wanted,
    pub(super) wish: Wish,
    /// Whether no better one can be made of what there is.
    pub(super) finished: bool,
    /// Whether something waits that it does not show.
    pub(super) left: bool,
    pub(super) took: Duration,
}

/// How a frame is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Manner {
    /// The view of which everything has been handed over that is to come.
    pub(super) finish: Option<u64>,
    /// Whether the first frame of a view may take as long as it needs.
    pub(super) patient: bool,
}

enum Order {
    Apply(Arc<Feeder>),
    Frame(Arc<Feeder>, Manner, oneshot::Sender<Result<Painted, RenderError>>),
    Pick(Box<Wanted>, DVec2, oneshot::Sender<Result<Option<Found>, RenderError>>),
    Leave(FeederId),
}

/// What a pixel shows.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) picked: Picked,
    /// The nodes of points that are on the device.
    pub(super) nodes: BTreeSet<PointNodeId>,
}

impl Stage {
    /// Starts the thread. Shaders are compiled there.
    pub(super) fn start(gpu: &Gpu, options: &RenderOptions) -> std::io::Result<Self> {
        let (orders, received) = mpsc::unbounded_channel();
        let (gpu, options) = (gpu.clone(), options.clone());
        let run = move || {
            let mut renderer = Renderer::with_settings(&gpu, options.settings);
            if let Err(error) = warm::up(&mut renderer) {
                tracing::warn!(%error, "shaders will be compiled with the first frame");
            }
            Painter::new(renderer, options).follow(received);
        };
        std::thread::Builder::new().name("render".to_owned()).spawn(run)?;
        Ok(Self { orders })
    }

    /// Brings some of what `feeder` has waiting to the device.
    pub(super) fn apply(&self, feeder: &Arc<Feeder>) {
        self.order(Order::Apply(Arc::clone(feeder)));
    }

    /// A frame of what `feeder` wants when its turn has come.
    ///
    /// # Errors
    /// Where the view cannot be rendered, or the driver fails.
    pub(super) async fn frame(
        &self,
        feeder: &Arc<Feeder>,
        manner: Manner,
    ) -> Result<Painted, RenderError> {
        let (reply, answer) = oneshot::channel();
        self.order(Order::Frame(Arc::clone(feeder), manner, reply));
        answer.await.unwrap_or_else(|_| Err(gone()))
    }

    /// What `pixel` of a view shows, of what is on the device.
    ///
    /// # Errors
    /// As [`Stage::frame`].
    pub(super) async fn pick(
        &self,
        wanted: Wanted,
        pixel: DVec2,
    ) -> Result<Option<Found>, RenderError> {
        let (reply, answer) = oneshot::channel();
        self.order(Order::Pick(Box::new(wanted), pixel, reply));
        answer.await.unwrap_or_else(|_| Err(gone()))
    }

    /// Whether the thread has ended by itself: its driver failed beyond what can be told.
    pub(super) fn has_ended(&self) -> bool {
        self.orders.is_closed()
    }

    /// `feeder` wants nothing any more.
    pub(super) fn leave(&self, feeder: FeederId) {
        self.order(Order::Leave(feeder));
    }

    fn order(&self, order: Order) {
        // A thread that has gone answers nobody, which those who wait take for an error.
        drop(self.orders.send(order));
    }
}

fn gone() -> RenderError {
    RenderError::Driver("it ended".to_owned())
}

/// What the thread knows.
struct Painter {
    renderer: Renderer,
    options: RenderOptions,
    residents: Residents,
    visitors: HashMap<FeederId, Visitor>,
    /// Whose frame was the last.
    last: Option<FeederId>,
    /// What that shows, as long as nothing has changed since.
    current: Option<(View, Mode)>,
}

/// What it knows of one who feeds it.
struct Visitor {
    feeder: Arc<Feeder>,
    asked: Duration,
    budget: FrameBudget,
    /// The view of its last frame.
    shown: Option<u64>,
}

impl Painter {
    fn new(renderer: Renderer, options: RenderOptions) -> Self {
        let (residents, visitors) = (Residents::default(), HashMap::new());
        Self { renderer, options, residents, visitors, last: None, current: None }
    }

    fn follow(mut self, mut orders: mpsc::UnboundedReceiver<Order>) {
        while let Some(order) = orders.blocking_recv() {
            match order {
                Order::Apply(feeder) => {
                    if let Err(error) = self.apply(&feeder, APPLYING) {
                        tracing::warn!(%error, "left out of the scene");
                    }
                    // Also where there is no room yet: another order makes more.
                    feeder.room.notify_one();
                }
                Order::Frame(feeder, manner, reply) => {
                    // Who has gone meanwhile needs none.
                    if !reply.is_closed() {
                        drop(reply.send(self.paint(&feeder, manner)));
                    }
                }
                Order::Pick(wanted, pixel, reply) => {
                    if !reply.is_closed() {
                        drop(reply.send(self.pick(&wanted, pixel)));
                    }
                }
                Order::Leave(feeder) => self.leave(feeder),
            }
        }
    }

    fn paint(&mut self, feeder: &Arc<Feeder>, manner: Manner) -> Result<Painted, RenderError> {
        let (expected, wish) = feeder.wanted();
        let asked = wish.budget.unwrap_or(self.options.budget);
        self.renderer.expect_eye(expected.view.eye());
        self.apply(feeder, APPLYING.max(asked.mul_f64(APPLYING_SHARE)))?;
        let left = !feeder.is_empty();
        // Meanwhile another may have come.
        let (wanted, wish) = feeder.wanted();

        let began = Instant::now();
        let base = self.options.settings;
        let follows = self.last.replace(feeder.id) == Some(feeder.id);
        let visitor = self.visitor(feeder, asked);
        let is_first = visitor.shown.replace(wanted.sequence) != Some(wanted.sequence);
        let hurries = is_first && !manner.patient;
        let settings = if hurries { visitor.budget.settings(base) } else { base };
        let finished = manner.finish == Some(wanted.sequence) && !left && settings == base;
        self.renderer.set_settings(settings);
        // The last frame of a view depends on nothing but that view.
        if finished || !follows {
            self.renderer.cut();
        }
        let frame = self.render(&wanted)?;
        let took = began.elapsed();
        if hurries && let Some(visitor) = self.visitors.get_mut(&feeder.id) {
            visitor.budget.observe(took);
        }
        Ok(Painted { frame, wanted, wish, finished, left, took })
    }

    fn render(&mut self, wanted: &Wanted) -> Result<Frame, RenderError> {
        self.current = None;
        let frame = self.renderer.render_as(&wanted.view, wanted.mode)?;
        self.current = Some((wanted.view, wanted.mode));
        Ok(frame)
    }

    fn pick(&mut self, wanted: &Wanted, pixel: DVec2) -> Result<Option<Found>, RenderError> {
        if self.current != Some((wanted.view, wanted.mode)) {
            // It is nobody's: the next frame of whoever had the last does not follow it.
            self.last = None;
            self.renderer.set_settings(self.options.settings);
            self.renderer.cut();
            self.render(wanted)?;
        }
        let picked = self.renderer.pick(pixel)?;
        Ok(picked.map(|picked| Found { picked, nodes: self.residents.nodes().collect() }))
    }

    /// Brings what waits to the device, for about so long.
    fn apply(&mut self, feeder: &Arc<Feeder>, most: Duration) -> Result<(), RenderError> {
        self.visitor(feeder, self.options.budget);
        let began = Instant::now();
        while began.elapsed() < most
            && let Some(update) = feeder.pop()
        {
            if let Some(update) = self.residents.give(feeder.id, update) {
                self.current = None;
                let applied = match self.renderer.apply(update) {
                    Ok(applied) => applied,
                    Err(error @ RenderError::Driver(_)) => return Err(error),
                    // What contradicts itself is left out; the rest goes on.
                    Err(error) => {
                        tracing::warn!(%error, "left out of the scene");
                        continue;
                    }
                };
                self.tell(applied);
            }
        }
        Ok(())
    }

    /// Tells whoever keeps account what the renderer did by itself.
    fn tell(&mut self, applied: Applied) {
        for dropped in applied.evicted {
            for id in self.residents.evicted(&dropped) {
                self.note(id, Note::Dropped(dropped.clone()));
            }
        }
        for (image, level) in applied.coarser {
            for id in self.residents.coarsened(&image, level) {
                self.note(id, Note::Coarser(image.clone(), level));
            }
        }
    }

    fn note(&self, id: FeederId, note: Note) {
        if let Some(visitor) = self.visitors.get(&id) {
            visitor.feeder.note(note);
        }
    }

    fn leave(&mut self, feeder: FeederId) {
        self.visitors.remove(&feeder);
        self.last.take_if(|last| *last == feeder);
        for update in self.residents.leave(feeder) {
            self.drop_resident(update);
        }
    }

    fn drop_resident(&mut self, update: SceneUpdate) {
        self.current = None;
        match self.renderer.apply(update) {
            Ok(applied) => self.tell(applied),
            Err(error) => tracing::warn!(%error, "not dropped from the scene"),
        }
    }

    fn visitor(&mut self, feeder: &Arc<Feeder>, asked: Duration) -> &mut Visitor {
        let visitor = self.visitors.entry(feeder.id).or_insert_with(|| Visitor {
            feeder: Arc::clone(feeder),
            asked,
            budget: FrameBudget::new(asked),
            shown: None,
        });
        if visitor.asked != asked {
            (visitor.asked, visitor.budget) = (asked, FrameBudget::new(asked));
        }
        visitor
    }
}
