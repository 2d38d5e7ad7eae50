//! A folder with sources that have changed since their packs were baked. It defines the permitted
//! results of a bake.
//!
//! | source | since the packs were baked |
//! |---|---|
//! | `in/a.obj`, `in/sub/b.obj`, `in/m0.obj` … | changed |
//! | `in/c.gltf` | the same, but its buffer `in/c.bin` has changed |
//! | `in/same.obj` | the same |
//! | `in/fresh/d.obj` | new, in a folder that the output does not have yet |
//! | `in/gone.obj` | gone: its pack is an orphan, to be pruned |
//! | `elsewhere/other.obj` | the same; its pack is in `o` too, and belongs to another build |
//!
//! The options in `in/hullmap.toml` change the packs.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use hullmap_testkit::files::{self, contents};
use serde_json::Value;
use shapes::families::Family;
use tempfile::TempDir;

use super::inject::Call;

/// Arguments of the bake that is disturbed.
pub const WORDS: [&str; 8] = ["build", "in", "--out", "o", "--prune", "--json", "--depfile", "o/deps.d"];

/// Files by their paths from the project's folder.
pub type Files = BTreeMap<String, Vec<u8>>;

/// The project, in a folder of its own.
#[derive(Debug)]
pub struct Project {
    folder: TempDir,
    binary: PathBuf,
    /// The output of the bake of the old sources.
    pub old: Files,
    /// The output of an undisturbed bake of the new sources.
    pub new: Files,
}

/// Numbers of outputs that a bake with a fault left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Left {
    /// Outputs that differ between old and new, and are new.
    pub new: usize,
    /// Outputs that differ between old and new, and are still old.
    pub old: usize,
    /// Temporary files.
    pub temporary: usize,
}

/// How a bake ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Killed.
    Killed,
    /// With exit code 0.
    Done,
    /// With exit code 2 and a message.
    Reported,
}

impl Project {
    /// Creates the project. Panics if `binary` does not bake it.
    pub fn new(binary: &Path) -> Self {
        let folder = tempfile::Builder::new().prefix("faults").tempdir().expect("a temporary folder");
        let mut project = Self { folder, binary: binary.to_owned(), old: Files::new(), new: Files::new() };
        project.write("elsewhere/other.obj", cloud(9, 1));
        project.write("in/hullmap.toml", "[defaults]\nunit_scale = 2.0\nindex = \"compact\"\n");
        project.write("in/same.obj", cloud(20, 2));
        project.write("in/gone.obj", cloud(20, 3));
        project.write("in/c.gltf", GLTF);
        project.write_version(0);
        project.bake(&["build", "elsewhere/other.obj", "--out", "o", "--config", "none"]);
        project.bake(&WORDS);
        project.old = project.output();
        project.write_version(1);
        project.write("in/fresh/d.obj", cloud(30, 4));
        fs::remove_file(project.path("in/gone.obj")).expect("it was just written");
        project.bake(&WORDS);
        project.new = project.output();
        let differing = project.differing().count();
        assert_eq!(differing, 6, "a, b, c, d, gone and deps.d differ: {:?}", project.new.keys());
        project
    }

    fn write_version(&self, version: u64) {
        self.write("in/a.obj", cloud(40, 10 + version));
        self.write("in/sub/b.obj", cloud(60, 20 + version));
        let bytes: Vec<u8> =
            Family::Sphere.points(12, 30 + version).as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.write("in/c.bin", bytes);
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        files::write(self.folder(), name, bytes);
    }

    /// The project's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// A file of the project.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The command under test.
    pub fn binary(&self) -> &Path {
        &self.binary
    }

