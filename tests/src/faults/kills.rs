//! `kill -9` at random moments.

use std::{
    fmt,
    path::Path,
    process::{Child, Stdio},
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
    time::{Duration, Instant},
};

use shapes::rng::SplitMix64;

use super::project::{End, Project, WORDS};

/// Number of additional meshes, so that most of the time is spent on packs.
const MESHES: usize = 12;

/// Maximum number of kills in a row before a bake may finish.
const MAX_IN_A_ROW: u64 = 3;

/// In one kill out of this many, a second bake writes into the same folder and continues.
const SECOND_BAKE_INTERVAL: u64 = 4;

/// Results of the kills.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Bakes that were killed.
    pub killed: usize,
    /// Bakes that ended before they were killed.
    pub ended_before: usize,
    /// Kills that left no new pack, some new packs, or all of them.
    pub none_some_all: [usize; 3],
    /// Kills that left temporary files.
    pub with_temporary: usize,
    /// Temporary files left by all kills.
    pub temporary: usize,
    /// Kills during a second bake, which completed.
    pub beside: usize,
    /// Bakes after a kill that completed and replaced all outputs.
    pub healed: usize,
    /// Errors.
    pub wrong: Vec<String>,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { killed, ended_before, none_some_all: [none, some, all], with_temporary, temporary, .. } = self;
        write!(
            f,
            "{killed} bakes killed ({ended_before} more ended before), {} of them during a second bake: {none} left no new output, \
             {some} some, {all} all; {with_temporary} left {temporary} temporary files; {} bakes afterwards replaced all outputs and \
             left no other file; {} wrong",
            self.beside,
            self.healed,
            self.wrong.len()
        )
    }
}

/// Kills `count` bakes, on `threads` threads. Panics if a bake does not start.
pub fn kill(binary: &Path, count: usize, seed: u64, threads: usize) -> Tally {
    let killed = AtomicUsize::new(0);
    let mut tally = Tally::default();
    std::thread::scope(|scope| {
        let killed = &killed;
        let work = |thread: u64| move || work(binary, killed, count, seed.wrapping_mul(1000) + thread);
        let handles: Vec<_> = (0..threads.max(1) as u64).map(|thread| scope.spawn(work(thread))).collect();
        for handle in handles {
            let part = handle.join().expect("a failure is recorded, not thrown");
            tally.killed += part.killed;
            tally.ended_before += part.ended_before;
            (0..3).for_each(|i| tally.none_some_all[i] += part.none_some_all[i]);
            tally.with_temporary += part.with_temporary;
            tally.temporary += part.temporary;
            tally.beside += part.beside;
            tally.healed += part.healed;
            tally.wrong.extend(part.wrong);
        }
    });
    tally
}

fn work(binary: &Path, killed: &AtomicUsize, count: usize, seed: u64) -> Tally {
    let project = Project::new(binary, MESHES);
    let (mut random, mut tally) = (SplitMix64::new(seed), Tally::default());
    project.put(&project.old);
    let start = Instant::now();
    let _ = spawn(&project).wait_with_output();
    // Adjusted so that about one bake in four ends before it is killed: kills reach every moment.
    let mut longest = start.elapsed();
    while killed.load(Relaxed) < count {
        project.put(&project.old);
        for _ in 0..1 + random.next_u64() % MAX_IN_A_ROW {
            let wait = longest.mul_f64(random.next_u64() as f64 / u64::MAX as f64);
            let beside = (random.next_u64() % SECOND_BAKE_INTERVAL == 0).then(|| spawn(&project));
            let mut victim = spawn(&project);
            std::thread::sleep(wait);
            let _ = victim.kill();
            let run = victim.wait_with_output().expect("it was started");
            let beside = beside.map(|other| other.wait_with_output().expect("it was started"));
            let fail = |error| format!("seed {seed}, killed after {wait:?}: {error}");
            // The results of the other bake do not count for this one.
            if let Some(other) = &beside {
                match project.judge(other, &[]) {
                    Ok((End::Done, _)) => tally.beside += 1,
                    // The files that the killed bake left are not an error of the other.
                    Err(error) if error.starts_with("temporary files are left") => tally.beside += 1,
                    Ok(_) => tally.wrong.push(fail(format!("the other bake failed: {other:?}"))),
                    Err(error) => tally.wrong.push(fail(error)),
                }
            }
            if run.status.code().is_some() {
                tally.ended_before += 1;
                longest = longest.mul_f64(0.97);
            } else {
                tally.killed += 1;
                killed.fetch_add(1, Relaxed);
                longest = longest.mul_f64(1.01).min(Duration::from_secs(10));
            }
            match project.judge(&run, &[]) {
                Err(error) if run.status.code().is_none() => tally.wrong.push(fail(error)),
                Err(error) if !error.starts_with("temporary files are left") => tally.wrong.push(fail(error)),
                Ok((End::Killed, left)) => {
                    let kind = if left.new == 0 { 0 } else { 1 + usize::from(left.old == 0) };
                    tally.none_some_all[kind] += 1;
                    tally.with_temporary += usize::from(left.temporary > 0);
                    tally.temporary += left.temporary;
                }
                _ => {}
            }
        }
        match project.bake_again() {
            Ok(()) => tally.healed += 1,
            Err(error) => tally.wrong.push(format!("seed {seed}: {error}")),
        }
    }
    tally
}

fn spawn(project: &Project) -> Child {
    let mut command = project.command(&WORDS);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("bake starts")
}
