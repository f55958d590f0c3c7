//! What can go wrong between a service and a scene update.

use flaneur_proto::FieldError;

/// Why streaming stopped.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StreamError {
    /// The service refused or failed, or the connection broke.
    #[error("{call}: {}", said(status))]
    Status {
        /// The call, as in `GetScene`.
        call: &'static str,
        /// What came back.
        status: Box<tonic::Status>,
    },
    /// No message arrived for a while.
    #[error("{call}: nothing was received for {seconds} s; the service may be overloaded")]
    Stalled {
        /// The call.
        call: &'static str,
        /// How long was waited.
        seconds: u64,
    },
    /// A message holds what the contract forbids.
    #[error("{call}: the service sent a message that cannot be used: {source}")]
    BadMessage {
        /// The call.
        call: &'static str,
        /// The field at fault.
        source: FieldError,
    },
    /// More arrived than a client takes.
    #[error("{call}: the service sent more than {limit} {what}")]
    TooMuch {
        /// The call.
        call: &'static str,
        /// What there was too much of.
        what: &'static str,
        /// How much is taken.
        limit: usize,
    },
    /// The bytes of a photograph, mask or point node cannot be decoded.
    #[error("cannot decode {what}: {problem}")]
    Damaged {
        /// Which photograph or node.
        what: String,
        /// What is wrong with its bytes.
        problem: String,
    },
    /// What is fetched cannot be kept.
    #[error(transparent)]
    Cache(#[from] crate::CacheError),
    /// The caller cancelled.
    #[error("streaming was cancelled")]
    Cancelled,
}

impl StreamError {
    pub(crate) fn field(call: &'static str) -> impl Fn(FieldError) -> Self {
        move |source| Self::BadMessage { call, source }
    }

    pub(crate) fn status(call: &'static str) -> impl Fn(tonic::Status) -> Self {
        move |status| Self::Status { call, status: Box::new(status) }
    }

    /// Whether the same request may well succeed at another time, or at another server.
    pub(crate) fn is_transient(&self) -> bool {
        use tonic::Code::{Aborted, Cancelled, DeadlineExceeded, ResourceExhausted, Unavailable};
        use tonic::Code::{Internal, Unknown};
        match self {
            Self::Stalled { .. } => true,
            // A connection that breaks is unknown, internal or cancelled, as it happens.
            Self::Status { status, .. } => matches!(
                status.code(),
                Aborted
                    | Cancelled
                    | DeadlineExceeded
                    | ResourceExhausted
                    | Unavailable
                    | Internal
                    | Unknown
            ),
            Self::BadMessage { .. }
            | Self::TooMuch { .. }
            | Self::Damaged { .. }
            | Self::Cache(_)
            | Self::Cancelled => false,
        }
    }

    /// Whether a server itself said that it cannot do this now, rather than a connection that broke
    /// or a server that is full.
    pub(crate) fn is_excuse(&self) -> bool {
        use tonic::Code::{Aborted, Internal, Unavailable, Unknown};
        let Self::Status { status, .. } = self else { return false };
        // What goes wrong on this side, or on the way, has a source.
        let is_said = std::error::Error::source(&**status).is_none();
        is_said && matches!(status.code(), Aborted | Internal | Unavailable | Unknown)
    }

    /// Whether what came is not what there is: worth asking for once more.
    pub(crate) fn is_garbage(&self) -> bool {
        match self {
            Self::BadMessage { .. } | Self::TooMuch { .. } | Self::Damaged { .. } => true,
            Self::Status { status, .. } => status.code() == tonic::Code::DataLoss,
            Self::Stalled { .. } | Self::Cache(_) | Self::Cancelled => false,
        }
    }

    /// Whether another server might do better.
    pub(crate) fn is_server_at_fault(&self) -> bool {
        self.is_transient() || self.is_garbage()
    }

    /// Whether what the caller asked for is at fault: a name that does not exist, a number
    /// that is out of range.
    pub fn is_bad_request(&self) -> bool {
        use tonic::Code::{InvalidArgument, NotFound, OutOfRange};
        matches!(self, Self::Status { status, .. }
            if matches!(status.code(), NotFound | InvalidArgument | OutOfRange))
    }
}

/// What the service said, or what its code means where it said nothing.
fn said(status: &tonic::Status) -> String {
    match status.message() {
        "" => status.code().description().to_lowercase(),
        message => message.to_owned(),
    }
}
