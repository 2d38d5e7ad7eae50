//! Structs and enums of the header: plain numbers, laid out as C does.
//!
//! Documentation comments become comments of the header, so they speak of C names.

#![forbid(unsafe_code)]

mod answers;
mod facts;
mod geometry;
mod manifold;
mod motion;
mod result;
mod settings;
mod sheet;
mod status;

pub use answers::{Contact, Distance, Impact, Intersection, RayHit, SignedDistance, Support};
pub use facts::{HullArrays, HullFacts, MassProperties, MassSource, PrimitiveKind, Replacement, Solid, Text};
pub use geometry::{Bounds, Pose, Quat, Vec3};
pub use manifold::{Feature, FeatureKind, ManifoldPoint, ManifoldPoints};
pub use motion::{
    ClearSettings, Clearance, Derivatives, Differentiability, Motion, MotionKind, MotionSettings, TimeOfImpact,
    Verdict, WitnessDerivatives,
};
pub use result::{ABI_VERSION, OPEN_BORROW, OPEN_MAP, OPEN_SKIP_CONTENTS, Result};
pub use settings::{CastSettings, ManifoldSettings, Prediction, Settings};
pub use sheet::{Diagonal, EdgeClass, FieldGround, FieldLayout, MeshTriangle};
pub use status::{Overlap, Status};
