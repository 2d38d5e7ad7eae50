//! Every kind of shape: at the limits of sizes and distances, its balls, and its errors. The soak
//! judges all pairings of kinds: hulls of all ranks, closed forms, scaled and rounded shapes.

use crate::any_shape::{contact, distance};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Segment, Sphere, Triangle};
use hullmap::{Cache, Contact, Pack, Pose, Settings, Shape, ShapeError};
use hullmap_testkit::{packs::tree_pack, random::RandomPoses};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0x005e_ed05;

/// Packs of hulls of each rank.
pub fn packs() -> Vec<(&'static str, Pack)> {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5)).collect();
    vec![
        ("point", tree_pack(&[[0.1, 0.2, 0.3]])),
        ("segment", tree_pack(&[[-0.5, 0.0, 0.1], [0.6, 0.3, 0.0]])),
        ("triangle", tree_pack(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.0, 1.0, 0.1]])),
        ("cube", tree_pack(&cube)),
        ("rock", tree_pack(&Family::Rock.points(300, 1))),
        ("ellipsoid", tree_pack(&Family::ClusteredEllipsoid.points(300, 1))),
        ("prism", tree_pack(&Family::Prism.points(100, 1))),
    ]
}

/// All shapes, of about unit size.
pub fn all<'a>(packs: &'a [(&'static str, Pack)]) -> Vec<(&'static str, Box<dyn Shape + Sync + 'a>)> {
    let mut all: Vec<(&'static str, Box<dyn Shape + Sync>)> = Vec::new();
    for (name, pack) in packs {
        all.push((name, Box::new(pack.hull(0).unwrap())));
    }
    let rock = packs[4].1.hull(0).unwrap();
    all.push(("sphere", Box::new(Sphere::new(0.6).unwrap())));
    all.push(("box", Box::new(Cuboid::new(DVec3::new(0.5, 0.3, 0.7)).unwrap())));
    all.push(("capsule", Box::new(Capsule::new(0.5, 0.25).unwrap())));
    all.push(("cylinder", Box::new(Cylinder::new(0.4, 0.5).unwrap())));
    all.push(("cone", Box::new(Cone::new(0.5, 0.5).unwrap())));
    let corners = [DVec3::new(0.6, -0.2, 0.1), DVec3::new(-0.3, 0.5, 0.2), DVec3::new(-0.2, -0.4, -0.3)];
    all.push(("oblique capsule", Box::new(Capsule::between(corners[0], corners[1], 0.25).unwrap())));
    all.push(("segment in closed form", Box::new(Segment::new(corners[0], corners[1]).unwrap())));
    all.push(("triangle in closed form", Box::new(Triangle::new(corners).unwrap())));
    all.push(("rounded triangle", Box::new(Rounded::new(Triangle::new(corners).unwrap(), 0.1).unwrap())));
    all.push(("mirrored rock", Box::new(Scaled::new(rock, DVec3::new(-0.5, 1.2, 0.8)).unwrap())));
    all.push(("rounded rock", Box::new(Rounded::new(rock, 0.2).unwrap())));
    all.push((
        "ellipsoid in closed form",
        Box::new(Scaled::new(Sphere::new(0.5).unwrap(), DVec3::new(1.0, 0.4, 1.5)).unwrap()),
    ));
    all
}

fn moved(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn solve(a: &(dyn Shape + Sync), b: &(dyn Shape + Sync), pose: Pose) -> Contact {
    contact(a, b, pose, &Settings::default(), &mut Cache::new())
}

/// A pebble on a body ten thousand times its size, far from the origin, in units at both ends of
/// the range of f32.
#[test]
fn extreme_sizes_and_distances() {
    let quarter = std::f64::consts::FRAC_PI_2;
    for unit in [1e-36, 1e-3, 1.0, 1e4, 1e33] {
        let floor = Cuboid::new(DVec3::new(1e4, 1e4, 1e4) * unit).unwrap();
        let pebbles: [Box<dyn Shape + Sync>; 5] = [
            Box::new(Sphere::new(unit).unwrap()),
            Box::new(Cuboid::new(DVec3::splat(unit)).unwrap()),
            Box::new(Cylinder::new(unit, unit).unwrap()),
            Box::new(Cone::new(unit, unit).unwrap()),
            Box::new(Rounded::new(Cuboid::new(DVec3::splat(0.5 * unit)).unwrap(), 0.5 * unit).unwrap()),
        ];
        for (i, pebble) in pebbles.iter().enumerate() {
            for gap in [-0.25, -1e-3, 1e-3, 2.0] {
                let pose =
                    Pose::new(DVec3::new(3e3, -7e3, 1e4 + 1.0 + gap) * unit, DQuat::from_rotation_z(0.3 * quarter))
                        .unwrap();
                let c = solve(&floor, &**pebble, pose);
                let at = format!("unit {unit}, pebble {i}, gap {gap}: {c:?}");
                assert_eq!(c.hit, gap < 0.0, "{at}");
                let d = distance(&floor, &**pebble, pose, &Settings::default(), &mut Cache::new());
                let error = 1e-10 * unit;
                if gap < 0.0 {
                    assert!((c.depth + gap * unit).abs() <= 2e-5 * -gap * unit + error, "{at}");
                    assert!(c.depth_lower <= -gap * unit + error && -gap * unit - error <= c.depth_upper, "{at}");
                } else {
                    assert!(d.lower <= gap * unit + error && gap * unit - error <= d.upper, "{at} {d:?}");
                }
            }
        }
    }
    // A rock a thousand kilometres from its origin, in f32. The file loses digits; the query loses
    // no more.
    let far: Vec<[f32; 3]> = Family::Rock.points(200, 1).iter().map(|p| [p[0] + 1e6, p[1] * 8.0, p[2] * 8.0]).collect();
    let pack = tree_pack(&far);
    let rock = pack.hull(0).unwrap();
    let ball = Sphere::new(1.0).unwrap();
    let top = rock.support(glam::Vec3::Z).point.as_dvec3();
    let c = solve(&rock, &ball, Pose::from_translation(top + DVec3::Z * 0.5).unwrap());
    assert!(c.hit && c.depth_lower <= 0.5 + 1e-6 && c.depth_upper >= 0.5 - 1e-6 || c.depth > 0.5, "{c:?}");
}

/// The inner ball of each shape is inside the shape, and the outer ball contains it.
#[test]
fn inner_and_outer_balls_of_all_shapes() {
    let packs = packs();
    let mut rng = SplitMix64::new(SEED + 4);
    for (name, shape) in all(&packs) {
        for _ in 0..2000 {
            let n = rng.unit_vector();
            let reach = (shape.support_point(n).point - shape.interior_point()).dot(n);
            let rounding = 1e-12;
            assert!(reach >= shape.inner_radius() - rounding && reach <= shape.outer_radius() + rounding, "{name}");
            let core = (shape.core_support_point(n).point - shape.interior_point()).dot(n);
            assert!((core + shape.convex_radius() - reach).abs() < rounding, "{name}");
            let [inner, outer] = shape.core_radii();
            assert!(core >= inner - rounding && core <= outer + rounding, "{name}");
            // The corners of a feature are as far out as the support point, up to the tilt
            // tolerance.
            let mut feature = hullmap::Feature::new();
            shape.feature(n, &mut feature);
            assert!(!feature.corners().is_empty());
            for corner in feature.corners() {
                let low = shape.support_point(n).point.dot(n) - corner.point.dot(n);
                assert!((-rounding..=0.1).contains(&low), "{name}: {low}");
            }
        }
        for none in [DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::INFINITY] {
            assert!(shape.support_point(none).point.is_finite(), "{name}");
            let mut feature = hullmap::Feature::new();
            shape.feature(none, &mut feature);
            assert!(!feature.corners().is_empty() && feature.corners().iter().all(|c| c.point.is_finite()), "{name}");
        }
    }
}

#[test]
fn invalid_parameters_are_errors() {
    for bad in [f64::NAN, -1.0, f64::INFINITY, -1e-300, 1e39] {
        let length =
            |error: ShapeError| matches!(error, ShapeError::Length { found, .. } if found.to_bits() == bad.to_bits());
        assert!(length(Sphere::new(bad).unwrap_err()));
        for axis in DVec3::AXES {
            let half =
                DVec3::ONE - axis + if bad.is_nan() { DVec3::splat(bad) } else { axis * bad.clamp(-1e300, 1e300) };
            assert!(Cuboid::new(half).is_err(), "{half}");
        }
        assert!(length(Capsule::new(bad, 1.0).unwrap_err()) && length(Capsule::new(1.0, bad).unwrap_err()));
        assert!(length(Capsule::between(DVec3::X, DVec3::Y, bad).unwrap_err()));
        assert!(length(Cylinder::new(bad, 1.0).unwrap_err()) && length(Cylinder::new(1.0, bad).unwrap_err()));
        assert!(length(Cone::new(bad, 1.0).unwrap_err()) && length(Cone::new(1.0, bad).unwrap_err()));
        assert!(length(Rounded::new(Sphere::new(1.0).unwrap(), bad).unwrap_err()));
    }
    for bad in [f64::NAN, 0.0, -0.0, f64::INFINITY, 1e-39, 1e39] {
        let error = Scaled::new(Sphere::new(1.0).unwrap(), DVec3::new(1.0, bad, 1.0)).unwrap_err();
        assert!(matches!(error, ShapeError::Scale { .. }) && error.to_string().contains("scale must have"), "{error}");
    }
    for bad in [f64::NAN, f64::INFINITY, 1e39, -1e39] {
        for corner in 0..3 {
            let mut corners = [DVec3::X, DVec3::Y, DVec3::Z];
            corners[corner].y = bad;
            let error = Triangle::new(corners).unwrap_err();
            assert!(matches!(error, ShapeError::Point { found, .. } if found.y.to_bits() == bad.to_bits()), "{error}");
            let [a, b, c] = corners;
            assert!(Segment::new(a, b).is_err() || Segment::new(b, c).is_err());
            assert!(Capsule::between(a, b, 1.0).is_err() || Capsule::between(b, c, 1.0).is_err());
        }
    }
    // Zero lengths are valid.
    for shape in [
        &Sphere::new(0.0).unwrap() as &(dyn Shape + Sync),
        &Capsule::new(0.0, 0.0).unwrap(),
        &Cone::new(0.0, 0.0).unwrap(),
        &Segment::new(DVec3::ZERO, DVec3::ZERO).unwrap(),
        &Triangle::new([DVec3::ZERO; 3]).unwrap(),
    ] {
        let c = solve(shape, &Cuboid::new(DVec3::ONE).unwrap(), moved(0.5, 0.0, 0.0));
        assert!(c.hit && (c.depth - 0.5).abs() < 1e-12, "{c:?}");
    }
}

/// The features of a triangle: all corners, an edge or a corner, also if it is a segment or a
/// point.
#[test]
fn features_of_triangles() {
    let feature = |corners: [DVec3; 3], dir: DVec3| {
        let mut out = hullmap::Feature::new();
        Triangle::new(corners).unwrap().feature(dir, &mut out);
        out.corners().iter().map(|corner| corner.vertex).collect::<Vec<_>>()
    };
    let right = [DVec3::ZERO, DVec3::X, DVec3::Y];
    assert_eq!(feature(right, DVec3::Z), [0, 1, 2]);
    assert_eq!(feature(right, DVec3::new(0.01, -0.01, -1.0)), [0, 1, 2]);
    assert_eq!(feature(right, DVec3::new(1.0, 1.0, 0.5)), [1, 2]);
    assert_eq!(feature(right, DVec3::NEG_X), [0, 2]);
    assert_eq!(feature(right, DVec3::new(2.0, 1.0, 0.0)), [1]);
    // Collinear corners, and equal ones.
    assert_eq!(feature([DVec3::ZERO, DVec3::X, DVec3::X * 2.0], DVec3::Y), [0, 1, 2]);
    assert_eq!(feature([DVec3::ZERO, DVec3::X, DVec3::X * 2.0], DVec3::new(1.0, 1.0, 0.0)), [2]);
    assert_eq!(feature([DVec3::ZERO, DVec3::X, DVec3::ZERO], DVec3::Y), [0, 1]);
    assert_eq!(feature([DVec3::ONE; 3], DVec3::Y), [0]);
}

/// Answers of a shape to every method.
fn answers<S: Shape>(shape: S, dir: DVec3) -> String {
    let mut features = [hullmap::Feature::new(), hullmap::Feature::new()];
    let [near, within] = &mut features;
    shape.feature(dir, near);
    shape.feature_within(dir, 0.1, within);
    let radii = [shape.inner_radius(), shape.outer_radius(), shape.convex_radius(), shape.support_error()];
    let points = [shape.interior_point(), shape.support_point(dir).point, shape.core_support_point(dir).point];
    let feature = shape.support_point(dir).feature;
    let hinted = shape.support_point_from(dir, feature);
    let known = [shape.point(feature), shape.core_point(feature), shape.polytope_vertex(3)];
    let edges = (shape.level_edges(feature, dir, 0.1), shape.only_level_edge(feature, dir, 0.1));
    let bounds = (shape.stored_bounds(), shape.bounds_under(Pose::IDENTITY));
    let sizes = (shape.core_radii(), shape.working_set_len(), shape.facets().is_some(), shape.has_polytope_core());
    format!("{features:?} {radii:?} {sizes:?} {points:?} {hinted:?} {known:?} {edges:?} {bounds:?}")
}

/// A forgotten method of a reference would be the trait's default. Derivatives of shared hulls did
/// not know the edges.
#[test]
#[expect(clippy::needless_borrows_for_generic_args, reason = "references are the subject")]
fn references_to_a_shape_and_shared_hulls_are_the_same_shape() {
    let mut rng = SplitMix64::new(SEED + 6);
    let packs = packs();
    let hull = packs[4].1.hull(0).unwrap();
    let shared = Arc::new(tree_pack(&Family::Rock.points(300, 1))).shared_hull(0).unwrap();
    let rounded = Rounded::new(Cuboid::new(DVec3::new(0.5, 0.3, 0.7)).unwrap(), 0.2).unwrap();
    for _ in 0..200 {
        let dir = DVec3::Z + rng.unit_vector() * 0.1;
        assert_eq!(answers(&hull, dir), answers(hull, dir));
        assert_eq!(answers(&shared, dir), answers(shared.hull(), dir));
        assert_eq!(answers(&rounded, dir), answers(rounded, dir));
    }
}
