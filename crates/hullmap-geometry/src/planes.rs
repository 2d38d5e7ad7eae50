//! Half-spaces, the planes of faces, and polygons clipped by them.

use glam::DVec3;

/// A half-space: the points p with `normal · p ≤ offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Unit normal, pointing out of the half-space.
    pub normal: DVec3,
    /// Offset along the normal.
    pub offset: f64,
}

impl HalfSpace {
    /// Signed distance of a point from the plane, positive outside.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// The half-space on the other side of the plane.
    pub fn opposite(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// The half-space grown by a distance.
    pub fn moved(self, distance: f64) -> Self {
        Self { offset: self.offset + distance, ..self }
    }
}

/// Sine of the angle between a face's edges below which its normal is not trusted. At this angle
/// the normal is off by about 1e-10.
const SLIVER: f64 = 1e-6;

/// The half-space of a face of the hull of `points`, and the face's area; `None` if it has no area.
/// The half-space contains the corners.
pub fn of_face(corners: &[DVec3], points: &[DVec3]) -> Option<(HalfSpace, f64)> {
    let first = *corners.first()?;
    let (mut area, mut products) = (DVec3::ZERO, 0.0);
    for edge in corners.windows(2) {
        let [a, b] = [edge[0] - first, edge[1] - first];
        area += a.cross(b);
        products += a.length() * b.length();
    }
    let normal = area.try_normalize()?;
    // The normal of a sliver is rounding error, but any plane that touches the hull is valid.
    let touched = if area.length() < SLIVER * products { points } else { corners };
    let offset = touched.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
    Some((HalfSpace { normal, offset }, 0.5 * area.length()))
}

/// One half-space per edge of a convex polygon with the given normal, at right angles to it, each
/// containing the whole edge. Edges without length are left out.
pub fn around(polygon: &[DVec3], normal: DVec3) -> Vec<HalfSpace> {
    let edge = |(index, &from): (usize, &DVec3)| {
        let to = polygon[(index + 1) % polygon.len()];
        let outward = (to - from).cross(normal).try_normalize()?;
        Some(HalfSpace { normal: outward, offset: outward.dot(from).max(outward.dot(to)) })
    };
    polygon.iter().enumerate().filter_map(edge).collect()
}

/// Appends the part of a convex polygon whose height is at least 0; NaN counts as below. `at` is
/// the point at a share of the way between two corners.
pub fn clip<P: Copy>(polygon: &[P], height: impl Fn(P) -> f64, at: impl Fn(P, P, f64) -> P, out: &mut Vec<P>) {
    let Some(&last) = polygon.last() else { return };
    let (mut p, mut p_height) = (last, height(last));
    for &q in polygon {
        let q_height = height(q);
        if (p_height >= 0.0) != (q_height >= 0.0) {
            out.push(at(p, q, p_height / (p_height - q_height)));
        }
        if q_height >= 0.0 {
            out.push(q);
        }
        (p, p_height) = (q, q_height);
    }
}

/// The point at a share of the way between two points of a plane.
pub fn between(p: [f64; 2], q: [f64; 2], share: f64) -> [f64; 2] {
    [p[0] + (q[0] - p[0]) * share, p[1] + (q[1] - p[1]) * share]
}

/// The parts of a convex polygon inside and outside of a plane; either may be empty. Corners within
/// `tolerance` count as on the plane.
pub fn cut(polygon: &[DVec3], plane: &HalfSpace, tolerance: f64) -> [Vec<DVec3>; 2] {
    let heights: Vec<f64> = polygon.iter().map(|p| plane.height(*p)).collect();
    if heights.iter().all(|height| *height <= tolerance) {
        return [polygon.to_vec(), Vec::new()];
    }
    if heights.iter().all(|height| *height >= -tolerance) {
        return [Vec::new(), polygon.to_vec()];
    }
    let mut sides = [Vec::with_capacity(polygon.len() + 1), Vec::with_capacity(polygon.len() + 1)];
    for (index, (&p, &height)) in polygon.iter().zip(&heights).enumerate() {
        let next = (index + 1) % polygon.len();
        if height <= tolerance {
            sides[0].push(p);
        }
        if height >= -tolerance {
            sides[1].push(p);
        }
        let (low, high) = (height.min(heights[next]), height.max(heights[next]));
        if low < -tolerance && high > tolerance {
            // From below, so that polygons on both sides of an edge are cut at one point.
            let (a, b) = if height < 0.0 { (index, next) } else { (next, index) };
            let crossing = polygon[a] + (polygon[b] - polygon[a]) * (heights[a] / (heights[a] - heights[b]));
            sides[0].push(crossing);
            sides[1].push(crossing);
        }
    }
    sides
}

/// The part of a convex polygon inside all `planes`, which may be empty, and convex polygons that
/// cover the rest.
pub fn divide(polygon: &[DVec3], planes: &[HalfSpace], tolerance: f64) -> (Vec<DVec3>, Vec<Vec<DVec3>>) {
    let mut inside = polygon.to_vec();
    let mut outside = Vec::new();
    for plane in planes {
        // Most planes of a part do not cut a small polygon.
        if inside.iter().all(|p| plane.height(*p) <= tolerance) {
            continue;
        }
        let [within, beyond] = cut(&inside, plane, tolerance);
        if within.is_empty() {
            return (within, vec![polygon.to_vec()]);
        }
        outside.push(beyond);
        inside = within;
    }
    (inside, outside)
}

/// Triangles that cover a convex polygon; fewer than three corners give a degenerate triangle.
pub fn fan(polygon: &[DVec3]) -> Vec<[DVec3; 3]> {
    match *polygon {
        [] => Vec::new(),
        [a] => vec![[a; 3]],
        [a, b] => vec![[a, b, b]],
        [a, ref rest @ ..] => rest.windows(2).map(|edge| [a, edge[0], edge[1]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec3> {
        [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec()
    }

    fn area(polygon: &[DVec3]) -> f64 {
        fan(polygon).iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() / 2.0).sum()
    }

    fn prism(low: f64, high: f64) -> Vec<HalfSpace> {
        [DVec3::X, DVec3::Y]
            .into_iter()
            .flat_map(|axis| [HalfSpace { normal: axis, offset: high }, HalfSpace { normal: -axis, offset: -low }])
            .collect()
    }

    #[test]
    fn pieces_cover_the_polygon() {
        let (inside, outside) = divide(&square(), &prism(1.0, 2.0), 0.0);
        assert_eq!((area(&inside), outside.len()), (1.0, 4));
        assert_eq!(outside.iter().map(|piece| area(piece)).sum::<f64>(), 15.0);
        // A polygon outside stays whole, and touching within the tolerance is inside.
        assert_eq!(divide(&square(), &prism(5.0, 6.0), 0.0), (vec![], vec![square()]));
        assert_eq!(divide(&square(), &prism(1e-9, 4.0 - 1e-9), 1e-8), (square(), vec![]));
    }
}
