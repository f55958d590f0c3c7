//! The window: what people do to it, in; pictures, out.

mod astray;
mod clicks;
mod controls;
mod figures;
mod help;
mod keys;
mod layers;
mod lead;
mod panels;
mod photograph;
mod photographs;
mod picture;
mod pointer;
mod ruler;
mod screen;
mod tape;

use std::sync::Arc;
use std::time::{Duration, Instant};

use flaneur_renderer::Mode;
use flaneur_scene::{Bounds3, Panorama};
use flaneur_services::place::{Found, Record, StoredSight, look_up};
use flaneur_services::shares::Shares;
use flaneur_streamer::{StreamOptions, Streamer};
use glam::{DVec2, DVec3, UVec2};
use tokio_util::sync::CancellationToken;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use super::astray::is_astray;
use super::buildings::Buildings;
use super::opened::Opened;
use super::painter::{News, Order, Painter, Shown, Wish};
use super::photograph::{Photograph, develop};
use super::pose::Pose;
use super::surroundings::{SURROUNDINGS_M, Surroundings};
use super::visitor::Visitor;
use crate::exit::Exit;
use crate::source::stream_exit;
use figures::Facts;
use lead::Lead;
use panels::PanelState;
use photograph::PhotographWindow;
use pointer::Pointer;
use screen::Screen;
use tape::Reference;

/// While something moves the window is drawn so often.
const PACE: Duration = Duration::from_millis(16);
/// Who has not moved for so long stands.
const REST: Duration = Duration::from_millis(150);
/// Least sides of the window, pixels.
const SMALLEST: PhysicalSize<u32> = PhysicalSize::new(160, 120);

/// What is told to the window.
pub(super) enum Told {
    /// By the painter.
    Painter(News),
    /// The photograph nearest to where one stands, or clicked twice.
    Photograph(Result<Option<(Panorama, DVec3)>, Exit>),
    /// What is stored of a measured place, by its number.
    Stored(usize, Result<Record, Exit>),
    /// A photograph to be seen, by the number of the question.
    Developed(u64, Result<Box<Photograph>, Exit>),
    /// The houses around, by the number of the question; `None` where they could not be had.
    Surroundings(u64, Option<Buildings>),
    /// A scene was dropped onto it and opened.
    Opened(Result<Box<Opened>, Exit>),
    /// The program is to end.
    Cancelled,
}

/// What a window shows.
pub(super) struct Scene {
    /// It looks at nothing itself: for what is asked beside the painter's.
    pub(super) streamer: Arc<Streamer>,
    pub(super) name: String,
    pub(super) bounds: Bounds3,
    /// Where one is led back to.
    pub(super) home: Pose,
    pub(super) reference: Reference,
}

/// A window on a scene.
pub(super) struct App {
    pub(super) visitor: Visitor,
    pub(super) painter: Painter,
    pub(super) surroundings: Surroundings,
    pub(super) scene: Scene,
    pub(super) mode: Mode,
    /// Of the window at first, pixels.
    pub(super) size: UVec2,
    pub(super) adapter: String,
    pub(super) proxy: EventLoopProxy<Told>,
    /// For scenes that are dropped onto the window.
    pub(super) stream_options: StreamOptions,
    pub(super) open: Option<Open>,
    /// Photographs that were asked for.
    pub(super) photographs: u64,
    /// Why it ended, where that is not because someone closed it.
    pub(super) exit: Option<Exit>,
}

/// The window once it is there.
pub(super) struct Open {
    window: Arc<Window>,
    screen: Screen,
    panels: PanelState,
    pointer: Pointer,
    modifiers: ModifiersState,
    lead: Lead,
    shown: Option<Box<Shown>>,
    /// Whether it was said that no server can be reached.
    cut_off: bool,
    moved_at: Instant,
    /// Whether the painter was told that one stands.
    rests: bool,
    /// What the window was drawn for the last time, and when.
    drawn: Option<Pose>,
    drawn_at: Instant,
    drawing: Duration,
    /// Whether it is to be drawn again at the next beat.
    moves: bool,
    /// When its panels are, if they are to be by themselves.
    again_at: Option<Instant>,
}

