//! Support queries against brute force over the source points, where an index can go wrong.
//!
//! The tests cover every family of shapes, turned, scaled and moved; every index; both instruction
//! sets; f32 and f64; with and without hints. The samples are counted, so that no test is vacuous:
//! each kind of direction, node and hint must occur.

mod nodes;

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Vec3};
use hullmap::{Hull, Instructions, Pack, SupportMap};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{ALL_INDICES, bytes, pack, point_set};
use hullmap_testkit::random::RandomPoses;
use hullmap_tests::directions::{self, KINDS, Kind, Maker};
use hullmap_tests::regret::Truth;
use nodes::Counts;
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0xe8ac7;

/// Maximum regret that counts as exact, by the project's definition.
const EXACT: f64 = 2e-7;

/// Maximum regret by design of the index: a cone that reaches less than 4e-15 beyond a cut, in
/// units of u and v, is not listed there. A unit of u is at most a radian.
const SLIVERS: f64 = 8e-15;

/// [`SLIVERS`] around a fan's axis. A cone that reaches less than 4e-15 beyond two cuts may be
/// listed by neither side, and the vertex listed instead is as far off as the cuts are apart there.
const SLIVERS_AT_AXIS: f64 = 4e-13;

/// Error of the difference of two dot products in f64, relative to the greatest coordinate.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Maximum distance of source points from a flat hull, relative to the diameter.
const FLAT: f64 = 1e-7;

/// Maximum distance of a source point from its hull, relative to the diameter.
const CONTAINMENT: f64 = 1e-7;

/// Counts of queries: directions of each kind, nodes of each kind, and wrong hints.
#[derive(Debug, Default)]
pub struct Met {
    kinds: BTreeMap<Kind, usize>,
    nodes: Counts,
    wrong_hints: usize,
    compared: usize,
    pub worst: f64,
}

impl Met {
    fn add(&mut self, other: Met) {
        for (kind, count) in other.kinds {
            *self.kinds.entry(kind).or_default() += count;
        }
        self.nodes.iter_mut().zip(other.nodes).for_each(|(sum, count)| *sum += count);
        self.wrong_hints += other.wrong_hints;
        self.compared += other.compared;
        self.worst = self.worst.max(other.worst);
    }

    /// Asserts that every kind of direction, node and hint occurs often enough.
    fn assert_representative(&self) {
        println!("seed {SEED:#x}: {self:#?}");
        let drawn: usize = self.kinds.values().sum();
        assert!(KINDS.iter().all(|kind| self.kinds[kind] * 50 > drawn), "directions");
        assert!(self.nodes[..4].iter().all(|count| *count > 20), "branches, planes, bundles and fans");
        assert!(self.wrong_hints > self.compared / 4, "hints that are wrong");
    }
}

/// Hulls of at most this number of faces are queried along all their normals.
const FEW_FACES: usize = 128;

