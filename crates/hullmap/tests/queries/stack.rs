//! Every query runs on the stack that is documented: [`Settings::stack_size`] and
//! [`Scratch::STACK_SIZE`]. An overflow ends the process.

use std::hint::black_box;
use std::process::Command;

use hullmap::{
    Cache, CastSettings, Compound, CompoundManifolds, Contact, Feature, Manifold, ManifoldSettings, Motion, Pack, Pose,
    Ray, Scratch, Settings, Shape,
    batch::{self, Pair},
    cast, contact, distance,
    glam::{DQuat, DVec3, Vec3},
    intersects, ray,
    shapes::{Capsule, Rounded, Sphere},
    signed_distance,
};
use hullmap_testkit::packs::{parts, point_set};
use shapes::families::Family;

/// Stack that a query takes beyond [`Scratch::STACK_SIZE`], which is stated for optimised builds.
const UNOPTIMISED: usize = if cfg!(debug_assertions) { 8 * 1024 } else { 0 };

/// Runs a test in a process of its own: a thread of this one may reuse the larger stack of a thread
/// that has ended.
#[expect(clippy::disallowed_methods, reason = "the parent process says that this is the child")]
fn alone(test: &str, run: impl FnOnce()) {
    const CHILD: &str = "HULLMAP_STACK_TEST";
    if std::env::var_os(CHILD).is_some() {
        return run();
    }
    let mut child = Command::new(std::env::current_exe().unwrap());
    let output = child.args([&format!("stack::{test}"), "--exact", "--nocapture"]).env(CHILD, "1").output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && printed.contains("1 passed"), "{printed}{output:?}");
}

/// Hulls whose contact takes the largest polytope, and small ones.
fn pack() -> Pack {
    let sets = [
        point_set("sphere", &Family::Sphere.points(8_192, 1)),
        point_set("prism", &Family::Prism.points(500, 1)),
        point_set("rock", &Family::Rock.points(60, 1)),
    ];
    parts(&sets)
}

fn poses() -> Vec<Pose> {
    let turned = DQuat::from_array([0.3, -0.2, 0.5, 0.7]).normalize();
    let offsets = [DVec3::ZERO, DVec3::new(0.1, 0.2, -0.1), DVec3::X, DVec3::new(1.99, 0.0, 0.0), DVec3::Z * 9.0];
    offsets.map(|offset| Pose::new(offset, turned).unwrap()).to_vec()
}

/// Runs every query and returns the maximum number of iterations of a contact. Caller-owned
/// memory is on the heap, so that the stack is the query's.
fn run_all<S: Shape + ?Sized>(a: &S, b: &S, settings: &Settings, scratch: &mut Option<Box<Scratch>>) -> u32 {
    let mut most = 0;
    for pose in poses() {
        let mut cache = Box::new(Cache::new());
        if let Some(scratch) = scratch.take() {
            cache.set_scratch(scratch);
        }
        let found = contact(a, b, pose, settings, &mut cache);
        most = most.max(found.iterations);
        // The second query starts from the first one's polytope.
        black_box(contact(a, b, pose, settings, &mut cache));
        black_box(intersects(a, b, pose, &mut cache));
        black_box(distance(a, b, pose, settings, &mut cache));
        let mut manifold = Box::new(Manifold::new());
        let manifold_settings = ManifoldSettings { contact: *settings, ..Default::default() };
        black_box(manifold.update(a, b, pose, &manifold_settings, &mut cache));
        let cast_settings = CastSettings { tolerance: 0.0, ..CastSettings::default() };
        for along in [DVec3::ZERO, DVec3::NEG_X, DVec3::new(0.3, -0.2, -1.0)] {
            black_box(cast(a, b, pose, Motion::new(along).unwrap(), &cast_settings, &mut cache));
            black_box(ray(a, &Ray::new(pose.translation(), along).unwrap(), &cast_settings));
        }
        black_box(signed_distance(a, pose.translation(), settings, &mut cache).unwrap());
        let mut feature = Box::new(Feature::new());
        a.feature(DVec3::X, &mut feature);
        black_box(feature.corners().len());
        *scratch = cache.take_scratch();
    }
    most
}

