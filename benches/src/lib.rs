//! Benchmarks: support queries side by side with everybody else's, the solver beside parry3d, and the paper's Figures 6
//! and 7 with our data.
//!
//! | module | what |
//! |---|---|
//! | [`subject`] | the hull that is asked: a family of [`shapes`], baked |
//! | [`rivals`] | the ways to answer, ours and the others', each with its own tables |
//! | [`query`] | what a rival is, and the loops that ask it |
//! | [`directions`] | what is asked: random, turning, and the awkward ones |
//! | [`measure`] | interleaved timing: throughput, latency, coherent, cold |
//! | [`eviction`] | how caches are emptied for cold queries |
//! | [`regret`] | how far from the truth the answers are, in f64 |
//! | [`matrix`], [`report`] | the tables |
//! | [`solver`] | contact, intersects and distance beside parry3d |
//! | [`collision`], [`fit`], [`chart`] | the paper's figures |
//! | [`machine`], [`output`] | which machine it was; files written whole or not at all |
//!
//! A new index of ours is one line in [`rivals::INDICES`].
#![deny(unsafe_code)]

pub mod chart;
pub mod collision;
pub mod directions;
pub mod eviction;
pub mod fit;
pub mod machine;
pub mod matrix;
pub mod measure;
pub mod opening;
pub mod output;
pub mod query;
pub mod regret;
pub mod report;
pub mod rivals;
pub mod solver;
pub mod subject;