/// Queries a hull of `points` in `count` directions, each in f64 and rounded to f32, with each of
/// `indices`; a small hull along all its normals, too. Panics if a regret exceeds `slivers` plus
/// the rounding error, if a query costs more than stated, or if a point is lost.
pub fn check(name: &str, points: &[[f32; 3]], indices: &[IndexKind], count: usize, slivers: f64) -> Met {
    let (truth, mut met) = (Truth::new(points), Met::default());
    let files: Vec<Vec<u8>> = indices
        .iter()
        .map(|&index| bytes(&[point_set(name, points)], index, &SourceRecord::default()))
        .collect::<Result<_, _>>()
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let packs: Vec<Pack> = files.iter().map(|file| Pack::from_bytes(file).unwrap()).collect();
    let hulls: Vec<Hull> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let (first, (nodes, fans)) = (hulls[0], nodes::nodes(&files[0]));
    met.nodes = nodes;
    let mut maker = Maker::new(&first, fans, SEED);
    let mut rng = SplitMix64::new(!SEED);
    // Source points may lie outside a hull that is flat except for rounding error.
    let is_rounded = first.rank() < 3 && first.containment_error() > 0.0;
    let thickness = if is_rounded { FLAT } else { 0.0 };
    let allowed = slivers + ROUNDING * truth.reach / truth.diameter + thickness;
    for hull in &hulls {
        assert_eq!(hull.rank(), first.rank(), "{name}: the rank does not depend on the index");
        assert!(hull.containment_error() <= CONTAINMENT, "{name}: {}", hull.containment_error());
        let is_lost = |v: Vec3| !points.contains(&v.to_array());
        assert!(points.len() > 3_000 || !hull.vertices().any(is_lost), "{name}: a vertex is not a source point");
        // An invalid direction gets some vertex.
        for d in directions::invalid() {
            let got = hull.support(d);
            assert_eq!((hull.vertex(got.index), hull.support_from(d, got.index)), (Some(got.point), got));
            assert!((SupportMap::support_point(hull, d.as_dvec3()).feature as usize) < hull.vertex_count());
        }
    }
    let (mut failures, mut before) = (0, 0);
    let normals = maker.normals(FEW_FACES).into_iter().map(|n| (Kind::Normal, n)).collect::<Vec<_>>();
    for (kind, exact) in (0..count).map(|direction| maker.make(direction)).chain(normals) {
        let narrow = exact.as_vec3();
        *met.kinds.entry(kind).or_default() += 1;
        // Rounding to f32 turns the shortest directions into zero and the longest into infinity.
        let truths = [exact, narrow.as_dvec3()].map(|d| truth.in_direction(d));
        let sets = [Instructions::Portable, Instructions::Avx2];
        let all = hulls.iter().zip(indices).flat_map(|pair| sets.map(|set| (pair, set)));
        for ((hull, index), instructions) in all {
            let Some(hull) = hull.with_instructions(instructions) else { continue };
            let at = || format!("{name} {index:?} {instructions:?} {kind:?} {exact:?}");
            let (got, got_narrow) = (SupportMap::support_point(&hull, exact), hull.support(narrow));
            let (cost, most) = (hull.support_cost(narrow), hull.worst_cost());
            assert!(cost.nodes <= most.nodes && cost.dots <= most.dots, "{}: {cost:?} exceeds {most:?}", at());
            assert_eq!(hull.vertex(got_narrow.index), Some(got_narrow.point));
            assert_eq!(hull.vertex(got.feature).map(Vec3::as_dvec3), Some(got.point));
            for (truth, point) in truths.iter().zip([got.point, got_narrow.point.as_dvec3()]) {
                let Some(truth) = truth else { continue };
                let regret = truth.regret(point);
                met.compared += 1;
                met.worst = met.worst.max(regret);
                // NaN takes the failing branch.
                if !(regret <= allowed) {
                    failures += 1;
                    println!("{}: regret {regret:e}, allowed {allowed:e}", at());
                }
            }
            // Hints test data that all indices share, before the index; one index is enough.
            if *index != indices[0] {
                continue;
            }
            // The right vertex, the last direction's vertex, any vertex, and two invalid ones.
            let (right, invalid) = (got_narrow.index, hull.vertex_count() as u32);
            for hint in [right, before, rng.below(hull.vertex_count()) as u32, invalid, u32::MAX] {
                let hinted = hull.support_from(narrow, hint);
                assert_eq!(hull.vertex(hinted.index), Some(hinted.point));
                let d = narrow.as_dvec3();
                let (with, without) = (hinted.point.as_dvec3().dot(d), got_narrow.point.as_dvec3().dot(d));
                let loss = if slivers < EXACT { 0.0 } else { EXACT * d.length() * truth.diameter };
                assert!(with >= without - loss || d.is_nan(), "{} from {hint}", at());
                met.wrong_hints += usize::from(hint != right);
            }
        }
        before = first.support(narrow).index;
    }
    println!("{name:28} {:6} vertices, {nodes:?}, worst {:.1e}", first.vertex_count(), met.worst);
    assert_eq!(failures, 0, "{name}: wrong answers, seed {SEED:#x}");
    assert!(met.worst <= EXACT);
    met
}

