//! Benchmarks: support queries and the solver beside other engines.
//!
//! | module | what |
//! |---|---|
//! | [`subject`] | a family of [`shapes`], baked |
//! | [`rivals`] | the methods that are compared, each with its own tables |
//! | [`query`] | what a rival is, and the loops that query it |
//! | [`clock`] | processor time of this thread |
//! | [`directions`] | query directions: random, turning, and difficult ones |
//! | [`measure`] | interleaved timing: throughput, latency, coherent, cold |
//! | [`eviction`] | how caches are emptied for cold queries |
//! | [`regret`] | error of the answers, in f64 |
//! | [`matrix`], [`report`], [`csv`] | the tables |
//! | [`solver`] | contact, intersects and distance beside parry3d |
//! | [`mesh_peer`] | Box3D's and Jolt's narrow phase on a mesh |
//! | [`peer_program`] | an engine in a C program of its own |
//! | [`known`] | two boxes with known answers, which prove such a program |
//! | [`scene`] | scenes of many different hulls |
//! | [`comparison`] | tables of benches/README.md, from a committed result |
//! | [`machine`], [`output`] | machine, compiler and commit; atomic writing of files |
//!
//! A new index kind is one line in [`rivals::INDICES`].
#![deny(unsafe_code)]

pub mod clock;
pub mod comparison;
pub mod csv;
pub mod directions;
pub mod eviction;
pub mod known;
pub mod machine;
pub mod matrix;
pub mod measure;
pub mod mesh_peer;
pub mod output;
pub mod peer_program;
pub mod query;
pub mod regret;
pub mod report;
pub mod rivals;
pub mod scene;
pub mod solver;
pub mod subject;
