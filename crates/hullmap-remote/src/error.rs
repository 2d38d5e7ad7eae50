//! Errors of the connection to a farm, and of its answers.

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
    /// One side of a TLS connection does not accept the certificate of the other.
    #[error("{0}")]
    Certificate(String),
    /// A file here cannot be read, or has changed meanwhile.
    #[error("{0}")]
    File(String),
    /// The address, a header or a certificate is wrong, or the server lacks something.
    #[error("{0}")]
    Settings(String),
}

impl RemoteError {
    /// Whether the server is unreachable.
    pub fn is_unreachable(&self) -> bool {
        matches!(self, Self::Unreachable { .. })
    }

    /// This error of a first request, with a possible reason if the server closed the connection.
    pub(crate) fn at_start(self, uses_tls: bool) -> Self {
        match self {
            // The last: an alert of TLS, read as a frame of HTTP/2.
            Self::Unreachable { what, mut reason }
                if ["closed", "reset", "frame with invalid size"].iter().any(|word| reason.contains(word)) =>
            {
                reason.push_str(if uses_tls {
                    "; perhaps it does not accept the certificate of the client"
                } else {
                    "; perhaps it expects TLS (grpcs://)"
                });
                Self::Unreachable { what, reason }
            }
            other => other,
        }
    }

    /// The error of a request that is not repeated.
    pub(crate) fn from_status(what: &'static str, status: &Status) -> Self {
        if let Some(message) = certificate(status) {
            return Self::Certificate(message);
        }
        let reason = bounded(&reason(status));
        let is_ours = is_ours(status);
        match status.code() {
            Code::Unavailable | Code::DeadlineExceeded | Code::Cancelled => Self::Unreachable { what, reason },
            _ if is_ours => Self::Unreachable { what, reason },
            code => Self::Rejected { what, code: format!("{code:?}"), reason },
        }
    }
}

/// Whether the same request may succeed later.
pub(crate) fn is_transient(status: &Status) -> bool {
    // Broken connections have the code Unknown or Internal.
    let code = matches!(
        status.code(),
        Code::Unavailable
            | Code::ResourceExhausted
            | Code::Aborted
            | Code::DeadlineExceeded
            | Code::Unknown
            | Code::Internal
            | Code::Cancelled
    );
    code && certificate(status).is_none()
}

/// Whether a status comes from this process: a broken connection has a cause, and an answer of the
/// server has none.
fn is_ours(status: &Status) -> bool {
    std::error::Error::source(status).is_some()
}

/// The explanation of a status: of a broken connection, all of its causes.
fn reason(status: &Status) -> String {
    let text = std::error::Error::source(status).map_or_else(|| status.message().to_owned(), chain);
    if text.contains("InvalidContentType") { format!("{text}; the server does not use TLS there") } else { text }
}

/// Describes what a failed TLS handshake reports about certificates. rustls has types for this, but
/// its errors arrive as text. Text in the answers of a server is ignored, since it does not
/// describe this connection.
fn certificate(status: &Status) -> Option<String> {
    let reason = if is_ours(status) { bounded(&reason(status)) } else { return None };
    if let Some((_, why)) = reason.split_once("invalid peer certificate: ") {
        let why = match why {
            why if why.starts_with("UnknownIssuer") => "its issuer is not trusted",
            why if why.starts_with("BadSignature") => "its issuer has the name of a trusted authority, but another key",
            why => why,
        };
        return Some(format!("the certificate of the server is not accepted: {why}"));
    }
    let (_, alert) = reason.split_once("received fatal alert: ")?;
    let alert = alert.split(|letter: char| !letter.is_alphanumeric()).next().unwrap_or_default();
    match alert {
        "CertificateRequired" => Some("the server requires a certificate of the client".to_owned()),
        alert if alert.contains("Certificate") || ["UnknownCA", "DecryptError", "AccessDenied"].contains(&alert) => {
            Some(format!("the server does not accept the certificate of the client: {alert}"))
        }
        "InternalError" => None,
        alert => Some(format!("the server ends the TLS handshake: {alert}")),
    }
}

/// An error with all of its causes.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        let cause_text = cause.to_string();
        // Some errors repeat their cause.
        if !text.ends_with(&cause_text) {
            text.push_str(": ");
            text.push_str(&cause_text);
        }
        next = cause.source();
    }
    text
}

/// Maximum length of a text from the server that becomes part of a message.
const MAX_REASON: usize = 2000;

/// The start of a text.
pub(crate) fn bounded(text: &str) -> String {
    text.chars().take(MAX_REASON).collect()
}
