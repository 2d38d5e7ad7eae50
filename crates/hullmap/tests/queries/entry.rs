//! Rays, shape casts and signed distances against the truth in f64: clipping by all planes of a
//! hull, by all facets of a Minkowski difference, or by bisection of a closed form.

use crate::any_shape::{cast, distance, ray, signed_distance};
use glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Rounded, Scaled, Sphere};
use hullmap::{Cache, CastSettings, Impact, Motion, Pack, Pose, Ray, RayHit, Settings, Shape, Status, SupportMap};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::{
    entry::{Passage, passage, passage_of_point},
    packs::{self, point_set, tree_pack},
    polytope::{Polytope, rounding_error},
    random::RandomPoses,
    reach::Reach,
};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_122;

/// Error of an answer with default settings, relative to the size of the shapes.
const ERROR: f64 = 1e-6;

/// Hulls of rank 2 and 3.
const SETS: [(Family, usize); 14] = [
    (Family::Sphere, 8),
    (Family::Sphere, 128),
    (Family::Sphere, 2_000),
    (Family::Rock, 20),
    (Family::Rock, 400),
    (Family::ClusteredEllipsoid, 60),
    (Family::Prism, 13),
    (Family::RotatedPrism, 32),
    (Family::Cone, 20),
    (Family::Lens, 40),
    (Family::UvSphere, 62),
    (Family::CubeGrid, 27),
    (Family::FlatSheet, 20),
    (Family::Needle, 24),
];

fn pack(sets: &[(Family, usize)]) -> Pack {
    let sets: Vec<_> = sets.iter().map(|(family, n)| point_set(family.name(), &family.points(*n, *n as u64))).collect();
    Pack::from_bytes(&packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()).unwrap()
}

/// A ray towards a hull: from inside, from its surface, at a vertex, an edge, a face, past it.
fn some_ray(rng: &mut SplitMix64, hull: &Polytope, center: DVec3, radius: f64) -> (DVec3, DVec3) {
    let vertex = |rng: &mut SplitMix64| hull.points[rng.below(hull.points.len())];
    let target = match rng.below(8) {
        0 => vertex(rng),
        1 => vertex(rng).lerp(vertex(rng), 0.5),
        2 => (vertex(rng) + vertex(rng) + vertex(rng)) / 3.0,
        3 => center,
        _ => center + rng.unit_vector() * radius * rng.between(0.0, 1.2),
    };
    let direction = match rng.below(8) {
        0 => DVec3::AXES[rng.below(3)],
        1 => vertex(rng) - vertex(rng),
        2 => vertex(rng) - target,
        _ => rng.unit_vector(),
    };
    let direction = if direction == DVec3::ZERO { DVec3::X } else { direction * rng.between(0.1, 3.0) };
    let back = match rng.below(8) {
        0 => 0.0,
        1 => rng.between(-1.0, 1.0) * radius,
        2 => 1e3 * radius,
        _ => rng.between(0.0, 6.0) * radius,
    };
    (target - direction.normalize() * back, direction)
}

/// An answer about a path, in terms that rays and casts share.
#[derive(Clone, Copy, Debug)]
struct Answer {
    hit: bool,
    status: Status,
    /// Lower bound, value and upper bound.
    t: [f64; 3],
    limit: f64,
    /// Size of the shapes in units of t.
    size: f64,
}

#[derive(Default, Debug)]
struct Tally {
    answers: usize,
    hits: usize,
    misses: usize,
    grazing: usize,
    stalled: usize,
}

impl Tally {
    fn judge(&mut self, answer: &Answer, truth: &Passage, details: &dyn Fn() -> String) {
        let Answer { hit, status, t: [lower, t, upper], limit, size } = *answer;
        let mut wrong = Vec::new();
        let [earliest, latest] = truth.enter.map(|t| t.max(0.0));
        if hit {
            let certain = status != Status::Touching;
            if !(0.0 <= lower && lower <= t && t <= upper) {
                wrong.push("t is not in its own interval");
            }
            if truth.certainly_hits(limit) && !(lower <= latest && earliest <= upper) {
                wrong.push("the interval does not contain the truth");
            }
            // An interval that ends beyond the limit leaves open whether the hit is within it.
            if certain && truth.certainly_misses(limit.max(upper)) {
                wrong.push("a certain hit misses");
            }
            if status == Status::Overlapping && truth.enter[0] > 0.0 {
                wrong.push("the start is not inside");
            }
            let off = (earliest - t).max(t - latest);
            if matches!(status, Status::Exact | Status::Within) && truth.certainly_hits(limit) && off > ERROR * size {
                wrong.push("the answer is inaccurate");
            }
        } else if truth.certainly_hits(limit) {
            wrong.push("a certain miss hits");
        }
        let wrong = wrong.first();
        assert!(wrong.is_none(), "{wrong:?}: {answer:?}, truth {truth:?}\n  {}", details());
        self.answers += 1;
        self.hits += usize::from(matches!(status, Status::Exact | Status::Within));
        self.misses += usize::from(status == Status::Separated);
        self.grazing += usize::from(status == Status::Touching);
        self.stalled += usize::from(matches!(status, Status::Stalled | Status::IterationLimit));
    }
}

