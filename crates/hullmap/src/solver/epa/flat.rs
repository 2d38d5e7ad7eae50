//! EPA without volume: flat differences, and an origin beside a face instead of on it. GJK decides
//! both.

use glam::DVec3;

use super::search::{End, Expansion, TOUCHING_ROUNDINGS};
use crate::solver::bound::{Bound, FOOT_ROUNDINGS};
use crate::solver::gjk::{self, Closest, Simplex, closest_within};
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;
use crate::vector::unit;

/// Support values of flat differences up to this many rounding errors count as touching: their
/// thickness is up to half of this, and their normal is as uncertain.
pub(in crate::solver) const FLAT_ROUNDINGS: f64 = 16.0;

/// Witness points of a touching face that are more than this many rounding errors from each other
/// show that the origin is beside the face.
pub(in crate::solver) const BESIDE_ROUNDINGS: f64 = 4.0;

/// Maximum number of steps of the closest-point search.
const MAX_FLAT: u32 = 100;

/// Corrects the witness points of a bound whose face does not give them.
///
/// If the origin is in the plane of a face but beside the face, the face proves nothing: two flat
/// shapes may be separated within their common plane. GJK decides. And if a limit or rounding error
/// ended the search, a support point replaces points that are less deep than the interval of the
/// depth allows.
#[inline]
pub(super) fn settle<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    mut expansion: Expansion,
) -> Expansion {
    let between = expansion.bound.point_a - expansion.bound.point_b;
    let beside = BESIDE_ROUNDINGS * m.rounding_error();
    if expansion.end == End::Touching && between.length_squared() > beside * beside {
        expansion = settle_beside(m, expansion);
    }
    if expansion.end == End::Separated {
        return expansion;
    }
    if expansion.lower > 0.0 {
        let slack = FOOT_ROUNDINGS * m.rounding_error();
        expansion.bound.deepen(expansion.lower - slack, |normal| m.point(normal));
    }
    expansion
}

/// The case of an origin in the plane of a face and beside the face.
#[cold]
#[inline(never)]
fn settle_beside<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    mut expansion: Expansion,
) -> Expansion {
    if let Some((_, points, between)) = closest(m, &mut expansion) {
        let bound = &mut expansion.bound;
        if between.length_squared() < bound.point_a.distance_squared(bound.point_b) {
            [bound.point_a, bound.point_b] = points;
        }
    }
    expansion
}

/// GJK from the centre: what it found, the witness points, and their difference. `None` if it
/// proves the shapes separated, which `expansion` states then.
fn closest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    expansion: &mut Expansion,
) -> Option<(Closest, [DVec3; 2], DVec3)> {
    let (mut simplex, rounding) = (Simplex::new(m.center_point()), m.rounding_error());
    let near = closest_within(m, &mut simplex, rounding, 0.0, MAX_FLAT);
    let (point_a, point_b, between) = simplex.witnesses(near.upper, m.noise());
    expansion.iterations += near.iterations;
    if near.lower > rounding {
        expansion.end = End::Separated;
        expansion.bound = Bound { upper: -near.lower, normal: near.normal, point_a, point_b };
        return None;
    }
    Some((near, [point_a, point_b], between))
}

/// The normal of the largest face of a flat tetrahedron.
pub(super) fn widest_normal(tetrahedron: [Point; 4]) -> DVec3 {
    let [p, q, r, s] = tetrahedron.map(|v| v.w);
    let normals = [(q - p).cross(r - p), (q - p).cross(s - p), (r - p).cross(s - p), (r - q).cross(s - q)];
    let wider = |widest: DVec3, n: DVec3| if n.length_squared() > widest.length_squared() { n } else { widest };
    unit(normals.into_iter().fold(DVec3::ZERO, wider)).unwrap_or(DVec3::X)
}

/// Solves a difference that is flat along `normal`: its depth is zero if it contains the origin.
#[inline(never)]
pub(super) fn expand_flat<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    normal: DVec3,
    mut state: Expansion,
) -> Expansion {
    state.lower = 0.0;
    let Some((near, [point_a, point_b], _)) = closest(m, &mut state) else { return state };
    let value = m.point(normal).w.dot(normal);
    state.bound = Bound { upper: value.max(0.0), normal, point_a, point_b };
    state.end = if near.end == gjk::End::AtOrigin
        || near.end == gjk::End::Inside
        || near.upper <= TOUCHING_ROUNDINGS * m.rounding_error()
    {
        End::Touching
    } else {
        End::Stalled
    };
    state
}
