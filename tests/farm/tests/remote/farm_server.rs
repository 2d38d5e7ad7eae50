//! A farm in this process: a slow, obvious server of the Remote Execution API, which keeps
//! everything in maps and runs actions one after the other in temporary folders.
//!
//! It can misbehave on purpose, to test what a client does about it.

use std::collections::{BTreeMap, HashMap};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::process::Command;
use std::sync::{Arc, Mutex};

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use bazel_remote_apis::build::bazel::remote::execution::v2::action_cache_server::{ActionCache, ActionCacheServer};
use bazel_remote_apis::build::bazel::remote::execution::v2::capabilities_server::{Capabilities, CapabilitiesServer};
use bazel_remote_apis::build::bazel::remote::execution::v2::content_addressable_storage_server::{
    ContentAddressableStorage, ContentAddressableStorageServer,
};
use bazel_remote_apis::build::bazel::remote::execution::v2::execution_server::{Execution, ExecutionServer};
use bazel_remote_apis::google::bytestream as stream;
use bazel_remote_apis::google::bytestream::byte_stream_server::{ByteStream, ByteStreamServer};
use bazel_remote_apis::google::longrunning::{Operation, operation};
use bazel_remote_apis::google::protobuf::Any;
use bazel_remote_apis::google::rpc;
use prost::Message;
use sha2::{Digest as _, Sha256};
use tokio::sync::oneshot;
use tokio_stream::Stream;
use tokio_stream::wrappers::TcpListenerStream;
use tonic::codegen::http::HeaderMap;
use tonic::metadata::MetadataMap;
use tonic::transport::{Certificate, Identity, ServerTlsConfig};
use tonic::{Code, Request, Response, Status, Streaming};

/// Behaviour and counters of the server.
#[derive(Debug, Default)]
pub struct State {
    /// Blobs by their hashes.
    pub blobs: HashMap<String, Vec<u8>>,
    /// Results by the hashes of actions.
    pub results: HashMap<String, api::ActionResult>,
    /// Number of requests by their names.
    pub requests: BTreeMap<&'static str, usize>,
    /// Actions that were run.
    pub runs: usize,
    /// Whether actions can be run.
    pub executes: bool,
    /// Answer this many further requests with "unavailable".
    pub failures: usize,
    /// Break off this many streams of actions.
    pub broken_streams: usize,
    /// Headers of the last request.
    pub headers: BTreeMap<String, String>,
    /// Attack that it makes.
    pub fault: Option<Fault>,
    /// A file that is overwritten while a result is looked up, and its new contents.
    pub edit: Option<(PathBuf, String)>,
}

/// Attack of a hostile server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Downloads repeat these bytes for ever; if there are none, they never begin.
    EndlessBlob(Vec<u8>),
    /// Actions begin again and again.
    EndlessAction,
    /// The details of "no result" are not Base64.
    BrokenDetails,
    /// Every answer about missing blobs has more than 16 MiB.
    HugeAnswer,
}

/// Certificates and a private key, all in PEM format.
#[derive(Debug)]
pub struct Tls {
    /// The server's certificate.
    pub certificate: String,
    pub key: String,
    /// Authority that signs client certificates; `None`: clients need none.
    pub clients: Option<String>,
}

impl State {
    fn count(&mut self, name: &'static str, headers: &tonic::metadata::MetadataMap) -> Result<(), Status> {
        *self.requests.entry(name).or_default() += 1;
        self.headers = headers
            .iter()
            .filter_map(|pair| match pair {
                tonic::metadata::KeyAndValueRef::Ascii(key, value) => {
                    Some((key.to_string(), value.to_str().unwrap_or_default().to_owned()))
                }
                tonic::metadata::KeyAndValueRef::Binary(..) => None,
            })
            .collect();
        if self.failures > 0 {
            self.failures -= 1;
            return Err(Status::unavailable("on purpose"));
        }
        Ok(())
    }

    fn blob(&self, digest: Option<&api::Digest>) -> Result<Vec<u8>, Status> {
        let hash = &digest.ok_or_else(|| Status::invalid_argument("no digest"))?.hash;
        let missing = || Status::failed_precondition(format!("blob {hash} is missing"));
        self.blobs.get(hash).cloned().ok_or_else(missing)
    }

