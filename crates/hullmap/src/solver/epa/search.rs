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

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) enum End {
    /// The origin is outside; the normal separates.
    Separated,
    /// The origin is on the surface, within rounding errors.
    Touching,
    /// The origin is inside; the bounds are not narrowed further.
    Inside,
    Converged,
    Limit,
    /// Rounding errors stopped all progress.
    Stalled,
}

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

#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Terms {
    decides_only: bool,
    tolerance: f64,
    /// Lower bound of the depth from the balls inside the shapes.
    ball: f64,
    /// If the smallest offset is below this, inserting a vertex may move the surface past the
    /// origin.
    safe: f64,
    max_expansions: u32,
    noise: f64,
    rounding: f64,
}

impl Terms {
    /// Terms of a search for the depth, until upper − lower ≤ tolerance · upper + rounding error.
    /// Without a tolerance, only whether the origin is inside is decided.
    pub(in crate::solver) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        tolerance: Option<f64>,
        max_expansions: u32,
    ) -> Self {
        Self {
            decides_only: tolerance.is_none(),
            tolerance: tolerance.unwrap_or(0.0),
            ball: m.inner_radius() - m.center_point().w.length(),
            // The slack is measured by the sum of a normal's absolute components, which is at most
            // √3 times its length. One more noise is for rounding.
            safe: (COPLANAR_NOISES * SQRT_3 + 1.0) * m.noise(),
            max_expansions,
            noise: m.noise(),
            rounding: m.rounding_error(),
        }
    }

    /// Whether the polytope is kept for the next query. A decision leaves the cache's polytope as
    /// it is.
    pub(super) fn keeps_polytope(&self) -> bool {
        !self.decides_only
    }

    /// Maximum width of the interval of a depth that ends the search.
    #[inline(always)]
    pub(super) fn allowance(&self, upper: f64) -> f64 {
        self.tolerance * upper + self.rounding
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    face: usize,
    /// Normal of the plane, of any length: the direction of the support query.
    pub(super) direction: DVec3,
    length: f64,
    offset: f64,
}

impl Nearest {
    pub(super) const NONE: Self = Self { face: 0, direction: DVec3::ZERO, length: 0.0, offset: 0.0 };
}

pub(super) enum Next {
    Ask,
    Ended,
    /// The polytope is full. The search can continue in a larger one.
    Full,
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
    pub(super) nearest: Nearest,
}

impl State {
    pub(super) fn new(bound: Bound, encloses: bool) -> Self {
        let (lower, others) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let out = Expansion { end: End::Limit, lower, bound, iterations: 0, features: Point::CENTER, others };
        Self { out, corners: None, encloses, nearest: Nearest::NONE }
    }

    /// Step 2, up to the support query. Keeps the polytope in `cache` when it has the right size.
    #[inline(always)]
    pub(super) fn aim<const V: usize, const F: usize>(
        &mut self,
        polytope: &mut Polytope<V, F>,
        terms: &Terms,
        cache: Option<&mut Cache>,
    ) -> Next {
        let face = polytope.nearest;
        let (direction, length, offset) = polytope.plane(face);
        // The lower bound holds only if the surface winds around the origin.
        if offset > terms.safe && !self.encloses {
            self.encloses = polytope.check_encloses();
        }
        self.out.lower = if self.encloses { offset.max(terms.ball) } else { terms.ball };
        if terms.decides_only && self.out.lower > terms.rounding {
            self.out.end = End::Inside;
            return Next::Ended;
        }
        if self.is_close(terms) {
            self.out.end = End::Converged;
            return Next::Ended;
        }
        self.out.end = End::Limit;
        // The first step is always taken: without it there may be no upper bound at all.
        if self.out.iterations >= terms.max_expansions && self.out.bound.upper < f64::INFINITY {
            return Next::Ended;
        }
        if polytope.is_full() {
            return Next::Full;
        }
        if polytope.point_count == KEEP
            && self.encloses
            && let Some(cache) = cache
        {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
        self.out.iterations += 1;
        self.nearest = Nearest { face, direction, length, offset };
        Next::Ask
    }

    /// Steps 3 and 4, with the support point along the normal of the nearest face. Returns whether
    /// the search has ended.
    #[inline(always)]
    pub(super) fn expand<const V: usize, const F: usize>(
        &mut self,
        polytope: &mut Polytope<V, F>,
        terms: &Terms,
        point: Point,
    ) -> bool {
        let Nearest { face, direction, length, offset } = self.nearest;
        // 3. The support plane bounds the depth from above.
        let value = point.w.dot(direction) / length;
        let is_tight = value - offset <= terms.allowance(value);
        let is_separated = value < -terms.rounding;
        let is_touching = value <= TOUCHING_ROUNDINGS * terms.rounding;
        if value < self.out.bound.upper || is_tight || is_touching {
            // Take the face in this plane that contains the origin's foot.
            let face = if is_tight { polytope.face_of_foot(face, terms.noise) } else { face };
            (self.out.bound.upper, self.out.bound.normal) = (value, direction / length);
            self.corners = Some(polytope.corners[face]);
        }
        // 4. Stop if the bounds are close, else insert the support point.
        if is_separated || is_touching || is_tight || self.is_close(terms) {
            self.out.end = if is_separated {
                End::Separated
            } else if is_touching {
                End::Touching
            } else {
                End::Converged
            };
            return true;
        }
        self.encloses &= offset > terms.safe;
        // NaN counts as no progress.
        let is_above = value > offset;
        if !is_above || polytope.insert_vertex(point, face).is_err() {
            self.out.end = End::Stalled;
            // The surface is torn.
            self.encloses = false;
            return true;
        }
        false
    }

    #[inline(always)]
    fn is_close(&self, terms: &Terms) -> bool {
        // A missing bound is infinite, and infinity is within a tolerance of infinity.
        let upper = self.out.bound.upper;
        upper < f64::INFINITY && upper - self.out.lower <= terms.allowance(upper)
    }
}