#[test]
fn rays_at_hulls() {
    let pack = pack(&SETS);
    let mut tally = Tally::default();
    for hull in pack.hulls() {
        let polytope = Polytope::new(&hull);
        let offsets: Vec<f64> = polytope.normals.iter().map(|n| polytope.reach(*n)).collect();
        let mut rng = SplitMix64::new(SEED);
        for round in 0..2_000 {
            let (origin, direction) = some_ray(&mut rng, &polytope, hull.interior_point(), hull.outer_radius());
            let max_t = if round % 4 == 0 { rng.between(0.0, 4.0) } else { f64::INFINITY };
            let settings = CastSettings { max_t, ..CastSettings::default() };
            let line = Ray::new(origin, direction).unwrap();
            let found = hullmap::ray(&hull, &line, &settings);
            let slack = 16.0 * f64::EPSILON * (polytope.greatest() + origin.length());
            let truth = passage_of_point(&polytope, &offsets, origin, direction, slack);
            let t = [found.t_lower, found.t, found.t_upper];
            let size = hull.outer_radius() / direction.length();
            let answer = Answer { hit: found.hit, status: found.status, t, limit: max_t, size };
            tally.judge(&answer, &truth, &|| format!("{} {line:?} {found:?}", hull.name()));
        }
    }
    println!("seed {SEED}: {tally:?}");
    assert!(tally.hits * 3 > tally.answers && tally.misses * 8 > tally.answers, "one-sided: {tally:?}");
    // Many graze: exact arithmetic decides them.
    assert!(tally.grazing == 0 && tally.stalled * 100 < tally.answers, "{tally:?}");
}

#[test]
fn casts_of_hulls() {
    let pack = pack(&SETS);
    let mut rng = SplitMix64::new(SEED);
    let hulls = pack.hulls().filter(|hull| hull.vertex_count() <= 64);
    let hulls: Vec<_> = hulls.map(|hull| (hull, Polytope::new(&hull))).collect();
    let mut tally = Tally::default();
    for (a, polytope_a) in &hulls {
        for (b, polytope_b) in &hulls {
            let mut cache = Cache::new();
            for round in 0..40 {
                let pose = rng.pose(4.0);
                let aim = rng.unit_vector() * rng.between(0.0, 2.0) - pose.translation();
                let velocity = if round % 5 == 0 { rng.unit_vector() } else { aim };
                let max_t = if round % 3 == 0 { 1.0 } else { f64::INFINITY };
                let settings = CastSettings { max_t, ..CastSettings::default() };
                let found = hullmap::cast(a, b, pose, Motion::new(velocity).unwrap(), &settings, &mut cache);
                let placed = polytope_b.placed(pose);
                let slack = rounding_error(polytope_a, &placed, pose.translation().length());
                // The facets of two parallel polygons are not known.
                let is_flat = [a, b].iter().all(|hull| hull.rank() < 3);
                let truth = if is_flat { Passage::UNBOUNDED } else { passage(polytope_a, &placed, velocity, slack) };
                let size = (a.outer_radius() + b.outer_radius()) / velocity.length();
                let t = [found.t_lower, found.t, found.t_upper];
                let answer = Answer { hit: found.hit, status: found.status, t, limit: max_t, size };
                if !is_flat {
                    let details = || format!("{} {} {pose:?} {velocity} {found:?}", a.name(), b.name());
                    tally.judge(&answer, &truth, &details);
                }
            }
        }
    }
    println!("seed {SEED}: {tally:?}");
    assert!(tally.hits * 5 > tally.answers && tally.misses * 8 > tally.answers, "one-sided: {tally:?}");
    assert!(tally.stalled * 100 < tally.answers, "{tally:?}");
}

