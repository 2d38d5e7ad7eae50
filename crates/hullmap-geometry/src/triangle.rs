//! Triangles: the nearest point, and cells of a surface that can be halved.
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
//!
//! # Deviations
//! - The nearest points of the three edges are compared as well, so that the result is a point of
//!   the triangle for any triangle, however thin, and nearest except for rounding error.

use glam::DVec3;

/// Sine of the angle between a triangle's edges below which its normal is not trusted.
const SLIVER: f64 = 1e-6;

/// Maximum error of the normal of any other triangle.
const NORMAL_ERROR: f64 = 1e-9;

/// Corners of a triangle.
pub type Triangle = [DVec3; 3];

/// Sine of the angle at the first corner below which the projection onto the plane is refined.
const THIN: f64 = 1e-3;

/// Sine of that angle below which refinements do not converge: the error of a distance is then up
/// to the triangle's height.
const NEEDLE: f64 = 1e-7;

/// Number of refinements of the projection. Each divides the error by over 40, except for needles.
const REFINEMENTS: usize = 8;

/// Barycentric coordinate up to which a point may be beside the opposite edge, relative to the
/// greatest one. It is far above the rounding error of a triangle that is not thin.
const BESIDE: f64 = 1e-6;

struct Plane {
    a: DVec3,
    ab: DVec3,
    ac: DVec3,
    aa: f64,
    ab_ac: f64,
    cc: f64,
    /// Square of twice the area.
    area: f64,
}

impl Plane {
    fn new([a, b, c]: &Triangle) -> Self {
        let (ab, ac) = (*b - *a, *c - *a);
        let (aa, ab_ac, cc) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
        Self { a: *a, ab, ac, aa, ab_ac, cc, area: aa * cc - ab_ac * ab_ac }
    }

    /// Whether the sine of the angle at the first corner exceeds `sine`. NaN of a degenerate
    /// triangle does not.
    fn is_wider(&self, sine: f64) -> bool {
        self.area > sine * sine * self.aa * self.cc
    }

    /// Coordinates of the projection of a step from the first corner, times `area`.
    fn scaled(&self, step: DVec3) -> (f64, f64) {
        let (d1, d2) = (self.ab.dot(step), self.ac.dot(step));
        (self.cc * d1 - self.ab_ac * d2, self.aa * d2 - self.ab_ac * d1)
    }

    fn point(&self, (v, w): (f64, f64)) -> DVec3 {
        self.a + v * self.ab + w * self.ac
    }

    /// The projection of `p`, if it is in the triangle. `scaled` are its rough coordinates.
    fn projection(&self, p: DVec3, scaled: (f64, f64), refinements: usize) -> Option<DVec3> {
        let (mut v, mut w) = (scaled.0 / self.area, scaled.1 / self.area);
        for _ in 0..refinements {
            let (dv, dw) = self.scaled(p - self.point((v, w)));
            (v, w) = (v + dv / self.area, w + dw / self.area);
        }
        // NaN and infinite coordinates of a degenerate triangle fail the test.
        (v >= 0.0 && w >= 0.0 && v + w <= 1.0).then(|| self.point((v, w)))
    }
}

/// The point of a triangle nearest to `p`, a convex combination of the corners. The error of its
/// distance is at most [`needle`], besides rounding.
pub fn nearest(triangle: &Triangle, p: DVec3) -> DVec3 {
    let plane = Plane::new(triangle);
    if !plane.is_wider(THIN) {
        return nearest_of_all(triangle, p);
    }
    let (v, w) = plane.scaled(p - plane.a);
    let u = plane.area - v - w;
    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
        return plane.projection(p, (v, w), 1).unwrap_or_else(|| nearest_of_all(triangle, p));
    }
    // Only an edge that has the point on its outer side can be nearest.
    let [a, b, c] = *triangle;
    let beside = BESIDE * u.abs().max(v.abs()).max(w.abs());
    let mut best = (f64::INFINITY, a);
    for (weight, edge) in [(w, [a, b]), (u, [b, c]), (v, [c, a])] {
        if weight <= beside {
            let candidate = nearest_on_segment(edge, p);
            let square = candidate.distance_squared(p);
            if square < best.0 {
                best = (square, candidate);
            }
        }
    }
    best.1
}

