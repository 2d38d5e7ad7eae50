//! EPA: `kernels/epa.wgsl` in Rust.
//!
//! # Reference
//! G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects",
//! 2001.
//!
//! # Steps
//! 1. Start with the surface of GJK's tetrahedron, or of the support points along the six axes.
//! 2. A face is certain if its volume with the origin is. If all are, the lowest height of a corner
//!    over a face is a lower bound of the depth: see docs/intervals.md, section 13.
//! 3. The support point beyond the lowest face. Its plane is an upper bound.
//! 4. The point replaces the faces that see it. Their border is found by cancelling edges that
//!    occur in both directions, so the surface stays closed whatever the rounding.
//! 5. The witness points belong to the closest point of the surface.
//!
//! # Deviations
//! The depth ends as stalled as soon as one face is not certain. There is no surface to return to.

use super::gjk::Ended;
use super::simplex::{Corner, FACES, on_triangle, reach};
use super::support::Run;
use super::vector::{CERTAIN, LOWEST, Vector, cross, dot, l1, mad, scaled, sub};
use crate::records::{AnswerRecord, PairRecord, code};

/// Vertices of the polytope. A closed surface of them has at most 124 faces.
const MAX_VERTICES: usize = 64;
const MAX_FACES: usize = 124;

/// Triangles over the border of the faces that a new vertex sees.
const MAX_PENDING: usize = 64;

type Triangle = [usize; 3];

/// A face of the polytope.
#[derive(Clone, Copy)]
struct Face {
    /// Outward normal, of unit length if the face is certain.
    normal: Vector,
    /// Height of its lowest corner along the normal; −1 if its volume with the origin may be
    /// negative.
    height: f32,
    corners: Triangle,
}

fn face<const FUSED: bool>(corners: &[Corner], triangle: Triangle) -> Face {
    let [p, q, r] = triangle.map(|corner| corners[corner].w);
    let (e, f) = (sub(q, p), sub(r, p));
    let normal = cross::<FUSED>(e, f);
    let volume = dot::<FUSED>(normal, p);
    let long = dot::<FUSED>(e, e) + dot::<FUSED>(f, f);
    if !(volume > CERTAIN * 0.5 * long * l1(p)) {
        return Face { normal, height: -1.0, corners: triangle };
    }
    let inverse = 1.0 / dot::<FUSED>(normal, normal).sqrt();
    let mut least = volume;
    for corner in [q, r] {
        let at = dot::<FUSED>(normal, corner);
        if at < least {
            least = at;
        }
    }
    Face { normal: scaled(normal, inverse), height: least * inverse, corners: triangle }
}

/// Plus and minus x, y and z.
fn axis_direction(index: usize) -> Vector {
    let mut dir = [0.0; 3];
    dir[index >> 1] = if index & 1 == 0 { 1.0 } else { -1.0 };
    dir
}

/// Removes the faces that see the point `w`, and returns the fan over their border, or nothing if
/// there is no room.
fn open_horizon<const FUSED: bool>(faces: &mut Vec<Face>, w: Vector, apex: usize, error: f32) -> Vec<Triangle> {
    let mut pending: Vec<Triangle> = Vec::new();
    let mut at = 0;
    while at < faces.len() {
        let Face { normal, height, corners } = faces[at];
        if !(dot::<FUSED>(normal, w) > height + error) {
            at += 1;
            continue;
        }
        for side in 0..3 {
            let (from, to) = (corners[side], corners[(side + 1) % 3]);
            // An edge between two of these faces occurs twice, in opposite directions.
            match pending.iter().position(|other| *other == [to, from, apex]) {
                Some(opposite) => {
                    pending.swap_remove(opposite);
                }
                None if pending.len() == MAX_PENDING => return Vec::new(),
                None => pending.push([from, to, apex]),
            }
        }
        faces.swap_remove(at);
    }
    if faces.len() + pending.len() > MAX_FACES { Vec::new() } else { pending }
}

/// Finishes a depth that GJK left to EPA.
pub(super) fn epa<const FUSED: bool>(
    run: &mut Run<'_>,
    pair: &PairRecord,
    tolerance: f32,
    max_steps: u32,
    ended: Ended,
) -> AnswerRecord {
    let mut search = EpaSearch::<FUSED>::new(pair, tolerance, ended);
    search.out.status = loop {
        if let Err(status) = search.expand(run, max_steps) {
            break status;
        }
    };
    search.find_witness();
    search.finish()
}

/// State of the search.
struct EpaSearch<'p, const FUSED: bool> {
    pair: &'p PairRecord,
    tolerance: f32,
    out: AnswerRecord,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    /// Triangles that become faces in the next step.
    pending: Vec<Triangle>,
    /// Direction of the next support call.
    dir: Vector,
    /// Height of the lowest face.
    height: f32,
    /// The lowest face so far, of a closed surface with certain volumes, and its height.
    lowest_face: Option<Triangle>,
    lowest_height: f32,
    depth_upper: f32,
    depth_lower: f32,
    /// Whether the search still collects support points along the axes.
    axes: bool,
}

