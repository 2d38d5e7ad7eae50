//! Runtime for `.hullmap` packs.

pub mod support_map;
pub use support_map::{Support, SupportMap};
