//! The steps of EPA: bound the depth from below by the nearest face, from above by a support plane,
//! and insert the support point.

use glam::DVec3;

use super::polytope::{COPLANAR_NOISES, Polytope};
use crate::solver::bound::Bound;
use crate::solver::cache::{Cache, MAX_POINTS};
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;

/// Support values up to this many rounding errors count as touching: one for the support point, one
/// for the normal.
pub(in crate::solver) const TOUCHING_ROUNDINGS: f64 = 2.0;

/// Number of vertices at which a polytope is kept for the next query, unless it ends with fewer.
/// Further vertices belong to small faces around the nearest one. These become dents when the pose
/// changes, and each dent costs a support call.
pub(super) const KEEP: usize = MAX_POINTS;

/// What the search computes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum Goal {
    /// Only whether the origin is inside.
    Decide,
    /// The depth, until upper − lower ≤ tolerance · upper + rounding error.
    Depth { tolerance: f64 },
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum End {
    /// The origin is outside; the normal separates.
    Separated,
    /// The origin is on the surface, within rounding errors.
    Touching,
    /// The origin is inside; the bounds are not narrowed further.
    Inside,
    /// The bounds are close enough.
    Converged,
    /// A limit was reached.
    Limit,
    /// Rounding errors stopped all progress.
    Stalled,
}

/// The result of the search.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Expansion {
    pub(in crate::solver) end: End,
    /// Lower bound of the depth, up to rounding errors; negative if nothing is known.
    pub(in crate::solver) lower: f64,
    pub(in crate::solver) bound: Bound,
    pub(in crate::solver) iterations: u32,
    /// The features of a corner of the bound's face; the greatest number if there is none.
    pub(in crate::solver) features: [u32; 2],
    /// Lower bound of the depth along all directions that pass through faces beside the bound's
    /// plane, up to rounding errors; negative if nothing is known.
    pub(in crate::solver) others: f64,
}

/// √3, rounded up.
const SQRT_3: f64 = 1.733;
const _: () = assert!(SQRT_3 * SQRT_3 > 3.0);

/// The constants of one search.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Terms {
    goal: Goal,
    tolerance: f64,
    /// Lower bound of the depth from the balls inside the shapes.
    ball: f64,
    /// If the smallest offset is below this, inserting a vertex may move the surface past the
    /// origin.
    safe: f64,
    max_expansions: u32,
    /// [`Minkowski::noise`].
    noise: f64,
    /// [`Minkowski::rounding_error`].
    rounding: f64,
}

impl Terms {
    pub(in crate::solver) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        goal: Goal,
        max_expansions: u32,
    ) -> Self {
        let tolerance = match goal {
            Goal::Decide => 0.0,
            Goal::Depth { tolerance } => tolerance,
        };
        let ball = m.inner_radius() - m.center_point().w.length();
        // The slack is measured by the sum of a normal's absolute components, which is at most √3
        // times its length. One more noise is for rounding.
        let safe = (COPLANAR_NOISES * SQRT_3 + 1.0) * m.noise();
        Self { goal, tolerance, ball, safe, max_expansions, noise: m.noise(), rounding: m.rounding_error() }
    }

    /// Whether the polytope is kept for the next query. A decision leaves the cache's polytope as
    /// it is.
    pub(super) fn keeps_polytope(&self) -> bool {
        self.goal != Goal::Decide
    }

    /// Whether an upper bound is as near to a lower one as the goal requires.
    #[inline(always)]
    fn are_close(&self, upper: f64, lower: f64) -> bool {
        upper - lower <= self.allowance(upper)
    }

    /// Maximum width of the interval of a depth that ends the search.
    #[inline(always)]
    pub(super) fn allowance(&self, upper: f64) -> f64 {
        self.tolerance * upper + self.rounding
    }
}

/// The state of one search, which survives the move to a larger polytope.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) out: Expansion,
    /// The corners of the bound's face, whose witness points are computed at the end. `None` if the
    /// bound came from outside or has its points already.
    pub(super) corners: Option<[u16; 3]>,
    /// The surface certainly winds around the origin.
    pub(super) encloses: bool,
}

/// The face nearest to the origin and its plane.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    face: usize,
    /// Normal of the plane, of any length.
    direction: DVec3,
    /// Its length.
    length: f64,
    /// Signed distance of the plane from the origin.
    offset: f64,
}

/// The support point along a nearest face's normal.
struct Probe {
    point: Point,
    /// Support value along the unit normal.
    value: f64,
    /// The support plane is as near to the face as the goal requires.
    tight: bool,
    /// The support plane separates.
    separated: bool,
    /// The support plane passes through the origin, within rounding errors.
    touching: bool,
}

/// Outcome of steps 1 and 2.
pub(super) enum Next {
    /// A support query along the normal of this face.
    Ask(Aim),
    /// The search has ended.
    Ended,
    /// The polytope is full. The state is as before the last step, and the search can continue in a
    /// larger polytope.
    Full,
}

/// The face whose plane is tested next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim(Nearest);

impl Aim {
    /// Before the first step.
    pub(super) const NOTHING: Self = Self(Nearest { face: 0, direction: DVec3::ZERO, length: 0.0, offset: 0.0 });

    /// The direction of the support query, of any length.
    #[inline(always)]
    pub(super) fn direction(&self) -> DVec3 {
        self.0.direction
    }
}

