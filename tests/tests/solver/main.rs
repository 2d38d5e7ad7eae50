//! The solver against references and against parry3d, and a rigid-body simulation with its contact
//! manifolds.

mod parry;
mod properties;
mod regressions;
mod soak;
mod standing;
mod truth;
