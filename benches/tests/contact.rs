//! The contact table measures a fair sample, and no answer of hullmap in it is wrong.

use hullmap_bench::{
    csv,
    solver::{
        engines::PairQuery,
        race::{self, Effort, Mix},
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
        for share in [record.hit_share, record.coherent_hit_share] {
            assert!((0.35..=0.65).contains(&share), "{what}: {share} overlap");
        }
        let d = &record.differences;
        assert_eq!((d.disproved, d.stalled), (0, 0), "{what}");
        assert!(d.depth.len() >= d.pairs / 3, "{what}: {} depths of {} pairs", d.depth.len(), d.pairs);

        assert_eq!(record.cold.len(), PairQuery::ALL.len() * Mix::ALL.len());
        assert_eq!(record.coherent.len(), PairQuery::ALL.len() * Mix::ALL.len());
        for cell in &record.cold {
            assert!([cell.hullmap_ns, cell.parry_ns].iter().all(|ns| *ns > 0.0 && ns.is_finite()), "{what}: {cell:?}");
        }
    }
    let goals = tables::goals(&records).to_text();
    assert!(goals.contains("contact, cold") && goals.contains("0.30"), "{goals}");
    assert_eq!(tables::reached(&records)[1], 9, "8 points have goals cold and warm, 300 only warm ones");

    let times = tables::to_csv(&records);
    let rows = csv::parse(times.as_str()).unwrap();
    assert_eq!(rows.len(), COUNTS.len() * PairQuery::ALL.len() * Mix::ALL.len());
    assert!(rows.iter().flatten().all(|(_, value)| !value.is_empty()));
    let answers = tables::answers_to_csv(&records);
    assert_eq!(csv::parse(answers.as_str()).unwrap().len(), COUNTS.len() * 22);
}
