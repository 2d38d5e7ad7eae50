//! Linear shape casts by hullmap, with parry's options.

use hullmap::glam::DVec3;
use hullmap::shapes::Rounded;
use hullmap::{Cache, CastSettings, Impact, Motion, Settings, Status};

use super::super::convert::{double, real, wide};
use super::super::parry::math::Vector;
use super::super::parry::query::{ShapeCastHit, ShapeCastOptions, ShapeCastStatus};
use super::BakedHull;
use super::nearest::contact_of;
use super::pair::{HullPair, Local, Placement, on_pair};

/// A hit before this time counts as a contact at the start: its normal decides whether the shapes
/// move apart. In the unit of the motion, as in parry.
const AT_START: f64 = 1e-4;

/// The first hit of a pair that moves at the relative velocity `velocity12`, which is in the frame
/// of parry's first shape. The outer `None` is for invalid numbers, the inner one for a miss.
pub(super) fn cast(
    (pair, placement): &(HullPair<'_>, Placement),
    velocity12: Vector,
    options: &ShapeCastOptions,
) -> Option<Option<ShapeCastHit>> {
    // Velocity of B, in A's frame.
    let velocity = match placement.flipped {
        false => wide(velocity12),
        true => placement.b_in_a.transform_vector(-wide(velocity12)),
    };
    let (motion, target) = (Motion::new(velocity).ok()?, double(options.target_distance));
    let max_t = double(options.max_time_of_impact);
    let settings = CastSettings { max_t, ..CastSettings::default() };
    let place = placement.b_in_a;
    let cache = &mut Cache::new();
    let impact = if target > 0.0 {
        // The shapes are within the target distance if the hull, grown by it, meets B.
        on_pair!(*pair, a, b => {
            let grown: Rounded<BakedHull> = Rounded::new(a.clone(), target).ok()?;
            hullmap::cast(&grown, b, place, motion, &settings, cache)
        })
    } else {
        on_pair!(*pair, a, b => hullmap::cast(a, b, place, motion, &settings, cache))
    };
    // NaN takes the failing branch.
    if !impact.hit || !(impact.t <= max_t) {
        return Some(None);
    }
    let at_start = impact.t < AT_START;
    let geometry = options.compute_impact_geometry_on_penetration || !options.stop_at_penetration;
    if at_start && geometry {
        return Some(start(pair, placement, velocity, target, impact.t, options));
    }
    let Impact { point_a, point_b, normal, t, status, .. } = impact;
    // The point of B moved with it: subtract the motion.
    let Local { points: [witness1, witness2], normals: [normal1, normal2] } =
        placement.local(point_a - normal * target, point_b - velocity * t, normal);
    let status = match status {
        Status::Overlapping => ShapeCastStatus::PenetratingOrWithinTargetDist,
        Status::IterationLimit => ShapeCastStatus::OutOfIterations,
        _ => ShapeCastStatus::Converged,
    };
    let time_of_impact = real(t);
    Some(Some(ShapeCastHit {
        time_of_impact,
        witness1,
        witness2,
        normal1,
        normal2,
        status,
        subshape1: 0,
        subshape2: 0,
    }))
}

/// A hit at the start, described by the contact of the shapes there. `None` if the shapes move
/// apart and the options ignore such hits.
fn start(
    pair: &HullPair<'_>,
    placement: &Placement,
    velocity: DVec3,
    target: f64,
    t: f64,
    options: &ShapeCastOptions,
) -> Option<ShapeCastHit> {
    let found = contact_of(pair, placement, &Settings::default());
    if !options.stop_at_penetration && found.normal.dot(velocity) >= 0.0 {
        return None;
    }
    let status =
        if found.dist < target { ShapeCastStatus::PenetratingOrWithinTargetDist } else { ShapeCastStatus::Converged };
    let Local { points: [witness1, witness2], normals: [normal1, normal2] } =
        placement.local(found.point_a, found.point_b, found.normal);
    Some(ShapeCastHit {
        time_of_impact: real(t),
        witness1,
        witness2,
        normal1,
        normal2,
        status,
        subshape1: 0,
        subshape2: 0,
    })
}
