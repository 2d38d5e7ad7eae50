//! Faults while baking: the state of the output folder afterwards, and whether the command reported
//! it correctly.
//!
//! A [`project`] has packs of old sources, and sources that have changed. One of these faults
//! disturbs a bake of it:
//!
//! 1. [`calls`]: its Nth system call on a file fails, transfers fewer bytes, or is the last one;
//! 2. [`power`]: the power is cut, and the disk keeps any part of the data that was not synced.
//!
//! After each fault, every pack is either the old or the new one, and opens. The command's output
//! and exit code report which it is. The next bake replaces all old packs and leaves no temporary
//! files.

pub mod calls;
pub mod inject;
pub mod power;
pub mod project;
