//! Spans of equal support vertices along a row of directions, on a hull whose vertices are scanned.
//!
//! # Steps
//! 1. In the direction of a pixel, compute how far the support vertex is above each other vertex.
//! 2. These heights are linear along the row. Take the last pixel at which none of them is small.
//! 3. Compute the heights there as well. If all are large at both ends, they are large between
//!    them, so the answer is the same.
//! 4. Query the other pixels.

use glam::{DVec3, Vec3};
use hullmap::Hull;

/// Relative height of one vertex above another that is certain in a scan. Directions have a largest
/// coordinate of 1: f32 turns them by at most 6e-8 for each coordinate, which changes a height by
/// at most 4e-7, and directions of a row are off a line by as much. A scan orders heights from 3e-6
/// by its f32 dot products alone.
const CERTAIN: f64 = 1e-5;

/// Maximum number of vertices. A scan of more takes less time than the heights of all of them.
const MAX_VERTICES: usize = 256;

/// Minimum largest coordinate. Dot products of smaller hulls may underflow in f32.
const LEAST_REACH: f64 = 1e-20;

/// Maximum largest coordinate. Dot products of larger hulls may overflow in f32.
const MOST_REACH: f64 = 1e30;

pub struct Scan {
    vertices: Vec<DVec3>,
    /// Height from which an answer is certain.
    certain: f64,
}

impl Scan {
    /// `None` for many vertices, or coordinates at which dot products may be inaccurate.
    pub fn new(hull: &Hull) -> Option<Self> {
        if hull.vertex_count() > MAX_VERTICES {
            return None;
        }
        let vertices: Vec<DVec3> = hull.vertices().map(|vertex| vertex.as_dvec3()).collect();
        let reach = vertices.iter().fold(0.0, |reach: f64, vertex| reach.max(vertex.abs().max_element()));
        (LEAST_REACH..=MOST_REACH).contains(&reach).then_some(Self { vertices, certain: CERTAIN * reach })
    }

    /// The answers of `pixel` for `0..count` as runs: number of pixels and answer, not all of them
    /// computed. The directions are evenly spaced on a line, except for rounding to f32.
    pub fn row<A>(
        &self,
        count: u32,
        direction: impl Fn(u32) -> [f32; 3],
        pixel: impl Fn(u32) -> (u32, A),
    ) -> Vec<(u32, (u32, A))> {
        let dir = |column: u32| Vec3::from_array(direction(column)).as_dvec3();
        let mut runs = Vec::new();
        let mut column = 0;
        while column < count {
            let answer = pixel(column);
            let last = self.last_certain(answer.0, column, count, &dir);
            runs.push((last + 1 - column, answer));
            column = last + 1;
        }
        runs
    }

    /// The last pixel up to which `vertex` is certainly the answer, or `column`.
    fn last_certain(&self, vertex: u32, column: u32, count: u32, dir: &impl Fn(u32) -> DVec3) -> u32 {
        let Some(own) = self.vertices.get(vertex as usize) else { return column };
        let (first, end) = (dir(column), dir(count - 1));
        let steps = f64::from(count - 1 - column);
        let mut last = steps;
        for other in self.others(vertex) {
            let from = (*own - *other).dot(first) - self.certain;
            let to = (*own - *other).dot(end) - self.certain;
            // Written so that NaN is not certain.
            if !(from > 0.0) {
                return column;
            }
            if !(to > 0.0) {
                last = last.min(steps * from / (from - to));
            }
        }
        // Casts saturate, and turn NaN into 0.
        let last = column + (last.floor() as u32).min(count - 1 - column);
        let at = dir(last);
        let is_certain = self.others(vertex).all(|other| (*own - *other).dot(at) > self.certain);
        if is_certain { last } else { column }
    }

    fn others(&self, vertex: u32) -> impl Iterator<Item = &DVec3> {
        let (before, rest) = self.vertices.split_at(vertex as usize);
        before.iter().chain(&rest[1..])
    }
}
