//! Contact of small hulls and boxes by the separating axis test, compared with the depth by all
//! facets of the Minkowski difference in f64: random poses, and poses in which features are
//! parallel, nearly parallel, or touch.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use hullmap::{
    Cache, Contact, Hull, Pack, Pose, Settings, Status, SupportMap, contact, shapes::Cuboid, solver::contact_by_facets,
};
use hullmap_testkit::{
    depth::signed_depth,
    packs,
    polytope::{Polytope, rounding_error},
    random::RandomPoses,
};
use shapes::{families, rng::SplitMix64};

const SEED: u64 = 20_261_122;

/// Largest distance of a witness point from the surface, and of a depth from the truth, over the
/// size of the query: four rounding errors of a query with hulls.
const NEAR: f64 = 4e-12;

/// How B lies relative to A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// Anywhere from concentric to touching.
    Random,
    /// Turned by about 1e-3 to 1e-9 from a quarter turn: features are nearly parallel.
    NearlyParallel,
    /// Turned by a multiple of a quarter turn about an axis.
    Aligned,
    /// The interior points coincide.
    Concentric,
    /// A depth of about 1e-4 to 1e-12 of the size.
    Touching,
}

impl Kind {
    const ALL: [Self; 5] = [Self::Random, Self::NearlyParallel, Self::Aligned, Self::Concentric, Self::Touching];
}

/// Points of a body: random ones, boxes, bevelled boxes, plates, prisms, needles.
fn points(kind: usize, most: usize, rng: &mut SplitMix64) -> Vec<[f32; 3]> {
    let count = 8 + rng.below(most - 7);
    let seed = rng.next_u64();
    let of_box = |half: [f32; 3], bevel: f32| {
        let mut all = Vec::new();
        for corner in 0..8 {
            let at = |cut: [f32; 3]| {
                std::array::from_fn(|axis| (half[axis] - cut[axis]) * if corner >> axis & 1 == 0 { 1.0 } else { -1.0 })
            };
            if bevel == 0.0 {
                all.push(at([0.0; 3]));
            } else {
                all.extend([at([0.0, bevel, bevel]), at([bevel, 0.0, bevel]), at([bevel, bevel, 0.0])]);
            }
        }
        all
    };
    match kind % 8 {
        0 | 1 => families::rock(count, seed),
        2 => families::sphere(count, seed),
        3 => of_box([1.0, 1.0, 1.0], 0.0),
        4 => of_box([1.0, 0.75, 0.5], 0.0625),
        5 => of_box([1.0, 1.0, [1e-2, 1e-4][rng.below(2)]], 0.0),
        6 => families::prism(8 + 2 * rng.below(9), 0),
        _ => families::clustered_ellipsoid(count, seed),
    }
}

/// Numbers of pairs by kind of pose: all, decided by the test, and overlapping.
type Tally = BTreeMap<Kind, [u32; 3]>;

struct Body {
    pack: Pack,
    /// The box that the hull is, if it is one.
    cuboid: Option<Cuboid>,
    truth: Polytope,
}

impl Body {
    fn random(kind: usize, most: usize, scale: f32, rng: &mut SplitMix64) -> Self {
        // A quarter of the bodies are far from the origin of their frame.
        let shift = if rng.below(4) == 0 { [40.0, -24.0, 8.0] } else { [0.0; 3] };
        let place = |p: [f32; 3]| std::array::from_fn(|axis| (p[axis] + shift[axis]) * scale);
        let points: Vec<[f32; 3]> = points(kind, most, rng).into_iter().map(place).collect();
        let pack = packs::tree_pack(&points);
        let truth = Polytope::new(&pack.hull(0).unwrap());
        let cuboid = (matches!(kind % 8, 3 | 5) && shift == [0.0; 3]).then(|| {
            let [x, y, z] = points[0];
            Cuboid::new(DVec3::new(x.into(), y.into(), z.into())).unwrap()
        });
        Self { pack, cuboid, truth }
    }

    fn hull(&self) -> Hull<'_> {
        self.pack.hull(0).unwrap()
    }
}

