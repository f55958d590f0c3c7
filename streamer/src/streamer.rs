//! The streamer itself: one scene, one receiver of updates.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use flaneur_scene::{ImageId, ImageUpdate, Panorama, SceneInfo, SceneUpdate};
use futures::Stream;
use tokio::sync::mpsc;
use tokio_util::sync::{CancellationToken, DropGuard};
use tonic::transport::Channel;

use crate::fetch::{self, Fetch, Known};
use crate::resident::Resident;
use crate::{Client, Event, StreamError, ViewRequest};

/// Updates that may wait for their receiver.
const QUEUE: usize = 16;

/// Streams one scene to one receiver, whose holdings it keeps account of: what the receiver
/// already holds is not sent again, and what a view no longer wants is dropped.
#[derive(Debug)]
pub struct Streamer {
    client: Client,
    scene: Arc<SceneInfo>,
    known: Arc<Known>,
    resident: Resident,
}

impl Streamer {
    /// Asks the service behind `channel` what `scene` holds.
    pub async fn connect(channel: Channel, scene: &str) -> Result<Self, StreamError> {
        let client = Client::new(channel, scene);
        let scene = Arc::new(client.scene().await?);
        Ok(Self { client, scene, known: Arc::default(), resident: Resident::default() })
    }

    /// What the scene holds.
    pub fn info(&self) -> &SceneInfo {
        &self.scene
    }

    /// The client, for calls beside the stream.
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// The photograph `id` of `panorama` as it is stored: its finest level with its mask, a face
    /// of a sphere resampled. `None` where the panorama has none of that name. The receiver's
    /// holdings do not change.
    ///
    /// # Errors
    /// Where the service fails, or sends what is no such picture.
    pub async fn photograph(
        &self,
        panorama: &Arc<Panorama>,
        id: &ImageId,
    ) -> Result<Option<Arc<ImageUpdate>>, StreamError> {
        fetch::photograph(&self.client, &self.known, panorama, id).await
    }

    /// Everything that `request` wants and the receiver does not hold: buildings and terrain, a
    /// coarse level of the photographs, points from coarse to fine, finer photographs; then
    /// what is to be dropped. Once the stream has ended, the receiver holds what the
    /// request alone determines: the same over a network and in process, and whatever
    /// was streamed before.
    ///
    /// An error ends the stream, as does `cancel`, with [`StreamError::Cancelled`]. Dropping
    /// the stream ends its requests on the wire. Must be called within a tokio runtime.
    pub fn stream(&mut self, request: ViewRequest, cancel: &CancellationToken) -> Events<'_> {
        let (sender, receiver) = mpsc::channel(QUEUE);
        let cancel = cancel.child_token();
        let fetch = Fetch {
            client: self.client.clone(),
            scene: Arc::clone(&self.scene),
            known: Arc::clone(&self.known),
            resident: self.resident.clone(),
            request,
        };
        let stopped = cancel.clone();
        tokio::spawn(async move {
            let outcome = tokio::select! {
                biased;
                () = stopped.cancelled() => Err(StreamError::Cancelled),
                outcome = fetch.run(&sender) => outcome,
            };
            if let Err(error) = outcome {
                // Where nobody listens, nobody needs to know.
                drop(sender.send(Err(error)).await);
            }
        });
        Events { receiver, resident: &mut self.resident, _cancel_on_drop: cancel.drop_guard() }
    }
}

/// The events of one view. It borrows the streamer: one view is streamed at a time.
#[derive(Debug)]
pub struct Events<'a> {
    receiver: mpsc::Receiver<Result<Event, StreamError>>,
    resident: &'a mut Resident,
    _cancel_on_drop: DropGuard,
}

impl Events<'_> {
    /// Takes note of what the receiver did by itself: dropped to make room, say. What it does not
    /// hold any more is sent again once a view wants it.
    pub fn note(&mut self, update: &SceneUpdate) {
        self.resident.note(update);
    }

    /// Takes note that the receiver holds a photograph at another level than it was sent: where a
    /// view wants that one it is sent again.
    pub fn note_level(&mut self, id: &ImageId, level: u32) {
        self.resident.images.insert(id.clone(), level);
    }
}

impl Stream for Events<'_> {
    type Item = Result<Event, StreamError>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let event = std::task::ready!(self.receiver.poll_recv(context));
        // An update counts once it is handed over, not when it was fetched.
        if let Some(Ok(Event::Update(update))) = &event {
            self.resident.note(update);
        }
        Poll::Ready(event)
    }
}
