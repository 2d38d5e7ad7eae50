//! Support mappings: the trait that shapes implement, and the look-up that implements it for a
//! baked hull.
//!
//! A support query on a hull goes through `index`, which chooses the path (direction → cell → leaf,
//! or a scan), and `best_candidate` (leaf → support vertex), with the instruction set that `simd`
//! selected. `hint` tests whether the support vertex of the previous query is still the answer;
//! `hull/support_mapping.rs` decides whether to try that first.

pub(crate) mod best_candidate;
mod bounds;
pub(crate) mod candidate;
pub(crate) mod direction;
pub(crate) mod hint;
pub(crate) mod index;
mod paused_lookup;
pub(crate) mod simd;
pub(crate) mod support_map;

pub use bounds::Bounds;
#[doc(hidden)]
pub use paused_lookup::Lookup;
pub use simd::Instructions;
pub use support_map::{FeaturePoint, LevelEdges, SupportMap, SupportPoint};
