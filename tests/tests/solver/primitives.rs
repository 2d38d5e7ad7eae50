//! Rays at half-spaces, bounds of all shapes, and caches that start from an axis.

use glam::DVec3;
use hullmap::shapes::{HalfSpace, Triangle};
use hullmap::{Bounds, Cache, CastSettings, Pose, Ray, Settings, Status, SupportMap, contact, distance, intersects};
use hullmap_bake::IndexKind;
use hullmap_testkit::{packs::pack, random::RandomPoses, reach::Placed, reach::Reach};
use hullmap_tests::soak::{
    bodies::{Bodies, Stock},
    body::Any,
};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_122;

#[test]
fn half_spaces_and_rays() {
    let mut rng = SplitMix64::new(SEED + 4);
    let (mut hits, mut inside) = (0, 0);
    for i in 0..5_000 {
        let size = [1e-3, 1.0, 1e6][i % 3];
        let plane = HalfSpace::new(rng.unit_vector(), rng.between(-1.0, 1.0) * size).unwrap();
        let (origin, direction) = (rng.unit_vector() * (rng.between(0.0, 3.0) * size), rng.unit_vector() * size);
        let height = origin.dot(plane.normal()) - plane.offset();
        let t = -height / direction.dot(plane.normal());
        let hit = hullmap::ray(&plane, &Ray::new(origin, direction).unwrap(), &CastSettings::default());
        let at = format!("seed {SEED}, {i}: {height:e} {t:e} {hit:?}");
        let signed = hullmap::signed_distance(&plane, origin, &Settings::default(), &mut Cache::new()).unwrap();
        assert!(signed.lower <= height + 1e-15 * size && height - 1e-15 * size <= signed.upper, "{at} {signed:?}");
        assert!(signed.upper - signed.lower < 1e-13 * size && (signed.distance - height).abs() < 1e-14 * size, "{at}");
        assert!(signed.point.distance(origin - plane.normal() * height) < 1e-14 * size, "{at} {signed:?}");
        if height.abs() < 1e-12 * size {
            continue;
        }
        if height < 0.0 {
            inside += 1;
            assert_eq!((hit.status, hit.t, hit.point), (Status::Overlapping, 0.0, origin), "{at}");
        } else if t > 0.0 && hit.hit {
            hits += 1;
            let slack = 1e-14 * (t + 1.0) * (t + 1.0);
            assert!(hit.t_lower <= t + slack && t - slack <= hit.t_upper && (hit.t - t).abs() <= slack, "{at}");
        } else {
            assert!(t < 0.0 && hit.status == Status::Separated, "{at}");
        }
    }
    assert!(hits > 1_000 && inside > 1_000, "{hits} {inside}");
    let plane = HalfSpace::new(DVec3::Z, 0.0).unwrap();
    let still = Ray::new(DVec3::Z, DVec3::ZERO).unwrap();
    assert_eq!(hullmap::ray(&plane, &still, &CastSettings::default()).status, Status::Separated);
    let within = Ray::new(-DVec3::Z, DVec3::ZERO).unwrap();
    assert_eq!(hullmap::ray(&plane, &within, &CastSettings::default()).status, Status::Overlapping);
    assert!(hullmap::signed_distance(&plane, DVec3::NAN, &Settings::default(), &mut Cache::new()).is_err());
}

/// Bounds contain the shape, without any tolerance for the reference, and are not much larger.
#[test]
fn bounds_of_all_shapes() {
    let stock = Stock::bake(&[], 1);
    let bodies = Bodies::new(&stock);
    for index in 0..10_000 {
        let pair = bodies.pair(SEED + 1, index);
        let (body, pose) = (pair.bodies[1], pair.b_in_a);
        let placed = Placed::new(&body.model, pose);
        let bounds: Bounds = body.shape().bounds_under(pose);
        let reach = body.model.greatest + pose.translation().length() + body.shape().outer_radius();
        let at = format!("seed {SEED}, {index}, {}, {pose:?}: {bounds:?}", body.name);
        let slack = 200.0 * f64::EPSILON * reach + 2.0 * body.shape().support_error();
        let [low, high] = bounds.to_f32();
        for axis in 0..3 {
            let (min, max) = (-placed.reach(-DVec3::AXES[axis]), placed.reach(DVec3::AXES[axis]));
            assert!(bounds.min[axis] <= min && max <= bounds.max[axis], "{at}: {min:e} {max:e}");
            assert!(min - bounds.min[axis] <= slack && bounds.max[axis] - max <= slack, "{at}: {min:e} {max:e}");
            assert!(f64::from(low[axis]) <= min && max <= f64::from(high[axis]), "{at}");
        }
    }
}

#[test]
fn caches_started_from_an_axis_save_support_calls() {
    let packs =
        [Family::Rock, Family::Prism, Family::Cone].map(|family| pack("hull", &family.points(300, 1), IndexKind::Tree));
    let mut rng = SplitMix64::new(SEED + 2);
    let settings = Settings::default();
    // Contact, intersects and distance of two hulls, and distance of a hull and a triangle.
    let (mut fresh, mut started, mut apart) = ([0; 4], [0; 4], 0);
    for _ in 0..2_000 {
        let mut hull = || packs[rng.below(3)].hull(0).unwrap();
        let (a, b) = (hull(), hull());
        let size = a.outer_radius().min(b.outer_radius());
        let before = rng.pose(2.2 * size);
        let after = Pose::new(before.translation() + rng.unit_vector() * (0.01 * size), before.rotation()).unwrap();
        let (hull, triangle): (&Any<'_>, &Any<'_>) =
            (&a, &Triangle::new([(); 3].map(|()| rng.unit_vector() * size)).unwrap());
        let axis = distance(&a, &b, before, &settings, &mut Cache::new());
        let other = distance(hull, triangle, before, &settings, &mut Cache::new());
        if axis.distance < 0.02 * size || other.distance < 0.02 * size {
            continue;
        }
        apart += 1;
        for (calls, cache, beside) in [
            (&mut fresh, Cache::new(), Cache::new()),
            (&mut started, Cache::from_axis(axis.normal * 3.0), Cache::from_axis(other.normal)),
        ] {
            let cache = || cache.clone();
            let deep = contact(&a, &b, after, &settings, &mut cache());
            assert!(!deep.hit);
            calls[0] += deep.support_calls;
            calls[1] += intersects(&a, &b, after, &mut cache()).support_calls;
            calls[2] += distance(&a, &b, after, &settings, &mut cache()).support_calls;
            calls[3] += distance(hull, triangle, after, &settings, &mut { beside }).support_calls;
        }
    }
    println!("{apart} pairs: {fresh:?} support calls with empty caches, {started:?} with axes");
    assert!(apart > 300, "{apart}");
    for (fresh, started) in fresh.into_iter().zip(started) {
        assert!(started < fresh, "{started} of {fresh}");
    }
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(Cache::from_axis(bad), Cache::new());
    }
    let mut cleared = Cache::from_axis(DVec3::X);
    cleared.clear();
    assert_eq!(cleared, Cache::new());
}
