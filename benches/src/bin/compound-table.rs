//! Prints the time and the work of compound queries, beside parry3d's `Compound`: sheets of 1 to
//! 1,024 rocks against one rock and against each other. The number of parts that touch does not
//! grow with the sheet.

use std::hint::black_box;
use std::time::Instant;

use glam::{DQuat, DVec3};
use hullmap::compound::CompoundManifolds;
use hullmap::{Compound, CompoundCache, ManifoldSettings, Pack, Pose, Prediction, Settings, compound};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, point_set};
use parry3d::math;
use parry3d::query::{self, ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::SharedShape;
use shapes::{families::rock, rng::SplitMix64};

/// Vertices of a part.
const VERTICES: usize = 32;

/// Poses in a batch, whose median time is printed.
const POSES: usize = 64;

const BATCHES: usize = 9;

/// Prediction of manifolds, in units of a part's size.
const PREDICTION: f64 = 0.02;

/// A sheet of `side` × `side` rocks in the plane z = 0, which overlap slightly.
struct Sheet {
    side: usize,
    pack: Pack,
    parry: SharedShape,
}

impl Sheet {
    fn new(side: usize) -> Self {
        let place = |i: usize| [(i % side) as f32, (i / side) as f32].map(|at| at - (side as f32 - 1.0) * 0.5);
        let points = |i: usize| -> Vec<[f32; 3]> {
            let [x, y] = place(i);
            rock(VERTICES, i as u64 % 16).iter().map(|p| [p[0] * 0.6 + x, p[1] * 0.6 + y, p[2] * 0.6]).collect()
        };
        let count = side * side;
        let sets: Vec<_> = (0..count).map(|i| point_set("part", &points(i))).collect();
        let baked = bytes(&sets, IndexKind::Tree, &SourceRecord::default()).expect("rocks can be baked");
        let pack = Pack::from_bytes(&baked).expect("a pack");
        let hull = |i: usize| {
            let vertices: Vec<math::Vector> = points(i).iter().map(|p| math::Vector::from_array(*p)).collect();
            SharedShape::convex_hull(&vertices).expect("parry takes rocks")
        };
        let parry = if count == 1 {
            hull(0)
        } else {
            SharedShape::compound((0..count).map(|i| (math::Pose::identity(), hull(i))).collect())
        };
        Self { side, pack, parry }
    }

    /// Poses of another sheet whose corner is at a height above the middle of this one. A single
    /// part is above a random place.
    fn poses(&self, other: &Self, height: f64, seed: u64) -> Vec<Pose> {
        let mut rng = SplitMix64::new(seed);
        let half = |sheet: &Self| (sheet.side as f64 - 1.0) * 0.5;
        (0..POSES)
            .map(|_| {
                let reach = (half(self) - 1.0).max(0.0);
                let over = DVec3::new(rng.between(-reach, reach), rng.between(-reach, reach), 0.0);
                let spin = DQuat::from_rotation_z(rng.between(0.0, 6.0));
                // The corner of the other sheet points down.
                let tilt =
                    if other.side > 1 { DQuat::from_rotation_x(0.5) * DQuat::from_rotation_y(0.5) } else { spin };
                let rotation = if other.side > 1 { spin * tilt } else { spin };
                let corner = DVec3::new(half(other), -half(other), 0.0);
                let at = over + DVec3::Z * (1.0 + height) - rotation * corner;
                Pose::new(at, rotation).expect("finite")
            })
            .collect()
    }
}

/// Median over batches of the mean time of a query, in microseconds.
fn time(mut query: impl FnMut(usize)) -> f64 {
    let mut times: Vec<f64> = (0..BATCHES)
        .map(|_| {
            let start = Instant::now();
            (0..POSES).for_each(&mut query);
            start.elapsed().as_secs_f64() * 1e6 / POSES as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[BATCHES / 2]
}

fn for_parry(pose: &Pose) -> math::Pose {
    math::Pose::from_parts(pose.translation().as_vec3(), pose.rotation().as_quat())
}

fn main() {
    let sheets: Vec<Sheet> = [1, 2, 4, 8, 16, 32].map(Sheet::new).into_iter().collect();
    println!(
        "µs, cold and warm, and parry3d cold and warm; pairs of parts queried and pairs of boxes compared, cold\n"
    );
    println!("| query | parts | hullmap | parry3d | pairs | boxes |");
    println!("|---|---|---|---|---|---|");
    for against_one in [true, false] {
        for name in ["intersects, apart", "intersects, hit", "distance", "contact", "manifolds"] {
            for sheet in sheets.iter().filter(|sheet| against_one || sheet.side <= 16) {
                row(name, sheet, if against_one { &sheets[0] } else { sheet });
            }
        }
    }
}

fn row(name: &str, a: &Sheet, b: &Sheet) {
    let height = match name {
        "distance" | "intersects, apart" => 0.3,
        _ => -0.4,
    };
    let poses = a.poses(b, height, 7);
    // The second query of a warm pair is a step later.
    let step = DVec3::new(2e-3, 1e-3, -1e-3);
    let next: Vec<Pose> =
        poses.iter().map(|p| Pose::new(p.translation() + step, p.rotation()).expect("finite")).collect();
    let (whole_a, whole_b) = (Compound::new(&a.pack), Compound::new(&b.pack));
    let settings = Settings::default();
    let manifold_settings =
        ManifoldSettings { prediction: Prediction::Length(PREDICTION), ..ManifoldSettings::default() };
    let query = |pose: &Pose, cache: &mut CompoundCache, manifolds: &mut CompoundManifolds| -> [u32; 2] {
        match name {
            "distance" => {
                let found = compound::distance(&whole_a, &whole_b, *pose, &settings, cache);
                [found.pairs, found.boxes]
            }
            "contact" => {
                let found = compound::contact(&whole_a, &whole_b, *pose, &settings, cache);
                found.map_or([0; 2], |found| [found.pairs, found.boxes])
            }
            "manifolds" => {
                let counts = manifolds.update(&whole_a, &whole_b, *pose, &manifold_settings);
                [counts.pairs, counts.boxes]
            }
            _ => {
                let found = compound::intersects(&whole_a, &whole_b, *pose, cache);
                [found.pairs, found.boxes]
            }
        }
    };
    let (mut cache, mut manifolds) = (CompoundCache::default(), CompoundManifolds::new(64));
    let mut work = [0; 2];
    for pose in &poses {
        cache.clear();
        manifolds.clear();
        let found = query(pose, &mut cache, &mut manifolds);
        work = [work[0] + found[0], work[1] + found[1]];
    }
    let cleared = time(|_| {
        cache.clear();
        manifolds.clear();
    });
    let cold = time(|i| {
        cache.clear();
        manifolds.clear();
        black_box(query(&poses[i], &mut cache, &mut manifolds));
    });
    let mut warm: Vec<_> = poses.iter().map(|_| (CompoundCache::default(), CompoundManifolds::new(64))).collect();
    let mut step = 0;
    let warm = time(|i| {
        let (cache, manifolds) = &mut warm[i];
        step += 1;
        black_box(query(if (step / POSES).is_multiple_of(2) { &poses[i] } else { &next[i] }, cache, manifolds));
    });
    let [of_parry, later]: [Vec<math::Pose>; 2] = [&poses, &next].map(|poses| poses.iter().map(for_parry).collect());
    let (shape_a, shape_b) = (&*a.parry, &*b.parry);
    let identity = math::Pose::identity();
    let theirs = |pose: &math::Pose, manifolds: &mut Vec<ContactManifold<(), ()>>, workspace: &mut Option<_>| match name
    {
        "distance" => _ = black_box(query::distance(&identity, shape_a, pose, shape_b).is_ok()),
        "contact" => _ = black_box(query::contact(&identity, shape_a, pose, shape_b, 0.0).is_ok()),
        "manifolds" => {
            let found = DefaultQueryDispatcher.contact_manifolds(
                pose,
                shape_a,
                shape_b,
                PREDICTION as f32,
                manifolds,
                workspace,
            );
            black_box(found.is_ok());
        }
        _ => _ = black_box(query::intersection_test(&identity, shape_a, pose, shape_b).is_ok()),
    };
    let parry_cold = time(|i| theirs(&of_parry[i], &mut Vec::new(), &mut None));
    let mut memory: Vec<_> = poses.iter().map(|_| (Vec::new(), None)).collect();
    let mut step = 0;
    let parry_warm = time(|i| {
        let (manifolds, workspace) = &mut memory[i];
        step += 1;
        theirs(if (step / POSES).is_multiple_of(2) { &of_parry[i] } else { &later[i] }, manifolds, workspace);
    });
    let count = |sheet: &Sheet| sheet.side * sheet.side;
    println!(
        "| {name} | {} × {} | {:.2}, {warm:.2} | {parry_cold:.2}, {parry_warm:.2} | {:.1} | {:.0} |",
        count(a),
        count(b),
        cold - cleared,
        f64::from(work[0]) / POSES as f64,
        f64::from(work[1]) / POSES as f64,
    );
}
