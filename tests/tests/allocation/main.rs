//! Queries and batches do not allocate.
//!
//! This is a separate binary, because the allocator counts for the whole process. Each test holds
//! [`ALONE`] while it runs.

use std::{
    alloc::System,
    sync::{Mutex, MutexGuard, PoisonError},
};

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

mod batch;
mod queries;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

static ALONE: Mutex<()> = Mutex::new(());

/// Waits until no other test of this process runs.
fn alone() -> MutexGuard<'static, ()> {
    // A failed test leaves no inconsistent state behind the lock.
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}
