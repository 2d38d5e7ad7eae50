//! Temporary files of this process, so that a handler of Ctrl-C can remove them.
//!
//! Their list is locked while one is created, renamed or removed, and stays locked while the
//! process exits, so that each file is either in place or removed. After a kill that cannot be
//! caught, [`crate::pack_file::sweep`] removes leftovers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn lock() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // No code leaves the list half changed, so a panic elsewhere does not matter.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files, and runs `exit` while no new one can appear.
pub fn remove_all(exit: impl FnOnce()) {
    let unfinished = lock();
    for path in unfinished.iter() {
        let _ = std::fs::remove_file(path);
    }
    exit();
}

/// Creates a temporary file and lists it, in one step. Returns the errors of `make`.
pub fn make<T>(make: impl FnOnce() -> std::io::Result<T>, path: impl FnOnce(&T) -> &Path) -> std::io::Result<T> {
    let mut unfinished = lock();
    let file = make()?;
    unfinished.insert(path(&file).to_owned());
    Ok(file)
}

/// Renames or removes a listed file and takes it off the list, in one step.
pub fn settle<T>(path: &Path, settle: impl FnOnce() -> T) -> T {
    let mut unfinished = lock();
    let result = settle();
    unfinished.remove(path);
    result
}
