//! Baked hulls as shapes of parry3d, the collision library of Rapier and Avian.
//!
//! [`BakedHull`] is a hull of a `.hullmap` pack as a parry `Shape`. Support queries, rays, point
//! queries, bounds and mass cost nearly the same for 32 vertices as for 8,192, and nothing is
//! computed when it is created. It works wherever parry takes a shape, without further set-up:
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let pack = pack();
//! use std::sync::Arc;
//! use hullmap_parry::BakedHull;
//! use parry3d::math::{Pose, Vector};
//! use parry3d::query;
//! use parry3d::shape::{Ball, SharedShape};
//!
//! let pack: Arc<hullmap::Pack> = Arc::new(pack);
//! let cube: SharedShape = BakedHull::new(pack.shared_hull_named("cube")?).into();
//! // The cube extends by 1 from its centre.
//! let ball = Ball::new(0.5);
//! let distance = query::distance(&Pose::IDENTITY, &*cube, &Pose::translation(3.0, 0.0, 0.0), &ball)?.distance;
//! assert!((distance - 1.5).abs() < 1e-6);
//! assert!((cube.mass_properties(1.0).mass() - 8.0).abs() < 1e-5);
//! # Ok(())
//! # }
//! ```
//!
//! A pack of convex parts (`bake build --decompose`) becomes one shape for each object of its
//! source with [`objects`]. [`BakedSurface`] is static ground that keeps its triangles: a triangle
//! mesh, a height field, or several that meet.
//!
//! With the feature `dispatcher`, `HullDispatcher` solves pairs that have a baked hull or a surface
//! with hullmap's solver and manifolds, and casts of shapes that turn. In Rapier:
//! `NarrowPhase::with_query_dispatcher(HullDispatcher)`.
//!
//! # Limits of engines with custom shapes
//!
//! - Debug rendering draws nothing. Draw the mesh of [`BakedHull::to_trimesh`] or
//!   [`BakedSurface::to_trimesh`].
//! - Serialising a shape or a collider fails: "TypedShape::Custom cannot be serialized". The
//!   feature `serde` provides a workaround, `SavedShape`, for hulls and compounds of them.
//! - `HullDispatcher` passes pairs with other custom shapes to parry's default dispatcher.
//! - Rapier's character controller always uses parry's default dispatcher. Baked hulls work with
//!   it.
//!
//! # Features of the crate
//!
//! - `f32` (default): for `parry3d`. The root of this crate re-exports the module [`f32`](mod@f32).
//! - `f64`: for `parry3d-f64`, with the same items in the module `f64`. Both may be on.
//! - `dispatcher`: `HullDispatcher`, which solves pairs that have a baked hull with hullmap.
//! - `serde`: `SavedShape`, for saving and loading shapes with baked hulls.
//!
//! # Frames and units
//!
//! A shape has the frame and units of its hull, and these are the frame and units of the source
//! mesh. If the bake recentred the source, [`Hull::origin`](hullmap::Hull::origin) is the frame's
//! origin in coordinates of the source. Surfaces have the frame and units of their files; heights
//! of a field are along +z.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]
// Both modules are made from one folder, each with its own parry.
#![allow(clippy::duplicate_mod)]

#[cfg(not(any(feature = "f32", feature = "f64")))]
compile_error!("hullmap-parry needs the feature `f32` (parry3d) or `f64` (parry3d-f64)");

#[cfg(feature = "f32")]
pub mod f32;
#[cfg(feature = "f64")]
pub mod f64;

#[cfg(feature = "f32")]
pub use self::f32::*;

#[cfg(all(doctest, feature = "f32"))]
#[doc = include_str!("../README.md")]
pub struct Readme;
