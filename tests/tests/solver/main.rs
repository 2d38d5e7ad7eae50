//! Comparisons of the solver with references.

mod degenerate;
mod meshes;
mod primitives;
mod regressions;
mod soak;
mod warm;
