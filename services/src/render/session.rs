//! One client's walk: views come, frames go.
//!
//! The first frame of a view is made at once, of what is there and within the frame budget; further
//! ones as data arrive, as exact as can be; and the last once everything is there. A frame is begun
//! only when the connection has room for it, so that none is old when it leaves.

use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_streamer::{Event, Progress, Streamer, ViewRequest};
use tokio::sync::mpsc;
use tokio::time::Instant;
use tonic::Status;

use super::inputs::{Heard, Inputs};
use super::pace::{Pace, Until};
use super::picture::{self, Encoded};
use super::scenes::{OpenScene, Visit};
use super::stage::Manner;
use super::{RenderOptions, refuse};

/// How long the very first frame waits for a complete picture.
const PATIENCE: Duration = Duration::from_secs(2);

/// The frames of a session; an error is the last of them.
pub(super) type Frames = mpsc::Sender<Result<v1::Frame, Status>>;

/// A frame that was handed to the connection.
struct Shown {
    sequence: u64,
    finished: bool,
    left: bool,
    at: Instant,
}

type Painting = Pin<Box<dyn Future<Output = Result<Shown, Status>> + Send>>;

/// Follows `inputs` until `frames` is closed, or the client has said that it says no more and has the
/// final frame.
///
/// # Errors
/// Where a frame cannot be made, or the client has said nothing for too long.
pub(super) async fn run(
    scene: Arc<OpenScene>,
    inputs: Arc<Inputs>,
    options: Arc<RenderOptions>,
    frames: Frames,
) -> Result<(), Status> {
    let session = Session::new(scene, inputs, options, frames.clone());
    tokio::select! {
        () = frames.closed() => Ok(()),
        outcome = session.follow() => outcome,
    }
}

struct Session {
    inputs: Arc<Inputs>,
    options: Arc<RenderOptions>,
    frames: Frames,
    visit: Visit,
    streamer: Streamer,
    pace: Pace,
    /// What is being looked at: the client's number of the view, and the streamer's.
    looked: Option<(u64, u64)>,
    /// Of that view.
    progress: Progress,
    fault: String,
    /// Whether something has come that the last frame does not show.
    news: bool,
    shown: Option<Shown>,
    /// Frames so far.
    number: u64,
    began: Instant,
    /// The client says no more, and so acknowledges nothing.
    closed: bool,
}

impl Session {
    fn new(
        scene: Arc<OpenScene>,
        inputs: Arc<Inputs>,
        options: Arc<RenderOptions>,
        frames: Frames,
    ) -> Self {
        let heard = inputs.heard();
        let streamer = scene.streamer.beside();
        Self {
            inputs,
            options,
            frames,
            visit: Visit::new(scene, heard.wanted, heard.wish),
            streamer,
            pace: Pace::new(),
            looked: None,
            progress: Progress::default(),
            fault: String::new(),
            news: false,
            shown: None,
            number: 0,
            began: Instant::now(),
            closed: false,
        }
    }

    async fn follow(mut self) -> Result<(), Status> {
        let mut painting: Option<Painting> = None;
        let mut applying = false;
        loop {
            let heard = self.listen();
            if heard.closed && self.is_final() {
                return Ok(());
            }
            let mut wake = heard.at + self.options.idle;
            if Instant::now() >= wake {
                let seconds = self.options.idle.as_secs();
                let message = format!("nothing was heard for {seconds} s: the session has ended");
                return Err(Status::deadline_exceeded(message));
            }
            if painting.is_none() {
                match self.due() {
                    Due::Now => painting = Some(self.paint()),
                    Due::At(at) => wake = wake.min(at),
                    Due::NotYet => {}
                }
            }
            let has_room = self.visit.feeder.has_room();
            if !has_room && painting.is_none() && !applying {
                self.visit.stage().apply(&self.visit.feeder);
                applying = true;
            }
            tokio::select! {
                () = self.inputs.changed.notified() => {}
                () = self.visit.feeder.room.notified() => applying = false,
                event = self.streamer.next(), if has_room => self.take(event),
                Some(note) = self.visit.notes.recv() => note.tell(&self.streamer),
                shown = async { painting.as_mut().expect("there is one").await }, if painting.is_some() => {
                    painting = None;
                    self.take_shown(shown?);
                }
                () = tokio::time::sleep_until(wake) => {}
            }
        }
    }

