//! Certificate of a hull, from its vertices, faces and source points alone.
//!
//! 1. Euler: V − E + F = 2, and every edge occurs once in each direction.
//! 2. Every face faces outward: the centroid of the vertices lies behind it.
//! 3. No source point lies farther than [`CONTAINMENT`] in front of any face, or from the polygon,
//!    segment or point.
//!
//! Step 3 halves the points recursively, and each half keeps only the faces that it may not be
//! behind. A box around the group shows that, or a slice along the surface: the boxes of small
//! groups stick out of a curved surface, and with boxes alone the work grows as n^1.5.

use glam::DVec3;

use super::{Hull, area::area_vector, edges, polygon::side_normal};
use crate::error::{CONTAINMENT, CertificateError};
use hullmap_geometry::{bounds, planes::HalfSpace};

/// Checks `hull` against `points` and returns its containment error, relative to its diameter.
///
/// # Errors
/// The first check that fails.
pub fn certify(hull: &Hull, points: &[DVec3]) -> Result<f64, CertificateError> {
    let vertices = hull.positions();
    let worst = match hull.rank {
        0 => points.iter().map(|p| p.distance(vertices[0])).fold(0.0, f64::max),
        1 => points.iter().map(|p| distance_to_segment(*p, vertices[0], vertices[1])).fold(0.0, f64::max),
        _ => {
            euler(hull)?;
            let mut half_spaces = face_planes(hull, &vertices);
            outward(hull, &vertices, &half_spaces)?;
            if hull.rank == 2 {
                half_spaces.extend(side_planes(hull, &vertices, half_spaces[0].normal));
            }
            worst_outside(points, &half_spaces)
        }
    };
    let error = if worst == 0.0 { 0.0 } else { worst / hull.diameter };
    // Written so that NaN fails.
    if error <= CONTAINMENT { Ok(error) } else { Err(CertificateError::Containment { error }) }
}

/// Distance of a point from a segment, which has a length.
pub fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

fn euler(hull: &Hull) -> Result<(), CertificateError> {
    // Each edge with its smaller vertex first, then the larger one, then whether it was turned. The
    // two directions of an edge follow each other once they are sorted.
    let ordered = |(a, b): (u32, u32)| (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), a > b);
    let mut sides: Vec<(u64, bool)> = Vec::with_capacity(hull.faces.iter().map(Vec::len).sum());
    sides.extend(hull.faces.iter().flat_map(|face| edges(face)).map(ordered));
    sides.sort_unstable();
    let (pairs, rest) = sides.as_chunks::<2>();
    let paired = rest.is_empty() && pairs.iter().all(|[one, other]| one.0 == other.0 && !one.1 && other.1);
    let once = pairs.windows(2).all(|pair| pair[0][0].0 != pair[1][0].0);
    let euler = hull.vertices.len() as i64 - sides.len() as i64 / 2 + hull.faces.len() as i64;
    if once && paired && euler == 2 { Ok(()) } else { Err(CertificateError::Surface { euler }) }
}

/// The supporting plane of each face, accurate to rounding error.
fn face_planes(hull: &Hull, vertices: &[DVec3]) -> Vec<HalfSpace> {
    hull.faces
        .iter()
        .map(|face| {
            let normal = area_vector(face, vertices).normalize_or_zero();
            // Take the farthest corner, so that rounding error in the normal never puts a corner
            // outside its own face.
            let offset = face.iter().map(|v| normal.dot(vertices[*v as usize])).fold(f64::NEG_INFINITY, f64::max);
            HalfSpace { normal, offset }
        })
        .collect()
}

fn outward(hull: &Hull, vertices: &[DVec3], planes: &[HalfSpace]) -> Result<(), CertificateError> {
    let centroid = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    for (face, plane) in planes.iter().enumerate() {
        let behind = plane.offset - plane.normal.dot(centroid);
        let slack = CONTAINMENT * hull.diameter;
        if !(plane.normal.is_finite() && plane.normal != DVec3::ZERO && behind >= -slack) {
            return Err(CertificateError::Inward { face });
        }
    }
    Ok(())
}

/// Planes through the edges of a polygon, at right angles to it except for rounding error.
fn side_planes(hull: &Hull, vertices: &[DVec3], normal: DVec3) -> Vec<HalfSpace> {
    edges(&hull.faces[0])
        .map(|(a, b)| {
            let (a, b) = (vertices[a as usize], vertices[b as usize]);
            let out = side_normal(b - a, normal);
            HalfSpace { normal: out, offset: out.dot(a).max(out.dot(b)) }
        })
        .collect()
}

/// Maximum number of points in a group that is not halved further.
const GROUP: usize = 32;

/// Maximum number of points of a group with slices. On more of the surface, boxes are as good.
const WITH_SLICES: usize = 1 << 14;

/// Half-spaces are dropped on every level whose number is a multiple of this.
const EVERY: usize = 2;

