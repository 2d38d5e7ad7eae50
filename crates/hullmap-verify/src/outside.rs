//! Inexact hulls: how far a simplified hull extends beyond its source; distances of points.

use glam::{DVec3, Vec3};
use hullmap::{Cache, Distance, Hull, Pose, Settings, distance};
use rayon::prelude::*;

use crate::support::REGRET_LIMIT;
use crate::truth::{Points, dot};
use hullmap_geometry::number::rounded;

/// Difference between the supports of a hull and its source, over all tested directions; lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// Minimum; negative if the source protrudes from the hull.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// The source's diameter.
    pub diameter: f64,
}

/// Support of the hull's vertices minus support of the source's points, in finite `directions`
/// other than zero. Complexity: O((vertices + points) · directions), on all threads.
pub fn measure_outside(vertices: &[Vec3], source: &Points, directions: &[Vec3]) -> Outside {
    let hull = Points::new(&vertices.iter().map(|vertex| vertex.to_array()).collect::<Vec<_>>());
    let [ours, theirs] = [&hull, source].map(|points| points.greatest_dots(directions));
    let gaps = ours.par_iter().zip(&theirs).zip(directions).map(|((ours, theirs), dir)| {
        let dir = dir.to_array().map(f64::from);
        (ours - theirs) / dot(dir, dir).sqrt()
    });
    // NaN, which cannot occur, would become both minimum and maximum.
    let pick = |a: (f64, f64), b: (f64, f64)| (if b.0 >= a.0 { a.0 } else { b.0 }, if b.1 <= a.1 { a.1 } else { b.1 });
    let (min, max) = gaps.map(|gap| (gap, gap)).reduce(|| (f64::INFINITY, f64::NEG_INFINITY), pick);
    Outside { min, max, diameter: source.diameter() }
}

impl Outside {
    /// Describes the error, if the hull extends farther beyond the source than `recorded`.
    pub fn problem(&self, recorded: f64) -> Option<String> {
        let slack = REGRET_LIMIT * self.diameter;
        // NaN fails.
        if !(self.min >= -slack) {
            return Some(format!(
                "the source protrudes from the hull by {}: a source point was lost",
                rounded(-self.min)
            ));
        }
        if !(self.max <= recorded + slack) {
            let (found, recorded) = (rounded(self.max), rounded(recorded));
            return Some(format!("the hull extends {found} beyond its source, but records at most {recorded}"));
        }
        None
    }
}

/// Distance of a point in the hull's frame, by the runtime's solver: independently of the baker.
pub fn to_point(hull: &Hull, p: DVec3) -> Distance {
    match Pose::from_translation(p) {
        Ok(pose) => distance(hull, &Dot, pose, &Settings::default(), &mut Cache::new()),
        // Nothing is known about a point that is not finite.
        Err(_) => Distance { lower: 0.0, upper: f64::INFINITY, ..Distance::default() },
    }
}

struct Dot;

impl hullmap::SupportMap for Dot {
    fn support_point(&self, _: DVec3) -> hullmap::SupportPoint {
        hullmap::SupportPoint { point: DVec3::ZERO, feature: 0 }
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

impl hullmap::Shape for Dot {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    fn sphere(count: usize) -> Vec<Vec3> {
        let mut random = SplitMix::new(3);
        (0..count).map(|_| random.in_ball().normalize()).collect()
    }

    #[test]
    fn lost_points_and_too_small_errors_are_found() {
        let source = sphere(300);
        let points = Points::new(&source.iter().map(|v| v.to_array()).collect::<Vec<_>>());
        let directions = sphere(5_000);
        let measured = |scale: f32| {
            let vertices: Vec<Vec3> = source.iter().map(|v| *v * scale).collect();
            measure_outside(&vertices, &points, &directions)
        };
        assert_eq!(measured(1.05).problem(0.051), None);
        assert!(measured(1.05).problem(0.04).unwrap().contains("beyond its source"));
        assert!(measured(0.999).problem(0.1).unwrap().contains("a source point was lost"));
        let nan = Outside { min: f64::NAN, max: 0.0, diameter: 1.0 };
        assert!(nan.problem(1.0).is_some());
    }
}
