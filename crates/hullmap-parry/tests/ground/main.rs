//! Surfaces as parry's shapes: against brute force over all triangles in f64, and against parry's
//! own triangle meshes.

#[cfg(feature = "dispatcher")]
mod bodies;
mod grounds;
mod shapes_of_parry;

#[cfg(feature = "dispatcher")]
mod contacts;
#[cfg(feature = "dispatcher")]
mod queries;
