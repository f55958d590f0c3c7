//! Files and chunks that arrive in parts, in the order in which they were asked for.

use bytes::Bytes;
use flaneur_proto::{Assembly, FieldError, v1};
use prost::Message;

use super::incoming::Incoming;
use crate::StreamError;
use crate::servers::Turn;

/// A message that carries a piece of a payload.
pub(crate) trait Part: Message + Default + 'static {
    /// What a request names a payload by.
    type Key: PartialEq + std::fmt::Debug + Send;

    /// Which payload this is a piece of.
    fn key(&self) -> Option<&Self::Key>;
    /// Total bytes, offset and bytes of this piece.
    fn piece(&self) -> (u64, u64, &[u8]);
}

impl Part for v1::ImagePart {
    type Key = v1::ImageKey;

    fn key(&self) -> Option<&v1::ImageKey> {
        self.image.as_ref()
    }

    fn piece(&self) -> (u64, u64, &[u8]) {
        (self.total_bytes, self.offset, &self.data)
    }
}

impl Part for v1::PointChunk {
    type Key = v1::NodeKey;

    fn key(&self) -> Option<&v1::NodeKey> {
        self.key.as_ref()
    }

    fn piece(&self) -> (u64, u64, &[u8]) {
        (self.total_bytes, self.offset, &self.data)
    }
}

/// The payloads of one call.
#[derive(Debug)]
pub(crate) struct Payloads<P: Part> {
    parts: Incoming<P>,
    expected: std::vec::IntoIter<P::Key>,
    limit: u64,
}

impl<P: Part> Payloads<P> {
    pub(super) fn new(parts: Incoming<P>, expected: Vec<P::Key>, limit: u64) -> Self {
        Self { parts, expected: expected.into_iter(), limit }
    }

    /// The next payload, `None` once all that was asked for has arrived. Refused: parts of
    /// anything else, out of order, or larger together than the limit.
    pub(crate) async fn next(&mut self) -> Result<Option<Bytes>, StreamError> {
        let Some(expected) = self.expected.next() else { return Ok(None) };
        let first = self.part_of(&expected).await?;
        let (total, offset, data) = first.piece();
        let mut assembly = Assembly::new(total, self.limit).map_err(|e| self.bad(e))?;
        let mut whole = assembly.push(total, offset, data).map_err(|e| self.bad(e))?;
        while whole.is_none() {
            let part = self.part_of(&expected).await?;
            let (total, offset, data) = part.piece();
            whole = assembly.push(total, offset, data).map_err(|e| self.bad(e))?;
        }
        self.parts.settle();
        Ok(whole)
    }

    /// Which server answers.
    pub(crate) fn turn(&self) -> Turn {
        self.parts.turn()
    }

    /// What was received is not what there is: its server is not asked for a while.
    pub(crate) fn distrust(&self) {
        self.parts.distrust();
    }

    async fn part_of(&mut self, expected: &P::Key) -> Result<P, StreamError> {
        let Some(part) = self.parts.next().await? else {
            let problem = format!("the stream ended before {expected:?} was whole");
            return Err(self.bad(FieldError::new("data", problem)));
        };
        if part.key() == Some(expected) {
            return Ok(part);
        }
        let problem = format!("is {:?}, must be {expected:?}", part.key());
        Err(self.bad(FieldError::new("key", problem)))
    }

    fn bad(&self, field: FieldError) -> StreamError {
        self.distrust();
        StreamError::field(self.parts.call())(field)
    }
}
