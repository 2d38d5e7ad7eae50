//! Measures how well convex parts represent a mesh: whether they cover its surface, and how far
//! they protrude from its solid. Both are certified upper bounds, for parts from any source.
//!
//! | file | concept |
//! |---|---|
//! | [`solid`] | the solid that a mesh bounds, for any set of triangles |
//! | [`winding`] | the winding number of its closed surface |
//! | [`mesh_mass`](mod@mesh_mass) | its volume, centre and second moments |
//! | [`closing`] | cones that close the holes of a mesh |
//! | [`protrusion`](mod@protrusion) | how far a part protrudes from the solid |
//! | [`peaks`] | local maxima of the distance from the solid |
//! | [`coverage`] | proof of coverage: how far the surface lies outside all parts, at most |
//! | [`fits`] | both measures of all parts of a mesh, as a pack records them |
//! | `looseness` | estimates: overlap of the parts, mean protrusion, distance from the hull |
//! | `voids` | estimate: volume of the solid that is in no part |
//! | [`remainder`](mod@remainder) | what parts leave of the solid, as convex pieces |
//! | `region` | a part as half-spaces in a box |
//! | [`polytope`] | convex polytopes, cut by planes |
//! | [`branch`] | branch and bound, by which both are proven |
//! | [`reach`] | space that no ball of a radius can reach from outside |
//! | [`sides`] | regions that are inside although triangles cut them |
//! | `triangle_tree` | bounding volume hierarchy of a mesh's triangles |
//! | [`triangle`], [`planes`] | distances from a triangle, half-spaces of a part |
//!
//! Lengths are in the unit of the positions, which the mesh and the parts share.

pub mod branch;
pub mod closing;
pub mod coverage;
mod fits;
mod looseness;
pub mod mesh_mass;
pub mod peaks;
pub mod planes;
pub mod polytope;
pub mod protrusion;
pub mod reach;
mod region;
pub mod remainder;
pub mod sides;
pub mod solid;
pub mod triangle;
pub(crate) mod triangle_tree;
mod voids;
pub mod winding;

pub use branch::Accuracy;
pub use coverage::{Uncovered, uncovered, uncovered_triangles};
pub use fits::{Fit, fits, fits_around};
pub use looseness::{Looseness, looseness, looseness_of_parts, overlap};
pub use mesh_mass::mesh_mass;
pub use protrusion::{Protrusion, protrusion};
pub use remainder::remainder;
pub use solid::{Solid, SolidKind, reversed};
pub use voids::{Voids, VoidsShare, voids};

#[cfg(test)]
mod tests;
