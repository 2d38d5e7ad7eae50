//! Tries changed files on several threads, and counts the outcomes.

use std::fmt;
use std::ops::{Add, AddAssign};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use rayon::prelude::*;

/// Time after which a file counts as hanging. The slowest files take milliseconds.
const HANG_TIME: Duration = Duration::from_secs(60);

/// Interval between checks for a hang.
const CHECK_INTERVAL: Duration = Duration::from_secs(2);

/// Number of times that a file which seems to be the slowest is measured again.
const REPETITIONS: usize = 3;

/// In place of a file's index: the thread is between two files.
const IDLE: usize = usize::MAX;

/// Counts of opened and rejected files.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Files that were tried.
    pub tried: usize,
    /// Files that opened, and on which all queries ended.
    pub opened: usize,
    /// Name of the slowest file, and its minimum time over a few runs.
    pub slowest: Option<(Duration, String)>,
}

impl Tally {
    /// Files that did not open.
    pub fn rejected(&self) -> usize {
        self.tried - self.opened
    }

    /// Asserts that neither outcome is rare. Otherwise one half of the requirement is not tested.
    /// Panics if fewer than a twentieth of the files opened, or were rejected.
    pub fn assert_representative(&self) {
        assert!(self.opened * 20 > self.tried && self.rejected() * 20 > self.tried, "{self}");
    }
}

impl Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            opened: self.opened + other.opened,
            slowest: [self.slowest, other.slowest].into_iter().flatten().max_by_key(|(took, _)| *took),
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        *self = std::mem::take(self) + other;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} tried, {} rejected, {} opened", self.tried, self.rejected(), self.opened)?;
        match &self.slowest {
            Some((took, which)) => write!(f, ", slowest {:.3} ms ({which})", took.as_secs_f64() * 1e3),
            None => Ok(()),
        }
    }
}

/// Tries the files `indices` on `threads` threads. `try_one` makes a file, opens it, queries it,
/// and returns whether it opened. Panics if a file causes a panic; the message contains its index.
/// If a file hangs, the process is aborted, because its thread cannot be stopped.
pub fn run(
    name: &str,
    indices: &[usize],
    threads: usize,
    try_one: impl Fn(usize, &mut Vec<u8>) -> bool + Sync,
) -> Tally {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().expect("threads start");
    let at: Vec<AtomicUsize> = (0..pool.current_num_threads()).map(|_| AtomicUsize::new(IDLE)).collect();
    let timed = |index: usize, file: &mut Vec<u8>| {
        let start = Instant::now();
        let opened = catch_unwind(AssertUnwindSafe(|| try_one(index, file)));
        (opened.unwrap_or_else(|_| panic!("{name}: change {index} causes a panic")), start.elapsed())
    };
    let try_next = |(mut tally, mut file): (Tally, Vec<u8>), &index: &usize| {
        let own = &at[rayon::current_thread_index().expect("a thread of the pool")];
        own.store(index, Ordering::Relaxed);
        let (has_opened, mut took) = timed(index, &mut file);
        tally.tried += 1;
        tally.opened += usize::from(has_opened);
        let is_slowest = |took: Duration| tally.slowest.as_ref().is_none_or(|(slowest, _)| took > *slowest);
        // A file may have been slow only because its thread was waiting.
        for _ in 0..REPETITIONS {
            if is_slowest(took) {
                took = took.min(timed(index, &mut file).1);
            }
        }
        if is_slowest(took) {
            tally.slowest = Some((took, format!("{name}, {index}")));
        }
        own.store(IDLE, Ordering::Relaxed);
        (tally, file)
    };
    let (sender, end) = mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| watch(name, &at, end));
        // Dropped at the end, also by a panic.
        let _sender: mpsc::Sender<()> = sender;
        let tallies = indices.par_iter().fold(Default::default, try_next).map(|(tally, _)| tally);
        pool.install(|| tallies.reduce(Tally::default, |sum, tally| sum + tally))
    })
}

/// Aborts the process if a thread hangs, until the sender is dropped.
fn watch(name: &str, at: &[AtomicUsize], end: mpsc::Receiver<()>) {
    let mut last: Vec<(usize, Instant)> = at.iter().map(|_| (IDLE, Instant::now())).collect();
    while end.recv_timeout(CHECK_INTERVAL) == Err(RecvTimeoutError::Timeout) {
        for (at, (index, since)) in at.iter().zip(&mut last) {
            let now = at.load(Ordering::Relaxed);
            if now != *index || now == IDLE {
                (*index, *since) = (now, Instant::now());
            } else if since.elapsed() > HANG_TIME {
                // The thread cannot be stopped, and the scope would wait for it forever.
                eprintln!("{name}: change {now} hangs");
                std::process::abort();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_is_tried_once_and_counted() {
        let indices: Vec<usize> = (0..1000).map(|i| 3 * i).collect();
        let seen = std::sync::Mutex::new(Vec::new());
        let tally = run("all", &indices, 3, |index, _| {
            seen.lock().unwrap().push(index);
            index.is_multiple_of(2)
        });
        let mut seen = seen.into_inner().unwrap();
        seen.sort_unstable();
        // The slowest files are tried several times.
        seen.dedup();
        assert_eq!(seen, indices);
        assert_eq!((tally.tried, tally.opened, tally.rejected()), (1000, 500, 500));
        tally.assert_representative();
        assert!(tally.slowest.is_some());
    }

    #[test]
    #[should_panic(expected = "all: change 700 causes a panic")]
    fn a_panic_names_the_change() {
        let indices: Vec<usize> = (0..1000).collect();
        run("all", &indices, 2, |index, _| {
            assert!(index != 700, "the panic that the test expects");
            true
        });
    }
}
