//! The connection to a server, what the server can do, and requests with retries. Actions in
//! progress are resumed in `execution.rs`.

use std::future::Future;
use std::time::Duration;

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use bazel_remote_apis::build::bazel::remote::execution::v2::capabilities_client::CapabilitiesClient;
use tokio::runtime::Runtime;
use tonic::metadata::{AsciiMetadataKey, AsciiMetadataValue};
use tonic::transport::Endpoint;
use tonic::{Request, Response, Status};

use crate::error::{chain, is_transient};
use crate::strip_header::StripHeader;
use crate::{RemoteError, Settings};

/// Time to connect.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);

/// Interval of HTTP/2 keep-alive pings, and the timeout for the answer to one.
const KEEP_ALIVE: Duration = Duration::from_secs(30);

/// Wait before the second attempt; it doubles with each attempt.
const FIRST_WAIT: Duration = Duration::from_millis(200);

/// Maximum wait between two attempts.
const MAX_WAIT: Duration = Duration::from_secs(10);

/// Maximum size of a message in bytes, in either direction.
pub(crate) const MAX_MESSAGE: usize = 16 << 20;

/// Bytes of blobs in one request, if the server allows more: messages of 4 MiB are the default
/// limit of gRPC, and names and digests need some of it.
const MAX_BATCH: u64 = 3 << 20;

/// Bytes a second that a transfer must reach on average.
const MIN_RATE: u64 = 64 << 10;

/// Threads that do the network's work.
const THREADS: usize = 2;

/// A client of one server.
#[derive(Debug)]
pub struct Client {
    runtime: Runtime,
    pub(crate) channel: StripHeader,
    pub(crate) settings: Settings,
    headers: Vec<(AsciiMetadataKey, AsciiMetadataValue)>,
    capabilities: Capabilities,
}

/// What a server states in its `ServerCapabilities`.
#[derive(Clone, Copy, Debug)]
struct Capabilities {
    executes: bool,
    takes_results: bool,
    /// Maximum bytes of blobs in one request.
    batch: u64,
    /// Maximum size of a blob.
    blob: u64,
}

impl Client {
    /// Connects, and requests what the server can do.
    ///
    /// # Errors
    /// The server cannot be reached, does not know the instance, or does not use SHA-256; or a
    /// header or certificate is wrong.
    pub fn connect(settings: Settings) -> Result<Self, RemoteError> {
        let headers = settings.headers.iter().map(header).collect::<Result<_, _>>()?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(THREADS)
            .enable_all()
            .build()
            .map_err(|error| RemoteError::Settings(format!("cannot start threads: {error}")))?;
        // The connection spawns tasks.
        let channel = {
            let _entered = runtime.enter();
            StripHeader(endpoint(&settings)?.connect_lazy())
        };
        let capabilities = Capabilities { executes: false, takes_results: false, batch: MAX_BATCH, blob: u64::MAX };
        let mut client = Self { runtime, channel, settings, headers, capabilities };
        let uses_tls = client.settings.address.uses_tls();
        client.capabilities =
            client.block_on(client.request_capabilities()).map_err(|error| error.at_start(uses_tls))?;
        Ok(client)
    }

    /// Whether the server runs actions.
    pub fn executes(&self) -> bool {
        self.capabilities.executes
    }

    /// Whether clients may add results to the action cache.
    pub fn takes_results(&self) -> bool {
        self.capabilities.takes_results
    }

    /// Maximum bytes of blobs in one request.
    pub(crate) fn max_batch(&self) -> u64 {
        self.capabilities.batch
    }

    /// Maximum size of a blob.
    pub(crate) fn max_blob(&self) -> u64 {
        self.capabilities.blob
    }

    async fn request_capabilities(&self) -> Result<Capabilities, RemoteError> {
        let request = api::GetCapabilitiesRequest { instance_name: self.settings.instance.clone() };
        let found = self
            .retry("capabilities", 0, || {
                let mut client = CapabilitiesClient::new(self.channel.clone());
                let request = self.request(request.clone());
                async move { client.get_capabilities(request).await }
            })
            .await?;
        let lacking = |what: &str| RemoteError::Settings(format!("the server {what}, so it cannot be used"));
        let cache = found.cache_capabilities.ok_or_else(|| lacking("has no cache"))?;
        let sha_256 = api::digest_function::Value::Sha256 as i32;
        if !cache.digest_functions.contains(&sha_256) {
            return Err(lacking("does not use SHA-256"));
        }
        let executes = found.execution_capabilities.is_some_and(|execution| {
            let known = execution.digest_functions.contains(&sha_256) || execution.digest_function == sha_256;
            execution.exec_enabled && known
        });
        // 0 stands for no limit.
        let limit = |bytes: i64| u64::try_from(bytes).ok().filter(|&bytes| bytes > 0).unwrap_or(u64::MAX);
        Ok(Capabilities {
            executes,
            takes_results: cache.action_cache_update_capabilities.is_some_and(|can| can.update_enabled),
            batch: limit(cache.max_batch_total_size_bytes).min(MAX_BATCH),
            blob: limit(cache.max_cas_blob_size_bytes),
        })
    }