/// How far a group must be behind a half-space to drop it, relative to the largest coordinate: a
/// hundred times the rounding error, so that each computed distance is negative.
const BEHIND: f64 = 1e-13;

/// Maximum distance of a point outside any half-space; 0 if no point is outside.
fn worst_outside(points: &[DVec3], half_spaces: &[HalfSpace]) -> f64 {
    search(points, half_spaces).worst
}

fn keep(half_spaces: &mut [HalfSpace], is_kept: impl Fn(&HalfSpace) -> bool) -> &mut [HalfSpace] {
    let mut count = 0;
    for at in 0..half_spaces.len() {
        // Branch-free: this branch would mispredict. A dropped half-space changes places with an
        // earlier one.
        let is_kept = is_kept(&half_spaces[at]);
        half_spaces.swap(count, at);
        count += usize::from(is_kept);
    }
    &mut half_spaces[..count]
}

fn search(points: &[DVec3], half_spaces: &[HalfSpace]) -> OutsideSearch {
    let scale = points.iter().fold(0.0, |scale: f64, p| scale.max(p.abs().max_element()));
    let scale = half_spaces.iter().fold(scale, |scale: f64, h| scale.max(h.offset.abs()));
    let mut search = OutsideSearch { worst: 0.0, margin: BEHIND * scale, path: Vec::new(), work: 0 };
    search.descend(&mut points.to_vec(), &mut half_spaces.to_vec());
    search
}

struct OutsideSearch {
    worst: f64,
    margin: f64,
    /// The boxes around the current group, each with the worst distance when it was entered.
    path: Vec<(Box3, f64)>,
    work: usize,
}

#[derive(Clone, Copy)]
struct Box3 {
    centre: DVec3,
    half: DVec3,
}

impl Box3 {
    fn new(points: &[DVec3]) -> Self {
        let [low, high] = bounds(points.iter().copied());
        Self { centre: (low + high) * 0.5, half: (high - low) * 0.5 }
    }

    fn outside(&self, h: &HalfSpace) -> f64 {
        h.normal.dot(self.centre) + h.normal.abs().dot(self.half) - h.offset
    }
}

/// A round slice that contains a group of points: everything below a plane, and within a radius of
/// an axis at right angles to it.
struct Slice {
    /// Where the axis meets the plane.
    top: DVec3,
    axis: DVec3,
    radius: f64,
}

impl Slice {
    fn new(points: &[DVec3], centre: DVec3, normals: DVec3) -> Self {
        // Zero if there are none: then the slice is behind nothing.
        let axis = normals.normalize_or_zero();
        let height = points.iter().map(|p| axis.dot(*p - centre)).fold(f64::NEG_INFINITY, f64::max);
        let radius = points.iter().map(|p| axis.cross(*p - centre).length_squared()).fold(0.0, f64::max).sqrt();
        Self { top: centre + axis * height, axis, radius }
    }

    fn is_behind(&self, h: &HalfSpace, margin: f64) -> bool {
        let along = h.normal.dot(self.axis);
        let behind = h.offset - h.normal.dot(self.top) - margin;
        // The slice turns by the angle between the axis and the normal. Written so that NaN fails.
        (along > 0.0)
            & (behind > 0.0)
            & (h.normal.cross(self.axis).length_squared() * self.radius * self.radius < behind * behind)
    }
}

impl OutsideSearch {
    fn descend(&mut self, points: &mut [DVec3], half_spaces: &mut [HalfSpace]) {
        let around = Box3::new(points);
        self.path.push((around, self.worst));
        let is_leaf = points.len() <= GROUP;
        let near = if is_leaf || self.path.len().is_multiple_of(EVERY) {
            self.keep_near(points, &around, half_spaces)
        } else {
            half_spaces
        };
        if near.is_empty() {
        } else if is_leaf {
            self.compare(points, near);
        } else {
            let axis = around.half.max_position();
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
            let (left, right) = points.split_at_mut(middle);
            self.descend(left, near);
            self.descend(right, near);
        }
        self.path.pop();
    }

