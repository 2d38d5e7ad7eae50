//! Pairs of baked hulls, whose support points have an error: the soak found wrong answers.

use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cuboid, Cylinder};
use hullmap::{Cache, Contact, Overlap, Pose, Settings, Status, contact, distance, intersects};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    packs::{pack, tree_pack},
    random::RandomPoses,
};
use hullmap_tests::soak::{bodies::Stock, body::Any};
use shapes::{families, rng::SplitMix64};

fn deep(a: &Any<'_>, b: &Any<'_>, pose: Pose) -> Contact {
    contact(a, b, pose, &Settings::default(), &mut Cache::new())
}

/// Two polygons, one of them in the plane of a face of the difference, 7e-5 beside it, were
/// reported as touching, at a gap of 30,000 rounding errors.
#[test]
fn beside_a_face_is_not_touching() {
    let flat = [[1000.0, 0.0, 0.0], [-1000.0, 0.0, 0.0], [0.0, 800.0, 0.0], [100.0, 200.0, 1e-5]];
    let sliver = [[-1000.0, 0.0, 250.0], [1000.0, 0.0, 250.0], [300.0, 0.01, 250.0]];
    let packs = [pack("flat", &flat, IndexKind::Tree), pack("sliver", &sliver, IndexKind::Tree)];
    let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
    let quarter = DQuat::from_xyzw(-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2);
    let pose = Pose::new(DVec3::new(1999.9999999999998, -249.99991135212065, 0.0), quarter).unwrap();
    let gap = distance(&a, &b, pose, &Settings::default(), &mut Cache::new());
    assert!(gap.lower > 6.9e-5 && gap.upper < 7e-5, "{gap:?}");
    assert_eq!(intersects(&a, &b, pose, &mut Cache::new()).status, Overlap::Separated);
    assert!(!deep(&a, &b, pose).hit);
}

/// A segment through a disc 1e9 times its size, and a capsule through a cube's corner, penetrate.
/// They were reported as touching: the distance of their cores is within the rounding error.
#[test]
fn thin_penetrating_cores_do_not_merely_touch() {
    let (disc, needle): (&Any<'_>, &Any<'_>) =
        (&Cylinder::new(0.0, 800.0).unwrap(), &Capsule::new(7e-7, 1e-12).unwrap());
    let shift = DVec3::new(5.971920797150828e-12, 4.4407429005608977e-11, 2.5103881645942507e-11);
    let turn = DQuat::from_xyzw(-0.05669111068631973, -0.6217613658996758, 0.6314151869169203, -0.45990776);
    let pose = Pose::new(shift, turn.normalize()).unwrap();
    for (deep, yes) in [
        (deep(needle, disc, pose), intersects(needle, disc, pose, &mut Cache::new())),
        (deep(disc, needle, pose.inverse()), intersects(disc, needle, pose.inverse(), &mut Cache::new())),
    ] {
        assert!(deep.depth_lower > 1.5e-7, "{deep:?}");
        assert_eq!(yes.status, Overlap::Overlapping, "{deep:?}");
    }
}

/// The iteration limit was reached on a round Minkowski difference. The reported points were not
/// along the normal, in whose direction the radii are added.
#[test]
fn contact_points_lie_along_the_normal_at_the_iteration_limit() {
    let (disc, long) = (Cylinder::new(1e-9, 0.0008).unwrap(), Capsule::new(700.0, 0.001).unwrap());
    let turn =
        DQuat::from_xyzw(-2.821668210076401e-1, 3.716787100216282e-2, -7.059676274211393e-1, 6.485446349488803e-1);
    let c = deep(&disc, &long, Pose::new(DVec3::ZERO, turn).unwrap());
    assert!(c.hit && c.depth_lower >= 0.001 && c.depth_upper > c.depth_lower, "{c:?}");
    let along = (c.point_a - c.point_b).dot(c.normal);
    assert!(along >= 0.999 * c.depth_lower && along <= c.depth_upper + 1e-12, "{along:e}: {c:?}");
}

/// Checks that the witness points are on the support planes, and opposite each other, to within the
/// interval of the depth.
fn assert_settled(a: &Any<'_>, b: &Any<'_>, pose: Pose, c: &Contact) {
    assert!(c.hit && matches!(c.status, Status::Exact | Status::Within), "{pose:?}: {c:?}");
    let most = c.depth_upper - c.depth_lower + 1e-12 * (a.outer_radius() + b.outer_radius());
    let off = (c.point_a - c.point_b).distance(c.normal * c.depth);
    assert!(off <= most, "{off:e} off the normal, {pose:?}: {c:?}");
    let top = a.support_point(c.normal).point.dot(c.normal) - c.point_a.dot(c.normal);
    let down = pose.inverse_transform_vector(-c.normal);
    let bottom = b.support_point(down).point.dot(down) - pose.inverse().transform_point(c.point_b).dot(down);
    assert!(top.max(bottom) <= most, "{top:e} and {bottom:e} below the surface, {pose:?}: {c:?}");
}

