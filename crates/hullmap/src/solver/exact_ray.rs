//! Exact decisions about a ray and points: on which side of its line they are, and where it meets
//! their convex hull.
//!
//! # Steps
//! 1. Compute a volume in f64, with a bound of its rounding error.
//! 2. If the bound allows either sign, add up the exact products of the coordinates.
//!
//! So no two triangles contradict each other about their common edge: a line that passes the edge
//! is on it for both of them, or on the same side of it.
//!
//! # Reference
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013, for the rule. Shewchuk, 1997,
//! for filters before exact arithmetic. The errors of sums and products: Higham, "Accuracy and
//! Stability of Numerical Algorithms", 2002, section 3.1.

use glam::DVec3;

use super::long_accumulator::{Sum, Way};
use super::motion::{CastSettings, Ray};

/// Bound of the rounding error of a volume of three vectors, each with an error of half a unit per
/// component, relative to the product of their lengths: 11 units of [`f64::EPSILON`] to first
/// order, and twice as much for the lengths.
const VOLUME_ERROR: f64 = 32.0 * f64::EPSILON;

/// Volumes below this are not used: products may underflow.
pub(super) const TINY_VOLUME: f64 = 1e-250;

/// A vector, and its length.
#[derive(Clone, Copy)]
pub(super) struct Measured(pub(super) DVec3, pub(super) f64);

impl Measured {
    #[inline]
    pub(super) fn new(vector: DVec3) -> Self {
        Self(vector, vector.length())
    }
}

/// The volume that three vectors span, and a bound of its rounding error.
#[inline]
pub(super) fn volume(a: Measured, b: Measured, c: Measured) -> (f64, f64) {
    let error = VOLUME_ERROR * a.1 * b.1 * c.1;
    // The square of a length has underflowed: nothing is known.
    (a.0.dot(b.0.cross(c.0)), if error > 0.0 { error } else { f64::INFINITY })
}

/// The volume that three vectors span, with its rounding error. The sign is exact.
fn signed_volume(ways: [Way; 3]) -> f64 {
    let [a, b, c] = ways.map(|[from, to]| Measured::new(to - from));
    let (volume, error) = volume(a, b, c);
    // NaN takes the exact branch.
    if volume.abs() > error.max(TINY_VOLUME) {
        return volume;
    }
    let [a, b, c] = ways;
    f64::from(Sum::volume(a, b, c).sign()) * TINY_VOLUME
}

/// −1, 0 or 1.
fn sign(number: f64) -> i32 {
    i32::from(number > 0.0) - i32::from(number < 0.0)
}

/// A ray, up to its end.
pub(super) struct ExactRay {
    origin: DVec3,
    /// Not zero.
    direction: DVec3,
    /// The t of its end, which is on the ray.
    limit: f64,
}

impl ExactRay {
    pub(super) fn new(ray: &Ray, settings: &CastSettings) -> Self {
        let (origin, direction) = (ray.origin(), ray.direction());
        if direction == DVec3::ZERO {
            // A point: the start of any ray.
            return Self { origin, direction: DVec3::X, limit: 0.0 };
        }
        Self { origin, direction, limit: settings.limit() }
    }

    /// The unit vector against the ray.
    pub(super) fn against(&self) -> DVec3 {
        // Squares of a tiny direction would underflow.
        -(self.direction / self.direction.abs().max_element()).normalize()
    }

    fn to(&self, point: DVec3) -> Way {
        [self.origin, point]
    }

    fn along(&self) -> Way {
        [DVec3::ZERO, self.direction]
    }

    /// How two points turn around the line, seen against the ray: 1 counter-clockwise, −1
    /// clockwise, 0 if they are in one plane with it.
    pub(super) fn turn(&self, p: DVec3, q: DVec3) -> i32 {
        sign(signed_volume([self.along(), self.to(p), self.to(q)]))
    }

    /// Whether the ray moves to the front of a triangle (−1), from which its corners turn
    /// counter-clockwise, to its back (1), or in its plane (0).
    pub(super) fn facing(&self, [a, b, c]: [DVec3; 3]) -> i32 {
        sign(signed_volume([self.along(), [a, b], [a, c]]))
    }

    /// On which side of the line a point is, along an axis: the sign of a coordinate of a cross
    /// product. The line is in a plane with all points that are compared.
    fn side(&self, point: DVec3, axis: usize) -> i32 {
        Sum::cross(self.along(), self.to(point), axis).sign()
    }

    /// Whether a point is on the line.
    pub(super) fn is_on(&self, point: DVec3) -> bool {
        (0..3).all(|axis| self.side(point, axis) == 0)
    }

