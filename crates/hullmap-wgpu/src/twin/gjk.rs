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
use super::vector::{CERTAIN, LOWEST, Vector, cross, dot, l1, mad, scaled, sub};
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

/// Solves `pair` up to EPA. `state` is the simplex to start from, and becomes the final one.
pub(super) fn gjk<const FUSED: bool>(
    run: &mut Run<'_>,
    pair: &PairRecord,
    query: Query,
    tolerance: f32,
    max_steps: u32,
    state: &mut StateRecord,
) -> Ended {
    let mut search = GjkSearch::<FUSED>::new(run, pair, query, tolerance);
    search.restore(run, state);
    // Whether the simplex belongs to the last batch, and its closest point comes first.
    let mut restored = search.size > 0;
    if !restored {
        search.start_at_center();
    }
    while search.out.status == code::RUNNING && (restored || search.out.steps < max_steps) {
        if restored || search.extend(run) {
            search.reduce();
        }
        restored = false;
    }
    if search.out.status == code::RUNNING {
        search.out.status = code::BUDGET;
    }
    *state = StateRecord::default();
    for (stored, corner) in state.corners.iter_mut().zip(&search.simplex[..search.size]) {
        *stored = corner.ends;
    }
    search.finish()
}

/// State of the search.
struct GjkSearch<'p, const FUSED: bool> {
    pair: &'p PairRecord,
    query: Query,
    tolerance: f32,
    out: AnswerRecord,
    simplex: [Corner; 4],
    size: usize,
    /// Direction of the next support call.
    dir: Vector,
    /// Bounds of the distance.
    upper: f32,
    lower: f32,
    /// Square of the upper bound.
    square: f32,
    /// Whether the search continues across a face of a tetrahedron that may hold the origin.
    outward: bool,
    /// Bounds of the depth.
    depth_upper: f32,
    depth_lower: f32,
}

/// The point of the simplex closest to the origin, and where the origin is in a tetrahedron.
struct Nearest {
    closest: Closest,
    /// Whether the simplex is a tetrahedron that holds the origin.
    inside: bool,
    /// Whether it holds the origin by more than the rounding error.
    certain: bool,
    /// The face closest to the origin.
    through: usize,
    /// The faces are oriented alike, outwards by this factor.
    outwards: f32,
}

/// A face of the tetrahedron that the origin is certainly behind. Lengths are in lengths of the
/// normal.
struct FaceInFront {
    normal: Vector,
    height: f32,
    /// Height of the lowest corner.
    lowest: f32,
}

impl<'p, const FUSED: bool> GjkSearch<'p, FUSED> {
    /// Step 1.
    fn new(run: &Run<'_>, pair: &'p PairRecord, query: Query, tolerance: f32) -> Self {
        let (a, b) = (&run.tables.hulls[pair.a as usize], &run.tables.hulls[pair.b as usize]);
        let mut out = AnswerRecord { status: code::RUNNING, ..AnswerRecord::default() };
        let center = pair.rows.map(|row| row[3]);
        let error = pair.rounding;
        // Not far · far: compilers turn the square of a root into its argument.
        let far = dot::<FUSED>(center, center).sqrt();
        let lower = far - (a.outer + b.outer) * pair.scale;
        let mut dir = [1.0, 0.0, 0.0];
        if far > 0.0 {
            dir = scaled(center, -(1.0 / far));
        }
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
        Self {
            pair,
            query,
            tolerance,
            out,
            simplex: [Corner::default(); 4],
            size: 0,
            dir,
            upper: far,
            lower,
            square: -LOWEST,
            outward: false,
            depth_upper: -lower,
            depth_lower,
        }
    }

    /// Puts the corners of a state into the simplex.
    fn restore(&mut self, run: &Run<'_>, state: &StateRecord) {
        let pair = self.pair;
        let (a, b) = (&run.tables.hulls[pair.a as usize], &run.tables.hulls[pair.b as usize]);
        for ends in state.corners {
            if ends[0] == StateRecord::CENTER {
                self.push(Corner::center(pair));
            } else if is_vertex(a, ends[0]) && is_vertex(b, ends[1]) {
                let at = ends.map(|stored| stored - StateRecord::FIRST_WORD);
                let from = [run.offset(a, at[0] as usize), run.offset(b, at[1] as usize)];
                self.push(Corner::new::<FUSED>(pair, from, at));
            }
        }
    }

