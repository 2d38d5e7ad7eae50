//! Geometry below the baker, the readers of files and the judge: no I/O, f64, and no dependency but
//! glam.
//!
//! | module | concept |
//! |---|---|
//! | `point_set` | [`PointSet`]: source points and triangles |
//! | [`triangle`] | the nearest point of a triangle; halves, centroid, heights |
//! | [`planes`] | half-spaces, the planes of faces, clipped polygons |
//! | [`quadratic_program`] | the point nearest to the origin outside of half-spaces |
//! | [`number`] | numbers and lengths in messages |

#![forbid(unsafe_code)]

pub mod number;
pub mod planes;
mod point_set;
pub mod quadratic_program;
pub mod triangle;

pub use point_set::{MAX_POINTS, PointSet, bits, bounds, diagonal};
