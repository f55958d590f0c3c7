//! `RenderService`: pictures of scenes, for programs and for people.
//!
//! ```text
//! service   the calls
//! inputs    what a client says; only the latest counts
//! session   one client's walk: a streamer of its own, frames when they are due
//! pace      how many frames a connection takes, and how large
//! still     one picture, waited for
//! pick      what a pixel shows
//! scenes    what is open
//! stage     a scene on the device: orders, and their answers
//! painter   the thread that renders it for all who look at it
//! residents who has what there
//! absent    the answer of a server that was told not to render
//! ```
//!
//! The service is a streaming client like any other: it reads scenes through the streamer, from
//! data services in this process or over the network.

mod absent;
mod feeder;
mod inputs;
mod options;
mod pace;
mod painter;
mod pick;
mod picture;
mod refuse;
mod residents;
mod scenes;
mod service;
mod session;
mod sessions;
mod stage;
mod still;
mod wanted;
mod warm;

pub(crate) use absent::NotRendered;
pub use options::RenderOptions;
pub use service::Rendering;