    /// Stores a blob and returns its digest.
    pub fn put(&mut self, bytes: Vec<u8>) -> api::Digest {
        let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let digest = api::Digest { hash: hash.clone(), size_bytes: bytes.len() as i64 };
        self.blobs.insert(hash, bytes);
        digest
    }
}

/// A running server. Dropping it stops it.
#[derive(Debug)]
pub struct FarmServer {
    /// Where it listens.
    pub address: SocketAddr,
    /// Behaviour and counters.
    pub state: Arc<Mutex<State>>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl FarmServer {
    /// Starts a server on a free port of this machine. Panics if it cannot be started.
    pub fn start() -> Self {
        Self::start_with(None)
    }

    /// [`start`](Self::start); with certificates, for TLS only.
    pub fn start_with(tls: Option<Tls>) -> Self {
        let state = Arc::new(Mutex::new(State { executes: true, ..State::default() }));
        let (stop, stopped) = oneshot::channel::<()>();
        let (sender, receiver) = std::sync::mpsc::channel();
        let own = state.clone();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("threads start");
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.expect("a port is free");
                sender.send(listener.local_addr().expect("it has an address")).expect("the starter waits");
                let farm = Farm(own);
                let limit = 64 << 20;
                let mut server = tonic::transport::Server::builder();
                if let Some(Tls { certificate, key, clients }) = tls {
                    let config = ServerTlsConfig::new().identity(Identity::from_pem(certificate, key));
                    let config = match clients {
                        Some(pem) => config.client_ca_root(Certificate::from_pem(pem)),
                        None => config,
                    };
                    server = server.tls_config(config).expect("the certificates are right");
                }
                let server = server
                    .add_service(CapabilitiesServer::new(farm.clone()))
                    .add_service(ActionCacheServer::new(farm.clone()))
                    .add_service(
                        ContentAddressableStorageServer::new(farm.clone())
                            .max_decoding_message_size(limit)
                            .max_encoding_message_size(limit),
                    )
                    .add_service(ByteStreamServer::new(farm.clone()))
                    .add_service(ExecutionServer::new(farm));
                let stopped = async { drop(stopped.await) };
                server
                    .serve_with_incoming_shutdown(TcpListenerStream::new(listener), stopped)
                    .await
                    .expect("it serves");
            });
        });
        let address = receiver.recv().expect("the server starts");
        Self { address, state, stop: Some(stop), thread: Some(thread) }
    }

    /// Its address for `--remote`.
    pub fn url(&self) -> String {
        format!("grpc://{}", self.address)
    }

    /// Number of requests with this name so far. Panics if the server panicked.
    pub fn requests(&self, name: &str) -> usize {
        self.state.lock().expect("no panic").requests.get(name).copied().unwrap_or_default()
    }
}

impl Drop for FarmServer {
    fn drop(&mut self) {
        // Open connections keep a graceful server waiting, so its thread is left behind.
        drop(self.stop.take());
        drop(self.thread.take());
    }
}

type Answers<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

#[derive(Clone)]
struct Farm(Arc<Mutex<State>>);

impl Farm {
    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.0.lock().expect("no panic")
    }
}

fn ok() -> Option<rpc::Status> {
    Some(rpc::Status::default())
}

fn status(code: i32, message: &str) -> Option<rpc::Status> {
    Some(rpc::Status { code, message: message.to_owned(), details: Vec::new() })
}

#[tonic::async_trait]
impl Capabilities for Farm {
    async fn get_capabilities(
        &self,
        request: Request<api::GetCapabilitiesRequest>,
    ) -> Result<Response<api::ServerCapabilities>, Status> {
        let mut state = self.state();
        state.count("GetCapabilities", request.metadata())?;
        let sha_256 = api::digest_function::Value::Sha256 as i32;
        Ok(Response::new(api::ServerCapabilities {
            cache_capabilities: Some(api::CacheCapabilities {
                digest_functions: vec![sha_256],
                action_cache_update_capabilities: Some(api::ActionCacheUpdateCapabilities { update_enabled: true }),
                max_batch_total_size_bytes: 100_000,
                ..Default::default()
            }),
            execution_capabilities: Some(api::ExecutionCapabilities {
                digest_function: sha_256,
                exec_enabled: state.executes,
                ..Default::default()
            }),
            ..Default::default()
        }))
    }
}

