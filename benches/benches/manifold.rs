//! Everyday benchmark of contact manifolds: their cost must not grow with the number of vertices.
//! `cargo bench -p hullmap-bench --bench manifold`.
//!
//! A run of the closure is [`STEPS`] updates of a pair in contact that slides and turns slowly,
//! with one cache: divide by it, or read the updates per second. Compare 8,192 vertices with 128.

use std::fmt;

use divan::{Bencher, black_box, counter::ItemsCount};
use glam::{DQuat, DVec3};
use hullmap::shapes::Cuboid;
use hullmap::{Cache, Manifold, ManifoldSettings, Pack, Pose, Shape, intersects};
use hullmap_testkit::packs::tree_pack;
use shapes::{families::Family, solids};

/// Updates of one run.
const STEPS: usize = 64;

const COUNTS: [usize; 4] = [128, 512, 2048, 8192];

/// A hull of `n` vertices on a box, or on another hull of the same shape.
#[derive(Clone, Copy)]
struct Case {
    shape: &'static str,
    n: usize,
    on_itself: bool,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let floor = if self.on_itself { self.shape } else { "box" };
        write!(f, "{} on {floor}, {}", self.shape, self.n)
    }
}

fn cases() -> impl Iterator<Item = Case> {
    let shapes = ["sphere", "rock", "prism"].into_iter();
    shapes.flat_map(|shape| {
        [false, true].into_iter().flat_map(move |on_itself| COUNTS.map(|n| Case { shape, n, on_itself }))
    })
}

fn pack(case: Case) -> Pack {
    tree_pack(&match case.shape {
        "sphere" => Family::Sphere.points(case.n, 1),
        "rock" => Family::Rock.points(case.n, 1),
        _ => solids::extrusion(&solids::regular_polygon(case.n / 2, 1.0), -1.0, 1.0).vertices,
    })
}

/// Poses of a body that slides along the floor, 1e-3 deep.
fn poses(floor: &dyn Shape, body: &dyn Shape) -> Vec<Pose> {
    let place = |height: f64, slide: f64| {
        let turned = DQuat::from_rotation_z(0.1 * slide);
        Pose::new(DVec3::new(0.1 + slide, 0.05, height), turned).expect("finite")
    };
    let (mut low, mut high) = (0.0, 8.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        let is_hit = intersects(floor, body, place(middle, 0.0), &mut Cache::new()).is_hit();
        (low, high) = if is_hit { (middle, high) } else { (low, middle) };
    }
    (0..STEPS).map(|step| place(low - 1e-3, 1e-4 * step as f64)).collect()
}

#[divan::bench(args = cases())]
fn update(bencher: Bencher<'_, '_>, case: Case) {
    let pack = pack(case);
    let body = pack.hull(0).expect("the pack has a hull");
    let cuboid = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).expect("finite");
    let floor: &dyn Shape = if case.on_itself { &body } else { &cuboid };
    let poses = poses(floor, &body);
    let settings = ManifoldSettings::default();
    let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for pose in &poses {
            black_box(manifold.update(floor, &body, *pose, &settings, &mut cache));
        }
    });
}

/// The contact inside of an update: what remains of the ratio is the manifold's own.
#[divan::bench(args = cases())]
fn contact(bencher: Bencher<'_, '_>, case: Case) {
    let pack = pack(case);
    let body = pack.hull(0).expect("the pack has a hull");
    let cuboid = Cuboid::new(DVec3::new(5.0, 5.0, 1.0)).expect("finite");
    let floor: &dyn Shape = if case.on_itself { &body } else { &cuboid };
    let poses = poses(floor, &body);
    let settings = ManifoldSettings::default();
    let mut cache = Cache::new();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for pose in &poses {
            black_box(hullmap::contact(floor, &body, *pose, &settings.contact, &mut cache));
        }
    });
}

#[divan::bench(args = cases().filter(|case| !case.on_itself))]
fn feature(bencher: Bencher<'_, '_>, case: Case) {
    let pack = pack(case);
    let body = pack.hull(0).expect("the pack has a hull");
    let mut feature = hullmap::Feature::new();
    let dirs: Vec<DVec3> = (0..STEPS).map(|step| DVec3::new(1e-4 * step as f64, 0.0, -1.0)).collect();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for dir in &dirs {
            body.feature_within(*dir, black_box(0.02), &mut feature);
            black_box(&feature);
        }
    });
}

fn main() {
    divan::main();
}
