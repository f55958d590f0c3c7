//! Someone who walks: views go out, frames come in.

use std::time::Duration;

use flaneur_proto::v1;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Status, Streaming};

use crate::{Client, SCENE, exact, view};

/// How long a frame may take, at most, on a machine that does other things as well.
const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) struct Walker {
    views: mpsc::Sender<v1::ViewUpdate>,
    frames: Streaming<v1::Frame>,
    pub(crate) sequence: u64,
}

pub(crate) fn update(sequence: u64, heading_deg: f64) -> v1::ViewUpdate {
    v1::ViewUpdate {
        scene: SCENE.to_owned(),
        sequence,
        view: Some(view(heading_deg)),
        quality: Some(exact()),
        received_frame: 0,
    }
}

impl Walker {
    /// Begins with a view to `heading_deg`.
    pub(crate) async fn begin(client: &mut Client, heading_deg: f64) -> Result<Self, Status> {
        let (views, receiver) = mpsc::channel(64);
        views.send(update(1, heading_deg)).await.expect("room");
        let frames = client.navigate(ReceiverStream::new(receiver)).await?.into_inner();
        Ok(Self { views, frames, sequence: 1 })
    }

    pub(crate) async fn turn(&mut self, heading_deg: f64) {
        self.sequence += 1;
        self.send(update(self.sequence, heading_deg)).await;
    }

    pub(crate) async fn send(&self, update: v1::ViewUpdate) {
        // A walk that has ended says why with its next frame.
        drop(self.views.send(update).await);
    }

    /// The next frame, not acknowledged.
    pub(crate) async fn next(&mut self) -> Result<Option<v1::Frame>, Status> {
        let next = tokio::time::timeout(PATIENCE, self.frames.message());
        next.await.expect("a frame in time")
    }

    /// The frames up to the final one of the last view; each is acknowledged.
    pub(crate) async fn settle(&mut self) -> Vec<v1::Frame> {
        let mut frames = Vec::new();
        loop {
            let frame = self.next().await.expect("a frame").expect("more to come");
            let received_frame = frame.number;
            self.send(v1::ViewUpdate { received_frame, ..v1::ViewUpdate::default() }).await;
            let ends = frame.r#final && frame.sequence == self.sequence;
            frames.push(frame);
            if ends {
                return frames;
            }
        }
    }

    /// Sends no more; the frames that come all the same.
    pub(crate) async fn end(mut self) -> Result<Vec<v1::Frame>, Status> {
        drop(self.views);
        let mut frames = Vec::new();
        while let Some(frame) =
            tokio::time::timeout(PATIENCE, self.frames.message()).await.expect("an end in time")?
        {
            frames.push(frame);
        }
        Ok(frames)
    }
}
