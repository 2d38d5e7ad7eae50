//! The options that shape a bake: everything, other than the source's bytes, that a pack's bytes
//! depend on.
//!
//! Layers are laid over each other, then [`OptionLayer::resolve`] fills in the defaults.

pub mod layer;
mod record;
pub mod removed;
pub mod resolved;
pub mod table;
mod template;
pub mod value;

pub use layer::OptionLayer;
pub use resolved::{BuildOptions, RecordSource};
pub use template::template;

/// The flag of an option, without dashes in front.
pub fn flag(key: &str) -> String {
    key.replace('_', "-")
}
