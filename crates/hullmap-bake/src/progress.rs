//! Progress of a long computation, for a progress bar, which may also cancel it: in another thread,
//! or by a listener where there is only one.
//! Shares are estimates from counts of steps; no result depends on them.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};

/// Resolution of a share.
const STEPS: f64 = 1e6;

/// Steps between two calls of a listener.
const HUNDREDTH: u32 = 10_000;

/// Share of a computation that is done, from 0 to 1. It never decreases.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicU32,
    is_cancelled: AtomicBool,
    listener: Option<Listener>,
}

struct Listener(Box<dyn Fn(f64) -> bool + Send + Sync>);

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Listener")
    }
}

impl Progress {
    /// Progress that calls `listener` with its share at each hundredth, on a thread of the
    /// computation. If it returns `false`, the computation is cancelled.
    pub fn reported_to(listener: impl Fn(f64) -> bool + Send + Sync + 'static) -> Self {
        Self { listener: Some(Listener(Box::new(listener))), ..Self::default() }
    }

    /// The share that is done.
    pub fn share(&self) -> f64 {
        f64::from(self.done.load(Ordering::Relaxed)) / STEPS
    }

    /// Requests an early end. The result is then unusable.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// The whole computation as one stage.
    pub fn whole(&self) -> Stage<'_> {
        Stage { progress: Some(self), start: 0.0, length: 1.0 }
    }
}

/// One stage of a computation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stage<'a> {
    /// `None`: no other thread reads the progress.
    progress: Option<&'a Progress>,
    start: f64,
    length: f64,
}

impl<'a> Stage<'a> {
    /// The stage between two shares of this one.
    #[must_use]
    pub fn from_to(self, from: f64, to: f64) -> Self {
        Self { start: self.start + from * self.length, length: (to - from) * self.length, ..self }
    }

    /// Reports that this share of the stage is done.
    pub fn reach(self, share: f64) {
        let Some(progress) = self.progress else { return };
        // A cast saturates, and NaN, which `clamp` keeps, becomes 0.
        let reached = ((self.start + share.clamp(0.0, 1.0) * self.length) * STEPS) as u32;
        let before = progress.done.fetch_max(reached, Ordering::Relaxed);
        if let Some(Listener(listener)) = &progress.listener
            && reached / HUNDREDTH > before / HUNDREDTH
            && !listener(f64::from(reached) / STEPS)
        {
            progress.cancel();
        }
    }

    /// Whether the result is no longer wanted.
    pub fn is_cancelled(self) -> bool {
        self.progress.is_some_and(|progress| progress.is_cancelled.load(Ordering::Relaxed))
    }

    /// A counter of `total` steps that make up the stage.
    pub fn steps(self, total: usize) -> Steps<'a> {
        Steps { stage: self, total, done: AtomicUsize::new(0) }
    }
}

/// A counter of steps, which any thread may take.
#[derive(Debug)]
pub struct Steps<'a> {
    stage: Stage<'a>,
    total: usize,
    done: AtomicUsize,
}

impl Steps<'_> {
    /// Counts a step that is done.
    pub fn take(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.stage.reach(done as f64 / self.total.max(1) as f64);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    #[test]
    fn stages_nest_and_never_go_back() {
        let progress = Progress::default();
        let stage = progress.whole().from_to(0.2, 0.8);
        let steps = stage.from_to(0.0, 0.5).steps(4);
        (0..4).for_each(|_| steps.take());
        assert!((progress.share() - 0.5).abs() < 1e-5, "{}", progress.share());
        stage.reach(f64::NAN);
        stage.reach(-1.0);
        assert!((progress.share() - 0.5).abs() < 1e-5);
        stage.reach(7.0);
        assert!((progress.share() - 0.8).abs() < 1e-5);
        Stage::default().steps(0).take();
        progress.cancel();
        assert!(stage.is_cancelled() && !Stage::default().is_cancelled());
    }
    #[test]
    fn a_listener_hears_each_hundredth_once_and_may_cancel() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ears = Arc::clone(&heard);
        let progress = Progress::reported_to(move |share| {
            ears.lock().expect("one thread").push(share);
            share < 0.5
        });
        for share in [0.001, 0.2, 0.2001, 0.1, 0.4] {
            progress.whole().reach(share);
        }
        assert!(!progress.whole().is_cancelled());
        progress.whole().reach(0.5);
        assert!(progress.whole().is_cancelled());
        assert_eq!(*heard.lock().expect("one thread"), [0.2, 0.4, 0.5]);
    }
}
