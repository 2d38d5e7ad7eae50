//! Queries and batches do not allocate.
//!
//! This is a separate binary, because the allocator counts for the whole process. Each test holds
//! [`ALONE`] while it runs.

use std::{
    alloc::System,
    sync::{Mutex, MutexGuard, PoisonError},
};

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

mod batch;
mod queries;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

static ALONE: Mutex<()> = Mutex::new(());

/// Number of tries. The minimum counts, because the harness's own thread may allocate too.
const TRIES: usize = 5;

/// Number of allocations of `work`.
fn allocations(mut work: impl FnMut()) -> usize {
    let tries = (0..TRIES).map(|_| {
        let region = Region::new(ALLOCATOR);
        work();
        region.change().allocations + region.change().reallocations
    });
    tries.min().unwrap_or_default()
}

/// Waits until no other test of this process runs.
fn alone() -> MutexGuard<'static, ()> {
    // A failed test leaves no inconsistent state behind the lock.
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}