/// An event loop for a window.
///
/// # Errors
/// Where there is no display.
pub(super) fn event_loop() -> Result<EventLoop<Told>, Exit> {
    EventLoop::with_user_event().build().map_err(|error| {
        // It names source files of the machine that this was built on.
        tracing::debug!(%error, "no display");
        Exit::Failed(anyhow::anyhow!(
            "cannot open a window: no display answers; log in to a desktop, or set DISPLAY or \
             WAYLAND_DISPLAY, or use `flaneur render` for pictures in files"
        ))
    })
}

/// Shows the window until it is closed, or `cancel`.
pub(super) fn run(
    event_loop: EventLoop<Told>,
    mut app: App,
    cancel: CancellationToken,
) -> Result<(), Exit> {
    let proxy = app.proxy.clone();
    let watch = tokio::spawn(async move {
        cancel.cancelled().await;
        drop(proxy.send_event(Told::Cancelled));
    });
    let outcome = event_loop.run_app(&mut app);
    watch.abort();
    if let Some(exit) = app.exit.take() {
        return Err(exit);
    }
    outcome.map_err(Exit::failed)
}

impl ApplicationHandler<Told> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match open(event_loop, &self.scene.name, self.size) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.end(event_loop, Exit::Failed(error.context("cannot open a window"))),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        open.panels.notice(&open.window, &event);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw(event_loop) {
                    self.end(event_loop, Exit::Failed(error.context("cannot draw the window")));
                }
            }
            WindowEvent::Resized(_) => {
                open.screen.resize();
                open.wake();
            }
            event => self.control(&event),
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, told: Told) {
        match told {
            Told::Painter(News::Failed(exit)) => self.end(event_loop, exit),
            Told::Cancelled => self.end(event_loop, Exit::Interrupted),
            Told::Painter(News::Frame(shown)) => self.show(shown),
            Told::Painter(News::Fault(fault)) => self.say(fault),
            Told::Painter(News::Picked(click, found)) => {
                self.picked(&click, found.map(|found| *found));
            }
            Told::Photograph(Ok(Some((_, centre)))) => {
                self.visitor.go(self.visitor.pose().at(centre), Instant::now());
            }
            Told::Stored(number, stored) => self.learn(number, stored),
            Told::Developed(number, developed) => self.develop(number, developed),
            Told::Photograph(Ok(None)) => self.say("no photograph is near".to_owned()),
            Told::Surroundings(question, found) => {
                self.surroundings.take(question, found, Instant::now());
            }
            Told::Opened(Ok(opened)) => self.go_over(*opened),
            Told::Photograph(Err(exit)) => {
                self.say(format!("the nearest photograph cannot be had: {}", exit.message()));
            }
            Told::Opened(Err(exit)) => self.say(exit.message()),
        }
        if let Some(open) = &mut self.open {
            open.wake();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &self.open else { return };
        let beat = open.moves.then_some(open.drawn_at + PACE);
        // Once more, to say that the view stands.
        let stand = (!open.rests).then_some(open.moved_at + REST);
        let Some(next) = [beat, stand, open.again_at].into_iter().flatten().min() else {
            return event_loop.set_control_flow(ControlFlow::Wait);
        };
        if Instant::now() >= next {
            open.window.request_redraw();
            event_loop.set_control_flow(ControlFlow::Wait);
        } else {
            event_loop.set_control_flow(ControlFlow::WaitUntil(next));
        }
    }
}

impl App {
    fn end(&mut self, event_loop: &ActiveEventLoop, exit: Exit) {
        self.exit.get_or_insert(exit);
        event_loop.exit();
    }

