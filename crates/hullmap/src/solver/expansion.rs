//! Depth phase: expand a polytope inside the Minkowski difference until its nearest face is a true face (EPA).
//!
//! Computes the least support value h(n) over all unit normals n, which is the penetration depth, as an interval; or
//! a separating plane, when the origin turns out to be outside.
//!
//! # Reference
//! van den Bergen 2001 (expanding polytope), cited by Kenwright as [15]. It takes over from phase two, whose depth depends on
//! the centre ray.
//!
//! # Steps
//! 1. start from the tetrahedron of v0 and the portal, or from one of [`seed`](super::seed);
//! 2. take the face nearest to the origin, its plane at d with normal n; d bounds the depth from below;
//! 3. w = support along n; h(n) = w · n bounds it from above;
//! 4. stop when the bounds are close; otherwise insert w; again.
//!
//! # Deviations
//! - "Nearest" is by signed offset, so the origin need not be inside at the start: while it is outside the polytope grows
//!   towards it, until it is inside or a support plane proves it outside. No portal can be too bad to start from.
//! - The least h(n) of all faces tried is kept with its face, so the upper bound never grows.
//! - Bounds that are close do not end the search before the contact points are good: if the face of the least h(n) is not on the
//!   surface itself, the nearest face is asked once more; and a portal's face without the origin's foot in it gives none.
//! - The ball of the interior points bounds the depth from below as well: round shapes end at once.
//! - Small and big polytopes: most queries never touch the big arrays.

use super::barycentric::{blend, on_triangle};
use super::closest::{self, Simplex, closest};
use super::polytope::{Polytope, Refused};
use super::seed::{Flat, seed};
use crate::SupportMap;
use crate::minkowski::{Minkowski, Vertex};
use glam::DVec3;

/// Vertices of the small polytope: enough for 9 in 10 queries on small hulls.
const SMALL: usize = 32;

/// Vertices of the big polytope, and so the cap on expansions: bytes number them.
const BIG: usize = 256;

/// Most steps of the closest-point search on flat differences.
const MAX_FLAT: u32 = 100;

/// A portal whose tetrahedron has a height of no more than this many roundings is no start: its planes would be noise.
const THIN_ROUNDINGS: f64 = 64.0;

/// Support values up to this many roundings are touching: one for the support point, one for the normal.
pub(super) const TOUCHING_ROUNDINGS: f64 = 2.0;

/// A foot this share of its distance beside the face is as good as in it: contact points are off by as much.
const FOOT_OFF: f64 = 1e-3;

/// What to expand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Goal {
    /// Only whether the origin is inside.
    Decide,
    /// The depth, until upper − lower ≤ tolerance · upper + rounding.
    Depth { tolerance: f64 },
}

/// Why the expansion ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The origin is outside; the normal separates.
    Separated,
    /// The origin is on the surface, within rounding.
    Touching,
    /// The origin is inside; the bounds are as far apart as they were then.
    Inside,
    /// The bounds are close enough.
    Converged,
    /// The cap was reached.
    Limit,
    /// Rounding stopped all progress.
    Stalled,
}

/// A face's normal, its support value, and the points of A and B on it that are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Support value of the difference along `normal`.
    pub(super) upper: f64,
    /// Of unit length, from A to B.
    pub(super) normal: DVec3,
    pub(super) face: [Vertex; 3],
}

/// The outcome of the expansion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion {
    pub(super) end: End,
    /// The depth is no less than this, but for rounding; negative when nothing is known.
    pub(super) lower: f64,
    pub(super) bound: Bound,
    pub(super) iterations: u32,
}

impl Bound {
    /// No bound yet.
    pub(super) fn none() -> Self {
        Self { upper: f64::INFINITY, normal: DVec3::ZERO, face: [Vertex::EMPTY; 3] }
    }

    /// Whether the face lies on the surface, so that points on it are as deep as the bound says.
    fn is_tight(&self, tolerance: f64, rounding: f64) -> bool {
        self.upper - self.normal.dot(self.face[0].w) <= tolerance * self.upper + rounding
    }

    /// Whether the foot of the origin on the face's plane lies in the face. A polytope's nearest face has it; a portal
    /// that the centre ray meets need not, and then gives no contact points however good its normal.
    fn has_foot(&self, rounding: f64) -> bool {
        let [p, q, r] = self.face.map(|v| v.w);
        let foot = self.normal * self.normal.dot(p);
        foot.distance(on_triangle(p, q, r).point) <= FOOT_OFF * foot.length() + rounding
    }

    /// The point of A and the point of B where the face is nearest to the origin.
    pub(super) fn points(&self) -> (DVec3, DVec3) {
        let [p, q, r] = self.face.map(|v| v.w);
        let weights = on_triangle(p, q, r).weights;
        (blend(&weights, self.face.map(|v| v.a)), blend(&weights, self.face.map(|v| v.b)))
    }
}

