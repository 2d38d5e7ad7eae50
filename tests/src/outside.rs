//! Inputs that lie outside the repository: folders and files that an environment variable names.

use std::path::{Path, PathBuf};

/// The path that `variable` holds; without it `None`, after a line that says which test was skipped.
///
/// # Panics
/// If the variable names nothing that is there: a test that was asked for must not be skipped.
pub fn path(variable: &str, test: &str) -> Option<PathBuf> {
    let Some(path) = std::env::var_os(variable).filter(|value| !value.is_empty()) else {
        println!("skipped: {test}: {variable} is not set");
        return None;
    };
    // Cargo runs a test in its package's folder; the variable is meant from the workspace's.
    let path = workspace().join(path);
    assert!(path.exists(), "{variable} names {}, which is not there", path.display());
    Some(path)
}

/// The workspace's folder.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_owned()
}
