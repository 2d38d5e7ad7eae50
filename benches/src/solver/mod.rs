//! The solver beside parry3d and MuJoCo: contact, intersection and distance on the same hulls in
//! the same poses, in one run.
//!
//! | module | content |
//! |---|---|
//! | [`pairs`] | two hulls, and their poses: by class, and along paths |
//! | [`engines`] | the three queries, hullmap's and parry's |
//! | [`race`] | interleaved timing, cold and frame-coherent |
//! | [`answers`] | the answers compared with each other |
//! | [`tables`] | the rows of `contact-table` |
//! | [`mujoco`] | MuJoCo in a program of its own |

pub mod answers;
pub mod engines;
pub mod mujoco;
pub mod pairs;
pub mod race;
pub mod tables;
