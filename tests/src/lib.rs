//! What the tests of the whole workspace share: directions to try, and truths that come from somewhere else.

pub mod directions;
pub mod parry;
pub mod regret;
