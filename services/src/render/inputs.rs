//! What a client says in the course of a session. Only the latest counts.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use flaneur_proto::{FieldError, v1};
use tokio::sync::Notify;
use tokio::time::Instant;
use tonic::Status;

use super::wanted::{Wanted, Wish};
use super::{RenderOptions, refuse};
use crate::grpc::status;

/// What was said last, shared by whoever hears it and the session that follows it.
#[derive(Debug)]
pub(super) struct Inputs {
    scene: String,
    options: Arc<RenderOptions>,
    heard: Mutex<Heard>,
    /// Told at every change.
    pub(super) changed: Notify,
}

/// What was said last.
#[derive(Clone, Debug)]
pub(super) struct Heard {
    pub(super) wanted: Wanted,
    pub(super) wish: Wish,
    /// Number of the last frame that was received.
    pub(super) received: u64,
    pub(super) at: Instant,
    /// Nothing more will be.
    pub(super) closed: bool,
    allowance: Allowance,
}

/// Views that may still come at once.
#[derive(Clone, Copy, Debug)]
struct Allowance {
    views: f64,
    at: Instant,
}

/// Why an update was not taken.
#[derive(Debug)]
pub(super) enum Refusal {
    /// It must not be sent again.
    Bad(FieldError),
    /// After a while it may.
    TooFast(Duration),
}

impl Inputs {
    /// Those of the session that begins with `update`.
    pub(super) fn begin(
        update: v1::ViewUpdate,
        options: &Arc<RenderOptions>,
    ) -> Result<Self, FieldError> {
        let view = update.view.ok_or_else(|| FieldError::new("view", "is absent"))?;
        let wanted = Wanted::new(update.sequence, view, options)?;
        let wish = wish(update.quality.as_ref())?;
        let at = wanted.since;
        let allowance = Allowance { views: f64::from(options.views_per_s), at };
        let heard = Heard { wanted, wish, received: 0, at, closed: false, allowance };
        Ok(Self {
            scene: update.scene,
            options: Arc::clone(options),
            heard: Mutex::new(heard),
            changed: Notify::new(),
        })
    }

    /// Takes a further update. One that is older than the last changes no view.
    pub(super) fn update(&self, update: &v1::ViewUpdate) -> Result<(), Refusal> {
        if !(update.scene.is_empty() || update.scene == self.scene) {
            let problem = format!("is {:?}, the session's is {:?}", update.scene, self.scene);
            return Err(Refusal::Bad(FieldError::new("scene", problem)));
        }
        let view = update.view.map(|view| Wanted::new(update.sequence, view, &self.options));
        let view = view.transpose().map_err(Refusal::Bad)?;
        let quality = update.quality.as_ref().map(|quality| wish(Some(quality)));
        let quality = quality.transpose().map_err(Refusal::Bad)?;
        let mut heard = self.locked();
        let now = Instant::now();
        heard.allowance.take(f64::from(self.options.views_per_s), now)?;
        heard.at = now;
        heard.received = heard.received.max(update.received_frame);
        if let Some(view) = view.filter(|view| view.sequence > heard.wanted.sequence) {
            heard.wanted = view;
        }
        heard.wish = quality.unwrap_or(heard.wish);
        drop(heard);
        self.changed.notify_one();
        Ok(())
    }

    /// The client says no more.
    pub(super) fn close(&self) {
        self.locked().closed = true;
        self.changed.notify_one();
    }

    /// What was said last.
    pub(super) fn heard(&self) -> Heard {
        self.locked().clone()
    }

    /// Name of the scene.
    pub(super) fn scene(&self) -> &str {
        &self.scene
    }

