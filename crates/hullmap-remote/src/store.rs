//! The content-addressed store (CAS): which blobs are missing, upload and download.
//!
//! Small blobs share requests. A larger one is streamed (ByteStream), in chunks that are read from
//! its file as they are sent.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use bazel_remote_apis::build::bazel::remote::execution::v2::content_addressable_storage_client::ContentAddressableStorageClient;
use bazel_remote_apis::google::bytestream::byte_stream_client::ByteStreamClient;
use bazel_remote_apis::google::bytestream::{ReadRequest, WriteRequest};
use tonic::{Code, Response, Status};

use crate::client::MAX_MESSAGE;
use crate::strip_header::StripHeader;
use crate::{Blob, Client, Data, Digest, RemoteError};

/// Size of a chunk of a streamed blob in bytes.
const CHUNK: usize = 1 << 20;

/// Maximum number of digests in one request.
const MAX_DIGESTS: usize = 4000;

/// Size of a blob in a request, in addition to its own bytes.
const PER_BLOB: u64 = 128;

impl Client {
    /// Uploads the blobs that the server lacks.
    ///
    /// # Errors
    /// The server cannot be reached or rejects a blob, or a file has changed since its digest was
    /// computed.
    pub fn upload(&self, blobs: &[&Blob]) -> Result<(), RemoteError> {
        let by_digest: BTreeMap<&Digest, &Blob> = blobs.iter().map(|blob| (&blob.digest, *blob)).collect();
        if let Some(blob) = by_digest.keys().find(|digest| digest.size() > self.max_blob()) {
            let (size, limit) = (blob.size(), self.max_blob());
            return Err(RemoteError::Settings(format!("the server takes blobs of {limit} bytes, but one has {size}")));
        }
        self.block_on(async {
            let digests: Vec<&Digest> = by_digest.keys().copied().collect();
            let missing = self.missing(&digests).await?;
            let missing = digests.into_iter().filter(|digest| missing.contains(*digest));
            for group in groups(missing, self.max_batch()) {
                match group.as_slice() {
                    [large] if large.size() > self.max_batch() => {
                        if let Some(blob) = by_digest.get(large) {
                            self.stream_up(blob).await?;
                        }
                    }
                    small => {
                        let blobs: Vec<&Blob> =
                            small.iter().filter_map(|digest| by_digest.get(*digest).copied()).collect();
                        self.send(&blobs).await?;
                    }
                }
            }
            Ok(())
        })
    }

    /// The blobs with these digests, each of which is compared with its digest.
    ///
    /// # Errors
    /// The server cannot be reached, lacks a blob, or sends another; or a blob has more than
    /// `max_bytes`.
    pub fn fetch(&self, digests: &[Digest], max_bytes: u64) -> Result<HashMap<Digest, Vec<u8>>, RemoteError> {
        if let Some(large) = digests.iter().find(|digest| digest.size() > max_bytes) {
            let message = format!("an output has {} bytes, which is more than {max_bytes}", large.size());
            return Err(RemoteError::Invalid(message));
        }
        let mut unique: Vec<&Digest> = digests.iter().collect();
        unique.sort();
        unique.dedup();
        self.block_on(async {
            let mut found = HashMap::with_capacity(unique.len());
            for group in groups(unique.into_iter(), self.max_batch()) {
                match group.as_slice() {
                    [large] if large.size() > self.max_batch() => {
                        found.insert((*large).clone(), self.stream_down(large).await?);
                    }
                    small => self.receive(small, &mut found).await?,
                }
            }
            Ok(found)
        })
    }

