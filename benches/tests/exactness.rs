//! The exactness stated in the tables.

use glam::Vec3;
use hullmap_bench::{
    directions,
    eviction::Eviction,
    measure::{self, Effort, Mode},
    regret::{EXACT, Truth},
    rivals::{self, INDICES},
    subject::{FAMILIES, SEED, Subject},
};

/// Vertex counts: fewer than a block, not a multiple of one, and enough for f32 plateaus.
const COUNTS: [usize; 3] = [8, 200, 1_500];

/// Number of directions for each subject.
const DIRECTIONS: usize = 1_500;

/// Every rival equals brute force in all directions.
#[test]
fn rivals_are_exact() {
    for family in FAMILIES {
        for n in COUNTS {
            let subject = Subject::new(family, n, SEED);
            let truth = Truth::new(&subject, directions::awkward(&subject, DIRECTIONS, SEED));
            let entries = rivals::enter(&subject);
            assert!(entries.len() > INDICES.len(), "a rival is missing");
            for entry in entries {
                let regret = truth.max_regret(&entry.answers(truth.dirs()));
                assert!(regret <= EXACT, "{}: {} {n}, regret {regret:e}, seed {SEED}", entry.name(), family.name());
            }
        }
    }
}

/// Every answer is a vertex, even for invalid directions.
#[test]
fn answers_are_vertices() {
    let subject = Subject::new(FAMILIES[2], 100, SEED);
    let vertices: Vec<Vec3> = subject.vertices().collect();
    let mut dirs = directions::random(100, SEED);
    dirs.extend([Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)]);
    for entry in rivals::enter(&subject) {
        for (dir, answer) in dirs.iter().zip(entry.answers(&dirs)) {
            assert!(vertices.contains(&answer), "{} in direction {dir}: {answer}", entry.name());
        }
    }
}

#[test]
fn every_rival_is_timed() {
    let subject = Subject::new(FAMILIES[0], 32, SEED);
    let mut entries = rivals::enter(&subject);
    let effort = Effort { batch: std::time::Duration::from_micros(5), rounds: 2, cold_rounds: 1 };
    let mut eviction = Eviction::new();
    for mode in Mode::ALL {
        let timings = measure::time(&mut entries, mode, effort, &mut eviction, SEED);
        assert_eq!(timings.len(), entries.len());
        assert!(timings.iter().all(|t| t.median_ns > 0.0 && t.median_ns.is_finite()), "{timings:?}");
    }
}
