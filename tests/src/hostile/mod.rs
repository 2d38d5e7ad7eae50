//! Malicious files: packs that were changed and, mostly, given a correct checksum again.
//!
//! Requirement: either such a file is refused, or it opens and every query on it ends, without a
//! panic and without a read out of bounds. Answers may be wrong.
//!
//! | module | what |
//! |---|---|
//! | [`samples`] | the packs that are changed: small ones of all kinds, and larger random ones |
//! | [`series`] | the ways to change them: each an indexed series |
//! | [`inquiry`] | all queries on a pack that opened |
//! | [`trial`] | runs a series on threads, catches panics and hangs, counts the outcomes |
//! | [`unchecked`] | the same files, opened without the checks |
//! | [`place`] | positions of the archive's numbers in the file |
//!
//! The pack's name, the series and an index identify a change.

pub mod inquiry;
pub mod place;
pub mod samples;
pub mod series;
pub mod trial;
pub mod unchecked;

/// Bytes of the header.
pub const HEADER_LEN: usize = 64;