/// A shape and its signed distance, up to a factor: negative inside and convex.
type Form = (&'static str, Box<dyn Shape + Sync>, Box<dyn Fn(DVec3) -> f64>);

fn closed_forms() -> Vec<Form> {
    let across = |p: DVec3| (p.x * p.x + p.y * p.y).sqrt();
    let half = DVec3::new(0.5, 0.8, 0.3);
    let scale = DVec3::new(1.0, 0.5, 2.0);
    let to_box = move |p: DVec3| {
        let q = p.abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    };
    let to_segment = |half: f64, p: DVec3| p.distance(DVec3::Z * p.z.clamp(-half, half));
    vec![
        ("sphere", Box::new(Sphere::new(0.7).unwrap()), Box::new(|p| p.length() - 0.7)),
        ("cuboid", Box::new(Cuboid::new(half).unwrap()), Box::new(to_box)),
        ("capsule", Box::new(Capsule::new(0.5, 0.3).unwrap()), Box::new(move |p| to_segment(0.5, p) - 0.3)),
        ("thin capsule", Box::new(Capsule::new(0.9, 1e-4).unwrap()), Box::new(move |p| to_segment(0.9, p) - 1e-4)),
        (
            "cylinder",
            Box::new(Cylinder::new(0.5, 0.4).unwrap()),
            Box::new(move |p| (p.z.abs() - 0.5).max(across(p) - 0.4)),
        ),
        (
            "cone",
            Box::new(Cone::new(0.5, 0.4).unwrap()),
            Box::new(move |p| (-0.5 - p.z).max(across(p) - 0.4 * (0.5 - p.z))),
        ),
        (
            "ellipsoid",
            Box::new(Scaled::new(Sphere::new(0.6).unwrap(), scale).unwrap()),
            Box::new(move |p| (p / scale).length() - 0.6),
        ),
        (
            "rounded cuboid",
            Box::new(Rounded::new(Cuboid::new(half).unwrap(), 0.1).unwrap()),
            Box::new(move |p| to_box(p) - 0.1),
        ),
        ("tiny sphere", Box::new(Sphere::new(1e-9).unwrap()), Box::new(|p| p.length() - 1e-9)),
    ]
}

/// The passage of a line through a convex function's negative part, by ternary search for its
/// minimum and bisection. `blur` is the error of the times.
fn passage_by_bisection(outside: &dyn Fn(f64) -> f64, reach: f64, blur: f64) -> Passage {
    let (mut from, mut to) = (-reach, reach);
    for _ in 0..200 {
        let (left, right) = (from + (to - from) / 3.0, to - (to - from) / 3.0);
        if outside(left) < outside(right) { to = right } else { from = left }
    }
    let middle = 0.5 * (from + to);
    if outside(middle) > 0.0 {
        return Passage { enter: [f64::INFINITY; 2], exit: [f64::NEG_INFINITY; 2] };
    }
    let border = |mut out: f64| {
        let mut within = middle;
        for _ in 0..200 {
            let half = 0.5 * (out + within);
            if outside(half) > 0.0 { out = half } else { within = half }
        }
        within
    };
    let (enter, exit) = (border(-reach), border(reach));
    Passage { enter: [enter - blur, enter + blur], exit: [exit - blur, exit + blur] }
}

#[test]
fn rays_at_shapes_in_closed_form() {
    let mut tally = Tally::default();
    for (name, shape, outside) in closed_forms() {
        let mut rng = SplitMix64::new(SEED);
        let radius = shape.outer_radius();
        for round in 0..1_000 {
            let target = shape.interior_point() + rng.unit_vector() * radius * rng.between(0.0, 1.1);
            let direction = rng.unit_vector() * rng.between(0.1, 3.0);
            let origin = target - direction.normalize() * radius * rng.between(-1.0, 5.0);
            let tolerance = [1e-6, 1e-6, 1e-9, 0.0][round % 4];
            let settings = CastSettings { tolerance, ..CastSettings::default() };
            let line = Ray::new(origin, direction).unwrap();
            let found = ray(&*shape, &line, &settings);
            // Where the line grazes, a relative error of 1e-15 in the closed form is one of 1e-7 in
            // the time.
            let blur = 1e-7 * radius / direction.length();
            let truth = passage_by_bisection(&|t| outside(line.point_at(t)), 20.0 * radius / direction.length(), blur);
            let t = [found.t_lower, found.t, found.t_upper];
            let size = radius / direction.length();
            let answer = Answer { hit: found.hit, status: found.status, t, limit: f64::INFINITY, size };
            tally.judge(&answer, &truth, &|| format!("{name} {line:?} {found:?}"));
            if found.hit && found.status != Status::Touching {
                assert!(outside(found.point) <= ERROR * radius, "{name} {line:?} {found:?}");
            }
        }
    }
    println!("seed {SEED}: {tally:?}");
    assert!(tally.hits * 3 > tally.answers && tally.misses * 8 > tally.answers, "one-sided: {tally:?}");
    assert!(tally.stalled * 20 < tally.answers, "{tally:?}");
}

/// The time of impact is where a distance query, which has tests of its own, finds a distance of 0.
#[test]
fn casts_of_all_shapes_by_their_distance() {
    let forms = closed_forms();
    let rock = tree_pack(&Family::Rock.points(60, 1));
    let hull = rock.hull(0).unwrap();
    let soap = Rounded::new(hull, 0.05).unwrap();
    let mut shapes: Vec<(&str, &(dyn Shape + Sync))> = forms.iter().map(|(name, shape, _)| (*name, &**shape)).collect();
    shapes.extend([("hull", &hull as &(dyn Shape + Sync)), ("rounded hull", &soap)]);
    let mut rng = SplitMix64::new(SEED);
    let mut counts = [0; 3];
    for (name_a, a) in &shapes {
        for (name_b, b) in &shapes {
            for round in 0..12 {
                let start = rng.pose(5.0);
                let velocity = rng.unit_vector() * rng.between(0.0, 1.2) - start.translation();
                let tolerance = [1e-6, 1e-9][round % 2];
                let settings = CastSettings { tolerance, ..CastSettings::default() };
                let found = cast(*a, *b, start, Motion::new(velocity).unwrap(), &settings, &mut Cache::new());
                let details = || format!("{name_a} {name_b} {start:?} {velocity}\n  {found:?}");
                let gap = |t: f64| {
                    let moved = Pose::new(start.translation() + velocity * t, start.rotation()).unwrap();
                    let exact = Settings { tolerance: 1e-12, ..Settings::default() };
                    distance(*a, *b, moved, &exact, &mut Cache::new())
                };
                match found.status {
                    Status::Separated => {
                        counts[0] += 1;
                        for step in 0..60 {
                            assert!(gap(f64::from(step) * 0.05).upper > 0.0, "{}", details());
                        }
                    }
                    Status::Overlapping => {
                        counts[1] += 1;
                        assert!(gap(0.0).lower == 0.0, "{}", details());
                    }
                    _ => {
                        counts[2] += 1;
                        assert!(found.t_lower <= found.t && found.t <= found.t_upper, "{}", details());
                        for share in [0.0, 0.5, 0.9, 0.999] {
                            assert!(gap(found.t_lower * share).upper > 0.0, "{share}: {}", details());
                        }
                        if found.status != Status::Touching {
                            let size = a.outer_radius() + b.outer_radius();
                            // Up to there, the shapes have met.
                            assert!(gap(found.t_upper).lower <= 1e-9 * size, "{:?} {}", gap(found.t_upper), details());
                            let width = (found.t_upper - found.t_lower) * velocity.length();
                            assert!(width <= 1e-5 * size, "{width:e} {}", details());
                            assert!(found.point_a.distance(found.point_b) <= 1e-5 * size, "{}", details());
                        }
                    }
                }
            }
        }
    }
    println!("seed {SEED}: {counts:?}");
    assert!(counts.iter().all(|count| *count > 30), "one-sided: {counts:?}");
}

#[test]
fn points_at_shapes_in_closed_form() {
    for (name, shape, outside) in closed_forms() {
        // The other closed forms are true distances.
        if ["cylinder", "cone", "ellipsoid"].contains(&name) {
            continue;
        }
        let (mut rng, mut cache) = (SplitMix64::new(SEED), Cache::new());
        for _ in 0..500 {
            let point = rng.unit_vector() * shape.outer_radius() * rng.between(0.0, 2.0);
            let found = signed_distance(&*shape, point, &Settings::default(), &mut cache).unwrap();
            let truth = outside(point);
            let slack = 1e-14 * shape.outer_radius();
            assert!(found.lower - slack <= truth && truth <= found.upper + slack, "{name} {point} {truth} {found:?}");
            assert!(found.lower <= found.distance && found.distance <= found.upper, "{name} {found:?}");
            assert!((found.distance - truth).abs() <= 1e-5 * shape.outer_radius(), "{name} {point} {truth} {found:?}");
            let along = (point - found.point).dot(found.normal);
            assert!((along - found.distance).abs() <= 1e-5 * shape.outer_radius(), "{name} {point} {found:?}");
        }
    }
}

#[test]
fn points_at_hulls() {
    let pack = pack(&SETS);
    let mut insides = 0;
    for hull in pack.hulls() {
        let polytope = Polytope::new(&hull);
        let offsets: Vec<f64> = polytope.normals.iter().map(|n| polytope.reach(*n)).collect();
        let (mut rng, mut cache) = (SplitMix64::new(SEED), Cache::new());
        for _ in 0..300 {
            let point = hull.interior_point() + rng.unit_vector() * hull.outer_radius() * rng.between(0.0, 1.5);
            let found = hullmap::signed_distance(&hull, point, &Settings::default(), &mut cache).unwrap();
            assert!(found.lower <= found.distance && found.distance <= found.upper, "{found:?}");
            let slack = 16.0 * f64::EPSILON * (polytope.greatest() + point.length());
            let heights = polytope.normals.iter().zip(&offsets).map(|(n, offset)| n.dot(point) - offset);
            let highest = heights.fold(f64::NEG_INFINITY, f64::max);
            // Inside, the nearest plane is the truth; outside, it is a lower bound.
            assert!(highest <= found.upper + slack, "{} {point} {highest} {found:?}", hull.name());
            if highest < -slack {
                insides += 1;
                assert!(found.lower - slack <= highest, "{} {point} {highest} {found:?}", hull.name());
                assert!(found.upper <= 0.0);
            } else {
                let proved = found.normal.dot(point) - polytope.reach(found.normal);
                assert!(found.lower <= proved + slack, "{} {point} {found:?}", hull.name());
            }
        }
    }
    assert!(insides > 500, "{insides}");
}

#[test]
fn rays_that_start_on_the_surface() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let at = |origin: [f64; 3], direction: [f64; 3]| {
        ray(&cube, &Ray::new(origin.into(), direction.into()).unwrap(), &CastSettings::default())
    };
    let into = at([1.0, 0.2, 0.1], [-1.0, 0.0, 0.0]);
    assert!(into.hit && into.t_lower == 0.0 && into.t_upper < 1e-12, "{into:?}");
    assert!(into.normal.distance(DVec3::X) < 1e-12);
    // It touches the surface at the start.
    let out = at([1.0, 0.2, 0.1], [1.0, 0.0, 0.0]);
    assert!(out.hit && out.status == Status::Exact && out.t == 0.0 && out.t_upper == 0.0, "{out:?}");
    let along = at([1.0, 0.2, 0.1], [0.0, 1.0, 0.0]);
    assert!(along.hit && along.status == Status::Exact && along.t == 0.0, "{along:?}");
    // One unit in the last place outside.
    assert_eq!(at([1.0_f64.next_up(), 0.2, 0.1], [1.0, 0.0, 0.0]).status, Status::Separated);
    assert_eq!(at([1.0_f64.next_up(), 0.2, 0.1], [0.0, 1.0, 0.0]).status, Status::Separated);
}

