//! Truth about pairs of hulls: depth and distance in f64, without the solver, and the solver judged by it.
//!
//! | module | what |
//! |---|---|
//! | [`polytope`] | a hull as points, face normals and edges |
//! | [`depth`] | signed depth by all facets of the Minkowski difference; a slow twin |
//! | [`gap`] | distance with a certificate; a slow twin |
//! | [`scene`] | hulls of many kinds and the poses they meet in |
//! | [`verdict`] | what was wrong with an answer, and the counts |
//!
//! # Rounding
//! Both truths are right up to [`rounding`]: a facet's normal is computed to a few units of rounding over the
//! facet's extent, and tilting a plane about a facet by that much moves its support value by extent times tilt. So however
//! thin a facet is, the value is off by some units of the greatest length.

pub mod depth;
pub mod gap;
pub mod polytope;
pub mod scene;
pub mod verdict;

use polytope::Polytope;

/// Units of rounding that a truth may be off by, of the greatest length in the query: two products of a rotation, a
/// normal, a dot product and a difference come to about 20 on each hull.
const ROUNDING_UNITS: f64 = 64.0;

/// What a truth about `a` and `b`, both in A's frame, may be off by: a length. `far` is the distance between the frames.
pub fn rounding(a: &Polytope, b: &Polytope, far: f64) -> f64 {
    ROUNDING_UNITS * f64::EPSILON * (a.greatest() + b.greatest() + far)
}
