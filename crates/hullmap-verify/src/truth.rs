//! Reference support values: the maximum dot product over every point, in f64.
//!
//! Products of f32 are exact in f64, and each dot product carries two roundings of 1.1e-16. The
//! result equals a plain scan's (except for the sign of a zero), but is computed faster:
//!
//! 1. Duplicate points are dropped, and the others sorted along a Morton curve, in blocks.
//! 2. For a direction, every block gets a bound: the dot product with the farthest corner of its
//!    box. Addition is monotone, so in the same order of operations no point of the block has a
//!    *computed* dot product above it.
//! 3. The block with the maximum bound is scanned, then every other with a bound above the best.
//!
//! This module does not use the hull, so that it cannot repeat the baker's mistakes.

use glam::Vec3;
use rayon::prelude::*;

/// Points in a block: scanning few blocks and bounding many cost about the same.
const BLOCK: usize = 32;

const MORTON_BITS: u32 = 10;

const DIRECTIONS_A_TASK: usize = 64;

/// Points as columns of f64, in blocks of neighbours.
#[derive(Debug)]
pub struct Points {
    /// Coordinates by axis; whole blocks.
    columns: [Vec<f64>; 3],
    /// Minimum coordinates of each block by axis.
    low: [Vec<f64>; 3],
    /// Maximum coordinates of each block by axis.
    high: [Vec<f64>; 3],
}

impl Points {
    /// Points, at least one, all finite. Panics without points.
    pub fn new(positions: &[[f32; 3]]) -> Self {
        assert!(!positions.is_empty(), "the truth needs at least one point");
        // Adding +0 turns -0 into +0, so that the two compare equal bit by bit.
        let mut distinct: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x + 0.0)).collect();
        distinct.sort_unstable_by_key(|p| p.map(f32::to_bits));
        distinct.dedup();
        sort_along_morton_curve(&mut distinct);
        // Fill the last block: repeating a point cannot change a maximum.
        let last = distinct[distinct.len() - 1];
        distinct.resize(distinct.len().next_multiple_of(BLOCK), last);

        let columns = [0, 1, 2].map(|axis| distinct.iter().map(|p| f64::from(p[axis])).collect::<Vec<f64>>());
        let bound = |start: f64, choose: fn(f64, f64) -> f64| {
            let of_block = |block: &[f64]| block.iter().copied().fold(start, choose);
            columns.each_ref().map(|column| column.chunks(BLOCK).map(of_block).collect())
        };
        let (low, high) = (bound(f64::INFINITY, f64::min), bound(f64::NEG_INFINITY, f64::max));
        Self { columns, low, high }
    }

    /// For each finite direction, the maximum dot product. Complexity: O(points / 32 + points near
    /// the maximum) for each, on all threads.
    pub fn greatest_dots(&self, directions: &[Vec3]) -> Vec<f64> {
        let tasks = directions.par_iter().with_min_len(DIRECTIONS_A_TASK);
        let greatest = |bounds: &mut Vec<f64>, dir: &Vec3| self.greatest(dir.to_array().map(f64::from), bounds);
        tasks.map_init(Vec::new, greatest).collect()
    }

    /// The maximum dot product with one finite direction.
    pub fn greatest_dot(&self, dir: [f64; 3]) -> f64 {
        self.greatest(dir, &mut Vec::new())
    }

    fn greatest(&self, dir: [f64; 3], bounds: &mut Vec<f64>) -> f64 {
        let corner = |axis: usize| {
            if dir[axis] >= 0.0 { &self.high[axis] } else { &self.low[axis] }
        };
        let corners = corner(0).iter().zip(corner(1)).zip(corner(2));
        bounds.clear();
        bounds.extend(corners.map(|((&x, &y), &z)| dot([x, y, z], dir)));
        let first = (1..bounds.len()).fold(0, |best, next| if bounds[next] > bounds[best] { next } else { best });
        let mut greatest = self.greatest_in_block(first, dir);
        for (block, &bound) in bounds.iter().enumerate() {
            if bound > greatest {
                greatest = greatest.max(self.greatest_in_block(block, dir));
            }
        }
        greatest
    }

    fn greatest_in_block(&self, block: usize, dir: [f64; 3]) -> f64 {
        let [x, y, z] = self.columns.each_ref().map(|column| &column[block * BLOCK..][..BLOCK]);
        let dots = x.iter().zip(y).zip(z).map(|((&x, &y), &z)| dot([x, y, z], dir));
        // Not f64::max, whose handling of NaN, which cannot occur here, costs time.
        dots.fold(f64::NEG_INFINITY, |best, next| if next > best { next } else { best })
    }

    /// The maximum distance between two points, or slightly less: from several extreme points, it
    /// walks to the farthest point until the distance no longer grows. A regret relative to it is
    /// never understated.
    pub fn diameter(&self) -> f64 {
        let mut greatest = 0.0_f64;
        for dir in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 0.5]] {
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
        let point = |i: usize| [0, 1, 2].map(|axis| self.columns[axis][i]);
        let best = (0..self.columns[0].len()).map(|i| (score(point(i)), i));
        let (_, index) = best.fold((f64::NEG_INFINITY, 0), |best, next| if next.0 > best.0 { next } else { best });
        point(index)
    }
}