    fn locked(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Allowance {
    fn take(&mut self, per_s: f64, now: Instant) -> Result<(), Refusal> {
        let passed = now.saturating_duration_since(self.at).as_secs_f64();
        (self.views, self.at) = ((self.views + per_s * passed).min(per_s), now);
        if self.views < 1.0 {
            let wait = (1.0 - self.views) / per_s.max(1.0);
            return Err(Refusal::TooFast(Duration::from_secs_f64(wait)));
        }
        self.views -= 1.0;
        Ok(())
    }
}

impl Refusal {
    /// The same, seen from the message that holds the update in its field `outer`.
    pub(super) fn within(self, outer: &str) -> Self {
        match self {
            Self::Bad(error) => Self::Bad(error.within(outer)),
            Self::TooFast(wait) => Self::TooFast(wait),
        }
    }

    /// The status of a call that did nothing else.
    pub(super) fn status(&self, options: &RenderOptions) -> Status {
        match self {
            Self::Bad(error) => status::invalid(error),
            Self::TooFast(wait) => refuse::too_fast(options.views_per_s, *wait),
        }
    }
}

/// Makes of an update that has not been taken yet one that says what it and a `later` one say.
pub(super) fn overtake(earlier: &mut v1::ViewUpdate, later: v1::ViewUpdate) {
    if later.view.is_some() && (earlier.view.is_none() || later.sequence > earlier.sequence) {
        (earlier.view, earlier.sequence) = (later.view, later.sequence);
    }
    if !later.scene.is_empty() {
        earlier.scene = later.scene;
    }
    earlier.quality = later.quality.or(earlier.quality);
    earlier.received_frame = earlier.received_frame.max(later.received_frame);
}

fn wish(quality: Option<&v1::Quality>) -> Result<Wish, FieldError> {
    Wish::new(quality).map_err(|e| e.within("quality"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn update(sequence: u64) -> v1::ViewUpdate {
        let view = v1::View {
            eye: Some(v1::Point3 { x: 1.0, y: 2.0, z: 3.0 }),
            extent: Some(v1::view::Extent::FovDeg(60.0)),
            width: 16,
            height: 16,
            ..v1::View::default()
        };
        v1::ViewUpdate {
            scene: "street".to_owned(),
            sequence,
            view: Some(view),
            ..v1::ViewUpdate::default()
        }
    }

    #[tokio::test(start_paused = true)]
    async fn views_that_come_too_fast_are_told_when_the_next_may() {
        let options = Arc::new(RenderOptions { views_per_s: 10, ..RenderOptions::default() });
        let inputs = Inputs::begin(update(1), &options).expect("good");
        for sequence in 2..12 {
            inputs.update(&update(sequence)).expect("a second's worth at once");
        }
        let Err(Refusal::TooFast(wait)) = inputs.update(&update(12)) else {
            panic!("one too many");
        };
        assert!(wait <= Duration::from_millis(100), "{wait:?}");
        assert_eq!(inputs.heard().wanted.sequence, 11, "and it changed nothing");
        tokio::time::advance(wait + Duration::from_millis(1)).await;
        inputs.update(&update(12)).expect("now it may");
        // A pause saves up no more than a second's worth.
        tokio::time::advance(Duration::from_secs(3600)).await;
        let taken = (13..100).take_while(|&sequence| inputs.update(&update(sequence)).is_ok());
        assert_eq!(taken.count(), 10);
    }

    #[test]
    fn a_later_update_overtakes_one_that_waits() {
        let quality = |jpeg_quality| Some(v1::Quality { jpeg_quality, ..v1::Quality::default() });
        let mut waiting = v1::ViewUpdate { received_frame: 3, ..v1::ViewUpdate::default() };
        overtake(&mut waiting, v1::ViewUpdate { quality: quality(40), ..update(7) });
        assert_eq!((waiting.sequence, waiting.received_frame), (7, 3), "the view is one at last");
        overtake(&mut waiting, update(6));
        assert_eq!((waiting.sequence, waiting.quality), (7, quality(40)), "that was older");
        let received = v1::ViewUpdate { received_frame: 5, ..v1::ViewUpdate::default() };
        overtake(&mut waiting, received);
        assert_eq!((waiting.sequence, waiting.received_frame), (7, 5));
        assert_eq!(waiting.scene, "street");
        overtake(&mut waiting, v1::ViewUpdate { quality: quality(50), ..update(8) });
        assert_eq!(
            waiting,
            v1::ViewUpdate { quality: quality(50), received_frame: 5, ..update(8) }
        );
    }

    #[tokio::test]
    async fn only_what_is_newer_counts() {
        let inputs = Inputs::begin(update(5), &Arc::default()).expect("good");
        let received =
            |frame| v1::ViewUpdate { received_frame: frame, ..v1::ViewUpdate::default() };
        inputs.update(&update(4)).expect("late, but good");
        inputs.update(&received(7)).expect("an acknowledgement");
        inputs.update(&received(6)).expect("a late one");
        let heard = inputs.heard();
        assert_eq!((heard.wanted.sequence, heard.received, heard.closed), (5, 7, false));
        let elsewhere = v1::ViewUpdate { scene: "other".to_owned(), ..update(6) };
        assert!(matches!(inputs.update(&elsewhere), Err(Refusal::Bad(e)) if e.field == "scene"));
    }
}
