//! Everyday benchmark of support queries: detects a slower change. `cargo bench -p hullmap-bench`.
//!
//! A run of the closure is a batch of [`BATCH`] queries: divide by it, or read the queries per
//! second. The binary `support-table` compares all rivals, with cold caches and exactness.

use std::{cell::RefCell, fmt, rc::Rc};

use divan::{Bencher, black_box, counter::ItemsCount};
use glam::Vec3;
use hullmap_bench::{
    directions,
    query::{Contestant, Flow},
    rivals,
    subject::{SEED, Subject},
};
use shapes::families::Family;

/// Queries of one batch.
const BATCH: usize = 4096;

const COUNTS: [usize; 5] = [8, 128, 1024, 8192, 65_536];

/// Rivals to watch: ours, and another one to distinguish a slow machine from slow code.
const WATCHED: [&str; 2] = [rivals::DEFAULT_INDEX, "cube map 64"];

/// A rival on a sphere of `n` points.
#[derive(Clone, Copy)]
struct Case {
    rival: &'static str,
    n: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.rival, self.n)
    }
}

/// All rivals on a subject of `n` points.
type Entered = (usize, Rc<Vec<Box<dyn Contestant>>>);

thread_local! {
    /// Rivals created so far, so that each subject is baked once.
    static ENTERED: RefCell<Vec<Entered>> = const { RefCell::new(Vec::new()) };
}

fn entered(n: usize) -> Rc<Vec<Box<dyn Contestant>>> {
    ENTERED.with_borrow_mut(|entered| {
        if let Some((_, entries)) = entered.iter().find(|(of, _)| *of == n) {
            return Rc::clone(entries);
        }
        let entries = Rc::new(rivals::enter(&Subject::new(Family::Sphere, n, SEED)));
        entered.push((n, Rc::clone(&entries)));
        entries
    })
}

fn cases() -> impl Iterator<Item = Case> {
    WATCHED.into_iter().flat_map(|rival| COUNTS.map(|n| Case { rival, n }))
}

fn bench(bencher: Bencher<'_, '_>, case: Case, flow: Flow, dirs: &[Vec3]) {
    let entries = entered(case.n);
    let entry = entries.iter().find(|e| e.name() == case.rival).expect("the rival is entered");
    bencher.counter(ItemsCount::new(dirs.len())).bench_local(|| entry.query_all(flow, black_box(dirs)));
}

#[divan::bench(args = cases())]
fn throughput(bencher: Bencher<'_, '_>, case: Case) {
    bench(bencher, case, Flow::Independent, &directions::random(BATCH, SEED));
}

#[divan::bench(args = cases())]
fn latency(bencher: Bencher<'_, '_>, case: Case) {
    bench(bencher, case, Flow::Dependent, &directions::random(BATCH, SEED));
}

#[divan::bench(args = cases())]
fn coherent(bencher: Bencher<'_, '_>, case: Case) {
    bench(bencher, case, Flow::Dependent, &directions::turning(BATCH, SEED));
}

fn main() {
    divan::main();
}
