//! What a caller is told while a view's scene arrives.

use flaneur_scene::SceneUpdate;

use crate::StreamError;

/// One step of streaming.
#[derive(Clone, Debug)]
pub enum Event {
    /// Something for the renderer.
    Update(SceneUpdate),
    /// How far it is.
    Progress(Progress),
    /// Something could not be had. What can be had comes all the same, and the rest is asked for
    /// again with the next view; what a server that does not answer would have, until it does.
    Fault {
        /// Of which view, as [`Streamer::look`](crate::Streamer::look) numbered it.
        view: u64,
        /// What went wrong.
        error: StreamError,
    },
}

/// How far streaming is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Of which view, as [`Streamer::look`](crate::Streamer::look) numbered it.
    pub view: u64,
    /// Bytes of messages received since the streamer connected.
    pub bytes_received: u64,
    /// Requests sent since it connected.
    pub requests: u64,
    /// Tiles, images and nodes that are still to come.
    pub remaining: u64,
    /// What was emitted makes a complete picture, however coarse: the base mesh in sight, and a coarse
    /// level of the photographs that decide the picture.
    pub complete_picture: bool,
    /// [`Progress::bytes_received`] when it first did so for this view.
    pub complete_at: Option<u64>,
    /// Everything that the view wants, and that can be had, has been emitted.
    pub finished: bool,
}