/// For any triangle, however thin: the nearest of the projection and of the points of all edges.
fn nearest_of_all(triangle: &Triangle, p: DVec3) -> DVec3 {
    let [a, b, c] = *triangle;
    let plane = Plane::new(triangle);
    let projection = plane.projection(p, plane.scaled(p - a), REFINEMENTS);
    let edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(edge, p));
    let closer = |x: DVec3, y: DVec3| if y.distance_squared(p) < x.distance_squared(p) { y } else { x };
    edges.into_iter().chain(projection).fold(edges[0], closer)
}

/// Error bound of distances by [`nearest`], beyond rounding: 0, or the height of a needle.
pub fn needle(triangle: &Triangle) -> f64 {
    let [a, b, c] = *triangle;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let height = (b - a).cross(c - a).length() / longest;
    if Plane::new(triangle).is_wider(NEEDLE) || height.is_nan() { 0.0 } else { height }
}

fn nearest_on_segment([a, b]: [DVec3; 2], p: DVec3) -> DVec3 {
    let ab = b - a;
    let along = (p - a).dot(ab) / ab.length_squared();
    // NaN of a segment without length takes the first end.
    if along >= 1.0 {
        b
    } else if along > 0.0 {
        a + along * ab
    } else {
        a
    }
}

/// Bounds on the heights along `normal` of the part of a triangle within `radius` of a point.
pub fn heights_in_ball(corners: &Triangle, normal: DVec3, p: DVec3, radius: f64) -> [f64; 2] {
    let [a, b, c] = *corners;
    let [x, y, z] = corners.map(|corner| normal.dot(corner));
    let [low, high] = [x.min(y).min(z), x.max(y).max(z)];
    let area = (b - a).cross(c - a);
    // The normal of a sliver is rounding error.
    let Some(own) = area.try_normalize().filter(|_| area.length() > SLIVER * (b - a).length() * (c - a).length())
    else {
        return [low, high];
    };
    // The ball cuts a disc out of the triangle's plane.
    let slack = NORMAL_ERROR * (p.distance(a) + radius);
    let from_plane = own.dot(p - a);
    let in_plane = ((radius + slack).powi(2) - (from_plane.abs() - slack).max(0.0).powi(2)).max(0.0).sqrt();
    let middle = normal.dot(p - own * from_plane);
    let half = in_plane * (normal.cross(own).length() + NORMAL_ERROR) + slack;
    [low.max(middle - half), high.min(middle + half)]
}

/// A triangle of indices from its least one on, in the same orientation.
pub fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The mean of the corners.
pub fn centroid([a, b, c]: &Triangle) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// The centroid, and the radius of a ball around it that contains the triangle.
pub fn ball(corners: &Triangle) -> (DVec3, f64) {
    let centre = centroid(corners);
    (centre, corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f64::max))
}

/// The greatest distance of points from a triangle.
pub fn farthest(points: &[DVec3], triangle: &Triangle) -> f64 {
    points.iter().map(|p| nearest(triangle, *p).distance(*p)).fold(0.0, f64::max)
}

