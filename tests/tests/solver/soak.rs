//! The solver on 100,000 pairs. A certificate verifies each answer. The program `solver-soak` does
//! this for any number of pairs, and the nightly run for a million.

use hullmap_tests::{
    game_hulls,
    soak::{
        Queries,
        bodies::{Bodies, Stock},
        body::Kind,
        manifolds::FRAMES,
        meeting::Meeting,
        soak,
        tally::Tally,
    },
};

/// Pairs 0 to 99,999 of this seed.
const SEED: u64 = 20_261_121;
const PAIRS: u64 = 100_000;

/// One game hull out of this many is used. Baking all of them without optimization would take
/// longer than judging the pairs.
const STRIDE: usize = 32;

/// Maximum shares of undecided, stalled or limited answers, for `intersects`, `contact` and
/// `distance`: curved shapes that graze each other, and flat shapes within the rounding error.
const UNSETTLED: [f64; 3] = [2e-3, 5e-3, 2e-2];

/// Judges queries about generated bodies and `clouds`. Panics if an answer is wrong.
fn judged(queries: Queries, clouds: &[Vec<[f32; 3]>], pairs: u64) -> Tally {
    let stock = Stock::bake(clouds, STRIDE);
    let bodies = Bodies::new(&stock);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let tally = soak(&bodies, queries, SEED, 0..pairs, threads);
    println!("{queries:?}, seed {SEED}, bodies {:?}, not baked {:?}\n{tally}", bodies.counts, stock.rejected);
    let wrong: Vec<String> = tally.wrongs().take(3).map(|wrong| wrong.to_string()).collect();
    assert!(wrong.is_empty(), "{queries:?}, seed {SEED}: {:?}\n{}", tally.wrong, wrong.join("\n"));
    tally
}

#[test]
fn every_answer_has_a_certificate() {
    let clouds = game_hulls::clouds("the game hulls of the soak, generated shapes alone").unwrap_or_default();
    let tally = judged(Queries::Pairs, &clouds, PAIRS);
    assert_eq!(tally.pairs, PAIRS);
    // The sample is representative.
    assert!((0.35..=0.65).contains(&tally.hits()), "one-sided: {} hit", tally.hits());
    assert_eq!(tally.meetings.len(), 6);
    let [inside, deep] = tally.meetings[&Meeting::Inside];
    assert!(deep > PAIRS / 20 && deep > inside / 2, "{deep} of {inside} inside");
    let touching = tally.statuses[0]["touching"] as f64 / tally.judged as f64;
    assert!((0.1..=0.4).contains(&touching), "{touching} touch");
    for kind in [Kind::Family, Kind::Sliver, Kind::Flat, Kind::Closed] {
        assert!(tally.kinds[&kind] > PAIRS / 50, "{kind:?}");
    }
    assert!(clouds.is_empty() || tally.kinds[&Kind::Game] > PAIRS / 10);
    assert!(tally.normals > PAIRS / 20 && tally.facets > PAIRS / 50);
    for (which, share) in UNSETTLED.into_iter().enumerate() {
        let of = |status: &str| tally.statuses[which].get(status).copied().unwrap_or(0);
        let unsettled = of("undecided") + of("stalled") + of("iteration_limit");
        assert!(unsettled as f64 <= share * tally.judged as f64, "{which}: {unsettled} of {}", tally.judged);
    }
}

#[test]
fn the_tally_does_not_depend_on_threads_or_pieces() {
    let stock = Stock::bake(&[], 1);
    let bodies = Bodies::new(&stock);
    let alone = soak(&bodies, Queries::Pairs, SEED, 0..10_000, 1);
    for threads in [2, 16] {
        assert_eq!(soak(&bodies, Queries::Pairs, SEED, 0..10_000, threads), alone, "{threads} threads");
    }
    let mut pieces = soak(&bodies, Queries::Pairs, SEED, 0..3_333, 2);
    pieces.add(soak(&bodies, Queries::Pairs, SEED, 3_333..10_000, 2));
    assert_eq!(pieces, alone);
}

