//! A scene on the device: the orders to the thread that renders it, and their answers.
//!
//! Whoever wants something from it gives an order and waits for the answer before the next: so all
//! have their turn, in the order in which they asked.

use std::sync::Arc;
use std::time::Duration;

use flaneur_renderer::{Frame, Gpu, RenderError, Renderer};
use glam::DVec2;
use tokio::sync::{mpsc, oneshot};

use super::RenderOptions;
use super::feeder::Feeder;
use super::painter::Painter;
use super::residents::FeederId;
use super::wanted::{Wanted, Wish};
use super::warm;
use crate::place::Found;

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

/// What is asked of the thread.
pub(super) enum Order {
    Apply(Arc<Feeder>),
    Frame(Arc<Feeder>, Manner, oneshot::Sender<Result<Painted, RenderError>>),
    Pick(Box<Wanted>, DVec2, oneshot::Sender<Result<Option<Found>, RenderError>>),
    Leave(FeederId),
}

impl Stage {
    /// Starts the thread, in a runtime. Shaders are compiled there.
    ///
    /// It is one of the runtime's own, whose end waits for it: a driver that works while the process
    /// ends crashes.
    pub(super) fn start(gpu: &Gpu, options: &RenderOptions) -> Self {
        let (orders, received) = mpsc::unbounded_channel();
        let (gpu, options) = (gpu.clone(), options.clone());
        let run = move || {
            let mut renderer = Renderer::with_settings(&gpu, options.settings);
            if let Err(error) = warm::up(&mut renderer, &options) {
                tracing::warn!(%error, "shaders will be compiled with the first frame");
            }
            Painter::new(renderer, options).follow(received);
        };
        drop(tokio::task::spawn_blocking(run));
        Self { orders }
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

    /// Waits until [`Stage::has_ended`].
    pub(super) async fn ended(&self) {
        self.orders.closed().await;
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

/// What is told of a stage that has ended.
pub(super) fn gone() -> RenderError {
    RenderError::Driver("it ended".to_owned())
}

#[cfg(test)]
mod tests {
    use flaneur_proto::v1;

    use super::*;

    #[tokio::test]
    async fn who_waits_hears_that_the_thread_has_ended() {
        let (orders, mut received) = mpsc::unbounded_channel();
        let stage = Stage { orders };
        let view = v1::View {
            eye: Some(v1::Point3 { x: 1.0, y: 2.0, z: 3.0 }),
            extent: Some(v1::view::Extent::FovDeg(60.0)),
            width: 16,
            height: 16,
            ..v1::View::default()
        };
        let wanted = Wanted::new(1, view, &RenderOptions::default()).expect("a view");
        let waiting = stage.clone();
        let pick = tokio::spawn(async move { waiting.pick(wanted, DVec2::ONE).await });
        let order = received.recv().await;
        assert!(matches!(order, Some(Order::Pick(..))));
        drop((order, received));
        stage.ended().await;
        assert!(stage.has_ended());
        let outcome = pick.await.expect("no panic");
        assert!(outcome.is_err_and(|error| error.is_fatal()));
    }
}
