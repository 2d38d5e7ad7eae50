//! Comparisons of the solver with references, and a rigid-body simulation with its contact
//! manifolds.

mod degenerate;
mod facets;
mod meshes;
mod primitives;
mod properties;
mod regressions;
mod soak;
mod standing;
mod truth;
