//! What the first pass of the separating axis test, in f32, tells the second one, in f64.

use super::scan::{Arc, Pair};
use crate::support::facet_table::PointBlock;
use crate::support::lane_set::LaneSet;
use crate::support::simd::Dispatch;

/// A pass over the faces and the arcs of a pair, in f32. `P` blocks of points, `N` blocks of faces.
///
/// It only proposes. Every value is that of a point of the difference, to within
/// [`error`](Self::error), so what it rules out is ruled out for certain.
pub(super) trait FirstPass<const P: usize, const N: usize> {
    /// Whether [`run`](Self::run) takes an upper bound of the depth, and saves work by it.
    const TAKES_UPPER: bool;

    /// A pass over `pair` without values.
    fn new(pair: &Pair<'_>) -> Self;

    /// Computes the support values at the faces of A and of B that may have the minimum. If a face
    /// separates, it stops there: [`low`](Self::low) is below −`error` then. `None` if there are
    /// too many faces.
    ///
    /// `upper` is an upper bound of the depth, or infinite. `seen` holds a vertex of B and one of A
    /// that are likely support points along the depth; they only save work.
    fn run(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32, seen: Option<[usize; 2]>) -> Option<()>;

    /// Finds all [`arcs`](Self::arcs) of A that may have a value of at most `upper` at a direction
    /// that is not an end. `None` if they are too many.
    ///
    /// `upper` is an upper bound of the depth, at most that for [`faces`](Self::faces). The
    /// vertices of all faces found there are known from f64 ([`set_vertex`](Self::set_vertex)).
    fn find_arcs(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32) -> Option<()>;

    /// The arcs of A that were found, that with the lowest bound first.
    fn arcs(&self) -> &[Arc];

    /// Lowest value found.
    fn low(&self) -> f32;

    /// Upper bound of the error of every value: a length.
    fn error(&self) -> f32;

    /// The faces of A and of B whose values may be at most `upper`, an upper bound of the depth.
    fn faces(&self, upper: f32) -> [LaneSet<N>; 2];

    /// The faces of A and of B whose values are at most `value`.
    fn faces_at_most(&self, value: f32) -> [LaneSet<N>; 2];

    /// The vertex of B that is the support point at a known face of A, or nearly so.
    fn vertex(&self, face: usize) -> usize;

    /// Stores the support vertex of B at a face of A, known from f64.
    fn set_vertex(&mut self, face: usize, vertex: u32);

    /// The vertices of B in the difference, in A's frame, and those of A, in B's frame.
    fn points(&self) -> [&[PointBlock; P]; 2];
}
