//! The adapter, compiled once for each precision: `parry` is `parry3d` or `parry3d-f64`, and `Real`
//! is its scalar.

use super::parry;

mod baked_hull;
mod convert;
mod debug;
#[cfg(feature = "dispatcher")]
mod dispatcher;
mod mass;
mod objects;
mod point;
mod polygon;
mod ray;
#[cfg(feature = "serde")]
mod saved;
mod shape;
mod support;
mod surface;

pub use baked_hull::{BakedHull, PartMass};
#[cfg(feature = "dispatcher")]
pub use dispatcher::HullDispatcher;
pub use objects::{Object, compound, objects, union};
#[cfg(feature = "serde")]
pub use saved::{Packs, SavedHull, SavedShape, SavedShapeError, is_custom};
pub use surface::{BakedSurface, JoinError, Sheet, SurfaceTile};
