//! One picture, waited for until it is final.

use std::sync::Arc;

use flaneur_proto::v1;
use flaneur_streamer::{Event, ViewRequest};
use tonic::Status;

use super::picture::{self, Encoded, FINAL_QUALITY};
use super::scenes::{OpenScene, Visit};
use super::stage::{self, Manner, Painted};
use super::wanted::{Wanted, Wish};
use super::{RenderOptions, refuse};

/// The final frame of a view.
///
/// # Errors
/// Where something that the view wants cannot be had, or the view cannot be rendered.
pub(super) async fn frame(
    scene: Arc<OpenScene>,
    wanted: Wanted,
    wish: Wish,
    options: &RenderOptions,
) -> Result<v1::Frame, Status> {
    let still = Still::paint(scene, wanted, wish, options).await?;
    let Encoded { message, since } = picture::encoded(still.painted, FINAL_QUALITY).await?;
    let latency_ms = since.elapsed().as_secs_f64() * 1e3;
    let bytes_received = still.bytes_received;
    Ok(v1::Frame { number: 1, complete: true, bytes_received, latency_ms, ..message })
}

/// A view of which everything is on the device, for as long as this is there.
pub(super) struct Still {
    pub(super) painted: Painted,
    bytes_received: u64,
    pub(super) visit: Visit,
}

impl Still {
    /// Loads what the view wants, and paints it.
    ///
    /// # Errors
    /// As [`frame`].
    pub(super) async fn paint(
        scene: Arc<OpenScene>,
        wanted: Wanted,
        wish: Wish,
        options: &RenderOptions,
    ) -> Result<Self, Status> {
        let mut streamer = scene.streamer.beside();
        let request = ViewRequest { limits: options.limits, ..ViewRequest::new(wanted.view) };
        let (view, sequence) = (streamer.look(request), wanted.sequence);
        let mut visit = Visit::new(scene, wanted, wish);
        let feeder = Arc::clone(&visit.feeder);
        let mut bytes_received = 0;
        let (mut finished, mut applying) = (false, false);
        while !finished {
            let has_room = feeder.has_room();
            if !has_room && !applying {
                visit.stage().apply(&feeder);
                applying = true;
            }
            tokio::select! {
                () = visit.scene.stage.ended() => return Err(refuse::of_render(&stage::gone())),
                () = feeder.room.notified() => applying = false,
                Some(note) = visit.notes.recv() => note.tell(&streamer),
                event = streamer.next(), if has_room => match event {
                    Event::Update(update) => feeder.push(update),
                    Event::Progress(progress) if progress.view == view => {
                        bytes_received = progress.bytes_received;
                        finished = progress.finished;
                    }
                    Event::Fault { view: of, error } if of == view => {
                        return Err(refuse::of_stream(&error));
                    }
                    Event::Progress(_) | Event::Fault { .. } => {}
                },
            }
        }
        let manner = Manner { finish: Some(sequence), patient: true };
        let painted = loop {
            let painted = visit.stage().frame(&feeder, manner).await;
            let painted = painted.map_err(|e| refuse::of_render(&e))?;
            if painted.finished {
                break painted;
            }
        };
        Ok(Self { painted, bytes_received, visit })
    }
}
