//! The frame of a mesh. A mesh that is turned by right angles or reflected, or whose triangles come
//! in another order or orientation, is the same mesh in its frame, so that it has the same solid
//! and the same parts.

use glam::DVec3;

use crate::hull::Hull;
use hullmap_geometry::{PointSet, bounds, triangle};

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
        let triangles = || mesh.triangles.iter().map(|t| mesh.corners(t));
        let [low, high] = bounds(triangles().flatten());
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

    /// A mesh in its frame: nothing is rounded. Triangles are sorted. Each starts with its least
    /// corner.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn of_mesh(&self, mesh: &PointSet) -> PointSet {
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| self.point(p)).collect();
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

    /// A hull of the source in this frame: nothing is rounded.
    pub fn of_hull(&self, hull: Hull) -> Hull {
        let vertices = hull.vertices.iter().map(|p| self.point(p)).collect();
        let mut faces = hull.faces;
        if self.is_mirrored() {
            faces.iter_mut().for_each(|face| face[1..].reverse());
        }
        Hull { vertices, faces, ..hull }
    }

    /// Whether one frame is left-handed where the other is right-handed.
    pub fn is_mirrored(&self) -> bool {
        let is_cyclic = (self.axes[0] + 1) % 3 == self.axes[1];
        is_cyclic != (self.signs.iter().product::<f32>() > 0.0)
    }

    /// A point of this frame in the frame of the source.
    pub fn to_source(&self, p: DVec3) -> DVec3 {
        let mut found = DVec3::ZERO;
        for k in 0..3 {
            found[self.axes[k]] = f64::from(self.signs[k]) * p[k] + 0.0;
        }
        found
    }

    fn point(&self, p: &[f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| self.signs[k] * p[self.axes[k]] + 0.0)
    }
}

/// Integers in the order of finite numbers.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}