/// A ray from 1.5 % inside a cube far from the origin of its frame was `Exact`, with t = 0.
#[test]
fn rays_that_start_inside_overlap() {
    let corner = |i: usize, bit: usize, at: [f32; 2]| at[usize::from(i & bit != 0)];
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| [corner(i, 1, [81781.0, 81783.0]), corner(i, 2, [-1.0, 1.0]), corner(i, 4, [-1.0, 1.0])])
        .collect();
    let pack = tree_pack(&corners);
    let hull = pack.hull(0).unwrap();
    let scale = 2.0_f64.powi(110);
    let origin = DVec3::new(6.300331988517956e-29, -4.032956626326999e-34, -3.693649122063957e-34) * scale;
    let direction = DVec3::new(-3.3404182872141488e-34, -5.227812647004182e-34, 4.567152176714411e-34) * scale;
    let mut rng = SplitMix64::new(SEED + 11);
    let random = (0..2_000).map(|_| {
        let middle = DVec3::X * 81782.0;
        let inside = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)) * (1.0 - 1e-6);
        (middle + inside, DVec3::from_array(rng.direction()))
    });
    for (origin, direction) in std::iter::once((origin, direction)).chain(random) {
        for max_t in [0.0, 1.0, f64::INFINITY] {
            for tolerance in [0.0, 1e-6] {
                let settings = CastSettings { max_t, tolerance, ..CastSettings::default() };
                let hit = ray(&hull, &Ray::new(origin, direction).unwrap(), &settings);
                assert_eq!(
                    (hit.status, hit.t, hit.t_upper),
                    (Status::Overlapping, 0.0, 0.0),
                    "{origin} {direction} {hit:?}"
                );
                assert!(hit.normal.dot(direction) < 0.0 && hit.point.distance(origin) < 1e-9, "{hit:?}");
            }
        }
    }
}

