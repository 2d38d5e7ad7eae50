//! Thread pools: one for each requested number of threads, made on first use.
//!
//! A forked child (`multiprocessing` on Linux) has the pools of its parent but none of their
//! threads, and would wait for them for ever. So pools belong to a process id.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::Error;

/// Maximum number of threads, far above what processors have. A typing error must not exhaust the
/// system.
const MAX_THREADS: usize = 1024;

/// The pools of one process; the key 0 is the pool of all processors.
struct Pools {
    process: u32,
    by_count: HashMap<usize, Arc<ThreadPool>>,
}

static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// A number of threads; of `None`, as many as there are processors, or `RAYON_NUM_THREADS`.
#[derive(Clone, Copy, Default)]
pub struct Threads(Option<usize>);

impl Threads {
    /// Whether the calling thread does all work.
    pub fn is_one(self) -> bool {
        self.0 == Some(1)
    }
}

impl<'py> FromPyObject<'_, 'py> for Threads {
    type Error = PyErr;

    fn extract(argument: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if argument.is_none() {
            return Ok(Self(None));
        }
        match argument.extract::<usize>() {
            Ok(count) if (1..=MAX_THREADS).contains(&count) => Ok(Self(Some(count))),
            _ => Err(Error::new_err(format!(
                "threads must be a whole number from 1 to {MAX_THREADS}, or None for all processors, found {}",
                argument.repr()?
            ))),
        }
    }
}

/// The pool with this number of threads. Fails if the system has no threads left.
pub fn pool(Threads(count): Threads) -> PyResult<Arc<ThreadPool>> {
    let count = count.unwrap_or(0);
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if pools.as_ref().is_none_or(|pools| pools.process != process) {
        let of_parent = pools.replace(Pools { process, by_count: HashMap::new() });
        // Dropping a pool would wake threads that this process does not have.
        std::mem::forget(of_parent);
    }
    if let Some(found) = pools.as_ref().and_then(|pools| pools.by_count.get(&count)) {
        return Ok(Arc::clone(found));
    }
    let made = ThreadPoolBuilder::new()
        .num_threads(count)
        .thread_name(|index| format!("hullmap-{index}"))
        .build()
        .map_err(|error| Error::new_err(format!("cannot start threads: {error}; use fewer threads")))?;
    let made = Arc::new(made);
    if let Some(pools) = pools.as_mut() {
        pools.by_count.insert(count, Arc::clone(&made));
    }
    Ok(made)
}
