//! Normal cones clipped to a cell of the cube map: polygons in the (u, v) plane of one face, each
//! with its vertex's index. A leaf's candidates are the vertices whose polygons meet its cell.

use glam::DVec3;
use hullmap_format::cube::{self, CELL_SLACK};
use hullmap_geometry::planes::{between, clip};

use crate::gauss_map::GaussMap;

/// How far a polygon must reach beyond a plane, in units of u and v, to be listed there.
///
/// A cone that only touches a plane is listed on its own side. Otherwise, cones that meet at one
/// point would be on both sides of every cut through it. Rounding can put a direction this close to
/// the cut on the wrong side, where the regret is at most about `TOUCH` times the diameter.
pub const TOUCH: f64 = 4e-15;

/// Range of sizes in which a polygon is listed wherever it reaches at all.
///
/// Where two planes meet, everything between them is within [`TOUCH`] of both, and would be listed
/// on neither side. A large polygon reaches out and is listed outside. The error of omitting a
/// small one is its size: below this range, of the order of [`TOUCH`].
const SMALL: std::ops::Range<f64> = 8.0 * TOUCH..1e-6;

/// Distance that a polygon of this size must reach beyond a plane to be listed there.
pub fn touch_of(size: f64) -> f64 {
    if SMALL.contains(&size) { 0.0 } else { TOUCH }
}

/// Polygons of the cones that meet a cell, in ascending order of their vertices.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    /// Vertex index of each polygon.
    pub vertices: Vec<u32>,
    ends: Vec<u32>,
    corners: Vec<[f64; 2]>,
}

/// A line a·u + b·v + c = 0 in the plane of a cube face. Cells are cut along such lines.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    terms: [f64; 3],
    /// How far each side extends across the line. If negative, how far a polygon must reach across
    /// the line to be listed there.
    overlap: f64,
}

impl Line {
    /// The line u = `at` (`axis` 0) or v = `at` (`axis` 1); its front is the upper side.
    pub fn axis(axis: usize, at: f64) -> Self {
        // A direction this close to the line may be located on either side of it.
        Self { terms: if axis == 0 { [1.0, 0.0, -at] } else { [0.0, 1.0, -at] }, overlap: CELL_SLACK }
    }

    /// The line in which the plane through the origin with this `normal` cuts the plane of `face`.
    pub fn plane(face: u32, normal: DVec3) -> Self {
        let normal = normal.to_array();
        let axis = (face / 2) as usize;
        let towards = if face.is_multiple_of(2) { normal[axis] } else { -normal[axis] };
        Self { terms: [normal[(axis + 1) % 3], normal[(axis + 2) % 3], towards], overlap: -TOUCH }
    }

    fn height(&self, p: [f64; 2]) -> f64 {
        self.terms[0] * p[0] + self.terms[1] * p[1] + self.terms[2]
    }
}

impl Cones {
    /// All cones of `map`, clipped to `face` of the cube.
    pub fn on_face(map: &GaussMap, face: u32) -> Self {
        let mut cones = Self::default();
        let (mut polygon, mut scratch) = (Vec::new(), Vec::new());
        let axis = (face / 2) as usize;
        let towards = DVec3::from_array(cube::direction(face, 0.0, 0.0));
        let sides = [(axis + 1) % 3, (axis + 2) % 3].map(|i| DVec3::AXES[i]);
        let planes = [-sides[0], sides[0], -sides[1], sides[1]].map(|side| towards * (1.0 + CELL_SLACK) + side);
        map.for_each_piece_near(face, |vertex, piece| {
            polygon.clear();
            polygon.extend_from_slice(piece);
            for plane in planes {
                clip_rays(&polygon, plane, &mut scratch);
                std::mem::swap(&mut polygon, &mut scratch);
            }
            let start = cones.corners.len();
            cones.corners.extend(polygon.iter().filter(|d| d.dot(towards) > 0.0).map(|d| {
                let size = d.dot(towards);
                [d.dot(sides[0]) / size, d.dot(sides[1]) / size]
            }));
            if cones.corners.len() > start {
                cones.end(vertex);
            }
        });
        cones
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there are no polygons.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Number of vertices: fewer than polygons if both pieces of a cone are present.
    pub fn vertex_count(&self) -> usize {
        self.vertices.chunk_by(|a, b| a == b).count()
    }

    /// The distinct vertices, ascending.
    pub fn into_vertices(mut self) -> Vec<u32> {
        self.vertices.dedup();
        self.vertices
    }

    /// The polygons, each with the index of its vertex.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[[f64; 2]])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        self.vertices
            .iter()
            .zip(starts.zip(&self.ends))
            .map(|(v, (start, end))| (*v, &self.corners[start as usize..*end as usize]))
    }

