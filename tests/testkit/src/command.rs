//! The `bake` command, run as its users run it.
//!
//! Cargo gives a test only the binaries of its own package. So each test binary builds the command
//! once, with the cargo that runs the tests, in the same profile and target folder. If it is up to
//! date, that takes a moment.

use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::OnceLock,
};

use serde_json::Value;

use crate::files::workspace;

/// The result of a run.
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
    /// Asserts the exit code and returns the run. Panics if the exit code differs; the message has
    /// all output.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, code, "exit code\nstdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Standard output as one JSON value per line. Panics if a line is not JSON.
    #[track_caller]
    pub fn json(&self) -> Vec<Value> {
        let read = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        self.stdout.lines().map(read).collect()
    }
}

/// Runs `bake` with these arguments, in the workspace's folder. Panics if it cannot be built or
/// started, is killed, or prints invalid UTF-8.
pub fn bake<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> Run {
    bake_in(&workspace(), words)
}

/// Runs `bake` with these arguments in `folder`. Panics as [`bake`] does.
pub fn bake_in<S: AsRef<OsStr>>(folder: &Path, words: impl IntoIterator<Item = S>) -> Run {
    finished(Command::new(binary()).args(words).current_dir(folder))
}

/// Runs `bake` in `folder` with the words of a line, which hold no spaces. Panics as [`bake`] does.
pub fn bake_line(folder: impl AsRef<Path>, line: &str) -> Run {
    bake_in(folder.as_ref(), line.split_whitespace())
}

/// Runs a command of `bake` to its end. Panics if it cannot be started, is killed, or prints
/// invalid UTF-8.
pub fn finished(command: &mut Command) -> Run {
    let run = command.output().expect("bake starts");
    let text = |bytes| String::from_utf8(bytes).expect("bake prints UTF-8");
    Run { code: run.status.code().expect("bake is not killed"), stdout: text(run.stdout), stderr: text(run.stderr) }
}

/// Runs cargo with these arguments in the workspace's folder. Panics if it fails; the message has
/// its errors.
pub fn cargo<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> Output {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from(env!("CARGO")));
    let output = Command::new(cargo).args(words).current_dir(workspace()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// `bake` with these arguments in `folder`, not started yet, so that a test can interrupt, watch or
/// pipe it. Panics if it cannot be built.
pub fn command<S: AsRef<OsStr>>(folder: &Path, words: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(binary());
    command.args(words).current_dir(folder);
    command
}

/// The binary, built.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| built(&[]))
}

/// Builds the command, with these words for cargo. Panics if it cannot be built.
pub fn built(more: &[&str]) -> PathBuf {
    // A test is <target>/<profile>/deps/<name>, a command of this package
    // <target>/<profile>/<name>.
    let test = std::env::current_exe().expect("a test knows where it is");
    let above = test.ancestors().skip(1).find(|folder| folder.file_name() != Some(OsStr::new("deps")));
    let folder = above.expect("tests lie in a profile's folder");
    let profile = match folder.file_name().and_then(OsStr::to_str) {
        Some("debug") | None => "dev",
        Some(profile) => profile,
    };
    let target = folder.parent().expect("a profile's folder lies in the target folder").as_os_str();
    // Without `--package`, and with a test: cargo then selects the features of the default members
    // and of their dev-dependencies, as for `cargo test`, so that no crate is built twice. This
    // test compiles in a moment, if it is not up to date.
    let words = ["build", "--bin", "bake", "--test", "drift", "--message-format", "json", "--profile", profile];
    let words = words.into_iter().chain(more.iter().copied()).map(OsStr::new);
    let built = cargo(words.chain([OsStr::new("--target-dir"), target]));
    let messages = String::from_utf8(built.stdout).expect("cargo prints UTF-8");
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|message| message["target"]["name"] == "bake")
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .expect("cargo says where it put the binary")
}