    /// Takes note of what the client has said.
    fn listen(&mut self) -> Heard {
        let heard = self.inputs.heard();
        self.pace.received(heard.received, Instant::now());
        self.closed = heard.closed;
        let sequence = heard.wanted.sequence;
        if self.looked.is_none_or(|(looked, _)| looked != sequence) {
            let request = ViewRequest {
                limits: self.options.limits,
                ..ViewRequest::walking(heard.wanted.view)
            };
            self.looked = Some((sequence, self.streamer.look(request)));
            self.progress = Progress::default();
            self.fault.clear();
        }
        self.visit.feeder.want(heard.wanted.clone(), heard.wish);
        heard
    }

    /// Whether the client has the best frame of what it wants.
    fn is_final(&self) -> bool {
        let looked = self.looked.map(|(sequence, _)| sequence);
        self.shown.as_ref().is_some_and(|shown| shown.finished && Some(shown.sequence) == looked)
    }

    fn take(&mut self, event: Event) {
        let view = self.looked.map(|(_, view)| view);
        match event {
            Event::Update(update) => {
                self.visit.feeder.push(update);
                self.news = true;
            }
            Event::Progress(progress) if Some(progress.view) == view => self.progress = progress,
            Event::Fault { view: of, error } if Some(of) == view => {
                tracing::warn!(%error, "the picture is made without");
                self.fault = error.to_string();
            }
            Event::Progress(_) | Event::Fault { .. } => {}
        }
    }

    fn take_shown(&mut self, shown: Shown) {
        self.pace.sent(self.number, shown.at);
        self.news |= shown.left;
        self.shown = Some(shown);
    }

    /// Whether a frame is to be made.
    fn due(&self) -> Due {
        let Some((sequence, _)) = self.looked else { return Due::NotYet };
        let complete = self.progress.complete_picture || self.progress.finished;
        let wants = match &self.shown {
            None if !complete => {
                let at = self.began + PATIENCE;
                if Instant::now() < at {
                    return Due::At(at);
                }
                true
            }
            None => true,
            Some(shown) if shown.sequence != sequence => true,
            Some(shown) => !shown.finished && (self.progress.finished || self.news),
        };
        let wait = self.pace.wait(Instant::now()).filter(|_| !self.closed);
        match (wants, wait) {
            (false, _) | (true, Some(Until::Acknowledged)) => Due::NotYet,
            (true, Some(Until::At(at))) => Due::At(at),
            (true, None) => Due::Now,
        }
    }

    /// Has a frame made and sent.
    fn paint(&mut self) -> Painting {
        self.number += 1;
        self.news = false;
        let looked = self.looked.map(|(sequence, _)| sequence);
        let finish = looked.filter(|_| self.progress.finished);
        let manner = Manner { finish, patient: false };
        let (number, progress, fault) = (self.number, self.progress, self.fault.clone());
        // Not that of the progress, which begins anew with each view.
        let bytes_received = self.streamer.statistics().bytes_received;
        let (stage, feeder) = (self.visit.stage().clone(), Arc::clone(&self.visit.feeder));
        let frames = self.frames.clone();
        let quality = self.pace.quality();
        Box::pin(async move {
            // The client has gone where there will be none.
            let permit = frames.reserve_owned().await;
            let permit = permit.map_err(|_| Status::cancelled("the client has gone"))?;
            let painted = stage.frame(&feeder, manner).await.map_err(|e| refuse::of_render(&e))?;
            let (sequence, finished, left) =
                (painted.wanted.sequence, painted.finished, painted.left);
            let Encoded { mut message, since } = picture::encoded(painted, quality).await?;
            message.complete = finished;
            // What is known of the stream is of the view that was being looked at.
            if looked == Some(sequence) {
                message.complete |= progress.complete_picture || progress.finished;
                message.remaining = progress.remaining;
                message.fault = fault;
            }
            message.number = number;
            message.bytes_received = bytes_received;
            message.latency_ms = since.elapsed().as_secs_f64() * 1e3;
            permit.send(Ok(message));
            Ok(Shown { sequence, finished, left, at: Instant::now() })
        })
    }
}

/// When a frame is to be made.
enum Due {
    Now,
    At(Instant),
    NotYet,
}
