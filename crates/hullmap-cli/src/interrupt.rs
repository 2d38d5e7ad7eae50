//! Ctrl-C: removes temporary files, keeps finished ones, and exits with [`EXIT`].

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use hullmap_pipeline::unfinished;
use indicatif::MultiProgress;

use crate::terminal;

/// Exit code after Ctrl-C: 128 plus the signal number, as in shells.
pub const EXIT: i32 = 130;

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
            unfinished::remove_all(|| {
                if let Some(bars) = lock(&SCREEN).as_ref() {
                    let _ = bars.clear();
                }
                terminal::say(if IDLE.load(Ordering::Relaxed) {
                    "stopped watching"
                } else {
                    "interrupted: finished files are kept, unfinished ones were removed; run the command again to \
                     continue"
                });
                std::process::exit(EXIT);
            });
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
