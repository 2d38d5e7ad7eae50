//! Continuous collision detection: bodies that move and turn over the times 0 to 1.
//!
//! | where | what |
//! |---|---|
//! | `rigid_motion` | a motion: constant linear and angular velocity |
//! | `advance` | how far two moving bodies certainly stay apart along a direction |
//! | `search` | when two moving bodies first come within a distance of each other |
//! | `time_of_impact` | the answer |
//! | `cast_motion`, `half_space` | the search for two shapes, and for a half-space and a shape |
//! | `clear` | whether a motion is free, with the clearance |
//!
//! Compounds search their pairs of parts: `compound/cast_motion.rs`. Angles occur in `rigid_motion`
//! alone, with the sines of `libm`, so the same input always gives the same bits.

#![forbid(unsafe_code)]

mod advance;
pub(crate) mod cast_motion;
pub(crate) mod clear;
mod half_space;
mod rigid_motion;
pub(crate) mod search;
mod time_of_impact;

pub use cast_motion::MotionSettings;
pub use clear::{ClearSettings, Clearance, Verdict};
pub use rigid_motion::RigidMotion;
pub use time_of_impact::TimeOfImpact;
