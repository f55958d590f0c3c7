//! The messages of one call.

use prost::Message;
use tokio::sync::OwnedSemaphorePermit;
use tonic::Streaming;

use super::Client;
use crate::StreamError;
use crate::servers::Turn;

/// A streaming response under way. Dropping it ends the call on the wire and makes room for
/// the next one, and what has come of it and is not settled is noted as lost.
#[derive(Debug)]
pub(crate) struct Incoming<M> {
    call: &'static str,
    /// Bytes that have come and may yet come to nothing.
    unsettled: u64,
    messages: Streaming<M>,
    client: Client,
    turn: Turn,
    _permit: OwnedSemaphorePermit,
}

impl<M> Incoming<M> {
    pub(super) fn new(
        call: &'static str,
        messages: Streaming<M>,
        client: Client,
        turn: Turn,
        permit: OwnedSemaphorePermit,
    ) -> Self {
        Self { call, unsettled: 0, messages, client, turn, _permit: permit }
    }

    /// The call's name.
    pub(crate) fn call(&self) -> &'static str {
        self.call
    }

    /// What has come so far is whole.
    pub(super) fn settle(&mut self) {
        self.unsettled = 0;
        self.client.servers.works(self.turn);
    }

    /// Which server answers.
    pub(crate) fn turn(&self) -> Turn {
        self.turn
    }

    /// What was received is no answer.
    pub(crate) fn distrust(&self) {
        self.client.servers.fails(self.turn);
    }
}

impl<M: Message + 'static> Incoming<M> {
    /// The next message; `None` at the end, which settles what has come.
    pub(crate) async fn next(&mut self) -> Result<Option<M>, StreamError> {
        let message = self.client.heard.in_time(self.call, self.messages.message()).await;
        let message = self.client.judged(self.turn, message)?;
        match &message {
            Some(message) => {
                let bytes = message.encoded_len();
                self.client.traffic().received(bytes);
                self.unsettled += bytes as u64;
            }
            None => self.settle(),
        }
        Ok(message)
    }
}

impl<M> Drop for Incoming<M> {
    fn drop(&mut self) {
        self.client.traffic().abandoned(self.unsettled);
    }
}
