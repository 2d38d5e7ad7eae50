//! Triangles and edges to draw, of a hull or of its source mesh, thinned out if there are many.

use std::collections::HashMap;

use hullmap::Hull;
use serde::Serialize;

use crate::encode::{fraction, words};

/// Corner indices have 16 bits, and a mesh has half as many corners.
pub const MAX_TRIANGLES: usize = 60_000;

/// Triangles that every hull may have, however many hulls there are.
const MIN_TRIANGLES: usize = 400;

/// Maximum corners of a mesh on a page: their indices have 16 bits.
const MAX_CORNERS: usize = 1 << 16;

/// Finest grid on which corners are merged, in cells along the longest side.
const FINEST_GRID: u32 = 2048;

/// Points, triangles and edges, in source units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplayMesh {
    /// Corners.
    pub points: Vec<[f32; 3]>,
    /// Their indices in the whole mesh if some are left out; otherwise empty.
    pub numbers: Vec<u32>,
    /// Corner indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Ends of the edges to draw: edges of faces, not of the triangles that faces are cut into.
    pub edges: Vec<[u32; 2]>,
}

#[derive(Debug, Serialize)]
pub struct EncodedMesh {
    pub low: [f32; 3],
    pub size: [f32; 3],
    /// Corners: three 16-bit fractions of the extent each.
    pub points: String,
    /// Their indices in the whole mesh if some are left out; otherwise empty.
    pub numbers: Vec<u32>,
    /// Triangles: three 16-bit corner indices each.
    pub triangles: String,
    /// Edges: two 16-bit corner indices each.
    pub edges: String,
    pub shown: usize,
    pub whole: usize,
    pub corners: usize,
}

struct GridCorners {
    points: Vec<[f32; 3]>,
    numbers: Vec<u32>,
    /// For each corner of the whole mesh, its index among them.
    new: Vec<u32>,
}