/// Rays, shape casts, signed distances and half-spaces, with certificates of their own. The program
/// `solver-soak` does this for any number of them.
#[test]
fn every_ray_cast_point_and_half_space_has_a_certificate() {
    for queries in [Queries::Rays, Queries::Casts, Queries::Points, Queries::HalfSpaces] {
        let tally = judged(queries, &[], PAIRS / 4);
        assert_eq!(tally.judged, PAIRS / 4);
        // The sample is representative: hits, misses and grazing paths, many of them with all
        // planes. Half-spaces are judged by their own plane.
        let by_planes = tally.normals + tally.facets;
        assert!(by_planes > PAIRS / 80 || queries == Queries::HalfSpaces, "{queries:?}: {by_planes}");
        let settled = tally.of("exact") + tally.of("within");
        assert!(settled > PAIRS / 20, "{queries:?}: {settled}");
        let statuses: &[&str] = match queries {
            Queries::Points => &[],
            // Counted by the contact.
            Queries::HalfSpaces => &["separated", "touching"],
            _ => &["separated", "overlapping", "touching"],
        };
        for status in statuses {
            // Rays at polytopes never graze: they are decided exactly.
            let least = if queries == Queries::Rays && *status == "touching" { PAIRS / 300 } else { PAIRS / 200 };
            assert!(tally.of(status) > least, "{queries:?}: {status} {}", tally.of(status));
        }
    }
}

/// Manifolds of pairs that move: points on both surfaces, depths along the normal. The program
/// `solver-soak` does this for any number of pairs, and the nightly run for a million updates.
#[test]
fn every_point_of_a_manifold_has_a_certificate() {
    let pairs = PAIRS / 20;
    let tally = judged(Queries::Manifolds, &[], pairs);
    assert_eq!(tally.judged, pairs * FRAMES);
    // The sample is representative.
    for count in ["no points", "one point", "two points", "three points", "four points"] {
        assert!(tally.of(count) > tally.judged / 50, "{count}: {}", tally.of(count));
    }
    assert!(tally.of("kept") > tally.judged / 2, "{} points kept", tally.of("kept"));
}

/// Times of impact of pairs that move and turn. The program `solver-soak` does this for any number
/// of pairs, and the nightly run for a million.
#[test]
fn every_time_of_impact_has_a_certificate() {
    let pairs = PAIRS / 2;
    let tally = judged(Queries::Motions, &[], pairs);
    assert_eq!(tally.judged, pairs);
    // The sample is representative, and the work small.
    for status in ["separated", "overlapping", "touching", "within"] {
        assert!(tally.of(status) > pairs / 20, "{status}: {}", tally.of(status));
    }
    assert!(
        tally.of("at most 8 queries") > pairs * 3 / 4 && tally.of("iteration_limit") < pairs / 200,
        "{:?}",
        tally.lines
    );
}

/// Times of impact of small hulls, in exact arithmetic, for all times. The program `solver-soak`
/// does this for any number of motions.
#[test]
fn screws_of_small_hulls_agree_with_exact_arithmetic() {
    let motions = 400;
    let tally = judged(Queries::Screws, &[], motions);
    // The sample is representative: hits, misses and grazing motions. Nearly all are decided.
    for status in ["separated", "overlapping", "touching", "within"] {
        assert!(tally.of(status) > motions / 20, "{status}: {}", tally.of(status));
    }
    assert!(tally.of("not decided") <= motions / 200, "{:?}", tally.lines);
}

/// Derivatives of answers about hulls. Uncertain ones are flagged, and are very rare.
#[test]
fn derivatives_agree_with_central_differences() {
    let tally = judged(Queries::Derivatives, &[], PAIRS / 4);
    // Derivatives of normals and points are counted, too.
    let witnesses: u64 =
        tally.lines.iter().filter(|(what, _)| what.starts_with("witness: ")).map(|(_, count)| count).sum();
    let values = tally.judged - witnesses;
    for kind in ["distance", "depth", "ray", "cast"] {
        assert!(tally.of(kind) > values / 20, "{kind}: {}", tally.of(kind));
    }
    assert!(tally.of("judged") * 10 > values * 9 && tally.of("kink in the step") * 500 < values, "{:?}", tally.lines);
    assert!(witnesses > values / 4 && tally.of("witness: judged") * 10 > witnesses * 9, "{:?}", tally.lines);
}
