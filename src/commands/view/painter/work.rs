//! The painter's thread: streams, draws, answers.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use flaneur_renderer::{FrameBudget, Gpu, Mode, RenderError, Renderer, Settings};
use flaneur_scene::SceneUpdate;
use flaneur_services::place::Found;
use flaneur_streamer::{Event, Streamer, ViewRequest};
use tokio::sync::{mpsc, watch};

use super::feed::{Brought, Feed};
use super::{Click, News, Order, PaintOptions, Shown, Wish};
use crate::commands::view::ground::Ground;
use crate::exit::Exit;

/// A frame waits so long at least for what has arrived to be brought to the device, and half as long
/// as the one before took to draw; the rest comes with the next one.
const APPLYING: Duration = Duration::from_millis(20);
/// Who comes to stand sees a frame with all settings after so long at the latest; sooner where
/// everything is there by then, and the frame is the final one.
const SETTLING: Duration = Duration::from_millis(300);

/// Frames are drawn for nobody once there is nothing else to do, as if one moved, until the budget knows
/// what this machine can do, or so many were. Else whoever moves first would wait for that, and for the
/// driver to compile what it takes.
const MOST_REHEARSALS: u32 = 16;

/// A renderer, what feeds it, and what was drawn last.
pub(super) struct Work {
    gpu: Gpu,
    options: PaintOptions,
    renderer: Renderer,
    budget: FrameBudget,
    feed: Feed,
    ground: Arc<Mutex<Ground>>,
    wish: Option<Wish>,
    /// Since when that is of someone who stands.
    stands_since: Instant,
    /// Whether something has arrived that the last frame does not show.
    news: bool,
    /// What the last frame shows, and whether it is the final one of its view.
    drawn: Option<(Wish, bool)>,
    /// How long it took.
    drawing: Duration,
    /// Frames that were drawn for nobody, and whether the last of all was one.
    rehearsed: u32,
    rehearses: bool,
}

impl Work {
    pub(super) fn new(
        gpu: Gpu,
        streamer: Streamer,
        options: PaintOptions,
        ground: Arc<Mutex<Ground>>,
    ) -> Self {
        let renderer = Renderer::with_settings(&gpu, options.settings);
        Self {
            gpu,
            options,
            renderer,
            budget: FrameBudget::new(options.budget),
            feed: Feed::new(streamer),
            ground,
            wish: None,
            stands_since: Instant::now(),
            news: false,
            drawn: None,
            drawing: Duration::ZERO,
            rehearsed: 0,
            rehearses: false,
        }
    }

    /// Works until nobody wishes for anything any more.
    pub(super) async fn run(
        &mut self,
        mut wishes: watch::Receiver<Option<Wish>>,
        mut orders: mpsc::UnboundedReceiver<Order>,
        tell: &impl Fn(News),
    ) -> Result<(), Exit> {
        loop {
            // Orders first: a wish may be for the scene that the last one opens.
            while let Ok(order) = orders.try_recv() {
                self.obey(order, tell)?;
            }
            let wish = *wishes.borrow_and_update();
            self.look(wish);
            self.bring(tell)?;
            if self.is_due() {
                self.draw(tell)?;
                // Others on this runtime have their turn; a closed window is noticed.
                tokio::task::yield_now().await;
                if wishes.has_changed().is_err() {
                    return Ok(());
                }
                continue;
            }
            if self.has_leisure() {
                self.rehearse(tell)?;
                tokio::task::yield_now().await;
                continue;
            }
            let (coarse, settled) = (self.is_coarse(), self.settled_at().into());
            tokio::select! {
                changed = wishes.changed() => if changed.is_err() {
                    return Ok(());
                },
                order = orders.recv() => match order {
                    Some(order) => self.obey(order, tell)?,
                    None => return Ok(()),
                },
                event = self.feed.streamer.next() => self.take(event, tell)?,
                () = tokio::time::sleep_until(settled), if coarse => {}
            }
        }
    }

    /// Asks for what the wish needs.
    fn look(&mut self, wish: Option<Wish>) {
        let before = std::mem::replace(&mut self.wish, wish);
        let Some(wish) = wish.filter(|_| wish != before) else { return };
        self.renderer.expect_eye(wish.view.eye());
        self.stands_since = Instant::now();
        let same = |before: Wish| (before.view, before.moving) == (wish.view, wish.moving);
        if before.is_some_and(same) {
            return;
        }
        // Who walks keeps what is there while it may serve, and looks ahead; in the end the view
        // alone decides.
        let of = if wish.moving { ViewRequest::walking } else { ViewRequest::new };
        self.feed.look(ViewRequest { limits: self.options.limits, ..of(wish.view) });
    }

    fn obey(&mut self, order: Order, tell: &impl Fn(News)) -> Result<(), Exit> {
        match order {
            Order::Pick(click) => {
                let found = self.pick(&click)?;
                tell(News::Picked(click, found.map(Box::new)));
            }
            Order::Open(opened) => {
                self.renderer = Renderer::with_settings(&self.gpu, self.options.settings);
                self.feed = Feed::new(opened.streamer);
                *self.ground.lock().unwrap_or_else(PoisonError::into_inner) = Ground::default();
                (self.wish, self.drawn, self.news) = (None, None, false);
            }
        }
        Ok(())
    }

