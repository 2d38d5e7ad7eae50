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
//! 1. start from the tetrahedron of v0 and the portal, from the last query's polytope under the new pose, or from a
//!    tetrahedron of [`seed`](super::seed);
//! 2. take the face nearest to the origin, its plane at d with normal n; d bounds the depth from below;
//! 3. w = support along n; h(n) = w · n bounds it from above;
//! 4. stop when the bounds are close; otherwise insert w; again.
//!
//! # Deviations
//! - "Nearest" is by signed offset, so the origin need not be inside at the start: while it is outside the polytope grows
//!   towards it, until it is inside or a support plane proves it outside. No portal can be too bad to start from.
//! - d is a bound only once the surface is certain to wind around the origin; until then nothing is claimed.
//! - The least h(n) of all faces tried is kept with its face, so the upper bound never grows.
//! - Bounds that are close do not end the search before the contact points are good: if the face of the least h(n) is not on the
//!   surface itself, or is without the origin's foot, the nearest face is asked, until a face, or a support point, gives them.
//! - The ball of the interior points bounds the depth from below as well: round shapes end at once.
//! - Polytopes come in four sizes: most queries never touch the big arrays.

use super::barycentric::{blend, on_triangle};
use super::cache::{Cache, MOST_POINTS};
use super::closest::{self, Simplex, closest};
use super::polytope::{COPLANAR_NOISES, Polytope};
use super::seed::{Flat, seed};
use crate::SupportMap;
use crate::minkowski::{Minkowski, Point, unit};
use glam::DVec3;

/// Vertices of the polytopes, from the first to the last: enough for small hulls and for touching ones, for nearly all, for
/// sphere-like hulls, and for what a query may cost at all.
const SIZES: [usize; 4] = [24, 64, 256, 1024];

/// Most steps of the closest-point search on flat differences.
const MAX_FLAT: u32 = 100;

/// A portal whose tetrahedron has a height of no more than this many roundings is no start: its planes would be noise.
const THIN_ROUNDINGS: f64 = 64.0;

/// Support values up to this many roundings are touching: one for the support point, one for the normal.
pub(super) const TOUCHING_ROUNDINGS: f64 = 2.0;

/// Support values of flat differences that still are touching: their thickness is up to half of this, along a normal that is as uncertain.
pub(super) const FLAT_ROUNDINGS: f64 = 16.0;

/// Contact points of a touching face that are farther apart than this many roundings say that the origin is beside the face.
const BESIDE_ROUNDINGS: f64 = 4.0;

/// A foot this share of its distance beside the face is as good as in it: contact points are off by as much.
const FOOT_OFF: f64 = 1e-3;

/// Vertices that a polytope has when it is kept for the next query, unless it ends with fewer. More would be vertices of small faces
/// about the nearest one, which turn into dents when the pose changes, and each dent costs a support call again.
const KEEP: usize = MOST_POINTS;

/// Expansions from a kept polytope after which it is not kept any longer: it has grown stale.
const WORN_OUT: u32 = 8;

/// Room that a kept polytope must find in the smallest one.
const SPARE: usize = 6;

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

/// The least support value along a face's normal, and the points of A and B on the face that are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Support value of the difference along `normal`.
    pub(super) upper: f64,
    /// Of unit length, from A to B.
    pub(super) normal: DVec3,
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
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
        Self { upper: f64::INFINITY, normal: DVec3::ZERO, point_a: DVec3::ZERO, point_b: DVec3::ZERO }
    }

    /// A bound, with the points where the face is nearest to the origin.
    pub(super) fn at(upper: f64, normal: DVec3, face: [&Point; 3]) -> Self {
        let [p, q, r] = face.map(|v| v.w);
        let weights = on_triangle(p, q, r).weights;
        let (point_a, point_b) = (blend(&weights, face.map(|v| v.a)), blend(&weights, face.map(|v| v.b())));
        Self { upper, normal, point_a, point_b }
    }
}

/// Whether the foot of the origin on the plane through a face with this unit normal lies in the face. A polytope's nearest
/// face has it; another need not, and then gives no contact points however good its normal.
fn has_foot([p, q, r]: [DVec3; 3], normal: DVec3, rounding: f64) -> bool {
    let foot = normal * normal.dot(p);
    foot.distance(on_triangle(p, q, r).point) <= FOOT_OFF * foot.length() + rounding
}

