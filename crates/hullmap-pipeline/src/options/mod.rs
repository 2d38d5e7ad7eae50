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
pub use table::name;
pub use template::template;

/// An option on the command line: `--max-error`, or `--set wall`.
pub fn flag(key: &str) -> String {
    let is_advanced = table::position(key).is_some_and(|index| table::OPTIONS[index].is_advanced);
    if is_advanced { format!("--set {key}") } else { format!("--{}", name(key).replace('_', "-")) }
}
