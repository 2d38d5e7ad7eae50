//! The solver beside parry3d: contact, intersection and distance on the same hulls in the same
//! poses, in one run.
//!
//! | module | what |
//! |---|---|
//! | [`pairs`] | two hulls, and their poses: by class, and along paths |
//! | [`engines`] | the three queries, hullmap's and parry's |
//! | [`mujoco`] | MuJoCo in a program of its own |
//! | [`race`] | interleaved timing, cold and frame-coherent |
//! | [`errors`] | the answers compared with each other |
//! | [`targets`] | goals, as fractions of parry's time |
//! | [`tables`] | the tables, and their CSV |

pub mod engines;
pub mod errors;
pub mod mujoco;
pub mod pairs;
pub mod race;
pub mod tables;
pub mod targets;
