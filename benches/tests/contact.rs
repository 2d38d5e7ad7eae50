//! The contact table measures a fair sample, and no answer of hullmap in it is wrong.

use hullmap_bench::{
    solver::{
        engines::PairQuery,
        pairs::Mix,
        race::{self, Effort},
        tables,
    },
    subject::SEED,
};

/// The minimum vertex count, and one at which later phases decide too.
const COUNTS: [usize; 2] = [8, 300];

const EFFORT: Effort = Effort { poses: 40, paths: 4, frames: 9, pieces: [12, 4], rounds: 1 };

#[test]
fn sample_is_fair_and_intervals_hold() {
    let records: Vec<_> = COUNTS.into_iter().map(|n| race::run(n, EFFORT)).collect();
    for record in &records {
        let what = format!("n = {}, seed {SEED}", record.n);
        assert_eq!(record.rejected, [""; 0], "{what}");
        assert_eq!(record.vertices, record.n as f64, "{what}: points that are not extreme");
        let d = &record.differences;
        for share in [d.hits as f64 / d.pairs as f64, record.path_hit_share] {
            assert!((0.35..=0.65).contains(&share), "{what}: {share} overlap");
        }
        assert_eq!((d.disproved, d.stalled), (0, 0), "{what}");
        assert!(d.depth.len() >= d.pairs / 3, "{what}: {} depths of {} pairs", d.depth.len(), d.pairs);
        for cell in &record.cells {
            assert!(cell.ns.iter().all(|ns| *ns > 0.0 && ns.is_finite()), "{what}: {cell:?}");
        }
    }
    let count = COUNTS.len() * PairQuery::ALL.len() * Mix::ALL.len();
    let [times, answers] = [tables::times(&records), tables::answers(&records)];
    assert_eq!(times.iter().filter(|row| row.number("parry_ns") > 0.0).count(), count);
    assert_eq!(answers.iter().filter(|row| row.text("measure") == "pairs").count(), COUNTS.len());
}
