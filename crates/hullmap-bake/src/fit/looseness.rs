//! How loose the parts of a mesh are: how much they overlap, how far they protrude on average, and
//! how far they leave the mesh's convex hull.
//!
//! Overlap and mean protrusion are estimates from points of a fixed sequence, so that they are the
//! same everywhere. They promise nothing, unlike the bounds of [`fits`](super::fits()). The error
//! of the overlap is stated.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    Solid,
    region::Region,
    triangle_tree::{Bounds, TriangleTree},
};
use crate::{hull::Hull, mass::mass, simplify::nearest::Nearest, spread::spread};
use hullmap_geometry::{planes, triangle::Triangle};

/// How loose the parts of a mesh are. Lengths are in the unit of the positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Looseness {
    /// Sum of the parts' volumes less the volume of their union, relative to the latter.
    pub overlap: f64,
    /// Twice the maximum standard deviation of `overlap`, if the points are random. The points of
    /// the fixed sequence are spread more evenly.
    pub overlap_error: f64,
    /// Mean distance of the visible surface from the solid, accurate to about 2 %. A part's surface
    /// is invisible in another part, and at most 1e-4 of the diagonal behind one, as between parts.
    pub mean_protrusion: f64,
    /// The greatest distance of a part from the mesh's convex hull, exact except for rounding.
    pub outside_hull: f64,
}

/// Number of points by which volumes are compared, and of points on the surface.
const POINTS: usize = 20_000;

/// Distance in front of the surface at which another part hides it, relative to the diagonal. CoACD
/// leaves gaps of up to a fifth of this between its parts.
const HIDDEN: f64 = 1e-4;

/// Estimates how loose `parts` are around `solid`, whose convex hull is `hull`, in one frame.
///
/// # Complexity
/// 40,000 points, or 32 for each of more than 1,250 parts. Each is compared with the planes of the
/// parts near it; half of them need a distance from the solid.
pub fn looseness(solid: &Solid, hull: &Hull, parts: &[&Hull]) -> Looseness {
    looseness_of_parts(solid, hull, parts).0
}

/// As [`looseness`], and the mean protrusion of each part's own visible surface; `None` for a part
/// that is not a solid, or has no visible surface.
pub fn looseness_of_parts(solid: &Solid, hull: &Hull, parts: &[&Hull]) -> (Looseness, Vec<Option<f64>>) {
    let count = parts.len();
    let is_solid = |index: &usize| parts[*index].rank == 3;
    let indices: Vec<usize> = (0..count).filter(is_solid).collect();
    let parts = Parts::new(indices.iter().map(|index| parts[*index]));
    let area: f64 = parts.all.iter().map(|part| part.area).sum();
    let step = HIDDEN * solid.diagonal();
    let visible: Vec<[f64; 2]> =
        (0..parts.all.len()).into_par_iter().map(|index| visible(solid, &parts, index, area, step)).collect();
    let mean = |[protrusion, area]: [f64; 2]| (area > 0.0).then(|| protrusion / area);
    let mut means = vec![None; count];
    indices.iter().zip(&visible).for_each(|(index, visible)| means[*index] = mean(*visible));
    let all = visible.into_iter().fold([0.0; 2], |sum, share| [sum[0] + share[0], sum[1] + share[1]]);
    let nearest = Nearest::new(hull);
    let outside = |p: &DVec3| nearest.nearest_from(*p, 0).point.distance(*p);
    let points: Vec<DVec3> = parts.all.iter().flat_map(|part| part.points.iter().copied()).collect();
    let (overlap, overlap_error) = overlap_of(&parts);
    let found = Looseness {
        overlap,
        overlap_error,
        mean_protrusion: mean(all).unwrap_or(0.0),
        outside_hull: if hull.rank == 3 { points.par_iter().map(outside).reduce(|| 0.0, f64::max) } else { 0.0 },
    };
    (found, means)
}

/// [`Looseness::overlap`] of parts without their mesh, and its error, from half the points of
/// [`looseness`].
pub fn overlap(parts: &[&Hull]) -> (f64, f64) {
    overlap_of(&Parts::new(parts.iter().copied().filter(|part| part.rank == 3)))
}