#[tonic::async_trait]
impl ActionCache for Farm {
    async fn get_action_result(
        &self,
        request: Request<api::GetActionResultRequest>,
    ) -> Result<Response<api::ActionResult>, Status> {
        let mut state = self.state();
        state.count("GetActionResult", request.metadata())?;
        if let Some((path, text)) = state.edit.take() {
            std::fs::write(path, text).expect("the file can be written");
        }
        let hash = request.into_inner().action_digest.unwrap_or_default().hash;
        let missing = || match state.fault {
            Some(Fault::BrokenDetails) => {
                let mut headers = HeaderMap::new();
                headers.insert("grpc-status-details-bin", "no Base64!".parse().expect("a header"));
                Status::with_metadata(Code::NotFound, "no result", MetadataMap::from_headers(headers))
            }
            _ => Status::not_found("no result"),
        };
        state.results.get(&hash).cloned().map(Response::new).ok_or_else(missing)
    }

    async fn update_action_result(
        &self,
        request: Request<api::UpdateActionResultRequest>,
    ) -> Result<Response<api::ActionResult>, Status> {
        let mut state = self.state();
        state.count("UpdateActionResult", request.metadata())?;
        let request = request.into_inner();
        let result = request.action_result.unwrap_or_default();
        for file in &result.output_files {
            state.blob(file.digest.as_ref())?;
        }
        state.results.insert(request.action_digest.unwrap_or_default().hash, result.clone());
        Ok(Response::new(result))
    }
}

#[tonic::async_trait]
impl ContentAddressableStorage for Farm {
    async fn find_missing_blobs(
        &self,
        request: Request<api::FindMissingBlobsRequest>,
    ) -> Result<Response<api::FindMissingBlobsResponse>, Status> {
        let mut state = self.state();
        state.count("FindMissingBlobs", request.metadata())?;
        let mut digests = request.into_inner().blob_digests;
        if state.fault == Some(Fault::HugeAnswer) {
            digests = vec![api::Digest { hash: "0".repeat(64), size_bytes: 1 }; 300_000];
        }
        let missing_blob_digests =
            digests.into_iter().filter(|digest| !state.blobs.contains_key(&digest.hash)).collect();
        Ok(Response::new(api::FindMissingBlobsResponse { missing_blob_digests }))
    }

    async fn batch_update_blobs(
        &self,
        request: Request<api::BatchUpdateBlobsRequest>,
    ) -> Result<Response<api::BatchUpdateBlobsResponse>, Status> {
        let mut state = self.state();
        state.count("BatchUpdateBlobs", request.metadata())?;
        let mut responses = Vec::new();
        for blob in request.into_inner().requests {
            let stored = state.put(blob.data);
            let is_right = blob.digest.as_ref() == Some(&stored);
            let status = if is_right { ok() } else { status(3, "wrong digest") };
            responses.push(api::batch_update_blobs_response::Response { digest: blob.digest, status });
        }
        Ok(Response::new(api::BatchUpdateBlobsResponse { responses }))
    }

    async fn batch_read_blobs(
        &self,
        request: Request<api::BatchReadBlobsRequest>,
    ) -> Result<Response<api::BatchReadBlobsResponse>, Status> {
        let mut state = self.state();
        state.count("BatchReadBlobs", request.metadata())?;
        let read = |digest: api::Digest| match state.blobs.get(&digest.hash) {
            Some(data) => api::batch_read_blobs_response::Response {
                digest: Some(digest),
                data: data.clone(),
                status: ok(),
                compressor: 0,
            },
            None => api::batch_read_blobs_response::Response {
                digest: Some(digest),
                status: status(5, "missing"),
                ..Default::default()
            },
        };
        let responses = request.into_inner().digests.into_iter().map(read).collect();
        Ok(Response::new(api::BatchReadBlobsResponse { responses }))
    }

    type GetTreeStream = tokio_stream::Empty<Result<api::GetTreeResponse, Status>>;