    /// Waits for a future.
    pub(crate) fn block_on<T>(&self, future: impl Future<Output = T>) -> T {
        self.runtime.block_on(future)
    }

    /// A request with the headers.
    pub(crate) fn request<T>(&self, message: T) -> Request<T> {
        let mut request = Request::new(message);
        for (name, value) in &self.headers {
            request.metadata_mut().insert(name.clone(), value.clone());
        }
        request
    }

    /// Makes a request until it is answered, rejected, or was tried often enough. `bytes` is the
    /// size of what it transfers, if that is large.
    pub(crate) async fn retry<T, F>(
        &self,
        what: &'static str,
        bytes: u64,
        call: impl Fn() -> F,
    ) -> Result<T, RemoteError>
    where
        F: Future<Output = Result<Response<T>, Status>>,
    {
        let (usual, longest) = (self.settings.request_timeout, self.settings.action_timeout);
        let limit = usual.saturating_add(Duration::from_secs(bytes / MIN_RATE)).min(longest.max(usual));
        let mut attempt = 1;
        loop {
            let status = match tokio::time::timeout(limit, call()).await {
                Ok(Ok(response)) => return Ok(response.into_inner()),
                Ok(Err(status)) => status,
                Err(_) => Status::deadline_exceeded("no answer in time"),
            };
            if !is_transient(&status) || attempt >= self.settings.attempts {
                return Err(RemoteError::from_status(what, &status));
            }
            tokio::time::sleep(backoff(attempt)).await;
            attempt += 1;
        }
    }
}

/// Wait after an attempt, counted from 1.
pub(crate) fn backoff(attempt: u32) -> Duration {
    FIRST_WAIT.saturating_mul(2_u32.saturating_pow(attempt.saturating_sub(1))).min(MAX_WAIT)
}

fn header((name, value): &(String, String)) -> Result<(AsciiMetadataKey, AsciiMetadataValue), RemoteError> {
    // The value may be a secret.
    let wrong = || RemoteError::Settings(format!("header `{}`: its name or value is invalid", name.escape_debug()));
    let key = AsciiMetadataKey::from_bytes(name.to_lowercase().as_bytes()).map_err(|_| wrong())?;
    let mut value: AsciiMetadataValue = value.parse().map_err(|_| wrong())?;
    // Then it is in no log, and in no table of compressed headers.
    value.set_sensitive(true);
    Ok((key, value))
}

fn endpoint(settings: &Settings) -> Result<Endpoint, RemoteError> {
    let address = &settings.address;
    let wrong = |error: tonic::transport::Error| RemoteError::Settings(format!("{address}: {}", chain(&error)));
    let endpoint = Endpoint::from_shared(address.uri())
        .map_err(wrong)?
        .connect_timeout(CONNECT_TIMEOUT)
        .tcp_nodelay(true)
        .http2_keep_alive_interval(KEEP_ALIVE)
        .keep_alive_timeout(KEEP_ALIVE)
        .http2_adaptive_window(true);
    if !address.uses_tls() {
        if settings.certificates.is_some() || settings.identity.is_some() {
            return Err(RemoteError::Settings(format!(
                "{address}: certificates have no effect without TLS; use grpcs://"
            )));
        }
        return Ok(endpoint);
    }
    #[cfg(feature = "tls")]
    {
        use tonic::transport::{Certificate, ClientTlsConfig};

        use crate::Identity;

        let tls = match &settings.certificates {
            Some(pem) => ClientTlsConfig::new().ca_certificate(Certificate::from_pem(pem)),
            None => ClientTlsConfig::new().with_native_roots(),
        };
        let tls = match &settings.identity {
            Some(Identity { certificate, key }) => tls.identity(tonic::transport::Identity::from_pem(certificate, key)),
            None => tls,
        };
        endpoint.tls_config(tls).map_err(wrong)
    }
    #[cfg(not(feature = "tls"))]
    Err(RemoteError::Settings(format!("{address}: this program was built without TLS; use grpc://")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_up_to_a_limit() {
        let waits: Vec<u128> = [1, 2, 3, 6, 7, u32::MAX].map(|attempt| backoff(attempt).as_millis()).to_vec();
        assert_eq!(waits, [200, 400, 800, 6400, 10_000, 10_000]);
    }

    #[test]
    fn headers_are_checked_and_their_values_never_shown() {
        assert!(header(&("Authorization".to_owned(), "Bearer x".to_owned())).is_ok());
        for (name, value) in [("a b", "x"), ("", "x"), ("a", "secret\n")] {
            let error = header(&(name.to_owned(), value.to_owned())).unwrap_err().to_string();
            assert!(!error.contains("secret"), "{error}");
        }
    }
}
