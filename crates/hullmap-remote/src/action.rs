//! Actions: a command line, its input files and the paths of its outputs, as messages whose digests
//! depend on nothing else.
//!
//! Input files form a tree of `Directory` messages (a Merkle tree): each names its files and
//! folders by their digests. Messages list names in ascending order, as the API demands, so that
//! equal actions have equal digests.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use bazel_remote_apis::google::protobuf;
use prost::Message as _;

use crate::{Digest, RemoteError};

/// A blob with its digest.
#[derive(Clone, Debug)]
pub struct Blob {
    /// Its name.
    pub digest: Digest,
    /// Its bytes.
    pub data: Data,
}

/// Where the bytes of a blob are.
#[derive(Clone, Debug)]
pub enum Data {
    /// In memory.
    Bytes(Vec<u8>),
    /// In a file, which is read when the server lacks the blob.
    File(PathBuf),
}

impl Blob {
    /// A blob in memory.
    pub fn from_bytes(bytes: Vec<u8>) -> Self {
        Self { digest: Digest::from_bytes(&bytes), data: Data::Bytes(bytes) }
    }
}

/// A file that an action reads.
#[derive(Clone, Debug)]
pub struct InputFile {
    /// Its path in the action's folder, with `/`.
    pub path: String,
    /// Its contents.
    pub blob: Blob,
    /// Whether it can be started.
    pub is_executable: bool,
}

/// Description of an action.
#[derive(Clone, Debug, Default)]
pub struct ActionSpec {
    /// Program and arguments. A program with a `/` is an input file.
    pub arguments: Vec<String>,
    /// Environment variables.
    pub environment: Vec<(String, String)>,
    /// Files in its folder.
    pub inputs: Vec<InputFile>,
    /// Paths of the files that it may write.
    pub outputs: Vec<String>,
    /// Properties that the worker must have.
    pub platform: Vec<(String, String)>,
    /// Maximum time on the worker; `None`: the server's limit.
    pub timeout: Option<Duration>,
}

/// An action with everything that a server needs to run it.
#[derive(Clone, Debug)]
pub struct Action {
    /// Digest of the `Action` message: the key in the action cache.
    pub digest: Digest,
    /// The messages `Action` and `Command`.
    pub messages: Vec<Blob>,
    /// Input files and the folders that name them.
    pub inputs: Vec<Blob>,
}

impl ActionSpec {
    /// The action.
    ///
    /// ```
    /// use hullmap_remote::{ActionSpec, Blob, InputFile};
    ///
    /// let blob = Blob::from_bytes(b"text".to_vec());
    /// let input = InputFile { path: "in/a".into(), blob, is_executable: false };
    /// let spec = ActionSpec { arguments: vec!["cat".into(), "in/a".into()], inputs: vec![input], ..Default::default() };
    /// // Action, command; file, `in`, root.
    /// let action = spec.action()?;
    /// assert_eq!((action.messages.len(), action.inputs.len()), (2, 3));
    /// # Ok::<(), hullmap_remote::RemoteError>(())
    /// ```
    ///
    /// # Errors
    /// The path of an input is not relative, or names a file and a folder.
    pub fn action(self) -> Result<Action, RemoteError> {
        let mut root = Folder::default();
        let mut inputs = Vec::with_capacity(self.inputs.len());
        for InputFile { path, blob, is_executable } in self.inputs {
            root.insert(&path, &blob.digest, is_executable)?;
            inputs.push(blob);
        }
        let root = root.encode(&mut inputs);
        let sorted = |mut pairs: Vec<(String, String)>| {
            pairs.sort();
            pairs
        };
        let property = |(name, value)| api::platform::Property { name, value };
        let platform = api::Platform { properties: sorted(self.platform).into_iter().map(property).collect() };
        let variable = |(name, value)| api::command::EnvironmentVariable { name, value };
        let mut outputs = self.outputs;
        outputs.sort();
        outputs.dedup();
        let mut command = api::Command {
            arguments: self.arguments,
            environment_variables: sorted(self.environment).into_iter().map(variable).collect(),
            output_paths: outputs,
            ..api::Command::default()
        };
        // Servers of version 2.1 and older read it here.
        #[expect(deprecated, reason = "servers of version 2.1 and older")]
        {
            command.platform = Some(platform.clone());
        }
        let command = Blob::from_bytes(command.encode_to_vec());
        let timeout = self.timeout.map(|timeout| protobuf::Duration {
            seconds: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            nanos: 0,
        });
        let action = api::Action {
            command_digest: Some(command.digest.message()),
            input_root_digest: Some(root.message()),
            timeout,
            platform: Some(platform),
            ..api::Action::default()
        };
        let action = Blob::from_bytes(action.encode_to_vec());
        Ok(Action { digest: action.digest.clone(), messages: vec![action, command], inputs })
    }
}

