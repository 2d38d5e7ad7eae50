//! What the contact table says is of a fair sample, and no answer of ours in it is wrong.

use hullmap_bench::{
    solver::{
        engines::Query,
        race::{self, Effort, Mix},
        tables,
    },
    subject::SEED,
};

/// Fewest hulls' vertices, and enough that phases beyond the first decide.
const COUNTS: [usize; 2] = [8, 300];

const EFFORT: Effort = Effort { poses: 40, paths: 4, frames: 9, pieces: [12, 4], rounds: 1 };

#[test]
fn the_sample_is_fair_and_our_answers_hold() {
    let records: Vec<_> = COUNTS.into_iter().map(|n| race::run(n, EFFORT)).collect();
    for record in &records {
        let what = format!("n = {}, seed {SEED}", record.n);
        assert_eq!(record.refused, [""; 0], "{what}");
        assert_eq!(record.vertices, record.n as f64, "{what}: points that are not extreme");
        for share in [record.hit_share, record.coherent_hit_share] {
            assert!((0.35..=0.65).contains(&share), "{what}: {share} overlap");
        }
        let d = &record.differences;
        assert_eq!((d.disproved, d.stalled), (0, 0), "{what}");
        assert!(d.depth.len() >= d.pairs / 3, "{what}: {} depths of {} pairs", d.depth.len(), d.pairs);

        assert_eq!(record.cold.len(), Query::ALL.len() * Mix::ALL.len());
        assert_eq!(record.coherent.len(), Query::ALL.len() * Mix::ALL.len());
        for cell in &record.cold {
            assert!([cell.ours_ns, cell.parry_ns].iter().all(|ns| *ns > 0.0 && ns.is_finite()), "{what}: {cell:?}");
        }
    }
    let tables = tables::all(&records);
    let head = tables[0].to_text();
    assert!(head.contains("contact, target") && head.contains("0.30"), "{head}");
    assert_eq!(tables::reached(&records)[1], 9, "8 points have targets cold and warm, 300 only warm ones");
}
