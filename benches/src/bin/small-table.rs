//! Contact of small hulls by the separating axis test beside the general path (MPR and EPA), on the
//! same pairs, interleaved in one run. All caches are empty.

use std::hint::black_box;

use clap::Parser;
use hullmap::{
    Cache, Contact, Hull, Pack, Pose, Settings, SupportMap, contact, glam::DVec3, intersects, solver::contact_by_facets,
};
use hullmap_bench::{
    clock,
    solver::pairs::{BakedPair, Class, FAMILIES, Placed},
    subject::SEED,
};
use hullmap_testkit::{faceless::Faceless, packs};
use shapes::rng::SplitMix64;

/// Compares contact with and without the separating axis test for small hulls.
#[derive(Parser)]
struct Arguments {
    /// Point counts, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "8,12,16,24,32")]
    n: Vec<usize>,
    /// Poses of each class
    #[arg(long, default_value_t = 200)]
    poses: usize,
    /// Rounds; the median counts
    #[arg(long, default_value_t = 15)]
    rounds: usize,
}

fn time<A: SupportMap, B: SupportMap>(a: &A, b: &B, poses: &[Placed]) -> f64 {
    let settings = Settings::default();
    let all = clock::time_ns(|| {
        for placed in poses {
            black_box(contact(a, b, placed.b_in_a, &settings, &mut Cache::new()));
        }
    });
    all / poses.len() as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn row(name: &str, [a, b]: [Hull<'_>; 2], poses: &[Placed], rounds: usize) {
    let [general_a, general_b] = [Faceless(a), Faceless(b)];
    print!("{name:<24}");
    for class in Class::ALL {
        let poses: Vec<Placed> = poses.iter().filter(|placed| placed.class == class).copied().collect();
        let mut times = [(); 2].map(|()| Vec::new());
        for _ in 0..rounds {
            times[0].push(time(&general_a, &general_b, &poses));
            times[1].push(time(&a, &b, &poses));
        }
        let [general, sat] = times.map(median);
        print!(" | {general:5.0} {sat:5.0} {:4.2}", sat / general);
    }
    // How often the test leaves an overlapping pair to the general path.
    let fell_back = |placed: &&Placed| {
        let settings = Settings::default();
        let general: Contact = contact(&general_a, &general_b, placed.b_in_a, &settings, &mut Cache::new());
        let found = contact(&a, &b, placed.b_in_a, &settings, &mut Cache::new());
        assert!((found.depth - general.depth).abs() <= 2e-5 * general.depth + 1e-11, "{found:?} {general:?}");
        found.hit && contact_by_facets(&a, &b, placed.b_in_a, &settings).is_none()
    };
    let count = poses.iter().filter(fell_back).count();
    println!(" | {:.1} % general", 100.0 * count as f64 / poses.len() as f64);
}

fn bevelled_box(bevels: usize) -> Vec<[f32; 3]> {
    // 8, 16, 24 or 32 vertices: bevels along one axis, along two, at the corners.
    let mut points = Vec::new();
    for corner in 0..8 {
        let sign = |axis: usize| if corner >> axis & 1 == 0 { 1.0_f32 } else { -1.0 };
        let full = [1.0_f32, 0.8, 0.6];
        let at = |cut: [f32; 3]| std::array::from_fn(|axis| sign(axis) * (full[axis] - cut[axis]));
        match bevels {
            0 => points.push(at([0.0; 3])),
            1 => points.extend([at([0.2, 0.0, 0.0]), at([0.0, 0.2, 0.0])]),
            _ => points.extend([at([0.2, 0.2, 0.0]), at([0.2, 0.0, 0.2]), at([0.0, 0.2, 0.2])]),
        }
    }
    points
}

fn main() {
    let arguments = Arguments::parse();
    println!("ns: general, SAT, ratio; penetrating | near touching | separated");
    let mut rng = SplitMix64::new(SEED);
    for n in &arguments.n {
        for family in FAMILIES {
            let Some(pair) = BakedPair::bake(family, *n, SEED) else { continue };
            let poses = pair.poses(arguments.poses, &mut rng);
            row(&format!("{} {n}", family.name()), pair.hulls(), &poses, arguments.rounds);
        }
    }
    for bevels in 0..3 {
        let pack: Pack = packs::tree_pack(&bevelled_box(bevels));
        let hull = pack.hull(0).expect("a hull");
        let mut placed = Vec::new();
        while placed.len() < 3 * arguments.poses {
            let class = Class::ALL[placed.len() % 3];
            let rotation = hullmap::glam::DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
            let direction = DVec3::from_array(rng.direction());
            let [low, high] = class.shares();
            let reach = hullmap_bench::solver::pairs::touching_distance(&hull, &hull, rotation, direction);
            let pose = Pose::new(direction * reach * rng.between(low, high), rotation).expect("finite");
            assert!(class != Class::Separated || !intersects(&hull, &hull, pose, &mut Cache::new()).is_hit());
            let parry = hullmap_bench::solver::pairs::Placed::from_pose(class, pose);
            placed.push(parry);
        }
        row(&format!("bevelled box {}", hull.vertex_count()), [hull, hull], &placed, arguments.rounds);
    }
}