/// A folder of input files. Names are in ascending order of their bytes.
#[derive(Default)]
struct Folder {
    entries: BTreeMap<String, Entry>,
}

enum Entry {
    File { digest: Digest, is_executable: bool },
    Folder(Folder),
}

impl Folder {
    fn insert(&mut self, path: &str, digest: &Digest, is_executable: bool) -> Result<(), RemoteError> {
        let wrong = || RemoteError::File(format!("`{}` cannot be the path of an input", path.escape_debug()));
        let (name, rest) = path.split_once('/').map_or((path, None), |(name, rest)| (name, Some(rest)));
        if name.is_empty() || name == "." || name == ".." || name.contains('\0') {
            return Err(wrong());
        }
        match rest {
            None => match self.entries.get(name) {
                Some(Entry::File { digest: other, .. }) if other == digest => Ok(()),
                Some(_) => Err(wrong()),
                None => {
                    let file = Entry::File { digest: digest.clone(), is_executable };
                    self.entries.insert(name.to_owned(), file);
                    Ok(())
                }
            },
            Some(rest) => match self.entries.entry(name.to_owned()).or_insert(Entry::Folder(Self::default())) {
                Entry::Folder(folder) => folder.insert(rest, digest, is_executable),
                Entry::File { .. } => Err(wrong()),
            },
        }
    }

    /// Adds the messages of this folder and of all below it to `blobs`; returns its digest.
    fn encode(self, blobs: &mut Vec<Blob>) -> Digest {
        let mut message = api::Directory::default();
        for (name, entry) in self.entries {
            match entry {
                Entry::File { digest, is_executable } => message.files.push(api::FileNode {
                    name,
                    digest: Some(digest.message()),
                    is_executable,
                    ..api::FileNode::default()
                }),
                Entry::Folder(folder) => {
                    let digest = Some(folder.encode(blobs).message());
                    message.directories.push(api::DirectoryNode { name, digest });
                }
            }
        }
        let blob = Blob::from_bytes(message.encode_to_vec());
        let digest = blob.digest.clone();
        blobs.push(blob);
        digest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(paths: &[&str]) -> ActionSpec {
        let input = |path: &&str| InputFile {
            path: (*path).to_owned(),
            blob: Blob::from_bytes(path.as_bytes().to_vec()),
            is_executable: false,
        };
        ActionSpec { arguments: vec!["x".to_owned()], inputs: paths.iter().map(input).collect(), ..Default::default() }
    }

    #[test]
    fn the_order_of_inputs_and_outputs_does_not_matter() {
        let digest = |paths: &[&str], outputs: &[&str]| {
            let outputs = outputs.iter().map(|&path| path.to_owned()).collect();
            ActionSpec { outputs, ..spec(paths) }.action().unwrap().digest
        };
        let usual = digest(&["a/b", "a/c", "d"], &["o/1", "o/2"]);
        assert_eq!(usual, digest(&["d", "a/c", "a/b"], &["o/2", "o/1"]));
        assert_ne!(usual, digest(&["a/b", "a/c", "e"], &["o/1", "o/2"]));
        assert_ne!(usual, digest(&["a/b", "a/c", "d"], &["o/1"]));
    }

    #[test]
    fn paths_of_inputs_stay_in_the_folder() {
        for path in ["", "/a", "a//b", "a/", "../a", "a/../b", "./a", "a\0"] {
            assert!(spec(&[path]).action().is_err(), "{path:?}");
        }
        assert!(spec(&["a", "a/b"]).action().is_err() && spec(&["a/b", "a"]).action().is_err());
        assert!(spec(&["a", "a"]).action().is_ok());
    }

    /// The digest of an empty folder is the digest of no bytes, and a folder lists its files by
    /// name, as in other implementations.
    #[test]
    fn folders_are_encoded_as_the_api_defines() {
        let action = spec(&[]).action().unwrap();
        assert_eq!(action.inputs[0].digest, Digest::from_bytes(b""));
        let action = spec(&["b", "a", "sub/x"]).action().unwrap();
        let Data::Bytes(root) = &action.inputs.last().unwrap().data else { unreachable!() };
        let root = api::Directory::decode(&root[..]).unwrap();
        let names: Vec<&str> = root.files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!((names, root.directories[0].name.as_str()), (vec!["a", "b"], "sub"));
    }
}
