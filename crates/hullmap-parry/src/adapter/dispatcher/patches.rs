//! One contact patch of several parts: the four points that support the body best.
//!
//! A body on a triangle mesh or a compound has a manifold for each part. Rapier merges manifolds
//! with nearly the same normal. In every step, it picks four of their points anew: the deepest one,
//! and others far from it. A smooth body rocks on these for ever. So this module picks four points
//! before Rapier does, as for a single pair ([`choose`]), and the others are removed.

use hullmap::SupportMap as _;
use hullmap::glam::{DVec2, DVec3};
use hullmap::manifold::select::{Choice, SAME_PLACE, SLIGHT, Spot, choose};

use super::super::convert::{double, wide};
use super::super::parry::math::Real;
use super::super::parry::query::ContactManifold;
use super::BakedHull;

/// Cosine of the angle up to which normals count as one, as in Rapier.
pub(super) const SAME_NORMAL: f64 = 0.996;

/// A contact point, in the frame of the body.
#[derive(Clone, Copy)]
pub(super) struct PatchPoint {
    pub(super) place: DVec3,
    pub(super) normal: DVec3,
    pub(super) depth: f64,
}

#[derive(Clone, Copy)]
pub(super) struct Supported {
    /// Approximate centre of mass.
    pub(super) center: DVec3,
    /// Radius of a ball around the centre that contains it.
    pub(super) radius: f64,
}

/// Which points stay: at most four for each normal. `before` are the points of the last step, in
/// the frame of the body.
pub(super) fn thinned(points: &[PatchPoint], before: &[DVec3], body: Supported, prediction: Real) -> Vec<bool> {
    let (mut stays, mut is_done) = (vec![false; points.len()], vec![false; points.len()]);
    for first in 0..points.len() {
        let Some(normal) = points.get(first).map(|point| point.normal) else { break };
        let group: Vec<(usize, PatchPoint)> = points
            .iter()
            .copied()
            .enumerate()
            .skip(first)
            .filter(|(i, point)| is_done.get(*i) == Some(&false) && point.normal.dot(normal) >= SAME_NORMAL)
            .collect();
        for (i, _) in &group {
            is_done.get_mut(*i).into_iter().for_each(|done| *done = true);
        }
        let side = normal.any_orthonormal_vector();
        let over = |p: DVec3| DVec2::new(p.dot(side), p.dot(normal.cross(side)));
        let spots: Vec<Spot> =
            group.iter().map(|(_, point)| Spot { at: over(point.place), depth: point.depth }).collect();
        let mut last = Choice::default();
        for old in before {
            let apart = |point: &PatchPoint| point.place.distance(*old);
            let nearest = group.iter().enumerate().min_by(|(_, (_, p)), (_, (_, q))| apart(p).total_cmp(&apart(q)));
            let same = nearest.filter(|(_, (_, point))| apart(point) <= SAME_PLACE * body.radius);
            same.into_iter().for_each(|(index, _)| last.push(index));
        }
        let choice = choose(&spots, over(body.center), SLIGHT * double(prediction), Some(last));
        for index in choice.indices() {
            if let Some(stay) = group.get(*index).and_then(|(i, _)| stays.get_mut(*i)) {
                *stay = true;
            }
        }
    }
    stays
}

/// Which points of a ball stay: the deepest one for each normal.
pub(super) fn deepest(points: &[PatchPoint]) -> Vec<bool> {
    let is_deeper = |(i, other): (usize, &PatchPoint), (j, point): (usize, &PatchPoint)| {
        let comes_first = other.depth > point.depth || other.depth == point.depth && i < j;
        comes_first && other.normal.dot(point.normal) >= SAME_NORMAL
    };
    let stays = |found| !points.iter().enumerate().any(|other| is_deeper(other, found));
    points.iter().enumerate().map(stays).collect()
}

/// Leaves at most four points of a hull for each normal. `is_second` says whether it is parry's
/// second shape, and `before` are its points in the last step, in its frame.
pub(super) fn thin<M, C>(
    manifolds: &mut [ContactManifold<M, C>],
    (hull, is_second): (&BakedHull, bool),
    before: &[DVec3],
    prediction: Real,
) {
    if manifolds.iter().filter(|manifold| !manifold.points.is_empty()).count() < 2 {
        return;
    }
    let mut points = Vec::new();
    for manifold in manifolds.iter() {
        let normal = wide(if is_second { manifold.local_n2 } else { manifold.local_n1 });
        let own = places(std::slice::from_ref(manifold), is_second);
        let depths = manifold.points.iter().map(|point| -double(point.dist));
        points.extend(own.into_iter().zip(depths).map(|(place, depth)| PatchPoint { place, normal, depth }));
    }
    let body = Supported { center: hull.interior_point(), radius: hull.outer_radius() };
    let mut stays = thinned(&points, before, body, prediction).into_iter();
    for manifold in manifolds {
        manifold.points.retain(|_| stays.next() == Some(true));
    }
}

/// The points of manifolds on the body, in its frame.
pub(super) fn places<M, C>(manifolds: &[ContactManifold<M, C>], is_second: bool) -> Vec<DVec3> {
    let points = manifolds.iter().flat_map(|manifold| &manifold.points);
    points.map(|point| wide(if is_second { point.local_p2 } else { point.local_p1 })).collect()
}
