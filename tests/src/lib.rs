//! What the tests of the whole workspace share: the command, packs made in process, directions to try, and truths that
//! come from somewhere else.

pub mod command;
pub mod directions;
#[cfg(target_os = "linux")]
pub mod faults;
pub mod fuzzed;
pub mod game_hulls;
pub mod hostile;
pub mod outside;
pub mod packs;
pub mod parry;
pub mod regret;
pub mod soak;
pub mod truth;
pub mod wavefront;