    /// The command with these words in the project's folder.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(&self.binary);
        command.args(words).current_dir(self.folder());
        command
    }

    fn bake(&self, words: &[&str]) {
        let output = self.command(words).output().expect("bake starts");
        assert!(output.status.success(), "{words:?}: {output:?}");
    }

    /// Everything in the output folder.
    pub fn output(&self) -> Files {
        contents(&self.path("o")).into_iter().map(|(name, bytes)| (format!("o/{name}"), bytes)).collect()
    }

    /// Names of the outputs that differ between old and new.
    pub fn differing(&self) -> impl Iterator<Item = &String> {
        let names = self.old.keys().chain(self.new.keys().filter(|name| !self.old.contains_key(*name)));
        names.filter(|name| self.old.get(*name) != self.new.get(*name))
    }

    /// Replaces the output folder's contents by `files`. Panics if something else uses the folder.
    pub fn put(&self, files: &Files) {
        let out = self.path("o");
        if out.exists() {
            fs::remove_dir_all(&out).expect("the folder is ours");
        }
        fs::create_dir(&out).expect("the folder is ours");
        files.iter().for_each(|(name, bytes)| self.write(name, bytes));
    }

    /// Counts the old and new outputs in `files`. Fails if an output is neither old nor new, is
    /// missing, or should not exist.
    pub fn judge_files(&self, files: &Files) -> Result<Left, String> {
        let mut left = Left::default();
        for name in self.differing() {
            match files.get(name) {
                found if found == self.new.get(name) => left.new += 1,
                found if found == self.old.get(name) => left.old += 1,
                None => return Err(format!("{name} is gone")),
                Some(bytes) => return Err(format!("{name} is neither old nor new: {} bytes", bytes.len())),
            }
        }
        for (name, bytes) in files {
            if is_temporary(name) {
                left.temporary += 1;
            } else if !self.new.contains_key(name) && !self.old.contains_key(name) {
                return Err(format!("{name} should not exist"));
            } else if self.old.get(name) == self.new.get(name) && self.old.get(name) != Some(bytes) {
                return Err(format!("{name} should be unchanged"));
            }
        }
        let missing = self.old.keys().find(|name| self.new.contains_key(*name) && !files.contains_key(*name));
        missing.map_or(Ok(left), |name| Err(format!("{name} is gone")))
    }

    /// Checks the output folder and the end of the bake. `calls` are the system calls that it made,
    /// if known. The error is a defect of the packs, of the printed rows, or of the exit code.
    pub fn judge(&self, run: &Output, calls: &[Call]) -> Result<(End, Left), String> {
        let files = self.output();
        let left = self.judge_files(&files)?;
        for name in files.keys().filter(|name| name.ends_with(".hullmap")) {
            hullmap::Pack::open(self.path(name)).map_err(|error| error.to_string())?;
        }
        let Some(code) = run.status.code().filter(|&code| code != KILLED) else { return Ok((End::Killed, left)) };
        let (stderr, rows) = (String::from_utf8_lossy(&run.stderr), rows(&run.stdout)?);
        let fail = |what: &str| Err(format!("{what}; exit code {code}, stdout {rows:?}, stderr {stderr}"));
        if stderr.contains("panicked") || stderr.contains("internal error") {
            return fail("the bake panicked");
        }
        let could_not_remove = calls.iter().any(|call| call.name == "unlink" && call.result < 0);
        if left.temporary > 0 && !could_not_remove {
            return fail("temporary files are left");
        }
        for row in &rows {
            let text = |key: &str| row[key].as_str().unwrap_or_default();
            let (name, status) = (text("output"), text("status"));
            let (found, old, new) = (files.get(name), self.old.get(name), self.new.get(name));
            let is_in_place = text("error").contains("the file was written");
            let is_true = match status {
                "baked" | "fresh" => found == new && text("error").is_empty(),
                "failed" => !text("error").is_empty() && found == if is_in_place { new } else { old },
                "orphaned" => found == old,
                "pruned" => found.is_none() && old.is_some() && new.is_none(),
                _ => false,
            };
            if !is_true {
                return fail(&format!("{name} is not {status}"));
            }
        }
        match code {
            0 if left.old > usize::from(self.is_orphan_left(&files)) => {
                fail("the bake reports success, but outputs are old")
            }
            0 => Ok((End::Done, left)),
            2 if stderr.contains("error: ") => Ok((End::Reported, left)),
            _ => fail("the exit code is wrong, or there is no message"),
        }
    }

    /// Whether the orphan is there. A build may leave it if it is not sure that its source is gone.
    fn is_orphan_left(&self, files: &Files) -> bool {
        files.contains_key("o/gone.hullmap")
    }

    /// Runs a bake without faults after one with a fault. All outputs must be new, with no other
    /// files. The error states the defect.
    pub fn bake_again(&self) -> Result<(), String> {
        let run = self.command(&WORDS).output().map_err(|error| error.to_string())?;
        let (stderr, files) = (String::from_utf8_lossy(&run.stderr), self.output());
        if !run.status.success() {
            return Err(format!("the next bake fails: {stderr}"));
        }
        if files != self.new {
            let odd: Vec<_> = files.iter().filter(|(name, bytes)| self.new.get(*name) != Some(bytes)).collect();
            let names: Vec<_> = odd.iter().map(|(name, _)| name).collect();
            let gone: Vec<_> = self.new.keys().filter(|name| !files.contains_key(*name)).collect();
            return Err(format!("after the next bake, {names:?} are wrong and {gone:?} are missing: {stderr}"));
        }
        Ok(())
    }
}

/// Exit code of the tracer for a process that was killed.
const KILLED: i32 = 137;

fn rows(stdout: &[u8]) -> Result<Vec<Value>, String> {
    let text = String::from_utf8_lossy(stdout);
    text.lines().map(|line| serde_json::from_str(line).map_err(|error| format!("{error}: {line}"))).collect()
}

/// Whether a path can only belong to a temporary file of `bake`.
fn is_temporary(name: &str) -> bool {
    let name = name.rsplit('/').next().unwrap_or(name);
    name.starts_with('.') && name.ends_with(".tmp")
}

/// Points on a sphere as OBJ text.
fn cloud(count: usize, seed: u64) -> String {
    Family::Sphere.points(count, seed).iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

/// Twelve points that lie in the file `c.bin` beside it.
const GLTF: &str = r#"{
  "asset": {"version": "2.0"},
  "buffers": [{"uri": "c.bin", "byteLength": 144}],
  "bufferViews": [{"buffer": 0, "byteLength": 144}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}],
  "nodes": [{"mesh": 0}],
  "scenes": [{"nodes": [0]}],
  "scene": 0
}
"#;
