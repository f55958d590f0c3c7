//! Ranges of objects on their way from the store to a client, in parts.
//!
//! Nothing is read that the client has not asked for by taking what came before, but for a
//! little ahead, which hides the store's latency. What a client that takes nothing makes the
//! server hold is bounded: [`FREE_BYTES`], and more only as far as the client has shown that it
//! takes so much, and as all streams together stay within [`AHEAD_BYTES`]. Where those are used
//! up, streams go on without.

use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use flaneur_proto::{PART_BYTES, split};
use futures::future::BoxFuture;
use futures::stream::{self, FuturesOrdered, Stream, StreamExt, TryStreamExt};
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tonic::Status;

use super::status;

/// Pieces of a stream that are read at a time.
const READ_AHEAD: usize = 4;

/// Bytes that every stream may hold: a part.
const FREE_BYTES: u64 = PART_BYTES as u64;

/// Bytes that a stream may hold at most.
const STREAM_BYTES: u64 = 8 << 20;

/// Bytes that are asked of the store at once.
const PIECE_BYTES: u64 = 2 << 20;

/// Bytes that all streams together may hold beyond [`FREE_BYTES`] each.
const AHEAD_BYTES: u64 = 256 << 20;

/// Bytes of a permit of [`Ahead`].
const PERMIT_BYTES: u64 = 1 << 10;

/// What streams may hold beyond what is free, of a whole server.
#[derive(Clone)]
pub(super) struct Ahead(Arc<Semaphore>);

impl Ahead {
    pub(super) fn new() -> Self {
        Self(Arc::new(Semaphore::new((AHEAD_BYTES / PERMIT_BYTES) as usize)))
    }

    /// Room for so many bytes, where there is any.
    fn take(&self, bytes: u64) -> Option<OwnedSemaphorePermit> {
        let permits = u32::try_from(bytes.div_ceil(PERMIT_BYTES)).ok()?;
        Arc::clone(&self.0).try_acquire_many_owned(permits).ok()
    }
}

/// A range of an object that a client asked for.
pub(super) struct Payload<K> {
    /// The object.
    pub(super) path: Path,
    /// Which bytes of it; not none.
    pub(super) range: Range<u64>,
    /// What it is called in messages.
    pub(super) what: String,
    /// What it was asked for by.
    pub(super) key: K,
}

/// A part of a payload.
pub(super) struct Part<K> {
    /// The payload it is a part of.
    pub(super) payload: Arc<Payload<K>>,
    /// Its place in the payload.
    pub(super) offset: u64,
    /// Its bytes.
    pub(super) data: Bytes,
}

impl<K> Payload<K> {
    /// Bytes of all parts together.
    pub(super) fn total(&self) -> u64 {
        self.range.end - self.range.start
    }
}

/// The parts of what `keys` stand for, one payload after the other, read as they are taken. A
/// key is kept until its turn comes, its payload from then on: keys should be small.
pub(super) fn parts<K, F>(
    store: Arc<dyn ObjectStore>,
    ahead: Ahead,
    keys: Vec<K>,
    payload_of: F,
) -> impl Stream<Item = Result<Part<K>, Status>> + Send
where
    K: Send + Sync + 'static,
    F: Fn(K) -> Result<Payload<K>, Status> + Send,
{
    let reader = Reader {
        store,
        ahead,
        keys: keys.into_iter(),
        payload_of,
        current: None,
        window: FuturesOrdered::new(),
        held: 0,
        taken: 0,
    };
    stream::try_unfold(reader, Reader::next)
        .map_ok(|piece| stream::iter(piece.parts()).map(Ok))
        .try_flatten()
}

struct Reader<K, F> {
    store: Arc<dyn ObjectStore>,
    ahead: Ahead,
    /// What is not yet begun.
    keys: std::vec::IntoIter<K>,
    payload_of: F,
    /// The payload that is not read to its end, and how much of it is.
    current: Option<(Arc<Payload<K>>, u64)>,
    /// Reads under way or done, in order.
    window: FuturesOrdered<BoxFuture<'static, Result<Piece<K>, Status>>>,
    /// Bytes of the window.
    held: u64,
    /// Bytes that have left it.
    taken: u64,
}

/// Bytes that were read at once.
struct Piece<K> {
    payload: Arc<Payload<K>>,
    offset: u64,
    data: Bytes,
    permit: Option<OwnedSemaphorePermit>,
}

