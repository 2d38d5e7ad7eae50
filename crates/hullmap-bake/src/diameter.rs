//! Diameter of a point set: the maximum distance between two of its points, by dual-tree search.
//!
//! Two groups of points can contain a farther pair only if the far corners of their bounding boxes
//! are farther from each other. Groups are halved recursively, and the more promising pair of
//! groups is searched first, until the boxes rule out all other pairs.

use glam::DVec3;

/// Maximum number of points in a group that is not halved further.
const GROUP: usize = 16;

/// Maximum distance between two of `points`; 0 for fewer than two. It equals the maximum over all
/// pairs, computed in f64.
///
/// # Complexity
/// O(n log n) on typical hulls; quadratic at worst.
pub fn diameter(points: &[DVec3]) -> f64 {
    if points.len() < 2 {
        return 0.0;
    }
    let mut points = points.to_vec();
    let root = Group::new(&mut points);
    let mut best_sq = 0.0;
    farther(&root, &root, &mut best_sq);
    best_sq.sqrt()
}

struct Group<'a> {
    low: DVec3,
    high: DVec3,
    points: &'a [DVec3],
    halves: Option<Box<[Group<'a>; 2]>>,
}

impl<'a> Group<'a> {
    fn new(points: &'a mut [DVec3]) -> Self {
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        if points.len() <= GROUP {
            return Self { low, high, points, halves: None };
        }
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        let (left, right) = points.split_at_mut(middle);
        let halves = Some(Box::new([Group::new(left), Group::new(right)]));
        Self { low, high, points: &[], halves }
    }

    /// Square of the maximum distance between a point of one box and a point of the other.
    fn reach_sq(&self, other: &Self) -> f64 {
        (self.high - other.low).max(other.high - self.low).length_squared()
    }

    fn is_larger(&self, other: &Self) -> bool {
        (self.high - self.low).length_squared() > (other.high - other.low).length_squared()
    }
}

fn farther(a: &Group, b: &Group, best_sq: &mut f64) {
    if a.reach_sq(b) <= *best_sq {
        return;
    }
    let (split, whole, halves) = match (&a.halves, &b.halves) {
        (None, None) => {
            for p in a.points {
                for q in b.points {
                    *best_sq = best_sq.max(p.distance_squared(*q));
                }
            }
            return;
        }
        (Some(halves), None) => (a, b, halves),
        (None, Some(halves)) => (b, a, halves),
        (Some(of_a), Some(of_b)) => {
            if b.is_larger(a) {
                (b, a, of_b)
            } else {
                (a, b, of_a)
            }
        }
    };
    debug_assert!(split.halves.is_some());
    let [left, right] = &**halves;
    let (first, second) = if right.reach_sq(whole) > left.reach_sq(whole) { (right, left) } else { (left, right) };
    farther(first, whole, best_sq);
    farther(second, whole, best_sq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use shapes::families::Family;

    #[test]
    fn agrees_with_all_pairs() {
        for (n, seed) in [(8, 1), (17, 2), (400, 3), (2000, 4)] {
            for family in [Family::Sphere, Family::Ball] {
                let points: Vec<DVec3> =
                    family.points(n, seed).iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
                let slow = points
                    .iter()
                    .flat_map(|p| points.iter().map(|q| p.distance_squared(*q)))
                    .fold(0.0, f64::max)
                    .sqrt();
                assert_eq!(diameter(&points), slow, "n {n}, seed {seed}");
            }
        }
    }
}
