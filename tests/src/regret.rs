//! Regret of a support query: the maximum dot product over all source points, in f64, independent
//! of the hull.
//!
//! Points are sorted into boxes of neighbours. A box's bound is the dot product with its farthest
//! corner, computed by the same operations in the same order. Rounding is monotonic, so no computed
//! dot product of a point in the box is greater. Boxes that cannot contain the maximum are skipped,
//! with the same result as testing every point.

use glam::{DVec3, Vec3};

/// Maximum number of points of a box.
const BOX: usize = 16;

/// The source points, in boxes.
pub struct Truth {
    boxes: Vec<(DVec3, DVec3, Vec<DVec3>)>,
    /// At most the maximum distance between two points, and at least half of it.
    pub diameter: f64,
    /// Greatest magnitude of a coordinate.
    pub reach: f64,
}

impl Truth {
    /// Takes the source points.
    pub fn new(points: &[[f32; 3]]) -> Self {
        let mut points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let far = |from: DVec3| {
            points.iter().copied().max_by(|p, q| p.distance(from).total_cmp(&q.distance(from))).unwrap_or(from)
        };
        let end = far(points[0]);
        let diameter = end.distance(far(end));
        let reach = points.iter().fold(0.0, |reach: f64, p| reach.max(p.abs().max_element()));
        let mut boxes = Vec::new();
        split(&mut points, &mut boxes);
        Self { boxes, diameter, reach }
    }

    /// The maximum dot product of any source point with `d`.
    pub fn greatest(&self, d: DVec3) -> f64 {
        let bound = |low: DVec3, high: DVec3| dot(DVec3::select(d.cmpge(DVec3::ZERO), high, low), d);
        let mut first = (f64::NEG_INFINITY, 0);
        let bounds: Vec<f64> = self.boxes.iter().map(|(low, high, _)| bound(*low, *high)).collect();
        for (index, bound) in bounds.iter().enumerate() {
            if *bound > first.0 {
                first = (*bound, index);
            }
        }
        let within = |index: usize| self.boxes[index].2.iter().fold(f64::NEG_INFINITY, |best, p| best.max(dot(*p, d)));
        let mut greatest = within(first.1);
        for (index, bound) in bounds.iter().enumerate() {
            if *bound > greatest {
                greatest = greatest.max(within(index));
            }
        }
        greatest
    }

    /// Regret of a support query: maximum dot product minus `dir · got`, over |dir| · diameter.
    /// 0 for an invalid direction, and where all points are the same.
    pub fn regret(&self, dir: Vec3, got: Vec3) -> f64 {
        self.in_direction(dir.as_dvec3()).map_or(0.0, |truth| truth.regret(got.as_dvec3()))
    }

    /// The maximum dot product in one direction of any length; `None` for an invalid direction.
    pub fn in_direction(&self, d: DVec3) -> Option<Greatest> {
        if !d.is_finite() || d == DVec3::ZERO {
            return None;
        }
        // Scaling by a power of two is exact.
        let d = d * (-f64::from(d.abs().max_element().log2().floor() as i32)).exp2();
        Some(Greatest { d, greatest: self.greatest(d), size: d.length() * self.diameter })
    }
}

/// The maximum dot product in one direction.
pub struct Greatest {
    d: DVec3,
    greatest: f64,
    /// Length of the direction times the diameter.
    size: f64,
}

impl Greatest {
    /// (greatest − own dot product of `got`) / (|d| · diameter); 0 where all points are the same.
    pub fn regret(&self, got: DVec3) -> f64 {
        if self.size == 0.0 { 0.0 } else { (self.greatest - dot(got, self.d)) / self.size }
    }
}

/// Sums in the order of the coordinates.
fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

fn split(points: &mut [DVec3], boxes: &mut Vec<(DVec3, DVec3, Vec<DVec3>)>) {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    if points.len() <= BOX {
        return boxes.push((low, high, points.to_vec()));
    }
    let axis = (high - low).max_position();
    let half = points.len() / 2;
    points.select_nth_unstable_by(half, |p, q| p[axis].total_cmp(&q[axis]));
    let (lower, upper) = points.split_at_mut(half);
    split(lower, boxes);
    split(upper, boxes);
}

#[cfg(test)]
mod tests {
    use shapes::{families::Family, rng::SplitMix64};

    use super::*;

    #[test]
    fn skipping_boxes_skips_no_point() {
        let mut rng = SplitMix64::new(3);
        for family in [Family::Ball, Family::CubeGrid, Family::Prism] {
            let points = family.points(500, 1);
            let truth = Truth::new(&points);
            for round in 0..2_000 {
                let mut d = DVec3::from_array(rng.direction());
                d[round % 3] *= [1.0, 0.0, 1e-9][round / 3 % 3];
                let slow = points.iter().map(|p| dot(DVec3::from_array(p.map(f64::from)), d)).fold(f64::MIN, f64::max);
                assert_eq!(truth.greatest(d), slow);
            }
        }
    }
}