/// What does not change during an expansion.
#[derive(Clone, Copy, Debug)]
struct Terms {
    goal: Goal,
    tolerance: f64,
    /// Lower bound of the depth by the balls in the shapes.
    ball: f64,
    /// Below this least offset, inserting a vertex may turn the surface around the origin.
    safe: f64,
    max_expansions: u32,
}

/// What does.
#[derive(Clone, Copy, Debug)]
struct State {
    out: Expansion,
    /// The corners of the bound's face; its points are found in the end. None where the bound came from outside.
    corners: Option<[u16; 3]>,
    /// The surface is certain to wind around the origin.
    encloses: bool,
}

/// Expands from `start`, if it has a volume, otherwise from a tetrahedron found here. `bound` is what is known already. With a
/// `cache`, keeps the polytope there.
pub(super) fn expand<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
    cache: Option<&mut Cache>,
) -> Expansion {
    let expansion = expand_from(m, start, goal, bound, max_expansions, cache);
    settle(m, expansion)
}

/// Looks after the points of A and of B that come with the bound.
///
/// A face in whose plane the origin lies proves nothing where the origin is beside the face, not on it: flat shapes in one plane, apart
/// in it. Then the closest points are asked. And where no face near the surface had the origin's foot, as on a cylinder around a ball
/// until the steps run out, points that are less deep than the bound give way to a support point.
#[inline]
fn settle<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    mut expansion: Expansion,
) -> Expansion {
    let Bound { upper, normal, point_a, point_b } = expansion.bound;
    let between = point_a - point_b;
    let (beside, shallow) = (BESIDE_ROUNDINGS * m.rounding(), (1.0 - FOOT_OFF) * upper - m.rounding());
    if expansion.end == End::Touching && between.length_squared() > beside * beside {
        return settle_beside(m, expansion);
    }
    // Along the normal, not as long: radii are added to them along it.
    if shallow > 0.0 && upper < f64::INFINITY && between.dot(normal) < shallow {
        let point = m.point(normal);
        (expansion.bound.point_a, expansion.bound.point_b) = (point.a, point.b());
    }
    expansion
}

#[cold]
#[inline(never)]
fn settle_beside<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    mut expansion: Expansion,
) -> Expansion {
    let mut simplex = Simplex::new(m.center_point());
    let near = closest(m, &mut simplex, 0.0, MAX_FLAT);
    let (point_a, point_b, between) = simplex.witnesses(near.upper, m.noise());
    expansion.iterations += near.iterations;
    let bound = &mut expansion.bound;
    if near.lower > m.rounding() {
        expansion.end = End::Separated;
        *bound = Bound { upper: -near.lower, normal: near.normal, point_a, point_b };
    } else if between.length_squared() < bound.point_a.distance_squared(bound.point_b) {
        (bound.point_a, bound.point_b) = (point_a, point_b);
    }
    expansion
}

fn expand_from<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
    mut cache: Option<&mut Cache>,
) -> Expansion {
    let terms = terms(m, goal, max_expansions);
    let mut state = fresh(bound);
    let mut small = Polytope::<{ SIZES[0] }, { 2 * SIZES[0] }>::empty(m.noise());
    let thin = THIN_ROUNDINGS * m.rounding();
    if !start.is_some_and(|tetrahedron| small.start(tetrahedron, thin)) {
        match seed(m) {
            Ok(tetrahedron) if small.start(tetrahedron, 0.0) => {}
            // Thick only by the noise in the normal of a thin triangle.
            Ok(tetrahedron) => return expand_flat(m, widest(tetrahedron), state.out),
            Err(Flat { normal }) => return expand_flat(m, normal, state.out),
        }
    }
    state.encloses = small.encloses();
    if let Some(cache) = &mut cache {
        cache.forget_polytope();
    }
    if !run(m, &mut small, &mut state, &terms, cache.as_deref_mut()) {
        let mut medium = small.grown::<{ SIZES[1] }, { 2 * SIZES[1] }>();
        return expand_more(m, &mut medium, &mut state, &terms, cache);
    }
    finish(&small, &mut state, cache)
}

/// Expands from the polytope in `cache`, if there is one that encloses the origin under the new pose, and if that gets
/// anywhere.
pub(super) fn expand_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    goal: Goal,
    max_expansions: u32,
    cache: &mut Cache,
) -> Option<Expansion> {
    let points = cache.polytope()?.points().len();
    let terms = terms(m, goal, max_expansions);
    let expansion = if points + SPARE <= SIZES[0] {
        let mut small = Polytope::<{ SIZES[0] }, { 2 * SIZES[0] }>::empty(m.noise());
        let mut state = restore(m, &mut small, cache)?;
        if run(m, &mut small, &mut state, &terms, None) {
            finish(&small, &mut state, Some(cache))
        } else {
            let mut medium = small.grown::<{ SIZES[1] }, { 2 * SIZES[1] }>();
            expand_more(m, &mut medium, &mut state, &terms, Some(cache))
        }
    } else {
        expand_medium_again(m, &terms, cache)?
    };
    if expansion.iterations > WORN_OUT {
        cache.forget_polytope();
    }
    (expansion.end != End::Stalled).then(|| settle(m, expansion))
}

