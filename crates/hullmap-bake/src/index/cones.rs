//! Normal cones cut to a cell of the cube map: polygons in the (u, v) plane of one face, each with its vertex's number.

use glam::DVec3;
use hullmap_format::cube::{self, CELL_SLACK};

use crate::gauss_map::GaussMap;

/// How far, in units of u and v, a polygon must reach beyond a plane to be listed there.
///
/// Cones that only touch a plane are listed on their own side alone. Else a fan, whose cones all meet in one point, would
/// be on both sides of every cut through it. A direction so close to the cut that rounding puts it on the wrong side finds
/// a vertex whose cone is as close: the regret is at most about this times the diameter.
pub const TOUCH: f64 = 4e-15;

/// Polygons of these sizes are listed wherever they reach at all.
///
/// Between two planes, near the line in which they meet, all is within [`TOUCH`] of both: what lies there would be listed
/// on neither side. Large polygons reach out of there and are found where they do. Small ones do not: what is listed instead
/// is as wrong as they are large. Still smaller ones can be wrong by no more than [`TOUCH`].
const SMALL: std::ops::Range<f64> = 8.0 * TOUCH..1e-6;

/// How far a polygon of this size must reach beyond a plane to be listed there.
pub fn touch_of(size: f64) -> f64 {
    if SMALL.contains(&size) { 0.0 } else { TOUCH }
}

/// Polygons of the cones that meet a cell, in ascending order of their vertices.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    /// Numbers of the vertices.
    pub vertices: Vec<u32>,
    ends: Vec<u32>,
    corners: Vec<[f64; 2]>,
}

/// A line a·u + b·v + c = 0 in a face's plane, at which cells are cut.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    terms: [f64; 3],
    /// How far each side reaches over the line; negative: how far a polygon must reach over it to be listed there.
    overlap: f64,
}

impl Line {
    /// The line u = `at` (`axis` 0) or v = `at` (`axis` 1); its front is the upper side.
    pub fn axis(axis: usize, at: f64) -> Self {
        // A direction so close to the line may be located on either side of it.
        Self { terms: if axis == 0 { [1.0, 0.0, -at] } else { [0.0, 1.0, -at] }, overlap: CELL_SLACK }
    }

    /// Where the plane through the origin with this `normal` cuts the plane of `face`.
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
    /// All cones of `map`, cut to `face` of the cube.
    pub fn on_face(map: &GaussMap, face: u32) -> Self {
        let mut cones = Self::default();
        let (mut polygon, mut scratch) = (Vec::new(), Vec::new());
        let axis = (face / 2) as usize;
        let towards = DVec3::from_array(cube::direction(face, 0.0, 0.0));
        let sides = [(axis + 1) % 3, (axis + 2) % 3].map(|i| DVec3::AXES[i]);
        let planes = [-sides[0], sides[0], -sides[1], sides[1]].map(|side| towards * (1.0 + CELL_SLACK) + side);
        for (vertex, piece) in map.pieces() {
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
        }
        cones
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Number of vertices: fewer than polygons where both pieces of a polygon's cone are here.
    pub fn vertex_count(&self) -> usize {
        self.vertices.chunk_by(|a, b| a == b).count()
    }

    /// The vertices, each once, ascending.
    pub fn into_vertices(mut self) -> Vec<u32> {
        self.vertices.dedup();
        self.vertices
    }

    /// The polygons with their vertices' numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[[f64; 2]])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        self.vertices
            .iter()
            .zip(starts.zip(&self.ends))
            .map(|(v, (start, end))| (*v, &self.corners[start as usize..*end as usize]))
    }

    /// The polygons with these numbers, ascending.
    pub fn select(&self, numbers: impl Iterator<Item = usize>) -> Self {
        let mut chosen = Self::default();
        for number in numbers {
            let start = if number == 0 { 0 } else { self.ends[number - 1] };
            chosen.push(self.vertices[number], &self.corners[start as usize..self.ends[number] as usize]);
        }
        chosen
    }

    /// Closes the polygon of `vertex`, whose corners were pushed last.
    fn end(&mut self, vertex: u32) {
        self.vertices.push(vertex);
        self.ends.push(self.corners.len() as u32);
    }

    /// How many cones would lie behind `line` and in front of it; those across it count twice.
    pub fn count(&self, line: Line) -> [usize; 2] {
        let mut counts = [0; 2];
        for (_, polygon) in self.iter() {
            let [behind, front] = reach(polygon, line);
            counts[0] += usize::from(behind);
            counts[1] += usize::from(front);
        }
        counts
    }

    /// The cones behind `line` and those in front of it, those across it cut in two.
    pub fn split(&self, line: Line) -> [Self; 2] {
        let [mut behind, mut front] = [Self::default(), Self::default()];
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

    /// Adds the part of a polygon on one side of a line; all of it where rounding leaves no part.
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

/// Whether a polygon reaches behind a line, and in front of it. One so small that it does neither counts for both.
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

/// The longer side of a polygon's bounds.
fn size(polygon: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let of = |start: f64, choose: fn(f64, f64) -> f64| polygon.iter().map(|p| p[axis]).fold(start, choose);
        of(f64::NEG_INFINITY, f64::max) - of(f64::INFINITY, f64::min)
    };
    along(0).max(along(1))
}

/// Appends the part of a convex polygon on one side of a line (`sign` 1: in front; −1: behind), the overlap included.
pub fn cut(polygon: &[[f64; 2]], line: Line, sign: f64, out: &mut Vec<[f64; 2]>) {
    let Some(last) = polygon.last() else { return };
    let overlap = line.overlap.max(0.0);
    let height = |p: [f64; 2]| sign * line.height(p) + overlap;
    let (mut p, mut p_height) = (*last, height(*last));
    for &q in polygon {
        let q_height = height(q);
        if (p_height < 0.0) != (q_height < 0.0) {
            let t = p_height / (p_height - q_height);
            out.push([p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t]);
        }
        if q_height >= 0.0 {
            out.push(q);
        }
        (p, p_height) = (q, q_height);
    }
}

/// The part of a cone, given by its corner rays in order, where plane·d ≥ 0.
fn clip_rays(polygon: &[DVec3], plane: DVec3, out: &mut Vec<DVec3>) {
    out.clear();
    let Some(&last) = polygon.last() else { return };
    let (mut p, mut p_height) = (last, plane.dot(last));
    for &q in polygon {
        let q_height = plane.dot(q);
        if (p_height < 0.0) != (q_height < 0.0) {
            out.push(p + (q - p) * (p_height / (p_height - q_height)));
        }
        if q_height >= 0.0 {
            out.push(q);
        }
        (p, p_height) = (q, q_height);
    }
}