    fn start_at_center(&mut self) {
        let corner = Corner::center(self.pair);
        self.square = dot::<FUSED>(corner.w, corner.w);
        self.push(corner);
    }

    fn push(&mut self, corner: Corner) {
        self.simplex[self.size] = corner;
        self.size += 1;
    }

    /// Step 2. Returns false if the search has ended.
    fn extend(&mut self, run: &mut Run<'_>) -> bool {
        self.out.steps += 1;
        let Some(reached) = reach::<FUSED>(run, self.pair, self.dir) else {
            self.out.status = code::BUDGET;
            return false;
        };
        self.out.status = self.bound_distance(reached.w);
        if self.out.status != code::RUNNING {
            return false;
        }
        self.push(reached);
        true
    }

    /// Step 2: the plane at the support point `w` bounds the distance from below, and the depth
    /// from above. Returns the status with which the search ends, or `RUNNING`.
    fn bound_distance(&mut self, w: Vector) -> u32 {
        let error = self.pair.rounding;
        // `dir` is of unit length within the error.
        let along = dot::<FUSED>(w, self.dir);
        if -along > self.lower {
            self.lower = -along;
            self.out.normal = self.dir;
        }
        if along < self.depth_upper {
            self.depth_upper = along;
            if self.query == Query::Contact {
                self.out.normal = self.dir;
            }
        }
        let mut stuck = self.outward && !(along > 2.0 * error);
        for corner in &self.simplex[..self.size] {
            if corner.w == w {
                stuck = true;
            }
        }
        let apart = self.lower > error;
        let narrow = self.upper - self.lower <= self.tolerance * self.upper + 2.0 * error;
        if apart && (self.query != Query::Distance || narrow) {
            code::SEPARATED
        } else if stuck {
            ended(self.query, apart)
        } else {
            code::RUNNING
        }
    }

    /// Steps 3 and 4.
    fn reduce(&mut self) {
        let found = self.nearest();
        if found.inside {
            self.end_or_go_outward(&found);
            return;
        }
        self.outward = false;
        let closest = found.closest;
        if !(closest.square < self.square) || (self.query == Query::Contact && !(closest.square > 0.0)) {
            self.out.status = ended(self.query, self.lower > self.pair.rounding);
            return;
        }
        self.square = closest.square;
        self.upper = self.square.sqrt();
        self.out.between = closest.y;
        self.keep_corners(&closest.weights);
        if !(self.upper > 0.0) {
            self.out.status = if self.query == Query::Contact { code::AXES } else { code::OPEN };
            return;
        }
        self.turn_to_origin(closest.y);
    }

    fn nearest(&mut self) -> Nearest {
        let center = self.pair.rows.map(|row| row[3]);
        let mut closest = Closest { weights: [1.0, 0.0, 0.0, 0.0], y: center, square: -LOWEST };
        if self.size == 4 {
            return self.nearest_in_tetrahedron(closest);
        }
        if self.size <= 2 {
            closest = on_segment::<FUSED>(&self.simplex, 0, self.size - 1);
        } else {
            let [i, j, k] = FACES[0];
            closest = nearer(closest, on_triangle::<FUSED>(&self.simplex, i, j, k));
        }
        Nearest { closest, inside: false, certain: true, through: 0, outwards: 1.0 }
    }

