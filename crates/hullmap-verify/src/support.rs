//! Whether a hull's support queries are exact, measured against every source point.
//!
//! [`index`](crate::index) has proven that every query finds the support vertex of the stored hull.
//!
//! `regret(d) = (max over the source points of v·d − got·d) / (|d| · diameter)`, in f64 on the
//! stored f32 numbers. A hull that lost a source point has a large regret in that point's
//! directions; a hull with a point that is not in the source has a negative regret. Both are
//! mismatches.

use glam::Vec3;
use rayon::prelude::*;

use crate::directions;
use crate::truth::{Points, dot};
use hullmap::{Cost, Hull, SupportVertex};

/// Maximum regret, relative to the diameter, that counts as exact: twice the certified 1e-7.
pub const REGRET_LIMIT: f64 = 2e-7;

/// Queries that verification requires of a hull.
pub trait SupportQueries: Sync {
    /// A vertex; `None` if the index is out of range.
    fn vertex(&self, index: u32) -> Option<Vec3>;
    /// The support point.
    fn support(&self, dir: Vec3) -> SupportVertex;
    /// Cost of that query.
    fn support_cost(&self, dir: Vec3) -> Cost;
}

impl SupportQueries for Hull<'_> {
    fn vertex(&self, index: u32) -> Option<Vec3> {
        Hull::vertex(self, index)
    }

    fn support(&self, dir: Vec3) -> SupportVertex {
        Hull::support(self, dir)
    }

    fn support_cost(&self, dir: Vec3) -> Cost {
        Hull::support_cost(self, dir)
    }
}

/// Result of testing a hull in many directions.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Maximum absolute regret; infinite if an answer was not a vertex.
    pub max_regret: f64,
    /// Direction of the maximum regret.
    pub worst_direction: Option<Vec3>,
    /// Number of directions whose regret exceeds [`REGRET_LIMIT`] or whose answer is not a vertex.
    pub mismatches: usize,
    /// Number of special directions whose answer is not a vertex.
    pub invalid_answers: usize,
    /// Maximum cost of a query.
    pub cost: Cost,
}

/// Tests a hull in all `directions`, which must be finite and non-zero, and in the special
/// directions. Complexity: O(points · directions), on all threads of the pool.
pub fn measure(hull: &impl SupportQueries, truth: &Points, directions: &[Vec3]) -> Measurement {
    let diameter = truth.diameter();
    let greatest = truth.greatest_dots(directions);
    let answers: Vec<(f64, Cost)> = directions
        .par_iter()
        .zip(&greatest)
        .map(|(&dir, &greatest)| {
            let got = hull.support(dir);
            let regret = if is_vertex(hull, got) { regret(greatest, got.point, dir, diameter) } else { f64::INFINITY };
            (regret, hull.support_cost(dir))
        })
        .collect();

    let specials = directions::special_directions();
    let invalid_answers = specials.iter().filter(|&&dir| !is_vertex(hull, hull.support(dir))).count();
    let mut result =
        Measurement { max_regret: 0.0, worst_direction: None, mismatches: 0, invalid_answers, cost: Cost::default() };
    for (&(regret, cost), &dir) in answers.iter().zip(directions) {
        if regret > REGRET_LIMIT {
            result.mismatches += 1;
        }
        if regret > result.max_regret {
            result.max_regret = regret;
            result.worst_direction = Some(dir);
        }
        result.cost.nodes = result.cost.nodes.max(cost.nodes);
        result.cost.dots = result.cost.dots.max(cost.dots);
    }
    result
}

/// Whether an answer is a vertex of the hull, bit by bit.
fn is_vertex(hull: &impl SupportQueries, got: SupportVertex) -> bool {
    let bits = |point: Vec3| point.to_array().map(f32::to_bits);
    hull.vertex(got.index).is_some_and(|vertex| bits(vertex) == bits(got.point))
}