fn turned(points: &[[f32; 3]], seed: u64) -> Vec<[f32; 3]> {
    let mut rng = SplitMix64::new(seed);
    let axis = rng.unit_vector();
    moved(points, DQuat::from_axis_angle(axis, 6.0 * rng.unit()), 1.0, DVec3::ZERO)
}

fn moved(points: &[[f32; 3]], rotation: DQuat, scale: f64, offset: DVec3) -> Vec<[f32; 3]> {
    let transform = |p: &[f32; 3]| rotation * DVec3::from_array(p.map(f64::from)) * scale + offset;
    points.iter().map(|p| transform(p).as_vec3().to_array()).collect()
}

/// A shape about z: rings of these radii, heights and angles.
fn rings(rings: &[(f64, f64, Vec<f64>)]) -> Vec<[f32; 3]> {
    let point = |r: f64, z: f64, angle: f64| [(r * libm::cos(angle)) as f32, (r * libm::sin(angle)) as f32, z as f32];
    rings.iter().flat_map(|(r, z, angles)| angles.iter().map(move |a| point(*r, *z, *a))).collect()
}

fn even(n: usize) -> Vec<f64> {
    (0..n).map(|i| std::f64::consts::TAU * i as f64 / n as f64).collect()
}

fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = SplitMix64::new(seed);
    (0..n).map(|_| std::f64::consts::TAU * rng.unit()).collect()
}

/// Seven even angles; all others lie at distances of 0.1 down to 1e-7 from one of them.
fn crowded(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = SplitMix64::new(seed);
    let mut angles = even(7);
    while angles.len() < n {
        let near = angles[rng.below(7)];
        angles.push(near + 10_f64.powf(-1.0 - 6.0 * rng.unit()));
    }
    angles
}

fn main_axis_to(to: DVec3) -> DQuat {
    DQuat::from_rotation_arc(DVec3::Z, to.normalize())
}

#[test]
fn every_family_with_every_index() {
    let mut sum = Met::default();
    for family in Family::ALL {
        let points = family.points(1_500, 11);
        sum.add(check(family.name(), &points, &ALL_INDICES, 4_000, SLIVERS));
        sum.add(check(family.name(), &family.points(20_000, 5), &ALL_INDICES[..1], 7_000, SLIVERS));
        for n in [8, 9, 40, 200] {
            sum.add(check(&format!("{} {n}", family.name()), &family.points(n, 7), &ALL_INDICES, 1_500, SLIVERS));
        }
    }
    sum.assert_representative();
}

#[test]
fn every_family_turned_scaled_and_moved() {
    let mut sum = Met::default();
    for family in Family::ALL {
        let points = family.points(3_000, 2);
        let around = |scale, offset| moved(&points, DQuat::from_rotation_y(0.3), scale, DVec3::splat(offset));
        for (name, points) in [
            ("turned", turned(&points, 1)),
            ("turned again", turned(&points, 2)),
            ("tiny", around(1e-6, 0.0)),
            ("huge", around(1e6, 0.0)),
            ("far", around(1.0, 1_000.0)),
        ] {
            sum.add(check(&format!("{} {name}", family.name()), &points, &ALL_INDICES[..2], 4_000, SLIVERS));
        }
    }
    for family in [Family::Rock, Family::Lens, Family::RotatedPrism, Family::FlatSheet, Family::Needle] {
        for scale in [1e-30, 1e30] {
            let points: Vec<[f32; 3]> = family.points(500, 5).iter().map(|p| p.map(|c| c * scale)).collect();
            let (pack, truth) = (pack(family.name(), &points, IndexKind::Tree), Truth::new(&points));
            let hull = pack.hull(0).unwrap();
            for dir in directions::all(&hull, 2_000, 0x5eed) {
                let regret = truth.regret(dir, hull.support(dir).point);
                assert!(regret <= EXACT, "{} times {scale:e}: regret {regret:e} in direction {dir}", family.name());
            }
        }
    }
    sum.assert_representative();
}

