//! Primitive shapes (sphere, box, capsule, cylinder, cone, segment, triangle, half-space) and
//! modifiers of shapes (scaled, rounded).
//!
//! All except the half-space can be paired with hulls and with each other in every query. To add a
//! shape, follow the recipe in CONTRIBUTING.md; `cone.rs` is a complete example.
//!
//! | shape | position in its frame | core | convex radius |
//! |---|---|---|---|
//! | [`Sphere`] | about the origin | point | radius |
//! | [`Cuboid`] | about the origin, edges along the axes | itself | 0 |
//! | [`Capsule`] | about the origin, along z; or between any two points | segment | radius |
//! | [`Cylinder`] | about the origin, along z | itself | 0 |
//! | [`Cone`] | along z, apex up, the origin halfway up | itself | 0 |
//! | [`Segment`] | between any two points | itself | 0 |
//! | [`Triangle`] | between any three points | itself | 0 |
//! | [`Scaled`] | inner shape, scaled or mirrored | scaled[^uniform] | scaled[^uniform] |
//! | [`Rounded`] | Minkowski sum of an inner shape and a ball | inner core | sum of both |
//!
//! A [`HalfSpace`] is unbounded, so it has no support mapping. Its queries against every shape have
//! closed forms.
//!
//! Queries solve the core and then add the convex radius, which is exact and takes few steps. Other
//! curved surfaces, such as the side of a cylinder, take more steps.
//!
//! [^uniform]: If the scales are equal in magnitude. Otherwise the shape is its own core, with
//! radius 0.
//!
//! # Examples
//! ```
//! use hullmap::glam::DVec3;
//! use hullmap::shapes::{Capsule, Cuboid, Rounded};
//! use hullmap::{Cache, Pose, Settings};
//!
//! let player = Capsule::new(0.6, 0.3)?;
//! let stone = Rounded::new(Cuboid::new(DVec3::new(0.5, 0.4, 0.2))?, 0.1)?;
//! let b_in_a = Pose::from_translation(DVec3::new(1.0, 0.0, 0.0))?;
//! let gap = hullmap::distance(&player, &stone, b_in_a, &Settings::default(), &mut Cache::new());
//! assert!((gap.distance - 0.1).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Reference
//! Support mappings in closed form: Snethen, "XenoCollide", Game Programming Gems 7; van den
//! Bergen, "Collision Detection in Interactive 3D Environments", 4.3.
//!
//! # Deviations
//! - Directions need not be of unit length, nor finite: every direction returns a point of the
//!   shape.

#![forbid(unsafe_code)]

mod capsule;
mod cone;
mod cuboid;
mod cylinder;
pub(crate) mod error;
pub(crate) mod feature;
pub(crate) mod half_space;
mod rounded;
mod scaled;
mod segment;
pub(crate) mod shape;
mod sphere;
pub(crate) mod triangle;

pub use capsule::Capsule;
pub use cone::Cone;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use error::ShapeError;
#[doc(hidden)]
pub use feature::tilted;
pub use feature::{Corner, Feature, MAX_CORNERS, TILT, ring};
pub use half_space::HalfSpace;
pub use rounded::Rounded;
pub use scaled::Scaled;
pub use segment::Segment;
pub use shape::Shape;
pub use sphere::Sphere;
pub use triangle::Triangle;

use crate::support::FeaturePoint;
use crate::vector::unit;
use feature::turn;
use glam::{DMat3, DVec3};

/// `dir` normalised, even if its square overflows or underflows; x if it is zero or not finite.
fn direction(dir: DVec3) -> DVec3 {
    unit(dir).or_else(|| unit(dir / dir.abs().max_element())).unwrap_or(DVec3::X)
}

/// Component of `dir` perpendicular to z, normalised; x if it is zero or not finite.
fn radial(dir: DVec3) -> DVec3 {
    direction(DVec3::new(dir.x, dir.y, 0.0))
}

/// Length of (x, y). `hypot` is avoided because its last digits depend on the platform; lengths
/// here are far from overflow.
fn length_of(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Vertex id of the first point on the rim of a disc; the others follow in order.
const RIM: u32 = 8;

/// Adds the rim of a disc perpendicular to z, as [`MAX_CORNERS`] points.
fn push_rim(out: &mut Feature, z: f64, radius: f64, first: u32) {
    for step in 0..MAX_CORNERS {
        let (x, y) = turn(step);
        out.push(Corner { point: DVec3::new(x * radius, y * radius, z), vertex: first + step as u32 });
    }
}

/// Moves the feature of a core outward by the convex radius. `interior` is a point inside the core.
///
/// A face moves along its own normal. An edge has many normals, and moves along the one closest to
/// `dir`. Both then lie on the rounded surface. A feature whose normal is
/// far from `dir`, such as a needle's, moves along `dir`, and counts as curved. An edge that is not
/// perpendicular to `dir` also counts as curved, because its closest normal may not be a normal of
/// the core.
fn round(out: &mut Feature, dir: DVec3, radius: f64, interior: DVec3) {
    /// Maximum cosine of the angle between perpendicular directions: rounding error.
    const LEVEL: f64 = 1e-9;
    /// Minimum cosine of the angle between `dir` and the normal of a feature that faces it: five
    /// times the tilt within which faces are merged.
    const FACING: f64 = 0.98;
    let n = direction(dir);
    let mut is_level = true;
    let outward = match out.corners() {
        [] | [_] => n,
        [a, b] => {
            let along = direction(b.point - a.point);
            is_level = n.dot(along).abs() <= LEVEL;
            n - along * n.dot(along)
        }
        corners => {
            let normal = corners.windows(3).fold(DVec3::ZERO, |sum, c| match c {
                [a, b, c] => sum + (b.point - a.point).cross(c.point - a.point),
                _ => sum,
            });
            // A thin shape's feature may face away from `dir` a little.
            let height = corners.iter().map(|corner| normal.dot(corner.point - interior)).sum::<f64>();
            normal * if height == 0.0 { normal.dot(n) } else { height }
        }
    };
    let facing = unit(outward).filter(|outward| outward.dot(n) >= FACING);
    if !is_level || facing.is_none() {
        out.set_curved();
    }
    if out.corners().len() > 1 {
        out.set_rounded();
    }
    // The point of a ball moves with the direction.
    out.set_fall(0.0);
    let offset = facing.unwrap_or(n) * radius;
    out.corners_mut().iter_mut().for_each(|corner| corner.point += offset);
}

/// Keeps every eighth corner of a disc: the square is the largest quadrilateral in its polygon.
fn reduce_rim(out: &mut Feature) {
    if out.corners().len() == MAX_CORNERS {
        out.retain(|corner| (corner.vertex - RIM).is_multiple_of(MAX_CORNERS as u32 / 4));
        out.set_reduced();
    }
}

/// The point of a rim about the z axis that is farthest along `dir`.
fn rim_point(dir: DVec3, radius: f64, z: f64) -> FeaturePoint {
    let u = radial(dir);
    let around = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)) - DMat3::from_cols(u * u.x, u * u.y, DVec3::ZERO);
    let derivative = if radius > 0.0 { around * (radius / length_of(dir.x, dir.y)) } else { DMat3::ZERO };
    FeaturePoint { point: u * radius + DVec3::Z * z, derivative }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_is_normalised() {
        for dir in [DVec3::splat(1e-320), DVec3::splat(1e300), DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::INFINITY] {
            assert!((direction(dir).length() - 1.0).abs() < 1e-12, "{dir}");
            assert!((radial(dir).length() - 1.0).abs() < 1e-12, "{dir}");
        }
    }
}