/// Apart, so that the small path's stack stays small.
#[inline(never)]
fn expand_medium_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    terms: &Terms,
    cache: &mut Cache,
) -> Option<Expansion> {
    let mut medium = Polytope::<{ SIZES[1] }, { 2 * SIZES[1] }>::empty(m.noise());
    let mut state = restore(m, &mut medium, cache)?;
    Some(if run(m, &mut medium, &mut state, terms, None) {
        finish(&medium, &mut state, Some(cache))
    } else {
        expand_big(m, &medium, &mut state, terms)
    })
}

/// The polytope in `cache` under the new pose; nothing if it does not enclose the origin for certain.
#[inline]
fn restore<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    cache: &Cache,
) -> Option<State> {
    let kept = cache.polytope()?;
    let points = kept.points().map(|features| m.recall(features));
    let encloses = polytope.restore(points, kept.faces()) && polytope.encloses();
    encloses.then(|| State { encloses: true, ..fresh(Bound::none()) })
}

fn terms<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    goal: Goal,
    max_expansions: u32,
) -> Terms {
    let tolerance = match goal {
        Goal::Decide => 0.0,
        Goal::Depth { tolerance } => tolerance,
    };
    let ball = m.inner_radius() - m.center_point().w.length();
    Terms { goal, tolerance, ball, safe: (COPLANAR_NOISES + 1.0) * m.noise(), max_expansions }
}

fn fresh(bound: Bound) -> State {
    let out = Expansion { end: End::Limit, lower: f64::NEG_INFINITY, bound, iterations: 0 };
    State { out, corners: None, encloses: false }
}

/// Goes on with more room.
#[inline(never)]
fn expand_more<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &mut Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
    mut cache: Option<&mut Cache>,
) -> Expansion {
    if run(m, medium, state, terms, cache.as_deref_mut()) {
        return finish(medium, state, cache);
    }
    expand_big(m, medium, state, terms)
}

/// And with more. What is as big as this is not kept.
#[inline(never)]
fn expand_big<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut big = medium.grown::<{ SIZES[2] }, { 2 * SIZES[2] }>();
    if run(m, &mut big, state, terms, None) {
        return finish(&big, state, None);
    }
    expand_biggest(m, &big, state, terms)
}

#[inline(never)]
fn expand_biggest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    big: &Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut biggest = big.grown::<{ SIZES[3] }, { 2 * SIZES[3] }>();
    // Without room the cap is reached: that is what the state says already.
    run(m, &mut biggest, state, terms, None);
    finish(&biggest, state, None)
}