    /// If the tetrahedron holds the origin, `dir` becomes the normal of the closest face.
    fn nearest_in_tetrahedron(&mut self, closest: Closest) -> Nearest {
        let mut found = Nearest { closest, inside: true, certain: true, through: 0, outwards: 1.0 };
        let [o, p, q, r] = self.simplex.map(|corner| corner.w);
        let (e, f) = (sub(p, o), sub(q, o));
        if dot::<FUSED>(cross::<FUSED>(e, f), sub(r, o)) > 0.0 {
            found.outwards = -1.0;
        }
        let mut least = -LOWEST;
        for (face, corners) in FACES.into_iter().enumerate() {
            let Some(FaceInFront { normal, height, lowest }) = self.face_in_front(corners, found.outwards) else {
                found.inside = false;
                let [i, j, k] = corners;
                found.closest = nearer(found.closest, on_triangle::<FUSED>(&self.simplex, i, j, k));
                continue;
            };
            let length = dot::<FUSED>(normal, normal).sqrt();
            if !(lowest > self.pair.rounding * length) {
                found.certain = false;
            }
            let clearance = height * (1.0 / length);
            if clearance < least {
                least = clearance;
                found.through = face;
                self.dir = scaled(normal, 1.0 / length);
            }
        }
        found
    }

    /// A face of the tetrahedron, if the origin is certainly behind it.
    fn face_in_front(&self, corners: [usize; 3], outwards: f32) -> Option<FaceInFront> {
        let [p, q, r] = corners.map(|corner| self.simplex[corner].w);
        let (e, f) = (sub(q, p), sub(r, p));
        let normal = scaled(cross::<FUSED>(e, f), outwards);
        let height = dot::<FUSED>(normal, p);
        let long = dot::<FUSED>(e, e) + dot::<FUSED>(f, f);
        // NaN takes the failing branch.
        if !(height > CERTAIN * 0.5 * long * l1(p)) {
            return None;
        }
        let mut lowest = height;
        for corner in [q, r] {
            let at = dot::<FUSED>(normal, corner);
            if at < lowest {
                lowest = at;
            }
        }
        Some(FaceInFront { normal, height, lowest })
    }

    /// Step 4: the tetrahedron holds the origin.
    fn end_or_go_outward(&mut self, found: &Nearest) {
        if self.query == Query::Contact {
            if found.outwards < 0.0 {
                self.simplex.swap(0, 1);
            }
            self.out.status = code::TETRAHEDRON;
            return;
        }
        if found.certain {
            self.out.status = code::OVERLAPPING;
            return;
        }
        let [i, j, k] = FACES[found.through];
        self.simplex = [self.simplex[i], self.simplex[j], self.simplex[k], self.simplex[3]];
        self.size = 3;
        self.outward = true;
    }

    /// Keeps the corners with positive weights, and computes A's part of the closest point.
    fn keep_corners(&mut self, weights: &[f32; 4]) {
        self.out.offset = [0.0; 3];
        let mut kept = 0;
        for (corner, &weight) in weights.iter().enumerate().take(self.size) {
            if weight > 0.0 {
                let from = self.simplex[corner];
                for axis in 0..3 {
                    self.out.offset[axis] = mad::<FUSED>(from.offset[axis], weight, self.out.offset[axis]);
                }
                self.simplex[kept] = from;
                kept += 1;
            }
        }
        self.size = kept;
    }

    /// Turns `dir` from the closest point `y` to the origin.
    fn turn_to_origin(&mut self, y: Vector) {
        self.dir = scaled(y, -(1.0 / self.upper));
        if self.size == 3 {
            // Close to the origin, the normal of the triangle is more accurate than the point.
            let [o, p, q, _] = self.simplex.map(|corner| corner.w);
            let (e, f) = (sub(p, o), sub(q, o));
            let normal = cross::<FUSED>(e, f);
            let long = dot::<FUSED>(normal, normal);
            if long > dot::<FUSED>(e, e) * dot::<FUSED>(f, f) * self.square && long > NO_NORMAL {
                let mut by = 1.0 / long.sqrt();
                if dot::<FUSED>(normal, o) > 0.0 {
                    by = -by;
                }
                self.dir = scaled(normal, by);
            }
        }
    }

    /// The answer, with its bounds widened by the rounding error.
    fn finish(self) -> Ended {
        let Self { mut out, simplex, upper, lower, depth_upper, depth_lower, .. } = self;
        let error = self.pair.rounding;
        out.gjk_steps = out.steps;
        if self.query == Query::Contact {
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
}

/// Outcome of a pair that makes no more progress.
fn ended(query: Query, apart: bool) -> u32 {
    match query {
        Query::Contact => code::AXES,
        _ if apart => code::STALLED,
        _ => code::OPEN,
    }
}