fn pose(kind: Kind, a: &Body, b: &Body, rng: &mut SplitMix64) -> Pose {
    let (hull_a, hull_b) = (a.hull(), b.hull());
    let quarter = |rng: &mut SplitMix64| {
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][rng.below(3)];
        DQuat::from_axis_angle(axis, std::f64::consts::FRAC_PI_2 * rng.below(4) as f64)
    };
    let rotation = match kind {
        Kind::Random => rng.rotation(),
        Kind::Touching if rng.below(2) == 0 => rng.rotation(),
        Kind::NearlyParallel => {
            let turn = 10_f64.powf(rng.between(-9.0, -3.0));
            DQuat::from_axis_angle(rng.unit_vector(), turn) * quarter(rng)
        }
        Kind::Concentric if rng.below(2) == 0 => rng.rotation(),
        Kind::Aligned | Kind::Touching | Kind::Concentric => quarter(rng),
    };
    let direction = match kind {
        Kind::Aligned | Kind::NearlyParallel => [DVec3::X, DVec3::Y, DVec3::Z][rng.below(3)],
        _ => rng.unit_vector(),
    };
    let from = hull_a.interior_point() - rotation * hull_b.interior_point();
    let at = |t: f64| Pose::new(from + direction * t, rotation).unwrap();
    let reach = hull_a.outer_radius() + hull_b.outer_radius();
    match kind {
        Kind::Concentric => at(0.0),
        Kind::Touching => {
            let size = reach * 10_f64.powf(rng.between(-12.0, -4.0));
            let (mut inside, mut outside) = (0.0, reach);
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                let (depth, _) = signed_depth(&a.truth, &b.truth.placed(at(middle)), size);
                if depth > size { inside = middle } else { outside = middle }
            }
            at(inside)
        }
        _ => at(reach * rng.between(0.0, 0.6)),
    }
}

/// How far a point is outside of a convex polytope; negative inside.
fn outside(polytope: &Polytope, point: DVec3) -> f64 {
    let offset = |n: DVec3| polytope.points.iter().map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max);
    polytope.normals.iter().map(|n| point.dot(*n) - offset(*n)).fold(f64::NEG_INFINITY, f64::max)
}

fn judge(found: &Contact, a: &Polytope, b: &Polytope, frames: f64, size: f64, what: &str) {
    let error = rounding_error(a, b, frames);
    let (truth, _) = signed_depth(a, b, f64::NEG_INFINITY);
    let report = format!("{what}: truth {truth:e}, found {found:?}");
    if !found.hit {
        assert!(truth <= error, "{report}");
        return;
    }
    assert!(found.depth_lower <= truth + error && truth - error <= found.depth_upper, "{report}");
    assert!(
        found.depth_lower > 0.0 && found.depth_lower <= found.depth && found.depth <= found.depth_upper,
        "{report}"
    );
    assert!((found.depth - truth).abs() <= NEAR * size + error, "{report}");
    assert!(matches!(found.status, Status::Exact | Status::Within), "{report}");
    assert!((found.normal.length() - 1.0).abs() < 1e-14, "{report}");
    let (on_a, on_b) = (outside(a, found.point_a), outside(b, found.point_b));
    assert!(on_a.abs() <= NEAR * size + error && on_b.abs() <= NEAR * size + error, "{on_a:e} {on_b:e} {report}");
    let between = found.point_a - found.point_b - found.normal * found.depth;
    assert!(between.length() <= 1e-6 * found.depth + 4.0 * NEAR * size, "{between} {report}");
}

/// Judges pairs of hulls of at most `most` vertices.
fn judge_all(rounds: u64, poses: u64, most: usize) -> Tally {
    let mut rng = SplitMix64::new(SEED);
    let mut tally = Tally::new();
    let settings = Settings { tolerance: 0.0, ..Settings::default() };
    for round in 0..rounds {
        let scale = [1.0, 1.0, 1e-3, 1e3, 1e-6, 1e6][rng.below(6)];
        let kinds = [rng.below(8), rng.below(8)];
        let bodies = kinds.map(|kind| Body::random(kind, most, scale, &mut rng));
        let [a, b] = &bodies;
        let (hull_a, hull_b) = (a.hull(), b.hull());
        let far = hull_a.interior_point().length() + hull_b.interior_point().length();
        let size = hull_a.outer_radius() + hull_b.outer_radius() + far;
        for index in 0..poses {
            let kind = Kind::ALL[index as usize % Kind::ALL.len()];
            let b_in_a = pose(kind, a, b, &mut rng);
            let placed = b.truth.placed(b_in_a);
            let what = format!("seed {SEED}, pair {round}, pose {index}, {kind:?}, bodies {kinds:?}, {b_in_a:?}");
            let frames = b_in_a.translation().length();
            let mut answers = vec![contact_by_facets(&hull_a, &hull_b, b_in_a, &settings)];
            if let Some(cuboid) = &a.cuboid {
                answers.push(contact_by_facets(cuboid, &hull_b, b_in_a, &settings));
            }
            if let Some(cuboid) = &b.cuboid {
                answers.push(contact_by_facets(&hull_a, cuboid, b_in_a, &settings));
            }
            if let (Some(cuboid_a), Some(cuboid_b)) = (&a.cuboid, &b.cuboid) {
                answers.push(contact_by_facets(cuboid_a, cuboid_b, b_in_a, &settings));
            }
            let counts = tally.entry(kind).or_default();
            for found in answers {
                counts[0] += 1;
                let Some(found) = found else { continue };
                counts[1] += 1;
                counts[2] += u32::from(found.hit);
                judge(&found, &a.truth, &placed, frames, size, &what);
            }
            // Whichever path answers.
            let found = contact(&hull_a, &hull_b, b_in_a, &settings, &mut Cache::new());
            let (truth, _) = signed_depth(&a.truth, &placed, f64::NEG_INFINITY);
            let error = rounding_error(&a.truth, &placed, frames);
            let fits = if found.hit { found.depth_lower <= truth + error } else { truth <= error };
            assert!(fits && truth - error <= found.depth_upper, "{what}: truth {truth:e}, {found:?}");
        }
    }
    tally
}

