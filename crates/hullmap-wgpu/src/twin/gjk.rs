//! GJK: `kernels/gjk.wgsl` in Rust, without rounds.
//!
//! # Reference
//! Kenwright, section 3. E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for
//! computing the distance between complex objects in three-dimensional space", 1988.
//!
//! # Steps
//! 1. The balls around and inside the hulls may decide.
//! 2. A support call in the direction of the origin. Its plane is a lower bound of the distance. A
//!    pair that has a simplex from the last batch starts with step 3.
//! 3. The point of the simplex closest to the origin is the next upper bound.
//! 4. A tetrahedron that holds the origin by more than the rounding error proves an overlap. If it
//!    holds it by less, the search continues across its closest face.
//! 5. For a depth, EPA continues from any tetrahedron that holds the origin. If GJK finds none, it
//!    starts from the axes.

use super::query::Query;
use super::simplex::{Closest, Corner, FACES, nearer, on_segment, on_triangle, reach};
use super::support::Run;
use super::vector::{CERTAIN, LOWEST, cross, dot, l1, mad, scaled, sub};
use crate::records::{AnswerRecord, HullRecord, PairRecord, StateRecord, code};

/// Squared length below which a normal has no direction.
const NO_NORMAL: f32 = 1e-30;

/// State that GJK passes on to EPA.
pub(super) struct Ended {
    pub(super) out: AnswerRecord,
    pub(super) simplex: [Corner; 4],
    pub(super) depth_upper: f32,
    pub(super) depth_lower: f32,
}

fn is_vertex(hull: &HullRecord, stored: u32) -> bool {
    let start = StateRecord::FIRST_WORD + hull.block_start * 32;
    stored >= start && stored - start < hull.block_count * 32 && (stored - start) & 31 < 8
}

/// Puts the corners of a state into the simplex, and returns their number.
fn restore<const FUSED: bool>(
    run: &Run<'_>,
    pair: &PairRecord,
    state: &StateRecord,
    simplex: &mut [Corner; 4],
) -> usize {
    let (a, b) = (&run.tables.hulls[pair.a as usize], &run.tables.hulls[pair.b as usize]);
    let mut size = 0;
    for ends in state.corners {
        if ends[0] == StateRecord::CENTER {
            simplex[size] = Corner::center(pair);
            size += 1;
        } else if is_vertex(a, ends[0]) && is_vertex(b, ends[1]) {
            let at = ends.map(|stored| stored - StateRecord::FIRST_WORD);
            let from = [run.offset(a, at[0] as usize), run.offset(b, at[1] as usize)];
            simplex[size] = Corner::of::<FUSED>(pair, from, at);
            size += 1;
        }
    }
    size
}

