//! Trial hulls: convex bodies of few points in f64, with the planes of their faces.
//!
//! A flat set has no volume. Its body is thickened by a length far below any limit, so that every
//! body has planes on all sides.

use glam::DVec3;

use super::extremes::Extremes;
use crate::hull::{
    polygon, quickhull,
    rank::{Simplex, spanning_simplex},
};
use hullmap_geometry::{
    bounds,
    planes::{self, HalfSpace},
};

/// Thickness of flat trial bodies, relative to the diagonal.
pub const THICKNESS: f64 = 2e-7;

/// A convex body.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Its extreme points.
    pub points: Vec<DVec3>,
    /// The planes of its faces.
    pub planes: Vec<HalfSpace>,
    /// The areas of its faces.
    pub areas: Vec<f64>,
    /// Its surface, as triangles.
    pub triangles: Vec<[DVec3; 3]>,
    /// Minimum of the points.
    pub low: DVec3,
    /// Maximum of the points.
    pub high: DVec3,
}

impl Body {
    /// The hull of finite points. A flat one is thickened by `thickness`. Without points, the body
    /// is empty.
    pub fn new(points: &[DVec3], thickness: f64) -> Self {
        if points.len() < MANY {
            return Self::of_outer_points(points.iter().copied(), thickness);
        }
        let inner = Inner::new(&Extremes::from_points(points));
        let outer = points.iter().filter(|p| !inner.holds(**p)).copied();
        Self::of_outer_points(outer, thickness)
    }

    /// The hull of points, without some of those inside.
    pub fn of_outer_points(points: impl Iterator<Item = DVec3>, thickness: f64) -> Self {
        Self::of_distinct(distinct(points), thickness)
    }

    fn of_distinct(points: Vec<DVec3>, thickness: f64) -> Self {
        let [low, high] = bounds(points.iter().copied());
        let (extreme, around) = match points.as_slice() {
            [] => return Self { low, high, ..Self::default() },
            _ => match spanning_simplex(&points) {
                Simplex::Tetrahedron(simplex) => {
                    let mut body = Self { low, high, ..Self::default() };
                    body.add_faces(&points, simplex);
                    return body;
                }
                Simplex::Triangle(corners) => {
                    let [a, b, c] = corners.map(|i| points[i]);
                    let outline = polygon::hull_along_own_axis(&points, (b - a).cross(c - a));
                    (outline.iter().map(|i| points[*i as usize]).collect(), points)
                }
                _ => (vec![points[0], points[points.len() - 1]], points),
            },
        };
        let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * thickness);
        let thick: Vec<DVec3> = around.iter().flat_map(|p| steps.iter().flat_map(|s| [*p + *s, *p - *s])).collect();
        let thick = distinct(thick.into_iter());
        let mut body =
            Self { low: low - DVec3::splat(thickness), high: high + DVec3::splat(thickness), ..Self::default() };
        if let Simplex::Tetrahedron(simplex) = spanning_simplex(&thick) {
            body.add_faces(&thick, simplex);
        }
        body.points = extreme;
        body
    }

    fn add_faces(&mut self, points: &[DVec3], simplex: [usize; 4]) {
        let facets = quickhull::hull(points, simplex);
        let mut used = vec![false; points.len()];
        for facet in &facets {
            let corners: Vec<DVec3> = facet.iter().map(|i| points[*i as usize]).collect();
            self.triangles.extend(planes::fan(&corners));
            if let Some((plane, area)) = planes::of_face(&corners, points) {
                self.planes.push(plane);
                self.areas.push(area);
            }
            for v in facet {
                used[*v as usize] = true;
            }
        }
        self.points = points.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();
    }

    /// Whether a point lies in the body, or at most `slack` outside of its planes.
    pub fn holds(&self, p: DVec3, slack: f64) -> bool {
        let step = DVec3::splat(slack);
        p.cmpge(self.low - step).all()
            && p.cmple(self.high + step).all()
            && !self.planes.is_empty()
            && self.planes.iter().all(|plane| plane.height(p) <= slack)
    }

    /// Volume, by the tetrahedra from the first point.
    pub fn volume(&self) -> f64 {
        let Some(&o) = self.points.first() else { return 0.0 };
        self.triangles.iter().map(|[a, b, c]| (*a - o).cross(*b - o).dot(*c - o)).sum::<f64>() / 6.0
    }

    /// Distance from `p` along the unit vector `direction` to where it leaves the body; 0 if `p` is
    /// outside.
    pub fn exit(&self, p: DVec3, direction: DVec3) -> f64 {
        let mut exit = f64::INFINITY;
        for plane in &self.planes {
            let speed = plane.normal.dot(direction);
            if speed > 1e-12 {
                exit = exit.min(-plane.height(p) / speed);
            }
        }
        if exit.is_finite() { exit.max(0.0) } else { 0.0 }
    }

    /// The height of a point above the body's planes, and the largest face that it is nearly as
    /// high above; `None` without planes.
    pub fn face_below(&self, p: DVec3) -> Option<(f64, usize)> {
        let heights: Vec<f64> = self.planes.iter().map(|plane| plane.height(p)).collect();
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let high = (0..heights.len()).filter(|face| heights[*face] >= 0.7 * highest);
        let best = high.max_by(|a, b| self.areas[*a].total_cmp(&self.areas[*b]).then(b.cmp(a)));
        best.map(|face| (highest, face))
    }

    /// Length of the box's diagonal.
    pub fn diagonal(&self) -> f64 {
        if self.points.is_empty() { 0.0 } else { self.high.distance(self.low) }
    }
}