    /// Which of these blobs the server lacks.
    async fn missing(&self, digests: &[&Digest]) -> Result<HashSet<Digest>, RemoteError> {
        let mut missing = HashSet::new();
        for digests in digests.chunks(MAX_DIGESTS) {
            let request = api::FindMissingBlobsRequest {
                instance_name: self.settings.instance.clone(),
                blob_digests: digests.iter().map(|digest| digest.message()).collect(),
                digest_function: api::digest_function::Value::Sha256 as i32,
            };
            let answer = self
                .retry("missing blobs", 0, || {
                    let (mut client, request) = (self.store(), self.request(request.clone()));
                    async move { client.find_missing_blobs(request).await }
                })
                .await?;
            for digest in answer.missing_blob_digests.iter().take(digests.len()) {
                missing.insert(Digest::read(Some(digest))?);
            }
        }
        Ok(missing)
    }

    /// Uploads blobs that fit into one request.
    async fn send(&self, blobs: &[&Blob]) -> Result<(), RemoteError> {
        let mut requests = Vec::with_capacity(blobs.len());
        for blob in blobs {
            let (digest, data) = (Some(blob.digest.message()), bytes(blob)?);
            requests.push(api::batch_update_blobs_request::Request { digest, data, compressor: 0 });
        }
        let request = api::BatchUpdateBlobsRequest {
            instance_name: self.settings.instance.clone(),
            requests,
            digest_function: api::digest_function::Value::Sha256 as i32,
        };
        let answer = self
            .retry("upload", self.max_batch(), || {
                let (mut client, request) = (self.store(), self.request(request.clone()));
                async move { client.batch_update_blobs(request).await }
            })
            .await?;
        for status in answer.responses.iter().filter_map(|response| response.status.as_ref()) {
            if status.code != 0 {
                return Err(RemoteError::from_status(
                    "upload",
                    &Status::new(Code::from_i32(status.code), &status.message),
                ));
            }
        }
        Ok(())
    }

    /// Downloads blobs that fit into one request.
    async fn receive(&self, digests: &[&Digest], found: &mut HashMap<Digest, Vec<u8>>) -> Result<(), RemoteError> {
        let request = api::BatchReadBlobsRequest {
            instance_name: self.settings.instance.clone(),
            digests: digests.iter().map(|digest| digest.message()).collect(),
            acceptable_compressors: Vec::new(),
            digest_function: api::digest_function::Value::Sha256 as i32,
        };
        let answer = self
            .retry("download", self.max_batch(), || {
                let (mut client, request) = (self.store(), self.request(request.clone()));
                async move { client.batch_read_blobs(request).await }
            })
            .await?;
        for response in answer.responses {
            let digest = Digest::read(response.digest.as_ref())?;
            if let Some(status) = response.status.filter(|status| status.code != 0) {
                return Err(match Code::from_i32(status.code) {
                    Code::NotFound => RemoteError::Missing(digest.hash().to_owned()),
                    code => RemoteError::from_status("download", &Status::new(code, &status.message)),
                });
            }
            check(&digest, &response.data)?;
            found.insert(digest, response.data);
        }
        match digests.iter().find(|digest| !found.contains_key(**digest)) {
            Some(missing) => Err(RemoteError::Missing(missing.hash().to_owned())),
            None => Ok(()),
        }
    }

    /// Uploads one large blob.
    async fn stream_up(&self, blob: &Blob) -> Result<(), RemoteError> {
        let size = blob.digest.size();
        // The name of an upload must differ from all others.
        let name = format!("{}uploads/{}/blobs/{}/{size}", self.prefix(), unique(), blob.digest.hash());
        // A file that cannot be read is not an answer of the server.
        Chunks::new(blob, name.clone())?;
        let answer = self
            .retry("upload", size, || {
                let mut client = ByteStreamClient::new(self.channel.clone()).max_encoding_message_size(MAX_MESSAGE);
                let chunks = Chunks::new(blob, name.clone());
                async move {
                    let chunks = chunks.map_err(|error| Status::invalid_argument(error.to_string()))?;
                    client.write(self.request(tokio_stream::iter(chunks))).await
                }
            })
            .await?;
        // A server that has the blob already may not read it to its end.
        if u64::try_from(answer.committed_size) == Ok(size) || answer.committed_size == -1 {
            return Ok(());
        }
        Err(RemoteError::Invalid(format!("{} of {size} bytes were accepted", answer.committed_size)))
    }

