//! What can go wrong between here and a farm.

use tonic::{Code, Status};

/// Error of a [`Client`](crate::Client).
#[derive(Clone, Debug, thiserror::Error)]
pub enum RemoteError {
    /// No answer, after all retries.
    #[error("{what}: the server does not answer: {reason}")]
    Unreachable {
        /// The request.
        what: &'static str,
        /// The last reason.
        reason: String,
    },
    /// The server rejects the request.
    #[error("{what}: the server answers {code}: {reason}")]
    Rejected {
        /// The request.
        what: &'static str,
        /// The name of the gRPC code.
        code: String,
        /// Its explanation.
        reason: String,
    },
    /// The answer contradicts the request, its own digest, or a limit.
    #[error("the answer of the server is invalid: {0}")]
    Invalid(String),
    /// A blob, or an action, is not in the store.
    #[error("{0} is not in the store of the server")]
    Missing(String),
    /// A file here cannot be read, or has changed meanwhile.
    #[error("{0}")]
    File(String),
    /// The address, a header or a certificate is wrong, or the server lacks something.
    #[error("{0}")]
    Settings(String),
}

impl RemoteError {
    /// Whether the server is away.
    pub fn is_unreachable(&self) -> bool {
        matches!(self, Self::Unreachable { .. })
    }

    /// The error of a request that is not repeated.
    pub(crate) fn of(what: &'static str, status: &Status) -> Self {
        let reason = bounded(status.message());
        // A broken connection has a cause in this process, and an answer has none.
        let is_ours = std::error::Error::source(status).is_some();
        match status.code() {
            Code::Unavailable | Code::DeadlineExceeded | Code::Cancelled => Self::Unreachable { what, reason },
            _ if is_ours => Self::Unreachable { what, reason },
            code => Self::Rejected { what, code: format!("{code:?}"), reason },
        }
    }
}

/// Whether the same request may succeed later.
pub(crate) fn is_transient(code: Code) -> bool {
    // Broken connections have the code Unknown or Internal.
    matches!(
        code,
        Code::Unavailable
            | Code::ResourceExhausted
            | Code::Aborted
            | Code::DeadlineExceeded
            | Code::Unknown
            | Code::Internal
            | Code::Cancelled
    )
}

/// Maximum length of a text from the server that becomes part of a message.
const MAX_REASON: usize = 2000;

/// The start of a text.
pub(crate) fn bounded(text: &str) -> String {
    text.chars().take(MAX_REASON).collect()
}