#[test]
fn prisms_and_other_shapes_with_fans() {
    let mut sum = Met::default();
    let prism = |angles: Vec<f64>| rings(&[(1.0, -1.0, angles.clone()), (1.0, 1.0, angles)]);
    let mut shapes: Vec<(String, Vec<[f32; 3]>)> = Vec::new();
    for n in [100, 1_000, 20_000] {
        shapes.push((format!("even prism {n}"), prism(even(n / 2))));
        shapes.push((format!("random prism {n}"), prism(random(n / 2, 1))));
        shapes.push((format!("crowded prism {n}"), prism(crowded(n / 2, 2))));
        shapes.push((format!("truncated cone {n}"), rings(&[(1.0, -1.0, even(n / 2)), (0.3, 1.0, even(n / 2))])));
        shapes.push((format!("antiprism {n}"), rings(&[(1.0, -1.0, even(n / 2)), (1.0, 1.0, random(n / 2, 5))])));
        shapes.push((format!("cone {n}"), Family::Cone.points(n, 0)));
        shapes.push((format!("rotated prism {n}"), Family::RotatedPrism.points(n, 0)));
        let mut two = prism(even(n / 4));
        two.extend(moved(&prism(random(n / 4, 3)), DQuat::from_rotation_x(1.0), 0.9, DVec3::ZERO));
        shapes.push((format!("two prisms {n}"), two));
    }
    let base = prism(even(2_000));
    for (name, to) in [
        ("seam", DVec3::new(1.0, 1.0, 0.0)),
        ("corner", DVec3::ONE),
        ("middle of a cell", DVec3::new(0.5, 0.5, 1.0)),
        ("near a seam", DVec3::new(1.0, 1.0 + 1e-7, 0.2)),
        ("edge of a cell", DVec3::new(0.0, 0.25, 1.0)),
    ] {
        shapes.push((format!("prism to {name}"), moved(&base, main_axis_to(to), 1.0, DVec3::ZERO)));
    }
    shapes.push(("prism far away".into(), moved(&base, DQuat::IDENTITY, 1.0, DVec3::new(1000.0, -2000.0, 500.0))));
    shapes.push(("thin disc".into(), base.iter().map(|p| [p[0], p[1], p[2] * 1e-3]).collect()));
    shapes.push(("long rod".into(), base.iter().map(|p| [p[0] * 1e-3, p[1] * 1e-3, p[2]]).collect()));
    for (name, points) in shapes {
        sum.add(check(&name, &points, &ALL_INDICES[..2], 8_000, SLIVERS));
    }
    sum.assert_representative();
}

/// Nearly flat caps at height 0, where f32 can represent the smallest bumps: the normals of their
/// facets lie within 1e-6 or less of a fan's axis, and the cones are as small.
fn bumpy_cap(bump: f64, rim: &[f64]) -> Vec<[f32; 3]> {
    let mut points = rings(&[(1.0, -1.0, rim.to_vec()), (1.0, 0.0, rim.to_vec())]);
    for ring in 1..6 {
        let r = f64::from(ring) / 6.0;
        points.extend(rings(&[(r, bump * (1.0 - r * r), random(12, ring as u64))]));
    }
    points
}