    /// Whether two points, in one plane with the line, are on opposite sides of it.
    pub(super) fn is_between(&self, p: DVec3, q: DVec3) -> bool {
        (0..3).any(|axis| self.side(p, axis) * self.side(q, axis) < 0)
    }

    /// Whether the line meets a closed triangle, and is not in a plane with it.
    pub(super) fn pierces(&self, [a, b, c]: [DVec3; 3]) -> bool {
        let turns = [self.turn(b, c), self.turn(c, a), self.turn(a, b)];
        turns != [0; 3] && !(turns.contains(&1) && turns.contains(&-1))
    }

    /// The outward unit normal of a triangle on the front, whose coordinates are rounded only at
    /// the end: the normal of a sliver would be rounding error. `None` if its corners are in a
    /// line.
    pub(super) fn outward(&self, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
        let areas = [0, 1, 2].map(|axis| Sum::cross([a, b], [a, c], axis));
        let quotients = areas.iter().filter(|area| area.sign() != 0).map(|greatest| {
            let sign = f64::from(-self.facing([a, b, c]) * greatest.sign());
            DVec3::from_array([0, 1, 2].map(|axis| sign * areas[axis].over(greatest)[1]))
        });
        quotients.min_by(|p, q| p.length_squared().total_cmp(&q.length_squared()))?.try_normalize()
    }

    /// How far a point is beyond the plane of a triangle that the ray crosses, as a volume:
    /// negative before the plane. The sign is exact.
    pub(super) fn beyond(&self, [a, b, c]: [DVec3; 3], facing: i32, point: DVec3) -> f64 {
        signed_volume([[a, point], [a, b], [a, c]]) * f64::from(facing)
    }

    /// Adds where the line meets a closed triangle, which may be a segment or a point.
    pub(super) fn meet(&self, [a, b, c]: [DVec3; 3], found: &mut Meeting) {
        if self.pierces([a, b, c]) {
            let height = Sum::volume(self.to(a), [a, b], [a, c]);
            return found.add(&height, &Sum::volume(self.along(), [a, b], [a, c]), self.limit);
        }
        if [self.turn(b, c), self.turn(c, a), self.turn(a, b)] != [0; 3] {
            return;
        }
        // All in one plane. Corners on the line, and edges that cross it.
        let corners = [a, b, c];
        let sides = |axis: usize| corners.map(|corner| self.side(corner, axis));
        let axis = (0..3).find(|axis| sides(*axis) != [0; 3]).unwrap_or(0);
        let sides = sides(axis);
        let longest = self.direction.abs().max_position();
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (corner, edge) = (self.to(corners[i]), [corners[i], corners[j]]);
            if sides[i] == 0 {
                found.add(&Sum::coordinate(corner, longest), &Sum::coordinate(self.along(), longest), self.limit);
            }
            if sides[i] * sides[j] < 0 {
                let speed = Sum::cross(self.along(), edge, axis);
                found.add(&Sum::cross(corner, edge, axis), &speed, self.limit);
            }
        }
    }
}

/// Points that a line and a convex set have in common.
pub(super) struct Meeting {
    /// Whether one is at the start of the ray or ahead of it.
    pub(super) is_ahead: bool,
    /// Whether one is at the start or behind it.
    pub(super) is_behind: bool,
    /// Whether one is at the end of the ray or before it.
    pub(super) is_within: bool,
    /// The least t of them, between its bounds.
    first: [f64; 3],
}

impl Meeting {
    pub(super) fn new() -> Self {
        Self { is_ahead: false, is_behind: false, is_within: false, first: [f64::INFINITY; 3] }
    }

    /// Adds the point at this height over this speed.
    fn add(&mut self, height: &Sum, speed: &Sum, limit: f64) {
        let sign = height.sign() * speed.sign();
        let t = height.over(speed);
        self.is_ahead |= sign >= 0;
        self.is_behind |= sign <= 0;
        self.is_within |= t[2] <= limit || t[0] <= limit && !height.is_over(speed, limit);
        for (first, t) in self.first.iter_mut().zip(t) {
            *first = first.min(t);
        }
    }

    /// Whether the ray meets the set: a line meets it in one piece.
    pub(super) fn is_hit(&self) -> bool {
        self.is_ahead && self.is_within
    }

    /// The t at which the ray enters the set at the latest, between its bounds, if it meets it.
    pub(super) fn entry(&self, ray: &ExactRay) -> [f64; 3] {
        if self.is_behind { [0.0; 3] } else { self.first.map(|t| t.min(ray.limit)) }
    }
}
