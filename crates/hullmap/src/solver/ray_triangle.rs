//! Ray cast of a triangle: the signs of three volumes decide it, exactly.
//!
//! # Steps
//! 1. Move the origin of the ray to the origin of the frame.
//! 2. Compute the volumes that the direction spans with each edge. If two certainly have different
//!    signs, the ray misses. If all three certainly have the same sign, its line crosses the
//!    triangle.
//! 3. Divide the volume that the origin spans with the triangle by the volume that the direction
//!    spans.
//! 4. If rounding error might change a sign, or the interval of t would be wide, decide by exact
//!    arithmetic ([`exact_ray`](super::exact_ray)). A volume of 0 has both signs: a triangle is
//!    closed, and so is the ray at both ends.
//!
//! # Reference
//! Kensler, Shirley, "Optimizing Ray-Triangle Intersection via Automated Search", 2006; Woop,
//! Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013.

use glam::DVec3;

use super::exact_ray::{ExactRay, Measured, Meeting, TINY_VOLUME, volume};
use super::motion::{CastSettings, Ray};
use super::ray_hit::RayHit;
use super::status::Status;

/// Rounding error of a quotient of bounds.
const QUOTIENT_ERROR: f64 = 4.0 * f64::EPSILON;

/// Maximum width of an interval of t, relative to t: of rays that are nearly in the plane it is
/// wider.
const MAX_WIDTH: f64 = 1e-9;

/// Where a ray first meets a closed triangle, which may be a segment or a point.
#[inline]
pub(crate) fn ray_triangle(corners: [DVec3; 3], ray: &Ray, settings: &CastSettings) -> RayHit {
    by_volumes(corners, ray, settings).unwrap_or_else(|| exactly(corners, ray, settings))
}

/// Whether a ray moves towards the front of a triangle: the side from which its corners turn
/// counter-clockwise.
pub(crate) fn is_towards_front(corners: [DVec3; 3], ray: &Ray) -> bool {
    ray.direction() != DVec3::ZERO && ExactRay::new(ray, &CastSettings::default()).facing(corners) < 0
}

/// The answer, if rounding error cannot change it.
#[inline]
fn by_volumes(corners: [DVec3; 3], ray: &Ray, settings: &CastSettings) -> Option<RayHit> {
    let dir = Measured::new(ray.direction());
    let [a, b, c] = corners.map(|corner| Measured::new(corner - ray.origin()));
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
        return Some(RayHit::miss(ray));
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
        return Some(RayHit::miss(ray));
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
        part: 0,
    })
}

/// The answer by exact arithmetic.
#[cold]
#[inline(never)]
fn exactly(corners: [DVec3; 3], ray: &Ray, settings: &CastSettings) -> RayHit {
    let (line, mut found) = (ExactRay::new(ray, settings), Meeting::new());
    line.meet(corners, &mut found);
    if !found.is_hit() {
        return RayHit::miss(ray);
    }
    let [t_lower, t, t_upper] = found.entry(&line);
    let normal = match line.facing(corners) {
        0 => edge_normal(corners, ray, t).unwrap_or_else(|| line.against()),
        facing => normal(corners) * -f64::from(facing),
    };
    RayHit {
        hit: true,
        status: Status::Exact,
        t,
        t_lower,
        t_upper,
        point: ray.point_at(t),
        normal,
        ..RayHit::miss(ray)
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or(DVec3::X)
}

/// The outward normal, in the plane of a triangle, of the edge through which a ray in this plane
/// enters the triangle at `t`; `None` if it starts inside, and for triangles without area.
///
/// # Reference
/// Cyrus, Beck, 1978.
fn edge_normal(corners: [DVec3; 3], ray: &Ray, t: f64) -> Option<DVec3> {
    let ([a, b, c], normal) = (corners, normal(corners));
    let entered = [(a, b), (b, c), (c, a)].into_iter().filter_map(|(from, to)| {
        let outward = (to - from).cross(normal).normalize_or_zero();
        let speed = -outward.dot(ray.direction());
        (speed > 0.0).then(|| (outward.dot(ray.origin() - from) / speed, outward))
    });
    entered.filter(|_| t > 0.0).max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, outward)| outward)
}

#[cfg(test)]
mod tests {
    use ::shapes::rng::SplitMix64;

    use super::*;
    use crate::shapes::Triangle;
    use crate::solver::ray::ray as by_support;

    /// Small and large triangles, near and far: all answers agree with the search among vertices
    /// or its intervals share a point, and most rays do not need exact arithmetic.
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
            let found = ray_triangle(corners, &line, &settings);
            // The square of the direction's length underflowed, and so did the bound of the error.
            let slow = Ray::new(origin, direction * 2_f64.powi(-600)).unwrap();
            assert_eq!(ray_triangle(corners, &slow, &settings).hit, found.hit, "round {round}: {found:?}");
            let is_sure = by_volumes(corners, &line, &settings).is_some();
            sure += usize::from(is_sure);
            hits += usize::from(found.hit);
            let expected = by_support(&Triangle::new(corners).unwrap(), &line, &settings);
            assert_ne!(expected.status, Status::Touching, "round {round}: {found:?}, by support {expected:?}");
            assert_eq!(found.hit, expected.hit, "round {round}: {found:?}, by support {expected:?}");
            if found.hit {
                let agree = found.t_lower <= expected.t_upper && expected.t_lower <= found.t_upper;
                assert!(agree, "round {round}: {found:?}, by support {expected:?}");
                assert!(
                    !is_sure || found.normal.distance(expected.normal) < 1e-6,
                    "round {round}: {found:?}, {expected:?}"
                );
            }
        }
        println!("{sure} sure, {hits} hits");
        assert!((rounds as usize / 2..rounds as usize * 49 / 50).contains(&sure) && hits > rounds as usize / 5);
    }
}
