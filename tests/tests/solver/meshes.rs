//! Triangle meshes of all kinds, a part of the run of `mesh-truth`.

use hullmap_tests::sheets::Tally;

#[test]
fn meshes_answer_as_brute_force_does() {
    const SEED: u64 = 39;
    let mut tally = Tally::default();
    (0..180).for_each(|index| tally.judge(SEED, index));
    println!("seed {SEED}\n{tally}");
    assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
    for (query, outcome, least) in [
        ("intersects", "apart", 300),
        ("intersects", "overlapping", 300),
        ("intersects", "touching", 10),
        ("contact", "deep", 1000),
        ("ray", "hit", 1000),
        ("ray", "miss", 1000),
        ("cast", "hit", 300),
        ("signed distance", "inside", 2000),
        ("signed distance", "outside", 2000),
        ("signed distance", "on", 100),
    ] {
        assert!(tally.of(query, outcome) >= least, "{query} {outcome}: {}", tally.of(query, outcome));
    }
}

#[test]
fn rays_at_edges_vertices_and_seams_never_reach_the_surface_behind() {
    const SEED: u64 = 63;
    let mut tally = Tally::default();
    (0..60).for_each(|index| tally.judge_joints(SEED, index));
    // A ray that ended stalled at an edge where five parts meet.
    tally.judge_joints(1, 1636);
    println!("seed {SEED}\n{tally}");
    assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
    for (query, least) in [("edge", 300), ("seam", 300), ("front", 60), ("cast", 1000), ("cast on fronts", 60)] {
        for outcome in ["miss", "one", "several"] {
            assert!(tally.of(query, outcome) >= least, "{query} {outcome}: {}", tally.of(query, outcome));
        }
    }
}

/// Bodies of all kinds on sheets of all kinds, a part of the run of `mesh-truth --manifolds`.
#[test]
fn every_point_of_a_manifold_is_on_both_surfaces_and_none_is_missing() {
    const SEED: u64 = 63;
    let mut tally = Tally::default();
    (0..320).for_each(|index| tally.judge_manifolds(SEED, index));
    // Sunk bodies, 10 km away, that the weld left without a manifold.
    [(2, 207), (2, 543), (SEED, 975)].into_iter().for_each(|(seed, index)| tally.judge_manifolds(seed, index));
    println!("seed {SEED}\n{tally}");
    assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
    let bodies =
        "cuboid,ball,capsule,cylinder,cone,rounded disc,hull,compound,ellipsoid,scaled hull,rounded hull,triangle";
    for body in bodies.split(',').chain(["half-space"]) {
        assert!(tally.of("point", body) >= 800, "{body}: {}", tally.of("point", body));
    }
    for (what, kind, least) in [
        ("clipped", "cuboid", 5000),
        ("clipped", "hull", 500),
        ("welding", "corrected", 5000),
        ("welding", "removed", 2000),
        ("welded", "yes", 20_000),
        ("welded", "no", 20_000),
        ("status", "within", 2000),
        ("status", "touching", 100),
        ("status", "stalled", 10),
        ("touching", "yes", 20_000),
        ("held", "yes", 1000),
        ("resting", "box", 20),
        ("chosen", "four", 500),
        ("chosen", "more", 1000),
    ] {
        assert!(tally.of(what, kind) >= least, "{what} {kind}: {}", tally.of(what, kind));
    }
}
