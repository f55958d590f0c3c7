//! The walk itself: a visitor in real time.

use std::time::{Duration, Instant};

use flaneur_renderer::{Frame, FrameBudget, Renderer, Settings};
use flaneur_scene::{SceneUpdate, View};
use flaneur_services::ingest::{Progress, Stage, Unit};
use flaneur_streamer::{FetchLimits, Order, Statistics, StreamOptions, ViewRequest};

use super::feed::Feed;
use super::kept::{Kept, Shown};
use super::link::Link;
use super::route::Route;
use crate::commands::Context;
use crate::evaluation::walk::{Part, Profile};
use crate::exit::Exit;

/// How long one stands at the end, at most, for what is still to come.
pub(super) const STAND: Duration = Duration::from_secs(120);
/// A frame waits so long at least for what has arrived to be brought to the device, and half as long as
/// the one before took to draw; the rest comes with the next one.
const APPLYING_MS: f64 = 30.0;
/// What the first frame of a view takes, about, as a render service has it: who moves needs it soon.
/// Those after it are as exact as can be.
pub(super) const BUDGET: Duration = Duration::from_millis(100);
/// How often one looks whether anything is to be done while nothing arrives.
const TICK: Duration = Duration::from_millis(10);
/// What comes on screen goes there smoothly, ever more slowly. A frame that differs from the one before
/// by no more than this anywhere, in 255ths, is taken for what it will be …
const REST_255: u8 = 1;
/// … and so is one after so many without anything new.
const FRAMES_TO_REST: u32 = 60;

/// What a walk left behind.
pub(super) struct Walked {
    pub(super) kept: Kept,
    pub(super) first_picture: Option<Shown>,
    pub(super) first_picture_bytes: Option<u64>,
    pub(super) longest_frame_ms: Option<f64>,
    pub(super) statistics: Statistics,
    /// Whether everything that the last view wants had come.
    pub(super) whole: bool,
    pub(super) profile: Profile,
}

/// Someone who walks.
pub(super) struct Stroll<'a> {
    route: &'a Route,
    limits: FetchLimits,
    renderer: Renderer,
    /// What frames are rendered with that time does not press.
    settings: Settings,
    budget: FrameBudget,
    started: Instant,
    walked: Walked,
    /// The frame on screen.
    on_screen: Option<(Frame, Shown)>,
    /// Whether something has arrived that it does not show.
    news: bool,
    /// How long it took to draw.
    drawing_ms: f64,
    /// Frames that were drawn since anything was new.
    unchanged: u32,
    /// Whether the last frame differed from the one before.
    restless: bool,
}

impl<'a> Stroll<'a> {
    /// Before the first step: time zero is now.
    pub(super) fn new(
        route: &'a Route,
        limits: FetchLimits,
        renderer: Renderer,
        kept: Kept,
    ) -> Self {
        let walked = Walked {
            kept,
            first_picture: None,
            first_picture_bytes: None,
            longest_frame_ms: None,
            statistics: Statistics::default(),
            whole: false,
            profile: Profile::default(),
        };
        let started = Instant::now();
        Self {
            route,
            limits,
            settings: renderer.settings(),
            renderer,
            budget: FrameBudget::new(BUDGET),
            started,
            walked,
            on_screen: None,
            news: false,
            drawing_ms: 0.0,
            unchanged: 0,
            restless: false,
        }
    }

    /// Connects and walks to the end. What was measured until an error is there all the same.
    pub(super) async fn walk(
        &mut self,
        link: &Link,
        order: Order,
        context: &Context,
    ) -> Result<(), Exit> {
        let stage = context.console.stage("walk", 0, Unit::Bytes);
        let connect = async {
            let source = link.throttled().await?;
            self.walked.profile.connected_ms = Some(self.ms());
            let options = StreamOptions { order, ..StreamOptions::default() };
            let streamer = source.streamer_with(options).await?;
            self.walked.profile.scene_ms = Some(self.ms());
            Ok::<_, Exit>(streamer)
        };
        let streamer = tokio::select! {
            () = context.cancel.cancelled() => return Err(Exit::Interrupted),
            streamer = connect => streamer?,
        };
        let mut feed = Feed::new(streamer);
        let outcome = self.follow(&mut feed, &*stage, context).await;
        self.walked.statistics = feed.statistics();
        self.walked.first_picture_bytes = feed.complete_at();
        if let Some((frame, shown)) = self.on_screen.take()
            && self.walked.kept.frames().last() != Some(&shown)
        {
            self.walked.kept.push(&frame, shown)?;
        }
        outcome
    }

    /// What it left behind; the renderer and what it holds are given up.
    pub(super) fn into_walked(self) -> Walked {
        self.walked
    }

