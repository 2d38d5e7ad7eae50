//! The tracer `inject.c`: built here, run on the real command.

use std::{
    fmt, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use tempfile::TempDir;

const SOURCE: &str = include_str!("inject.c");

/// Exit code of the tracer if the system does not allow tracing.
const UNTRACEABLE: i32 = 125;

/// A signal interrupted the call.
pub const EINTR: i32 = 4;
/// The disk is broken.
pub const EIO: i32 = 5;
/// No permission.
pub const EACCES: i32 = 13;
/// The disk is full.
pub const ENOSPC: i32 = 28;
/// The disk must not be written to.
pub const EROFS: i32 = 30;

/// Fault at the chosen call. Errors have their numbers on Linux.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No fault: the calls are only listed.
    None,
    /// The process is killed, and the call is not made.
    Kill,
    /// A write writes half, any other call is made, and the process is killed.
    Torn,
    /// A read or write moves half of the bytes.
    Short,
    /// The call fails.
    Error(i32),
    /// The call fails, and so do all later ones that need disk space.
    Full(i32),
}

impl Fault {
    /// All faults that `bake-faults` tries at every call.
    pub const ALL: [Self; 8] = [
        Self::Kill,
        Self::Torn,
        Self::Short,
        Self::Error(EINTR),
        Self::Error(EIO),
        Self::Error(EACCES),
        Self::Full(ENOSPC),
        Self::Full(EROFS),
    ];

    /// The error with which calls fail, if they fail.
    pub fn errno(self) -> Option<i32> {
        match self {
            Self::Error(errno) | Self::Full(errno) => Some(errno),
            _ => None,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Kill => f.write_str("kill"),
            Self::Torn => f.write_str("torn"),
            Self::Short => f.write_str("short"),
            Self::Error(errno) => write!(f, "errno={errno}"),
            Self::Full(errno) => write!(f, "full={errno}"),
        }
    }
}

/// A system call on a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Its name. Calls that differ only in how they name the file share a name.
    pub name: String,
    /// The file.
    pub path: String,
    /// Target of a rename or link; empty for other calls.
    pub second: String,
    /// Bytes requested; for `open`, nonzero if it may create the file.
    pub bytes: u64,
    /// Its result; if negative, the error number.
    pub result: i64,
}

/// The tracer, ready to run.
#[derive(Debug)]
pub struct Injector {
    folder: TempDir,
}

impl Injector {
    /// Builds the tracer. The error is the reason why it is unavailable: another system, no C
    /// compiler, or no permission to trace.
    pub fn build() -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let source = folder.path().join("inject.c");
        fs::write(&source, SOURCE).map_err(|error| error.to_string())?;
        let program = folder.path().join("inject");
        let built =
            Command::new("cc").args(["-O1", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&program).arg(&source).output();
        let built = built.map_err(|error| format!("the C compiler `cc` does not start: {error}"))?;
        if !built.status.success() {
            return Err(format!("the tracer does not compile here: {}", String::from_utf8_lossy(&built.stderr)));
        }
        let injector = Self { folder };
        let log = injector.log("probe");
        let probe = injector.command(&log, folder_text(&log), 0, Fault::None, Path::new("true")).output();
        match probe {
            Ok(output) if output.status.success() => Ok(injector),
            Ok(output) => Err(format!("this system does not permit tracing: {output:?}")),
            Err(error) => Err(format!("the tracer does not start: {error}")),
        }
    }

    /// Runs a command in `folder` with a fault at the `number`th call that accesses it. Also
    /// returns the calls. Panics if the command cannot be traced.
    pub fn run(
        &self,
        program: &Path,
        words: &[&str],
        folder: &Path,
        number: usize,
        fault: Fault,
    ) -> (Output, Vec<Call>) {
        let log = self.log(&folder.file_name().unwrap_or_default().to_string_lossy());
        let mut command = self.command(&log, folder_text(folder), number, fault, program);
        let output = command.args(words).current_dir(folder).output().expect("the tracer starts");
        assert_ne!(output.status.code(), Some(UNTRACEABLE), "{}", String::from_utf8_lossy(&output.stderr));
        let text = fs::read_to_string(&log).expect("the tracer writes its log");
        let calls = text.lines().filter_map(|line| {
            let [name, path, second, bytes, result] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
            let (bytes, result) = (bytes.parse().ok()?, result.parse().ok()?);
            Some(Call { name: name.to_owned(), path: path.to_owned(), second: second.to_owned(), bytes, result })
        });
        (output, calls.collect())
    }

    fn log(&self, name: &str) -> PathBuf {
        self.folder.path().join(format!("{name}.log"))
    }

    fn command(&self, log: &Path, needle: &str, number: usize, fault: Fault, program: &Path) -> Command {
        let mut command = Command::new(self.folder.path().join("inject"));
        command.arg(log).args([needle, &number.to_string(), &fault.to_string()]).arg(program);
        command
    }
}

fn folder_text(folder: &Path) -> &str {
    folder.to_str().expect("temporary folders have plain names")
}