/// A thin cylinder in the middle of a box: the witness points were on the wrong face, or a
/// thousandth of the depth beside it, with the status "exact".
#[test]
fn witness_points_of_a_thin_body_deep_in_a_thick_one() {
    let mut rng = SplitMix64::new(0x717);
    for round in 0..2_000 {
        let unit = [1.0, 1e-3, 1e3, 1e-30, 1e30][round % 5];
        let half = DVec3::new(rng.between(0.4, 0.6), rng.between(0.4, 0.6), rng.between(0.4, 0.6)) * unit;
        let (height, radius) = (rng.between(0.01, 0.2) * unit, rng.between(0.1, 0.3) * unit);
        let (thick, thin): (&Any<'_>, &Any<'_>) =
            (&Cuboid::new(half).unwrap(), &Cylinder::new(height, radius).unwrap());
        let turn = if round % 4 == 0 { rng.rotation() } else { DQuat::IDENTITY };
        let shift = if round % 2 == 0 { DVec3::ZERO } else { rng.unit_vector() * (0.1 * unit) };
        let pose = Pose::new(shift, turn).unwrap();
        for (tolerance, again) in [(1e-5, false), (0.0, false), (1e-5, true)] {
            let settings = Settings { tolerance, ..Settings::default() };
            let mut cache = Cache::new();
            if again {
                let beside = Pose::new(shift + DVec3::splat(1e-3 * unit), turn).unwrap();
                contact(thin, thick, beside, &settings, &mut cache);
            }
            let c = contact(thin, thick, pose, &settings, &mut cache);
            if tolerance > 0.0 || c.status != Status::IterationLimit {
                assert_settled(thin, thick, pose, &c);
            }
        }
    }
    let (thick, thin) = (Cuboid::new(DVec3::splat(0.5)).unwrap(), Cylinder::new(0.1057, 0.24).unwrap());
    assert_settled(&thin, &thick, Pose::IDENTITY, &deep(&thin, &thick, Pose::IDENTITY));
    assert_settled(&thick, &thin, Pose::IDENTITY, &deep(&thick, &thin, Pose::IDENTITY));
}

/// A prism of 200 vertices in a box: witness points were off by a thousandth of the depth, with the
/// status "within the tolerance".
#[test]
fn witness_points_of_a_prism_in_a_box() {
    let pack = tree_pack(&families::prism(200, 0));
    let prism = pack.hull(0).unwrap();
    let mut rng = SplitMix64::new(0x717);
    for round in 0..500 {
        let half = DVec3::new(rng.between(1.0, 3.0), rng.between(1.0, 3.0), rng.between(1.0, 3.0));
        let (thick, turn) = (Cuboid::new(half).unwrap(), if round % 2 == 0 { rng.rotation() } else { DQuat::IDENTITY });
        let pose = Pose::new(rng.unit_vector() * rng.between(0.0, 1.0), turn).unwrap();
        assert_settled(&thick, &prism, pose, &deep(&thick, &prism, pose));
    }
}

/// A needle in the rim of a disc, both thin, and 50 times the size of the disc from the origin. GJK
/// stalls on a sliver, and the two copies of the common point were 110 rounding errors apart.
#[test]
fn common_points_of_slivers_are_one_point() {
    let stock = Stock::bake(&[], 1);
    let [a, b] = ["disc 1e-4 thick, turned of size 1e0, 50 away", "needle 24 of size 1e-6, 0 away"]
        .map(|name| stock.hull(name).expect("it is baked"));
    assert_eq!([a.vertex_count(), b.vertex_count()], [48, 24]);
    let turn = DQuat::from_xyzw(-0.0007095353500622266, -0.6507496182125533, 0.46004963472103133, 0.6040519551734342);
    let pose = Pose::new(DVec3::new(50.335140228271484, -35.61344909667969, 20.71509552001953), turn).unwrap();
    let found = distance(&a, &b, pose, &Settings::default(), &mut Cache::new());
    assert_eq!(found.status, Status::Overlapping);
    let apart = found.point_a.distance(found.point_b);
    assert!(apart <= 4e-11, "{apart:e}: {found:?}");
}
