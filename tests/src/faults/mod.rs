//! Faults while baking: what is in the output folder afterwards, and whether the command told the truth.
//!
//! A [`project`] has packs of old sources, and sources that have changed. A bake of it meets a fault:
//!
//! 1. [`calls`]: its Nth system call on a file fails, moves fewer bytes, or is its last;
//! 2. [`kills`]: SIGKILL at a random moment, alone or beside another bake;
//! 3. [`power`]: the power is cut, and the disk keeps of what was not synced whatever it likes.
//!
//! After each, every pack is the old one or the new one, and opens; what the command printed and its exit code say which;
//! and the next bake makes all packs new and leaves nothing temporary.

pub mod calls;
pub mod inject;
pub mod kills;
pub mod power;
pub mod project;
