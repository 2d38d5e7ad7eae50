//! Hulls that are not exact: how far a simplified hull reaches beyond its source, and what convex parts leave out.

use glam::{DVec3, Vec3};
use hullmap::{Cache, Hull, Pose, Settings, distance};
use hullmap_bake::PointSet;
use rayon::prelude::*;

use super::REGRET_LIMIT;
use super::truth::{Points, dot};

/// Where a hull's support lies beyond that of the source, over all directions tried; lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// The least: below 0 where the source stands out of the hull.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
    /// The source's diameter.
    pub diameter: f64,
}

/// Support of the hull's vertices less that of the source's points, in all `directions`, which are finite and not zero.
///
/// # Complexity
/// O((vertices + points) · directions), on all threads of the pool.
pub fn measure_outside(vertices: &[Vec3], source: &Points, directions: &[Vec3]) -> Outside {
    let hull = Points::new(&vertices.iter().map(|vertex| vertex.to_array()).collect::<Vec<_>>());
    let [ours, theirs] = [&hull, source].map(|points| points.greatest_dots(directions));
    let gaps = ours.par_iter().zip(&theirs).zip(directions).map(|((ours, theirs), dir)| {
        let dir = dir.to_array().map(f64::from);
        (ours - theirs) / dot(dir, dir).sqrt()
    });
    // NaN, of which there is none, would be the least and the greatest.
    let pick = |a: (f64, f64), b: (f64, f64)| (if b.0 >= a.0 { a.0 } else { b.0 }, if b.1 <= a.1 { a.1 } else { b.1 });
    let (least, greatest) = gaps.map(|gap| (gap, gap)).reduce(|| (f64::INFINITY, f64::NEG_INFINITY), pick);
    Outside { least, greatest, diameter: source.diameter() }
}

impl Outside {
    /// What is wrong, if the hull says that it leaves the source by `said` at most.
    pub fn problem(&self, said: f64) -> Option<String> {
        let slack = REGRET_LIMIT * self.diameter;
        // NaN fails.
        if !(self.least >= -slack) {
            return Some(format!("the source stands out of it by {:.3e}: a point was lost", -self.least));
        }
        if !(self.greatest <= said + slack) {
            return Some(format!("it leaves the source by {:.3e}, where it says {said:.3e} at most", self.greatest));
        }
        None
    }
}

/// How far the point that lies farthest outside of all hulls is from the nearest; 0 where all are inside some.
///
/// By the solver's own distance, as a point against each hull: other means than the baker's.
pub fn uncovered(points: &PointSet, hulls: &[Hull]) -> f64 {
    let farthest = |p: &[f32; 3]| {
        let p = DVec3::from_array(p.map(f64::from));
        let Ok(pose) = Pose::from_translation(p) else { return f64::INFINITY };
        let mut least = f64::INFINITY;
        for hull in hulls {
            let [low, high] = hull.bounds().map(Vec3::as_dvec3);
            if (low - p).max(p - high).max(DVec3::ZERO).length() < least {
                let found = distance(hull, &Dot, pose, &Settings::default(), &mut Cache::new());
                least = least.min(found.distance);
            }
        }
        least
    };
    points.positions.par_iter().map(farthest).reduce(|| 0.0, f64::max)
}

/// A point at the origin of its frame.
struct Dot;

impl hullmap::SupportMap for Dot {
    fn support(&self, _: DVec3) -> hullmap::Support {
        hullmap::Support { point: DVec3::ZERO, feature: 0 }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        0.0
    }
    fn outer_radius(&self) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verification::random::SplitMix;

    fn sphere(count: usize) -> Vec<Vec3> {
        let mut random = SplitMix::new(3);
        (0..count).map(|_| random.in_ball().normalize()).collect()
    }

    #[test]
    fn a_hull_around_passes_and_a_lost_point_or_a_broken_promise_does_not() {
        let source = sphere(300);
        let points = Points::new(&source.iter().map(|v| v.to_array()).collect::<Vec<_>>());
        let directions = sphere(5_000);
        let measured = |scale: f32| {
            let vertices: Vec<Vec3> = source.iter().map(|v| *v * scale).collect();
            measure_outside(&vertices, &points, &directions)
        };
        assert_eq!(measured(1.05).problem(0.051), None);
        assert!(measured(1.05).problem(0.04).unwrap().contains("leaves the source"));
        assert!(measured(0.999).problem(0.1).unwrap().contains("a point was lost"));
        let nan = Outside { least: f64::NAN, greatest: 0.0, diameter: 1.0 };
        assert!(nan.problem(1.0).is_some());
    }
}
