//! Polytopes around primitives, close enough to them for a proof.

use std::f64::consts::PI;

use glam::DVec3;
use hullmap_format::PrimitiveKind;

use super::shape::Primitive;
use crate::{decompose::partition::wrap, hull::Hull};
use hullmap_geometry::planes;

/// Numbers of sides around the axis of a round primitive.
const SIDES: [usize; 2] = [8, 96];

/// Distance from a face's plane up to which rounding may move the support point of a primitive,
/// relative to the diagonal.
const ROUNDING: f64 = 1e-12;

/// The hull of f32 points that contains a primitive, and reaches at most about `excess` beyond it;
/// `None` if it cannot be built. Checked: each face is outside of the primitive.
pub fn polytope(primitive: &Primitive, excess: f64, diagonal: f64) -> Option<Hull> {
    let hull = wrap::tight(&points(primitive, excess), diagonal, 0.0).filter(|hull| hull.rank == 3)?;
    let is_outside = |plane: &planes::HalfSpace| {
        primitive.reach(plane.normal) + plane.height(primitive.center) <= ROUNDING * diagonal
    };
    hull.half_spaces().iter().all(is_outside).then_some(hull)
}

/// Points whose hull contains a primitive.
pub fn points(primitive: &Primitive, excess: f64) -> Vec<DVec3> {
    let [a, b, c] = primitive.sizes;
    let sides = sides(a, excess);
    let local: Vec<DVec3> = match primitive.kind {
        PrimitiveKind::Box => (0..8)
            .map(|i| DVec3::new(a, b, c) * DVec3::from_array([0, 1, 2].map(|k| f64::from(2 * (i >> k & 1) - 1))))
            .collect(),
        PrimitiveKind::Cylinder => [-b, b].into_iter().flat_map(|z| ring(a, z, sides)).collect(),
        PrimitiveKind::Sphere => ball(a, 0.0, sides),
        PrimitiveKind::Capsule => ball(a, b, sides),
    };
    local.into_iter().map(|p| primitive.center + primitive.rotation * p).collect()
}

/// Some points of the surface of a primitive.
pub fn surface_points(primitive: &Primitive) -> Vec<DVec3> {
    let around = points(primitive, f64::INFINITY);
    let middle = primitive.center;
    let to_surface = |p: DVec3| {
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..30 {
            let half = 0.5 * (inside + outside);
            if primitive.holds(middle.lerp(p, half), 0.0) { inside = half } else { outside = half }
        }
        middle.lerp(p, inside)
    };
    around.into_iter().map(to_surface).collect()
}

/// Number of sides with which a polygon around a circle reaches at most `excess` beyond it: a
/// multiple of four, within limits.
fn sides(radius: f64, excess: f64) -> usize {
    let angle = libm::acos(radius / (radius + excess));
    let [least, most] = SIDES;
    // Infinity and NaN give the least.
    let count = if angle > 0.0 { libm::ceil(PI / angle) as usize } else { most };
    count.clamp(least, most).next_multiple_of(4)
}

fn ring(radius: f64, z: f64, sides: usize) -> impl Iterator<Item = DVec3> {
    let step = 2.0 * PI / sides as f64;
    let outer = radius / libm::cos(0.5 * step);
    (0..sides).map(move |k| {
        let angle = step * k as f64;
        DVec3::new(outer * libm::cos(angle), outer * libm::sin(angle), z)
    })
}

/// A polytope around two balls with centres at the heights `half` and `-half`. Its profile is a
/// regular polygon around the circle, with edges that touch the poles.
fn ball(radius: f64, half: f64, sides: usize) -> Vec<DVec3> {
    let steps = sides / 2;
    let step = PI / steps as f64;
    let outer = radius / libm::cos(0.5 * step);
    let rings = (0..steps).flat_map(|k| {
        let angle = step * (k as f64 + 0.5);
        let z = outer * libm::cos(angle);
        ring(outer * libm::sin(angle), if 2 * k < steps { z + half } else { z - half }, sides)
    });
    rings.collect()
}
