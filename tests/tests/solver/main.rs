//! Comparisons of the solver with references and with parry3d, and a rigid-body simulation with its
//! contact manifolds.

mod degenerate;
mod facets;
mod parry;
mod primitives;
mod properties;
mod regressions;
mod soak;
mod standing;
mod truth;
