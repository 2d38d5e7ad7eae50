//! Rays that meet a vertex or the middle of two vertices without rounding: no answer may be behind.

use glam::DVec3;
use hullmap::{CastSettings, Pack, Ray, RayHit, SupportMap};

use crate::random::SplitMix;

/// Rounding error of a t, which is at most a few units of [`f64::EPSILON`].
const ROUNDING: f64 = 1e-12;

const MAX_RAYS: usize = 2_000;

/// A function that answers rays: [`hullmap::ray`], or in tests one with wrong answers.
pub(crate) type Answer<'a> = dyn Fn(&Ray) -> RayHit + Sync + 'a;

/// A ray, and a t at which it meets a surface exactly; infinite if none is known.
pub(crate) struct AimedRay {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    pub(crate) meets: f64,
}

impl AimedRay {
    /// The ray from near `from` whose point at t = 1 is exactly the target, if there is one in f32.
    pub(crate) fn at(target: DVec3, from: DVec3) -> Option<Self> {
        let direction = (target - from).as_vec3().as_dvec3();
        let origin = target - direction;
        // The difference is exact if both tests hold (Knuth's TwoSum).
        let is_exact = target - origin == direction && origin + direction == target;
        (is_exact && direction != DVec3::ZERO).then_some(Self { origin, direction, meets: 1.0 })
    }

    /// Whether an answer is not behind the point that the ray meets, by more than `tolerance`.
    pub(crate) fn is_met_by(&self, found: &RayHit, tolerance: f64) -> bool {
        let latest = self.meets * (1.0 + ROUNDING);
        self.meets == f64::INFINITY || found.hit && found.t_lower <= latest && found.t <= latest + tolerance
    }
}

/// The middle of two points; the first one if the middle is rounded.
pub(crate) fn exact_middle(a: DVec3, b: DVec3) -> DVec3 {
    let sum = a + b;
    if sum - a == b && sum - b == a { 0.5 * sum } else { a }
}

/// Casts rays at vertices of the parts of a pack, and at middles of two vertices of a part, which
/// are in it. Returns the number of rays at each hull, and the first hull that an answer is behind,
/// with the problem.
pub(crate) fn cast_rays(pack: &Pack, seed: u64, answer: &Answer) -> (Vec<usize>, Option<(usize, String)>) {
    let (mut counts, mut random) = (vec![0; pack.hull_count()], SplitMix::new(seed));
    let count: usize = pack.hulls().map(|hull| hull.vertex_count()).sum();
    let size = pack.hulls().map(|hull| hull.outer_radius()).fold(0.0, f64::max);
    let problem = (0..count.min(MAX_RAYS)).find_map(|round| {
        let index = random.below(pack.hull_count());
        let hull = pack.hull(index).ok()?;
        let mut vertex = || hull.vertex(random.below(hull.vertex_count()) as u32).map(|v| v.as_dvec3());
        let (a, b) = (vertex()?, vertex()?);
        let target = if round % 2 == 0 { a } else { exact_middle(a, b) };
        let way = match round % 3 {
            0 => DVec3::AXES[random.below(3)] * size,
            1 if a != b => b - a,
            _ => random.in_ball_f64() * (3.0 * size),
        };
        let aimed = AimedRay::at(target, target - way)?;
        let found = answer(&Ray::new(aimed.origin, aimed.direction).ok()?);
        counts[index] += 1;
        let (t, AimedRay { origin, direction, .. }) = (found.t, &aimed);
        let tolerance = CastSettings::default().tolerance * size / direction.length();
        (!aimed.is_met_by(&found, tolerance))
            .then(|| (index, format!("a ray from {origin} along {direction} meets a part at t = 1, found t = {t}")))
    });
    (counts, problem)
}

#[cfg(test)]
mod tests {
    use hullmap::Status;

    use super::*;

    #[test]
    fn an_answer_behind_the_point_is_wrong() {
        let (target, from) = (DVec3::new(f64::from(0.1_f32), 2.0, 1.0), DVec3::new(3.0, 0.7, 9.0));
        let aimed = AimedRay::at(target, from).expect("an exact ray");
        let found = |hit: bool, t: f64| RayHit {
            hit,
            status: Status::Exact,
            t,
            t_lower: t,
            t_upper: t,
            point: aimed.origin + aimed.direction * t,
            normal: DVec3::X,
            iterations: 0,
            support_calls: 0,
            part: 0,
        };
        assert!(aimed.is_met_by(&found(true, 1.0), 0.0) && aimed.is_met_by(&found(true, 0.5), 0.0));
        assert!(!aimed.is_met_by(&found(true, 1.2), 0.1) && !aimed.is_met_by(&found(false, f64::INFINITY), 0.1));
    }
}
