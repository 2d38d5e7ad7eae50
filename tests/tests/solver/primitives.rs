//! Triangles, segments and half-spaces against the truth in f64, and bounds of all shapes.

use glam::{DMat3, DVec3};
use hullmap::shapes::{HalfSpace, Segment, Triangle};
use hullmap::{
    Bounds, Cache, CastSettings, Motion, Overlap, Pose, Ray, Settings, Status, SupportMap, contact, distance,
    intersects,
};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    depth::signed_depth,
    gap::gap,
    packs::pack,
    polytope::{Polytope, rounding_error},
    random::RandomPoses,
    reach::{Placed, Reach},
};
use hullmap_tests::soak::{
    bodies::{Bodies, Stock},
    body::Any,
};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_122;

/// Triangles and segments against hulls, and against each other: their truth is the polygon or
/// segment with the same corners.
#[test]
fn triangles_and_segments_against_hulls() {
    let mut rng = SplitMix64::new(SEED);
    let solids = [(Family::Rock, 30), (Family::CubeGrid, 8), (Family::Prism, 12), (Family::Sphere, 60)];
    let solids: Vec<_> = solids.map(|(family, n)| pack("solid", &family.points(n, 1), IndexKind::Tree)).into();
    let (mut hits, mut sure) = (0, 0);
    for i in 0..3_000 {
        let size = [1.0, 0.1, 4.0][i % 3];
        let corners = [(); 3].map(|()| (rng.unit_vector() * size).as_vec3());
        let points = corners.map(|p| p.as_dvec3());
        let is_triangle = i % 2 == 0;
        let (flat, baked): (Box<Any<'_>>, _) = if is_triangle {
            (Box::new(Triangle::new(points).unwrap()), pack("flat", &corners.map(|p| p.to_array()), IndexKind::Tree))
        } else {
            let ends = [corners[0].to_array(), corners[1].to_array()];
            (Box::new(Segment::new(points[0], points[1]).unwrap()), pack("flat", &ends, IndexKind::Tree))
        };
        let solid = &solids[rng.below(solids.len())];
        let hull = solid.hull(0).unwrap();
        let whole: &Any<'_> = &hull;
        let pose = rng.pose(1.0 + 1.2 * size);
        let settings = Settings::default();
        let deep = contact(whole, &*flat, pose, &settings, &mut Cache::new());
        let near = distance(whole, &*flat, pose, &settings, &mut Cache::new());
        let yes = intersects(whole, &*flat, pose, &mut Cache::new());
        let at = format!("seed {SEED}, {i}: {deep:?} {near:?} {yes:?}");
        assert!(!matches!(deep.status, Status::Stalled | Status::IterationLimit), "{at}");
        hits += usize::from(deep.hit);
        // The baked twin has the same corners.
        let twin = baked.hull(0).unwrap();
        let twins = [
            contact(&hull, &twin, pose, &settings, &mut Cache::new()),
            contact(&*flat, whole, pose.inverse(), &settings, &mut Cache::new()),
        ];
        for twin in twins {
            assert!(
                deep.depth_lower <= twin.depth_upper + 1e-12 && twin.depth_lower <= deep.depth_upper + 1e-12,
                "{at}"
            );
        }
        if !is_triangle {
            continue;
        }
        let (a, b) = (Polytope::new(&hull), Polytope::new(&twin).placed(pose));
        let slack = rounding_error(&a, &b, pose.translation().length());
        let (depth, _) = signed_depth(&a, &b, f64::NEG_INFINITY);
        if depth.abs() > 2.0 * slack {
            sure += 1;
            assert_eq!((deep.hit, yes.is_hit()), (depth > 0.0, depth > 0.0), "{depth:e}, {at}");
        }
        let truth = depth.max(0.0);
        assert!(deep.depth_lower <= truth + slack && truth - slack <= deep.depth_upper, "{depth:e}, {at}");
        let far = gap(&a, &b);
        let lower = far.lower.max(-depth).max(0.0);
        assert!(near.lower <= far.upper + slack && lower - slack <= near.upper, "{far:?}, {at}");
    }
    assert!((800..2_200).contains(&hits) && sure > 1_000, "{hits} hits, {sure} sure");
}

