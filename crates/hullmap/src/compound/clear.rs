//! Whether parts stay clear of each other during a motion.

use super::cast_motion::{Compounds, first_meeting};
use super::parts::Parts;
use crate::continuous::clear::judge;
use crate::continuous::{ClearSettings, Clearance, RigidMotion};
use crate::solver::Cache;

/// Whether `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, stay farther apart
/// than a margin, and the least distance that is proven.
pub(crate) fn clear<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    motions: [&RigidMotion; 2],
    settings: &ClearSettings,
    cache: &mut Cache,
) -> Clearance {
    let origin = motions[0].start();
    let motions = motions.map(|motion| motion.relative_to(origin));
    let (tolerance, boxes) = (settings.motion.tolerance, Cache::new());
    let mut bodies = Compounds { a, b, motions, tolerance, cache, boxes };
    judge(settings, motions, |goal| first_meeting(&mut bodies, goal))
}