/// The halves of a triangle, cut through its longest edge.
pub fn halves(&[a, b, c]: &Triangle) -> [Triangle; 2] {
    let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    let [p, q, r] = if lengths[0] >= lengths[1] && lengths[0] >= lengths[2] {
        [a, b, c]
    } else if lengths[1] >= lengths[2] {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = (p + q) * 0.5;
    [[p, middle, r], [middle, q, r]]
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn heights_in_a_ball_contain_those_of_samples() {
        let mut rng = SplitMix64::new(6);
        let (mut inside, mut cut) = (0, 0);
        for round in 0..200_000 {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
            let (a, b, aside, weights, p) = (point(), point(), point(), point().abs(), point());
            let triangle = [a, b, a.midpoint(b) + 10_f64.powi(-(round % 12)) * aside];
            let Some(normal) = point().try_normalize() else { continue };
            let [x, y, z] = weights.to_array().map(|weight| weight / weights.element_sum());
            let sample = triangle[0] * x + triangle[1] * y + triangle[2] * z;
            let p = sample + 10_f64.powi(-(round % 4)) * p;
            let radius = sample.distance(p) * (1.0 + f64::from(round % 2));
            let [low, high] = heights_in_ball(&triangle, normal, p, radius);
            let height = normal.dot(sample);
            assert!(low <= height + 1e-12 && height <= high + 1e-12, "round {round}: {height} of {low} to {high}");
            let heights = triangle.map(|corner| normal.dot(corner));
            inside += 1;
            cut += i32::from(heights.iter().any(|height| *height < low - 1e-3 || *height > high + 1e-3));
        }
        assert!(cut > inside / 4, "{cut} of {inside}");
    }

    /// Triangles of all proportions. The truth is a point of the triangle, at a known height above
    /// it where the normal is certain.
    #[test]
    fn nearest_points_are_as_close_as_the_known_one() {
        let mut rng = SplitMix64::new(5);
        let (mut thin, mut needles, mut high) = (0, 0, 0);
        for round in 0..400_000 {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
            let (a, along, aside, weights) = (point(), point(), point(), point().abs());
            let width = 10_f64.powi(-(round % 12));
            let share = 2.0 * point().x;
            let triangle = [a, a + along, a + share * along + width * aside];
            let [a, b, c] = triangle;
            let foot = (a * weights.x + b * weights.y + c * weights.z) / weights.element_sum();
            let plane = Plane::new(&triangle);
            let height = if plane.is_wider(THIN) && round % 3 > 0 { 10_f64.powi(round / 12 % 8 - 3) } else { 0.0 };
            let p = foot + (b - a).cross(c - a).normalize_or_zero() * height;
            let found = nearest(&triangle, p);
            let excess = found.distance(p) - height;
            let rounding = 2e-14 * (1.0 + height) * if plane.is_wider(THIN) { 1.0 } else { 100.0 };
            assert!(excess <= needle(&triangle) + rounding, "round {round}: {excess:e} at {p}, {triangle:?}");
            // The normal may be off by 1e-13.
            assert!(-excess <= 1e-12 * (1.0 + height), "round {round}: closer than possible by {:e}", -excess);
            thin += usize::from(!plane.is_wider(THIN));
            needles += usize::from(!plane.is_wider(NEEDLE));
            high += usize::from(height > 0.0);
        }
        assert!(thin > 100_000 && needles > 50_000 && high > 50_000, "{thin} thin, {needles} needles, {high} high");
    }

    #[test]
    fn edges_that_are_left_out_are_farther() {
        let mut rng = SplitMix64::new(6);
        let mut outside = 0;
        for round in 0..200_000 {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
            let (a, along, aside, p) = (point(), point(), point(), point());
            let width = 10_f64.powi(-(round % 4));
            let share = 3.0 * point().x;
            let triangle = [a, a + along, a + share * along + width * aside];
            let p = a + p * 10_f64.powi(round / 4 % 8 - 3);
            let (fast, slow) = (nearest(&triangle, p), nearest_of_all(&triangle, p));
            let (distance, least) = (fast.distance(p), slow.distance(p));
            assert!((distance - least).abs() <= 1e-12 * (1.0 + least), "round {round}: {distance} instead of {least}");
            let plane = Plane::new(&triangle);
            outside += usize::from(plane.projection(p, plane.scaled(p - a), 1).is_none());
        }
        assert!(outside > 100_000, "{outside} points beside their triangles");
    }
}