    /// Lets time pass, and draws what is then to be seen.
    fn draw(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let now = Instant::now();
        let walls = self.surroundings.buildings();
        let walks = self.visitor.advance(now, &self.painter.ground(), walls);
        let pose = self.visitor.pose();
        if let Some(question) = self.surroundings.ask(pose.eye.truncate(), now) {
            self.scene.ask_around(pose.eye.truncate(), question, &self.proxy);
        }
        // What came and went between two beats counts, too.
        let moved = walks || open.pointer.drags() || open.drawn != Some(pose);
        if moved {
            open.moved_at = now;
        }
        open.drawn = Some(pose);
        open.lead.note(&pose, now);
        let size = open.screen.size();
        let view = pose.view(size);
        let rests = now.saturating_duration_since(open.moved_at) >= REST;
        if rests && !open.rests {
            // As --view takes it.
            tracing::debug!(view = %pose, "stands");
        }
        open.rests = rests;
        // The pictures of where one is going are asked for at once.
        let wished = match self.visitor.destination() {
            Some(end) => end.view(size),
            None if rests => view,
            None => open.lead.view(&pose, size),
        };
        self.painter.wish(Wish { view: wished, mode: self.mode, moving: !rests });
        let cut_off = self.scene.streamer.client().is_cut_off();
        match (std::mem::replace(&mut open.cut_off, cut_off), cut_off) {
            (false, true) => tracing::warn!("the server cannot be reached"),
            (true, false) => tracing::info!("the server answers again"),
            (false, false) | (true, true) => {}
        }
        let facts = Facts {
            pose: &pose,
            view: &view,
            mode: self.mode,
            shown: open.shown.as_deref(),
            drawing: open.drawing,
            scene: &self.scene.name,
            reference: &self.scene.reference,
            adapter: &self.adapter,
            cut_off: open.cut_off,
        };
        let (panels, again) = open.panels.lay_out(&open.window, event_loop, &facts);
        open.screen.draw(&view, panels)?;
        let chosen = open.panels.measuring.take_chosen();
        let destination = open.panels.destination.take();
        let leads_back = std::mem::take(&mut open.panels.leads_back);
        open.moves = moved;
        open.again_at = again.map(|delay| now + delay.max(PACE));
        open.drawn_at = now;
        open.drawing = now.elapsed();
        if let Some(chosen) = chosen {
            self.photographs += 1;
            let room = PhotographWindow::room(&open.screen);
            self.scene.develop(self.photographs, chosen.sight.clone(), room, &self.proxy);
            open.panels.photograph = Some(PhotographWindow::new(self.photographs, chosen));
            open.wake();
        }
        if let Some([taken_at, place]) = destination {
            self.visitor.go(self.visitor.pose().at(taken_at).facing(place), Instant::now());
            open.wake();
        }
        if leads_back {
            self.lead_back();
        }
        Ok(())
    }

    /// A photograph that was chosen is there, or is not to be had.
    fn develop(&mut self, number: u64, developed: Result<Box<Photograph>, Exit>) {
        if let Ok(photograph) = &developed {
            let [width, height] = photograph.image.dimensions().into();
            tracing::debug!(width, height, "developed");
        }
        if let Some(open) = &mut self.open {
            open.panels.take_photograph(number, developed.map(|photograph| *photograph));
        }
    }

    /// Nothing of the scene is in sight, and someone wants to be where there is.
    fn lead_back(&mut self) {
        self.visitor.go(self.scene.home, Instant::now());
        if let Some(open) = &mut self.open {
            open.wake();
        }
    }

    fn show(&mut self, mut shown: Box<Shown>) {
        let Some(open) = &mut self.open else { return };
        let astray = is_astray(Shares::of(&shown.stats), &shown.view, &self.scene.bounds);
        // What is still loading may come into sight; what is there already has.
        if shown.is_final || !astray {
            open.panels.is_astray = astray;
        }
        if !shown.is_final {
            open.lead.took(shown.took);
        }
        open.screen.show(&shown);
        shown.rgba = Vec::new();
        open.shown = Some(shown);
    }

    /// Says what went wrong; the log has it, too.
    fn say(&mut self, what: String) {
        tracing::warn!("{what}");
        if let Some(open) = &mut self.open {
            open.panels.say(what);
        }
    }

