//! Having every shader compiled before anything is timed.
//!
//! Drivers compile a pipeline when it is made, again when it first draws, and some once more for textures
//! of another kind. So the very renderer that is to walk is given the walk's first view, past the
//! throttled connection and by a streamer of its own, draws it as it does when the first picture is
//! there, soon and then well, and when all is, and drops everything again.

use flaneur_renderer::{FrameBudget, Renderer};
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Event, FetchLimits, ViewRequest};
use futures::StreamExt;
use tokio_util::sync::CancellationToken;

use super::stroll::BUDGET;
use crate::exit::Exit;
use crate::source::{Source, note, stream_exit};

/// Draws `view`. The renderer must be empty, and is so again.
pub(super) async fn warm_up(
    renderer: &mut Renderer,
    source: &Source,
    view: &View,
    limits: FetchLimits,
    cancel: &CancellationToken,
) -> Result<(), Exit> {
    renderer.expect_eye(view.eye());
    let mut streamer = source.streamer().await?;
    let request = ViewRequest { limits, ..ViewRequest::new(*view) };
    let mut events = streamer.stream(request, cancel);
    let (mut drops, mut drawn) = (Vec::new(), false);
    while let Some(event) = events.next().await {
        match event.map_err(stream_exit)? {
            Event::Update(update) => {
                drops.extend(drop_of(&update));
                let applied = tokio::task::block_in_place(|| renderer.apply(update))?;
                note(&mut events, &applied);
            }
            Event::Progress(progress) if progress.complete_picture && !drawn => {
                drawn = true;
                let settings = renderer.settings();
                renderer.set_settings(FrameBudget::new(BUDGET).settings(settings));
                draw(renderer, view)?;
                renderer.set_settings(settings);
                draw(renderer, view)?;
            }
            Event::Progress(_) | Event::Fault { .. } => {}
        }
    }
    draw(renderer, view)?;
    for dropped in drops {
        renderer.apply(dropped)?;
    }
    draw(renderer, view)?;
    renderer.cut();
    Ok(())
}

/// Draws twice: new depth maps and gains first, then a frame like the one before.
fn draw(renderer: &mut Renderer, view: &View) -> Result<(), Exit> {
    tokio::task::block_in_place(|| {
        renderer.render(view)?;
        renderer.render(view)?;
        Ok(())
    })
}

/// What takes an update back; nothing does that of a drop.
fn drop_of(update: &SceneUpdate) -> Option<SceneUpdate> {
    match update {
        SceneUpdate::Mesh(tile) => Some(SceneUpdate::DropMesh(tile.key)),
        SceneUpdate::Points(chunk) => Some(SceneUpdate::DropPoints(chunk.id)),
        SceneUpdate::Image(image) => Some(SceneUpdate::DropImage(image.id.clone())),
        SceneUpdate::DropMesh(_) | SceneUpdate::DropPoints(_) | SceneUpdate::DropImage(_) => None,
    }
}
