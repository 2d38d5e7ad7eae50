//! Batches of support queries, intersection tests, distances and contacts of baked hulls, as
//! compute kernels (wgpu, WGSL) on the bytes of a pack.
//!
//! [`Batch`] solves pairs of hulls of one pack or several, on a Vulkan device or on the processor.
//! The kernels compute in f32. They return intervals that contain the distance in spite of all
//! rounding errors, fused operations included, and a [`Status`] that says what is proven.
//! [`Batch::settle`] finishes on the processor, in f64, what f32 left open.
//!
//! # Limits
//! - Sections longer than a binding are an error.
//! - Correctness is tested on Mesa's lavapipe, and was checked once on an NVIDIA H100. docs/gpu.md
//!   has times.

#![forbid(unsafe_code)]

mod batch;
mod device;
mod error;
mod records;
mod rounding;

pub use batch::{Backend, Batch, SupportAnswer, SupportQuery};
pub use device::{Device, DevicePack};
pub use error::Error;
pub use records::{Answer, AnswerRecord, IndexedPair, MAX_STEPS, PairRecord, Query, Status};
pub use rounding::SUPPORT_SHORTFALL;
