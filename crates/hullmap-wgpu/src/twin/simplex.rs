//! Points of the Minkowski difference, and the closest point of a simplex: `kernels/simplex.wgsl`
//! in Rust.

use super::support::Run;
use super::vector::{LOWEST, Vector, cross, dot, mad, scaled, sub};
use crate::records::{PairRecord, StateRecord};

/// A corner of the simplex: a point of the Minkowski difference, and A's part of it.
#[derive(Clone, Copy, Default)]
pub(super) struct Corner {
    pub(super) w: Vector,
    pub(super) offset: Vector,
    /// The vertices of A and B, as in [`StateRecord`].
    pub(super) ends: [u32; 2],
}

impl Corner {
    /// The centre of the Minkowski difference.
    pub(super) fn center(pair: &PairRecord) -> Self {
        Self { w: pair.rows.map(|row| row[3]), offset: [0.0; 3], ends: [StateRecord::CENTER; 2] }
    }

    /// A corner from two vertices, relative to the centres of their hulls, and their words in
    /// `blocks`.
    pub(super) fn new<const FUSED: bool>(pair: &PairRecord, from: [Vector; 2], at: [u32; 2]) -> Self {
        let r = pair.rows;
        let offset = scaled(from[0], pair.scale);
        let of_b = scaled(from[1], pair.scale);
        let mut w = [0.0; 3];
        for axis in 0..3 {
            let turned = mad::<FUSED>(r[axis][2], of_b[2], mad::<FUSED>(r[axis][1], of_b[1], r[axis][0] * of_b[0]));
            w[axis] = r[axis][3] + (offset[axis] - turned);
        }
        Self { w, offset, ends: at.map(|at| at.wrapping_add(StateRecord::FIRST_WORD)) }
    }
}

/// Support point of the Minkowski difference in direction `dir`, of about unit length. `None` if it
/// is not certain.
pub(super) fn reach<const FUSED: bool>(run: &mut Run<'_>, pair: &PairRecord, dir: Vector) -> Option<Corner> {
    let r = pair.rows;
    let mut along_b = [0.0; 3];
    for axis in 0..3 {
        along_b[axis] = -mad::<FUSED>(r[2][axis], dir[2], mad::<FUSED>(r[1][axis], dir[1], r[0][axis] * dir[0]));
    }
    let on_a = run.support::<FUSED>(pair.a, dir);
    let on_b = run.support::<FUSED>(pair.b, along_b);
    let is_certain = on_a.is_certain && on_b.is_certain;
    is_certain.then(|| Corner::new::<FUSED>(pair, [on_a.offset, on_b.offset], [on_a.at, on_b.at]))
}

/// The closest point of a segment or a triangle, as weights of the corners.
#[derive(Clone, Copy)]
pub(super) struct Closest {
    pub(super) weights: [f32; 4],
    pub(super) y: Vector,
    pub(super) square: f32,
}

/// Corners of the faces of a tetrahedron, in the same order as seen from outside.
pub(super) const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

pub(super) fn on_segment<const FUSED: bool>(simplex: &[Corner; 4], i: usize, j: usize) -> Closest {
    let (a, b) = (simplex[i].w, simplex[j].w);
    let edge = sub(b, a);
    let of_a = dot::<FUSED>(b, edge);
    let of_b = -dot::<FUSED>(a, edge);
    let mut weights = [0.0; 4];
    let mut y = a;
    // NaN takes the first branch.
    if !(of_b > 0.0) {
        weights[i] = 1.0;
    } else if !(of_a > 0.0) {
        weights[j] = 1.0;
        y = b;
    } else {
        let inverse = 1.0 / (of_a + of_b);
        let (r, s) = (of_a * inverse, of_b * inverse);
        weights[i] = r;
        weights[j] = s;
        y = [mad::<FUSED>(b[0], s, a[0] * r), mad::<FUSED>(b[1], s, a[1] * r), mad::<FUSED>(b[2], s, a[2] * r)];
    }
    Closest { weights, y, square: dot::<FUSED>(y, y) }
}

pub(super) fn on_triangle<const FUSED: bool>(simplex: &[Corner; 4], i: usize, j: usize, k: usize) -> Closest {
    let (a, b, c) = (simplex[i].w, simplex[j].w, simplex[k].w);
    let (ab, ac, bc) = (sub(b, a), sub(c, a), sub(c, b));
    let normal = cross::<FUSED>(ab, ac);
    // Areas from differences of corners, so that the areas of slivers keep their digits.
    let of_a = dot::<FUSED>(cross::<FUSED>(b, bc), normal);
    let of_b = -dot::<FUSED>(cross::<FUSED>(c, ac), normal);
    let of_c = dot::<FUSED>(cross::<FUSED>(a, ab), normal);
    if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
        let inverse = 1.0 / (of_a + of_b + of_c);
        let (r, s, t) = (of_a * inverse, of_b * inverse, of_c * inverse);
        let y = [
            mad::<FUSED>(c[0], t, mad::<FUSED>(b[0], s, a[0] * r)),
            mad::<FUSED>(c[1], t, mad::<FUSED>(b[1], s, a[1] * r)),
            mad::<FUSED>(c[2], t, mad::<FUSED>(b[2], s, a[2] * r)),
        ];
        let mut weights = [0.0; 4];
        weights[i] = r;
        weights[j] = s;
        weights[k] = t;
        return Closest { weights, y, square: dot::<FUSED>(y, y) };
    }
    // NaN takes the failing branch.
    let mut best = Closest { weights: [0.0; 4], y: a, square: -LOWEST };
    best.weights[i] = 1.0;
    for (from, to, area) in [(j, k, of_a), (i, k, of_b), (i, j, of_c)] {
        if !(area > 0.0) {
            best = nearer(best, on_segment::<FUSED>(simplex, from, to));
        }
    }
    best
}

pub(super) fn nearer(a: Closest, b: Closest) -> Closest {
    if b.square < a.square { b } else { a }
}