/// Edges with new corners, sorted, each of them once.
fn renumbered(edges: &[[u32; 2]], new: &[u32]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = edges.iter().map(|edge| edge.map(|corner| new[corner as usize])).collect();
    edges.retain(|[a, b]| a != b);
    edges.iter_mut().for_each(|edge| edge.sort_unstable());
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Edges as a page reads them: two 16-bit corner indices each.
pub fn encoded_edges(edges: &[[u32; 2]]) -> String {
    words(edges.as_flattened().iter().map(|&corner| corner as u16))
}

pub fn triangle_limit(hull_count: usize) -> usize {
    (MAX_TRIANGLES / hull_count.max(1)).max(MIN_TRIANGLES)
}

impl DisplayMesh {
    /// A hull with the faces `polygons`, which are cut into triangles.
    pub fn of_hull(hull: &Hull, polygons: &[Vec<u32>]) -> Self {
        let mut mesh = Self { points: hull.vertices().map(|v| v.to_array()).collect(), ..Self::default() };
        for corners in polygons {
            mesh.triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
            // Each edge is in two faces, once in either direction.
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            mesh.edges.extend(ends.filter(|(from, to)| from < to).map(|(from, to)| [*from, *to]));
        }
        if hull.rank() == 1 {
            mesh.edges.push([0, 1]);
        }
        mesh.edges.sort_unstable();
        mesh
    }

    /// Minimum and maximum coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let fold = |start: f32, choose: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| self.points.iter().map(|p| p[axis]).fold(start, choose))
        };
        [fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max)]
    }

    /// The mesh with at most `limit` triangles, and no more corners than a page can index. Corners
    /// in a cell of the finest grid that meets the limit are merged. Degenerate triangles are
    /// dropped.
    pub fn with_at_most(&self, limit: usize) -> Self {
        self.cells_for(limit).map_or_else(|| self.clone(), |cells| self.merged(cells))
    }

    /// [`with_at_most`](Self::with_at_most), and `groups` with the corners of the thinned mesh.
    pub fn with_groups(&self, limit: usize, groups: &[Vec<[u32; 2]>]) -> (Self, Vec<Vec<[u32; 2]>>) {
        let Some(cells) = self.cells_for(limit) else { return (self.clone(), groups.to_vec()) };
        let new = self.corners_of_grid(cells).new;
        (self.merged(cells), groups.iter().map(|edges| renumbered(edges, &new)).collect())
    }

    /// Number of cells along the longest side of the finest grid that meets the limit; `None` if
    /// the whole mesh does.
    fn cells_for(&self, limit: usize) -> Option<u32> {
        let fits = |mesh: &Self| mesh.triangles.len() <= limit && mesh.points.len() <= MAX_CORNERS;
        if fits(self) {
            return None;
        }
        let (mut coarse, mut fine) = (1, FINEST_GRID);
        while coarse < fine {
            let middle = (coarse + fine).div_ceil(2);
            if fits(&self.merged(middle)) {
                coarse = middle;
            } else {
                fine = middle - 1;
            }
        }
        Some(coarse)
    }

    fn corners_of_grid(&self, cells: u32) -> GridCorners {
        let [low, high] = self.bounds();
        let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
        let cell = |p: [f32; 3]| {
            [0, 1, 2].map(|axis| ((f64::from(p[axis]) - f64::from(low[axis])) / longest * f64::from(cells)) as u32)
        };
        let mut first = HashMap::new();
        let (mut points, mut numbers) = (Vec::new(), Vec::new());
        let mut new = Vec::with_capacity(self.points.len());
        for (number, &point) in self.points.iter().enumerate() {
            new.push(*first.entry(cell(point)).or_insert_with(|| {
                points.push(point);
                numbers.push(number as u32);
                points.len() as u32 - 1
            }));
        }
        GridCorners { points, numbers, new }
    }

    fn merged(&self, cells: u32) -> Self {
        let GridCorners { points, numbers, new } = self.corners_of_grid(cells);
        let mut triangles: Vec<[u32; 3]> =
            self.triangles.iter().map(|t| t.map(|corner| new[corner as usize])).collect();
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        Self { points, numbers, triangles, edges: renumbered(&self.edges, &new) }
    }

    /// The mesh as a page reads it; `whole` is the mesh before it was thinned out.
    pub fn encoded(&self, whole: &Self) -> EncodedMesh {
        let [low, high] = self.bounds();
        let size = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let scaled = |p: &[f32; 3]| [0, 1, 2].map(|i| fraction(f64::from(p[i]), f64::from(low[i]), f64::from(size[i])));
        EncodedMesh {
            low,
            size,
            points: words(self.points.iter().flat_map(scaled)),
            numbers: self.numbers.clone(),
            triangles: words(self.triangles.as_flattened().iter().map(|&corner| corner as u16)),
            edges: encoded_edges(&self.edges),
            shown: self.triangles.len(),
            whole: whole.triangles.len(),
            corners: whole.points.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use hullmap::Pack;
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::test_packs::{baked, cloud};

    fn whole(pack: &Pack) -> DisplayMesh {
        let hull = pack.hull(0).unwrap();
        DisplayMesh::of_hull(&hull, &hull.faces().map(Iterator::collect).collect::<Vec<_>>())
    }

    #[test]
    fn hulls_are_closed() {
        let (pack, _) = baked(cloud(200), IndexKind::None);
        let mesh = whole(&pack);
        // Euler: there are twice as many triangles as vertices, minus four.
        assert_eq!(mesh.triangles.len(), 2 * mesh.points.len() - 4);
        assert!(mesh.edges.len() <= 3 * mesh.points.len() - 6);
        let hull = pack.hull(0).unwrap();
        let neighbours = (0..mesh.points.len() as u32).flat_map(|v| hull.neighbours(v).map(move |w| [v, w]));
        assert!(mesh.edges.iter().copied().eq(neighbours.filter(|[v, w]| v < w)));
    }

    #[test]
    fn thinned_meshes_stay_within_bounds() {
        let (pack, _) = baked(cloud(4000), IndexKind::None);
        let mesh = whole(&pack);
        assert_eq!(mesh.with_at_most(10_000).triangles, mesh.triangles);
        let [low, high] = mesh.bounds();
        for limit in [3000, 400, 20] {
            let small = mesh.with_at_most(limit);
            assert!(
                small.triangles.len() <= limit && small.triangles.len() > limit / 4,
                "{limit}: {}",
                small.triangles.len()
            );
            let corner = |corner: &u32| (*corner as usize) < small.points.len();
            assert!(small.triangles.as_flattened().iter().all(corner));
            assert!(small.edges.as_flattened().iter().all(corner));
            let [small_low, small_high] = small.bounds();
            for axis in 0..3 {
                assert!(small_low[axis] >= low[axis] && small_high[axis] <= high[axis]);
            }
        }
    }

    #[test]
    fn groups_of_edges_are_thinned_with_their_mesh() {
        let (pack, _) = baked(cloud(4000), IndexKind::None);
        let mesh = whole(&pack);
        let (even, odd) = mesh.edges.iter().partition(|[from, _]| from % 2 == 0);
        let groups: Vec<Vec<[u32; 2]>> = vec![even, odd];
        assert_eq!(mesh.with_groups(1 << 20, &groups), (mesh.clone(), groups.clone()));
        let (small, thinned) = mesh.with_groups(400, &groups);
        assert_eq!(small, mesh.with_at_most(400));
        let mut all = thinned.concat();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all, small.edges);
    }

    #[test]
    fn single_points_and_large_clouds_fit() {
        let point = DisplayMesh { points: vec![[1.0, 2.0, 3.0]], ..DisplayMesh::default() };
        assert_eq!(point.encoded(&point).points, words([0, 0, 0]));
        let many = DisplayMesh { points: cloud(140_000), ..DisplayMesh::default() };
        let fewer = many.with_at_most(100).points.len();
        assert!(fewer <= MAX_CORNERS && fewer > MAX_CORNERS / 8, "{fewer}");
    }
}
