//! From a view to scene updates: decides what to fetch, fetches it from the data services,
//! decodes it, and emits it, what matters most for the picture first.
//!
//! The services are reached through one or several [`tonic::transport::Channel`]s, be they across a
//! network or in the same process. Whatever they send is checked: they need not be friends. This
//! crate knows no store and no GPU.
//!
//! | module | what |
//! |---|---|
//! | `survey` | what is known of a scene, and what a view wants of it |
//! | `choose` | which tiles, images and nodes a view wants |
//! | `plan` | in which order, what is under way, what the receiver holds: decisions alone |
//! | `load` | parts out of the cache or over the network, no more at once than it carries |
//! | `cache` | what was fetched, in memory and on disk |
//! | `client` | the calls of the services, checked; `servers`: which of several is asked |
//! | `decode` | payloads to meshes, pictures and points, on threads that may block |
//! | `session` | the task that ties these together for one receiver |
//!
//! ```no_run
//! # async fn example(channel: tonic::transport::Channel, view: flaneur_scene::View)
//! # -> Result<(), flaneur_streamer::StreamError> {
//! use flaneur_streamer::{Event, Streamer, ViewRequest};
//! use futures::StreamExt;
//! use tokio_util::sync::CancellationToken;
//!
//! let mut streamer = Streamer::connect(channel, "street").await?;
//! let mut events = streamer.stream(ViewRequest::new(view), &CancellationToken::new());
//! while let Some(event) = events.next().await {
//!     match event? {
//!         Event::Update(update) => println!("for the renderer: {update:?}"),
//!         Event::Progress(progress) => println!("{} to come", progress.remaining),
//!         Event::Fault { error, .. } => println!("cannot be had: {error}"),
//!     }
//! }
//! # Ok(())
//! # }
//! ```

mod cache;
mod choose;
mod client;
mod decode;
mod error;
mod event;
mod limits;
mod load;
mod plan;
mod request;
mod servers;
mod session;
mod streamer;
mod survey;
mod traffic;

pub use cache::{CacheError, CacheOptions, CacheStatistics, DiskOptions, Rank, SegmentedLru};
pub use client::Client;
pub use error::StreamError;
pub use event::{Event, Progress};
pub use limits::FetchLimits;
pub use plan::Order;
pub use request::{Gaze, ViewRequest};
pub use servers::Servers;
pub use session::Statistics;
pub use streamer::{Events, StreamOptions, Streamer};