impl<'p, const FUSED: bool> EpaSearch<'p, FUSED> {
    /// Step 1.
    fn new(pair: &'p PairRecord, tolerance: f32, ended: Ended) -> Self {
        let Ended { out, simplex, depth_upper, depth_lower } = ended;
        let axes = out.status == code::AXES;
        let (corners, pending) = if axes { (Vec::new(), Vec::new()) } else { (simplex.to_vec(), FACES.to_vec()) };
        Self {
            pair,
            tolerance,
            out,
            corners,
            faces: Vec::new(),
            pending,
            dir: axis_direction(0),
            height: 0.0,
            lowest_face: None,
            lowest_height: 0.0,
            depth_upper,
            depth_lower,
            axes,
        }
    }

    /// Steps 2 to 4. An error is the status with which the search ends.
    fn expand(&mut self, run: &mut Run<'_>, max_steps: u32) -> Result<(), u32> {
        if !self.pending.is_empty() {
            self.add_faces()?;
        }
        if self.out.steps >= max_steps {
            return Err(code::BUDGET);
        }
        self.out.steps += 1;
        let Some(reached) = reach::<FUSED>(run, self.pair, self.dir) else { return Err(code::BUDGET) };
        self.bound_depth(&reached)?;
        let apex = self.corners.len();
        self.corners.push(reached);
        if self.axes {
            self.turn_to_next_axis();
            return Ok(());
        }
        self.pending = open_horizon::<FUSED>(&mut self.faces, reached.w, apex, self.pair.rounding);
        if self.pending.is_empty() {
            self.faces.clear();
            return Err(code::STALLED);
        }
        Ok(())
    }

    /// Step 2: the pending triangles become faces.
    fn add_faces(&mut self) -> Result<(), u32> {
        let corners = &self.corners;
        self.faces.extend(self.pending.drain(..).map(|triangle| face::<FUSED>(corners, triangle)));
        let mut lowest = 0;
        self.height = -LOWEST;
        for (at, face) in self.faces.iter().enumerate() {
            if face.height < self.height {
                lowest = at;
                self.height = face.height;
            }
        }
        // NaN takes the failing branch.
        if !(self.height > 0.0) {
            return Err(code::STALLED);
        }
        if self.height - self.pair.rounding > self.depth_lower {
            self.depth_lower = self.height - self.pair.rounding;
        }
        self.lowest_face = Some(self.faces[lowest].corners);
        self.lowest_height = self.height;
        self.dir = self.faces[lowest].normal;
        Ok(())
    }

    /// Step 3: the plane at the support point bounds the depth from above.
    fn bound_depth(&mut self, reached: &Corner) -> Result<(), u32> {
        let error = self.pair.rounding;
        let along = dot::<FUSED>(reached.w, self.dir);
        if along < self.depth_upper {
            self.depth_upper = along;
            self.out.normal = self.dir;
        }
        if -self.depth_upper > error {
            return Err(code::SEPARATED);
        }
        if !self.axes {
            if self.depth_upper - self.height <= self.tolerance * self.depth_upper + 2.0 * error {
                return Err(code::OVERLAPPING);
            }
            if self.corners.len() == MAX_VERTICES {
                return Err(code::BUDGET);
            }
            if self.corners.iter().any(|corner| corner.w == reached.w) {
                return Err(code::STALLED);
            }
        }
        Ok(())
    }

    /// The next support point along the axes, or the octahedron of all six.
    fn turn_to_next_axis(&mut self) {
        if self.corners.len() < 6 {
            self.dir = axis_direction(self.corners.len());
            return;
        }
        self.axes = false;
        self.pending.extend((0..8).map(|face| {
            let (i, j, k) = (face & 1, 2 + (face >> 1 & 1), 4 + (face >> 2));
            if (face ^ face >> 1 ^ face >> 2) & 1 == 0 { [i, j, k] } else { [i, k, j] }
        }));
    }

    /// Step 5: the closest point of the lowest face, and of those as low. A facet has several
    /// triangles.
    fn find_witness(&mut self) {
        let Some(lowest) = self.lowest_face else { return };
        let limit = self.lowest_height + (self.tolerance * self.depth_upper + 2.0 * self.pair.rounding);
        let mut square = -LOWEST;
        let as_low = self.faces.iter().filter(|face| face.height > 0.0 && face.height <= limit);
        for triangle in std::iter::once(lowest).chain(as_low.map(|face| face.corners)) {
            let [i, j, k] = triangle.map(|corner| self.corners[corner]);
            let simplex = [i, j, k, Corner::default()];
            let closest = on_triangle::<FUSED>(&simplex, 0, 1, 2);
            if closest.square < square {
                square = closest.square;
                self.out.between = closest.y;
                self.out.offset = [0.0; 3];
                for (corner, weight) in simplex.iter().zip(closest.weights).take(3) {
                    for axis in 0..3 {
                        self.out.offset[axis] = mad::<FUSED>(corner.offset[axis], weight, self.out.offset[axis]);
                    }
                }
            }
        }
    }

    /// The answer, with its bounds widened by the rounding error.
    fn finish(self) -> AnswerRecord {
        let Self { mut out, depth_upper, depth_lower, .. } = self;
        out.lower = depth_lower;
        out.upper = 0.0;
        if depth_upper + self.pair.rounding > 0.0 {
            out.upper = depth_upper + self.pair.rounding;
        }
        if out.status == code::SEPARATED {
            out.lower = 0.0;
            out.upper = 0.0;
        } else if !(depth_lower > 0.0) && out.status != code::BUDGET {
            out.status = code::OPEN;
        }
        out
    }
}