    async fn follow(
        &mut self,
        feed: &mut Feed,
        stage: &dyn Stage,
        context: &Context,
    ) -> Result<(), Exit> {
        let (mut looked, mut said) = (None, 0);
        loop {
            if context.cancel.is_cancelled() {
                return Err(Exit::Interrupted);
            }
            let (began, time_s) = (Instant::now(), self.ms() / 1e3);
            let view = self.route.view(time_s);
            let left_s = time_s - self.route.end_s();
            let walks = left_s < 0.0;
            if looked != Some((view, walks)) {
                self.renderer.expect_eye(view.eye());
                feed.look(self.request(view, walks));
                looked = Some((view, walks));
            }
            self.apply(feed, began)?;
            let bytes = feed.statistics().bytes_received;
            stage.advance(bytes.saturating_sub(said));
            said = bytes;
            self.news |= self.on_screen.as_ref().is_none_or(|(_, shown)| shown.view != view);
            let draws = feed.complete_at().is_some() && (self.news || !self.is_at_rest());
            if draws {
                self.draw(view, began, bytes)?;
            }
            let whole = feed.has_all();
            if !walks && whole && self.is_at_rest() || left_s > STAND.as_secs_f64() {
                self.walked.whole = whole;
                return Ok(());
            }
            if draws {
                tokio::task::yield_now().await;
            } else {
                tokio::select! {
                    () = context.cancel.cancelled() => {}
                    update = feed.next() => self.take(feed, update)?,
                    () = tokio::time::sleep(TICK) => {}
                }
            }
        }
    }

    /// Brings what has arrived to the renderer.
    fn apply(&mut self, feed: &mut Feed, began: Instant) -> Result<(), Exit> {
        let most_ms = APPLYING_MS.max(0.5 * self.drawing_ms);
        while began.elapsed().as_secs_f64() * 1e3 < most_ms {
            let Some(update) = feed.try_next() else { break };
            self.take(feed, update)?;
        }
        Ok(())
    }

    fn take(&mut self, feed: &Feed, update: Option<SceneUpdate>) -> Result<(), Exit> {
        let Some(update) = update else { return Ok(()) };
        let came_ms = self.ms();
        let part = Part::of(&update);
        let applied = tokio::task::block_in_place(|| self.renderer.apply(update))?;
        if self.walked.first_picture.is_none() {
            let took_ms = self.ms() - came_ms;
            self.walked.profile.came(part, came_ms, took_ms);
        }
        feed.note(&applied);
        self.news = true;
        Ok(())
    }

    fn draw(&mut self, view: View, began: Instant, bytes: u64) -> Result<(), Exit> {
        let drawn_from_ms = self.ms();
        let before = self.on_screen.as_ref().filter(|(_, before)| before.view == view);
        let hurries = before.is_none();
        let settings = if hurries { self.budget.settings(self.settings) } else { self.settings };
        self.renderer.set_settings(settings);
        let frame = tokio::task::block_in_place(|| self.renderer.render(&view))?;
        let shown = Shown { view, ms: self.ms(), bytes };
        self.drawing_ms = shown.ms - drawn_from_ms;
        if hurries {
            self.budget.observe(Duration::from_secs_f64(self.drawing_ms / 1e3));
        }
        let took_ms = began.elapsed().as_secs_f64() * 1e3;
        let walked = &mut self.walked;
        walked.longest_frame_ms = Some(walked.longest_frame_ms.unwrap_or(0.0).max(took_ms));
        if walked.first_picture.is_none() {
            walked.first_picture = Some(shown);
            walked.profile.drawn(&frame.stats, drawn_from_ms);
            tracing::info!(ms = shown.ms, bytes, "first picture");
        }
        if walked.kept.is_due(shown.ms) {
            walked.kept.push(&frame, shown)?;
        }
        let before = self.on_screen.as_ref().filter(|(_, before)| before.view == view);
        self.restless = before.is_none_or(|(before, _)| !is_like(before, &frame));
        self.unchanged = if std::mem::take(&mut self.news) { 0 } else { self.unchanged + 1 };
        self.on_screen = Some((frame, shown));
        Ok(())
    }

    /// Whether another frame of the same would be the same.
    fn is_at_rest(&self) -> bool {
        self.on_screen.is_some() && (!self.restless || self.unchanged >= FRAMES_TO_REST)
    }

    /// What someone wants who sees `view`. Who walks keeps what is there while it may serve; in the
    /// end the view alone decides.
    fn request(&self, view: View, walks: bool) -> ViewRequest {
        let steadiness = if walks { ViewRequest::STEADY } else { 1.0 };
        ViewRequest { limits: self.limits, steadiness, ..ViewRequest::new(view) }
    }

    /// Since time zero, milliseconds.
    fn ms(&self) -> f64 {
        self.started.elapsed().as_secs_f64() * 1e3
    }
}

fn is_like(before: &Frame, frame: &Frame) -> bool {
    before.rgba.iter().zip(&frame.rgba).all(|(a, b)| a.abs_diff(*b) <= REST_255)
}
