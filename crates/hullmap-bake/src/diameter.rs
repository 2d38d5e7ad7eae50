//! Diameter of a point set: the maximum distance between two of its points, by dual-tree search.
//!
//! 1. Halve the points recursively into groups.
//! 2. Two groups can contain a farther pair only if a bound on the distance between their points
//!    exceeds the distance found so far. Search the more promising pair of groups first, until the
//!    bounds rule out all other pairs.
//!
//! There are two bounds, and the smaller one counts:
//!
//! - the distance between the far corners of the groups' bounding boxes;
//! - the distance as seen from a common centre: groups that are not opposite each other have no
//!   pair as long as the sum of their radii. On a sphere, the boxes alone take n^1.5 steps.

use glam::DVec3;
use hullmap_geometry::bounds;

const GROUP: usize = 16;

/// Relative margin of the second bound: far more than its rounding error, and far less than the
/// rounding error of f32 coordinates.
const MARGIN: f64 = 1e-9;

/// Minimum cosine of a cone's half angle. The directions of a wider cone rule out nothing.
const NARROW: f64 = 0.8;

/// Maximum distance between two of `points`; 0 for fewer than two. It equals the maximum over all
/// pairs, computed in f64.
///
/// # Complexity
/// O(n log n) on typical hulls and on round ones; quadratic at worst.
pub fn diameter(points: &[DVec3]) -> f64 {
    search(points).best_sq.sqrt()
}

#[derive(Default)]
struct DiameterSearch {
    best_sq: f64,
    work: usize,
}

fn search(points: &[DVec3]) -> DiameterSearch {
    let mut search = DiameterSearch::default();
    if points.len() >= 2 {
        let mut points = points.to_vec();
        let [low, high] = bounds(points.iter().copied());
        let root = Group::new(&mut points, (low + high) * 0.5);
        search.farther(&root, &root);
    }
    search
}

struct Group<'a> {
    low: DVec3,
    high: DVec3,
    cone: Cone,
    points: &'a [DVec3],
    halves: Option<Box<[Group<'a>; 2]>>,
}

/// A cone with its apex in the common centre that contains a group's points.
struct Cone {
    radius: f64,
    axis: DVec3,
    cos: f64,
    sin: f64,
}

impl Cone {
    fn new(points: &[DVec3], centre: DVec3) -> Self {
        let sum: DVec3 = points.iter().map(|p| *p - centre).sum();
        let axis = sum.normalize_or_zero();
        let radius = points.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
        let along = |p: &DVec3| (*p - centre).normalize_or_zero().dot(axis);
        let cos = points.iter().map(along).fold(1.0, f64::min);
        Self { radius, axis, cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
    }

    /// Bound on the square of the distance between a point of one cone and a point of the other.
    fn reach_sq(&self, other: &Self) -> f64 {
        let (a, b) = (self.radius, other.radius);
        // Written so that NaN gives the full length.
        let cos = if self.cos > NARROW && other.cos > NARROW {
            // Cosines of the angle between one axis and the other's opposite, and of both half
            // angles together.
            let (apart, wide) = (-self.axis.dot(other.axis), self.cos * other.cos - self.sin * other.sin);
            if apart >= wide {
                1.0
            } else {
                let sines = (1.0 - apart * apart).max(0.0).sqrt() * (self.sin * other.cos + self.cos * other.sin);
                (apart * wide + sines).max(0.0)
            }
        } else {
            1.0
        };
        (a * a + b * b + 2.0 * a * b * cos) * (1.0 + MARGIN)
    }
}

impl<'a> Group<'a> {
    fn new(points: &'a mut [DVec3], centre: DVec3) -> Self {
        let [low, high] = bounds(points.iter().copied());
        let cone = Cone::new(points, centre);
        if points.len() <= GROUP {
            return Self { low, high, cone, points, halves: None };
        }
        let axis = (high - low).max_position();
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        let (left, right) = points.split_at_mut(middle);
        let halves = Some(Box::new([Group::new(left, centre), Group::new(right, centre)]));
        Self { low, high, cone, points: &[], halves }
    }

    fn reach_sq(&self, other: &Self) -> f64 {
        let boxes = (self.high - other.low).max(other.high - self.low).length_squared();
        boxes.min(self.cone.reach_sq(&other.cone))
    }

    fn is_larger(&self, other: &Self) -> bool {
        (self.high - self.low).length_squared() > (other.high - other.low).length_squared()
    }
}

impl DiameterSearch {
    fn farther(&mut self, a: &Group, b: &Group) {
        self.work += 1;
        if a.reach_sq(b) <= self.best_sq {
            return;
        }
        let (whole, halves) = match (&a.halves, &b.halves) {
            (None, None) => {
                self.work += a.points.len() * b.points.len();
                for p in a.points {
                    for q in b.points {
                        self.best_sq = self.best_sq.max(p.distance_squared(*q));
                    }
                }
                return;
            }
            (Some(halves), None) => (b, halves),
            (None, Some(halves)) => (a, halves),
            (Some(of_a), Some(of_b)) => {
                if b.is_larger(a) {
                    (a, of_b)
                } else {
                    (b, of_a)
                }
            }
        };
        let [left, right] = &**halves;
        let (first, second) = if right.reach_sq(whole) > left.reach_sq(whole) { (right, left) } else { (left, right) };
        self.farther(first, whole);
        self.farther(second, whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shapes::families::Family;

    fn points(family: Family, n: usize, seed: u64) -> Vec<DVec3> {
        family.points(n, seed).iter().map(|p| DVec3::from_array(p.map(f64::from))).collect()
    }

    fn slow(points: &[DVec3]) -> f64 {
        points.iter().flat_map(|p| points.iter().map(|q| p.distance_squared(*q))).fold(0.0, f64::max).sqrt()
    }

    #[test]
    fn agrees_with_all_pairs() {
        for (n, seed) in [(8, 1), (17, 2), (400, 3), (2000, 4)] {
            for family in Family::ALL {
                let points = points(family, n, seed);
                let expected = slow(&points);
                assert_eq!(diameter(&points), expected, "{family:?}, n {n}, seed {seed}");
                let far: Vec<DVec3> = points.iter().map(|p| *p * 1e-3 + DVec3::splat(1000.0)).collect();
                assert_eq!(diameter(&far), slow(&far), "{family:?} far away, n {n}, seed {seed}");
            }
        }
    }

    /// Every point of these has a partner at nearly the same distance.
    #[test]
    fn the_work_on_round_shapes_is_not_quadratic() {
        for family in [Family::Sphere, Family::UvSphere, Family::Prism, Family::RotatedPrism, Family::Lens] {
            let [small, large] = [4_000, 32_000].map(|n| search(&points(family, n, 5)).work);
            let exponent = (large as f64 / small as f64).log(8.0);
            println!("{family:?}: {small} and {large} comparisons, exponent {exponent:.2}");
            assert!(exponent < 1.25, "{family:?}: {exponent}");
        }
    }
}
