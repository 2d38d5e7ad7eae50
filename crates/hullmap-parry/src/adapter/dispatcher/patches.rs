//! One contact patch of several parts: the four points that support the body best.
//!
//! A body on a triangle mesh or a compound has a manifold for each part. Rapier merges manifolds
//! with nearly the same normal. In every step, it picks four of their points anew: the deepest one,
//! and others far from it. A smooth body rocks on these for ever. So this module picks four points
//! before Rapier does, as for a single pair ([`choose`]), and removes the others.

use hullmap::SupportMap as _;
use hullmap::glam::{DVec2, DVec3};
use hullmap::manifold::select::{Choice, SAME_PLACE, SLIGHT, Spot, choose};

use super::super::convert::{double, wide};
use super::super::parry::math::Real;
use super::super::parry::query::ContactManifold;
use super::BakedHull;

/// Cosine of the angle up to which normals count as one, as in Rapier.
const SAME_NORMAL: f64 = 0.996;

/// A body that has several manifolds.
pub(super) struct Body<'b> {
    pub(super) hull: &'b BakedHull,
    /// Whether it is parry's second shape.
    pub(super) is_second: bool,
}

impl Body<'_> {
    fn normal<M, C>(&self, manifold: &ContactManifold<M, C>) -> DVec3 {
        wide(if self.is_second { manifold.local_n2 } else { manifold.local_n1 })
    }

    /// The points in the body's frame.
    pub(super) fn points<M, C>(&self, manifolds: &[ContactManifold<M, C>]) -> Vec<DVec3> {
        let points = manifolds.iter().flat_map(|manifold| &manifold.points);
        points.map(|point| wide(if self.is_second { point.local_p2 } else { point.local_p1 })).collect()
    }

    /// Leaves at most four points for each normal. `before` are the points of the last step.
    pub(super) fn thin<M, C>(&self, manifolds: &mut [ContactManifold<M, C>], before: &[DVec3], prediction: Real) {
        if manifolds.iter().filter(|manifold| !manifold.points.is_empty()).count() < 2 {
            return;
        }
        let mut is_done = vec![false; manifolds.len()];
        for first in 0..manifolds.len() {
            let Some(normal) = manifolds.get(first).map(|manifold| self.normal(manifold)) else { break };
            let group: Vec<usize> = (first..manifolds.len())
                .filter(|i| is_done.get(*i) == Some(&false))
                .filter(|i| {
                    manifolds.get(*i).is_some_and(|m| !m.points.is_empty() && self.normal(m).dot(normal) >= SAME_NORMAL)
                })
                .collect();
            for &i in &group {
                is_done.get_mut(i).into_iter().for_each(|done| *done = true);
            }
            let side = normal.any_orthonormal_vector();
            let over = |p: DVec3| DVec2::new(p.dot(side), p.dot(normal.cross(side)));
            let (mut spots, mut places) = (Vec::new(), Vec::new());
            for manifold in group.iter().filter_map(|i| manifolds.get(*i)) {
                places.extend(self.points(std::slice::from_ref(manifold)));
                spots.extend(manifold.points.iter().map(|point| -double(point.dist)));
            }
            let spots: Vec<Spot> =
                spots.into_iter().zip(&places).map(|(depth, place)| Spot { at: over(*place), depth }).collect();
            let mut last = Choice::default();
            for old in before {
                let apart = |place: &DVec3| place.distance(*old);
                let nearest = places.iter().enumerate().min_by(|(_, p), (_, q)| apart(p).total_cmp(&apart(q)));
                let same = nearest.filter(|(_, place)| apart(place) <= SAME_PLACE * self.hull.outer_radius());
                same.into_iter().for_each(|(index, _)| last.push(index));
            }
            let center = over(self.hull.interior_point());
            let choice = choose(&spots, center, SLIGHT * double(prediction), Some(last));
            let mut index = 0;
            for i in group {
                let Some(manifold) = manifolds.get_mut(i) else { break };
                manifold.points.retain(|_| {
                    index += 1;
                    choice.indices().contains(&(index - 1))
                });
            }
        }
    }
}
