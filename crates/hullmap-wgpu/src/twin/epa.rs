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
    let Ended { mut out, simplex, mut depth_upper, mut depth_lower } = ended;
    let error = pair.rounding;
    let mut dir = axis_direction(0);
    let mut corners: Vec<Corner> = Vec::new();
    let mut faces: Vec<Face> = Vec::new();
    let mut pending: Vec<Triangle> = Vec::new();
    let mut height = 0.0;
    // The lowest face so far, of a closed surface with certain volumes.
    let mut lowest_face = None;
    let mut lowest_height = 0.0;
    let mut axes = out.status == code::AXES;
    if !axes {
        corners.extend(simplex);
        pending.extend(FACES);
    }
    out.status = loop {
        if !pending.is_empty() {
            faces.extend(pending.drain(..).map(|triangle| face::<FUSED>(&corners, triangle)));
            let mut lowest = 0;
            height = -LOWEST;
            for (at, face) in faces.iter().enumerate() {
                if face.height < height {
                    lowest = at;
                    height = face.height;
                }
            }
            // NaN takes the failing branch.
            if !(height > 0.0) {
                break code::STALLED;
            }
            if height - error > depth_lower {
                depth_lower = height - error;
            }
            lowest_face = Some(faces[lowest].corners);
            lowest_height = height;
            dir = faces[lowest].normal;
        }
        if out.steps >= max_steps {
            break code::BUDGET;
        }
        out.steps += 1;
        let Some(reached) = reach::<FUSED>(run, pair, dir) else { break code::BUDGET };
        let along = dot::<FUSED>(reached.w, dir);
        if along < depth_upper {
            depth_upper = along;
            out.normal = dir;
        }
        if -depth_upper > error {
            break code::SEPARATED;
        }
        if !axes {
            if depth_upper - height <= tolerance * depth_upper + 2.0 * error {
                break code::OVERLAPPING;
            }
            if corners.len() == MAX_VERTICES {
                break code::BUDGET;
            }
            if corners.iter().any(|corner| corner.w == reached.w) {
                break code::STALLED;
            }
        }
        let apex = corners.len();
        corners.push(reached);
        if axes {
            if corners.len() < 6 {
                dir = axis_direction(corners.len());
                continue;
            }
            axes = false;
            pending.extend((0..8).map(|face| {
                let (i, j, k) = (face & 1, 2 + (face >> 1 & 1), 4 + (face >> 2));
                if (face ^ face >> 1 ^ face >> 2) & 1 == 0 { [i, j, k] } else { [i, k, j] }
            }));
            continue;
        }
        pending = open_horizon::<FUSED>(&mut faces, reached.w, apex, error);
        if pending.is_empty() {
            faces.clear();
            break code::STALLED;
        }
    };
    // The closest point of the lowest face, and of those as low: a facet has several triangles.
    let limit = lowest_height + (tolerance * depth_upper + 2.0 * error);
    let mut square = -LOWEST;
    if let Some(lowest) = lowest_face {
        let as_low = faces.iter().filter(|face| face.height > 0.0 && face.height <= limit).map(|face| face.corners);
        for triangle in std::iter::once(lowest).chain(as_low) {
            let [i, j, k] = triangle.map(|corner| corners[corner]);
            let simplex = [i, j, k, Corner::default()];
            let closest = on_triangle::<FUSED>(&simplex, 0, 1, 2);
            if closest.square < square {
                square = closest.square;
                out.between = closest.y;
                out.offset = [0.0; 3];
                for (corner, weight) in simplex.iter().zip(closest.weights).take(3) {
                    for axis in 0..3 {
                        out.offset[axis] = mad::<FUSED>(corner.offset[axis], weight, out.offset[axis]);
                    }
                }
            }
        }
    }
    out.lower = depth_lower;
    out.upper = 0.0;
    if depth_upper + error > 0.0 {
        out.upper = depth_upper + error;
    }
    if out.status == code::SEPARATED {
        out.lower = 0.0;
        out.upper = 0.0;
    } else if !(depth_lower > 0.0) && out.status != code::BUDGET {
        out.status = code::OPEN;
    }
    out
}
