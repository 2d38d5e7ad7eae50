//! The exactness stated in the tables.

use std::time::Duration;

use glam::Vec3;
use hullmap_bake::IndexKind;
use hullmap_bench::{
    directions,
    regret::{EXACT, Truth},
    subject::{FAMILIES, SEED, Subject, first_hull},
    support::{self, Effort, INDICES, Mode, methods},
};

/// Vertex counts: fewer than a block, not a multiple of one, and enough for f32 plateaus.
const COUNTS: [usize; 3] = [8, 200, 1_500];

/// Number of directions for each subject.
const DIRECTIONS: usize = 1_500;

/// Every method equals brute force in all directions.
#[test]
fn methods_are_exact() {
    for family in FAMILIES {
        for n in COUNTS {
            let subject = Subject::new(family, n, SEED);
            let pack = subject.pack(IndexKind::None).0;
            let hull = first_hull(&pack);
            let dirs = directions::awkward(&hull, DIRECTIONS, SEED);
            let truth = Truth::new(&subject.points, hull.diameter(), dirs);
            let methods = methods(&subject);
            assert!(methods.len() > INDICES.len(), "a method is missing");
            for method in methods {
                let regret = truth.max_regret(&method.answers(truth.dirs()));
                assert!(regret <= EXACT, "{}: {} {n}, regret {regret:e}, seed {SEED}", method.name, family.name());
            }
        }
    }
}

/// Every answer is a vertex, even for invalid directions.
#[test]
fn answers_are_vertices() {
    let subject = Subject::new(FAMILIES[2], 100, SEED);
    let pack = subject.pack(IndexKind::None).0;
    let vertices: Vec<Vec3> = first_hull(&pack).vertices().collect();
    let mut dirs = directions::random(100, SEED);
    dirs.extend([Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)]);
    for method in methods(&subject) {
        for (dir, answer) in dirs.iter().zip(method.answers(&dirs)) {
            assert!(vertices.contains(&answer), "{} in direction {dir}: {answer}", method.name);
        }
    }
}

#[test]
fn every_method_is_timed() {
    let methods = methods(&Subject::new(FAMILIES[0], 32, SEED));
    let effort = Effort { batch: Duration::from_micros(5), rounds: 2 };
    for (name, mode) in Mode::ALL {
        let times = support::time(&methods, mode, effort, SEED);
        assert_eq!(times.len(), methods.len());
        assert!(times.iter().all(|t| t[0] > 0.0 && t[0] <= t[1] && t[2].is_finite()), "{name}: {times:?}");
    }
}
