//! Generated shapes for tests and benchmarks: seeded point families, solids, and files of them.
//!
//! All output is a pure function of the arguments, bit for bit on every machine. Randomness comes
//! from [`rng::SplitMix64`], trigonometry from the `libm` crate (plain Rust, in `f64`). Nothing
//! reads a clock, a path or the order of a hash map. Lengths have no unit, shapes have a radius of
//! about one, z is up, and faces wind counter-clockwise seen from outside.
//!
//! ```
//! use shapes::families::Family;
//!
//! let points = Family::Lens.points(1_000, 7);
//! assert_eq!(points.len(), 1_000);
//! assert!(points.iter().all(|p| p[2].abs() <= 0.05));
//! ```

#![forbid(unsafe_code)]

pub mod capped;
pub mod collada;
pub mod concave;
pub mod cubes;
pub mod families;
pub mod gltf;
pub mod mesh;
pub mod msh;
pub mod obj;
pub mod ply;
pub mod solids;
pub mod stl;
mod turn;
mod vector;

/// The seeded generator that all shapes are drawn with.
pub use hullmap_random as rng;