/// Absolute regret; infinite if it is NaN.
fn regret(greatest: f64, got: Vec3, dir: Vec3, diameter: f64) -> f64 {
    let dir = dir.to_array().map(f64::from);
    let loss = greatest - dot(got.to_array().map(f64::from), dir);
    if loss == 0.0 {
        return 0.0;
    }
    let regret = (loss / (dot(dir, dir).sqrt() * diameter)).abs();
    // NaN must not read as a small number.
    if regret.is_nan() { f64::INFINITY } else { regret }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::directions;
    use crate::random::SplitMix;

    /// A hull that answers by brute force, with one answer bent by `bend`.
    struct Cloud<F> {
        vertices: Vec<Vec3>,
        bend: F,
    }

    impl<F: Fn(Vec3, SupportVertex) -> SupportVertex + Sync> SupportQueries for Cloud<F> {
        fn vertex(&self, index: u32) -> Option<Vec3> {
            self.vertices.get(index as usize).copied()
        }

        fn support(&self, dir: Vec3) -> SupportVertex {
            let scores = self.vertices.iter().map(|v| v.as_dvec3().dot(dir.as_dvec3())).enumerate();
            let best = scores.fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best });
            (self.bend)(dir, SupportVertex { point: self.vertices[best.0], index: best.0 as u32 })
        }

        fn support_cost(&self, dir: Vec3) -> Cost {
            Cost { nodes: 3, dots: if dir.x > 0.0 { 8 } else { 4 } }
        }
    }

    fn honest(_: Vec3, point: SupportVertex) -> SupportVertex {
        point
    }

    fn sphere(count: usize) -> Vec<Vec3> {
        let mut random = SplitMix::new(5);
        (0..count).map(|_| random.in_ball().normalize()).collect()
    }

    fn points(vertices: &[Vec3]) -> Points {
        Points::new(&vertices.iter().map(|v| v.to_array()).collect::<Vec<_>>())
    }

    fn try_out(hull: &impl SupportQueries, source: &[Vec3]) -> Measurement {
        measure(hull, &points(source), &directions(source, &[], 4000, 1))
    }

    #[test]
    fn only_a_hull_of_the_same_points_has_no_regret() {
        let source = sphere(200);
        let of = |vertices: Vec<Vec3>| try_out(&Cloud { vertices, bend: honest }, &source);
        let exact = of(source.clone());
        assert!(exact.max_regret < 1e-15, "{}", exact.max_regret);
        assert_eq!((exact.mismatches, exact.invalid_answers), (0, 0));
        assert_eq!(exact.cost, Cost { nodes: 3, dots: 8 });
        let lost = of(source[1..].to_vec());
        assert!(lost.mismatches > 0 && lost.max_regret > 1e-4, "{lost:?}");
        assert!(lost.worst_direction.unwrap().normalize().dot(source[0]) > 0.9);
        let own = of([source.as_slice(), &[Vec3::new(1.01, 0.0, 0.0)]].concat());
        assert!(own.mismatches > 0, "{own:?}");
    }

    #[test]
    fn answers_that_are_no_vertex_fail() {
        let source = sphere(50);
        let moved = |_: Vec3, got: SupportVertex| SupportVertex { point: got.point * 1.000_001, ..got };
        let result = try_out(&Cloud { vertices: source.clone(), bend: moved }, &source);
        assert_eq!((result.mismatches, result.max_regret), (4000, f64::INFINITY));
        let nan_only = |dir: Vec3, got: SupportVertex| {
            if dir.is_nan() { SupportVertex { index: 50, ..got } } else { got }
        };
        let result = try_out(&Cloud { vertices: source.clone(), bend: nan_only }, &source);
        assert_eq!(result.mismatches, 0);
        assert!(result.invalid_answers > 0);
    }

    #[test]
    fn a_single_point_is_exact() {
        let source = [Vec3::new(1.0, 2.0, 3.0)];
        let result = try_out(&Cloud { vertices: source.to_vec(), bend: honest }, &source);
        assert_eq!((result.mismatches, result.max_regret), (0, 0.0));
        let far = [Vec3::new(1.0, 2.0, 4.0)];
        assert!(try_out(&Cloud { vertices: far.to_vec(), bend: honest }, &source).mismatches > 3000);
    }

    #[test]
    fn regret_does_not_depend_on_scale() {
        let source = sphere(100);
        let regret_at = |scale: f32| {
            let scaled: Vec<Vec3> = source.iter().map(|&v| v * scale).collect();
            try_out(&Cloud { vertices: scaled[1..].to_vec(), bend: honest }, &scaled).max_regret
        };
        assert!((regret_at(1024.0) / regret_at(1.0) - 1.0).abs() < 1e-9);
    }
}
