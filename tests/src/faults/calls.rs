//! A fault at the Nth system call, for every N.

use std::{
    collections::BTreeMap,
    fmt,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

use super::{
    inject::{Call, Fault, Injector},
    project::{End, Project, WORDS},
};

/// Arguments of the bake. It uses one thread, so that the Nth call is the same in every run, and
/// verifies packs, so that the calls of verification are tested too.
fn words() -> Vec<&'static str> {
    WORDS.into_iter().chain(["--verify", "--jobs", "1"]).collect()
}

/// Counts of how the bakes ended.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Calls of an undisturbed bake.
    pub calls: usize,
    /// Bakes that met a fault.
    pub bakes: usize,
    /// Bakes that were killed, or reported the fault by exit code 2 and a message, or absorbed it:
    /// they ended with exit code 0 and did everything. Some of them are mixed: they left old and
    /// new outputs. The temporary files of others were removed by the next bake.
    outcomes: BTreeMap<&'static str, usize>,
    /// Failed calls, by their name and how the bake ended.
    by_call: BTreeMap<(String, &'static str), usize>,
    /// Failed checks.
    pub wrong: Vec<String>,
}

impl Tally {
    /// Number of bakes with an outcome.
    pub fn of(&self, outcome: &str) -> usize {
        self.outcomes.get(outcome).copied().unwrap_or_default()
    }

    fn note(&mut self, outcome: &'static str, is_met: bool) {
        *self.outcomes.entry(outcome).or_default() += usize::from(is_met);
    }

    fn add(&mut self, other: Self) {
        self.bakes += other.bakes;
        other.outcomes.into_iter().for_each(|(key, count)| *self.outcomes.entry(key).or_default() += count);
        other.by_call.into_iter().for_each(|(key, count)| *self.by_call.entry(key).or_default() += count);
        self.wrong.extend(other.wrong);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcomes: Vec<String> = self.outcomes.iter().map(|(name, count)| format!("{count} {name}")).collect();
        writeln!(f, "{} bakes of {} calls met a fault: {}", self.bakes, self.calls, outcomes.join(", "))?;
        let names = self.by_call.iter().map(|((name, end), count)| format!("{name} {count} {end}"));
        writeln!(f, "failed calls: {}", names.collect::<Vec<_>>().join("; "))?;
        write!(f, "{} wrong", self.wrong.len())
    }
}

/// Bakes with `fault(n)` at the `n`th call, for every `n`, on `threads` threads. Panics if the
/// undisturbed bake fails.
pub fn at_every_call(
    binary: &Path,
    injector: &Injector,
    threads: usize,
    fault: impl Fn(usize) -> Fault + Sync,
) -> Tally {
    let next = AtomicUsize::new(1);
    let mut tally = Tally::default();
    std::thread::scope(|scope| {
        let work = || {
            let project = Project::new(binary);
            project.put(&project.old);
            let (run, calls) = injector.run(binary, &words(), project.folder(), 0, Fault::None);
            assert!(run.status.success(), "{run:?}");
            let mut tally = Tally { calls: calls.len(), ..Tally::default() };
            loop {
                let call = next.fetch_add(1, Relaxed);
                if call > calls.len() {
                    return tally;
                }
                tally.add(one(&project, injector, call, fault(call)));
            }
        };
        let handles: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        for handle in handles {
            let part = handle.join().expect("a failure is recorded, not thrown");
            tally.calls = part.calls;
            tally.add(part);
        }
    });
    tally
}

fn one(project: &Project, injector: &Injector, number: usize, fault: Fault) -> Tally {
    let mut tally = Tally { bakes: 1, ..Tally::default() };
    project.put(&project.old);
    let (run, calls) = injector.run(project.binary(), &words(), project.folder(), number, fault);
    let at = calls.get(number - 1).or(calls.last());
    let context = || format!("{fault} at call {number} ({})", at.map_or_else(String::new, shown));
    match project.judge(&run, &calls) {
        Err(error) => tally.wrong.push(format!("{}: {error}", context())),
        Ok((end, left)) => {
            let outcome = match end {
                End::Killed => "killed",
                End::Done => "absorbed",
                End::Reported => "reported",
            };
            tally.note(outcome, true);
            tally.note("mixed", left.new > 0 && left.old > 0);
            tally.note("with temporary files", left.temporary > 0);
            let stderr = String::from_utf8_lossy(&run.stderr);
            let expected = fault.errno().filter(|_| at.is_some()).map(|errno| format!("(os error {errno})"));
            if let (Some(_), Some(call)) = (&expected, at) {
                *tally.by_call.entry((call.name.clone(), outcome)).or_default() += 1;
            }
            if end == End::Reported && !expected.as_ref().is_some_and(|error| stderr.contains(error)) {
                tally.wrong.push(format!("{}: reported, expected {expected:?}: {stderr}", context()));
            }
        }
    }
    if let Err(error) = project.bake_again() {
        tally.wrong.push(format!("{}: {error}", context()));
    }
    tally
}

fn shown(call: &Call) -> String {
    format!("{} {}{}{}", call.name, call.path, if call.second.is_empty() { "" } else { " to " }, call.second)
}