#[test]
fn rays_along_faces_edges_and_through_vertices() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let at = |origin: [f64; 3], direction: [f64; 3]| {
        ray(&cube, &Ray::new(origin.into(), direction.into()).unwrap(), &CastSettings::default())
    };
    // In the plane of a face, along an edge, past a vertex: the cube is closed.
    for (origin, direction, t) in [
        ([-3.0, 0.0, 1.0], [1.0, 0.0, 0.0], 2.0),
        ([-3.0, 0.25, 1.0], [1.0, 0.0, 0.0], 2.0),
        ([-3.0, 1.0, 1.0], [2.0, 0.0, 0.0], 1.0),
        ([0.0, 2.0, 0.0], [1.0, -1.0, 0.0], 1.0),
        ([0.0, 0.0, 3.0], [1.0, 1.0, -2.0], 1.0),
    ] {
        let found = at(origin, direction);
        assert!(found.hit && found.t_lower <= t && t <= found.t_upper, "{origin:?} {direction:?} {found:?}");
        assert!(found.status == Status::Exact && found.t == t, "{origin:?} {direction:?} {found:?}");
        assert!(found.t_upper - found.t_lower < 1e-14, "{origin:?} {direction:?} {found:?}");
    }
    // Into a vertex, an edge, the middle of a face and its diagonal: certain hits.
    for (origin, direction, t) in [
        ([3.0, 3.0, 3.0], [-1.0, -1.0, -1.0], 2.0),
        ([3.0, 3.0, 0.0], [-1.0, -1.0, 0.0], 2.0),
        ([0.0, 0.0, 5.0], [0.0, 0.0, -4.0], 1.0),
        ([0.5, 0.5, 5.0], [0.0, 0.0, -4.0], 1.0),
        ([3.0, 2.0, 1.5], [-2.0, -1.5, -1.0], 1.0),
    ] {
        let found = at(origin, direction);
        assert!(matches!(found.status, Status::Exact | Status::Within), "{origin:?} {direction:?} {found:?}");
        assert!(found.t_lower <= t && t <= found.t_upper && (found.t - t).abs() < 1e-9, "{origin:?} {found:?}");
    }
    // Parallel to a face, one part in 10¹² off.
    assert_eq!(at([-3.0, 0.0, 1.0 + 1e-12], [1.0, 0.0, 0.0]).status, Status::Separated);
    assert!(matches!(at([-3.0, 0.0, 1.0 - 1e-12], [1.0, 0.0, 0.0]).status, Status::Exact | Status::Within));
}

