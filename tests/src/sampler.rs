//! A sampler that tries to refute the claims about the parts of a mesh.
//!
//! It measures by other code than the bounds: winding numbers are sums of solid angles, distances
//! are brute force over all triangles, and points are compared with all planes of a part. Only the
//! inside of a mesh that is not watertight comes from [`Solid`], since it is a convention.

use glam::DVec3;
use hullmap_bake::{
    PointSet, SolidKind,
    fit::{Fit, Solid},
    hull::Hull,
};
use hullmap_testkit::triangles::{distance_from_triangle, winding};
use rayon::prelude::*;
use shapes::rng::SplitMix64;

/// Number of points that one thread samples at a time.
const CHUNK: usize = 512;

/// Rounding error of a height above a plane, relative to the diagonal.
const HEIGHT_ERROR: f64 = 1e-9;

/// Rounding error of a distance from a triangle, relative to the diagonal: needles lose digits.
const DISTANCE_ERROR: f64 = 2e-6;

/// The claim that a point among `samples` refutes: half of them on the mesh's surface, half on the
/// surfaces of the parts. `None` if no point refutes a claim. Complexity: for each point, all
/// planes of all parts, or all triangles twice.
pub fn refutation(mesh: &PointSet, hulls: &[Hull], fits: &[Fit], samples: usize, seed: u64) -> Option<String> {
    let triangles = triangles(mesh);
    let solid = Solid::new(mesh);
    let diagonal = solid.diagonal();
    let is_watertight = fits[0].solid == SolidKind::Watertight;
    let is_inside = |p: DVec3| if is_watertight { is_inside(&triangles, p) } else { solid.is_inside(p) };
    // The closing triangles are near the solid as well, if anything is inside them.
    let surface = if is_watertight { &triangles } else { solid.triangles() };
    let planes: Vec<Vec<(DVec3, f64)>> = hulls.iter().map(planes).collect();
    let claimed = fits[0].uncovered;
    let uncovered = |at: usize, rng: &mut SplitMix64| {
        let p = in_triangle(&triangles[at % triangles.len()], rng);
        let height =
            |planes: &Vec<(DVec3, f64)>| planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max);
        // The height above a part's planes is at most its distance.
        let least = planes.iter().map(height).fold(f64::INFINITY, f64::min);
        (least > claimed + HEIGHT_ERROR * diagonal)
            .then(|| format!("{p} is {least:.2e} outside all parts, claimed {claimed:.2e}"))
    };
    let protruding = |at: usize, rng: &mut SplitMix64| {
        let part = at % hulls.len();
        let p = on_hull(&hulls[part], rng);
        let claimed = fits[part].protrusion;
        let is_near =
            surface.iter().any(|triangle| distance_from_triangle(*triangle, p) <= claimed + DISTANCE_ERROR * diagonal);
        (!is_near && !is_inside(p)).then(|| format!("part {part} protrudes farther at {p}, claimed {claimed:.6e}"))
    };
    (0..(samples / 2).div_ceil(CHUNK)).into_par_iter().find_map_first(|chunk| {
        let mut rng = SplitMix64::new(seed.wrapping_add(chunk as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let points = chunk * CHUNK..((chunk + 1) * CHUNK).min(samples / 2);
        points.into_iter().find_map(|at| uncovered(at, &mut rng).or_else(|| protruding(at, &mut rng)))
    })
}

fn triangles(mesh: &PointSet) -> Vec<[DVec3; 3]> {
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    mesh.triangles.iter().map(|t| t.map(at)).collect()
}

/// Outward unit normals and offsets of a part's faces.
fn planes(hull: &Hull) -> Vec<(DVec3, f64)> {
    let positions = hull.positions();
    let plane = |face: &Vec<u32>| {
        let corner = |i: usize| positions[face[i] as usize];
        let areas = (1..face.len() - 1).map(|i| (corner(i) - corner(0)).cross(corner(i + 1) - corner(0)));
        let normal = areas.sum::<DVec3>().try_normalize()?;
        Some((normal, positions.iter().map(|p| p.dot(normal)).fold(f64::NEG_INFINITY, f64::max)))
    };
    hull.faces.iter().filter_map(plane).collect()
}

fn in_triangle(&[a, b, c]: &[DVec3; 3], rng: &mut SplitMix64) -> DVec3 {
    let (mut u, mut v) = (rng.unit(), rng.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + u * (b - a) + v * (c - a)
}

/// A point on a face of a part.
fn on_hull(hull: &Hull, rng: &mut SplitMix64) -> DVec3 {
    let positions = hull.positions();
    if hull.faces.is_empty() {
        return positions[0];
    }
    let face = &hull.faces[rng.below(hull.faces.len())];
    let second = 1 + rng.below(face.len() - 2);
    in_triangle(&[face[0], face[second], face[second + 1]].map(|v| positions[v as usize]), rng)
}

/// Whether a point is inside by a quarter of a winding, or a ray meets an odd number of triangles:
/// generous, so that no claim is called false where a triangle faces the other way than its
/// surface.
fn is_inside(triangles: &[[DVec3; 3]], p: DVec3) -> bool {
    let ray = DVec3::new(0.36, 0.48, 0.8);
    let is_crossed = |corners: &&[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - p);
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(ray) > 0.0);
        let is_ahead = a.dot(b.cross(c)) * (b - a).cross(c - a).dot(ray) > 0.0;
        is_ahead && sides[0] == sides[1] && sides[1] == sides[2]
    };
    winding(triangles, p).abs() > 0.25 || triangles.iter().filter(is_crossed).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use hullmap_bake::{fit::fits, hull};
    use hullmap_testkit::packs::point_set;
    use shapes::concave;

    use super::*;

    /// Correct claims pass; each of them overstated by a tenth fails.
    #[test]
    fn overstated_claims_are_refuted() {
        let mesh = concave::l();
        let set = PointSet { triangles: mesh.fans(), ..point_set("l", &mesh.vertices) };
        // The hull of the whole protrudes. One arm alone leaves the other uncovered.
        let whole = hull::build(&set).unwrap();
        let arm: Vec<[f32; 3]> = mesh.vertices.iter().copied().filter(|corner| corner[0] <= 1.0).collect();
        let arm = hull::build(&point_set("arm", &arm)).unwrap();
        for hull in [whole, arm] {
            let mut fits = fits(&set, &[&hull], None).unwrap();
            let hulls = [hull];
            assert_eq!(refutation(&set, &hulls, &fits, 20_000, 1), None);
            for at in 0..set.triangles.len() {
                let mut turned = set.clone();
                turned.triangles[at].swap(0, 1);
                assert_eq!(refutation(&turned, &hulls, &fits, 5_000, 1), None, "triangle {at}");
            }
            assert!(fits[0].uncovered > 0.5 || fits[0].protrusion > 0.5, "{fits:?}");
            fits[0].uncovered *= 0.9;
            fits[0].protrusion *= 0.9;
            assert!(refutation(&set, &hulls, &fits, 20_000, 1).is_some());
        }
    }
}
