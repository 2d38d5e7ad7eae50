//! Looks up actions in the cache, runs them, and resumes or repeats those whose stream breaks.
//!
//! An action's answer is a stream of its states. If the stream breaks, `WaitExecution` continues
//! it; if the server has forgotten the action, it is requested again, and its result may be in the
//! cache by then.

use std::collections::BTreeMap;
use std::time::Duration;

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use bazel_remote_apis::build::bazel::remote::execution::v2::action_cache_client::ActionCacheClient;
use bazel_remote_apis::build::bazel::remote::execution::v2::execution_client::ExecutionClient;
use bazel_remote_apis::google::longrunning::{Operation, operation};
use prost::Message as _;
use tokio::time::Instant;
use tonic::{Code, Status};

use crate::client::{MAX_MESSAGE, backoff};
use crate::error::{bounded, is_transient};
use crate::{Action, Blob, Client, Digest, RemoteError};

/// Maximum number of output files.
const MAX_OUTPUTS: usize = 1 << 16;

/// Number of bytes kept from the end of standard error, which states what went wrong.
const MAX_ERROR_BYTES: usize = 1 << 12;

/// How often an action is requested again after its inputs have vanished from the store, or the
/// server has forgotten it.
const MAX_REPEATS: u32 = 3;

/// Duration above which an attempt does not count as failed: proxies end streams that live long.
const LONG_ATTEMPT: Duration = Duration::from_secs(20);

/// Result of an action.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Its output files, by their paths.
    pub files: BTreeMap<String, OutputFile>,
    /// Exit code of the command.
    pub exit_code: i32,
    /// The end of its standard error, if the server sent it.
    pub stderr: String,
    /// Whether it comes from the cache.
    pub is_cached: bool,
}

/// An output file.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Its name in the store.
    pub digest: Digest,
    /// Its bytes, if the server sent them along.
    pub contents: Option<Vec<u8>>,
}

