//! Ctrl-C: removes temporary files, keeps finished ones, and exits with [`EXIT`].
//!
//! The list of temporary files is locked while one is created, renamed or removed, and stays locked
//! while the process exits, so that each file is either in place or removed. After a kill that
//! cannot be caught, [`crate::pack_file::sweep`] removes leftovers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use indicatif::MultiProgress;

use crate::terminal;

/// Exit code after Ctrl-C: 128 plus the signal number, as in shells.
pub const EXIT: i32 = 130;

static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

static SCREEN: Mutex<Option<MultiProgress>> = Mutex::new(None);

static IDLE: AtomicBool = AtomicBool::new(false);

/// Locks a mutex. No code leaves these values half changed, so a panic elsewhere does not matter.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Installs the handler for Ctrl-C. If this fails, the signal ends the process as usual.
pub fn catch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let _ = ctrlc::set_handler(|| {
            let unfinished = lock(&UNFINISHED);
            for path in unfinished.iter() {
                let _ = std::fs::remove_file(path);
            }
            if let Some(bars) = lock(&SCREEN).as_ref() {
                let _ = bars.clear();
            }
            terminal::say(if IDLE.load(Ordering::Relaxed) {
                "stopped watching"
            } else {
                "interrupted: finished files are kept, unfinished ones were removed; run the command again to continue"
            });
            // The list stays locked, so that no new file can appear.
            std::process::exit(EXIT);
        });
    });
}

/// Waits for changes. Ctrl-C during `wait` interrupts no work, and the message states this.
pub fn idle<T>(wait: impl FnOnce() -> T) -> T {
    IDLE.store(true, Ordering::Relaxed);
    let result = wait();
    IDLE.store(false, Ordering::Relaxed);
    result
}

pub fn show(bars: Option<MultiProgress>) {
    *lock(&SCREEN) = bars;
}

/// Creates a temporary file and lists it, in one step. Returns the errors of `make`.
pub fn make<T>(make: impl FnOnce() -> std::io::Result<T>, path: impl FnOnce(&T) -> &Path) -> std::io::Result<T> {
    let mut unfinished = lock(&UNFINISHED);
    let file = make()?;
    unfinished.insert(path(&file).to_owned());
    Ok(file)
}

/// Renames or removes a listed file and takes it off the list, in one step.
pub fn settle<T>(path: &Path, settle: impl FnOnce() -> T) -> T {
    let mut unfinished = lock(&UNFINISHED);
    let result = settle();
    unfinished.remove(path);
    result
}
