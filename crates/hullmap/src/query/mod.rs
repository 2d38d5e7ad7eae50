//! The queries of any two geometries, and the choice of the code for them.
//!
//! # Steps
//! 1. `a` and `b` say what they are, by [`Geometry::visit`]. For known types the compiler decides.
//! 2. Two convex shapes go to `solver` and `continuous`. If one side has parts, both go to
//!    `compound`, where a shape counts as its only part.
//! 3. A half-space has closed forms. As B it is queried as A, with the inverse pose, and the answer
//!    is exchanged. Two half-spaces have no query: the answer claims nothing.

#![forbid(unsafe_code)]

mod contact;
mod distance;
mod intersects;
mod manifolds;
mod motion;
mod point;

use crate::compound::Parts;
use crate::geometry::{Geometry, Visitor};
use crate::shapes::{HalfSpace, Shape};
pub use contact::{contact, contacts};
pub use distance::distance;
pub use intersects::intersects;
pub use motion::{cast, cast_motion, clear};
pub use point::{ray, signed_distance};

pub(crate) trait PairQuery: Sized {
    /// The default claims nothing.
    type Answer: Default;

    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Self::Answer;

    /// Answers for two geometries, at least one of which has parts.
    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Self::Answer;

    /// Answers for a half-space, and parts or a convex shape.
    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Self::Answer;

    /// Answers with the half-space as B.
    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Self::Answer;
}

#[inline(always)]
pub(crate) fn answer<A, B, Q>(a: &A, b: &B, query: Q) -> Q::Answer
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
    Q: PairQuery,
{
    a.visit(WithB { b, query })
}

/// Visits A.
struct WithB<'g, B: ?Sized, Q> {
    b: &'g B,
    query: Q,
}

impl<B: Geometry + ?Sized, Q: PairQuery> Visitor for WithB<'_, B, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, a: &S) -> Q::Answer {
        self.b.visit(OfShape { a, query: self.query })
    }

    #[inline(always)]
    fn parts<P: Parts + ?Sized>(self, a: &P) -> Q::Answer {
        self.b.visit(OfParts { a, query: self.query })
    }

    #[inline(always)]
    fn half_space(self, a: &HalfSpace) -> Q::Answer {
        self.b.visit(OfHalfSpace { a, query: self.query })
    }
}

/// Visits B, where A is a convex shape.
struct OfShape<'g, A: ?Sized, Q> {
    a: &'g A,
    query: Q,
}

impl<A: Shape + ?Sized, Q: PairQuery> Visitor for OfShape<'_, A, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, b: &S) -> Q::Answer {
        self.query.shapes(self.a, b)
    }

    #[inline(always)]
    fn parts<P: Parts + ?Sized>(self, b: &P) -> Q::Answer {
        self.query.parts(self.a, b)
    }

    #[inline(always)]
    fn half_space(self, b: &HalfSpace) -> Q::Answer {
        self.query.half_space_as_b(self.a, b)
    }
}

/// Visits B, where A has parts.
struct OfParts<'g, A: ?Sized, Q> {
    a: &'g A,
    query: Q,
}

impl<A: Parts + ?Sized, Q: PairQuery> Visitor for OfParts<'_, A, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, b: &S) -> Q::Answer {
        self.query.parts(self.a, b)
    }

    #[inline(always)]
    fn parts<P: Parts + ?Sized>(self, b: &P) -> Q::Answer {
        self.query.parts(self.a, b)
    }

    #[inline(always)]
    fn half_space(self, b: &HalfSpace) -> Q::Answer {
        self.query.half_space_as_b(self.a, b)
    }
}

/// Visits B, where A is a half-space.
struct OfHalfSpace<'g, Q> {
    a: &'g HalfSpace,
    query: Q,
}

impl<Q: PairQuery> Visitor for OfHalfSpace<'_, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn shape<S: Shape + ?Sized>(self, b: &S) -> Q::Answer {
        self.query.half_space(self.a, b)
    }

    #[inline(always)]
    fn parts<P: Parts + ?Sized>(self, b: &P) -> Q::Answer {
        self.query.half_space(self.a, b)
    }

    fn half_space(self, _: &HalfSpace) -> Q::Answer {
        Q::Answer::default()
    }
}
