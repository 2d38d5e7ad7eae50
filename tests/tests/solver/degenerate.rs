//! Small hulls in degenerate poses, compared with their depth in exact arithmetic. The program
//! `degenerate-truth` does the same for any number of pairs.

use hullmap_tests::degenerate::{Count, Kind, Tally};

const SEED: u64 = 20_261_123;

/// Number of pairs: five hundred of each kind.
const PAIRS: u64 = 3_000;

/// Judges pairs of hulls of at most `most` vertices.
fn judge(pairs: u64, most: usize) -> Tally {
    let mut tally = Tally::default();
    (0..pairs).for_each(|index| tally.judge(SEED, index, most));
    println!("seed {SEED}\n{tally}");
    if let Some(miss) = tally.misses.first() {
        panic!("seed {SEED}: {} misses, the first: {miss}", tally.misses.len());
    }
    assert_eq!(tally.counts.len(), Kind::ALL.len());
    tally
}

#[test]
fn no_interval_excludes_the_exact_depth() {
    let tally = judge(PAIRS, 24);
    for (kind, count) in &tally.counts {
        // Concentric pairs always penetrate.
        let most = if *kind == Kind::Concentric { count.pairs } else { count.pairs * 95 / 100 };
        assert!((count.pairs * 3 / 10..=most).contains(&count.penetrating), "{kind:?}: {count:?}");
        // Touching pairs are left to the general path, and so are depths that f32 cannot rank.
        let least = if *kind == Kind::Touching { 2 } else { 9 };
        assert!(10 * count.by_facets >= least * count.asked, "{kind:?}: {count:?}");
    }
}

/// The exact depth of larger hulls takes longer. Hulls above 32 vertices have no face table.
#[test]
fn no_interval_of_larger_hulls_excludes_the_exact_depth() {
    let tally = judge(PAIRS / 5, 100);
    let sum = |of: fn(&Count) -> u64| tally.counts.values().map(of).sum::<u64>();
    let (decided, asked) = (sum(|count| count.by_facets), sum(|count| count.asked));
    assert!((asked / 5..asked * 4 / 5).contains(&decided), "{decided} of {asked}");
}

/// At a face of this pair, f32 finds the same support point as at the next face, and f64 another
/// one. The minimum is between the two faces.
#[test]
fn an_arc_whose_ends_share_a_support_point_in_f32_only_is_searched() {
    let mut tally = Tally::default();
    tally.judge(4, 1081, 24);
    assert!(tally.misses.is_empty(), "{:?}", tally.misses);
    assert!(tally.counts.values().all(|count| count.penetrating == 1 && count.by_facets == 1), "{tally}");
}
