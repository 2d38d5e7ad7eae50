//! Derivatives of answers by the poses of both shapes.
//!
//! | where | what |
//! |---|---|
//! | `pose_derivative` | a derivative by one pose, and by both; why there is none |
//! | `witness` | whether a pair of closest points is the only one, and on which features it is |
//! | `newton` | normal and points as accurate as rounding error allows |
//! | `lengths` | of distance, depth and signed distance |
//! | `times` | of rays, and of times of impact |
//! | `witness_derivatives` | of normals and witness points |
//!
//! # Reference
//! The envelope theorem (Danskin 1966): the derivative of an optimum is the derivative of the
//! function at the optimal points, if they are unique. So the normal and the witness points of an
//! answer are all that is needed. docs/contributors/intervals.md, section 16.

#![forbid(unsafe_code)]

mod lengths;
#[expect(clippy::indexing_slicing, reason = "the indexed arrays are its own, of fixed length")]
mod newton;
mod pose_derivative;
mod times;
mod witness;
mod witness_derivatives;

pub use pose_derivative::{Derivatives, Differentiability, PoseDerivative};
pub use witness_derivatives::{WitnessDerivatives, WitnessJacobian};
