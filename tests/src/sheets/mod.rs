//! Judges queries of triangle meshes by brute force over all triangles.
//!
//! | module | contents |
//! |---|---|
//! | [`scene`] | meshes of all kinds, and bodies beside them |
//! | [`exact`] | truths in integers, where all coordinates are whole |
//! | [`joints`] | rays at edges, vertices and seams of meshes, fields and parts |
//! | [`rational`] | truths of rays in rational numbers, for any coordinates |
//! | [`manifolds`] | manifolds of bodies of all kinds: every point is on both surfaces |
//!
//! Truths in f64 have a slack for their own rounding error. Where a truth is within it, and the
//! coordinates are whole, integers decide; other such cases are counted as unsure.

pub mod exact;
pub mod joints;
pub mod manifolds;
pub mod rational;
pub mod scene;

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;
use hullmap::compound::surface_distance;
use hullmap::{Cache, CastSettings, Contact, Motion, Overlap, Ray, Settings};
use hullmap_testkit::depth::signed_depth_by_points;
use hullmap_testkit::gap::distance_by_features;
use hullmap_testkit::triangles::{distance_from_triangle, winding};
use shapes::rng::SplitMix64;

use exact::Whole;
use scene::{Body, Kind, Scene};

/// Number of queries of each kind in a scene.
const QUERIES: u64 = 40;

/// Counts over all scenes.
#[derive(Debug, Default)]
pub struct Tally {
    /// Number of queries of each kind, with a short outcome.
    pub counts: BTreeMap<(&'static str, &'static str), u64>,
    /// Wrong answers, in words.
    pub wrong: Vec<String>,
}

impl Tally {
    /// Judges the queries of the scene with this index.
    pub fn judge(&mut self, seed: u64, index: u64) {
        let kind = Kind::ALL[(index % Kind::ALL.len() as u64) as usize];
        let scene = Scene::new(kind, seed, index);
        let mut rng = SplitMix64::new(seed ^ !index);
        let mut judge = Judge { tally: self, scene: &scene, name: format!("{kind:?}, --seed {seed} --first {index}") };
        for _ in 0..QUERIES {
            let body = scene.body(&mut rng);
            judge.pair(&body);
            judge.cast(&body, &mut rng);
            judge.ray(&mut rng);
            judge.point(&mut rng);
        }
    }

    /// Number of queries judged.
    pub fn queries(&self) -> u64 {
        self.counts.values().sum()
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for ((query, outcome), count) in &self.counts {
            writeln!(f, "{query:>16} {outcome:<12} {count:>9}")?;
        }
        write!(f, "{} queries, {} wrong", self.queries(), self.wrong.len())
    }
}

struct Judge<'s> {
    tally: &'s mut Tally,
    scene: &'s Scene,
    name: String,
}

/// Range of the time of the first meeting: from the earliest possible time to the time of the first
/// certain meeting.
#[derive(Clone, Copy)]
struct First {
    possible: f64,
    certain: f64,
}

impl First {
    const NEVER: Self = Self { possible: f64::INFINITY, certain: f64::INFINITY };

    fn add(&mut self, possible: f64, certain: f64) {
        self.possible = self.possible.min(possible);
        self.certain = self.certain.min(certain);
    }
}