/// Expands from `start`, if it has a volume, otherwise from a tetrahedron found here. `bound` is what is known already.
pub(super) fn expand<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Vertex; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
) -> Expansion {
    let ball = m.inner_radius() - m.center().w.length();
    let mut state = Expansion { end: End::Limit, lower: f64::NEG_INFINITY, bound, iterations: 0 };
    let mut small = Polytope::empty(m.rounding());
    let thin = THIN_ROUNDINGS * m.rounding();
    if !start.is_some_and(|tetrahedron| small.start(tetrahedron, thin)) {
        match seed(m) {
            Ok(tetrahedron) if small.start(tetrahedron, 0.0) => {}
            Ok(_) => {
                state.end = End::Stalled;
                state.lower = ball;
                return state;
            }
            Err(Flat { normal }) => return expand_flat(m, normal, state),
        }
    }
    if !run::<A, B, SMALL, { 2 * SMALL - 4 }>(m, &mut small, &mut state, goal, ball, max_expansions) {
        expand_big(m, &small, &mut state, goal, ball, max_expansions);
    }
    state
}

/// Goes on with more room. Apart, so that the small path's stack stays small.
#[inline(never)]
fn expand_big<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    small: &Polytope<SMALL, { 2 * SMALL - 4 }>,
    state: &mut Expansion,
    goal: Goal,
    ball: f64,
    max_expansions: u32,
) {
    let mut big: Polytope<BIG, { 2 * BIG - 4 }> = small.grown();
    // Without room the cap is reached: that is what the state says already.
    run(m, &mut big, state, goal, ball, max_expansions);
}

/// Expands until done, true, or until there is no more room, false: then `state` is as before the last step.
fn run<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    state: &mut Expansion,
    goal: Goal,
    ball: f64,
    max_expansions: u32,
) -> bool {
    let rounding = m.rounding();
    let tolerance = match goal {
        Goal::Decide => 0.0,
        Goal::Depth { tolerance } => tolerance,
    };
    loop {
        // 2. The nearest face bounds the depth from below.
        let face = polytope.nearest_face();
        let (offset, normal) = (polytope.offset(face), polytope.normal(face));
        state.lower = offset.max(ball);
        if goal == Goal::Decide && state.lower > rounding {
            state.end = End::Inside;
            return true;
        }
        // No bound yet is infinite, and infinity is within a tolerance of infinity.
        let close = state.bound.upper < f64::INFINITY
            && state.bound.upper - state.lower <= tolerance * state.bound.upper + rounding;
        if close && state.bound.is_tight(tolerance, rounding) && state.bound.has_foot(rounding) {
            state.end = End::Converged;
            return true;
        }
        // At least once: without a step there may be no bound at all.
        if state.iterations >= max_expansions && state.bound.upper < f64::INFINITY {
            state.end = End::Limit;
            return true;
        }
        if polytope.is_full() {
            state.end = End::Limit;
            return false;
        }
        state.iterations += 1;
        // 3. The support plane bounds it from above.
        let vertex = m.support(normal);
        let value = vertex.w.dot(normal);
        let tight = value - offset <= tolerance * value + rounding;
        let separated = value < -rounding;
        let touching = value <= TOUCHING_ROUNDINGS * rounding;
        if value < state.bound.upper || tight || touching {
            // Of the faces in this plane the one that the origin's foot is in.
            let face = if tight { polytope.face_of_foot(face, rounding) } else { face };
            state.bound = Bound { upper: value, normal, face: polytope.face_vertices(face) };
        }
        // 4. Close enough, or go on.
        if separated || touching || tight || (close && state.bound.has_foot(rounding)) {
            state.end = if separated {
                End::Separated
            } else if touching {
                End::Touching
            } else {
                End::Converged
            };
            return true;
        }
        // NaN counts as no progress.
        let above = value > offset;
        if !above || polytope.has_vertex(vertex.w) || polytope.insert(vertex, face) == Err(Refused::Contradiction) {
            state.end = End::Stalled;
            return true;
        }
    }
}

/// A difference without thickness along `normal`: its depth is zero, if it holds the origin at all.
#[inline(never)]
fn expand_flat<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    normal: DVec3,
    mut state: Expansion,
) -> Expansion {
    let near = closest(m, Simplex::new(m.center()), 0.0, MAX_FLAT);
    state.iterations += near.iterations;
    state.lower = 0.0;
    let first = near.simplex.vertices()[0];
    // A face that says where they touch; weights are found again from it.
    let mut face = [first; 3];
    for (corner, vertex) in face.iter_mut().zip(near.simplex.vertices()) {
        *corner = *vertex;
    }
    if near.lower > m.rounding() {
        state.end = End::Separated;
        state.bound = Bound { upper: -near.lower, normal: near.normal, face };
        return state;
    }
    let value = m.support(normal).w.dot(normal);
    state.bound = Bound { upper: value.max(0.0), normal, face };
    state.end = if near.end == closest::End::AtOrigin
        || near.end == closest::End::Inside
        || near.upper <= TOUCHING_ROUNDINGS * m.rounding()
    {
        End::Touching
    } else {
        End::Stalled
    };
    state
}
