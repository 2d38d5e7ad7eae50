//! Changed files tried on several threads, and the counts.

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

/// A file that takes longer hangs. The slowest takes milliseconds.
const HANG: Duration = Duration::from_secs(60);

/// Interval between checks for a hang.
const LOOK: Duration = Duration::from_secs(2);

/// Files that a thread takes at a time.
const RUN: usize = 64;

/// Number of repetitions of an apparently slowest file.
const AGAIN: usize = 3;

/// No index: a thread between two files.
const NONE: usize = usize::MAX;

/// Counts of opened and refused files.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Files tried.
    pub tried: usize,
    /// Those that opened, and answered.
    pub opened: usize,
    /// The slowest file, and its fastest time of a few.
    pub slowest: Option<(Duration, String)>,
}

impl Tally {
    /// Those that did not open.
    pub fn refused(&self) -> usize {
        self.tried - self.opened
    }

    /// Asserts that neither outcome is rare, because otherwise one of the two promises is not
    /// tested.
    ///
    /// # Panics
    /// If less than a twentieth opened, or was refused.
    pub fn assert_representative(&self) {
        assert!(self.opened * 20 > self.tried && self.refused() * 20 > self.tried, "{self}");
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
        write!(f, "{} tried, {} refused, {} opened", self.tried, self.refused(), self.opened)?;
        match &self.slowest {
            Some((took, which)) => write!(f, ", slowest {:.3} ms ({which})", took.as_secs_f64() * 1e3),
            None => Ok(()),
        }
    }
}

/// Tries the files `numbers` on `threads` threads. `one` makes a file, opens it and queries it, and
/// returns whether it opened.
///
/// # Panics
/// If a file panics; the message has its index. If one hangs, the process is aborted, because its
/// thread cannot be ended.
pub fn run(name: &str, numbers: &[usize], threads: usize, one: impl Fn(usize, &mut Vec<u8>) -> bool + Sync) -> Tally {
    let threads = threads.clamp(1, numbers.len().max(1));
    let next = AtomicUsize::new(0);
    let at: Vec<AtomicUsize> = (0..threads).map(|_| AtomicUsize::new(NONE)).collect();
    let (sum, fault) = (Mutex::new(Tally::default()), Mutex::new(None));
    let (sender, ends) = mpsc::channel();
    std::thread::scope(|scope| {
        for at in &at {
            let (sender, next, sum, fault, one) = (sender.clone(), &next, &sum, &fault, &one);
            scope.spawn(move || {
                let mut tally = Tally::default();
                let mut file = Vec::new();
                'all: loop {
                    let start = next.fetch_add(RUN, Ordering::Relaxed);
                    let Some(run) = numbers.get(start..numbers.len().min(start.saturating_add(RUN))) else { break };
                    if run.is_empty() {
                        break;
                    }
                    for &number in run {
                        at.store(number, Ordering::Relaxed);
                        let start = Instant::now();
                        let Ok(has_opened) = catch_unwind(AssertUnwindSafe(|| one(number, &mut file))) else {
                            *fault.lock().expect("no panic while it is held") = Some(number);
                            next.store(numbers.len(), Ordering::Relaxed);
                            break 'all;
                        };
                        tally.tried += 1;
                        tally.opened += usize::from(has_opened);
                        let is_slowest =
                            |took: Duration| tally.slowest.as_ref().is_none_or(|(slowest, _)| took > *slowest);
                        let mut took = start.elapsed();
                        // A file that was slow because the thread had to wait is faster the second
                        // time.
                        for _ in 0..AGAIN {
                            if is_slowest(took) {
                                let start = Instant::now();
                                one(number, &mut file);
                                took = took.min(start.elapsed());
                            }
                        }
                        if is_slowest(took) {
                            tally.slowest = Some((took, format!("{name}, {number}")));
                        }
                    }
                }
                at.store(NONE, Ordering::Relaxed);
                *sum.lock().expect("no panic while it is held") += tally;
                // The watch may be over after a fault.
                let _ = sender.send(());
            });
        }
        watch(name, &at, &ends);
    });
    if let Some(number) = fault.into_inner().expect("no panic while it is held") {
        panic!("{name}: change {number} makes it panic");
    }
    sum.into_inner().expect("no panic while it is held")
}

/// Waits for all threads to end.
fn watch(name: &str, at: &[AtomicUsize], ends: &mpsc::Receiver<()>) {
    let mut last: Vec<(usize, Instant)> = at.iter().map(|_| (NONE, Instant::now())).collect();
    let mut running = at.len();
    while running > 0 {
        match ends.recv_timeout(LOOK) {
            Ok(()) => running -= 1,
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {}
        }
        for (at, (number, since)) in at.iter().zip(&mut last) {
            let now = at.load(Ordering::Relaxed);
            if now != *number || now == NONE {
                (*number, *since) = (now, Instant::now());
            } else if since.elapsed() > HANG {
                // The thread cannot be ended, and the scope would wait for it forever.
                eprintln!("{name}: change {now} makes it hang");
                std::process::abort();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_tried_once_and_counted() {
        let numbers: Vec<usize> = (0..1000).map(|i| 3 * i).collect();
        let seen = Mutex::new(Vec::new());
        let tally = run("all", &numbers, 3, |number, _| {
            seen.lock().unwrap().push(number);
            number.is_multiple_of(2)
        });
        let mut seen = seen.into_inner().unwrap();
        seen.sort_unstable();
        // The slowest is tried more often.
        seen.dedup();
        assert_eq!(seen, numbers);
        assert_eq!((tally.tried, tally.opened, tally.refused()), (1000, 500, 500));
        tally.assert_representative();
        assert!(tally.slowest.is_some());
    }

    #[test]
    #[should_panic(expected = "all: change 700 makes it panic")]
    fn a_panic_names_the_change() {
        let numbers: Vec<usize> = (0..1000).collect();
        run("all", &numbers, 2, |number, _| {
            assert!(number != 700, "as it must");
            true
        });
    }
}