impl Judge<'_> {
    fn count(&mut self, query: &'static str, outcome: &'static str) {
        *self.tally.counts.entry((query, outcome)).or_default() += 1;
    }

    fn check(&mut self, is_right: bool, what: impl FnOnce() -> String) {
        if !is_right {
            self.tally.wrong.push(format!("{}: {}", self.name, what()));
        }
    }

    /// A point in units, if the coordinates are whole.
    fn whole(&self, point: DVec3) -> Whole {
        (point / self.scene.unit).to_array().map(|c| c as i128)
    }

    /// Twice the coordinates, which are halves.
    fn doubled(&self, point: DVec3) -> Whole {
        (point * 2.0 / self.scene.unit).to_array().map(|c| c as i128)
    }

    /// Distance, overlap and contacts of a body.
    fn pair(&mut self, body: &Body) {
        let (scene, settings) = (self.scene, Settings::default());
        let hull = body.pack.hull(0).expect("one hull");
        let slack = scene.slack;
        let depths: Vec<f64> = scene.triangles.iter().map(|corners| self.depth(corners, body)).collect();
        let deepest = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let exact = body.is_exact.then(|| {
            let solid: Vec<Whole> = body.points.iter().map(|p| self.whole(*p)).collect();
            scene.triangles.iter().map(|corners| exact::gap(&corners.map(|c| self.whole(c)), &solid)).min()
        });
        let truth = match exact.flatten() {
            Some(Ordering::Greater) => "apart",
            Some(Ordering::Equal) => "touching",
            Some(Ordering::Less) => "overlapping",
            None if deepest > slack => "overlapping",
            None if deepest < -slack => "apart",
            None => "unsure",
        };
        let hit = hullmap::intersects(&scene.mesh, &hull, body.pose, &mut Cache::new());
        self.count("intersects", truth);
        let is_near = deepest.abs() <= 1e3 * slack;
        self.check(
            match hit.status {
                Overlap::Separated => matches!(truth, "apart" | "unsure"),
                Overlap::Overlapping => matches!(truth, "overlapping" | "unsure"),
                Overlap::Touching | Overlap::Undecided => is_near,
            },
            || format!("intersects: {hit:?}, {truth}, depth {deepest}"),
        );
        self.distance(body, truth, &settings);
        self.contacts(body, &depths, &settings);
    }

    /// Depth of a body in a triangle; negative, and no more than a bound, if they are far apart.
    fn depth(&self, corners: &[DVec3; 3], body: &Body) -> f64 {
        let radius = |points: &[DVec3], center: DVec3| points.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
        let middle = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len() as f64;
        let (center_t, center_b) = (middle(corners), middle(&body.points));
        let gap = center_t.distance(center_b) - radius(corners, center_t) - radius(&body.points, center_b);
        if gap > 1e-3 * self.scene.unit { -gap } else { signed_depth_by_points(corners, &body.points) }
    }

    fn distance(&mut self, body: &Body, truth: &'static str, settings: &Settings) {
        let (scene, hull) = (self.scene, body.pack.hull(0).expect("one hull"));
        let found = hullmap::distance(&scene.mesh, &hull, body.pose, settings, &mut Cache::new());
        self.count("distance", truth);
        if truth != "apart" {
            self.check(found.lower <= scene.slack, || format!("distance: {found:?}, {truth}"));
            return;
        }
        let distance = |corners: &[DVec3; 3]| distance_by_features(corners, &body.points);
        let nearest = scene.triangles.iter().map(distance).fold(f64::INFINITY, f64::min);
        let is_inside = found.lower <= nearest + scene.slack && nearest <= found.upper + scene.slack;
        self.check(is_inside, || format!("distance: {found:?}, by brute force {nearest}"));
        let width = settings.tolerance * found.upper + 1e3 * scene.slack;
        self.check(found.upper - found.lower <= width, || format!("distance: wide: {found:?}"));
    }

    fn contacts(&mut self, body: &Body, depths: &[f64], settings: &Settings) {
        let (scene, hull) = (self.scene, body.pack.hull(0).expect("one hull"));
        let mut seen: Vec<Option<Contact>> = vec![None; depths.len()];
        let mut is_twice = false;
        let visit = |found: &Contact| is_twice |= seen[found.parts[0] as usize].replace(*found).is_some();
        hullmap::contacts(&scene.mesh, &hull, body.pose, settings, &mut Cache::new(), visit);
        self.check(!is_twice, || "contacts: a triangle was visited twice".to_owned());
        for (index, (seen, depth)) in seen.iter().zip(depths).enumerate() {
            let slack = scene.slack;
            let outcome = match seen {
                Some(_) if *depth > slack => "deep",
                None if *depth < -slack => continue,
                _ => "unsure",
            };
            self.count("contact", outcome);
            match seen {
                None => self.check(*depth <= slack, || format!("contacts: triangle {index} is missing, {depth} deep")),
                Some(found) => {
                    let is_inside = found.depth_lower <= depth.max(0.0) + slack && *depth <= found.depth_upper + slack;
                    let is_near = *depth >= -1e3 * slack;
                    self.check(is_inside && is_near, || {
                        format!("contacts: triangle {index}: {found:?}, truth {depth}")
                    });
                }
            }
        }
    }

    fn ray(&mut self, rng: &mut SplitMix64) {
        let scene = self.scene;
        let (origin, target) = (scene.point(rng), scene.point(rng));
        let dir = target - origin;
        let Ok(ray) = Ray::new(origin, dir) else { return };
        let mut first = First::NEVER;
        let is_whole = [origin, target].iter().all(|p| (*p * 2.0 / scene.unit).fract() == DVec3::ZERO);
        for corners in &scene.triangles {
            if scene.kind.is_whole() && is_whole {
                let corners = corners.map(|c| self.doubled(c));
                match exact::entry(&corners, self.doubled(origin), self.doubled(dir)) {
                    (Some(t), _) => first.add(t, t),
                    // In the plane: nothing is claimed.
                    (None, true) => first.add(0.0, f64::INFINITY),
                    (None, false) => {}
                }
            } else {
                let (possible, certain) = crossing(&ray, *corners, scene.slack);
                first.add(possible, certain);
            }
        }
        let found = hullmap::ray(&scene.mesh, &ray, &CastSettings::default());
        self.judge_first("ray", first, found.hit, [found.t_lower, found.t_upper], || format!("{found:?}, {ray:?}"));
    }

    fn cast(&mut self, body: &Body, rng: &mut SplitMix64) {
        let scene = self.scene;
        let hull = body.pack.hull(0).expect("one hull");
        let away = DVec3::from_array(rng.direction()) * rng.between(1.0, 4.0) * scene.unit;
        // Through the place of the body, or past it.
        let Ok(start) = hullmap::Pose::new(body.pose.translation() + away, body.pose.rotation()) else { return };
        let velocity = -away * rng.between(0.5, 3.0) + DVec3::from_array(rng.direction()) * scene.unit * rng.unit();
        let Ok(motion) = Motion::new(velocity) else { return };
        let points: Vec<DVec3> = hull.vertices().map(|v| start.transform_point(v.as_dvec3())).collect();
        let mut first = First::NEVER;
        for corners in &scene.triangles {
            let (possible, certain) = meeting(corners, &points, velocity, scene.slack);
            first.add(possible, certain);
        }
        let cache = &mut Cache::new();
        let found = hullmap::cast(&scene.mesh, &hull, start, motion, &CastSettings::default(), cache);
        self.judge_first("cast", first, found.hit, [found.t_lower, found.t_upper], || {
            format!("{found:?}, {start:?}, {motion:?}")
        });
    }

    /// Judges the first hit of a ray or a cast.
    fn judge_first(
        &mut self,
        query: &'static str,
        first: First,
        is_hit: bool,
        [lower, upper]: [f64; 2],
        what: impl Fn() -> String,
    ) {
        let First { possible, certain } = first;
        let outcome = match (possible < f64::INFINITY, certain < f64::INFINITY) {
            (false, _) => "miss",
            (true, true) => "hit",
            (true, false) => "unsure",
        };
        self.count(query, outcome);
        let slack = 1e-9 * (1.0 + certain.min(1e9));
        let describe = |wrong: &str| format!("{query}: {wrong}: {}, from {possible} to {certain}", what());
        self.check(is_hit || outcome != "hit", || describe("a hit is missing"));
        self.check(!is_hit || outcome != "miss", || describe("nothing is there"));
        if is_hit {
            self.check(lower <= certain + slack, || describe("too late"));
            self.check(possible - 1e-9 * (1.0 + possible.min(1e9)) <= upper, || describe("too early"));
        }
    }

    fn point(&mut self, rng: &mut SplitMix64) {
        let scene = self.scene;
        let point = scene.point(rng);
        let nearest = scene.triangles.iter().map(|c| distance_from_triangle(*c, point)).fold(f64::INFINITY, f64::min);
        let (settings, cache) = (Settings::default(), &mut Cache::new());
        let Ok(found) = surface_distance(&scene.mesh, point, &settings, cache) else {
            // Not closed: the distance from the triangles.
            let Ok(found) = hullmap::signed_distance(&scene.mesh, point, &settings, cache) else { return };
            self.count("signed distance", "open");
            let is_inside = found.lower <= nearest + scene.slack && nearest <= found.upper + scene.slack;
            self.check(is_inside, || format!("distance of {point}: {found:?}, by brute force {nearest}"));
            return;
        };
        let turns = winding(&scene.triangles, point);
        let (is_inside, is_on) = (turns.round() >= 1.0, nearest <= scene.slack);
        let outcome = if is_on {
            "on"
        } else if is_inside {
            "inside"
        } else {
            "outside"
        };
        self.count("signed distance", outcome);
        let truth = if is_inside && !is_on { -nearest } else { nearest };
        let is_right = found.lower <= truth + scene.slack && truth <= found.upper + scene.slack;
        self.check(is_right, || format!("signed distance of {point}: {found:?}, truth {truth}, {turns} turns"));
        self.check(is_on || (found.distance < 0.0) == is_inside, || {
            format!("signed distance of {point}: wrong sign: {found:?}, truth {truth}, {turns} turns")
        });
    }
}

