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
    /// Bakes that were killed.
    pub killed: usize,
    /// Bakes that reported the fault: exit code 2 and a message.
    pub reported: usize,
    /// Bakes that ended with exit code 0 and did everything: the call was repeated, or its failure
    /// does not matter.
    pub absorbed: usize,
    /// Bakes that left some outputs old and others new.
    pub mixed: usize,
    /// Bakes that left temporary files. The next bake removed them all.
    pub with_temporary: usize,
    /// Numbers of reported and absorbed faults, by the name of the call.
    pub by_call: BTreeMap<String, [usize; 2]>,
    /// Failed checks.
    pub wrong: Vec<String>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.bakes += other.bakes;
        self.killed += other.killed;
        self.reported += other.reported;
        self.absorbed += other.absorbed;
        self.mixed += other.mixed;
        self.with_temporary += other.with_temporary;
        for (name, [reported, absorbed]) in other.by_call {
            let entry = self.by_call.entry(name).or_default();
            entry[0] += reported;
            entry[1] += absorbed;
        }
        self.wrong.extend(other.wrong);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { calls, bakes, killed, reported, absorbed, mixed, with_temporary, .. } = self;
        writeln!(
            f,
            "{bakes} bakes of {calls} calls met a fault: {killed} killed, {reported} reported it with exit code 2, {absorbed} absorbed it; \
             {mixed} left old and new packs, {with_temporary} left temporary files that the next bake removed"
        )?;
        let names = self
            .by_call
            .iter()
            .map(|(name, [reported, absorbed])| format!("{name} {reported} reported, {absorbed} absorbed"));
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
            tally.mixed += usize::from(left.new > 0 && left.old > 0);
            tally.with_temporary += usize::from(left.temporary > 0);
            match end {
                End::Killed => tally.killed += 1,
                End::Done => tally.absorbed += 1,
                End::Reported => tally.reported += 1,
            }
            if let (Some(errno), Some(call)) = (fault.errno(), at) {
                tally.by_call.entry(call.name.clone()).or_default()[usize::from(end == End::Done)] += 1;
                let stderr = String::from_utf8_lossy(&run.stderr);
                if end == End::Reported && !stderr.contains(&format!("(os error {})", errno.number())) {
                    tally.wrong.push(format!("{}: the message does not name the error: {stderr}", context()));
                }
            } else if end == End::Reported {
                tally.wrong.push(format!(
                    "{}: no call failed, but the bake reported: {}",
                    context(),
                    String::from_utf8_lossy(&run.stderr)
                ));
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
