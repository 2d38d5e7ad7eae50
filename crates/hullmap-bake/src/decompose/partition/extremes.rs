//! Farthest points along fixed directions, of groups of points. The extremes of several groups are
//! the extremes of their union, so that a trial need not visit every point again.

use std::sync::LazyLock;

use glam::DVec3;

/// Number of steps from the middle of the grid of directions to its border, along each axis.
const STEPS: i32 = 2;

const COUNT: usize = 98;

/// Step from one direction of the grid to the next that is compared: few are enough to tell that a
/// point is far out if they lead to all sides. It has no divisor in common with the count.
const STRIDE: usize = 37;

/// Length of the longest direction, rounded up.
const LONGEST: f64 = 3.5;

static DIRECTIONS: LazyLock<[[f64; COUNT]; 3]> = LazyLock::new(|| {
    let all = || -STEPS..=STEPS;
    let grid = all().flat_map(|x| all().flat_map(move |y| all().map(move |z| [x, y, z])));
    let mut found = [[0.0; COUNT]; 3];
    for (k, at) in grid.filter(|at| at.iter().any(|c| c.abs() == STEPS)).enumerate() {
        for axis in 0..3 {
            found[axis][k * STRIDE % COUNT] = f64::from(at[axis]);
        }
    }
    found
});

/// The farthest points of a group along the directions of a grid; of equally far ones, the first.
#[derive(Clone, Debug)]
pub struct Extremes {
    /// How far they are: the products with the directions, which are not of unit length.
    reach: [f64; COUNT],
    at: [[f64; COUNT]; 3],
}

impl Extremes {
    /// The extremes of an empty group.
    pub const EMPTY: Self = Self { reach: [f64::NEG_INFINITY; COUNT], at: [[0.0; COUNT]; 3] };

    /// The extremes of points.
    pub fn from_points(points: &[DVec3]) -> Self {
        let mut extremes = Self::EMPTY;
        for p in points {
            extremes.add(*p);
        }
        extremes
    }

    /// Adds a point.
    pub fn add(&mut self, p: DVec3) {
        let [x, y, z] = &*DIRECTIONS;
        for k in 0..COUNT {
            let along = x[k] * p.x + y[k] * p.y + z[k] * p.z;
            let is_farther = along > self.reach[k];
            self.reach[k] = if is_farther { along } else { self.reach[k] };
            for (at, own) in self.at.iter_mut().zip(p.to_array()) {
                at[k] = if is_farther { own } else { at[k] };
            }
        }
    }

    /// Adds the points of another group. They come after the points of this group.
    pub fn add_all(&mut self, other: &Self) {
        for k in 0..COUNT {
            let is_farther = other.reach[k] > self.reach[k];
            self.reach[k] = if is_farther { other.reach[k] } else { self.reach[k] };
            for (at, own) in self.at.iter_mut().zip(&other.at) {
                at[k] = if is_farther { own[k] } else { at[k] };
            }
        }
    }

    /// Whether a point is at most `slack` beyond the farthest ones along all directions; a
    /// necessary condition for being in the hull.
    pub fn may_hold(&self, p: DVec3, slack: f64) -> bool {
        let [x, y, z] = &*DIRECTIONS;
        let reach = self.reach.iter().enumerate();
        reach.into_iter().all(|(k, reach)| x[k] * p.x + y[k] * p.y + z[k] * p.z <= reach + LONGEST * slack)
    }

    /// The points, with repetitions.
    pub fn points(&self) -> Vec<DVec3> {
        self.along(|_| true)
    }

    /// The points along the 26 directions to a cube's corners, edges and faces.
    pub fn few_points(&self) -> Vec<DVec3> {
        let [x, y, z] = &*DIRECTIONS;
        self.along(|k| [x[k], y[k], z[k]].iter().all(|c| c.abs() != 1.0))
    }

    fn along(&self, is_wanted: impl Fn(usize) -> bool) -> Vec<DVec3> {
        let [x, y, z] = &self.at;
        (0..COUNT).filter(|k| is_wanted(*k)).map(|k| DVec3::new(x[k], y[k], z[k])).collect()
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn extremes_of_groups_are_those_of_all_points() {
        let seed = 4;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let mut ties = 0;
        for round in 0..40 {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| (rng.between(-2.0, 2.0) * 4.0).round() / 4.0));
            let groups: Vec<Vec<DVec3>> = (0..5).map(|k| (0..k * 7).map(|_| point()).collect()).collect();
            let points = groups.concat();
            let mut found = Extremes::EMPTY;
            groups.iter().for_each(|group| found.add_all(&Extremes::from_points(group)));
            let [x, y, z] = &*DIRECTIONS;
            for (k, p) in found.points().iter().enumerate() {
                let along = |p: &DVec3| DVec3::new(x[k], y[k], z[k]).dot(*p);
                let reach = points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
                let farthest: Vec<&DVec3> = points.iter().filter(|p| along(p) == reach).collect();
                assert_eq!(p, farthest[0], "round {round}, direction {k}");
                ties += usize::from(farthest.iter().any(|p| *p != farthest[0]));
            }
            assert!(found.few_points().iter().all(|p| found.points().contains(p)));
            assert_eq!(found.few_points().len(), 26);
            // No point of the hull is beyond them.
            for pair in points.windows(2) {
                let p = pair[0].lerp(pair[1], 0.3);
                assert!(found.may_hold(p, 1e-12), "round {round}: {p}");
            }
            assert!(!found.may_hold(DVec3::splat(2.5), 0.0));
        }
        assert!(ties > 500, "{ties}");
    }
}
