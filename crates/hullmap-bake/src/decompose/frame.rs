//! The frame of a search. A mesh that is turned by right angles or reflected, or whose triangles
//! come in another order or orientation, is the same mesh in its frame, so that it has the same
//! parts.

use glam::DVec3;

use hullmap_geometry::{PointSet, triangle};

/// Skewness below which a mesh counts as symmetric along an axis, relative to the greatest.
const SYMMETRIC: f64 = 1e-9;

/// An order of the axes, and their directions.
pub struct Frame {
    axes: [usize; 3],
    signs: [f32; 3],
}

impl Frame {
    /// The frame of a mesh: the shortest axis is the first, and most of the surface that is far
    /// from the middle of the box is on the positive sides.
    ///
    /// # Complexity
    /// O(n) for n triangles.
    pub fn new(mesh: &PointSet) -> Self {
        let point = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
        let triangles = || mesh.triangles.iter().map(|t| t.map(point));
        let low = triangles().flatten().fold(DVec3::INFINITY, DVec3::min);
        let high = triangles().flatten().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, size) = (0.5 * (low + high), high - low);
        let (mut spread, mut skew, mut most) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for corners in triangles() {
            let [a, b, c] = corners;
            let area = (b - a).cross(c - a).length();
            let p = triangle::centroid(&corners) - middle;
            spread += area * p * p;
            skew += area * p * p * p;
            most += area * p.length_squared() * p.length();
        }
        let mut axes = [0, 1, 2];
        axes.sort_by(|a, b| size[*a].total_cmp(&size[*b]).then(spread[*a].total_cmp(&spread[*b])));
        let signs = axes.map(|axis| if skew[axis] < -SYMMETRIC * most { -1.0 } else { 1.0 });
        Self { axes, signs }
    }

    /// A mesh in its frame. Each triangle starts with its least corner, and they are sorted.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn of_mesh(&self, mesh: &PointSet) -> PointSet {
        let point = |p: &[f32; 3]| [0, 1, 2].map(|k| self.signs[k] * p[self.axes[k]] + 0.0);
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(point).collect();
        let at = |v: u32| DVec3::from_array(positions[v as usize].map(f64::from));
        let volume = |[a, b, c]: &[u32; 3]| at(*a).cross(at(*b)).dot(at(*c));
        let is_inward = mesh.triangles.iter().map(volume).sum::<f64>() < 0.0;
        let key = |v: u32| positions[v as usize].map(ordered);
        let from_least = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = if is_inward { [a, c, b] } else { [a, b, c] };
            let turns = [[a, b, c], [b, c, a], [c, a, b]];
            turns.into_iter().min_by_key(|turn| turn.map(key)).unwrap_or([a, b, c])
        };
        let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(from_least).collect();
        triangles.sort_by_cached_key(|corners| corners.map(key));
        PointSet { positions, triangles, ..mesh.clone() }
    }

    /// A part in the frame of the source.
    pub fn part_in_source(&self, part: PointSet) -> PointSet {
        let back = |p: [f32; 3]| {
            let mut found = [0.0; 3];
            for k in 0..3 {
                found[self.axes[k]] = self.signs[k] * p[k] + 0.0;
            }
            found
        };
        PointSet { positions: part.positions.into_iter().map(back).collect(), ..part }
    }
}

/// Integers in the order of finite numbers.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

#[cfg(test)]
mod tests {
    use shapes::{concave, rng::SplitMix64};

    use crate::decompose::{Cover, decompose, tests::point_set};

    use super::*;

    #[test]
    fn turned_meshes_have_the_same_parts() {
        let seed = 6;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        let mesh = point_set(&concave::spiral_stair(5));
        let bits = |p: &[f32; 3]| p.map(f32::to_bits);
        let parts = |mesh: &PointSet, back: &dyn Fn([f32; 3]) -> [f32; 3]| {
            let parts = decompose(mesh, &Cover::default()).unwrap().unwrap();
            let part = |part: &PointSet| {
                let mut points: Vec<_> = part.positions.iter().map(|p| bits(&back(*p))).collect();
                points.sort_unstable();
                points
            };
            let mut found: Vec<_> = parts.iter().map(part).collect();
            found.sort_unstable();
            found
        };
        let own = parts(&mesh, &|p| p);
        assert!(own.len() > 3);
        for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let signs = [0; 3].map(|_| if rng.unit() < 0.5 { -1.0 } else { 1.0 });
            let frame = Frame { axes, signs };
            let positions = mesh.positions.iter().map(|p| [0, 1, 2].map(|k| signs[k] * p[axes[k]] + 0.0)).collect();
            let mut turned = PointSet { positions, ..mesh.clone() };
            for k in (1..turned.triangles.len()).rev() {
                turned.triangles.swap(k, rng.below(k + 1));
            }
            turned.triangles.iter_mut().for_each(|t| t.rotate_left(rng.below(3)));
            if axes[0] == 2 {
                turned.triangles.iter_mut().for_each(|t| t.swap(0, 1));
            }
            let back = |p| frame.part_in_source(PointSet::of_positions(vec![p])).positions[0];
            assert!(parts(&turned, &back) == own, "{axes:?} {signs:?}");
        }
    }
}