    /// Brings what has arrived to the renderer.
    fn bring(&mut self, tell: &impl Fn(News)) -> Result<(), Exit> {
        let (began, most) = (Instant::now(), APPLYING.max(self.drawing / 2));
        while began.elapsed() < most {
            let Some(event) = self.feed.streamer.try_next() else { break };
            self.take(event, tell)?;
        }
        Ok(())
    }

    fn take(&mut self, event: Event, tell: &impl Fn(News)) -> Result<(), Exit> {
        let all_before = self.feed.has_all;
        match self.feed.take(event) {
            Brought::Update(update) => self.apply(&update, tell)?,
            Brought::Fault(error) => tell(News::Fault(Exit::failed(error).message())),
            Brought::Nothing => self.news |= self.feed.has_all && !all_before,
        }
        Ok(())
    }

    fn apply(&mut self, update: &SceneUpdate, tell: &impl Fn(News)) -> Result<(), Exit> {
        let applied = match self.renderer.apply(update.clone()) {
            Ok(applied) => applied,
            Err(error) => return survive(error, tell),
        };
        self.feed.note(&applied);
        if !applied.refused {
            self.ground.lock().unwrap_or_else(PoisonError::into_inner).note(update);
        }
        self.news = true;
        Ok(())
    }

    /// Whether one stands before a frame of when one moved.
    fn is_coarse(&self) -> bool {
        let stands = self.wish.is_some_and(|wish| !wish.moving);
        stands && self.drawn.is_some_and(|(drawn, _)| drawn.moving)
    }

    /// When that is no longer to be borne.
    fn settled_at(&self) -> Instant {
        self.stands_since + SETTLING
    }

    /// Whether another frame would be a better one.
    fn is_due(&self) -> bool {
        let Some(wish) = self.wish else { return false };
        match self.drawn {
            None => self.news || self.feed.has_all,
            Some((drawn, is_final)) => {
                drawn.view != wish.view
                    || drawn.mode != wish.mode
                    || self.news
                    || self.is_coarse() && Instant::now() >= self.settled_at()
                    || !wish.moving && !is_final && self.feed.has_all
            }
        }
    }

    /// Whether the final frame is drawn, and there is something to rehearse.
    fn has_leisure(&self) -> bool {
        let unsure = self.rehearsed < MOST_REHEARSALS && !self.budget.is_settled();
        unsure && self.drawn.is_some_and(|(_, is_final)| is_final)
    }

    /// Draws as if one moved, for nobody.
    fn rehearse(&mut self, tell: &impl Fn(News)) -> Result<(), Exit> {
        let Some((wish, _)) = self.drawn else { return Ok(()) };
        self.rehearsed += 1;
        self.rehearses = true;
        let base = FrameBudget::most_exact(self.options.settings);
        self.renderer.set_settings(self.budget.settings(base));
        let began = Instant::now();
        if let Err(error) = self.renderer.render_as(&wish.view, wish.mode) {
            return survive(error, tell);
        }
        self.budget.observe(began.elapsed());
        Ok(())
    }

    /// Draws what is there: as fine as time allows while the view moves, else as it can be.
    fn draw(&mut self, tell: &impl Fn(News)) -> Result<(), Exit> {
        let Some(wish) = self.wish else { return Ok(()) };
        let is_final = !wish.moving && self.feed.has_all;
        if wish.moving {
            let base = FrameBudget::most_exact(self.options.settings);
            self.renderer.set_settings(self.budget.settings(base));
        } else {
            self.renderer.set_settings(self.options.settings);
        }
        if is_final {
            self.renderer.cut();
        }
        let began = Instant::now();
        let drawn = self.renderer.render_as(&wish.view, wish.mode);
        (self.news, self.rehearses) = (false, false);
        self.drawn = Some((wish, is_final));
        let frame = match drawn {
            Ok(frame) => frame,
            Err(error) => return survive(error, tell),
        };
        self.drawing = began.elapsed();
        if wish.moving {
            self.budget.observe(self.drawing);
        }
        tell(News::Frame(Box::new(Shown {
            view: wish.view,
            mode: wish.mode,
            size: frame.size,
            rgba: frame.rgba,
            stats: frame.stats,
            took: self.drawing,
            is_final,
            budget: self.budget.standing().filter(|_| wish.moving),
            streamed: self.feed.streamer.statistics(),
            remaining: self.feed.remaining,
        })));
        Ok(())
    }

    /// What a click met.
    fn pick(&mut self, click: &Click) -> Result<Option<Found>, Exit> {
        let shows = |(drawn, _): (Wish, bool)| drawn.view == click.view;
        if self.rehearses || !self.drawn.is_some_and(shows) {
            let settings = self.options.settings;
            self.renderer.set_settings(Settings { infer: false, align: false, ..settings });
            self.renderer.render_as(&click.view, Mode::Depth)?;
            self.renderer.set_settings(settings);
            self.drawn = self.drawn.filter(|drawn| shows(*drawn));
            self.rehearses = false;
        }
        let picked = self.renderer.pick(click.pixel)?;
        Ok(picked.map(|picked| Found { picked, nodes: self.renderer.point_nodes().collect() }))
    }
}

/// Says what could not be brought or drawn, where that is no reason to stop.
fn survive(error: RenderError, tell: &impl Fn(News)) -> Result<(), Exit> {
    if error.is_fatal() {
        return Err(Exit::failed(error));
    }
    tell(News::Fault(Exit::failed(error).message()));
    Ok(())
}
