//! The messages of one call.

use std::sync::Arc;
use std::time::Duration;

use prost::Message;
use tokio::sync::OwnedSemaphorePermit;
use tonic::Streaming;

use super::in_time;
use crate::StreamError;
use crate::traffic::Traffic;

/// How long a service may be silent before its call is given up.
pub(super) const STALL: Duration = Duration::from_secs(60);

/// A streaming response under way. Dropping it ends the call on the wire and makes room for
/// the next one.
#[derive(Debug)]
pub(crate) struct Incoming<M> {
    call: &'static str,
    messages: Streaming<M>,
    traffic: Arc<Traffic>,
    _permit: OwnedSemaphorePermit,
}

impl<M> Incoming<M> {
    pub(super) fn new(
        call: &'static str,
        messages: Streaming<M>,
        traffic: Arc<Traffic>,
        permit: OwnedSemaphorePermit,
    ) -> Self {
        Self { call, messages, traffic, _permit: permit }
    }

    /// The call's name.
    pub(super) fn call(&self) -> &'static str {
        self.call
    }
}

impl<M: Message + 'static> Incoming<M> {
    /// The next message, `None` at the end.
    pub(super) async fn next(&mut self) -> Result<Option<M>, StreamError> {
        let message = in_time(self.call, self.messages.message()).await?;
        if let Some(message) = &message {
            self.traffic.received(message.encoded_len());
        }
        Ok(message)
    }
}