    /// Downloads one large blob.
    async fn stream_down(&self, digest: &Digest) -> Result<Vec<u8>, RemoteError> {
        let name = format!("{}blobs/{}/{}", self.prefix(), digest.hash(), digest.size());
        let request = ReadRequest { resource_name: name, read_offset: 0, read_limit: 0 };
        let bytes = self
            .retry("download", digest.size(), || {
                let mut client = ByteStreamClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE);
                let request = self.request(request.clone());
                async move {
                    let mut stream = client.read(request).await?.into_inner();
                    let mut bytes = Vec::new();
                    while let Some(chunk) = stream.message().await? {
                        bytes.extend_from_slice(&chunk.data);
                        if bytes.len() as u64 > digest.size() {
                            return Err(Status::out_of_range("more bytes than its digest says"));
                        }
                    }
                    Ok(Response::new(bytes))
                }
            })
            .await?;
        check(digest, &bytes)?;
        Ok(bytes)
    }

    fn store(&self) -> ContentAddressableStorageClient<StripHeader> {
        ContentAddressableStorageClient::new(self.channel.clone())
            .max_decoding_message_size(MAX_MESSAGE)
            .max_encoding_message_size(MAX_MESSAGE)
    }

    /// Start of the names of blobs.
    fn prefix(&self) -> String {
        let instance = &self.settings.instance;
        if instance.is_empty() { String::new() } else { format!("{instance}/") }
    }
}

/// Groups of digests that fit into one request each; one that does not fit is alone.
fn groups<'a>(digests: impl Iterator<Item = &'a Digest>, max_bytes: u64) -> Vec<Vec<&'a Digest>> {
    let mut groups: Vec<Vec<&Digest>> = Vec::new();
    let mut bytes = u64::MAX;
    for digest in digests {
        let own = digest.size().saturating_add(PER_BLOB);
        bytes = bytes.saturating_add(own);
        match groups.last_mut().filter(|group| bytes <= max_bytes && group.len() < MAX_DIGESTS) {
            Some(group) => group.push(digest),
            None => {
                groups.push(vec![digest]);
                bytes = own;
            }
        }
    }
    groups
}

fn check(digest: &Digest, bytes: &[u8]) -> Result<(), RemoteError> {
    if Digest::from_bytes(bytes) == *digest {
        return Ok(());
    }
    Err(RemoteError::Invalid(format!("{} bytes do not have the digest {}", bytes.len(), digest.hash())))
}

/// The bytes of a blob.
fn bytes(blob: &Blob) -> Result<Vec<u8>, RemoteError> {
    match &blob.data {
        Data::Bytes(bytes) => Ok(bytes.clone()),
        Data::File(path) => {
            let mut bytes = Vec::new();
            let mut file = open(path, &blob.digest)?.take(blob.digest.size().saturating_add(1));
            file.read_to_end(&mut bytes).map_err(|error| RemoteError::File(format!("{}: {error}", path.display())))?;
            if Digest::from_bytes(&bytes) == blob.digest { Ok(bytes) } else { Err(changed(path)) }
        }
    }
}

fn open(path: &Path, digest: &Digest) -> Result<File, RemoteError> {
    let failure = |error: std::io::Error| RemoteError::File(format!("{}: cannot read: {error}", path.display()));
    let file = File::open(path).map_err(failure)?;
    if file.metadata().map_err(failure)?.len() == digest.size() { Ok(file) } else { Err(changed(path)) }
}

fn changed(path: &Path) -> RemoteError {
    RemoteError::File(format!("{}: it changed during the upload; run the command again", path.display()))
}

