//! The truth about support: brute force over every point, in f64.
//!
//! Coordinates and directions are f32; their products are exact in f64, and each dot product carries two roundings of
//! 1.1e-16. Points that equal an earlier one are left out, which cannot change a maximum; nothing else is.

use glam::Vec3;
use rayon::prelude::*;

/// Points that are handled together, so that the compiler can use vector registers.
const LANES: usize = 4;

/// Directions that share one pass over the points.
const DIRECTIONS_A_PASS: usize = 4;

/// Points as columns of f64.
#[derive(Debug)]
pub struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Points {
    /// The points, which must be finite and at least one.
    ///
    /// # Panics
    /// Without points.
    pub fn new(positions: &[[f32; 3]]) -> Self {
        assert!(!positions.is_empty(), "the truth needs at least one point");
        // Adding +0 turns -0 into +0, so that the two compare equal bit by bit.
        let mut distinct: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x + 0.0)).collect();
        distinct.sort_unstable_by_key(|p| p.map(f32::to_bits));
        distinct.dedup();
        // Whole groups of LANES; the last point again cannot change a maximum.
        let last = distinct[distinct.len() - 1];
        distinct.resize(distinct.len().next_multiple_of(LANES), last);
        let column = |axis: usize| distinct.iter().map(|p| f64::from(p[axis])).collect();
        Self {
            x: column(0),
            y: column(1),
            z: column(2),
        }
    }

    /// For each direction the greatest dot product with any point. Directions must be finite.
    ///
    /// # Complexity
    /// O(points · directions), on all threads of the pool.
    pub fn greatest_dots(&self, directions: &[Vec3]) -> Vec<f64> {
        let passes = directions.par_chunks(DIRECTIONS_A_PASS);
        passes
            .flat_map_iter(|chunk| {
                let mut block = [[0.0; 3]; DIRECTIONS_A_PASS];
                for (slot, dir) in block.iter_mut().zip(chunk) {
                    *slot = dir.to_array().map(f64::from);
                }
                self.pass(&block).into_iter().take(chunk.len())
            })
            .collect()
    }

    fn pass(&self, directions: &[[f64; 3]; DIRECTIONS_A_PASS]) -> [f64; DIRECTIONS_A_PASS] {
        let mut best = [[f64::NEG_INFINITY; LANES]; DIRECTIONS_A_PASS];
        let (x, _) = self.x.as_chunks::<LANES>();
        let (y, _) = self.y.as_chunks::<LANES>();
        let (z, _) = self.z.as_chunks::<LANES>();
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            for (best, &[dx, dy, dz]) in best.iter_mut().zip(directions) {
                for lane in 0..LANES {
                    let dot = x[lane] * dx + y[lane] * dy + z[lane] * dz;
                    // Not f64::max: its care for NaN, of which there is none here, costs a third of the time.
                    best[lane] = if dot > best[lane] { dot } else { best[lane] };
                }
            }
        }
        best.map(|lanes| lanes.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// A distance between two of the points that is the greatest, or close to it, and never more.
    ///
    /// From several extreme points it walks to the farthest point until that brings nothing. A regret relative to it
    /// is thus never understated.
    pub fn diameter(&self) -> f64 {
        let mut greatest = 0.0_f64;
        for dir in [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [1.0, -1.0, 0.5],
        ] {
            let mut from = self.argmax(|p| dot(p, dir));
            let mut reach = -1.0;
            loop {
                let to = self.argmax(|p| distance_sq(p, from));
                // Strictly growing over finitely many pairs, so this ends.
                if distance_sq(to, from) > reach {
                    reach = distance_sq(to, from);
                    from = to;
                } else {
                    break;
                }
            }
            greatest = greatest.max(reach.sqrt());
        }
        greatest
    }

    fn argmax(&self, score: impl Fn([f64; 3]) -> f64) -> [f64; 3] {
        let point = |i: usize| [self.x[i], self.y[i], self.z[i]];
        let best = (0..self.x.len()).map(|i| (score(point(i)), i));
        let (_, index) = best.fold((f64::NEG_INFINITY, 0), |best, next| {
            if next.0 > best.0 { next } else { best }
        });
        point(index)
    }
}

/// Dot product with the operations, and their order, of [`Points::greatest_dots`].
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance_sq(a: [f64; 3], b: [f64; 3]) -> f64 {
    let gap = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(gap, gap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verification::directions::SplitMix;

    /// The same maximum, one dot product after the other.
    fn slow(positions: &[[f32; 3]], dir: Vec3) -> f64 {
        let dir = dir.to_array().map(f64::from);
        positions
            .iter()
            .map(|p| dot(p.map(f64::from), dir))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn fast_truth_is_the_slow_one_bit_by_bit() {
        let mut random = SplitMix::new(1);
        for count in [1, 2, 3, 4, 5, 7, 8, 9, 100, 1001] {
            let mut positions: Vec<[f32; 3]> =
                (0..count).map(|_| random.in_ball().to_array()).collect();
            positions.push(positions[0]);
            let directions: Vec<Vec3> = (0..13).map(|_| random.in_ball()).collect();
            let fast = Points::new(&positions).greatest_dots(&directions);
            assert_eq!(fast.len(), directions.len());
            for (fast, &dir) in fast.iter().zip(&directions) {
                assert_eq!(
                    fast.to_bits(),
                    slow(&positions, dir).to_bits(),
                    "{count} points, {dir}"
                );
            }
        }
    }

    #[test]
    fn diameter_is_that_of_all_pairs_on_random_clouds() {
        let mut random = SplitMix::new(2);
        for _ in 0..50 {
            let positions: Vec<[f32; 3]> = (0..60).map(|_| random.in_ball().to_array()).collect();
            let pairs = positions
                .iter()
                .flat_map(|a| positions.iter().map(move |b| (a, b)));
            let slow = pairs
                .map(|(a, b)| distance_sq(a.map(f64::from), b.map(f64::from)).sqrt())
                .fold(0.0, f64::max);
            let fast = Points::new(&positions).diameter();
            assert!(fast <= slow && fast > 0.9 * slow, "{fast} {slow}");
        }
    }

    #[test]
    fn diameter_of_a_point_is_zero() {
        assert_eq!(Points::new(&[[1.0, 2.0, 3.0]; 3]).diameter(), 0.0);
    }

    #[test]
    #[ignore = "a measurement: cargo test --release -p bake -- --ignored --nocapture speed"]
    fn speed_of_the_truth() {
        let mut random = SplitMix::new(3);
        let positions: Vec<[f32; 3]> = (0..50_000).map(|_| random.in_ball().to_array()).collect();
        let directions: Vec<Vec3> = (0..200_000).map(|_| random.in_ball()).collect();
        let points = Points::new(&positions);
        let start = std::time::Instant::now();
        let sum: f64 = points.greatest_dots(&directions).iter().sum();
        println!(
            "200,000 directions over 50,000 points: {:?} ({sum})",
            start.elapsed()
        );
    }
}
