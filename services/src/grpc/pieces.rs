//! Objects and ranges of objects on their way from the store to a client, in parts.
//!
//! Nothing is read before the client has taken what came before, but for [`READ_AHEAD`].

use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use flaneur_proto::split;
use futures::stream::{self, Stream, StreamExt, TryStreamExt};
use object_store::path::Path;
use object_store::{GetOptions, GetRange, ObjectStore, ObjectStoreExt};
use tonic::Status;

use super::status;

/// Payloads of a request that are fetched at a time, to hide the store's latency.
pub(super) const READ_AHEAD: usize = 4;

/// Bytes that are asked of the store at once. With [`READ_AHEAD`], a stream holds four times
/// as much at most.
const PIECE_BYTES: u64 = 8 << 20;

/// A range of an object whose first piece has been read.
pub(super) struct Pieces {
    store: Arc<dyn ObjectStore>,
    path: Path,
    /// What the object is called in messages.
    what: String,
    range: Range<u64>,
    first: Bytes,
}

impl Pieces {
    /// A whole object, of a size that is not known yet.
    pub(super) async fn open(
        store: Arc<dyn ObjectStore>,
        path: Path,
        what: String,
    ) -> Result<Self, Status> {
        let failed = |e: object_store::Error| status::of_object_store(&what, &e);
        let range = Some(GetRange::Bounded(0..PIECE_BYTES));
        let options = GetOptions { range, ..GetOptions::default() };
        let result = store.get_opts(&path, options).await.map_err(failed)?;
        let range = 0..result.meta.size;
        let first = result.bytes().await.map_err(failed)?;
        Self { store, path, what, range, first }.checked()
    }

    /// A range of an object.
    pub(super) async fn range(
        store: Arc<dyn ObjectStore>,
        path: Path,
        range: Range<u64>,
        what: String,
    ) -> Result<Self, Status> {
        let piece = range.start..range.end.min(range.start + PIECE_BYTES);
        let first = store.get_range(&path, piece).await;
        let first = first.map_err(|e| status::of_object_store(&what, &e))?;
        Self { store, path, what, range, first }.checked()
    }

    /// Bytes of all parts together.
    pub(super) fn total(&self) -> u64 {
        self.range.end - self.range.start
    }

    /// The parts with their offsets from the start of the range.
    pub(super) fn parts(self) -> impl Stream<Item = Result<(u64, Bytes), Status>> {
        let start = self.range.start;
        let second = start + self.first.len() as u64;
        let first = stream::once(std::future::ready(Ok((0, self.first.clone()))));
        let further = stream::try_unfold((self, second), move |(this, from)| async move {
            if from >= this.range.end {
                return Ok(None);
            }
            let piece = this.read(from).await?;
            let next = from + piece.len() as u64;
            Ok::<_, Status>(Some(((from - start, piece), (this, next))))
        });
        first
            .chain(further)
            .map_ok(|(base, piece)| {
                let parts: Vec<_> = split(&piece).map(|(at, part)| Ok((base + at, part))).collect();
                stream::iter(parts)
            })
            .try_flatten()
    }

    async fn read(&self, from: u64) -> Result<Bytes, Status> {
        let piece = from..self.range.end.min(from + PIECE_BYTES);
        let length = piece.end - piece.start;
        let bytes = self.store.get_range(&self.path, piece).await;
        let bytes = bytes.map_err(|e| status::of_object_store(&self.what, &e))?;
        if bytes.len() as u64 == length { Ok(bytes) } else { Err(self.short(bytes.len())) }
    }

    fn checked(self) -> Result<Self, Status> {
        let wanted = self.total().min(PIECE_BYTES);
        if self.first.len() as u64 == wanted { Ok(self) } else { Err(self.short(self.first.len())) }
    }

    fn short(&self, bytes: usize) -> Status {
        tracing::warn!(path = %self.path, bytes, "store gave fewer bytes than asked for");
        Status::unavailable(format!("the store did not give all of {}; try again", self.what))
    }
}
