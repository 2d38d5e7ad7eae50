//! Shapes for `parry3d`, in single precision. The root of the crate re-exports them.

pub(crate) use parry3d as parry;

#[path = "adapter/mod.rs"]
mod adapter;

pub use adapter::*;
