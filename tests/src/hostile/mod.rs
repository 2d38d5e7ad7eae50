//! Hostile files: packs, triangle meshes and height fields that were changed and, in most cases,
//! given a correct checksum again.
//!
//! Requirement: such a file is rejected, or it opens and every query on it ends without a panic and
//! without a read out of bounds. Answers may be wrong.
//!
//! | module | what |
//! |---|---|
//! | [`samples`] | the packs to change: small ones of all kinds, and larger random ones |
//! | [`sheets`] | small triangle meshes and height fields to change |
//! | [`series`] | the ways to change a file: each is a series with indexed members |
//! | [`inquiry`], [`sheet_inquiry`] | all queries on a pack, or on a mesh or a field, that opened |
//! | [`kinds`] | opening and queries, for each kind of file |
//! | [`trial`] | runs a series on several threads, detects panics and hangs, counts outcomes |
//! | [`tries`] | members of a series, opened and queried, with checks and without |
//! | [`large`] | large packs, and the time of the slowest query on each |
//! | [`patch`] | changes a single value of the archive in a file |
//!
//! A change is identified by the file's name, the series and the index in the series.

pub mod inquiry;
pub mod kinds;
pub mod large;
pub mod patch;
pub mod samples;
pub mod series;
pub mod sheet_inquiry;
pub mod sheets;
pub mod trial;
pub mod tries;

/// Bytes of the header.
pub const HEADER_LEN: usize = 64;