#[test]
fn flat_hulls_of_every_rank() {
    let square: Vec<[f32; 3]> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [x, y, 0.5]).into();
    let segment = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let point = [[0.5, 0.25, 0.125]];
    let settings = CastSettings::default();
    let line = |origin: [f64; 3], direction: [f64; 3]| Ray::new(origin.into(), direction.into()).unwrap();

    let pack = tree_pack(&square);
    let hull = pack.hull(0).unwrap();
    for [x, y] in [[0.0, 0.0], [0.25, 0.5], [0.5, 0.5], [-0.9, 0.9]] {
        let found = ray(&hull, &line([x, y, 3.5], [0.0, 0.0, -1.0]), &settings);
        assert!(matches!(found.status, Status::Exact | Status::Within), "{x} {y} {found:?}");
        assert!((found.t - 3.0).abs() < 1e-12 && found.normal.z > 0.999, "{found:?}");
    }
    assert_eq!(ray(&hull, &line([1.5, 0.0, 3.5], [0.0, 0.0, -1.0]), &settings).status, Status::Separated);
    let along = ray(&hull, &line([-3.0, 0.0, 0.5], [1.0, 0.0, 0.0]), &settings);
    assert!(along.status == Status::Exact && along.t == 2.0 && along.t_upper < 2.000_001, "{along:?}");

    let pack = tree_pack(&segment);
    let hull = pack.hull(0).unwrap();
    let across = ray(&hull, &line([0.5, 0.0, 2.0], [0.0, 0.0, -1.0]), &settings);
    assert!(across.status == Status::Exact && (across.t - 2.0).abs() < 1e-12, "{across:?}");
    let along = ray(&hull, &line([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), &settings);
    assert!(along.status == Status::Exact && along.t == 2.0 && along.t_upper < 2.000_001, "{along:?}");
    assert_eq!(ray(&hull, &line([0.5, 0.1, 2.0], [0.0, 0.0, -1.0]), &settings).status, Status::Separated);

    let pack = tree_pack(&point);
    let hull = pack.hull(0).unwrap();
    let through = ray(&hull, &line([0.5, 0.25, 2.0], [0.0, 0.0, -1.0]), &settings);
    assert!(through.status == Status::Exact && (through.t - 1.875).abs() < 1e-12, "{through:?}");
    assert_eq!(ray(&hull, &line([0.5, 0.26, 2.0], [0.0, 0.0, -1.0]), &settings).status, Status::Separated);
}

/// Nothing changes with the unit of length, nor with the length of the direction.
#[test]
fn units_change_no_answer() {
    for size in [1e-30, 1e-6, 1.0, 1e6, 1e30] {
        let cube = Cuboid::new(DVec3::splat(size)).unwrap();
        for speed in [5e-324, 1e-200, 1e-3, 1.0, 1e38] {
            let line = Ray::new(DVec3::new(0.1, 0.2, 4.0) * size, DVec3::NEG_Z * speed).unwrap();
            let found = ray(&cube, &line, &CastSettings::default());
            let t = 3.0 * size / speed;
            if t.is_finite() {
                assert!(found.hit && (found.t / t - 1.0).abs() < 1e-9, "{size:e} {speed:e} {found:?}");
                assert!(found.t_lower <= t && t <= found.t_upper, "{size:e} {speed:e} {found:?}");
            }
        }
        let far = Ray::new(DVec3::new(0.1, 0.2, 1e6) * size, DVec3::NEG_Z).unwrap();
        let found = ray(&cube, &far, &CastSettings::default());
        assert!((found.t / size - 999_999.0).abs() < 1e-6 && found.status != Status::Touching, "{found:?}");
    }
}

/// Where B meets A, or a ray an A, on each path through the code: its status, and t with its
/// interval.
fn all_entries(size: f64, start: DVec3, velocity: DVec3, settings: &CastSettings) -> Vec<(&'static str, Impact)> {
    let (motion, line, at) =
        (Motion::new(velocity).unwrap(), Ray::new(start, velocity).unwrap(), Pose::from_translation(start).unwrap());
    let (cube, ball) = (Cuboid::new(DVec3::splat(size)).unwrap(), Sphere::new(size).unwrap());
    let corners: Vec<[f32; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| (2 * bit - 1) as f32 * size as f32)).collect();
    let (floor, one) = (HalfSpace::new(DVec3::X, size).unwrap(), tree_pack(&corners));
    let of_ray = |found: RayHit| {
        let RayHit { hit, status, t, t_lower, t_upper, point, .. } = found;
        Impact { hit, status, t, t_lower, t_upper, point_a: point, point_b: point, ..Impact::default() }
    };
    let none = &mut Cache::new();
    vec![
        ("ray at a box", of_ray(ray(&cube, &line, settings))),
        ("ray at a ball", of_ray(ray(&ball, &line, settings))),
        ("ray at a half-space", of_ray(hullmap::ray(&floor, &line, settings))),
        ("ray at a compound", of_ray(hullmap::ray(&one, &line, settings))),
        ("box", cast(&cube, &cube, at, motion, settings, none)),
        ("ball", cast(&cube, &ball, at, motion, settings, none)),
        ("box and half-space", hullmap::cast(&floor, &cube, at, motion, settings, none)),
        ("compound and half-space", hullmap::cast(&floor, &one, at, motion, settings, none)),
        ("compound", hullmap::cast(&one, &one, at, motion, settings, &mut Cache::new())),
    ]
}