/// Runs every query on a thread with a stack of `size` bytes. Returns the maximum number of
/// iterations of a contact.
fn on_stack(size: usize, settings: Settings, with_scratch: bool) -> u32 {
    let pack = pack();
    let scratch = with_scratch.then(Scratch::boxed);
    let run = move || {
        let mut scratch = scratch;
        let hulls = [0, 1, 2].map(|index| pack.hull(index).unwrap());
        let mut most = 0;
        for a in &hulls {
            for b in &hulls {
                most = most.max(run_all(a, b, &settings, &mut scratch));
            }
            let (ball, capsule) = (Sphere::new(0.8).unwrap(), Capsule::new(0.5, 0.3).unwrap());
            run_all::<dyn Shape + Sync>(a, &ball, &settings, &mut scratch);
            run_all::<dyn Shape + Sync>(&capsule, a, &settings, &mut scratch);
            run_all::<dyn Shape + Sync>(a, &Rounded::new(*a, 0.1).unwrap(), &settings, &mut scratch);
            black_box((a.support(Vec3::X), a.support_from(Vec3::Y, 0), a.face_towards(DVec3::Z)));
        }
        let whole = Compound::new(&pack);
        let mut manifolds = CompoundManifolds::new(9);
        for pose in poses() {
            let mut cache = Cache::with_pairs(4);
            if let Some(scratch) = scratch.take() {
                cache.set_scratch(scratch);
            }
            black_box(hullmap::intersects(&whole, &whole, pose, &mut cache));
            black_box(hullmap::distance(&whole, &whole, pose, &settings, &mut cache));
            black_box(hullmap::contact(&whole, &whole, pose, &settings, &mut cache));
            let (motion, limits) = (Motion::new(-pose.translation()).unwrap(), CastSettings::default());
            black_box(hullmap::cast(&whole, &whole, pose, motion, &limits, &mut cache));
            black_box(hullmap::ray(&whole, &Ray::new(pose.translation(), DVec3::X).unwrap(), &limits));
            black_box(hullmap::signed_distance(&whole, pose.translation(), &settings, &mut cache).unwrap());
            if let Some(scratch) = cache.take_scratch() {
                manifolds.set_scratch(scratch);
            }
            let manifold_settings = ManifoldSettings { contact: settings, ..Default::default() };
            // The second update has manifolds for the pairs.
            for _ in 0..2 {
                black_box(manifolds.update(&whole, &whole, pose, &manifold_settings));
            }
            if let Some(scratch) = manifolds.take_scratch() {
                cache.set_scratch(scratch);
            }
            scratch = cache.take_scratch();
            assert_eq!(scratch.is_some(), with_scratch, "the scratch memory is lost");
        }
        most
    };
    let thread = std::thread::Builder::new().stack_size(size).spawn(run).unwrap();
    thread.join().unwrap()
}

#[test]
fn settings_state_the_stack_of_a_query() {
    alone("settings_state_the_stack_of_a_query", || {
        for max_iterations in [200, Settings::DEFAULT_MAX_ITERATIONS, u32::MAX] {
            let settings = Settings { max_iterations, ..Settings::default() };
            let most = on_stack(settings.stack_size(), settings, false);
            assert!(most >= max_iterations.min(900), "only {most} of {max_iterations} iterations");
        }
    });
}

/// Contacts in flight have the polytopes of several queries on the stack. Without the feature
/// `parallel`, the calling thread solves them.
#[test]
fn contacts_in_flight_take_64_kb_more() {
    alone("contacts_in_flight_take_64_kb_more", || {
        for max_iterations in [200, Settings::DEFAULT_MAX_ITERATIONS] {
            let settings = Settings { max_iterations, ..Settings::default() };
            let run = move || {
                let pack = pack();
                // Each copy has an address of its own, and counts as another shape.
                let hulls = vec![pack.hull(0).unwrap(); 32];
                let pose = |i: usize| poses()[i % poses().len()];
                let pairs: Vec<_> = hulls.iter().enumerate().map(|(i, a)| Pair { a, b: a, b_in_a: pose(i) }).collect();
                let mut caches = vec![Cache::new(); pairs.len()];
                let mut found = vec![Contact::default(); pairs.len()];
                batch::contact(&pairs, &settings, &mut caches, &mut found).unwrap();
                found.iter().map(|contact| contact.iterations).max().unwrap()
            };
            let thread = std::thread::Builder::new().stack_size(settings.stack_size() + 64 * 1024).spawn(run).unwrap();
            let most = thread.join().unwrap();
            assert!(most >= max_iterations.min(900), "only {most} of {max_iterations} iterations");
        }
    });
}

#[test]
fn scratch_memory_makes_a_small_stack_enough() {
    alone("scratch_memory_makes_a_small_stack_enough", || {
        for max_iterations in [0, Settings::DEFAULT_MAX_ITERATIONS] {
            let settings = Settings { max_iterations, ..Settings::default() };
            let most = on_stack(Scratch::STACK_SIZE + UNOPTIMISED, settings, true);
            assert!(most >= max_iterations.min(900), "only {most} iterations");
        }
    });
}

#[test]
fn scratch_memory_changes_no_answer() {
    let pack = pack();
    let mut scratch = Scratch::boxed();
    let mut deep = 0;
    for a in pack.hulls() {
        for b in pack.hulls() {
            for pose in poses() {
                let (mut plain, mut lent) = (Cache::new(), Cache::new());
                for _ in 0..2 {
                    lent.set_scratch(scratch);
                    let found = contact(&a, &b, pose, &Settings::default(), &mut lent);
                    scratch = lent.take_scratch().unwrap();
                    assert_eq!(found, contact(&a, &b, pose, &Settings::default(), &mut plain));
                    assert_eq!(lent, plain);
                    deep += usize::from(found.iterations > 300);
                }
            }
        }
    }
    assert!(deep >= 2, "{deep} queries use the scratch memory");
}
