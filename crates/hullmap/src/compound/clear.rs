//! Whether compounds stay clear of each other during a motion.

use super::cast_motion::{Bodies, Compounds, first_meeting};
use super::parts::Parts;
use super::{CompoundAnswer, CompoundCache};
use crate::continuous::clear::judge;
use crate::continuous::{ClearSettings, Clearance, RigidMotion};
use crate::solver::Cache;

/// Whether `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, stay farther apart
/// than a margin, and the least distance that is proven.
///
/// As [`clear`](crate::clear()), for all pairs of parts. If the motion hits, `hulls` is the pair of
/// parts that meets first; else it means nothing. The limit of queries is the same as for
/// [`compound::cast_motion`](super::cast_motion()), and applies to both searches together.
///
/// `cache` belongs to this ordered pair of compounds; the query reads and updates it.
///
/// # Complexity
/// The same as for [`compound::cast_motion`](super::cast_motion()); twice as much for a free motion
/// if [`share`](ClearSettings::share) is not 0. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{ClearSettings, Compound, CompoundCache, Pose, RigidMotion, Verdict, compound};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. A ball passes between them.
/// let (cubes, ball) = (Compound::new(&pack), Sphere::new(0.75)?);
/// let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.5, z));
/// let (still, settings) = (RigidMotion::still(Pose::IDENTITY), ClearSettings::default());
/// let mut run = |edge: RigidMotion| {
///     let mut cache = CompoundCache::default();
///     compound::clear(&cubes, &still, &ball, &edge, &settings, &mut cache).answer
/// };
/// let found = run(RigidMotion::between(at(2.0, 9.0)?, at(2.0, -9.0)?)?);
/// assert_eq!(found.verdict, Verdict::Free);
/// assert!(0.125 <= found.clearance && found.clearance <= 0.25);
/// assert_eq!(run(RigidMotion::between(at(1.0, 9.0)?, at(2.5, -9.0)?)?).verdict, Verdict::Hit);
/// # Ok(())
/// # }
/// ```
pub fn clear<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &ClearSettings,
    cache: &mut CompoundCache,
) -> CompoundAnswer<Clearance> {
    let origin = motion_a.start();
    let motions = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let (tolerance, boxes) = (settings.motion.tolerance, Cache::new());
    let mut bodies = Compounds { a, b, motions, tolerance, cache, boxes };
    judge_bodies(&mut bodies, motions, settings)
}

/// The answer for two bodies made of parts.
pub(super) fn judge_bodies<T: Bodies>(
    bodies: &mut T,
    motions: [RigidMotion; 2],
    settings: &ClearSettings,
) -> CompoundAnswer<Clearance> {
    let (mut hulls, mut pairs, mut boxes) = ([0, 0], 0, 0);
    let answer = judge(settings, motions, |goal| {
        let found = first_meeting(bodies, goal);
        (pairs, boxes) = (pairs + found.pairs, boxes + found.boxes);
        if found.answer.hit {
            hulls = found.hulls;
        }
        found.answer
    });
    CompoundAnswer { answer, hulls, pairs, boxes }
}