fn overlap_of(parts: &Parts) -> (f64, f64) {
    let volume: f64 = parts.all.iter().map(|part| part.volume).sum();
    let shares: Vec<[f64; 2]> = (0..parts.all.len()).into_par_iter().map(|index| share(parts, index, volume)).collect();
    let [union, variance] = shares.into_iter().fold([0.0; 2], |sum, share| [sum[0] + share[0], sum[1] + share[1]]);
    // The overlap changes with the union by its derivative.
    if union > 0.0 {
        ((volume / union - 1.0).max(0.0), 2.0 * variance.sqrt() * volume / (union * union))
    } else {
        (0.0, 0.0)
    }
}

struct Parts {
    all: Vec<SampledPart>,
    tree: TriangleTree,
}

impl Parts {
    fn new<'a>(hulls: impl Iterator<Item = &'a Hull>) -> Self {
        let all: Vec<SampledPart> = hulls.map(SampledPart::new).collect();
        Self { tree: TriangleTree::of_boxes(all.iter().map(|part| Bounds::around(&part.points))), all }
    }

    /// Number of parts other than the one with this index that a point is in.
    fn others_around(&self, index: usize, p: DVec3) -> usize {
        let mut count = 0;
        let is_other = |part: u32| part as usize != index && self.all[part as usize].region.holds(p, 0.0);
        self.tree.for_each(|bounds| bounds.contains(p), |part| count += usize::from(is_other(part)));
        count
    }
}

struct SampledPart {
    points: Vec<DVec3>,
    region: Region,
    triangles: Vec<Triangle>,
    volume: f64,
    area: f64,
}

impl SampledPart {
    fn new(hull: &Hull) -> Self {
        let points = hull.positions();
        let corners = |face: &Vec<u32>| face.iter().map(|v| points[*v as usize]).collect::<Vec<_>>();
        let mass = mass(hull);
        Self {
            region: Region::new(hull),
            triangles: hull.faces.iter().flat_map(|face| planes::fan(&corners(face))).collect(),
            volume: mass.volume,
            area: mass.surface_area,
            points,
        }
    }
}

fn count(share: f64) -> usize {
    ((POINTS as f64 * share).ceil() as usize).max(16)
}

/// A part's contribution to the union's volume, and its variance for random points.
fn share(parts: &Parts, index: usize, volume: f64) -> [f64; 2] {
    let part = &parts.all[index];
    let origin = part.points[0];
    let triangle_volume = |[a, b, c]: &Triangle| (*a - origin).cross(*b - origin).dot(*c - origin).abs();
    let inside = Spread::new(&part.triangles, triangle_volume, count(part.volume / volume));
    let (mut shared, mut squares) = (0.0, 0.0);
    for ([a, b, c], [u, v, w]) in inside.points() {
        // Uniform in the tetrahedron of the triangle and the origin.
        let (r, s, t) = (libm::cbrt(w), v.sqrt(), u);
        let p = origin + ((a - origin) * (1.0 - s) + ((b - origin) * (1.0 - t) + (c - origin) * t) * s) * r;
        let share = 1.0 / (1 + parts.others_around(index, p)) as f64;
        (shared, squares) = (shared + share, squares + share * share);
    }
    let count = inside.count as f64;
    // As if one more point were half shared, which keeps the variance above 0.
    let variance = (squares - shared * shared / count).max(0.0) + 0.25;
    [shared * part.volume / count, variance * (part.volume / count).powi(2)]
}

/// A part's contributions to the visible area and to the integral of the distance over it. A point
/// is visible if no other part contains the point a `step` farther outward.
fn visible(solid: &Solid, parts: &Parts, index: usize, area: f64, step: f64) -> [f64; 2] {
    let part = &parts.all[index];
    let triangle_area = |[a, b, c]: &Triangle| (*b - *a).cross(*c - *a).length();
    let surface = Spread::new(&part.triangles, triangle_area, count(part.area / area));
    let (mut distance, mut visible) = (0.0, 0.0);
    for ([a, b, c], [u, v, _]) in surface.points() {
        let s = v.sqrt();
        let p = a * (1.0 - s) + (b * (1.0 - u) + c * u) * s;
        let outward = (b - a).cross(c - a).normalize_or_zero();
        if parts.others_around(index, p + outward * step) == 0 {
            distance += solid.distance(p);
            visible += 1.0;
        }
    }
    let of_point = part.area / surface.count as f64;
    [distance * of_point, visible * of_point]
}

struct Spread<'a> {
    triangles: &'a [Triangle],
    sums: Vec<f64>,
    count: usize,
}

