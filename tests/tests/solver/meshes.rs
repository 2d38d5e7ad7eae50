//! Triangle meshes of all kinds, a part of the run of `mesh-truth`.

use hullmap_tests::sheets::Tally;

#[test]
fn meshes_answer_as_brute_force_does() {
    const SEED: u64 = 39;
    let mut tally = Tally::default();
    (0..160).for_each(|index| tally.judge(SEED, index));
    println!("seed {SEED}\n{tally}");
    assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
    let count = |query, outcome| tally.counts.get(&(query, outcome)).copied().unwrap_or_default();
    for (query, outcome, least) in [
        ("intersects", "apart", 300),
        ("intersects", "overlapping", 300),
        ("intersects", "touching", 10),
        ("contact", "deep", 1000),
        ("ray", "hit", 200),
        ("ray", "miss", 200),
        ("cast", "hit", 300),
        ("signed distance", "inside", 20),
        ("signed distance", "outside", 20),
    ] {
        assert!(count(query, outcome) >= least, "{query} {outcome}: {}", count(query, outcome));
    }
}

#[test]
fn rays_at_edges_vertices_and_seams_never_reach_the_surface_behind() {
    const SEED: u64 = 63;
    let mut tally = Tally::default();
    (0..60).for_each(|index| tally.judge_joints(SEED, index));
    println!("seed {SEED}\n{tally}");
    assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
    for query in ["edge", "seam"] {
        for outcome in ["miss", "one", "several"] {
            let count = tally.counts.get(&(query, outcome)).copied().unwrap_or_default();
            assert!(count >= 300, "{query} {outcome}: {count}");
        }
    }
}
