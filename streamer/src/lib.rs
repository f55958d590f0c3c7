//! From a view to scene updates: decides what to fetch, fetches it from the data services,
//! decodes it, and emits it in a sensible order.
//!
//! The services are reached through a [`tonic::transport::Channel`], be they across a network
//! or in the same process. Whatever they send is checked: they need not be friends. This
//! crate knows no store and no GPU.
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
mod fetch;
mod limits;
mod request;
mod resident;
mod streamer;
mod traffic;

pub use cache::{CacheError, CacheOptions, CacheStatistics, DiskOptions, Rank, SegmentedLru};
pub use client::Client;
pub use error::StreamError;
pub use event::{Event, Progress};
pub use limits::FetchLimits;
pub use request::ViewRequest;
pub use streamer::{Events, Streamer};