/// The point that is farthest along a vector; the origin if there are no points.
pub fn farthest(points: &[DVec3], direction: DVec3) -> DVec3 {
    let (mut reach, mut found) = (f64::NEG_INFINITY, DVec3::ZERO);
    for p in points {
        let along = p.dot(direction);
        if along > reach {
            (reach, found) = (along, *p);
        }
    }
    found
}

/// Number of points from which points deep inside the hull are dropped before it is built.
pub const MANY: usize = 256;

/// Points whose hull lies in the hull of all and is nearly as large, for comparisons of trials.
pub fn rough(points: &[DVec3]) -> Vec<DVec3> {
    if points.len() < ROUGH { points.to_vec() } else { Extremes::from_points(points).points() }
}

/// Number of points from which a trial uses some of them.
pub const ROUGH: usize = 128;

/// A body inside the hull of points. Those deep inside of it are no corners of the hull.
pub struct Inner {
    body: Body,
    slack: f64,
}

impl Inner {
    /// The hull of the farthest points along a few directions.
    pub fn new(extremes: &Extremes) -> Self {
        let body = Body::of_outer_points(extremes.few_points().into_iter(), 0.0);
        // Far from the origin, heights above planes are off by the rounding error of the
        // coordinates.
        let greatest = body.low.abs().max(body.high.abs()).max_element();
        let slack = INNER * body.diagonal() + INNER_ROUNDING * greatest;
        Self { body, slack }
    }

    /// Whether a point is deep inside.
    pub fn holds(&self, p: DVec3) -> bool {
        self.body.holds(p, -self.slack)
    }

    /// Whether all points of a box are certainly deep inside.
    pub fn holds_box(&self, low: DVec3, high: DVec3) -> bool {
        let middle = 0.5 * (low + high);
        let half = high - middle;
        // The slack is more than the rounding errors of two heights.
        let is_below = |plane: &HalfSpace| plane.height(middle) + plane.normal.abs().dot(half) <= -2.0 * self.slack;
        self.holds(low) && self.holds(high) && self.body.planes.iter().all(is_below)
    }
}

/// Depth from which a point counts as deep inside, relative to the diagonal.
const INNER: f64 = 1e-9;

/// Depth relative to the greatest coordinate, for rounding errors.
const INNER_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The points in ascending order, each once. Negative zeros become positive.
fn distinct(points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let mut all: Vec<DVec3> = points.filter(|p| p.is_finite()).map(|p| p + DVec3::ZERO).collect();
    all.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn extreme_points_are_outer_ones() {
        let mut rng = SplitMix64::new(3);
        let mut dropped = 0;
        for round in 0..60 {
            let offset = DVec3::splat([0.0, 1.0, 1e4, 1e8][round % 4]);
            let flat = if round % 3 == 2 { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
            let mut point = || {
                let p = DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
                offset + flat * if round % 3 == 1 { p.normalize_or_zero() * p.length().min(1.0).sqrt() } else { p }
            };
            let points: Vec<DVec3> = (0..600).map(|_| point()).collect();
            let inner = Inner::new(&Extremes::from_points(&points));
            let outer: Vec<DVec3> = points.iter().filter(|p| !inner.holds(**p)).copied().collect();
            let mut body = Body { low: offset - 1.0, high: offset + 1.0, ..Body::default() };
            let all = distinct(points.iter().copied());
            if let Simplex::Tetrahedron(simplex) = spanning_simplex(&all) {
                body.add_faces(&all, simplex);
                assert!(body.points.iter().all(|p| outer.contains(p)), "round {round}: an extreme point is missing");
                dropped += points.len() - outer.len();
            } else {
                assert_eq!(outer, points, "round {round}");
            }
        }
        assert!(dropped > 5_000, "{dropped}");
    }

    /// Regression: arbitrary normals of facets with nearly collinear corners cut through the body,
    /// and each triangle outside became a thin part.
    #[test]
    fn bodies_hold_their_points() {
        let mut rng = SplitMix64::new(5);
        let mut slivers = 0;
        for round in 0..300 {
            let mut corner = || DVec3::from_array(std::array::from_fn(|_| f64::from(rng.between(-1.0, 1.0) as f32)));
            let corners: Vec<DVec3> = (0..8).map(|_| corner()).collect();
            // Points on the edges, as cuts of polygons are.
            let mut points = corners.clone();
            for (i, p) in corners.iter().enumerate() {
                points.extend(corners[..i].iter().map(|q| p.lerp(*q, rng.between(0.0, 1.0))));
            }
            let body = Body::new(&points, 1e-7);
            let is_sliver = |[a, b, c]: &&[DVec3; 3]| {
                let (u, v) = (*b - *a, *c - *a);
                u.cross(v).length() < 1e-6 * u.length() * v.length()
            };
            slivers += body.triangles.iter().filter(is_sliver).count();
            assert!(points.iter().all(|p| body.holds(*p, 1e-9)), "round {round}");
        }
        assert!(slivers > 100, "{slivers}");
    }
}
