//! Comparisons of the solver with references, and a rigid-body simulation with its contact
//! manifolds.

mod degenerate;
mod meshes;
mod primitives;
mod regressions;
mod soak;
mod standing;
mod warm;
