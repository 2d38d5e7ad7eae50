//! Small hulls in degenerate poses, compared with their depth in exact arithmetic. The program
//! `degenerate-truth` does the same for any number of pairs.

use hullmap_tests::truth::degenerate::{Kind, Tally};

const SEED: u64 = 20_261_123;

/// Number of pairs: a hundred of each kind.
const PAIRS: u64 = 600;

#[test]
fn no_interval_excludes_the_exact_depth() {
    let mut tally = Tally::default();
    (0..PAIRS).for_each(|index| tally.judge(SEED, index));
    println!("seed {SEED}\n{tally}");
    if let Some(miss) = tally.misses.first() {
        panic!("seed {SEED}: {} misses, the first: {miss}", tally.misses.len());
    }
    assert_eq!(tally.counts.len(), Kind::ALL.len());
    for (kind, count) in &tally.counts {
        // Concentric pairs always penetrate.
        let most = if *kind == Kind::Concentric { count.pairs } else { count.pairs * 95 / 100 };
        assert!((count.pairs * 3 / 10..=most).contains(&count.penetrating), "{kind:?}: {count:?}");
        assert!(10 * count.by_facets > count.pairs, "{kind:?}: {count:?}");
    }
}
