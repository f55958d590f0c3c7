//! What a caller is told while a view's scene arrives.

use flaneur_scene::SceneUpdate;

/// One step of streaming.
#[derive(Clone, Debug)]
pub enum Event {
    /// Something for the renderer.
    Update(SceneUpdate),
    /// How far it is.
    Progress(Progress),
}

/// How far streaming is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Bytes of messages received by this streamer since it connected.
    pub bytes_received: u64,
    /// Requests sent since it connected.
    pub requests: u64,
    /// Updates that are still to come.
    pub remaining: u64,
    /// Everything that the view wants has been emitted.
    pub finished: bool,
}
