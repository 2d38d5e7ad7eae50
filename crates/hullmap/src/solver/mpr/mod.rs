//! MPR, Minkowski portal refinement (XenoCollide): the two phases of Kenwright's Algorithm 1.
//!
//! `discovery` finds a portal, a triangle of support points that the ray from the centre through
//! the origin pierces. `refinement` moves the portal outward until the origin is certainly behind
//! it or certainly in front of it. `search` is both phases as a state machine, for batches.

mod discovery;
mod refinement;
mod search;

pub(in crate::solver) use discovery::{Discovery, FLATNESS, Portal, discover_portal, is_clearly_negative};
pub(in crate::solver) use refinement::{Side, Until, refine_portal};
pub(in crate::solver) use search::{Found, Search};
