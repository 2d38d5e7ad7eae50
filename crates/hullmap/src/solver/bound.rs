//! Upper bound of the penetration depth: a support plane with its witness points.
//!
//! The origin's *foot* is its projection onto the support plane. Witness points a and b are
//! opposite each other if a − b is the foot: then both are on the surfaces, and B moved by the
//! depth touches A where they are.

use glam::DVec3;

use super::barycentric::{blend, on_segment, on_triangle};
use super::gjk::Simplex;
use super::minkowski::{Minkowski, Point};
use crate::support::SupportMap;

/// Witness points may be this many rounding errors farther from the foot than the interval is wide:
/// one each for the support point and the closest point.
pub(super) const FOOT_ROUNDINGS: f64 = 2.0;

/// Two normals are the same if they differ by less than this.
pub(crate) const SAME_NORMAL: f64 = 1e-7;

/// Maximum number of steps of the search for witness points. Most need 1 to 4.
const MAX_STEPS: u32 = 100;

/// Maximum number of points on the other side of the origin that a common point is mended with.
const MAX_SIDES: usize = 3;

/// Distance of such a point from the origin, in multiples of the distance of the point that it
/// mends.
const OTHER_SIDE: f64 = 8.0;

/// The minimum support value so far, with its normal and its witness points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Support value along `normal`, without allowance for rounding error.
    pub(super) upper: f64,
    pub(super) normal: DVec3,
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
}

impl Bound {
    pub(super) fn none() -> Self {
        Self { upper: f64::INFINITY, normal: DVec3::ZERO, point_a: DVec3::ZERO, point_b: DVec3::ZERO }
    }

    pub(super) fn on_face(upper: f64, normal: DVec3, face: [&Point; 3]) -> Self {
        let [p, q, r] = face.map(|v| v.w);
        let weights = on_triangle(p, q, r).weights;
        let (point_a, point_b) = (blend(&weights, face.map(|v| v.a)), blend(&weights, face.map(|v| v.b())));
        Self { upper, normal, point_a, point_b }
    }

    /// Uses the `support` point along the normal as witness points if they are less deep than
    /// `least`. It is as deep as the bound, but the two need not be opposite each other.
    pub(super) fn deepen(&mut self, least: f64, support: impl FnOnce(DVec3) -> Point) {
        // Not the distance: convex radii are added along the normal.
        if self.upper < f64::INFINITY && (self.point_a - self.point_b).dot(self.normal) < least {
            let point = support(self.normal);
            (self.point_a, self.point_b) = (point.a, point.b());
        }
    }

    /// A common point of two overlapping shapes, one on each. For slivers the two may be apart; GJK
    /// then starts from elsewhere. Also returns the number of steps.
    ///
    /// GJK may stall short of the origin, on a simplex that is too thin. The error of a point that
    /// is farther on the other side counts less in the point between both at the origin.
    pub(super) fn common_point<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &mut Minkowski<'_, A, B>,
        [point_a, point_b]: [DVec3; 2],
        normal: DVec3,
    ) -> ([DVec3; 2], u32) {
        // The origin is its own foot.
        let mut found = Self { upper: 0.0, normal, point_a, point_b };
        let enough = FOOT_ROUNDINGS * m.noise();
        // NaN takes the search.
        let mut steps = if found.off() <= enough { 0 } else { found.search(m, &[], enough) };
        for _ in 0..MAX_SIDES {
            let near = found.point_a - found.point_b;
            let length = near.length();
            // NaN ends the search.
            if !(length > enough) {
                break;
            }
            let mut far = Self { upper: OTHER_SIDE * length, normal: near * -length.recip(), ..found };
            steps += far.search(m, &[], enough);
            let weights = on_segment(near, far.point_a - far.point_b).weights;
            found.point_a = blend(&weights, [found.point_a, far.point_a]);
            found.point_b = blend(&weights, [found.point_b, far.point_b]);
        }
        ([found.point_a, found.point_b], steps)
    }

    /// How far the difference of the witness points is from the foot.
    pub(super) fn off(&self) -> f64 {
        (self.point_a - self.point_b).distance(self.normal * self.upper)
    }

    /// Searches for the point of the difference that is closest to the foot, by a distance query of
    /// A and of B moved by the depth, which touch. It starts from `face`, if there is one. Returns
    /// the number of steps.
    #[cold]
    #[inline(never)]
    pub(super) fn search<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        face: &[Point],
        enough: f64,
    ) -> u32 {
        let (foot, normal) = (self.normal * self.upper, self.normal);
        m.moved(foot, |m| {
            let mut simplex = Simplex::empty();
            for point in face {
                let w = point.w - foot;
                if !simplex.contains(w) {
                    simplex.push(Point { w, ..*point });
                }
            }
            if simplex.is_empty() {
                simplex.push(m.point(normal));
            }
            let near = m.closest_within(&mut simplex, enough, 0.0, MAX_STEPS);
            let (point_a, _, off) = simplex.witnesses(near.upper, m.noise());
            // NaN is no improvement.
            if off.length() < self.off() {
                (self.point_a, self.point_b) = (point_a, point_a - (off + foot));
            }
            near.iterations
        })
    }
}