/// Dot product with the operations, and their order, of [`Points::greatest_dots`].
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sorts so that points near one another in the list are near one another in space.
fn sort_along_morton_curve(points: &mut [[f32; 3]]) {
    let fold = |start: f32, choose: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|axis| f64::from(points.iter().map(|p| p[axis]).fold(start, choose)))
    };
    let (low, high) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
    let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let cells = f64::from((1_u32 << MORTON_BITS) - 1);
    points.sort_by_cached_key(|p| {
        let mut code = 0_u32;
        for axis in 0..3 {
            // 0/0 of a single point casts to cell 0.
            let cell = ((f64::from(p[axis]) - low[axis]) / longest * cells) as u32;
            for bit in 0..MORTON_BITS {
                code |= ((cell >> bit) & 1) << (3 * bit + axis as u32);
            }
        }
        code
    });
}

fn distance_sq(a: [f64; 3], b: [f64; 3]) -> f64 {
    let gap = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(gap, gap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    fn slow(positions: &[[f32; 3]], dir: Vec3) -> f64 {
        let dir = dir.to_array().map(f64::from);
        positions.iter().map(|p| dot(p.map(f64::from), dir)).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn fast_maximum_equals_plain_scan() {
        let mut random = SplitMix::new(1);
        let mut cloud = |count: usize| -> Vec<[f32; 3]> {
            let points: Vec<[f32; 3]> = (0..count).map(|_| random.in_ball().to_array()).collect();
            [&points, &points[..1]].concat()
        };
        let mut clouds = [1, 2, 3, 31, 32, 33, 63, 64, 65, 100, 1001, 5000].map(&mut cloud).to_vec();
        let lattice = (0..1000).map(|i| [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32]);
        let lattice: Vec<[f32; 3]> = lattice.collect();
        clouds.push(lattice.iter().map(|&[x, y, _]| [x, 3.0, y]).collect());
        clouds.push(lattice.iter().map(|p| p.map(|x| x * 0.01 + 20_000.0)).collect());
        clouds.push(lattice);
        for positions in clouds {
            let mut directions: Vec<Vec3> = (0..100).map(|_| random.in_ball()).collect();
            directions.extend([Vec3::X, Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z, Vec3::ZERO, Vec3::splat(1e30), Vec3::ONE]);
            directions.extend([Vec3::new(-0.0, 1e-30, -1.0), Vec3::new(1.0, -1.0, 0.0)]);
            let fast = Points::new(&positions).greatest_dots(&directions);
            assert_eq!(fast.len(), directions.len());
            for (fast, &dir) in fast.iter().zip(&directions) {
                assert_eq!(*fast, slow(&positions, dir), "{} points, {dir}", positions.len());
            }
        }
    }

    #[test]
    fn diameter_matches_all_pairs_on_random_clouds() {
        let mut random = SplitMix::new(2);
        for _ in 0..50 {
            let positions: Vec<[f32; 3]> = (0..60).map(|_| random.in_ball().to_array()).collect();
            let pairs = positions.iter().flat_map(|a| positions.iter().map(move |b| (a, b)));
            let slow = pairs.map(|(a, b)| distance_sq(a.map(f64::from), b.map(f64::from)).sqrt()).fold(0.0, f64::max);
            let fast = Points::new(&positions).diameter();
            assert!(fast <= slow && fast > 0.9 * slow, "{fast} {slow}");
        }
        assert_eq!(Points::new(&[[1.0, 2.0, 3.0]; 3]).diameter(), 0.0);
    }
}
