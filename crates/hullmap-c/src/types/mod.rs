//! Structs and enums of the header: plain numbers, laid out as C does.
//!
//! Answers are the structs of `hullmap` itself, which have this layout. Here are those that C sees
//! in another way: arguments, which are checked, and handles' contents. Documentation comments
//! become comments of the header, so they use C names.

#![forbid(unsafe_code)]

mod facts;
mod geometry;
mod manifold;
mod motion;
mod result;
mod settings;
mod sheet;

pub use facts::{HullArrays, HullFacts, MassProperties, PrimitiveKind, Replacement, Solid, Text};
pub use geometry::Pose;
pub use hullmap::glam::{DQuat, DVec3};
pub use hullmap::height_field::{Diagonal, Ground};
pub use hullmap::{
    Bounds, Clearance, Contact, Derivatives, Differentiability, Distance, EdgeClass, Impact, Intersection, MassSource,
    Overlap, RayHit, SignedDistance, Status, SupportPoint, TimeOfImpact, Verdict, WitnessDerivatives,
};
pub use manifold::{Feature, FeatureKind, ManifoldPoint, ManifoldPoints};
pub use motion::{ClearSettings, Motion, MotionKind, MotionSettings};
pub use result::{ABI_VERSION, OPEN_BORROW, OPEN_MAP, OPEN_SKIP_CONTENTS, Result};
pub use settings::{CastSettings, ManifoldSettings, Prediction, Settings};
pub use sheet::{FieldLayout, MeshTriangle};
