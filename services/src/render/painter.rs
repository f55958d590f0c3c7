//! The thread that renders a scene, for all who look at it.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use flaneur_renderer::{Applied, Frame, FrameBudget, Mode, RenderError, Renderer};
use flaneur_scene::{SceneUpdate, View};
use glam::DVec2;
use tokio::sync::{mpsc, oneshot};

use super::RenderOptions;
use super::feeder::{Feeder, Note};
use super::residents::{FeederId, Residents};
use super::stage::{Manner, Order, Painted};
use super::wanted::Wanted;
use crate::place::Found;

/// How long a frame waits for what is to be brought to the device, at least; the rest comes with
/// the next one …
const APPLYING: Duration = Duration::from_millis(25);
/// … and as a share of what its budget is, where that is more.
const APPLYING_SHARE: f64 = 0.5;

/// Whose frames those are that picks alone are for: of no feeder, whose numbers count up from 0.
const NOBODY: FeederId = FeederId::MAX;

/// What the thread knows.
pub(super) struct Painter {
    renderer: Renderer,
    options: RenderOptions,
    residents: Residents,
    visitors: HashMap<FeederId, Visitor>,
    /// The budget whose frames were timed last: who comes next begins where it stands.
    timed: Option<FrameBudget>,
    /// What the last frame shows, as long as nothing has changed since.
    current: Option<(View, Mode)>,
}

/// What it knows of one who feeds it.
struct Visitor {
    feeder: Arc<Feeder>,
    budget: FrameBudget,
    /// The view of its last frame.
    shown: Option<u64>,
}

impl Painter {
    /// An empty scene on `renderer`.
    pub(super) fn new(renderer: Renderer, options: RenderOptions) -> Self {
        let (residents, visitors) = (Residents::default(), HashMap::new());
        Self { renderer, options, residents, visitors, timed: None, current: None }
    }

    /// Obeys until nobody can give orders any more, or the device fails.
    pub(super) fn follow(mut self, mut orders: mpsc::UnboundedReceiver<Order>) {
        while let Some(order) = orders.blocking_recv() {
            if let Err(reason) = self.obey(order) {
                tracing::error!(reason, "the scene is given up");
                return;
            }
        }
    }

    /// Does as it is told; why it can do no more, where the device fails.
    fn obey(&mut self, order: Order) -> Result<(), String> {
        match order {
            Order::Apply(feeder) => {
                self.apply(&feeder, APPLYING).map_err(|error| error.to_string())?;
                // Also where there is no room yet: another order makes more.
                feeder.room.notify_one();
                Ok(())
            }
            // Who has gone meanwhile needs none.
            Order::Frame(.., reply) if reply.is_closed() => Ok(()),
            Order::Frame(feeder, manner, reply) => answer(reply, self.paint(&feeder, manner)),
            Order::Pick(.., reply) if reply.is_closed() => Ok(()),
            Order::Pick(wanted, pixel, reply) => answer(reply, self.pick(&wanted, pixel)),
            Order::Leave(feeder) => {
                self.leave(feeder);
                Ok(())
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
        let visitor = self.visitor(feeder);
        let is_first = visitor.shown.replace(wanted.sequence) != Some(wanted.sequence);
        let hurries = is_first && !manner.patient;
        let settings = if hurries { visitor.budget.settings(base) } else { base };
        let finished = manner.finish == Some(wanted.sequence) && !left && settings == base;
        self.renderer.set_settings(settings);
        // The last frame of a view depends on nothing but that view.
        self.renderer.look_as(feeder.id);
        if finished {
            self.renderer.cut();
        }
        let frame = self.render(&wanted)?;
        let took = began.elapsed();
        if hurries && let Some(visitor) = self.visitors.get_mut(&feeder.id) {
            visitor.budget.observe(took);
            self.timed = Some(visitor.budget.clone());
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
            // It is nobody's: no frame follows it.
            self.renderer.look_as(NOBODY);
            self.renderer.set_settings(self.options.settings);
            self.renderer.cut();
            self.render(wanted)?;
        }
        let picked = self.renderer.pick(pixel)?;
        Ok(picked.map(|picked| Found { picked, nodes: self.renderer.point_nodes().collect() }))
    }

    /// Brings what waits to the device, for about so long.
    fn apply(&mut self, feeder: &Arc<Feeder>, most: Duration) -> Result<(), RenderError> {
        self.visitor(feeder);
        let began = Instant::now();
        while began.elapsed() < most
            && let Some(update) = feeder.pop()
        {
            if let Some(update) = self.residents.give(feeder.id, update) {
                self.current = None;
                let applied = match self.renderer.apply(update) {
                    Ok(applied) => applied,
                    Err(error) if error.is_fatal() => return Err(error),
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
        self.renderer.forget_viewer(feeder);
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

    fn visitor(&mut self, feeder: &Arc<Feeder>) -> &mut Visitor {
        let asked = feeder.wanted().1.budget.unwrap_or(self.options.budget);
        let timed = self.timed.as_ref().filter(|budget| budget.budget() == asked);
        let budget = || timed.map_or_else(|| FrameBudget::new(asked), FrameBudget::afresh);
        let visitor = self.visitors.entry(feeder.id).or_insert_with(|| Visitor {
            feeder: Arc::clone(feeder),
            budget: budget(),
            shown: None,
        });
        if visitor.budget.budget() != asked {
            visitor.budget = budget();
        }
        visitor
    }
}

/// Tells who asked; why that was the last that could be told, if so.
fn answer<T>(
    reply: oneshot::Sender<Result<T, RenderError>>,
    outcome: Result<T, RenderError>,
) -> Result<(), String> {
    let fault = outcome.as_ref().err().filter(|error| error.is_fatal()).map(ToString::to_string);
    // Who asked may have gone meanwhile.
    drop(reply.send(outcome));
    fault.map_or(Ok(()), Err)
}
