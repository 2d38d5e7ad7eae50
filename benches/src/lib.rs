//! Benchmarks: support queries and the solver beside other engines.
//!
//! | module | content |
//! |---|---|
//! | [`subject`] | a family of [`shapes`], baked, for hullmap and parry3d |
//! | [`support`] | methods of answering support queries, and their timing |
//! | [`directions`], [`regret`] | query directions; error of the answers, in f64 |
//! | [`solver`] | contact, intersects and distance beside parry3d and MuJoCo |
//! | [`known`] | two boxes with known answers, which prove that an engine gets its input right |
//! | [`scene`] | scenes of many different hulls |
//! | [`rows`] | measurements: tables, and a CSV file |
//! | [`clock`] | processor time of this thread |
//!
//! A new index kind is one line in [`support::INDICES`].
#![deny(unsafe_code)]

pub mod clock;
pub mod directions;
pub mod known;
pub mod regret;
pub mod rows;
pub mod scene;
pub mod solver;
pub mod subject;
pub mod support;