    /// The polygons with these indices, which must be ascending.
    pub fn select(&self, indices: impl Iterator<Item = usize>) -> Self {
        let mut chosen = Self::default();
        for index in indices {
            let start = if index == 0 { 0 } else { self.ends[index - 1] };
            chosen.push(self.vertices[index], &self.corners[start as usize..self.ends[index] as usize]);
        }
        chosen
    }

    fn end(&mut self, vertex: u32) {
        self.vertices.push(vertex);
        self.ends.push(self.corners.len() as u32);
    }

    /// Number of cones behind and in front of `line`. A cone across it counts twice.
    pub fn count(&self, line: Line) -> [usize; 2] {
        let mut counts = [0; 2];
        for (_, polygon) in self.iter() {
            let [behind, front] = reach(polygon, line);
            counts[0] += usize::from(behind);
            counts[1] += usize::from(front);
        }
        counts
    }

    /// The cones behind `line` and those in front of it. A cone that crosses the line is cut in
    /// two. `counts` is the result of [`Self::count`].
    pub fn split(&self, line: Line, counts: [usize; 2]) -> [Self; 2] {
        let [mut behind, mut front] = counts.map(|count| self.with_room(count));
        for (vertex, polygon) in self.iter() {
            match reach(polygon, line) {
                [true, false] => behind.push(vertex, polygon),
                [false, true] => front.push(vertex, polygon),
                _ => {
                    behind.push_part(vertex, polygon, line, -1.0);
                    front.push_part(vertex, polygon, line, 1.0);
                }
            }
        }
        [behind, front]
    }

    /// No cones, with room for `count` of them that have as many corners as these on average.
    fn with_room(&self, count: usize) -> Self {
        let corners = (self.corners.len() * count).div_ceil(self.len().max(1));
        Self {
            vertices: Vec::with_capacity(count),
            ends: Vec::with_capacity(count),
            corners: Vec::with_capacity(corners + corners / 8 + 4),
        }
    }

    /// Adds the part of a polygon on one side of a line, or all of it if rounding leaves none.
    fn push_part(&mut self, vertex: u32, polygon: &[[f64; 2]], line: Line, sign: f64) {
        let start = self.corners.len();
        cut(polygon, line, sign, &mut self.corners);
        if self.corners.len() == start {
            self.corners.extend_from_slice(polygon);
        }
        self.end(vertex);
    }

    fn push(&mut self, vertex: u32, polygon: &[[f64; 2]]) {
        self.corners.extend_from_slice(polygon);
        self.end(vertex);
    }
}

/// Whether a polygon reaches behind and in front of a line. A tiny one counts for both.
fn reach(polygon: &[[f64; 2]], line: Line) -> [bool; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in polygon {
        let height = line.height(*p);
        low = low.min(height);
        high = high.max(height);
    }
    let mut overlap = line.overlap;
    if overlap < 0.0 && ((overlap..0.0).contains(&low) || (0.0..-overlap).contains(&high)) {
        overlap = -touch_of(size(polygon));
    }
    let [behind, front] = [low < overlap, high > -overlap];
    if behind || front { [behind, front] } else { [true, true] }
}

fn size(polygon: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let of = |start: f64, choose: fn(f64, f64) -> f64| polygon.iter().map(|p| p[axis]).fold(start, choose);
        of(f64::NEG_INFINITY, f64::max) - of(f64::INFINITY, f64::min)
    };
    along(0).max(along(1))
}

/// Appends the part of a convex polygon on one side of a line (`sign` 1: in front, −1: behind),
/// including the overlap.
pub fn cut(polygon: &[[f64; 2]], line: Line, sign: f64, out: &mut Vec<[f64; 2]>) {
    let overlap = line.overlap.max(0.0);
    clip(polygon, |p| sign * line.height(p) + overlap, between, out);
}

fn clip_rays(polygon: &[DVec3], plane: DVec3, out: &mut Vec<DVec3>) {
    out.clear();
    clip(polygon, |p| plane.dot(p), |p, q, share| p + (q - p) * share, out);
}
