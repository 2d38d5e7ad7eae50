//! Inputs that lie outside the repository: folders and files that an environment variable names.

use std::path::{Path, PathBuf};

/// The path in the environment variable `variable`. If it is not set, prints which test is skipped
/// and returns `None`.
///
/// # Panics
/// If the path does not exist: a requested test must not be skipped.
pub fn path(variable: &str, test: &str) -> Option<PathBuf> {
    let Some(path) = std::env::var_os(variable).filter(|value| !value.is_empty()) else {
        println!("skipped: {test}: {variable} is not set");
        return None;
    };
    // Cargo runs a test in its package's folder; the path is relative to the workspace.
    let path = workspace().join(path);
    assert!(path.exists(), "{variable} names {}, which does not exist", path.display());
    Some(path)
}

/// The workspace's folder.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_owned()
}