/// 2 to the power of `exponent`, down to −1074.
fn power_of_two(exponent: i32) -> f64 {
    2_f64.powi(exponent / 2) * 2_f64.powi(exponent - exponent / 2)
}

/// The speed of a subnormal velocity had a rounding error of up to 41 %, and the status was exact.
#[test]
fn subnormal_velocities_keep_their_digits() {
    // The lengths are so small that the times are finite.
    let (size, settings) = (power_of_two(-56), CastSettings::default());
    for exponent in [100, 30, -1, -160, -400, -401, -540, -900, -1022, -1050, -1074] {
        // Of length 5, exactly. The paths start at x = 1e-15.
        let unit = power_of_two(exponent);
        let (velocity, start) = (DVec3::new(-4.0, 3.0, 0.0) * unit, DVec3::new(1e-15, -0.75e-15, 0.0));
        for (what, found) in all_entries(size, start, velocity, &settings) {
            // The first of the two lengths is a ray's.
            let is_free = what.starts_with("ray");
            let x = if is_free { size } else { 2.0 * size };
            let t = (1e-15 - x) / 4.0 / unit;
            if what.contains("ball") {
                // Not at x, but at an angle: near it.
                assert!(found.hit && (found.t / t - 1.0).abs() < 0.05, "{what}, 2^{exponent}: {found:?}");
                continue;
            }
            assert!(found.hit && (found.t / t - 1.0).abs() < 1e-6, "{what}, 2^{exponent}: {t:e} {found:?}");
            let error = 1e-12 * t;
            assert!(found.t_lower - error <= t && t <= found.t_upper + error, "{what}, 2^{exponent}: {t:e} {found:?}");
            assert!(found.point_a.is_finite() && found.point_b.is_finite(), "{what}, 2^{exponent}: {found:?}");
        }
    }
}

/// A power of two in the velocity changes nothing but the times, also on paths that graze a plane:
/// squares of speeds below 1e-162 underflowed, and a half-space reported a certain miss.
#[test]
fn a_power_of_two_in_the_velocity_changes_no_digit() {
    let mut rng = SplitMix64::new(SEED);
    let mut statuses = std::collections::BTreeMap::new();
    for _ in 0..500 {
        let along = match rng.below(3) {
            0 => DVec3::X.cross(rng.unit_vector()),
            1 => DVec3::X.cross(rng.unit_vector()) + DVec3::X * rng.between(-4.0, 4.0) * f64::EPSILON,
            _ => rng.unit_vector(),
        };
        let start = DVec3::X * [2.0, 2.0 + 1e-9, 3.0][rng.below(3)] - along * rng.between(0.0, 3.0);
        let settings = CastSettings { max_t: [4.0, f64::INFINITY][rng.below(2)], ..CastSettings::default() };
        let plain = all_entries(1.0, start, along, &settings);
        for exponent in [100, 60, -60, -340, -400, -800] {
            let scale = power_of_two(exponent);
            let slow = CastSettings { max_t: settings.max_t / scale, ..settings };
            for ((what, slow), (_, plain)) in all_entries(1.0, start, along * scale, &slow).iter().zip(&plain) {
                *statuses.entry(plain.status.as_str()).or_insert(0) += 1;
                let times = |found: &Impact| [found.t_lower, found.t, found.t_upper];
                assert_eq!(
                    (slow.status, slow.hit),
                    (plain.status, plain.hit),
                    "{what}, 2^{exponent}: {slow:?}\n{plain:?}"
                );
                assert_eq!(times(slow).map(|t| t * scale), times(plain), "{what}, 2^{exponent}: {slow:?}\n{plain:?}");
                assert_eq!((slow.point_a, slow.point_b), (plain.point_a, plain.point_b), "{what}, 2^{exponent}");
            }
        }
    }
    println!("{statuses:?}");
    assert!(["separated", "touching", "exact", "within"].iter().all(|status| statuses[status] > 300), "{statuses:?}");
}

