//! Our answers and parry's compared with each other. Lengths are relative to the mean diameter of the pair.
//!
//! Where the depths differ, parry's normal is the judge: to move B out of A along any direction is an upper bound of the
//! depth, and how far that is follows from the vertices alone, in f64.

use glam::DVec3;
use hullmap::{Cache, Hull, Pose, Settings, Status, contact, distance, intersects};
use parry3d::{math, query};

use super::pairs::{Pair, Placed};

/// Differences of all pairs of one vertex count.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Pairs asked.
    pub pairs: usize,
    /// Pairs that overlap, by our answer.
    pub hits: usize,
    /// Pairs where `intersection_test` says otherwise than we.
    pub parry_yes_no: usize,
    /// Pairs that overlap, of which parry's contact says that they do not, or gives none.
    pub parry_no_contact: usize,
    /// How far parry's depth is above (positive) or below (negative) our interval; 0 within.
    pub depth: Vec<f64>,
    /// How far parry's distance is above (positive) or below (negative) our interval; 0 within.
    pub distance: Vec<f64>,
    /// Widths of our depth intervals, relative to their upper ends.
    pub depth_width: Vec<f64>,
    /// Widths of our distance intervals, relative to their upper ends.
    pub distance_width: Vec<f64>,
    /// Pairs where parry's normal proves our lower end of the depth too large. Must be 0.
    pub disproved: usize,
    /// Our contacts that ended at a cap.
    pub capped: usize,
    /// Our contacts that rounding stopped.
    pub stalled: usize,
}

impl Differences {
    /// Asks both about all `poses`.
    ///
    /// # Panics
    /// If parry does not take polyhedra: it does.
    pub fn add(&mut self, pair: &Pair, poses: &[Placed]) {
        const SUPPORTED: &str = "parry takes two polyhedra";
        let ([a, b], [parry_a, parry_b]) = (&pair.hulls(), pair.polyhedra());
        let (settings, here, diameter) = (Settings::default(), math::Pose::IDENTITY, pair.diameter());
        for placed in poses {
            let there = &placed.parry;
            let hit = intersects(a, b, placed.b_in_a, &mut Cache::default()).is_hit();
            let parry_hit = query::intersection_test(&here, parry_a, there, parry_b).expect(SUPPORTED).intersecting;
            self.pairs += 1;
            self.hits += usize::from(hit);
            self.parry_yes_no += usize::from(hit != parry_hit);
            if hit {
                let deep = contact(a, b, placed.b_in_a, &settings, &mut Cache::default());
                self.capped += usize::from(deep.status == Status::IterationLimit);
                self.stalled += usize::from(deep.status == Status::Stalled);
                self.depth_width.push((deep.depth_upper - deep.depth_lower) / deep.depth_upper);
                match query::contact(&here, parry_a, there, parry_b, 0.0).expect(SUPPORTED) {
                    Some(c) => {
                        self.depth.push(beyond(-f64::from(c.dist), deep.depth_lower, deep.depth_upper) / diameter);
                        let normal = DVec3::from_array(c.normal1.to_array().map(f64::from)).normalize();
                        self.disproved += usize::from(way_out(a, b, placed.b_in_a, normal) < deep.depth_lower);
                    }
                    None => self.parry_no_contact += 1,
                }
            } else {
                let gap = distance(a, b, placed.b_in_a, &settings, &mut Cache::default());
                self.distance_width.push((gap.upper - gap.lower) / gap.upper);
                let parrys = f64::from(query::distance(&here, parry_a, there, parry_b).expect(SUPPORTED).distance);
                self.distance.push(beyond(parrys, gap.lower, gap.upper) / diameter);
            }
        }
    }
}

/// How far B has to move along `normal`, in A's frame and of unit length, to be out of A: by all vertices, in f64.
fn way_out(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose, normal: DVec3) -> f64 {
    let turned = b_in_a.inverse_transform_vector(normal);
    let top = a.vertices().map(|v| v.as_dvec3().dot(normal)).fold(f64::NEG_INFINITY, f64::max);
    let bottom = b.vertices().map(|v| v.as_dvec3().dot(turned)).fold(f64::INFINITY, f64::min);
    top - bottom - b_in_a.translation().dot(normal)
}

/// How far `value` is above (positive) or below (negative) the interval.
fn beyond(value: f64, lower: f64, upper: f64) -> f64 {
    if value > upper {
        value - upper
    } else if value < lower {
        value - lower
    } else {
        0.0
    }
}

/// The 99th percentile and the greatest of what `of` makes of the values; zeros without any.
pub fn p99_and_worst(values: &[f64], of: impl Fn(f64) -> f64) -> [f64; 2] {
    let mut values: Vec<f64> = values.iter().map(|&v| of(v)).collect();
    values.sort_unstable_by(f64::total_cmp);
    match values.last() {
        Some(&worst) => [values[(values.len() - 1) * 99 / 100], worst],
        None => [0.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outside_of_an_interval() {
        assert_eq!([0.5, 1.5, 3.0].map(|v| beyond(v, 1.0, 2.0)), [-0.5, 0.0, 1.0]);
    }

    #[test]
    fn percentiles() {
        let values: Vec<f64> = (0..=100).map(f64::from).collect();
        assert_eq!(p99_and_worst(&values, |v| v), [99.0, 100.0]);
        assert_eq!(p99_and_worst(&values, |v| -v), [-1.0, 0.0]);
        assert_eq!(p99_and_worst(&[], |v| v), [0.0, 0.0]);
    }
}
