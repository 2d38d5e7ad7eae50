//! Hulls of few vertices around a hull, with unbounded protrusion: the fallback where
//! simplification fails or takes too long.
//!
//! | vertices allowed | hull |
//! |---|---|
//! | 8 or more | the box around it, whose sides are exact |
//! | 4 to 7 | a tetrahedron around the box |

use crate::{
    hull::{self, Hull},
    outer,
    simplify::{self, Limit, MIN_VERTICES},
};

/// Number of vertices above which a hull takes long to simplify.
const MANY: usize = 256;

/// Length of the tetrahedron's edges at the corner of the box, relative to the box: 3, and more
/// than rounding takes away.
const EDGE: f64 = 3.0 + 1e-5;

/// Distance by which that corner is moved outward, relative to the greatest coordinate.
const OUTWARD: f64 = 1e-6;

/// A hull around `hull` with at most `max_vertices` vertices, and at least 4: simplified if
/// possible.
pub fn within_vertices(hull: Hull, max_vertices: usize) -> Hull {
    if hull.vertices.len() <= max_vertices {
        return hull;
    }
    match simplify::simplify(&hull, Limit::Vertices(max_vertices.max(MIN_VERTICES))) {
        Ok(Some(simplified)) if simplified.hull.vertices.len() <= max_vertices => simplified.hull,
        _ => around(&hull, max_vertices).unwrap_or(hull),
    }
}

/// Faster: a hull of many vertices is replaced by its [`outer`](mod@crate::outer) hull.
pub fn quickly_within_vertices(hull: Hull, max_vertices: usize) -> Hull {
    let is_large = hull.vertices.len() > MANY && hull.vertices.len() > max_vertices;
    let coarse = is_large.then(|| outer::outer(&hull)).filter(|outer| !outer.is_empty()).and_then(hull::of_positions);
    within_vertices(coarse.unwrap_or(hull), max_vertices)
}

/// The box around a hull, or a tetrahedron around that; `None` if coordinates would be infinite.
fn around(hull: &Hull, max_vertices: usize) -> Option<Hull> {
    let [low, high] = hull::bounds(&hull.vertices);
    if max_vertices >= 8 {
        let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] } + 0.0);
        return hull::of_positions((0..8).map(corner).collect());
    }
    let greatest = low.iter().chain(&high).map(|x| f64::from(x.abs())).fold(f64::MIN_POSITIVE, f64::max);
    let start = low.map(|x| f64::from(x) - OUTWARD * greatest);
    let edge = |axis: usize| EDGE * (f64::from(high[axis]) - start[axis] + OUTWARD * greatest);
    let corner = |i: usize| [0, 1, 2].map(|axis| (start[axis] + if i == axis { edge(axis) } else { 0.0 }) as f32 + 0.0);
    let corners: Vec<[f32; 3]> = (0..4).map(corner).collect();
    corners.iter().flatten().all(|x| x.is_finite()).then(|| hull::of_positions(corners)).flatten()
}

#[cfg(test)]
mod tests {
    use shapes::families::Family;

    use super::*;
    use crate::{outer::holds, test_meshes::hull_of};

    fn points(family: Family, count: usize, map: impl Fn([f32; 3]) -> [f32; 3]) -> Hull {
        hull_of(family.points(count, 3).into_iter().map(map).collect())
    }

    #[test]
    fn hulls_around_contain_the_hull_and_have_few_vertices() {
        let far = |p: [f32; 3]| p.map(|x| x + 3e4);
        let thin = |p: [f32; 3]| [p[0], p[1] * 1e-3, p[2] * 1e-6];
        let vast = |p: [f32; 3]| p.map(|x| x * 1e30);
        for hull in [
            points(Family::Sphere, 600, |p| p),
            points(Family::Sphere, 40, far),
            points(Family::Sphere, 600, thin),
            points(Family::Sphere, 100, vast),
        ] {
            let positions = hull.positions();
            for max_vertices in [4, 5, 7, 8, 20, 24, 64] {
                for found in [
                    around(&hull, max_vertices).unwrap(),
                    within_vertices(hull.clone(), max_vertices),
                    quickly_within_vertices(hull.clone(), max_vertices),
                ] {
                    let count = found.vertices.len();
                    assert!(count <= max_vertices && found.rank == 3, "{count} of {max_vertices}");
                    assert!(holds(&found.vertices, &positions), "{max_vertices}: {:?}", found.vertices);
                }
            }
        }
    }

    /// Regression: rounding to f32 defeats simplification for coplanar points far from the origin.
    #[test]
    fn no_hull_keeps_too_many_vertices() {
        let ring = |i: usize, size: f64, far: f64| {
            let angle = std::f64::consts::TAU * i as f64 / 90.0;
            [far + size * libm::cos(angle), far + size * libm::sin(angle), far + size * 0.3 * libm::cos(angle)]
                .map(|x| x as f32)
        };
        let mut failed = 0;
        for (size, far) in [(1.0, 0.0), (1.0, 1e3), (1.0, 1e5), (1.0, 1e6), (1e-3, 1e3), (1e-30, 0.0)] {
            let hull = hull_of((0..90).map(|i| ring(i, size, far)).collect());
            for max_vertices in [4, 6, 8, 30] {
                let simplified = simplify::simplify(&hull, Limit::Vertices(max_vertices));
                failed += u32::from(simplified.is_err());
                let found = within_vertices(hull.clone(), max_vertices);
                assert!(found.vertices.len() <= max_vertices, "{} of {max_vertices}", found.vertices.len());
            }
        }
        assert!(failed > 0, "the sample is not representative");
    }
}
