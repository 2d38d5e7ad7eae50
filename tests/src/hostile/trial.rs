//! Tries changed files on several threads, and counts the outcomes.

use std::{
    fmt,
    ops::AddAssign,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    time::{Duration, Instant},
};

/// Time after which a file counts as hanging. The slowest files take milliseconds.
const HANG_TIME: Duration = Duration::from_secs(60);

/// Interval between checks for a hang.
const CHECK_INTERVAL: Duration = Duration::from_secs(2);

/// Number of files that a thread takes at a time.
const BATCH: usize = 64;

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

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.tried += other.tried;
        self.opened += other.opened;
        if other.slowest.as_ref().map(|(took, _)| *took) > self.slowest.as_ref().map(|(took, _)| *took) {
            self.slowest = other.slowest;
        }
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
    let threads = threads.clamp(1, indices.len().max(1));
    let next = AtomicUsize::new(0);
    let at: Vec<AtomicUsize> = (0..threads).map(|_| AtomicUsize::new(IDLE)).collect();
    let (sum, fault) = (Mutex::new(Tally::default()), Mutex::new(None));
    let (sender, ends) = mpsc::channel();
    std::thread::scope(|scope| {
        for at in &at {
            let (sender, next, sum, fault, try_one) = (sender.clone(), &next, &sum, &fault, &try_one);
            scope.spawn(move || {
                let mut tally = Tally::default();
                let mut file = Vec::new();
                'all: loop {
                    let start = next.fetch_add(BATCH, Ordering::Relaxed);
                    let Some(run) = indices.get(start..indices.len().min(start.saturating_add(BATCH))) else { break };
                    if run.is_empty() {
                        break;
                    }
                    for &index in run {
                        at.store(index, Ordering::Relaxed);
                        let start = Instant::now();
                        let Ok(has_opened) = catch_unwind(AssertUnwindSafe(|| try_one(index, &mut file))) else {
                            *fault.lock().expect("no thread panics while it holds the lock") = Some(index);
                            next.store(indices.len(), Ordering::Relaxed);
                            break 'all;
                        };
                        tally.tried += 1;
                        tally.opened += usize::from(has_opened);
                        let is_slowest =
                            |took: Duration| tally.slowest.as_ref().is_none_or(|(slowest, _)| took > *slowest);
                        let mut took = start.elapsed();
                        // A file may have been slow only because its thread was waiting.
                        for _ in 0..REPETITIONS {
                            if is_slowest(took) {
                                let start = Instant::now();
                                try_one(index, &mut file);
                                took = took.min(start.elapsed());
                            }
                        }
                        if is_slowest(took) {
                            tally.slowest = Some((took, format!("{name}, {index}")));
                        }
                    }
                }
                at.store(IDLE, Ordering::Relaxed);
                *sum.lock().expect("no thread panics while it holds the lock") += tally;
                // After a fault, the receiver may be gone.
                let _ = sender.send(());
            });
        }
        watch(name, &at, &ends);
    });
    if let Some(index) = fault.into_inner().expect("no thread panics while it holds the lock") {
        panic!("{name}: change {index} causes a panic");
    }
    sum.into_inner().expect("no thread panics while it holds the lock")
}

/// Waits for all threads to end, and aborts the process if one hangs.
fn watch(name: &str, at: &[AtomicUsize], ends: &mpsc::Receiver<()>) {
    let mut last: Vec<(usize, Instant)> = at.iter().map(|_| (IDLE, Instant::now())).collect();
    let mut running = at.len();
    while running > 0 {
        match ends.recv_timeout(CHECK_INTERVAL) {
            Ok(()) => running -= 1,
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {}
        }
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
        let seen = Mutex::new(Vec::new());
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
