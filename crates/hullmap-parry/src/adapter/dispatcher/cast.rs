//! Linear shape casts by hullmap, with parry's options.

use hullmap::glam::DVec3;
use hullmap::shapes::Rounded;
use hullmap::{Cache, CastSettings, Impact, Motion, Status};

use super::super::convert::{double, real, wide};
use super::super::parry::math::Vector;
use super::super::parry::query::{ShapeCastHit, ShapeCastOptions, ShapeCastStatus};
use super::pair::{HullPair, Local, Nearest, Placement};

/// A hit before this time counts as a contact at the start: its normal decides whether the shapes
/// move apart. In the unit of the motion, as in parry.
const AT_START: f64 = 1e-4;

pub(super) struct Cast<'o> {
    pub(super) placement: Placement,
    /// Velocity of B, in A's frame.
    pub(super) velocity: DVec3,
    /// The shapes meet at this distance.
    pub(super) target: f64,
    pub(super) max_t: f64,
    pub(super) options: &'o ShapeCastOptions,
}

impl<'o> Cast<'o> {
    /// A cast at the relative velocity `velocity12`, which is in the frame of parry's first shape.
    pub(super) fn new(placement: Placement, velocity12: Vector, options: &'o ShapeCastOptions) -> Self {
        let velocity = match placement.flipped {
            false => wide(velocity12),
            true => placement.b_in_a.transform_vector(-wide(velocity12)),
        };
        let (target, max_t) = (double(options.target_distance).max(0.0), double(options.max_time_of_impact));
        Self { placement, velocity, target, max_t, options }
    }

    /// Whether an impact is a contact at the start: its normal and points belong to the start.
    pub(super) fn is_at_start(&self, impact: &Impact) -> bool {
        let geometry = self.options.compute_impact_geometry_on_penetration || !self.options.stop_at_penetration;
        impact.t < AT_START && geometry
    }

    /// Whether an impact is a hit within the time of the cast. NaN takes the failing branch.
    pub(super) fn is_hit(&self, impact: &Impact) -> bool {
        impact.hit && impact.t <= self.max_t
    }

    /// Whether shapes in contact at the start move apart, and the options ignore such hits.
    pub(super) fn ignores(&self, normal: DVec3) -> bool {
        !self.options.stop_at_penetration && normal.dot(self.velocity) >= 0.0
    }

    pub(super) fn hit(&self, impact: &Impact) -> ShapeCastHit {
        let Impact { point_a, point_b, normal, t, status, .. } = *impact;
        // The point of B moved with it: subtract the motion.
        let local = self.placement.local(point_a - normal * self.target, point_b - self.velocity * t, normal);
        let status = match status {
            Status::Overlapping => ShapeCastStatus::PenetratingOrWithinTargetDist,
            Status::IterationLimit => ShapeCastStatus::OutOfIterations,
            _ => ShapeCastStatus::Converged,
        };
        cast_hit(t, local, status)
    }

    /// A hit at the start, described by the contact of the shapes there. `None` if the shapes move
    /// apart and the options ignore such hits.
    pub(super) fn start(&self, found: &Nearest, t: f64) -> Option<ShapeCastHit> {
        if self.ignores(found.normal) {
            return None;
        }
        let status = if found.dist < self.target {
            ShapeCastStatus::PenetratingOrWithinTargetDist
        } else {
            ShapeCastStatus::Converged
        };
        Some(cast_hit(t, self.placement.local(found.point_a, found.point_b, found.normal), status))
    }
}

fn cast_hit(t: f64, local: Local, status: ShapeCastStatus) -> ShapeCastHit {
    let Local { points: [witness1, witness2], normals: [normal1, normal2] } = local;
    ShapeCastHit { time_of_impact: real(t), witness1, witness2, normal1, normal2, status, subshape1: 0, subshape2: 0 }
}

/// The first hit of a pair that moves at the relative velocity `velocity12`, which is in the frame
/// of parry's first shape. The outer `None` is for invalid numbers, the inner one for a miss.
pub(super) fn cast(
    pair: &HullPair<'_>,
    velocity12: Vector,
    options: &ShapeCastOptions,
) -> Option<Option<ShapeCastHit>> {
    let HullPair { a, b, placement } = pair;
    let cast = Cast::new(*placement, velocity12, options);
    let motion = Motion::new(cast.velocity).ok()?;
    let settings = CastSettings { max_t: cast.max_t, ..CastSettings::default() };
    let cache = &mut Cache::new();
    let impact = if cast.target > 0.0 {
        // The shapes are within the target distance if the hull, grown by it, meets B.
        let grown = Rounded::new((*a).clone(), cast.target).ok()?;
        hullmap::cast(&grown, b, placement.b_in_a, motion, &settings, cache)
    } else {
        hullmap::cast(*a, b, placement.b_in_a, motion, &settings, cache)
    };
    if !cast.is_hit(&impact) {
        return Some(None);
    }
    if cast.is_at_start(&impact) {
        return Some(cast.start(&pair.nearest(), impact.t));
    }
    Some(Some(cast.hit(&impact)))
}