#[test]
fn nearly_flat_caps() {
    let mut sum = Met::default();
    for bump in [1e-7, 1e-9, 1e-11, 1e-12, 1e-13, 1e-15, 1e-20] {
        for n in [300, 3_000] {
            let name = |kind| format!("{kind} cap {bump:e}, {n}");
            let mut check_cap = |kind, points: &[[f32; 3]]| {
                sum.add(check(&name(kind), points, &ALL_INDICES[..1], 5_000, SLIVERS_AT_AXIS));
            };
            check_cap("bumpy", &bumpy_cap(bump, &random(n, 4)));
            check_cap("crowded", &bumpy_cap(bump, &crowded(n, 2)));
            let mut rng = SplitMix64::new(9);
            let mut rough = rings(&[(1.0, -1.0, random(n, 8))]);
            rough.extend(rings(&[(1.0, 0.0, random(n, 8))]).iter().map(|p| [p[0], p[1], (bump * rng.unit()) as f32]));
            check_cap("rough", &rough);
        }
    }
    sum.assert_representative();
    assert!(sum.nodes[4] > 20, "lists");
}

/// Cones of 1e-10 around the axis of a fan with narrow steps reached over no step's border by
/// 1e-13, were listed nowhere, and a vertex of the rim was found instead: a regret of 2e-11.
#[test]
fn small_cones_between_two_cuts_are_listed() {
    for n in [300, 3_000] {
        check(&format!("bumps of 1e-10, {n}"), &bumpy_cap(1e-10, &crowded(n, 2)), &ALL_INDICES[..1], 50_000, SLIVERS);
    }
}

/// Degenerate points that no family contains: ties, duplicates, every rank, nearly flat, nearly
/// straight, and caps that are tilted by a few units in the last place.
/// docs/contributors/intervals.md (section 9), docs/contributors/FORMAT.md and docs/limits.md state
/// the worst regrets.
#[test]
fn exact_on_degenerate_points() {
    let nearly_flat = |thickness: f32| -> Vec<[f32; 3]> {
        Family::Ball.points(300, 2).iter().map(|p| [p[0], p[1], p[2] * thickness]).collect()
    };
    let nearly_straight = |width: f32| -> Vec<[f32; 3]> {
        Family::Ball.points(300, 4).iter().map(|p| [p[0] * width, p[1], p[2] * width]).collect()
    };
    let mut cases: Vec<(String, Vec<[f32; 3]>)> = vec![
        ("point".into(), vec![[1.0, -2.0, 3.0]; 4]),
        ("segment".into(), vec![[0.0; 3], [1.0, 2.0, 3.0], [0.5, 1.0, 1.5], [0.0; 3]]),
        ("triangle".into(), vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        ("signed_zeros".into(), vec![[0.0, -0.0, 0.0], [-0.0, 0.0, -0.0], [1.0, -0.0, 0.0], [0.0, 1.0, 0.0]]),
        ("two_far_points".into(), vec![[f32::MAX / 4.0; 3], [-f32::MAX / 4.0; 3]]),
        ("tiny".into(), Family::Rock.points(64, 1).iter().map(|p| p.map(|c| c * 1e-42)).collect()),
    ];
    for exponent in 1..12 {
        let t = 10_f32.powi(-exponent);
        cases.push((format!("flat 1e-{exponent}"), nearly_flat(t)));
        cases.push((format!("straight 1e-{exponent}"), nearly_straight(t)));
    }
    for (corners, tilt) in [12, 40, 300].into_iter().flat_map(|n| [0.6e-7, 1e-7, 2e-7, 1e-6].map(|tilt| (n, tilt))) {
        let tilted = |[x, y, z]: [f32; 3]| [x, y, z + tilt * (x + 0.3 * y)];
        let points = Family::Prism.points(corners, 0).into_iter().map(tilted).collect();
        cases.push((format!("prism of {corners}, tilted by {tilt:e}"), points));
    }
    for (name, points) in cases {
        // Points near a plane or a line are baked as a polygon or a segment.
        let most = if name.starts_with("flat") || name.starts_with("straight") { 5e-8 } else { 1e-12 };
        let met = check(&name, &points, &ALL_INDICES, 1_000, most);
        assert!(met.worst <= most, "{name}: regret {:e}", met.worst);
    }
}
