//! Triangles and edges to look at: of a hull, or of its source mesh; fewer than there are where there are many.

use std::collections::HashMap;

use hullmap::Hull;
use serde::Serialize;

use super::encode::{fraction, words};

/// Triangles that a page shows of a shape at most. A corner has 16 bits on the page, and there are half as many.
pub const MAX_TRIANGLES: usize = 60_000;

/// Triangles that each hull of many may have on a page at least.
const MIN_TRIANGLES: usize = 400;

/// Corners a shape can have on a page.
const MAX_CORNERS: usize = 1 << 16;

/// Finest grid that corners are gathered on, cells along the longest side.
const FINEST_GRID: u32 = 2048;

/// Points, triangles and edges, in source units.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Corners.
    pub points: Vec<[f32; 3]>,
    /// Their numbers in the whole shape, where some are left out; else empty.
    pub numbers: Vec<u32>,
    /// Numbers of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Ends of the edges that are drawn: those of faces, not of the triangles that faces are cut into.
    pub edges: Vec<[u32; 2]>,
}

/// A shape as the page reads it.
#[derive(Debug, Serialize)]
pub struct ShownShape {
    /// Least coordinates.
    pub low: [f32; 3],
    /// Greatest coordinates less the least.
    pub size: [f32; 3],
    /// Corners: three 16-bit numbers each, between least and greatest.
    pub points: String,
    /// Their numbers in the whole shape, where some are left out; else empty.
    pub numbers: Vec<u32>,
    /// Triangles: three 16-bit numbers of corners each.
    pub triangles: String,
    /// Edges: two 16-bit numbers of corners each.
    pub edges: String,
    /// Triangles on the page.
    pub shown: usize,
    /// Triangles there are.
    pub whole: usize,
    /// Corners there are.
    pub corners: usize,
}

/// Triangles of each hull where a page shows this many.
pub fn triangle_cap(hull_count: usize) -> usize {
    (MAX_TRIANGLES / hull_count.max(1)).max(MIN_TRIANGLES)
}

impl Shape {
    /// A hull, its faces cut into triangles.
    pub fn of_hull(hull: &Hull) -> Self {
        let mut shape = Self { points: hull.vertices().map(|v| v.to_array()).collect(), ..Self::default() };
        for face in hull.faces() {
            let corners: Vec<u32> = face.collect();
            shape.triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
        }
        for vertex in 0..shape.points.len() as u32 {
            shape.edges.extend(hull.neighbours(vertex).filter(|&to| to > vertex).map(|to| [vertex, to]));
        }
        shape
    }

    /// Least and greatest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let fold = |start: f32, choose: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| self.points.iter().map(|p| p[axis]).fold(start, choose))
        };
        [fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max)]
    }

    /// The same with at most `cap` triangles, and as many corners as a page can number.
    ///
    /// Corners in the same cell of a grid become the first of them; the grid is the finest that leaves few enough. What
    /// becomes an edge or a point is left out.
    pub fn with_at_most(&self, cap: usize) -> Self {
        let fits = |shape: &Self| shape.triangles.len() <= cap && shape.points.len() <= MAX_CORNERS;
        if fits(self) {
            return self.clone();
        }
        let (mut coarse, mut fine) = (1, FINEST_GRID);
        let mut best = self.gathered(1);
        while coarse < fine {
            let middle = (coarse + fine).div_ceil(2);
            let tried = self.gathered(middle);
            if fits(&tried) {
                (coarse, best) = (middle, tried);
            } else {
                fine = middle - 1;
            }
        }
        best
    }

    /// Corners in the same cell made one.
    fn gathered(&self, cells: u32) -> Self {
        let [low, high] = self.bounds();
        let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
        let cell = |p: [f32; 3]| {
            [0, 1, 2].map(|axis| ((f64::from(p[axis]) - f64::from(low[axis])) / longest * f64::from(cells)) as u32)
        };
        let mut first = HashMap::new();
        let (mut points, mut numbers) = (Vec::new(), Vec::new());
        let mut place = Vec::with_capacity(self.points.len());
        for (number, &point) in self.points.iter().enumerate() {
            place.push(*first.entry(cell(point)).or_insert_with(|| {
                points.push(point);
                numbers.push(number as u32);
                points.len() as u32 - 1
            }));
        }
        let mut triangles: Vec<[u32; 3]> =
            self.triangles.iter().map(|t| t.map(|corner| place[corner as usize])).collect();
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        let mut edges: Vec<[u32; 2]> = self.edges.iter().map(|e| e.map(|corner| place[corner as usize])).collect();
        edges.retain(|[a, b]| a != b);
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        Self { points, numbers, triangles, edges }
    }

    /// The shape for a page, made from `whole`.
    pub fn shown(&self, whole: &Self) -> ShownShape {
        let [low, high] = self.bounds();
        let size = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let scaled = |p: &[f32; 3]| [0, 1, 2].map(|i| fraction(f64::from(p[i]), f64::from(low[i]), f64::from(size[i])));
        ShownShape {
            low,
            size,
            points: words(self.points.iter().flat_map(scaled)),
            numbers: self.numbers.clone(),
            triangles: words(self.triangles.as_flattened().iter().map(|&corner| corner as u16)),
            edges: words(self.edges.as_flattened().iter().map(|&corner| corner as u16)),
            shown: self.triangles.len(),
            whole: whole.triangles.len(),
            corners: whole.points.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::super::index_reader::tests::{baked, cloud};
    use super::*;

    #[test]
    fn hulls_are_closed() {
        let (pack, _) = baked(cloud(200), IndexKind::None);
        let shape = Shape::of_hull(&pack.hull(0).unwrap());
        // Euler: triangles are twice the vertices less four.
        assert_eq!(shape.triangles.len(), 2 * shape.points.len() - 4);
        assert!(shape.edges.len() <= 3 * shape.points.len() - 6);
    }

    #[test]
    fn shapes_are_made_smaller_and_stay_in_place() {
        let (pack, _) = baked(cloud(4000), IndexKind::None);
        let shape = Shape::of_hull(&pack.hull(0).unwrap());
        assert_eq!(shape.with_at_most(10_000).triangles, shape.triangles);
        let [low, high] = shape.bounds();
        for cap in [3000, 400, 20] {
            let small = shape.with_at_most(cap);
            assert!(
                small.triangles.len() <= cap && small.triangles.len() > cap / 4,
                "{cap}: {}",
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
    fn points_and_large_clouds_do() {
        let point = Shape { points: vec![[1.0, 2.0, 3.0]], ..Shape::default() };
        assert_eq!(point.shown(&point).points, words([0, 0, 0]));
        let many = Shape { points: cloud(140_000), ..Shape::default() };
        let fewer = many.with_at_most(100).points.len();
        assert!(fewer <= MAX_CORNERS && fewer > MAX_CORNERS / 8, "{fewer}");
    }
}
