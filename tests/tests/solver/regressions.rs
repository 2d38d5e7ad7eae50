//! Pairs of baked hulls, whose support points have an error: the soak found wrong answers.

use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cuboid, Cylinder, Sphere};
use hullmap::{Cache, Contact, Overlap, Pose, Settings, Status, contact, distance, intersects};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    packs::{pack, tree_pack},
    random::RandomPoses,
};
use hullmap_tests::soak::body::Any;
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

/// A ball around a point 8e-13 from a segment: the cores were reported as touching, with the whole
/// radius as depth.
#[test]
fn depth_of_cores_8e_13_apart() {
    let (needle, ball) = (Capsule::new(0.0007, 0.0).unwrap(), Sphere::new(0.0008).unwrap());
    let shift = DVec3::new(-5.496251782692585e-13, 6.14096393094371e-13, -4.704256949261687e-12);
    let turn =
        DQuat::from_xyzw(3.523716018709407e-1, -8.912437729690775e-1, -2.80570094148559e-1, 5.2907594995608064e-2);
    let pose = Pose::new(shift, turn).unwrap();
    let truth = 0.0008 - (shift.x * shift.x + shift.y * shift.y).sqrt();
    for c in [deep(&needle, &ball, pose), deep(&ball, &needle, pose.inverse())] {
        assert!(c.depth_lower <= truth + 1e-17 && truth - 1e-17 <= c.depth_upper, "{truth:e}: {c:?}");
    }
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
    let disc = [
        [50.13173, -35.21061, 20.968655],
        [50.131817, -35.210564, 20.968653],
        [50.241623, -35.426586, 20.871574],
        [50.241714, -35.42654, 20.871572],
        [50.33505, -35.613495, 20.715097],
        [50.33514, -35.61345, 20.715096],
        [50.40564, -35.7586, 20.509888],
        [50.405727, -35.758553, 20.509886],
        [50.448586, -35.852005, 20.26993],
        [50.448673, -35.85196, 20.269928],
        [50.460953, -35.88735, 20.011578],
        [50.461044, -35.887302, 20.011576],
        [50.441906, -35.862225, 19.752436],
        [50.441998, -35.86218, 19.752434],
        [50.392742, -35.77834, 19.510166],
        [50.392834, -35.778294, 19.510162],
        [50.31681, -35.64142, 19.301277],
        [50.3169, -35.641373, 19.301275],
        [50.219284, -35.460785, 19.140005],
        [50.219376, -35.46074, 19.140003],
        [50.10681, -35.24875, 19.03734],
        [50.106903, -35.248703, 19.037338],
        [49.987057, -35.019768, 19.000278],
        [49.98715, -35.01972, 19.000277],
        [49.868183, -34.789436, 19.031347],
        [49.86827, -34.78939, 19.031345],
        [49.758286, -34.57346, 19.128428],
        [49.758377, -34.573414, 19.128426],
        [49.66486, -34.38655, 19.284904],
        [49.66495, -34.386505, 19.284903],
        [49.594273, -34.241447, 19.490114],
        [49.59436, -34.2414, 19.490112],
        [49.551327, -34.14804, 19.730072],
        [49.551414, -34.147995, 19.73007],
        [49.538956, -34.112698, 19.988424],
        [49.539047, -34.11265, 19.988422],
        [49.558002, -34.13782, 20.247566],
        [49.558094, -34.137775, 20.247564],
        [49.607166, -34.221706, 20.489838],
        [49.607258, -34.22166, 20.489834],
        [49.6831, -34.358627, 20.698725],
        [49.68319, -34.35858, 20.698723],
        [49.780624, -34.53926, 20.859997],
        [49.780716, -34.539215, 20.859995],
        [49.893097, -34.751297, 20.962662],
        [49.89319, -34.75125, 20.96266],
        [50.01285, -34.98028, 20.999723],
        [50.012943, -34.980232, 20.999722],
    ];
    let needle = [
        [-5.722325e-7, -7.488831e-10, 3.342514e-10],
        [-3.0156602e-7, -1.3252131e-10, -9.441906e-10],
        [-7.220366e-7, -1.9647277e-11, 6.915758e-10],
        [2.0240986e-7, -7.0798006e-10, 6.766051e-10],
        [9.136449e-7, -4.0431675e-10, 4.220079e-11],
        [2.4854756e-7, 4.5936951e-10, 8.527624e-10],
        [-7.555007e-7, -4.7663534e-10, -4.4948575e-10],
        [-6.72434e-7, -4.915419e-10, 5.533707e-10],
        [2.8808864e-7, 7.754683e-11, -9.544587e-10],
        [-9.0727315e-7, 1.7081386e-10, -3.8428893e-10],
        [-3.916404e-8, 2.587966e-10, 9.651375e-10],
        [-7.989725e-7, 1.1909089e-10, -5.894577e-10],
        [-4.3024406e-7, -1.6616573e-10, 8.872874e-10],
        [-8.8721015e-7, -8.4522195e-11, -4.5355728e-10],
        [7.4631583e-7, -6.649674e-10, -2.8828231e-11],
        [-7.464028e-8, -3.1208547e-10, -9.471175e-10],
        [-4.08852e-7, -3.8466544e-10, -8.275703e-10],
        [4.313606e-7, 7.343534e-10, 5.2407356e-10],
        [8.895918e-7, -9.299567e-11, 4.471894e-10],
        [8.613042e-8, -7.119709e-10, -6.9690675e-10],
        [9.634991e-7, 2.671065e-10, -1.7982688e-11],
        [1.6179564e-7, 9.386638e-10, -3.0451983e-10],
        [-6.336733e-7, 2.5619604e-10, 7.2994644e-10],
        [3.090054e-7, 8.69981e-10, 3.8425088e-10],
    ];
    let packs = [tree_pack(&disc), tree_pack(&needle)];
    let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
    let turn = DQuat::from_xyzw(-0.0007095353500622266, -0.6507496182125533, 0.46004963472103133, 0.6040519551734342);
    let pose = Pose::new(DVec3::new(50.335140228271484, -35.61344909667969, 20.71509552001953), turn).unwrap();
    let found = distance(&a, &b, pose, &Settings::default(), &mut Cache::new());
    assert_eq!(found.status, Status::Overlapping);
    let apart = found.point_a.distance(found.point_b);
    assert!(apart <= 4e-11, "{apart:e}: {found:?}");
}
