//! Certificate of a hull, computed only from its vertices, its faces and the source points,
//! independently of its construction.
//!
//! 1. Euler: V − E + F = 2, and every edge occurs once in each direction.
//! 2. Every face faces outward: the centroid of the vertices lies behind it.
//! 3. No source point lies farther than [`CONTAINMENT`] in front of any face, or from the polygon,
//!    segment or point.
//!
//! Testing every point against every face in step 3 would be too slow. The bounding box of a group
//! of points lies entirely behind most faces. The points are therefore halved recursively, and each
//! half keeps only the faces that its box is not behind.

use glam::DVec3;

use super::{Hull, area::area_vector, edges, polygon::side_normal};

/// Why a hull fails its certificate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CertificateError {
    /// A source point is too far outside the hull.
    #[error("a source point is {error:e} of the diameter outside of the hull (at most {CONTAINMENT:e} is allowed)")]
    Containment {
        /// Distance relative to the diameter; NaN if unknown.
        error: f64,
    },
    /// The faces do not form a closed, consistently oriented surface.
    #[error(
        "its faces are not a closed surface (V - E + F is {euler}; every edge must be in two faces, once in each direction)"
    )]
    Surface {
        /// V − E + F; 2 for a polyhedron.
        euler: i64,
    },
    /// A face is degenerate or faces inward.
    #[error("face {face} is degenerate or faces inward")]
    Inward {
        /// Index of the face.
        face: usize,
    },
}

/// Maximum distance of a source point from the hull, relative to the hull's diameter.
pub const CONTAINMENT: f64 = 1e-7;

/// A half-space that contains the hull: n·x ≤ offset. The normal n has unit length.
#[derive(Clone, Copy)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

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

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

fn euler(hull: &Hull) -> Result<(), CertificateError> {
    let mut directed: Vec<(u32, u32)> = hull.faces.iter().flat_map(|face| edges(face)).collect();
    directed.sort_unstable();
    let once = directed.windows(2).all(|w| w[0] != w[1]);
    let paired = directed.iter().all(|&(a, b)| directed.binary_search(&(b, a)).is_ok());
    let euler = hull.vertices.len() as i64 - directed.len() as i64 / 2 + hull.faces.len() as i64;
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

/// Maximum number of points in a group that is not halved further. Each of its points is tested
/// against each of its half-spaces.
const GROUP: usize = 32;

/// Maximum distance of a point outside any half-space; 0 if no point is outside.
fn worst_outside(points: &[DVec3], half_spaces: &[HalfSpace]) -> f64 {
    let mut points = points.to_vec();
    let mut worst = 0.0;
    descend(&mut points, half_spaces, &mut worst);
    worst
}

fn descend(points: &mut [DVec3], half_spaces: &[HalfSpace], worst: &mut f64) {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    // Written so that a half-space whose distance is NaN is kept.
    let near: Vec<HalfSpace> = half_spaces
        .iter()
        .filter(|h| !(h.normal.dot(centre) + h.normal.abs().dot(half) - h.offset <= *worst))
        .copied()
        .collect();
    if near.is_empty() {
        return;
    }
    if points.len() <= GROUP {
        for h in &near {
            for p in points.iter() {
                let outside = h.normal.dot(*p) - h.offset;
                if !(outside <= *worst) {
                    *worst = outside;
                }
            }
        }
        return;
    }
    let axis = if half.x >= half.y && half.x >= half.z {
        0
    } else if half.y >= half.z {
        1
    } else {
        2
    };
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    let (left, right) = points.split_at_mut(middle);
    descend(left, &near, worst);
    descend(right, &near, worst);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PointSet, hull::build};

    fn cube() -> (Hull, Vec<DVec3>) {
        let corners: Vec<[f32; 3]> = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
        let set = PointSet {
            name: String::new(),
            source_vertices: (0..8).collect(),
            positions: corners,
            ..PointSet::default()
        };
        let hull = build(&set).unwrap();
        let points = hull.positions();
        (hull, points)
    }

    #[test]
    fn a_cube_is_certified_exactly() {
        let (hull, points) = cube();
        assert_eq!(certify(&hull, &points).unwrap(), 0.0);
    }

    #[test]
    fn a_point_outside_the_hull_is_found() {
        let (hull, mut points) = cube();
        points.push(DVec3::new(0.5, 0.5, 1.0 + 1e-6));
        let error = certify(&hull, &points).unwrap_err();
        assert!(matches!(error, CertificateError::Containment { error } if error > 5e-7), "{error}");
    }

    #[test]
    fn a_reversed_or_missing_face_is_found() {
        let (mut hull, points) = cube();
        hull.faces[2].reverse();
        assert!(matches!(certify(&hull, &points), Err(CertificateError::Surface { .. })));
        let (mut hull, points) = cube();
        hull.faces.pop();
        assert!(matches!(certify(&hull, &points), Err(CertificateError::Surface { euler: 3 })));
        let (mut hull, points) = cube();
        hull.faces.iter_mut().for_each(|f| f.reverse());
        assert_eq!(certify(&hull, &points), Err(CertificateError::Inward { face: 0 }));
    }

    /// The slow, obvious twin of `descend`.
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
