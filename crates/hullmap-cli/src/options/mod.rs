//! The options that shape a bake: everything, other than the source's bytes, that a pack's bytes
//! depend on.
//!
//! | module | concept |
//! |---|---|
//! | [`table`] | **the table of all options**: key, accepted values, default, help |
//! | [`value`] | the values that options take, and how they are written |
//! | [`layer`] | options given by one source: command line, `hullmap.toml`, or record |
//! | [`resolved`] | the options of one bake, once all layers are laid over each other |
//! | [`flags`] | a layer as flags of `bake build` and `bake decompose` |
//! | [`mod@template`] | the `hullmap.toml` that `bake init` writes |
//! | [`record`] | the text in which a pack records its options |
//! | [`removed`] | options of earlier versions, and what to use instead |
//!
//! Layers are laid over each other, then [`OptionLayer::resolve`] fills in the defaults. To add an
//! option, add a row to the table and read it in one of the methods of [`BuildOptions`].

#[cfg(feature = "command")]
mod flags;
pub mod layer;
mod record;
pub mod removed;
pub mod resolved;
pub mod table;
#[cfg(feature = "command")]
mod template;
pub mod value;

#[cfg(feature = "command")]
pub use flags::{PartsLayer, flag};
pub use layer::OptionLayer;
pub use resolved::BuildOptions;
#[cfg(feature = "command")]
pub use resolved::RecordSource;
#[cfg(feature = "command")]
pub use template::template;