#[test]
fn depths_contain_the_truth_in_degenerate_poses() {
    let tally = judge_all(450, 36, 32);
    println!("seed {SEED}: pairs, decided, overlapping\n{tally:?}");
    for (kind, [pairs, decided, hits]) in &tally {
        assert!(*pairs >= 2_700, "{kind:?}");
        // Touching pairs are left to the general path, and so are depths that f32 cannot rank.
        let least = if *kind == Kind::Touching { 0.2 } else { 0.9 };
        assert!(f64::from(*decided) >= least * f64::from(*pairs), "{kind:?}: {decided} of {pairs}");
        assert!(2 * hits > *decided, "{kind:?}: one-sided, {hits} of {decided}");
    }
}

/// Hulls above 32 vertices have no face table. The depth by all facets takes longer.
#[test]
fn depths_of_larger_hulls_contain_the_truth() {
    let tally = judge_all(150, 20, 128);
    println!("seed {SEED}: pairs, decided, overlapping\n{tally:?}");
    for (kind, [pairs, decided, hits]) in &tally {
        assert!(*pairs >= 600, "{kind:?}");
        let share = f64::from(*decided) / f64::from(*pairs);
        let expected = if *kind == Kind::Touching { 0.02..0.5 } else { 0.2..0.8 };
        assert!(expected.contains(&share), "{kind:?}: {decided} of {pairs}");
        assert!(2 * hits > *decided, "{kind:?}: one-sided, {hits} of {decided}");
    }
}

/// Two aligned cubes, one of them moved along x: the witness points are on the faces, and opposite.
#[test]
fn witness_points_of_parallel_faces_are_on_both_faces() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    for shift in [DVec3::new(1.5, 0.25, -0.5), DVec3::new(1.5, 1.2, 0.0), DVec3::new(-1.75, 0.0, 1.0)] {
        let b_in_a = Pose::from_translation(shift).unwrap();
        let found = contact_by_facets(&cube, &cube, b_in_a, &Settings::default()).expect("decided");
        let depth = 2.0 - shift.x.abs();
        assert_eq!((found.status, found.normal), (Status::Exact, DVec3::X * shift.x.signum()));
        assert!((found.depth - depth).abs() < 1e-14);
        assert!((found.point_a - found.point_b - found.normal * depth).length() < 1e-13, "{found:?}");
        for (point, center) in [(found.point_a, DVec3::ZERO), (found.point_b, shift)] {
            let local = (point - center).abs();
            assert!((local.x - 1.0).abs() < 1e-13 && local.max_element() < 1.0 + 1e-13, "{found:?}");
        }
    }
}

/// A second query starts from the normal of the first.
#[test]
fn caches_change_no_depth() {
    let mut rng = SplitMix64::new(SEED);
    let packs = [11, 12].map(|seed| packs::tree_pack(&families::rock(16, seed)));
    let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
    let settings = Settings::default();
    let mut decided = 0;
    for _ in 0..300 {
        let b_in_a = rng.pose(0.5);
        let mut cache = Cache::new();
        let found = [(); 4].map(|()| contact(&a, &b, b_in_a, &settings, &mut cache));
        decided += u32::from(contact_by_facets(&a, &b, b_in_a, &settings).is_some());
        for other in &found[1..] {
            assert_eq!(other.hit, found[0].hit);
            assert!(other.depth_lower <= found[0].depth_upper && found[0].depth_lower <= other.depth_upper);
        }
    }
    assert!(decided > 290, "{decided}");
}
