//! The first hit of a ray on triangles or hulls, in rational numbers, and the faults of an answer.
//!
//! | claim | truth |
//! |---|---|
//! | hit, and the interval of t | where the ray first meets a part, in rational numbers |
//! | t | the same, within [`Query::allowance`] |
//! | the part | the ray meets it there, within the same allowance |
//! | the point | on the ray at t, to rounding |
//! | the normal | a support plane of the part at the point, against the ray; for exact rays, the normal of a face there |

use std::cmp::Ordering::{Equal, Greater, Less};
use std::fmt;

use glam::DVec3;
use hullmap::{RayHit, Status};
use hullmap_testkit::ray::{Fraction, Line, facets};
use hullmap_testkit::triangles::distance_from_triangle;

/// Width of an interval of t, relative to the radius of a part: the default of
/// [`CastSettings`](hullmap::CastSettings).
const TOLERANCE: f64 = 1e-6;

/// Width of an interval of t, relative to t, that is as narrow as rounding allows: above it, the
/// library decides rays at triangles exactly.
const NARROW: f64 = 1e-9;

/// Rounding error of a point relative to its coordinates.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A triangle, or a hull with three points of each of its facets.
pub(super) struct Part {
    vertices: Vec<DVec3>,
    facets: Vec<[DVec3; 3]>,
    radius: f64,
    greatest: f64,
}

impl Part {
    fn new(vertices: Vec<DVec3>, facets: Vec<[DVec3; 3]>) -> Self {
        let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let radius = vertices.iter().map(|v| v.distance(middle)).fold(0.0, f64::max);
        let greatest = vertices.iter().map(|v| v.length()).fold(0.0, f64::max);
        Self { vertices, facets, radius, greatest }
    }

    pub(super) fn triangle(corners: &[DVec3; 3]) -> Self {
        Self::new(corners.to_vec(), vec![*corners])
    }

    pub(super) fn hull(vertices: Vec<DVec3>) -> Self {
        let facets = facets(&vertices);
        Self::new(vertices, facets)
    }

    /// Its corners, if it is a triangle.
    fn corners(&self) -> Option<[DVec3; 3]> {
        self.vertices.as_slice().try_into().ok()
    }

    pub(super) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    fn meet(&self, line: &Line) -> Option<Fraction> {
        self.corners().map_or_else(|| line.meet_hull(&self.facets), |corners| line.meet(corners))
    }

    /// Distance of a point from the triangle, or from the surface of the hull, at least.
    fn distance(&self, point: DVec3) -> f64 {
        if let Some(corners) = self.corners() {
            return distance_from_triangle(corners, point);
        }
        let height = |[a, b, c]: &[DVec3; 3]| (c - a).cross(b - a).normalize().dot(point - a);
        self.facets.iter().map(height).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether all points of the part are behind the plane of a face through `point`, or in it.
    fn is_behind(&self, point: DVec3, normal: DVec3, allowance: f64) -> bool {
        self.vertices.iter().all(|vertex| normal.dot(*vertex - point) <= allowance)
    }

    /// Whether a face through `point` has this normal. If the ray is in the plane of a triangle,
    /// any support plane counts.
    fn is_face(&self, line: &Line, point: DVec3, normal: DVec3, allowance: f64) -> bool {
        let is_in = |facet: &[DVec3; 3]| facet.iter().all(|corner| normal.dot(*corner - point).abs() <= allowance);
        let is_edge_on = self.corners().is_some_and(|corners| line.facing(corners) == Equal);
        is_edge_on || self.facets.iter().any(is_in)
    }
}

/// A kind of query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Query {
    /// A ray.
    Ray,
    /// The cast of a point.
    Cast,
}

impl Query {
    /// Maximum error of t, as a length.
    fn allowance(self, part: &Part, line: &Line, t: f64) -> f64 {
        let path = t * line.speed();
        let rounding = NARROW * path + ROUNDING * (line.origin().length() + part.greatest);
        let is_exact = self == Self::Ray && part.corners().is_some();
        if is_exact { rounding } else { TOLERANCE * part.radius + rounding }
    }
}

/// The parts that a ray meets.
pub(super) struct Hits<'s> {
    line: &'s Line,
    parts: &'s [Part],
    /// Index of a part, and where the ray enters it.
    all: Vec<(usize, Fraction)>,
    first: Option<Fraction>,
}

impl fmt::Debug for Hits<'_> {
    /// Each part with its t, and its vertices.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("truth")?;
        self.all.iter().try_for_each(|(i, t)| write!(f, " {i} at {:e} {:?}", t.rounded(), self.parts[*i].vertices))
    }
}

impl<'s> Hits<'s> {
    /// The hits on `parts`, or on the fronts of triangles.
    pub(super) fn new(line: &'s Line, parts: &'s [Part], is_one_sided: bool) -> Self {
        let is_front = |part: &Part| part.corners().is_some_and(|corners| line.facing(corners) == Less);
        let fronts = parts.iter().enumerate().filter(|(_, part)| !is_one_sided || is_front(part));
        let all: Vec<_> = fronts.filter_map(|(index, part)| Some((index, part.meet(line)?))).collect();
        let first = all.iter().map(|(_, t)| t.clone()).reduce(Fraction::min);
        Self { line, parts, all, first }
    }

