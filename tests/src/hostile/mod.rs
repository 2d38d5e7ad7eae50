//! Files that someone made to do harm: packs that are changed and, mostly, given a right checksum again.
//!
//! The promise: such a file is refused, or it opens and every query on it ends, without panic and without a read out of
//! bounds, however wrong the answers are.
//!
//! | module | what |
//! |---|---|
//! | [`samples`] | the packs that are changed: small ones of all kinds, and larger ones that are drawn |
//! | [`series`] | the ways to change them: each a numbered series |
//! | [`inquiry`] | all that can be asked of a pack that opened |
//! | [`trial`] | a series tried on threads: panics and hangs caught, the ends counted |
//! | [`unchecked`] | the same files opened without the checks: what then happens |
//! | [`place`] | where a number of the archive stands in the file |
//!
//! A change is found again by the pack's name, the series and its number.

pub mod inquiry;
pub mod place;
pub mod samples;
pub mod series;
pub mod trial;
pub mod unchecked;

/// Bytes of the header.
pub const HEADER_LEN: usize = 64;
