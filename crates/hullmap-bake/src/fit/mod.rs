//! Measures how well convex parts represent a mesh: whether they cover its surface, and how far
//! they protrude from its solid. Both are certified upper bounds, for parts from any source.
//!
//! Lengths are in the unit of the positions, which the mesh and the parts share.

pub mod branch;
pub mod closing;
pub mod coverage;
mod fits;
mod frame;
mod looseness;
pub mod mesh_mass;
pub mod peaks;
pub mod polytope;
pub mod protrusion;
mod region;
pub mod sides;
pub mod solid;
pub(crate) mod triangle_tree;
mod voids;
mod walls;
pub mod winding;

pub use branch::Accuracy;
pub use coverage::{Uncovered, uncovered, uncovered_triangles};
pub use fits::{Fit, fits, fits_around};
pub use frame::Frame;
pub use looseness::{Looseness, looseness, looseness_of_parts, overlap};
pub use mesh_mass::mesh_mass;
pub use protrusion::{Protrusion, protrusion};
pub use solid::{Solid, SolidKind, reversed};
pub use voids::{Voids, VoidsShare, voids};
pub use walls::SolidRule;

#[cfg(test)]
mod tests;