/// The earliest t at which a ray may cross a triangle, and the t at which it certainly does.
fn crossing(ray: &Ray, [a, b, c]: [DVec3; 3], slack: f64) -> (f64, f64) {
    const NEVER: (f64, f64) = (f64::INFINITY, f64::INFINITY);
    let (normal, dir) = ((b - a).cross(c - a).normalize(), ray.direction());
    let (slope, height) = (normal.dot(dir), normal.dot(a - ray.origin()));
    // Rounding error, which is larger for the normal of a needle.
    let longest = (b - a).length().max(c.distance(a));
    let sine = (b - a).cross(c - a).length() / (longest * longest);
    let error = slack / sine.min(1.0);
    if slope.abs() <= 1e-6 * dir.length() {
        // Nearly in the plane: nothing is claimed.
        return (0.0, f64::INFINITY);
    }
    let t = height / slope;
    let off = (error + 1e-12 * dir.length() * t.abs()) / slope.abs();
    let point = ray.origin() + t * dir;
    let margin = 1e3 * error + off * dir.length();
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).normalize().cross(point - p).dot(normal));
    if sides.iter().any(|side| *side < -margin) || t < -off {
        NEVER
    } else if sides.iter().all(|side| *side > margin) && t > off {
        (t - off, t + off)
    } else {
        ((t - off).max(0.0), f64::INFINITY)
    }
}