/// Planes at and around the surfaces of all shapes of the soak, against the shapes' definitions.
#[test]
fn half_spaces_against_all_shapes() {
    let stock = Stock::bake(&[], 1);
    let bodies = Bodies::new(&stock);
    let mut rng = SplitMix64::new(SEED + 1);
    let mut counts = [0_usize; 3];
    for index in 0..20_000 {
        let pair = bodies.pair(SEED, index);
        let (body, pose) = (pair.bodies[1], pair.b_in_a);
        let shape = body.shape();
        let normal = if index % 5 == 0 { DVec3::AXES[rng.below(3)] } else { rng.unit_vector() };
        let placed = Placed::new(&body.model, pose);
        let lowest = -placed.reach(-normal);
        let size = shape.outer_radius();
        let offset = lowest + size * [0.0, 1e-12, 0.3, -1e-12, -0.3, 1.5][rng.below(6)];
        let Ok(plane) = HalfSpace::new(normal, offset) else { continue };
        let truth = plane.offset() + placed.reach(-plane.normal());
        let (settings, mut cache) = (Settings::default(), Cache::new());
        let c = hullmap::contact(&plane, shape, pose, &settings, &mut cache);
        let d = hullmap::distance(&plane, shape, pose, &settings, &mut cache);
        let y = hullmap::intersects(&plane, shape, pose, &mut cache).status;
        let reach = body.model.greatest + pose.translation().length() + offset.abs();
        let slack = 64.0 * f64::EPSILON * reach;
        let width = 200.0 * f64::EPSILON * (reach + size) + 2.0 * shape.support_error();
        let at = format!("seed {SEED}, {index}, {}, truth {truth:e}: {plane:?} {pose:?} {c:?} {d:?} {y}", body.name);
        assert!(c.depth_lower <= truth.max(0.0) + slack && truth.max(0.0) <= c.depth_upper + slack, "{at}");
        assert!(d.lower <= (-truth).max(0.0) + slack && (-truth).max(0.0) <= d.upper + slack, "{at}");
        assert!(c.depth_upper - c.depth_lower <= width && d.upper - d.lower <= width, "{at}");
        let overlap = match (c.hit, c.status) {
            (false, Status::Separated) => Overlap::Separated,
            (true, Status::Touching) => Overlap::Touching,
            (true, Status::Exact) => Overlap::Overlapping,
            _ => panic!("{at}"),
        };
        assert_eq!(overlap, y, "{at}");
        match y {
            Overlap::Separated => assert!(truth < slack && d.status == Status::Exact && d.lower > 0.0, "{at}"),
            Overlap::Touching => assert!(truth.abs() <= width && d.status == Status::Touching, "{at}"),
            _ => assert!(truth > -slack && d.status == Status::Overlapping && c.depth_lower > 0.0, "{at}"),
        }
        counts[y as usize % 3] += 1;
        // The points are on the plane and on the body, and differ along the normal.
        let unturn = DMat3::from_quat(pose.rotation()).transpose();
        let on_body = body.model.outside(unturn * (c.point_b - pose.translation()));
        assert!(on_body <= slack, "{at}: {on_body:e}");
        assert!((c.point_a.dot(plane.normal()) - plane.offset()).abs() <= slack, "{at}");
        let between = (c.point_a - c.point_b).dot(plane.normal());
        assert!((between - truth).abs() <= width, "{at}");
    }
    assert!(counts.iter().all(|count| *count > 2_000), "{counts:?}");
}

/// The time at which a moving shape meets a plane: its gap over its speed.
#[test]
fn half_spaces_and_moving_shapes() {
    let stock = Stock::bake(&[], 1);
    let bodies = Bodies::new(&stock);
    let mut rng = SplitMix64::new(SEED + 3);
    let mut hits = 0;
    let pairs = 10_000;
    for index in 0..pairs {
        let pair = bodies.pair(SEED + 2, index);
        let (body, pose) = (pair.bodies[1], pair.b_in_a);
        let placed = Placed::new(&body.model, pose);
        let normal = rng.unit_vector();
        let size = body.shape().outer_radius() + 1e-9;
        let offset = -placed.reach(-normal) - size * rng.between(0.0, 3.0);
        let Ok(plane) = HalfSpace::new(normal, offset) else { continue };
        let velocity = match index % 4 {
            0 => normal.cross(rng.unit_vector()),
            1 => -normal,
            _ => rng.unit_vector(),
        } * (size * rng.between(0.1, 10.0));
        let motion = Motion::new(velocity).unwrap();
        let settings = CastSettings { max_t: 2.0, ..CastSettings::default() };
        let impact = hullmap::cast(&plane, body.shape(), pose, motion, &settings, &mut Cache::new());
        let gap = -plane.offset() - placed.reach(-plane.normal());
        let speed = -plane.normal().dot(velocity);
        let t = gap / speed;
        let reach = body.model.greatest + pose.translation().length() + offset.abs();
        // At the start, rounding error decides.
        if gap < 1e-12 * reach {
            continue;
        }
        let slack = 64.0 * f64::EPSILON * (reach / speed.abs() + t.abs() * velocity.length() / speed.abs());
        let at = format!("seed {SEED}, {index}, {}, {t:e}, gap {gap:e}: {plane:?} {pose:?} {impact:?}", body.name);
        assert!(impact.normal == plane.normal() && impact.t_lower <= impact.t && impact.t <= impact.t_upper, "{at}");
        if !impact.hit {
            assert!(speed <= 1e-12 * velocity.length() || t >= 2.0 - slack, "{at}");
            continue;
        }
        hits += 1;
        assert!(impact.t_lower <= t.max(0.0) + slack && t.max(0.0) - slack <= impact.t_upper, "{at}");
        let width = 400.0 * (f64::EPSILON * (reach + size) + body.shape().support_error()) / speed;
        match impact.status {
            Status::Exact => {
                assert!(t <= 2.0 + slack && impact.t_upper - impact.t_lower <= width + 1e-12 * t, "{at}");
                let height = impact.point_a.dot(plane.normal()) - plane.offset();
                assert!(height.abs() <= 1e-11 * (reach + size), "{at}: {height:e}");
                assert!(impact.point_a.distance(impact.point_b) <= 1e-11 * (reach + size), "{at}");
            }
            Status::Touching => {
                assert!(speed.abs() <= 1e-12 * velocity.length() || gap <= width * speed || t >= 2.0 - width, "{at}");
            }
            status => assert!(status == Status::Overlapping && gap <= slack * speed.abs(), "{at}"),
        }
    }
    assert!((pairs / 5..pairs * 4 / 5).contains(&hits), "{hits} of {pairs}");
}

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

/// Bounds contain the shape, without any tolerance for the reference, and are hardly larger.
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
