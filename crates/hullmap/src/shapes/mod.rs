//! Shapes in closed form, and shapes made of others: all of them mix with hulls and with each other in every query.
//!
//! | shape | placed in its frame | core and radius |
//! |---|---|---|
//! | [`Sphere`] | about the origin | point, its radius |
//! | [`Cuboid`] | about the origin, edges along the axes | |
//! | [`Capsule`] | about the origin, along z | segment, its radius |
//! | [`Cylinder`] | about the origin, along z | |
//! | [`Cone`] | along z, tip up, the origin halfway up | |
//! | [`Scaled`] | another shape, scaled along the axes, perhaps mirrored | |
//! | [`Rounded`] | another shape and a ball, summed | the other shape's, its radius and the other's |
//!
//! The queries solve those with a core by their cores, in few steps and exactly (`rounding`); other curved
//! shapes like any support mapping, in more steps.
//!
//! # Reference
//! Support mappings in closed form: Snethen, "XenoCollide", Game Programming Gems 7; van den Bergen, "Collision Detection
//! in Interactive 3D Environments", 4.3.
//!
//! # Deviations
//! - The directions given need not be of unit length, nor finite: a point of the shape comes back for all.

#![forbid(unsafe_code)]

mod capsule;
mod cone;
mod cuboid;
mod cylinder;
mod error;
mod rounded;
mod scaled;
mod sphere;

pub use capsule::Capsule;
pub use cone::Cone;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use error::ShapeError;
pub use rounded::Rounded;
pub use scaled::Scaled;
pub use sphere::Sphere;

use crate::minkowski::unit;
use crate::shape::{Corner, Feature, MAX_CORNERS, turn};
use glam::DVec3;

/// `dir` at unit length, whatever its own; x where it has none or is not finite.
fn direction(dir: DVec3) -> DVec3 {
    unit(dir).or_else(|| unit(dir / dir.abs().max_element())).unwrap_or(DVec3::X)
}

/// The part of `dir` across z, at unit length; x where there is none.
fn radial(dir: DVec3) -> DVec3 {
    direction(DVec3::new(dir.x, dir.y, 0.0))
}

/// Length of (x, y). Not `hypot`, which is the platform's own and differs in its last digits; lengths here are far from overflow.
fn length_of(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Feature numbers of points of the rim of a disc are this and the place on the rim.
const RIM: u32 = 8;

/// The rim of a disc across z, as [`MAX_CORNERS`] points.
fn push_rim(out: &mut Feature, z: f64, radius: f64, first: u32) {
    for step in 0..MAX_CORNERS {
        let (x, y) = turn(step);
        out.push(Corner { point: DVec3::new(x * radius, y * radius, z), vertex: first + step as u32 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_direction_has_unit_length() {
        for dir in [DVec3::splat(1e-320), DVec3::splat(1e300), DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::INFINITY] {
            assert!((direction(dir).length() - 1.0).abs() < 1e-12, "{dir}");
            assert!((radial(dir).length() - 1.0).abs() < 1e-12, "{dir}");
        }
    }
}