/// The earliest time at which a body that moves may meet a triangle, and the time at which it
/// certainly does: when it is in the slabs of all axes.
fn meeting(triangle: &[DVec3; 3], body: &[DVec3], velocity: DVec3, slack: f64) -> (f64, f64) {
    let [a, b, c] = *triangle;
    let sides = [b - a, c - b, a - c];
    let (mut enter, mut leave) = ([0.0_f64; 2], [f64::INFINITY; 2]);
    let mut clip = |axis: DVec3, scale: f64| {
        // Parallel edges span nothing.
        if axis.length() <= 1e-9 * scale {
            return;
        }
        let axis = axis.normalize();
        let range = |points: &[DVec3]| {
            let heights = || points.iter().map(|p| axis.dot(*p - a));
            [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
        };
        let ([low, high], [least, most]) = (range(triangle), range(body));
        let speed = axis.dot(velocity);
        // With the slack added, and taken away.
        for (i, slack) in [slack, -slack].into_iter().enumerate() {
            let (until, from) = (high + slack - least, low - slack - most);
            if speed.abs() <= 1e-12 * velocity.length() {
                if until < 0.0 || from > 0.0 {
                    enter[i] = f64::INFINITY;
                }
                continue;
            }
            let [p, q] = [from / speed, until / speed];
            enter[i] = enter[i].max(p.min(q));
            leave[i] = leave[i].min(p.max(q));
        }
    };
    clip(sides[0].cross(sides[1]), sides[0].length() * sides[1].length());
    for (i, p) in body.iter().enumerate() {
        for (j, q) in body.iter().enumerate().take(i) {
            for side in sides {
                clip(side.cross(*p - *q), side.length() * p.distance(*q));
            }
            for r in body.iter().take(j) {
                clip((*p - *q).cross(*p - *r), p.distance(*q) * p.distance(*r));
            }
        }
    }
    let time = |i: usize| if enter[i] <= leave[i] { enter[i] } else { f64::INFINITY };
    (time(0), time(1))
}