    /// Someone drops a file or folder onto the window.
    fn open_dropped(&self, path: &std::path::Path) {
        let (text, proxy) = (path.to_string_lossy().into_owned(), self.proxy.clone());
        let (options, fov_y) = (self.stream_options.clone(), self.visitor.pose().fov_y);
        tokio::spawn(async move {
            let opened = Opened::open(&text, options, fov_y).await;
            drop(proxy.send_event(Told::Opened(opened.map(Box::new))));
        });
    }

    fn go_over(&mut self, opened: Opened) {
        self.scene = Scene::of(&opened);
        self.surroundings.clear();
        self.visitor = Visitor::new(opened.start, Instant::now());
        self.painter.order(Order::Open(Box::new(opened)));
        if let Some(open) = &mut self.open {
            open.screen.clear();
            open.window.set_title(&title(&self.scene.name));
            open.panels.measuring.close();
            open.panels.photograph = None;
            open.panels.is_astray = false;
            open.panels.clear_message();
            open.shown = None;
        }
    }
}

impl Scene {
    /// That of a streamer.
    pub(super) fn of(opened: &Opened) -> Self {
        let info = opened.streamer.info();
        let streamer = Arc::new(opened.streamer.beside());
        Self {
            streamer,
            name: info.name.clone(),
            bounds: info.bounds,
            home: opened.start,
            reference: Reference::of(info),
        }
    }

    /// Asks what is stored of the place that was marked as `number`.
    fn look_up(&self, number: usize, found: Found, proxy: &EventLoopProxy<Told>) {
        let (streamer, proxy) = (Arc::clone(&self.streamer), proxy.clone());
        tokio::spawn(async move {
            let stored = look_up(&streamer, &found, usize::MAX).await.map_err(stream_exit);
            drop(proxy.send_event(Told::Stored(number, stored)));
        });
    }

    /// Asks for a photograph that fits into `room` pixels.
    fn develop(&self, number: u64, sight: StoredSight, room: UVec2, proxy: &EventLoopProxy<Told>) {
        let (streamer, proxy) = (Arc::clone(&self.streamer), proxy.clone());
        tokio::spawn(async move {
            let developed = develop(&streamer, &sight, room).await.map(Box::new);
            drop(proxy.send_event(Told::Developed(number, developed)));
        });
    }

    /// Asks for the houses around a place.
    fn ask_around(&self, place: DVec2, question: u64, proxy: &EventLoopProxy<Told>) {
        let (client, proxy) = (self.streamer.client().clone(), proxy.clone());
        tokio::spawn(async move {
            let found = Buildings::around(&client, place, SURROUNDINGS_M).await;
            if let Err(error) = &found {
                tracing::warn!("one walks through houses: {}", error.message());
            }
            drop(proxy.send_event(Told::Surroundings(question, found.ok())));
        });
    }
}

impl Open {
    /// Draws it soon.
    fn wake(&mut self) {
        self.moves = true;
    }
}

fn open(event_loop: &ActiveEventLoop, scene: &str, size: UVec2) -> anyhow::Result<Open> {
    let attributes = Window::default_attributes()
        .with_title(title(scene))
        .with_inner_size(PhysicalSize::new(size.x, size.y))
        .with_min_inner_size(SMALLEST);
    let window = Arc::new(event_loop.create_window(attributes)?);
    let screen = Screen::new(Arc::clone(&window), event_loop.owned_display_handle())?;
    let panels = PanelState::new(&window, screen.max_side());
    let now = Instant::now();
    Ok(Open {
        window,
        screen,
        panels,
        pointer: Pointer::default(),
        modifiers: ModifiersState::empty(),
        lead: Lead::new(),
        shown: None,
        cut_off: false,
        moved_at: now.checked_sub(REST).unwrap_or(now),
        rests: false,
        drawn: None,
        drawn_at: now,
        drawing: Duration::ZERO,
        moves: true,
        again_at: None,
    })
}

fn title(scene: &str) -> String {
    format!("{scene} - Flaneur")
}
