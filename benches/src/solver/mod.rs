//! The solver beside parry3d: contact, intersection and distance on the same hulls in the same poses, in one run.
//!
//! | module | what |
//! |---|---|
//! | [`pairs`] | two hulls, where they touch, and the poses: deep, touching, apart; and paths past each other |
//! | [`engines`] | the three queries, ours and parry's |
//! | [`race`] | interleaved timing, cold and frame-coherent |
//! | [`errors`] | the answers compared with each other |
//! | [`targets`] | which fraction of parry's time is aimed at |
//! | [`tables`] | the tables made of it |

pub mod engines;
pub mod errors;
pub mod pairs;
pub mod race;
pub mod tables;
pub mod targets;
