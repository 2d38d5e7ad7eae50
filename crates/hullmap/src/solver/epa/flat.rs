//! EPA without volume. A first tetrahedron or the proof that the Minkowski difference is flat; and,
//! by GJK, flat differences, and an origin beside a face instead of on it.
//!
//! # Steps of [`seed`], where portal refinement left no tetrahedron with a volume
//! 1. Query support points both ways along the three axes. Keep the two that are farthest from each
//!    other.
//! 2. Query four more directions, perpendicular to the line of the two. Keep the point
//!    farthest from the line of all ten.
//! 3. Query both ways along the normal of the triangle. Keep the point farther from it.
//! 4. If the length, the height or the thickness is within rounding error, the rank is 0, 1 or 2:
//!    flat.

use glam::DVec3;

use super::search::{End, Expansion, TOUCHING_ROUNDINGS};
use crate::solver::bound::{Bound, FOOT_ROUNDINGS};
use crate::solver::gjk::{self, Closest, Simplex};
use crate::solver::minkowski::{Minkowski, Point};
use crate::solver::scratch::Small;
use crate::support::SupportMap;
use crate::vector::{perpendicular, unit};

/// A thickness up to this many rounding errors counts as zero: the errors of two support points on
/// either side, and the error of the normal.
const THICKNESS_ROUNDINGS: f64 = 8.0;

/// Support values of flat differences up to this many rounding errors count as touching: their
/// thickness is up to half of this, and their normal is as uncertain.
pub(in crate::solver) const FLAT_ROUNDINGS: f64 = 16.0;

/// Witness points of a touching face that are more than this many rounding errors from each other
/// show that the origin is beside the face.
pub(in crate::solver) const BESIDE_ROUNDINGS: f64 = 4.0;

/// Maximum number of steps of the closest-point search.
const MAX_FLAT: u32 = 100;

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'_, A, B> {
    /// Starts `polytope` from a tetrahedron of support points. At most 12 support calls.
    ///
    /// # Errors
    /// The unit normal along which the difference has no thickness.
    #[cold]
    #[inline(never)]
    pub(super) fn seed(&mut self, polytope: &mut Small) -> Result<(), DVec3> {
        let thin = THICKNESS_ROUNDINGS * self.rounding_error();
        let mut seen = [Point::EMPTY; 10];
        for (i, dir) in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate()
        {
            seen[i] = self.point(dir);
        }
        let (mut p, mut q) = (seen[0], seen[1]);
        for (i, j) in (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j))) {
            if seen[i].w.distance_squared(seen[j].w) > p.w.distance_squared(q.w) {
                (p, q) = (seen[i], seen[j]);
            }
        }
        // NaN takes the branch of flat differences, here and below.
        let Some(line) = unit(q.w - p.w).filter(|_| q.w.distance(p.w) > thin) else {
            return Err(unit(-self.center_point().w).unwrap_or(DVec3::X));
        };
        let side = perpendicular(line);
        let other = line.cross(side);
        for (i, dir) in [side, -side, other, -other].into_iter().enumerate() {
            seen[6 + i] = self.point(dir);
        }
        let height = |v: &Point| (v.w - p.w).cross(line).length();
        let r = seen.iter().fold(&seen[0], |r, v| if height(v) > height(r) { v } else { r });
        let Some(normal) = unit((q.w - p.w).cross(r.w - p.w)).filter(|_| height(r) > thin) else { return Err(side) };
        let (above, below) = (self.point(normal), self.point(-normal));
        let (rise, fall) = ((above.w - p.w).dot(normal), (p.w - below.w).dot(normal));
        if !(rise.max(fall) > thin) {
            return Err(normal);
        }
        let tetrahedron = [p, q, *r, if rise >= fall { above } else { below }];
        // Otherwise its height comes from rounding error in the normal of a thin triangle.
        let is_solid = polytope.start(tetrahedron, 0.0);
        if is_solid { Ok(()) } else { Err(widest_normal(tetrahedron.map(|v| v.w))) }
    }

    /// Solves a difference that is flat along `normal`: its depth is zero if it contains the
    /// origin.
    #[inline(never)]
    pub(super) fn expand_flat(&mut self, normal: DVec3, mut state: Expansion) -> Expansion {
        state.lower = 0.0;
        let Some((near, [point_a, point_b], _)) = self.closest(&mut state) else { return state };
        let value = self.point(normal).w.dot(normal);
        state.bound = Bound { upper: value.max(0.0), normal, point_a, point_b };
        let is_touching = matches!(near.end, gjk::End::AtOrigin | gjk::End::Inside)
            || near.upper <= TOUCHING_ROUNDINGS * self.rounding_error();
        state.end = if is_touching { End::Touching } else { End::Stalled };
        state
    }

    /// Corrects the witness points of a bound whose face does not give them.
    ///
    /// If the origin is in the plane of a face but beside the face, the face proves nothing: two
    /// flat shapes may be separated within their common plane. GJK decides. And if a limit or
    /// rounding error ended the search, a support point replaces points that are less deep than the
    /// interval of the depth allows.
    #[inline]
    pub(super) fn settle_expansion(&mut self, mut expansion: Expansion) -> Expansion {
        let length_sq = expansion.bound.point_a.distance_squared(expansion.bound.point_b);
        let beside = BESIDE_ROUNDINGS * self.rounding_error();
        if expansion.end == End::Touching
            && length_sq > beside * beside
            && let Some((_, points, between)) = self.closest(&mut expansion)
            && between.length_squared() < length_sq
        {
            [expansion.bound.point_a, expansion.bound.point_b] = points;
        }
        if expansion.end != End::Separated && expansion.lower > 0.0 {
            let slack = FOOT_ROUNDINGS * self.rounding_error();
            expansion.bound.deepen(expansion.lower - slack, |normal| self.point(normal));
        }
        expansion
    }

    /// GJK from the centre: what it found, the witness points, and their difference. `None` if it
    /// proves the shapes separated, which `expansion` states then.
    #[cold]
    #[inline(never)]
    fn closest(&mut self, expansion: &mut Expansion) -> Option<(Closest, [DVec3; 2], DVec3)> {
        let (mut simplex, rounding) = (Simplex::new(self.center_point()), self.rounding_error());
        let near = self.closest_within(&mut simplex, rounding, 0.0, MAX_FLAT);
        let (point_a, point_b, between) = simplex.witnesses(near.upper, self.noise());
        expansion.iterations += near.iterations;
        if near.lower > rounding {
            expansion.end = End::Separated;
            expansion.bound = Bound { upper: -near.lower, normal: near.normal, point_a, point_b };
            return None;
        }
        Some((near, [point_a, point_b], between))
    }
}

/// The normal of the largest face of a flat tetrahedron.
fn widest_normal([p, q, r, s]: [DVec3; 4]) -> DVec3 {
    let normals = [(q - p).cross(r - p), (q - p).cross(s - p), (r - p).cross(s - p), (r - q).cross(s - q)];
    let wider = |widest: DVec3, n: DVec3| if n.length_squared() > widest.length_squared() { n } else { widest };
    unit(normals.into_iter().fold(DVec3::ZERO, wider)).unwrap_or(DVec3::X)
}