/// Expands the polytope without suspending. Returns true when the search has ended, and false when
/// the polytope is full.
pub(super) fn run<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
) -> bool {
    loop {
        match aim(polytope, state, terms, None) {
            Next::Ask(aim) => {
                let point = m.point(aim.direction());
                if continue_with(polytope, state, terms, &aim, point) {
                    return true;
                }
            }
            Next::Ended => return true,
            Next::Full => return false,
        }
    }
}

/// Step 2, up to the support query.
#[inline(always)]
pub(super) fn aim<const V: usize, const F: usize>(
    polytope: &mut Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
    cache: Option<&mut Cache>,
) -> Next {
    // 2. The nearest face bounds the depth from below.
    let nearest = Nearest::new(polytope);
    state.bound_from_below(polytope, &nearest, terms);
    if let Some(end) = state.end_before_query(terms) {
        state.out.end = end;
        return Next::Ended;
    }
    if polytope.is_full() {
        state.out.end = End::Limit;
        return Next::Full;
    }
    if polytope.point_count() == KEEP
        && state.encloses
        && let Some(cache) = cache
    {
        cache.keep_polytope(polytope.features(), polytope.faces());
    }
    state.out.iterations += 1;
    Next::Ask(Aim(nearest))
}

/// Steps 3 and 4, with the support point in the direction of `aim`. Returns whether the search has
/// ended.
#[inline(always)]
pub(super) fn continue_with<const V: usize, const F: usize>(
    polytope: &mut Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
    Aim(nearest): &Aim,
    point: Point,
) -> bool {
    // 3. The support plane bounds it from above.
    let probe = Probe::new(point, nearest, terms);
    state.bound_from_above(polytope, nearest, &probe, terms);
    // 4. Stop if the bounds are close, else insert the support point.
    if probe.separated || probe.touching || probe.tight || state.is_close(terms) {
        state.out.end = probe.end();
        return true;
    }
    state.encloses &= nearest.offset > terms.safe;
    // NaN counts as no progress.
    let above = probe.value > nearest.offset;
    if !above || polytope.insert_vertex(probe.point, nearest.face).is_err() {
        state.out.end = End::Stalled;
        // The surface is torn.
        state.encloses = false;
        return true;
    }
    false
}

impl Nearest {
    #[inline(always)]
    fn new<const V: usize, const F: usize>(polytope: &Polytope<V, F>) -> Self {
        let face = polytope.nearest_face();
        let (direction, length, offset) = polytope.plane(face);
        Self { face, direction, length, offset }
    }
}

impl Probe {
    #[inline(always)]
    fn new(point: Point, nearest: &Nearest, terms: &Terms) -> Self {
        let value = point.w.dot(nearest.direction) / nearest.length;
        Self {
            point,
            value,
            tight: terms.are_close(value, nearest.offset),
            separated: value < -terms.rounding,
            touching: value <= TOUCHING_ROUNDINGS * terms.rounding,
        }
    }

    /// How the search ends if this support plane finishes it.
    fn end(&self) -> End {
        if self.separated {
            End::Separated
        } else if self.touching {
            End::Touching
        } else {
            End::Converged
        }
    }
}

impl State {
    /// The state before the first step, with an upper bound known from elsewhere.
    pub(super) fn new(bound: Bound) -> Self {
        let nothing = f64::NEG_INFINITY;
        let features = Point::CENTER;
        let out = Expansion { end: End::Limit, lower: nothing, bound, iterations: 0, features, others: nothing };
        Self { out, corners: None, encloses: false }
    }

    /// Step 2: the lower bound, which holds only if the surface winds around the origin.
    #[inline(always)]
    fn bound_from_below<const V: usize, const F: usize>(
        &mut self,
        polytope: &mut Polytope<V, F>,
        nearest: &Nearest,
        terms: &Terms,
    ) {
        if nearest.offset > terms.safe && !self.encloses {
            self.encloses = polytope.check_encloses();
        }
        self.out.lower = if self.encloses { nearest.offset.max(terms.ball) } else { terms.ball };
    }

    /// Whether the bounds are as close as the goal requires.
    #[inline(always)]
    fn is_close(&self, terms: &Terms) -> bool {
        // A missing bound is infinite, and infinity is within a tolerance of infinity.
        let upper = self.out.bound.upper;
        upper < f64::INFINITY && terms.are_close(upper, self.out.lower)
    }

    /// How the search ends without a further support query, if it does.
    #[inline(always)]
    fn end_before_query(&self, terms: &Terms) -> Option<End> {
        if terms.goal == Goal::Decide && self.out.lower > terms.rounding {
            return Some(End::Inside);
        }
        if self.is_close(terms) {
            return Some(End::Converged);
        }
        // The first step is always taken: without it there may be no upper bound at all.
        let is_last = self.out.iterations >= terms.max_expansions && self.out.bound.upper < f64::INFINITY;
        is_last.then_some(End::Limit)
    }

    /// Step 3: the upper bound, with the face that it belongs to.
    #[inline(always)]
    fn bound_from_above<const V: usize, const F: usize>(
        &mut self,
        polytope: &Polytope<V, F>,
        nearest: &Nearest,
        probe: &Probe,
        terms: &Terms,
    ) {
        if probe.value < self.out.bound.upper || probe.tight || probe.touching {
            // Of the faces in this plane, take the one that contains the origin's foot.
            let face = if probe.tight { polytope.face_of_foot(nearest.face, terms.noise) } else { nearest.face };
            (self.out.bound.upper, self.out.bound.normal) = (probe.value, nearest.direction / nearest.length);
            self.corners = Some(polytope.corners(face));
        }
    }
}