    async fn get_tree(&self, _: Request<api::GetTreeRequest>) -> Result<Response<Self::GetTreeStream>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }

    async fn split_blob(&self, _: Request<api::SplitBlobRequest>) -> Result<Response<api::SplitBlobResponse>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }

    async fn splice_blob(
        &self,
        _: Request<api::SpliceBlobRequest>,
    ) -> Result<Response<api::SpliceBlobResponse>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }

    type GetChunkMappingStream = tokio_stream::Empty<Result<api::GetChunkMappingResponse, Status>>;

    async fn get_chunk_mapping(
        &self,
        _: Request<api::GetChunkMappingRequest>,
    ) -> Result<Response<Self::GetChunkMappingStream>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }

    async fn register_chunk_mapping(
        &self,
        _: Request<Streaming<api::RegisterChunkMappingRequest>>,
    ) -> Result<Response<api::RegisterChunkMappingResponse>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }
}

#[tonic::async_trait]
impl ByteStream for Farm {
    type ReadStream = Answers<stream::ReadResponse>;

    async fn read(&self, request: Request<stream::ReadRequest>) -> Result<Response<Self::ReadStream>, Status> {
        let mut state = self.state();
        state.count("Read", request.metadata())?;
        if let Some(Fault::EndlessBlob(data)) = state.fault.clone() {
            if data.is_empty() {
                return Ok(Response::new(Box::pin(tokio_stream::pending())));
            }
            let endless = std::iter::repeat_with(move || Ok(stream::ReadResponse { data: data.clone() }));
            return Ok(Response::new(Box::pin(tokio_stream::iter(endless))));
        }
        let name = request.into_inner().resource_name;
        let hash = name.split('/').rev().nth(1).unwrap_or_default();
        let bytes = state.blobs.get(hash).ok_or_else(|| Status::not_found("missing"))?;
        let chunks: Vec<_> =
            bytes.chunks(50_000).map(|data| Ok(stream::ReadResponse { data: data.to_vec() })).collect();
        Ok(Response::new(Box::pin(tokio_stream::iter(chunks))))
    }

    async fn write(
        &self,
        request: Request<Streaming<stream::WriteRequest>>,
    ) -> Result<Response<stream::WriteResponse>, Status> {
        self.state().count("Write", request.metadata())?;
        let mut messages = request.into_inner();
        let (mut bytes, mut name, mut is_finished) = (Vec::new(), String::new(), false);
        while let Some(message) = messages.message().await? {
            if message.write_offset != bytes.len() as i64 {
                return Err(Status::invalid_argument("wrong offset"));
            }
            name = message.resource_name;
            bytes.extend(message.data);
            is_finished |= message.finish_write;
        }
        let committed_size = bytes.len() as i64;
        let digest = self.state().put(bytes);
        if !is_finished || !name.ends_with(&format!("/blobs/{}/{committed_size}", digest.hash)) {
            return Err(Status::invalid_argument("wrong name, or not finished"));
        }
        Ok(Response::new(stream::WriteResponse { committed_size }))
    }

    async fn query_write_status(
        &self,
        _: Request<stream::QueryWriteStatusRequest>,
    ) -> Result<Response<stream::QueryWriteStatusResponse>, Status> {
        Err(Status::unimplemented("no client needs it"))
    }
}

#[tonic::async_trait]
impl Execution for Farm {
    type ExecuteStream = Answers<Operation>;
    type WaitExecutionStream = Self::ExecuteStream;

    async fn execute(&self, request: Request<api::ExecuteRequest>) -> Result<Response<Self::ExecuteStream>, Status> {
        let mut state = self.state();
        state.count("Execute", request.metadata())?;
        let digest = request.into_inner().action_digest.unwrap_or_default();
        // The name is all that a client needs to follow it.
        let name = format!("operations/{}", digest.hash);
        let begun = Operation { name: name.clone(), ..Operation::default() };
        if state.broken_streams > 0 {
            state.broken_streams -= 1;
            return Ok(Response::new(Box::pin(tokio_stream::iter([Ok(begun)]))));
        }
        if state.fault == Some(Fault::EndlessAction) {
            return Ok(Response::new(Box::pin(tokio_stream::iter(std::iter::repeat_with(move || Ok(begun.clone()))))));
        }
        let done = run(&mut state, &digest, name);
        Ok(Response::new(Box::pin(tokio_stream::iter([Ok(begun), Ok(done)]))))
    }