/// Times beyond the range of f64 were infinite, with `hit` and with NaN in the points.
#[test]
fn a_time_beyond_the_range_of_f64_is_no_hit() {
    for speed in [5e-324, 1e-310, 1e-309, 2e-308] {
        let (start, settings) = (DVec3::X * 9.0, CastSettings::default());
        for (what, found) in all_entries(1.0, start, DVec3::NEG_X * speed, &settings) {
            let length = if what.starts_with("ray") { 8.0 } else { 7.0 };
            let is_late = length / speed > f64::MAX;
            assert_eq!(found.hit, !is_late, "{what}, {speed:e}: {found:?}");
            assert!(!found.hit || found.t.is_finite() && found.t_lower <= found.t, "{what}, {speed:e}: {found:?}");
            assert!(found.hit || found.status == Status::Separated && found.t_lower == f64::INFINITY, "{found:?}");
            assert!(found.point_a.is_finite() && found.point_b.is_finite(), "{what}, {speed:e}: {found:?}");
        }
    }
    // At the end of the time range, rounding error decides.
    let speed = 7.0 / f64::MAX;
    for (what, found) in all_entries(1.0, DVec3::X * 9.0, DVec3::NEG_X * speed, &CastSettings::default()) {
        if found.hit {
            assert!(found.t <= f64::MAX && found.point_a.is_finite() && found.point_b.is_finite(), "{what}: {found:?}");
            assert!(found.t_upper < f64::MAX || found.status == Status::Touching, "{what}: {found:?}");
        }
    }
}

#[test]
fn without_motion_only_the_start_counts() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let at = |origin: DVec3| ray(&cube, &Ray::new(origin, DVec3::ZERO).unwrap(), &CastSettings::default());
    assert_eq!(at(DVec3::splat(0.5)).status, Status::Overlapping);
    assert_eq!(at(DVec3::splat(1.5)).status, Status::Separated);
    let on = at(DVec3::new(1.0, 0.5, 0.0));
    assert!(on.hit && on.status == Status::Exact && on.t == 0.0 && on.t_upper == 0.0, "{on:?}");
    // The points of a cast were zero.
    let (ball, start) = (Sphere::new(0.5).unwrap(), DVec3::new(1.25, 0.5, 0.75));
    for (x, status) in [(1.25, Status::Overlapping), (1.5, Status::Touching)] {
        let pose = Pose::from_translation(start.with_x(x)).unwrap();
        let motion = Motion::new(DVec3::ZERO).unwrap();
        let found = cast(&cube, &ball, pose, motion, &CastSettings::default(), &mut Cache::new());
        assert_eq!((found.hit, found.status, found.t, found.t_upper), (true, status, 0.0, 0.0), "{found:?}");
        assert!(found.point_a.distance(found.point_b) <= 1e-15, "{found:?}");
        assert!(found.point_a.abs().max_element() <= 1.0 + 1e-15, "{found:?}");
        assert!(found.point_b.distance(pose.translation()) <= 0.5 + 1e-15, "{found:?}");
    }
    let floor = HalfSpace::new(DVec3::Z, 1.0).unwrap();
    let (up, settings) = (Motion::new(DVec3::Z).unwrap(), CastSettings::default());
    let found = hullmap::cast(&floor, &ball, Pose::IDENTITY, up, &settings, &mut Cache::new());
    assert!(found.status == Status::Overlapping && found.point_a == found.point_b, "{found:?}");
    // With a limit of 0, of NaN, or below 0, too.
    for max_t in [0.0, f64::NAN, -1.0] {
        let settings = CastSettings { max_t, ..CastSettings::default() };
        let ahead = Ray::new(DVec3::X * 3.0, DVec3::NEG_X).unwrap();
        assert_eq!(ray(&cube, &ahead, &settings).status, Status::Separated, "{max_t}");
        let inside = Ray::new(DVec3::splat(0.5), DVec3::NEG_X).unwrap();
        assert!(ray(&cube, &inside, &settings).hit, "{max_t}");
    }
}

#[test]
fn vectors_that_are_not_finite_are_rejected() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39] {
        let v = DVec3::new(0.0, bad, 0.0);
        assert_eq!(Ray::new(v, DVec3::X).unwrap_err().what, "origin");
        assert_eq!(Ray::new(DVec3::X, v).unwrap_err().what, "direction");
        assert_eq!(Motion::new(v).unwrap_err().what, "velocity");
        let cube = Cuboid::new(DVec3::ONE).unwrap();
        let found = signed_distance(&cube, v, &Settings::default(), &mut Cache::new());
        assert_eq!(found.unwrap_err().what, "point");
    }
}

/// A limit on the steps ends every search with an honest interval.
#[test]
fn few_iterations_leave_a_wide_interval() {
    let egg = Scaled::new(Sphere::new(1.0).unwrap(), DVec3::new(1.0, 0.5, 2.0)).unwrap();
    let line = Ray::new(DVec3::new(0.1, 4.0, 0.3), DVec3::new(0.02, -1.0, 0.1)).unwrap();
    let exact = ray(&egg, &line, &CastSettings { tolerance: 0.0, ..CastSettings::default() });
    for max_iterations in 0..30 {
        let found = ray(&egg, &line, &CastSettings { max_iterations, ..CastSettings::default() });
        assert!(found.hit && found.t_lower <= exact.t_upper && exact.t_lower <= found.t_upper, "{found:?}");
        assert!(max_iterations > 4 || found.status == Status::IterationLimit, "{found:?}");
    }
}