fn finish<const V: usize, const F: usize>(
    polytope: &Polytope<V, F>,
    state: &mut State,
    cache: Option<&mut Cache>,
) -> Expansion {
    if let Some(corners) = state.corners {
        let Bound { upper, normal, .. } = state.out.bound;
        state.out.bound = Bound::at(upper, normal, corners.map(|i| polytope.point(i)).each_ref());
    }
    if let Some(cache) = cache {
        if !state.encloses || state.out.end == End::Stalled {
            cache.forget_polytope();
        } else if polytope.point_count() <= KEEP {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
    }
    state.out
}

/// Expands until done, true, or until there is no more room, false: then `state` is as before the last step.
fn run<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
    mut cache: Option<&mut Cache>,
) -> bool {
    let (noise, rounding) = (m.noise(), m.rounding());
    let Terms { goal, tolerance, ball, safe, max_expansions } = *terms;
    loop {
        // 2. The nearest face bounds the depth from below.
        let face = polytope.nearest_face();
        let (direction, length, offset) = polytope.plane(face);
        if offset > safe && !state.encloses {
            state.encloses = polytope.check_encloses();
        }
        state.out.lower = if state.encloses { offset.max(ball) } else { ball };
        if goal == Goal::Decide && state.out.lower > rounding {
            state.out.end = End::Inside;
            return true;
        }
        // No bound yet is infinite, and infinity is within a tolerance of infinity.
        let upper = state.out.bound.upper;
        let close = upper < f64::INFINITY && upper - state.out.lower <= tolerance * upper + rounding;
        if close {
            // Where the bound's face is on the surface, points on it are as deep as the bound says.
            let bound = &state.out.bound;
            let good = |corners: [u16; 3]| {
                let face = corners.map(|i| polytope.point(i).w);
                let is_tight = upper - bound.normal.dot(face[0]) <= tolerance * upper + rounding;
                is_tight && has_foot(face, bound.normal, rounding)
            };
            if state.corners.is_none_or(good) {
                state.out.end = End::Converged;
                return true;
            }
        }
        // At least once: without a step there may be no bound at all.
        if state.out.iterations >= max_expansions && upper < f64::INFINITY {
            state.out.end = End::Limit;
            return true;
        }
        if polytope.is_full() {
            state.out.end = End::Limit;
            return false;
        }
        if polytope.point_count() == KEEP
            && state.encloses
            && let Some(cache) = &mut cache
        {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
        state.out.iterations += 1;
        // 3. The support plane bounds it from above.
        let point = m.point(direction);
        let value = point.w.dot(direction) / length;
        let tight = value - offset <= tolerance * value + rounding;
        let separated = value < -rounding;
        let touching = value <= TOUCHING_ROUNDINGS * rounding;
        if value < upper || tight || touching {
            // Of the faces in this plane the one that the origin's foot is in.
            let face = if tight { polytope.face_of_foot(face, noise) } else { face };
            (state.out.bound.upper, state.out.bound.normal) = (value, direction / length);
            state.corners = Some(polytope.corners(face));
        }
        // 4. Close enough, or go on.
        let has_points = |corners: [u16; 3], upper: f64, normal: DVec3| {
            let face = corners.map(|i| polytope.point(i).w);
            upper - normal.dot(face[0]) <= FOOT_OFF * upper + rounding && has_foot(face, normal, rounding)
        };
        let Bound { upper, normal, .. } = state.out.bound;
        let mut done = separated
            || touching
            || tight
            || (close && state.corners.is_none_or(|corners| has_points(corners, upper, normal)));
        if close && !done && value - state.out.lower <= tolerance * value + rounding {
            // Another bound is as good, of a face with points, or of a support point that the normal points to, as on a ball.
            let (normal, corners) = (direction / length, polytope.corners(face));
            if point.w.distance(normal * value) <= FOOT_OFF * value + rounding {
                state.out.bound = Bound { upper: value, normal, point_a: point.a, point_b: point.b() };
                (state.corners, done) = (None, true);
            } else if has_points(corners, value, normal) {
                (state.out.bound.upper, state.out.bound.normal) = (value, normal);
                (state.corners, done) = (Some(corners), true);
            }
        }
        if done {
            state.out.end = if separated {
                End::Separated
            } else if touching {
                End::Touching
            } else {
                End::Converged
            };
            return true;
        }
        state.encloses &= offset > safe;
        // NaN counts as no progress.
        let above = value > offset;
        if !above || polytope.insert(point, face).is_err() {
            state.out.end = End::Stalled;
            // The surface is torn.
            state.encloses = false;
            return true;
        }
    }
}

/// The normal of the widest face of a tetrahedron that is none.
fn widest(tetrahedron: [Point; 4]) -> DVec3 {
    let [p, q, r, s] = tetrahedron.map(|v| v.w);
    let normals = [(q - p).cross(r - p), (q - p).cross(s - p), (r - p).cross(s - p), (r - q).cross(s - q)];
    let wider = |widest: DVec3, n: DVec3| if n.length_squared() > widest.length_squared() { n } else { widest };
    unit(normals.into_iter().fold(DVec3::ZERO, wider)).unwrap_or(DVec3::X)
}

/// A difference without thickness along `normal`: its depth is zero, if it holds the origin at all.
#[inline(never)]
fn expand_flat<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    normal: DVec3,
    mut state: Expansion,
) -> Expansion {
    let mut simplex = Simplex::new(m.center_point());
    let near = closest(m, &mut simplex, 0.0, MAX_FLAT);
    state.iterations += near.iterations;
    state.lower = 0.0;
    let (point_a, point_b, _) = simplex.witnesses(near.upper, m.noise());
    if near.lower > m.rounding() {
        state.end = End::Separated;
        state.bound = Bound { upper: -near.lower, normal: near.normal, point_a, point_b };
        return state;
    }
    let value = m.point(normal).w.dot(normal);
    state.bound = Bound { upper: value.max(0.0), normal, point_a, point_b };
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