/// Solves `pair` up to EPA. `state` is the simplex to start from, and becomes the final one.
pub(super) fn gjk<const FUSED: bool>(
    run: &mut Run<'_>,
    pair: &PairRecord,
    query: Query,
    tolerance: f32,
    max_steps: u32,
    state: &mut StateRecord,
) -> Ended {
    let (a, b) = (&run.tables.hulls[pair.a as usize], &run.tables.hulls[pair.b as usize]);
    let mut out = AnswerRecord { status: code::RUNNING, ..AnswerRecord::default() };
    let center = pair.rows.map(|row| row[3]);
    let error = pair.rounding;
    // Not far · far: compilers turn the square of a root into its argument.
    let center_square = dot::<FUSED>(center, center);
    let far = center_square.sqrt();
    let mut upper = far;
    let mut lower = far - (a.outer + b.outer) * pair.scale;
    let mut dir = [1.0, 0.0, 0.0];
    if far > 0.0 {
        dir = scaled(center, -(1.0 / far));
    }
    let mut square = -LOWEST;
    let mut outward = false;
    let mut depth_upper = -lower;
    let mut depth_lower = 0.0;
    out.normal = dir;
    out.between = center;
    let deep = (a.inner + b.inner) * pair.scale - far;
    if deep > error {
        depth_lower = deep - error;
    }
    if query != Query::Contact && deep > error {
        out.status = code::OVERLAPPING;
    } else if query != Query::Distance && lower > error {
        out.status = code::SEPARATED;
    }
    let mut simplex = [Corner::default(); 4];
    let mut size = restore::<FUSED>(run, pair, state, &mut simplex);
    // Whether the simplex is that of the last batch, and its closest point comes first.
    let mut restored = size > 0;
    if size == 0 {
        simplex[0] = Corner::center(pair);
        size = 1;
        square = center_square;
    }
    while out.status == code::RUNNING && (restored || out.steps < max_steps) {
        if !restored {
            out.steps += 1;
            let Some(reached) = reach::<FUSED>(run, pair, dir) else {
                out.status = code::BUDGET;
                break;
            };
            // The plane at the support point. `dir` is of unit length within the error.
            let along = dot::<FUSED>(reached.w, dir);
            if -along > lower {
                lower = -along;
                out.normal = dir;
            }
            if along < depth_upper {
                depth_upper = along;
                if query == Query::Contact {
                    out.normal = dir;
                }
            }
            let apart = lower > error;
            if apart && (query != Query::Distance || upper - lower <= tolerance * upper + 2.0 * error) {
                out.status = code::SEPARATED;
                break;
            }
            let mut stuck = outward && !(along > 2.0 * error);
            for corner in &simplex[..size] {
                if corner.w == reached.w {
                    stuck = true;
                }
            }
            if stuck {
                out.status = ended(query, apart);
                break;
            }
            simplex[size] = reached;
            size += 1;
        }
        restored = false;

        // The point of the simplex closest to the origin.
        let mut closest = Closest { weights: [1.0, 0.0, 0.0, 0.0], y: center, square: -LOWEST };
        let mut inside = size == 4;
        let mut certain = true;
        let mut least = -LOWEST;
        let mut through = 0;
        // The faces are oriented alike, outwards by this factor.
        let mut outwards = 1.0;
        let mut face_count = 0;
        if size <= 2 {
            closest = on_segment::<FUSED>(&simplex, 0, size - 1);
        } else if size == 3 {
            face_count = 1;
        } else {
            face_count = 4;
            let (e, f) = (sub(simplex[1].w, simplex[0].w), sub(simplex[2].w, simplex[0].w));
            if dot::<FUSED>(cross::<FUSED>(e, f), sub(simplex[3].w, simplex[0].w)) > 0.0 {
                outwards = -1.0;
            }
        }
        for (face, [i, j, k]) in FACES.into_iter().enumerate().take(face_count) {
            if size == 4 {
                let (p, e, f) = (simplex[i].w, sub(simplex[j].w, simplex[i].w), sub(simplex[k].w, simplex[i].w));
                let normal = scaled(cross::<FUSED>(e, f), outwards);
                let volume = dot::<FUSED>(normal, p);
                let long = dot::<FUSED>(e, e) + dot::<FUSED>(f, f);
                if volume > CERTAIN * 0.5 * long * l1(p) {
                    let length = dot::<FUSED>(normal, normal).sqrt();
                    let mut height = volume;
                    let at_j = dot::<FUSED>(normal, simplex[j].w);
                    let at_k = dot::<FUSED>(normal, simplex[k].w);
                    if at_j < height {
                        height = at_j;
                    }
                    if at_k < height {
                        height = at_k;
                    }
                    if !(height > error * length) {
                        certain = false;
                    }
                    let clearance = volume * (1.0 / length);
                    if clearance < least {
                        least = clearance;
                        through = face;
                        dir = scaled(normal, 1.0 / length);
                    }
                    continue;
                }
                inside = false;
            }
            closest = nearer(closest, on_triangle::<FUSED>(&simplex, i, j, k));
        }
        if inside {
            if query == Query::Contact {
                if outwards < 0.0 {
                    simplex.swap(0, 1);
                }
                out.status = code::TETRAHEDRON;
                break;
            }
            if certain {
                out.status = code::OVERLAPPING;
                break;
            }
            let [i, j, k] = FACES[through];
            simplex = [simplex[i], simplex[j], simplex[k], simplex[3]];
            size = 3;
            outward = true;
            continue;
        }
        outward = false;
        if !(closest.square < square) || (query == Query::Contact && !(closest.square > 0.0)) {
            out.status = ended(query, lower > error);
            break;
        }
        square = closest.square;
        upper = square.sqrt();
        out.between = closest.y;
        out.offset = [0.0; 3];
        let mut kept = 0;
        for corner in 0..size {
            let weight = closest.weights[corner];
            if weight > 0.0 {
                let from = simplex[corner];
                for axis in 0..3 {
                    out.offset[axis] = mad::<FUSED>(from.offset[axis], weight, out.offset[axis]);
                }
                simplex[kept] = from;
                kept += 1;
            }
        }
        size = kept;
        if !(upper > 0.0) {
            out.status = if query == Query::Contact { code::AXES } else { code::OPEN };
            break;
        }
        dir = scaled(closest.y, -(1.0 / upper));
        if size == 3 {
            // Close to the origin, the normal of the triangle is more accurate than the point.
            let (e, f) = (sub(simplex[1].w, simplex[0].w), sub(simplex[2].w, simplex[0].w));
            let normal = cross::<FUSED>(e, f);
            let long = dot::<FUSED>(normal, normal);
            if long > dot::<FUSED>(e, e) * dot::<FUSED>(f, f) * square && long > NO_NORMAL {
                let mut by = 1.0 / long.sqrt();
                if dot::<FUSED>(normal, simplex[0].w) > 0.0 {
                    by = -by;
                }
                dir = scaled(normal, by);
            }
        }
    }
    if out.status == code::RUNNING {
        out.status = code::BUDGET;
    }
    out.gjk_steps = out.steps;
    *state = StateRecord::default();
    for (stored, corner) in state.corners.iter_mut().zip(&simplex[..size]) {
        *stored = corner.ends;
    }
    if query == Query::Contact {
        out.lower = depth_lower;
        out.upper = 0.0;
        if depth_upper + error > 0.0 {
            out.upper = depth_upper + error;
        }
        if out.status == code::SEPARATED {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    } else {
        out.lower = 0.0;
        if lower > error {
            out.lower = lower - error;
        }
        out.upper = upper + error;
        if out.status == code::OVERLAPPING {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    }
    Ended { out, simplex, depth_upper, depth_lower }
}

/// Outcome of a pair that makes no more progress.
fn ended(query: Query, apart: bool) -> u32 {
    match query {
        Query::Contact => code::AXES,
        _ if apart => code::STALLED,
        _ => code::OPEN,
    }
}
