//! Ctrl-C: what is half done goes, what is done stays, and the process exits with [`EXIT`].
//!
//! Files that are being written are listed here while they exist. The list is locked while one is made, put in place or
//! removed, and for good once the process ends; so at the end each is either in place or gone.
//! After an end that nobody can catch, [`crate::pack_file::sweep`] removes what was left.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use indicatif::MultiProgress;

use crate::messages;

/// Exit code after Ctrl-C: 128 and the number of the signal, as shells have it.
pub const EXIT: i32 = 130;

/// Files of this process that are not in place yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The progress bars on the screen.
static SCREEN: Mutex<Option<MultiProgress>> = Mutex::new(None);

/// Whether the process only waits for something to do.
static IDLE: AtomicBool = AtomicBool::new(false);

/// Nothing leaves these half changed, so a panic elsewhere does not matter.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Catches Ctrl-C from now on. Where the system does not let one, the usual end by the signal remains.
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
            messages::say(if IDLE.load(Ordering::Relaxed) {
                "stopped watching"
            } else {
                "interrupted: finished packs stand, nothing half done is left; run it again to go on"
            });
            // The list stays locked: no file can appear any more.
            std::process::exit(EXIT);
        });
    });
}

/// Waits for something to do: Ctrl-C meanwhile interrupts nothing, and says so.
pub fn idle<T>(wait: impl FnOnce() -> T) -> T {
    IDLE.store(true, Ordering::Relaxed);
    let result = wait();
    IDLE.store(false, Ordering::Relaxed);
    result
}

/// Bars to take off the screen at the end.
pub fn show(bars: Option<MultiProgress>) {
    *lock(&SCREEN) = bars;
}

/// Makes a file and lists it, in one step.
///
/// # Errors
/// Those of `make`.
pub fn make<T>(make: impl FnOnce() -> std::io::Result<T>, path: impl FnOnce(&T) -> &Path) -> std::io::Result<T> {
    let mut unfinished = lock(&UNFINISHED);
    let file = make()?;
    unfinished.insert(path(&file).to_owned());
    Ok(file)
}

/// Puts a listed file in place, or removes it, and takes it off the list, in one step.
pub fn settle<T>(path: &Path, settle: impl FnOnce() -> T) -> T {
    let mut unfinished = lock(&UNFINISHED);
    let result = settle();
    unfinished.remove(path);
    result
}
