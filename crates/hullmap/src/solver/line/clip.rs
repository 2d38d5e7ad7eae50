//! Clipping of a line by support planes: the part of the line that may be in the shape.
//!
//! # Reference
//! Cyrus, Beck 1978 (clipping a line by a convex polytope). docs/contributors/intervals.md proves
//! the bounds.

use glam::DVec3;

use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;

/// Error of a line's points and of a crossing, in units of `f64::EPSILON` times a length of the
/// query. docs/contributors/intervals.md derives 6; the excess covers terms of second order.
const LINE_ROUNDINGS: f64 = 8.0;

/// The part of a line that may be in a convex set.
///
/// Parameters are lengths along the line from its *foot*, the point nearest to the set's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clip {
    pub(super) direction: DVec3,
    /// The point of the line nearest to the centre of the set.
    pub(super) foot: DVec3,
    pub(super) origin: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// Maximum over the planes that the line enters through, also behind its origin.
    pub(super) entry: f64,
    /// Unit normal of the plane of `entry`; zero before there is one.
    pub(super) normal: DVec3,
    /// Unit normal of the plane that cut last.
    pub(super) last: DVec3,
    /// Radius of a ball around the foot that holds every point of the set on the line.
    pub(super) reach: f64,
    /// Error of a point of the line and of the set: a length.
    pub(super) noise: f64,
    /// Error of a plane's offset at any point of the line within the reach: a length.
    pub(super) error: f64,
}

impl Clip {
    /// The part of the line `origin + t direction`, t from 0 to `limit`, that is in the ball around
    /// the Minkowski difference. The line's origin is the origin.
    pub(super) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        direction: DVec3,
        limit: f64,
    ) -> Self {
        let center = m.center_point().w;
        let ahead = center.dot(direction);
        let line_error = LINE_ROUNDINGS * f64::EPSILON * (center.length() + m.outer_radius());
        let reach = m.outer_radius() + m.rounding_error() + line_error;
        let foot = direction * ahead;
        let mut clip = Self {
            direction,
            foot,
            origin: -ahead,
            lower: (-ahead - line_error).max(-reach),
            upper: (limit - ahead + line_error).min(reach),
            entry: f64::NEG_INFINITY,
            normal: DVec3::ZERO,
            last: DVec3::ZERO,
            reach,
            noise: m.noise() + line_error,
            error: m.rounding_error() + line_error,
        };
        let aside = center - foot;
        if aside.length_squared() > reach * reach {
            clip.upper = f64::NEG_INFINITY;
            clip.last = -aside / aside.length();
        } else if clip.is_empty() {
            clip.last = if ahead > 0.0 { -direction } else { direction };
        }
        clip
    }

    /// Whether nothing of the line is left: it certainly misses the set.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.lower > self.upper
    }

    /// Cuts off what is beyond the support plane with normal `n`, of any length, through `w`.
    #[inline(always)]
    pub(super) fn cut(&mut self, n: DVec3, w: DVec3) {
        let length = n.length();
        let along = n.dot(self.direction);
        // Every point of the line in the set satisfies: along · parameter ≤ offset.
        let offset = n.dot(w - self.foot) + self.error * length;
        let crossing = offset / along;
        let rounding = f64::EPSILON * self.reach;
        // NaN cuts off nothing.
        if along < 0.0 {
            let crossing = crossing - rounding;
            if crossing > self.entry {
                self.entry = crossing;
                self.normal = n / length;
                self.lower = self.lower.max(crossing);
            }
        } else if along > 0.0 {
            self.upper = self.upper.min(crossing + rounding);
        } else if offset < 0.0 {
            self.upper = f64::NEG_INFINITY;
        }
        if self.is_empty() {
            self.last = n / length;
        }
    }

    /// Two directions across the line.
    pub(super) fn across(&self) -> [DVec3; 2] {
        let (x, y) = self.direction.any_orthonormal_pair();
        [x, y]
    }
}