impl<'a> Spread<'a> {
    fn new(triangles: &'a [Triangle], weight: impl Fn(&Triangle) -> f64, count: usize) -> Self {
        let sums = triangles.iter().scan(0.0, |sum, triangle| {
            *sum += weight(triangle);
            Some(*sum)
        });
        Self { triangles, sums: sums.collect(), count }
    }

    fn points(&self) -> impl Iterator<Item = (Triangle, [f64; 3])> {
        let total = self.sums.last().copied().unwrap_or(0.0);
        (0..self.count).filter_map(move |k| {
            let at = total * (k as f64 + 0.5) / self.count as f64;
            let triangle = self.triangles.get(self.sums.partition_point(|sum| *sum < at))?;
            Some((*triangle, spread(k)))
        })
    }
}

#[cfg(test)]
mod tests {
    use shapes::concave;

    use super::*;
    use crate::{
        hull,
        test_meshes::{box_hull, point_set},
    };

    #[test]
    fn boxes_have_known_overlap_and_protrusion() {
        let mesh = point_set(&concave::l());
        let (solid, whole) = (Solid::new(&mesh), hull::build(&mesh).unwrap());
        let [low, high] = solid.bounds().map(|p| p.as_vec3());
        let around = box_hull(low.to_array(), high.to_array());
        let twice = looseness(&solid, &whole, &[&around, &around]);
        assert!((twice.overlap - 1.0).abs() < 1e-9 && twice.overlap_error < 1e-3, "{twice:?}");
        let size = high - low;
        let half = box_hull(low.to_array(), [low.x + 0.5 * size.x, high.y, high.z]);
        let found = looseness(&solid, &whole, &[&around, &half]);
        assert!((found.overlap - 0.5).abs() <= found.overlap_error && found.overlap_error < 0.01, "{found:?}");
        let beside = box_hull([high.x + 1.0, low.y, low.z], [high.x + 2.0, high.y, high.z]);
        let found = looseness(&solid, &whole, &[&around, &beside]);
        // The hull's slanted side is in the plane 2 x + y = 5, the farthest corner at (4, 3).
        assert!(found.overlap == 0.0 && (found.outside_hull - 6.0 / 5.0_f64.sqrt()).abs() < 1e-6, "{found:?}");
        // The mean over the box beside the mesh alone, by a sum over a grid.
        let found = looseness(&solid, &whole, &[&beside]).mean_protrusion;
        let (mut sum, mut weight) = (0.0, 0.0);
        let steps = 60;
        for face in 0..6 {
            let (axis, side) = (face % 3, face / 3);
            let size = [1.0, f64::from(size.y), f64::from(size.z)];
            let area = size[(axis + 1) % 3] * size[(axis + 2) % 3];
            for i in 0..steps * steps {
                let mut at = [0.0; 3];
                at[axis] = side as f64;
                at[(axis + 1) % 3] = ((i % steps) as f64 + 0.5) / steps as f64;
                at[(axis + 2) % 3] = ((i / steps) as f64 + 0.5) / steps as f64;
                let p = DVec3::new(f64::from(high.x) + 1.0, f64::from(low.y), f64::from(low.z))
                    + DVec3::from_array(at) * DVec3::from_array(size);
                (sum, weight) = (sum + area * solid.distance(p), weight + area);
            }
        }
        assert!((found - sum / weight).abs() < 0.02 * found, "{found} {}", sum / weight);
    }

    #[test]
    fn faces_between_parts_are_not_visible() {
        let mesh = point_set(&concave::l());
        let (solid, whole) = (Solid::new(&mesh), hull::build(&mesh).unwrap());
        let [low, high] = solid.bounds().map(|p| p.as_vec3().to_array());
        let mean = |parts: &[&Hull]| looseness(&solid, &whole, parts).mean_protrusion;
        let undivided = mean(&[&box_hull(low, high)]);
        let middle = 0.5 * (low[0] + high[0]);
        for reach in [0.0, 0.1] {
            let left = box_hull(low, [middle + reach, high[1], high[2]]);
            let right = box_hull([middle - reach, low[1], low[2]], high);
            let divided = mean(&[&left, &right]);
            // The overlap in the planes of the box's sides counts twice.
            let error = if reach > 0.0 { 0.1 } else { 0.03 };
            assert!((divided - undivided).abs() < error * undivided, "{divided} {undivided}, reach {reach}");
        }
    }
}