impl Client {
    /// The result of an action in the action cache. `inline` are the paths of small outputs that
    /// the server may send along.
    ///
    /// # Errors
    /// The server cannot be reached, or sends an invalid answer.
    pub fn look_up(&self, action: &Digest, inline: &[String]) -> Result<Option<Outcome>, RemoteError> {
        let request = api::GetActionResultRequest {
            instance_name: self.settings.instance.clone(),
            action_digest: Some(action.message()),
            inline_output_files: inline.to_vec(),
            digest_function: api::digest_function::Value::Sha256 as i32,
            ..api::GetActionResultRequest::default()
        };
        let found = self.block_on(self.retry("action cache", 0, || {
            let mut client = ActionCacheClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE);
            let request = self.request(request.clone());
            async move {
                match client.get_action_result(request).await {
                    Ok(found) => Ok(found.map(Some)),
                    Err(status) if status.code() == Code::NotFound => Ok(tonic::Response::new(None)),
                    Err(status) => Err(status),
                }
            }
        }))?;
        found.map(|result| outcome(result, true)).transpose()
    }

    /// Uploads the inputs of an action, runs it on a worker, and waits for its result. With
    /// `again`, a result in the cache does not count.
    ///
    /// # Errors
    /// The server cannot be reached in spite of all retries, rejects the action, takes longer than
    /// the settings allow, or sends an invalid answer. A command that fails is not an error: see
    /// [`Outcome::exit_code`].
    pub fn execute(&self, action: &Action, again: bool) -> Result<Outcome, RemoteError> {
        let deadline = Instant::now() + self.settings.action_timeout;
        let mut repeats = 0;
        loop {
            let blobs: Vec<&Blob> = action.messages.iter().chain(&action.inputs).collect();
            self.upload(&blobs)?;
            match self.block_on(self.run(&action.digest, again, deadline)) {
                // An input has vanished between upload and start.
                Err(RemoteError::Missing(_)) if repeats < MAX_REPEATS => repeats += 1,
                result => return result,
            }
        }
    }

    /// Adds a result to the action cache: files by their paths, of an action that ended with exit
    /// code 0.
    ///
    /// # Errors
    /// The server cannot be reached, or does not let this client write.
    pub fn publish(&self, action: &Action, files: &[(String, Blob)]) -> Result<(), RemoteError> {
        let blobs: Vec<&Blob> = action.messages.iter().chain(files.iter().map(|(_, blob)| blob)).collect();
        self.upload(&blobs)?;
        let file = |(path, blob): &(String, Blob)| api::OutputFile {
            path: path.clone(),
            digest: Some(blob.digest.message()),
            ..api::OutputFile::default()
        };
        let mut output_files: Vec<api::OutputFile> = files.iter().map(file).collect();
        output_files.sort_by(|a, b| a.path.cmp(&b.path));
        let request = api::UpdateActionResultRequest {
            instance_name: self.settings.instance.clone(),
            action_digest: Some(action.digest.message()),
            action_result: Some(api::ActionResult { output_files, ..api::ActionResult::default() }),
            digest_function: api::digest_function::Value::Sha256 as i32,
            ..api::UpdateActionResultRequest::default()
        };
        let call = self.retry("action cache", 0, || {
            let mut client = ActionCacheClient::new(self.channel.clone()).max_encoding_message_size(MAX_MESSAGE);
            let request = self.request(request.clone());
            async move { client.update_action_result(request).await }
        });
        self.block_on(call).map(drop)
    }

    /// Requests an action that the server has the inputs of, and follows it to its end.
    async fn run(&self, action: &Digest, again: bool, deadline: Instant) -> Result<Outcome, RemoteError> {
        let (mut name, mut forgotten) = (None, 0);
        let mut failures = Failures { count: 0, limit: self.settings.attempts };
        loop {
            let follows = name.is_some();
            let start = Instant::now();
            let followed = tokio::time::timeout_at(deadline, self.follow(action, again, &mut name)).await;
            failures.add(start.elapsed());
            let late = || Status::deadline_exceeded("the action did not end in time");
            match followed.unwrap_or_else(|_| Err(late())) {
                Ok(Some(done)) => match finished(done)? {
                    Ok(outcome) => return Ok(outcome),
                    Err(status) if is_missing(&status) => return Err(RemoteError::Missing(bounded(status.message()))),
                    Err(status) if is_transient(&status) && failures.allow_another() => name = None,
                    Err(status) => return Err(RemoteError::from_status("action", &status)),
                },
                // The stream ended too early: follow it again.
                Ok(None) if failures.allow_another() => {}
                Ok(None) => {
                    return Err(RemoteError::from_status("action", &Status::unavailable("the answer broke off")));
                }
                Err(status) if Instant::now() >= deadline => return Err(RemoteError::from_status("action", &status)),
                // The server was restarted, and has forgotten the action.
                Err(status) if follows && status.code() == Code::NotFound && forgotten < MAX_REPEATS => {
                    forgotten += 1;
                    name = None;
                }
                Err(status) if is_missing(&status) => return Err(RemoteError::Missing(bounded(status.message()))),
                Err(status) if is_transient(&status) && failures.allow_another() => {}
                Err(status) => return Err(RemoteError::from_status("action", &status)),
            }
            tokio::time::sleep(backoff(failures.count)).await;
        }
    }

    /// Requests an action, or follows the one with this name, until it is done or the stream ends.
    async fn follow(
        &self,
        action: &Digest,
        again: bool,
        name: &mut Option<String>,
    ) -> Result<Option<Operation>, Status> {
        let mut client = ExecutionClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE);
        // The answer to the request itself; the action may take longer.
        let limit: Duration = self.settings.request_timeout;
        let late = |_| Status::deadline_exceeded("no answer in time");
        let stream = match name.clone() {
            Some(name) => {
                let request = self.request(api::WaitExecutionRequest { name });
                tokio::time::timeout(limit, client.wait_execution(request)).await.map_err(late)??
            }
            None => {
                let request = self.request(api::ExecuteRequest {
                    instance_name: self.settings.instance.clone(),
                    action_digest: Some(action.message()),
                    digest_function: api::digest_function::Value::Sha256 as i32,
                    inline_stderr: true,
                    skip_cache_lookup: again,
                    ..api::ExecuteRequest::default()
                });
                tokio::time::timeout(limit, client.execute(request)).await.map_err(late)??
            }
        };
        let mut stream = stream.into_inner();
        while let Some(state) = stream.message().await? {
            if state.done {
                return Ok(Some(state));
            }
            if !state.name.is_empty() {
                *name = Some(state.name);
            }
        }
        Ok(None)
    }
}