/// A name that no other upload has.
fn unique() -> String {
    use std::hash::{BuildHasher, RandomState};
    let word = || RandomState::new().hash_one(0);
    let (a, b) = (word(), word());
    // A UUID of version 4.
    format!(
        "{:08x}-{:04x}-4{:03x}-8{:03x}-{:012x}",
        a >> 32,
        a >> 16 & 0xffff,
        a & 0xfff,
        b >> 48 & 0xfff,
        b & 0xffff_ffff_ffff
    )
}

/// The messages of a streamed upload.
struct Chunks {
    source: Source,
    name: String,
    offset: u64,
    size: u64,
}

enum Source {
    Bytes(Vec<u8>),
    File(File),
}

impl Chunks {
    fn new(blob: &Blob, name: String) -> Result<Self, RemoteError> {
        let source = match &blob.data {
            Data::Bytes(bytes) => Source::Bytes(bytes.clone()),
            Data::File(path) => Source::File(open(path, &blob.digest)?),
        };
        Ok(Self { source, name, offset: 0, size: blob.digest.size() })
    }

    fn read(&mut self) -> Vec<u8> {
        let start = usize::try_from(self.offset).unwrap_or(usize::MAX);
        match &mut self.source {
            Source::Bytes(bytes) => bytes.iter().skip(start).take(CHUNK).copied().collect(),
            Source::File(file) => {
                let mut chunk = Vec::with_capacity(CHUNK);
                let left = self.size.saturating_sub(self.offset);
                // A file that cannot be read ends early, and the server rejects the upload.
                let _ = file.take(left.min(CHUNK as u64)).read_to_end(&mut chunk);
                chunk
            }
        }
    }
}

impl Iterator for Chunks {
    type Item = WriteRequest;

    fn next(&mut self) -> Option<WriteRequest> {
        if self.offset >= self.size {
            return None;
        }
        let data = self.read();
        if data.is_empty() {
            return None;
        }
        let write_offset = i64::try_from(self.offset).ok()?;
        // Only the first message needs the name; some servers want it in each.
        let resource_name = self.name.clone();
        self.offset += data.len() as u64;
        Some(WriteRequest { resource_name, write_offset, finish_write: self.offset >= self.size, data })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_fit_and_hold_every_digest() {
        let digests: Vec<Digest> = (1..100_usize).map(|size| Digest::from_bytes(&vec![7; size * size])).collect();
        let grouped = groups(digests.iter(), 5000);
        assert_eq!(grouped.concat(), digests.iter().collect::<Vec<_>>());
        for group in grouped {
            let bytes: u64 = group.iter().map(|digest| digest.size() + PER_BLOB).sum();
            assert!(group.len() == 1 || bytes <= 5000, "{bytes}");
        }
    }

    #[test]
    fn chunks_are_the_blob() {
        let bytes: Vec<u8> = (0..CHUNK * 2 + 5).map(|i| i as u8).collect();
        let file = std::env::temp_dir().join(format!("hullmap-remote-chunks-{}", std::process::id()));
        std::fs::write(&file, &bytes).unwrap();
        let (memory, mut disk) = (Blob::from_bytes(bytes.clone()), Blob::from_bytes(bytes.clone()));
        disk.data = Data::File(file.clone());
        for blob in [memory, disk] {
            let chunks: Vec<WriteRequest> = Chunks::new(&blob, "n".to_owned()).unwrap().collect();
            let data: Vec<u8> = chunks.iter().flat_map(|chunk| chunk.data.clone()).collect();
            assert_eq!(data, bytes);
            assert_eq!(chunks.iter().map(|chunk| chunk.finish_write).collect::<Vec<_>>(), [false, false, true]);
            assert_eq!(chunks[2].write_offset, 2 * CHUNK as i64);
        }
        std::fs::remove_file(file).unwrap();
    }

    #[test]
    fn names_of_uploads_differ() {
        let (a, b) = (unique(), unique());
        assert!(a != b && a.len() == 36, "{a} {b}");
    }
}
