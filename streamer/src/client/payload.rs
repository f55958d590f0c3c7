//! Files and chunks that arrive in parts, in the order in which they were asked for.

use bytes::Bytes;
use flaneur_proto::{Assembly, FieldError, v1};
use prost::Message;

use super::incoming::Incoming;
use crate::StreamError;

/// A message that carries a piece of a payload.
pub(crate) trait Part: Message + Default + 'static {
    /// What a request names a payload by.
    type Key: PartialEq + std::fmt::Debug + Send;

    /// Which payload this is a piece of.
    fn key(&self) -> Option<&Self::Key>;
    /// What the payload is.
    fn media_type(&self) -> &str;
    /// Total bytes, offset and bytes of this piece.
    fn piece(&self) -> (u64, u64, &[u8]);
}

impl Part for v1::ImagePart {
    type Key = v1::ImageKey;

    fn key(&self) -> Option<&v1::ImageKey> {
        self.image.as_ref()
    }

    fn media_type(&self) -> &str {
        &self.media_type
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

    fn media_type(&self) -> &str {
        ""
    }

    fn piece(&self) -> (u64, u64, &[u8]) {
        (self.total_bytes, self.offset, &self.data)
    }
}

/// A whole payload.
#[derive(Debug)]
pub(crate) struct Payload {
    /// All its bytes.
    pub(crate) bytes: Bytes,
    /// What they are; empty for point chunks.
    pub(crate) media_type: String,
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
    pub(crate) async fn next(&mut self) -> Result<Option<Payload>, StreamError> {
        let Some(expected) = self.expected.next() else { return Ok(None) };
        let bad_field = StreamError::field(self.parts.call());
        let first = self.part_of(&expected).await?;
        let media_type = first.media_type().to_owned();
        let (total, offset, data) = first.piece();
        let mut assembly = Assembly::new(total, self.limit).map_err(&bad_field)?;
        let mut whole = assembly.push(total, offset, data).map_err(&bad_field)?;
        while whole.is_none() {
            let part = self.part_of(&expected).await?;
            let (total, offset, data) = part.piece();
            whole = assembly.push(total, offset, data).map_err(&bad_field)?;
        }
        Ok(whole.map(|bytes| Payload { bytes, media_type }))
    }

    async fn part_of(&mut self, expected: &P::Key) -> Result<P, StreamError> {
        let bad_field = StreamError::field(self.parts.call());
        let part = self.parts.next().await?.ok_or_else(|| {
            let problem = format!("the stream ended before {expected:?} was whole");
            bad_field(FieldError::new("data", problem))
        })?;
        if part.key() == Some(expected) {
            return Ok(part);
        }
        let problem = format!("is {:?}, must be {expected:?}", part.key());
        Err(bad_field(FieldError::new("key", problem)))
    }
}