/// Failed attempts in a row to follow an action to its end.
struct Failures {
    count: u32,
    /// Number of attempts that may fail in a row.
    limit: u32,
}

impl Failures {
    /// Adds an attempt that took this long. A long one starts the count anew. The deadline of the
    /// action bounds the number of these.
    fn add(&mut self, elapsed: Duration) {
        self.count = if elapsed > LONG_ATTEMPT { 0 } else { self.count + 1 };
    }

    fn allow_another(&self) -> bool {
        self.count < self.limit
    }
}

/// Whether a status says that an input is not in the store.
fn is_missing(status: &Status) -> bool {
    status.code() == Code::FailedPrecondition
}

/// The result of an action that is done, or the reason why it did not run.
fn finished(done: Operation) -> Result<Result<Outcome, Status>, RemoteError> {
    let status = |code: i32, message: &str| Status::new(Code::from_i32(code), bounded(message));
    let response = match done.result {
        Some(operation::Result::Response(response)) => response,
        Some(operation::Result::Error(error)) => return Ok(Err(status(error.code, &error.message))),
        None => return Err(RemoteError::Invalid("an action is done, but has no result".to_owned())),
    };
    let response = api::ExecuteResponse::decode(&response.value[..])
        .map_err(|error| RemoteError::Invalid(format!("the result of an action: {error}")))?;
    if let Some(error) = response.status.filter(|status| status.code != 0) {
        return Ok(Err(status(error.code, &error.message)));
    }
    let result = response.result.ok_or_else(|| RemoteError::Invalid("an action has no result".to_owned()))?;
    outcome(result, response.cached_result).map(Ok)
}

fn outcome(result: api::ActionResult, is_cached: bool) -> Result<Outcome, RemoteError> {
    if result.output_files.len() > MAX_OUTPUTS {
        return Err(RemoteError::Invalid(format!("an action has more than {MAX_OUTPUTS} outputs")));
    }
    let mut files = BTreeMap::new();
    for file in result.output_files {
        let digest = Digest::read(file.digest.as_ref())?;
        // Bytes that do not have the digest are fetched, which fails if there are no others.
        let contents = Some(file.contents).filter(|bytes| !bytes.is_empty() && Digest::from_bytes(bytes) == digest);
        files.insert(file.path, OutputFile { digest, contents });
    }
    let start = result.stderr_raw.len().saturating_sub(MAX_ERROR_BYTES);
    let stderr = result.stderr_raw.get(start..).unwrap_or_default();
    let stderr = String::from_utf8_lossy(stderr).into_owned();
    Ok(Outcome { files, exit_code: result.exit_code, stderr, is_cached })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last attempt failed however long its stream had lived.
    #[test]
    fn end_of_a_long_stream_is_not_a_failed_last_attempt() {
        let short = LONG_ATTEMPT / 2;
        let long = LONG_ATTEMPT * 2;
        let mut failures = Failures { count: 0, limit: 3 };
        let mut add = |elapsed| {
            failures.add(elapsed);
            failures.allow_another()
        };
        assert_eq!([short, short, long].map(&mut add), [true; 3]);
        assert_eq!([short, short, short].map(&mut add), [true, true, false]);
        let mut only = Failures { count: 0, limit: 1 };
        only.add(long);
        assert!(only.allow_another());
        only.add(short);
        assert!(!only.allow_another());
    }
}
