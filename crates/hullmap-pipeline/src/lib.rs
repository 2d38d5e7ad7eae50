//! The pipeline: turns files of meshes and terrains into `.hullmap` packs, one source or a folder
//! of them, and bakes in memory. The command `bake` and the bindings are thin over it.
//!
//! To bake in memory: [`bake_arrays`], [`bake_file`], [`bake_source`], [`bake_level`]. To bake
//! files: [`jobs::jobs`] finds them, and [`runner::run`] bakes them.
//!
//! | module | concept |
//! |---|---|
//! | [`jobs`] | the meshes to bake, with options and packs; in shards, batches and tasks |
//! | [`runner`] | bakes jobs, or takes their packs from a cache |
//! | [`options`] | the options that shape a pack, in one table with their defaults |
//! | [`config`], [`glob`] | `hullmap.toml`, and the globs in it |
//! | [`baker`] | all calls into `hullmap-bake` |
//! | [`content`] | what a source holds, a mesh or a terrain: read, imported, verified |
//! | [`triangle_mesh`] | triangle meshes: how they are baked, and what is counted |
//! | [`budget`] | what physics engines accept of a hull |
//! | [`mesh_file`] | hulls as files of meshes: OBJ, GLB, STL, USD |
//! | [`principal_axes`] | principal axes of an inertia tensor |
//! | [`packs`], [`open`] | packs in folders, and what they hold |
//! | [`source`] | finds the source of a pack |
//! | [`project`] | the folder outside of which no source is read |
//! | [`pack_file`], [`unfinished`] | files that are complete or absent at every moment |
//! | [`outcome`] | how work ends: done, rejected, or not possible |

#![forbid(unsafe_code)]
// Comments that repeat a name are left out; the functions of this module are documented in full.
#![expect(missing_docs, reason = "items for the command are named after what they are")]
// Text is printed by the command alone.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod baker;
pub mod budget;
pub mod config;
pub mod content;
pub mod glob;
mod in_memory;
pub mod jobs;
pub mod mesh_file;
pub mod open;
pub mod options;
pub mod outcome;
pub mod pack_file;
pub mod packs;
pub mod principal_axes;
pub mod project;
pub mod runner;
pub mod source;
pub mod triangle_mesh;
pub mod unfinished;

pub use baker::BakedPack;
pub use hullmap_bake::progress::{Progress, Stage};
pub use in_memory::{InMemoryError, bake_arrays, bake_file, bake_level, bake_source, without_flags};
