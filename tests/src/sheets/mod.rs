//! Judges queries of triangle meshes by brute force over all triangles.
//!
//! | module | contents |
//! |---|---|
//! | [`scene`] | meshes of all kinds, and bodies beside them |
//! | `hits` | the first hit of a ray, and the faults of an answer |
//! | [`joints`] | rays at edges, vertices and seams of meshes, fields and parts |
//! | [`manifolds`] | manifolds of bodies of all kinds: every point is on both surfaces |
//! | `missing` | points that manifolds must have |
//!
//! Truths of rays are exact. Truths in f64 have a slack for their own rounding error. Where a truth
//! is within it, and the coordinates are whole, f64 decides exactly; other such cases are counted
//! as unsure.

mod hits;
pub mod joints;
pub mod manifolds;
mod missing;
pub mod scene;
mod tally;

use std::cmp::Ordering;

use glam::DVec3;
use hullmap::compound::surface_distance;
use hullmap::{Cache, CastSettings, Contact, Motion, Overlap, Ray, Settings};
use hullmap_testkit::depth::{gap_of_whole, signed_depth_by_points};
use hullmap_testkit::entry::passage_by_points;
use hullmap_testkit::gap::distance_by_features;
use hullmap_testkit::random::RandomPoses;
use hullmap_testkit::ray::Line;
use hullmap_testkit::triangles::{distance_from_triangle, winding};
use shapes::rng::SplitMix64;

use hits::{Hits, Part, Query};
use scene::{Body, Kind, Scene};
pub use tally::Tally;

/// Number of queries of each kind in a scene.
const QUERIES: u64 = 40;

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
            // Two of the kinds are closed.
            let points = if matches!(kind, Kind::Closed | Kind::Round) { 12 } else { 1 };
            (0..points).for_each(|_| judge.point(&mut rng));
        }
    }
}

struct Judge<'s> {
    tally: &'s mut Tally,
    scene: &'s Scene,
    name: String,
}

impl Judge<'_> {
    fn check(&mut self, is_right: bool, what: impl FnOnce() -> String) {
        if !is_right {
            self.tally.wrong.push(format!("{}: {}", self.name, what()));
        }
    }

    /// Distance, overlap and contacts of a body.
    fn pair(&mut self, body: &Body) {
        let (scene, settings) = (self.scene, Settings::default());
        let hull = body.pack.hull(0).expect("one hull");
        let slack = scene.slack;
        let depths: Vec<f64> = scene.triangles.iter().map(|corners| self.depth(corners, body)).collect();
        let deepest = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let exact = body.is_exact.then(|| {
            let solid: Vec<DVec3> = body.points.iter().map(|p| *p / scene.unit).collect();
            scene.triangles.iter().map(|corners| gap_of_whole(&corners.map(|c| c / scene.unit), &solid)).min()
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
        self.tally.note("intersects", truth);
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
        self.tally.note("distance", truth);
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
            self.tally.note("contact", outcome);
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
        let deepest = hullmap::contact(&scene.mesh, &hull, body.pose, settings, &mut Cache::new());
        let expected = seen.iter().flatten().map(|found| found.depth).reduce(f64::max);
        let is_deepest = expected.map_or(!deepest.hit, |depth| (deepest.depth - depth).abs() <= 1e-9 * scene.unit);
        self.check(is_deepest, || format!("contact: {deepest:?}, the deepest triangle is {expected:?} deep"));
    }

    fn ray(&mut self, rng: &mut SplitMix64) {
        let scene = self.scene;
        let (origin, target) = (scene.point(rng), scene.point(rng));
        let dir = target - origin;
        let Ok(ray) = Ray::new(origin, dir) else { return };
        let line = Line::new(origin, dir, f64::INFINITY);
        let parts: Vec<Part> = scene.triangles.iter().map(Part::triangle).collect();
        let hits = Hits::new(&line, &parts, false);
        let found = hullmap::ray(&scene.mesh, &ray, &CastSettings::default());
        self.tally.note("ray", if hits.outcome() == "miss" { "miss" } else { "hit" });
        let fault = hits.fault(&found, found.point, Query::Ray);
        self.check(fault.is_none(), || format!("ray: {fault:?}: {found:?}, {ray:?}, {hits:?}"));
    }

    fn cast(&mut self, body: &Body, rng: &mut SplitMix64) {
        let scene = self.scene;
        let hull = body.pack.hull(0).expect("one hull");
        let away = rng.unit_vector() * rng.between(1.0, 4.0) * scene.unit;
        // Through the place of the body, or past it.
        let Ok(start) = hullmap::Pose::new(body.pose.translation() + away, body.pose.rotation()) else { return };
        let velocity = -away * rng.between(0.5, 3.0) + rng.unit_vector() * scene.unit * rng.unit();
        let Ok(motion) = Motion::new(velocity) else { return };
        let points: Vec<DVec3> = hull.vertices().map(|v| start.transform_point(v.as_dvec3())).collect();
        // The earliest time at which it may meet a triangle, and the time at which it certainly
        // does.
        let (mut possible, mut certain) = (f64::INFINITY, f64::INFINITY);
        for corners in &scene.triangles {
            let passage = passage_by_points(corners, &points, velocity, scene.slack);
            let [earliest, latest] = passage.enter.map(|t| t.max(0.0));
            if !passage.certainly_misses(f64::INFINITY) {
                possible = possible.min(earliest);
            }
            if passage.certainly_hits(f64::INFINITY) {
                certain = certain.min(latest);
            }
        }
        let outcome = match (possible < f64::INFINITY, certain < f64::INFINITY) {
            (false, _) => "miss",
            (true, true) => "hit",
            (true, false) => "unsure",
        };
        self.tally.note("cast", outcome);
        let found = hullmap::cast(&scene.mesh, &hull, start, motion, &CastSettings::default(), &mut Cache::new());
        let slack = |t: f64| 1e-9 * (1.0 + t.min(1e9));
        let what =
            |wrong: &str| format!("cast: {wrong}: {found:?}, {start:?}, {motion:?}, from {possible} to {certain}");
        self.check(found.hit || outcome != "hit", || what("a hit is missing"));
        self.check(!found.hit || outcome != "miss", || what("nothing is there"));
        if found.hit {
            self.check(found.t_lower <= certain + slack(certain), || what("too late"));
            self.check(possible - slack(possible) <= found.t_upper, || what("too early"));
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
            self.tally.note("signed distance", "open");
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
        self.tally.note("signed distance", outcome);
        let truth = if is_inside && !is_on { -nearest } else { nearest };
        let on = scene.triangles.get(found.part as usize).map_or(f64::NAN, |c| distance_from_triangle(*c, found.point));
        let toward = (point - found.point).normalize_or_zero() * if is_inside { -1.0 } else { 1.0 };
        let is_along = nearest < 1e-6 * scene.unit || found.normal.distance(toward) < 1e-5;
        let is_right = found.lower <= truth + scene.slack && truth <= found.upper + scene.slack;
        self.check(is_right && on < 1e-9 * scene.unit && is_along, || {
            format!("signed distance of {point}: {found:?}, truth {truth}, {turns} turns")
        });
        self.check(is_on || (found.distance < 0.0) == is_inside, || {
            format!("signed distance of {point}: wrong sign: {found:?}, truth {truth}, {turns} turns")
        });
    }
}
