//! The `bake` command, run as its users run it.
//!
//! Cargo gives a test the binaries of its own package only. So the command is built here, once a test binary, by the
//! cargo that runs the tests, in the same profile and the same target folder: when it is up to date, that takes a
//! moment.

use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::OnceLock,
};

use serde_json::Value;

use crate::outside::workspace;

/// What came out of a run.
#[derive(Debug)]
pub struct Run {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Run {
    /// The same run, if it ended with `code`.
    ///
    /// # Panics
    /// If it ended otherwise, with all that it printed.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, code, "exit code\nstdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Standard output as one JSON value a line.
    ///
    /// # Panics
    /// If a line is anything else.
    #[track_caller]
    pub fn json(&self) -> Vec<Value> {
        let read = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        self.stdout.lines().map(read).collect()
    }
}

/// Runs `bake` with these words, in the workspace's folder.
///
/// # Panics
/// If it cannot be built or started, is killed, or prints what is not UTF-8.
pub fn bake<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> Run {
    bake_in(&workspace(), words)
}

/// Runs `bake` with these words in `folder`.
///
/// # Panics
/// As [`bake`].
pub fn bake_in<S: AsRef<OsStr>>(folder: &Path, words: impl IntoIterator<Item = S>) -> Run {
    let run = Command::new(binary()).args(words).current_dir(folder).output().expect("bake starts");
    let text = |bytes| String::from_utf8(bytes).expect("bake prints UTF-8");
    Run { code: run.status.code().expect("bake is not killed"), stdout: text(run.stdout), stderr: text(run.stderr) }
}

/// Runs cargo with these words in the workspace's folder.
///
/// # Panics
/// If it fails, with what it printed.
pub fn cargo<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> Output {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from(env!("CARGO")));
    let output = Command::new(cargo).args(words).current_dir(workspace()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// `bake` with these words in `folder`, not started yet: for what must be interrupted, watched or piped.
///
/// # Panics
/// If it cannot be built.
pub fn command<S: AsRef<OsStr>>(folder: &Path, words: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(binary());
    command.args(words).current_dir(folder);
    command
}

/// The binary, built.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        // A test is <target>/<profile>/deps/<name>, a command of this package <target>/<profile>/<name>.
        let test = std::env::current_exe().expect("a test knows where it is");
        let above = test.ancestors().skip(1).find(|folder| folder.file_name() != Some(OsStr::new("deps")));
        let folder = above.expect("tests lie in a profile's folder");
        let profile = match folder.file_name().and_then(OsStr::to_str) {
            Some("debug") | None => "dev",
            Some(profile) => profile,
        };
        let target = folder.parent().expect("a profile's folder lies in the target folder").as_os_str();
        let words = ["build", "--package", "bake", "--bin", "bake", "--message-format", "json", "--profile", profile];
        let built = cargo(words.map(OsStr::new).into_iter().chain([OsStr::new("--target-dir"), target]));
        let messages = String::from_utf8(built.stdout).expect("cargo prints UTF-8");
        messages
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok())
            .filter(|message| message["target"]["name"] == "bake")
            .find_map(|message| message["executable"].as_str().map(PathBuf::from))
            .expect("cargo says where it put the binary")
    })
}
