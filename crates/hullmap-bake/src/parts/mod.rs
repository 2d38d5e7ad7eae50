//! The parts of meshes for a pack: found, measured, and described for people.
//!
//! [`cut`] finds the points of each hull, [`measure`] records how they fit their meshes, and
//! [`estimates`] sums them up. The judge refutes what is recorded by other means.

pub mod cut;
pub mod estimates;
pub mod measure;
