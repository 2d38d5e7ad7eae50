//! Shapes for `parry3d-f64`, in double precision.

pub(crate) use parry3d_f64 as parry;

#[path = "adapter/mod.rs"]
mod adapter;

pub use adapter::*;