    fn keep_near<'h>(
        &mut self,
        points: &[DVec3],
        around: &Box3,
        half_spaces: &'h mut [HalfSpace],
    ) -> &'h mut [HalfSpace] {
        let margin = self.margin;
        self.work += half_spaces.len();
        let near = keep(half_spaces, |h| !(around.outside(h) < -margin));
        let Some(first) = near.first().filter(|_| points.len() <= WITH_SLICES) else { return near };
        // Two slices, because a group of a thin body has points on both sides.
        let is_front = |h: &HalfSpace| h.normal.dot(first.normal) >= 0.0;
        let mut sums = [DVec3::ZERO; 2];
        for h in near.iter() {
            sums[usize::from(is_front(h))] += h.normal;
        }
        let slices = sums.map(|normals| Slice::new(points, around.centre, normals));
        self.work += near.len();
        keep(near, |h| !(slices[0].is_behind(h, margin) | slices[1].is_behind(h, margin)))
    }

    fn compare(&mut self, points: &[DVec3], near: &[HalfSpace]) {
        self.work += points.len() * near.len();
        for h in near {
            let mut outside = f64::NEG_INFINITY;
            for p in points {
                outside = outside.max(h.normal.dot(*p) - h.offset);
            }
            // The boxes decide which of the distances within rounding error count: packs record
            // the worst one.
            if outside > self.worst && self.path.iter().all(|(around, worst)| !(around.outside(h) <= *worst)) {
                self.worst = outside;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{box_hull, hull_of};
    use shapes::families::Family;

    #[test]
    fn a_cube_is_certified_exactly_and_each_defect_is_found() {
        let of = |change: fn(&mut Hull, &mut Vec<DVec3>)| {
            let mut hull = box_hull([0.0; 3], [1.0; 3]);
            let mut points = hull.positions();
            change(&mut hull, &mut points);
            certify(&hull, &points)
        };
        assert_eq!(of(|_, _| ()), Ok(0.0));
        let outside = of(|_, points| points.push(DVec3::new(0.5, 0.5, 1.0 + 1e-6)));
        assert!(matches!(outside, Err(CertificateError::Containment { error }) if error > 5e-7), "{outside:?}");
        let reversed = of(|hull, _| hull.faces[2].reverse());
        assert!(matches!(reversed, Err(CertificateError::Surface { .. })), "{reversed:?}");
        let missing = of(|hull, _| _ = hull.faces.pop());
        assert!(matches!(missing, Err(CertificateError::Surface { euler: 3 })), "{missing:?}");
        let inward = of(|hull, _| hull.faces.iter_mut().for_each(|f| f.reverse()));
        assert_eq!(inward, Err(CertificateError::Inward { face: 0 }));
    }

    fn planes(family: Family, n: usize) -> (Vec<DVec3>, Vec<HalfSpace>) {
        let hull = hull_of(family.points(n, 5));
        let points = hull.positions();
        let half_spaces = face_planes(&hull, &points);
        (points, half_spaces)
    }

    /// The slow twin, with boxes alone. It skips distances within rounding error whose boxes are
    /// behind within rounding error.
    fn boxes_only(points: &mut [DVec3], half_spaces: &[HalfSpace], worst: &mut f64) {
        let around = Box3::new(points);
        let near: Vec<HalfSpace> = half_spaces.iter().filter(|h| !(around.outside(h) <= *worst)).copied().collect();
        if near.is_empty() {
            return;
        }
        if points.len() <= GROUP {
            let outside = |h: &HalfSpace| points.iter().map(|p| h.normal.dot(*p) - h.offset).fold(0.0, f64::max);
            *worst = near.iter().map(outside).fold(*worst, f64::max);
            return;
        }
        let axis = around.half.max_position();
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        let (left, right) = points.split_at_mut(middle);
        boxes_only(left, &near, worst);
        boxes_only(right, &near, worst);
    }

    #[test]
    fn slices_change_no_bit() {
        let mut positive = 0;
        for family in Family::ALL {
            for (n, shrink) in [(300, 1.0), (3000, 1.0), (3000, 1.0 - 1e-9), (3000, 0.999)] {
                let (points, mut half_spaces) = planes(family, n);
                half_spaces.iter_mut().for_each(|h| h.offset *= shrink);
                let mut slow = 0.0;
                boxes_only(&mut points.clone(), &half_spaces, &mut slow);
                assert_eq!(worst_outside(&points, &half_spaces).to_bits(), slow.to_bits(), "{family:?} {n} {shrink}");
                positive += usize::from(slow > 0.0);
            }
        }
        assert!(positive > 20, "{positive}");
    }

    #[test]
    fn the_work_is_not_quadratic() {
        for family in [Family::Sphere, Family::Rock, Family::UvSphere, Family::Lens] {
            let [small, large] = [4_000, 32_000].map(|n| {
                let (points, half_spaces) = planes(family, n);
                search(&points, &half_spaces).work
            });
            let exponent = (large as f64 / small as f64).log(8.0);
            println!("{family:?}: {small} and {large} comparisons, exponent {exponent:.2}");
            assert!(exponent < 1.25, "{family:?}: {exponent}");
        }
    }

    #[test]
    fn grouping_changes_nothing() {
        let points: Vec<DVec3> =
            shapes::families::ball(3000, 5).iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let planes: Vec<HalfSpace> = shapes::families::sphere(200, 9)
            .iter()
            .map(|n| HalfSpace { normal: DVec3::from_array(n.map(f64::from)).normalize(), offset: 0.7 })
            .collect();
        let slow = planes.iter().flat_map(|h| points.iter().map(|p| h.normal.dot(*p) - h.offset)).fold(0.0, f64::max);
        assert_eq!(worst_outside(&points, &planes), slow);
        assert!(slow > 0.1);
    }
}