impl<K, F> Reader<K, F>
where
    K: Send + Sync + 'static,
    F: Fn(K) -> Result<Payload<K>, Status>,
{
    async fn next(mut self) -> Result<Option<(Piece<K>, Self)>, Status> {
        while self.window.len() < READ_AHEAD && self.begin()? {}
        let Some(piece) = self.window.next().await.transpose()? else { return Ok(None) };
        let bytes = piece.data.len() as u64;
        self.held -= bytes;
        self.taken += bytes;
        Ok(Some((piece, self)))
    }

    /// Begins to read the next piece, if that may be.
    fn begin(&mut self) -> Result<bool, Status> {
        let (payload, offset) = match self.current.take() {
            Some(current) => current,
            None => match self.keys.next() {
                Some(key) => (Arc::new((self.payload_of)(key)?), 0),
                None => return Ok(false),
            },
        };
        let rest = payload.total() - offset;
        let Some((bytes, permit)) = room(rest, self.held, self.taken, &self.ahead) else {
            self.current = Some((payload, offset));
            return Ok(false);
        };
        if bytes < rest {
            self.current = Some((Arc::clone(&payload), offset + bytes));
        }
        self.held += bytes;
        let place = offset..offset + bytes;
        self.window.push_back(Box::pin(read(Arc::clone(&self.store), payload, place, permit)));
        Ok(true)
    }
}

/// How much of `rest` bytes of a payload may be read where a stream holds `held` bytes, and its
/// client has taken `taken`; with the room for it, where it is not free. `None` while there is none.
fn room(
    rest: u64,
    held: u64,
    taken: u64,
    ahead: &Ahead,
) -> Option<(u64, Option<OwnedSemaphorePermit>)> {
    let limit = taken.clamp(FREE_BYTES, STREAM_BYTES);
    let mut bytes = rest.min(PIECE_BYTES).min(limit.saturating_sub(held));
    // No crumbs: a store is asked for little only where little is left.
    if bytes < rest {
        bytes -= bytes % FREE_BYTES;
    }
    if bytes >= rest.min(FREE_BYTES) {
        if held + bytes <= FREE_BYTES {
            return Some((bytes, None));
        }
        if let Some(permit) = ahead.take(bytes) {
            return Some((bytes, Some(permit)));
        }
    }
    (held == 0).then(|| (rest.min(FREE_BYTES), None))
}

async fn read<K>(
    store: Arc<dyn ObjectStore>,
    payload: Arc<Payload<K>>,
    place: Range<u64>,
    permit: Option<OwnedSemaphorePermit>,
) -> Result<Piece<K>, Status> {
    let start = payload.range.start;
    let bytes = store.get_range(&payload.path, start + place.start..start + place.end).await;
    let data = bytes.map_err(|e| status::of_object_store(&payload.what, &e))?;
    if data.len() as u64 != place.end - place.start {
        let (path, bytes) = (&payload.path, data.len());
        tracing::warn!(%path, bytes, ?place, "store gave other bytes than asked for");
        return Err(status::try_again(&format!("the store did not give all of {}", payload.what)));
    }
    Ok(Piece { payload, offset: place.start, data, permit })
}

impl<K> Piece<K> {
    /// The parts, the room that they take kept until the last is taken.
    fn parts(self) -> impl Iterator<Item = Part<K>> {
        let Self { payload, offset, data, permit } = self;
        let parts = split(&data);
        drop(data);
        parts.map(move |(at, data)| {
            let _ = &permit;
            Part { payload: Arc::clone(&payload), offset: offset + at, data }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stream_has_some_room_and_more_only_as_it_takes() {
        let ahead = Ahead::new();
        let bytes = |rest, held, taken| room(rest, held, taken, &ahead).map(|(bytes, _)| bytes);
        assert_eq!(bytes(100, 0, 0), Some(100));
        assert_eq!(bytes(u64::MAX, 0, 0), Some(FREE_BYTES));
        // Small payloads side by side, as many as are free.
        assert_eq!(bytes(100, FREE_BYTES - 100, 0), Some(100));
        assert_eq!(bytes(100, FREE_BYTES - 99, 0), None);
        assert_eq!(bytes(u64::MAX, FREE_BYTES - 1, 0), None, "no crumbs");
        // Who has taken much gets as much ahead, in large pieces.
        assert_eq!(bytes(u64::MAX, 0, 1 << 20), Some(1 << 20));
        assert_eq!(bytes(u64::MAX, 1 << 20, 1 << 40), Some(PIECE_BYTES));
        assert_eq!(bytes(u64::MAX, STREAM_BYTES, 1 << 40), None);
    }

    #[test]
    fn where_all_room_is_taken_streams_go_on_piece_by_piece() {
        let ahead = Ahead::new();
        let mut kept = Vec::new();
        while let Some((bytes, permit @ Some(_))) = room(u64::MAX, 0, 1 << 40, &ahead) {
            kept.push((bytes, permit));
        }
        assert_eq!(kept.iter().map(|(bytes, _)| bytes).sum::<u64>(), AHEAD_BYTES);
        assert!(matches!(room(u64::MAX, 0, 1 << 40, &ahead), Some((FREE_BYTES, None))));
        assert!(room(u64::MAX, FREE_BYTES, 1 << 40, &ahead).is_none());
        kept.pop();
        assert!(matches!(room(u64::MAX, 0, 1 << 40, &ahead), Some((PIECE_BYTES, Some(_)))));
    }
}
