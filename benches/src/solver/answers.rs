//! hullmap's answers compared with parry's. Lengths are relative to the mean diameter of the pair.
//!
//! If the depths differ, parry's normal decides: the distance by which B moves out of A along any
//! direction is an upper bound of the depth. It follows from the vertices alone, in f64.

use glam::DVec3;
use hullmap::{Cache, Settings, Status, contact, distance, intersects};
use hullmap_testkit::reach::{self, way_out};
use parry3d::{math, query};

use super::{
    engines::SUPPORTED,
    pairs::{BakedPair, Placed},
};

/// Differences over all pairs of one vertex count.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Number of pairs.
    pub pairs: usize,
    /// Pairs that overlap, by hullmap's answer.
    pub hits: usize,
    /// Pairs on which `intersection_test` disagrees with hullmap.
    pub parry_yes_no: usize,
    /// Overlapping pairs for which parry returns no contact.
    pub parry_no_contact: usize,
    /// Excess of parry's depth above (positive) or below (negative) the interval; 0 inside it.
    pub depth: Vec<f64>,
    /// Excess of parry's distance above (positive) or below (negative) the interval; 0 inside it.
    pub distance: Vec<f64>,
    /// Widths of the depth intervals, relative to their upper bounds.
    pub depth_width: Vec<f64>,
    /// Widths of the distance intervals, relative to their upper bounds.
    pub distance_width: Vec<f64>,
    /// Pairs for which parry's normal proves hullmap's lower bound of the depth wrong. Must be 0.
    pub disproved: usize,
    /// Contacts of hullmap that ended at a limit.
    pub limited: usize,
    /// Contacts of hullmap that rounding error stopped.
    pub stalled: usize,
}

impl Differences {
    /// Compares both engines on all `poses`.
    pub fn add(&mut self, pair: &BakedPair, poses: &[Placed]) {
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
                self.limited += usize::from(deep.status == Status::IterationLimit);
                self.stalled += usize::from(deep.status == Status::Stalled);
                self.depth_width.push((deep.depth_upper - deep.depth_lower) / deep.depth_upper);
                match query::contact(&here, parry_a, there, parry_b, 0.0).expect(SUPPORTED) {
                    Some(c) => {
                        self.depth.push(beyond(-f64::from(c.dist), deep.depth_lower, deep.depth_upper) / diameter);
                        let normal = DVec3::from_array(c.normal1.to_array().map(f64::from)).normalize();
                        self.disproved +=
                            usize::from(way_out(a, &reach::Placed::new(b, placed.b_in_a), normal) < deep.depth_lower);
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

    /// All measures by name; errors with their 99th percentile and their maximum.
    pub fn measures(&self) -> Vec<(String, String)> {
        let (above, below, width) = (|v: f64| v.max(0.0), |v: f64| (-v).max(0.0), |v: f64| v);
        let errors = [
            ("parry's depth above the interval", p99_and_worst(&self.depth, above)),
            ("parry's depth below the interval", p99_and_worst(&self.depth, below)),
            ("parry's distance above the interval", p99_and_worst(&self.distance, above)),
            ("parry's distance below the interval", p99_and_worst(&self.distance, below)),
            ("relative width of hullmap's depth interval", p99_and_worst(&self.depth_width, width)),
            ("relative width of hullmap's distance interval", p99_and_worst(&self.distance_width, width)),
        ];
        let counts = [
            ("pairs", self.pairs),
            ("pairs that overlap", self.hits),
            ("parry's yes/no differs", self.parry_yes_no),
            ("parry finds no contact for an overlapping pair", self.parry_no_contact),
            ("hullmap's depths disproved by parry's normal", self.disproved),
            ("hullmap's contacts that reached a limit", self.limited),
            ("hullmap's contacts stopped by rounding error", self.stalled),
        ];
        let errors = errors.into_iter().flat_map(|(name, values)| {
            [": p99", ": worst"]
                .into_iter()
                .zip(values)
                .map(move |(of, value)| (format!("{name}{of}"), format!("{value:.2e}")))
        });
        errors.chain(counts.map(|(name, count)| (name.to_owned(), count.to_string()))).collect()
    }
}

/// Excess of `value` above (positive) or below (negative) the interval; 0 inside it.
fn beyond(value: f64, lower: f64, upper: f64) -> f64 {
    (value - upper).max(0.0) + (value - lower).min(0.0)
}

/// The 99th percentile and the maximum of `of(value)`; zeros without values.
fn p99_and_worst(values: &[f64], of: impl Fn(f64) -> f64) -> [f64; 2] {
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
    fn beyond_is_zero_inside_the_interval() {
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
