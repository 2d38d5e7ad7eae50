//! Hulls and surfaces as parry's shapes, and the dispatcher: against brute force over all vertices,
//! faces and triangles in f64, and against parry's own shapes.

mod bodies;
mod grounds;
mod mass;
mod shape;
mod shapes_of_parry;

#[cfg(feature = "dispatcher")]
mod contacts;
#[cfg(feature = "dispatcher")]
mod dispatcher;
#[cfg(feature = "dispatcher")]
mod judge;
#[cfg(feature = "dispatcher")]
mod motion;
#[cfg(feature = "dispatcher")]
mod queries;
