//! The options that shape a bake: everything, other than the source's bytes, that a pack's bytes
//! depend on.
//!
//! Layers are laid over each other, then [`OptionLayer::resolve`] fills in the defaults.

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
pub use flags::{PartsLayer, TERRAIN, flag};
pub use layer::OptionLayer;
pub use resolved::BuildOptions;
#[cfg(feature = "command")]
pub use resolved::RecordSource;
#[cfg(feature = "command")]
pub use template::template;