    /// Whether the ray meets a part, or several at the same place.
    pub(super) fn outcome(&self) -> &'static str {
        match self.all.iter().filter(|(_, t)| self.first.as_ref().is_some_and(|first| t.is(first))).count() {
            0 => "miss",
            1 => "one",
            _ => "several",
        }
    }

    /// Whether rounding decides nowhere whether the ray moves towards a front, and starts before
    /// it: casts compute that in f64.
    pub(super) fn has_clear_fronts(&self) -> bool {
        let is_clear = |part: &Part| {
            let Some([a, b, c]) = part.corners() else { return false };
            let (normal, origin) = ((b - a).cross(c - a), self.line.origin());
            let error = ROUNDING * (b - a).length() * (c - a).length();
            let length = origin.length() + part.greatest;
            normal.dot(self.line.way()).abs() > error && normal.dot(origin - a).abs() > error * length
        };
        self.parts.iter().all(|part| part.meet(self.line).is_none() || is_clear(part))
    }

    /// The fault of an answer, if it has one.
    ///
    /// `of_ray` is the point that moves along the ray, when it meets `found.point`.
    pub(super) fn fault(&self, found: &RayHit, of_ray: DVec3, query: Query) -> Option<&'static str> {
        let Some(first) = &self.first else { return found.hit.then_some("nothing is there") };
        match () {
            () if !found.hit => return Some("a hit is missing"),
            () if first.compare(found.t_lower) == Less => return Some("too late"),
            () if first.compare(found.t_upper) == Greater => return Some("too early"),
            () if found.status == Status::Touching => return Some("not certain"),
            () if !(found.t_lower <= found.t && found.t <= found.t_upper) => return Some("t is outside"),
            () => {}
        }
        let Some(part) = self.parts.get(found.part as usize) else { return Some("no such part") };
        let allowance = query.allowance(part, self.line, found.t);
        let is_near = |t: &Fraction| t.is_within(found.t, allowance / self.line.speed());
        let is_met = |index: usize| self.all.iter().find(|(other, _)| *other == index).map(|(_, t)| t);
        let width = (found.t_upper - found.t_lower) * self.line.speed();
        // At slivers, the intervals of casts may be wide, as the status says: rounding error allows
        // no narrower one, or the search has stalled. Rays are decided exactly.
        let may_be_wide = query == Query::Cast && matches!(found.status, Status::Stalled | Status::Exact);
        let has_stalled = query == Query::Ray && found.status == Status::Stalled;
        let is_narrow = may_be_wide || !has_stalled && width <= 2.0 * allowance;
        let (point, normal) = (found.point, found.normal);
        let rounding = ROUNDING * (self.line.origin().length() + found.t * self.line.speed() + part.greatest);
        let is_against = normal.dot(self.line.way()) <= NARROW;
        let is_at_start = first.compare(0.0) == Equal && normal.distance(-self.line.way()) <= NARROW;
        let is_face = query == Query::Cast || part.is_face(self.line, point, normal, allowance + rounding);
        match () {
            () if !is_narrow => Some("the interval is wide"),
            () if !is_near(first) => Some("t is of another surface"),
            () if !is_met(found.part as usize).is_some_and(is_near) => Some("the part is not met first"),
            () if !(of_ray.distance(self.line.at(found.t)) <= rounding) => Some("the point is off the ray"),
            () if !(point.distance(of_ray) <= allowance + rounding) => Some("the points are apart"),
            () if !(part.distance(point) <= rounding) => Some("the point is off the part"),
            () if !((normal.length() - 1.0).abs() <= 1e-14) => Some("the normal is not of unit length"),
            () if !is_against => Some("the normal is along the ray"),
            () if is_at_start => None,
            () if !part.is_behind(point, normal, allowance + rounding) => Some("the normal is not of a support plane"),
            () if !is_face => Some("the normal is not of a face"),
            () => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The answer about the surface behind is a fault, even in an interval that holds the truth.
    #[test]
    fn answers_about_the_surface_behind_are_faults() {
        let floor =
            |z: f64| Part::triangle(&[DVec3::new(-1.0, -1.0, z), DVec3::new(2.0, -1.0, z), DVec3::new(-1.0, 2.0, z)]);
        let parts = [floor(0.0), floor(0.0), floor(-4.0)];
        let line = Line::new(DVec3::Z, DVec3::NEG_Z, f64::INFINITY);
        let hits = Hits::new(&line, &parts, false);
        assert_eq!((hits.outcome(), Hits::new(&line, &parts[2..], true).outcome()), ("several", "one"));
        let first =
            RayHit { status: Status::Exact, t: 1.0, t_lower: 1.0, t_upper: 1.0, normal: DVec3::Z, ..RayHit::default() };
        let behind =
            RayHit { status: Status::Stalled, t: 5.0, t_upper: 5.0, point: DVec3::NEG_Z * 4.0, part: 2, ..first };
        let wrong = [
            ("t is of another surface", behind),
            ("the interval is wide", RayHit { status: Status::Within, t_upper: 5.0, ..first }),
            ("the part is not met first", RayHit { part: 2, ..first }),
            ("the point is off the ray", RayHit { point: DVec3::X * 1e-6, ..first }),
            ("the point is off the ray", RayHit { point: behind.point, ..first }),
            ("the normal is not of unit length", RayHit { normal: DVec3::Z * 1.01, ..first }),
            ("the normal is along the ray", RayHit { normal: DVec3::NEG_Z, ..first }),
            ("the normal is not of a support plane", RayHit { normal: DVec3::new(0.6, 0.0, 0.8), ..first }),
            ("not certain", RayHit { status: Status::Touching, ..first }),
            ("a hit is missing", RayHit { hit: false, ..first }),
        ];
        for query in [Query::Ray, Query::Cast] {
            for part in [0, 1] {
                assert_eq!(hits.fault(&RayHit { part, ..first }, first.point, query), None);
            }
            for (name, answer) in wrong {
                let expected =
                    if query == Query::Ray && name.starts_with("t is") { "the interval is wide" } else { name };
                assert_eq!(hits.fault(&answer, answer.point, query), Some(expected), "{query:?} {answer:?}");
            }
        }
    }
}