    async fn wait_execution(
        &self,
        request: Request<api::WaitExecutionRequest>,
    ) -> Result<Response<Self::WaitExecutionStream>, Status> {
        let mut state = self.state();
        state.count("WaitExecution", request.metadata())?;
        let name = request.into_inner().name;
        let hash = name.strip_prefix("operations/").ok_or_else(|| Status::not_found("unknown"))?;
        let digest = api::Digest { hash: hash.to_owned(), size_bytes: 0 };
        let done = run(&mut state, &digest, name.clone());
        Ok(Response::new(Box::pin(tokio_stream::iter([Ok(done)]))))
    }
}

/// Runs an action to its end.
fn run(state: &mut State, digest: &api::Digest, name: String) -> Operation {
    let response = match perform(state, digest) {
        Ok(result) => {
            if result.exit_code == 0 {
                state.results.insert(digest.hash.clone(), result.clone());
            }
            api::ExecuteResponse { result: Some(result), status: ok(), ..Default::default() }
        }
        Err(error) => {
            api::ExecuteResponse { status: status(error.code() as i32, error.message()), ..Default::default() }
        }
    };
    let type_url = "type.googleapis.com/build.bazel.remote.execution.v2.ExecuteResponse".to_owned();
    let response = Any { type_url, value: response.encode_to_vec() };
    Operation { name, done: true, result: Some(operation::Result::Response(response)), ..Default::default() }
}

fn perform(state: &mut State, digest: &api::Digest) -> Result<api::ActionResult, Status> {
    let invalid = |error: prost::DecodeError| Status::invalid_argument(error.to_string());
    let failed = |error: std::io::Error| Status::internal(error.to_string());
    let action = api::Action::decode(&state.blob(Some(digest))?[..]).map_err(invalid)?;
    let command = api::Command::decode(&state.blob(action.command_digest.as_ref())?[..]).map_err(invalid)?;
    let folder = tempfile::tempdir().map_err(failed)?;
    lay_out(state, action.input_root_digest.as_ref(), folder.path())?;
    for path in &command.output_paths {
        let parent = folder.path().join(path);
        std::fs::create_dir_all(parent.parent().expect("below the folder")).map_err(failed)?;
    }
    state.runs += 1;
    // A relative program is found in the folder.
    let program = &command.arguments[0];
    let program = if program.contains('/') { folder.path().join(program).into_os_string() } else { program.into() };
    let run = Command::new(program)
        .args(&command.arguments[1..])
        .envs(command.environment_variables.iter().map(|variable| (&variable.name, &variable.value)))
        .current_dir(folder.path())
        .output()
        .map_err(failed)?;
    let mut output_files = Vec::new();
    for path in &command.output_paths {
        if let Ok(bytes) = std::fs::read(folder.path().join(path)) {
            let digest = Some(state.put(bytes));
            output_files.push(api::OutputFile { path: path.clone(), digest, ..Default::default() });
        }
    }
    Ok(api::ActionResult {
        output_files,
        exit_code: run.status.code().unwrap_or(-1),
        stderr_raw: run.stderr,
        ..Default::default()
    })
}

/// Writes a tree of input files. Only files that the tree names exist there.
fn lay_out(state: &State, digest: Option<&api::Digest>, folder: &Path) -> Result<(), Status> {
    let failed = |error: std::io::Error| Status::internal(error.to_string());
    let directory = api::Directory::decode(&state.blob(digest)?[..])
        .map_err(|error| Status::invalid_argument(error.to_string()))?;
    std::fs::create_dir_all(folder).map_err(failed)?;
    for file in &directory.files {
        let path = folder.join(&file.name);
        std::fs::write(&path, state.blob(file.digest.as_ref())?).map_err(failed)?;
        #[cfg(unix)]
        if file.is_executable {
            use std::os::unix::fs::PermissionsExt;
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).map_err(failed)?;
        }
    }
    for below in &directory.directories {
        lay_out(state, below.digest.as_ref(), &folder.join(&below.name))?;
    }
    Ok(())
}
