//! Ray cast of a triangle: the signs of three volumes decide it, in f64 with bounds of the rounding
//! error.
//!
//! # Steps
//! 1. Move the origin of the ray to the origin of the frame.
//! 2. Compute the volumes that the direction spans with each edge. If two certainly have different
//!    signs, the ray misses. If all three certainly have the same sign, its line crosses the
//!    triangle.
//! 3. Divide the volume that the origin spans with the triangle by the volume that the direction
//!    spans.
//!
//! # Deviations
//! If rounding error might change a sign, the ray is cast by support queries, whose answer says
//! that the ray grazes the triangle.
//!
//! # Reference
//! Kensler, Shirley, "Optimizing Ray-Triangle Intersection via Automated Search", 2006; Woop,
//! Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. The errors of sums and products:
//! Higham, "Accuracy and Stability of Numerical Algorithms", 2002, section 3.1.

use glam::DVec3;

use super::motion::{CastSettings, Ray};
use super::ray::RayHit;
use super::status::Status;

/// Bound of the rounding error of a volume of three vectors, each with an error of half a unit per
/// component, relative to the product of their lengths: 11 units of [`f64::EPSILON`] to first
/// order, and twice as much for the lengths.
const VOLUME_ERROR: f64 = 32.0 * f64::EPSILON;

/// Rounding error of a quotient of bounds.
const QUOTIENT_ERROR: f64 = 4.0 * f64::EPSILON;

/// Volumes below this are not used: products may underflow.
const TINY_VOLUME: f64 = 1e-250;

/// Maximum width of an interval of t, relative to t: of rays that are nearly in the plane it is
/// wider.
const MAX_WIDTH: f64 = 1e-9;

/// A vector, and its length.
#[derive(Clone, Copy)]
struct Measured(DVec3, f64);

impl Measured {
    fn new(vector: DVec3) -> Self {
        Self(vector, vector.length())
    }
}

/// The volume that three vectors span, and a bound of its rounding error.
#[inline]
fn volume(a: Measured, b: Measured, c: Measured) -> (f64, f64) {
    (a.0.dot(b.0.cross(c.0)), VOLUME_ERROR * a.1 * b.1 * c.1)
}

/// The answer of [`ray`](super::ray::ray) for a triangle, if rounding error cannot change it.
pub(crate) fn ray_triangle(corners: [DVec3; 3], ray: &Ray, settings: &CastSettings) -> Option<RayHit> {
    let dir = Measured::new(ray.direction());
    let [a, b, c] = corners.map(|corner| Measured::new(corner - ray.origin()));
    let miss = || RayHit {
        hit: false,
        status: Status::Separated,
        t: f64::INFINITY,
        t_lower: f64::INFINITY,
        t_upper: f64::INFINITY,
        point: ray.origin(),
        normal: DVec3::X,
        iterations: 0,
        support_calls: 0,
    };
    let mut signs = [false; 2];
    let mut is_sure = true;
    for (first, second) in [(c, b), (a, c), (b, a)] {
        let (volume, error) = volume(dir, first, second);
        // NaN takes the failing branch.
        if volume.abs() > error.max(TINY_VOLUME) {
            signs[usize::from(volume > 0.0)] = true;
        } else {
            is_sure = false;
        }
    }
    if signs == [true; 2] {
        return Some(miss());
    }
    if !is_sure {
        return None;
    }
    let [edge_b, edge_c] = [corners[1], corners[2]].map(|corner| Measured::new(corner - corners[0]));
    let ((height, height_error), (speed, speed_error)) = (volume(a, edge_b, edge_c), volume(dir, edge_b, edge_c));
    let (height, speed) = if speed < 0.0 { (-height, -speed) } else { (height, speed) };
    if !(speed > 2.0 * speed_error.max(TINY_VOLUME)) {
        return None;
    }
    let bound = |height: f64, speed: f64, outward: f64| {
        let t = height / speed;
        t + outward * QUOTIENT_ERROR * t.abs()
    };
    let (least, most) = (height - height_error, height + height_error);
    let t_lower = bound(least, if least > 0.0 { speed + speed_error } else { speed - speed_error }, -1.0);
    let t_upper = bound(most, if most > 0.0 { speed - speed_error } else { speed + speed_error }, 1.0);
    if t_upper < 0.0 || t_lower > settings.limit() {
        return Some(miss());
    }
    // The origin, or the end, is in the plane but for rounding; or the ray is nearly in it.
    if !(t_lower > 0.0 && t_upper <= settings.limit() && t_upper - t_lower <= MAX_WIDTH * t_upper) {
        return None;
    }
    let t = (height / speed).clamp(t_lower, t_upper);
    let normal = edge_b.0.cross(edge_c.0).normalize_or(DVec3::X);
    let normal = if normal.dot(dir.0) > 0.0 { -normal } else { normal };
    Some(RayHit {
        hit: true,
        status: Status::Exact,
        t,
        t_lower,
        t_upper,
        point: ray.point_at(t),
        normal,
        iterations: 0,
        support_calls: 0,
    })
}

#[cfg(test)]
mod tests {
    use ::shapes::rng::SplitMix64;

    use super::*;
    use crate::shapes::Triangle;
    use crate::solver::ray::ray as by_support;

    /// Small and large triangles, near and far: the intervals of both answers share a point, and
    /// most rays do not need the general search.
    #[test]
    fn answers_agree_with_those_by_support_queries() {
        let (mut rng, mut sure, mut hits, rounds) = (SplitMix64::new(5), 0, 0, 20_000);
        for round in 0..rounds {
            let (size, far) = (10_f64.powi(round % 7 - 3), 10_f64.powi(round / 7 % 5 - 2));
            let mut vector = || DVec3::from_array([(); 3].map(|()| rng.between(-1.0, 1.0)));
            let offset = vector() * far;
            // On a grid of few places, so that rays meet edges and corners.
            let mut corner = || (vector() * if round % 3 == 0 { 2.0 } else { 1e3 }).round() * size + offset.round();
            let corners = [corner(), corner(), corner()];
            let origin = corner() + DVec3::Z * size;
            let target = corners[0] + (corners[1] - corners[0]) * 0.5 + (corners[2] - corners[0]) * 0.25;
            let direction = if round % 2 == 0 { target - origin } else { vector() * size };
            let line = Ray::new(origin, direction).unwrap();
            let settings = CastSettings::default();
            let Some(found) = ray_triangle(corners, &line, &settings) else { continue };
            sure += 1;
            hits += usize::from(found.hit);
            let expected = by_support(&Triangle::new(corners).unwrap(), &line, &settings);
            if expected.status == Status::Touching {
                continue;
            }
            assert_eq!(found.hit, expected.hit, "round {round}: {found:?}, by support {expected:?}");
            if found.hit {
                let agree = found.t_lower <= expected.t_upper && expected.t_lower <= found.t_upper;
                assert!(agree, "round {round}: {found:?}, by support {expected:?}");
                assert!(found.normal.distance(expected.normal) < 1e-6, "round {round}: {found:?}, {expected:?}");
            }
        }
        println!("{sure} sure, {hits} hits");
        assert!(sure > rounds as usize / 2 && hits > rounds as usize / 5);
    }
}
