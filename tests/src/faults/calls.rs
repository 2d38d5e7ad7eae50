//! A fault at every system call: the Nth, for every N.

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

/// The bake, on one thread: so the Nth call is the same in every run. Packs are verified, for the
/// calls which that takes.
fn words() -> Vec<&'static str> {
    WORDS.into_iter().chain(["--verify", "--jobs", "1"]).collect()
}

/// How the bakes ended.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Calls of an undisturbed bake.
    pub calls: usize,
    /// Bakes that met a fault.
    pub bakes: usize,
    /// Of these, killed.
    pub killed: usize,
    /// Ended with exit code 2 and a message.
    pub told: usize,
    /// Ended with exit code 0, and all was done: what failed was tried again, or does not matter.
    pub absorbed: usize,
    /// Bakes that left some outputs old and others new.
    pub mixed: usize,
    /// Bakes that left temporary files, all of which the next one removed.
    pub with_temporary: usize,
    /// Faults by the name of the call: reported, absorbed.
    pub by_call: BTreeMap<String, [usize; 2]>,
    /// What went wrong.
    pub wrong: Vec<String>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.bakes += other.bakes;
        self.killed += other.killed;
        self.told += other.told;
        self.absorbed += other.absorbed;
        self.mixed += other.mixed;
        self.with_temporary += other.with_temporary;
        for (name, [told, absorbed]) in other.by_call {
            let entry = self.by_call.entry(name).or_default();
            entry[0] += told;
            entry[1] += absorbed;
        }
        self.wrong.extend(other.wrong);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { calls, bakes, killed, told, absorbed, mixed, with_temporary, .. } = self;
        writeln!(
            f,
            "{bakes} bakes of {calls} calls met a fault: {killed} killed, {told} reported it with exit code 2, {absorbed} did all the \
             same; {mixed} left old and new packs, {with_temporary} temporary files that the next removed"
        )?;
        let names =
            self.by_call.iter().map(|(name, [told, absorbed])| format!("{name} {told} reported, {absorbed} absorbed"));
        writeln!(f, "failed calls: {}", names.collect::<Vec<_>>().join("; "))?;
        write!(f, "{} wrong", self.wrong.len())
    }
}

/// Bakes with `fault(n)` at the `n`th call, for every `n`, on `threads` threads.
///
/// # Panics
/// The undisturbed bake fails.
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
            let project = Project::new(binary, 0);
            project.put(&project.old);
            let (run, calls) = injector.run(binary, &words(), project.folder(), 0, Fault::None);
            assert!(run.status.success(), "{run:?}");
            let mut tally = Tally { calls: calls.len(), ..Tally::default() };
            loop {
                let number = next.fetch_add(1, Relaxed);
                if number > calls.len() {
                    return tally;
                }
                tally.add(one(&project, injector, number, fault(number)));
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
    let place = || format!("{fault} at call {number} ({})", at.map_or_else(String::new, shown));
    match project.judge(&run, &calls) {
        Err(error) => tally.wrong.push(format!("{}: {error}", place())),
        Ok((end, left)) => {
            tally.mixed += usize::from(left.new > 0 && left.old > 0);
            tally.with_temporary += usize::from(left.temporary > 0);
            match end {
                End::Killed => tally.killed += 1,
                End::Done => tally.absorbed += 1,
                End::Told => tally.told += 1,
            }
            if let (Some(errno), Some(call)) = (fault.errno(), at) {
                tally.by_call.entry(call.name.clone()).or_default()[usize::from(end == End::Done)] += 1;
                let stderr = String::from_utf8_lossy(&run.stderr);
                if end == End::Told && !stderr.contains(&format!("(os error {})", errno.number())) {
                    tally.wrong.push(format!("{}: the message does not say what failed: {stderr}", place()));
                }
            } else if end == End::Told {
                tally.wrong.push(format!("{}: nothing failed, but: {}", place(), String::from_utf8_lossy(&run.stderr)));
            }
        }
    }
    if let Err(error) = project.bake_again() {
        tally.wrong.push(format!("{}: {error}", place()));
    }
    tally
}

fn shown(call: &Call) -> String {
    format!("{} {}{}{}", call.name, call.path, if call.second.is_empty() { "" } else { " to " }, call.second)
}
