//! Builds and certifies the convex hull, of rank 3, 2, 1 or 0, of a set of source points.
//!
//! 1. Merge points with equal positions, and find the dimension they span ([`rank`]).
//! 2. Find the extreme points and the faces between them: [`quickhull`] for rank 3, [`polygon`] for
//!    rank 2, the two ends for rank 1, the single point for rank 0.
//! 3. Measure how far any source point lies outside, independently of step 2 ([`certify`]).

pub mod adjacency;
pub mod area;
mod boundary;
pub mod certify;
pub mod polygon;
pub mod quads;
pub mod quickhull;
pub mod rank;

use glam::DVec3;

use crate::error::BakeError;
pub use boundary::Hull;
pub(crate) use boundary::{bounds, edges};
use hullmap_format::archive::NO_SOURCE_VERTEX;
use hullmap_geometry::{MAX_POINTS, PointSet};
use rank::Simplex;

/// The hull of points that are not source vertices; `None` if it cannot be built.
pub(crate) fn of_positions(positions: Vec<[f32; 3]>) -> Option<Hull> {
    let source_vertices = vec![NO_SOURCE_VERTEX; positions.len()];
    build(&PointSet { positions, source_vertices, ..PointSet::default() }).ok()
}

/// Builds and certifies the hull of `points`.
///
/// # Errors
/// No points, more than [`MAX_POINTS`] points, a position that is not finite, or
/// a hull that fails certification.
///
/// # Complexity
/// O(n log n) on all families tried.
pub fn build(points: &PointSet) -> Result<Hull, BakeError> {
    let distinct = distinct(points)?;
    let positions: Vec<DVec3> = distinct.iter().map(|(p, _)| DVec3::from_array(p.map(f64::from))).collect();
    let simplex = rank::spanning_simplex(&positions);
    let (rank, faces) = match simplex {
        Simplex::Point(p) => (0, vec![vec![p as u32]]),
        Simplex::Segment(ends) => (1, vec![segment_ends(&positions, ends)]),
        Simplex::Triangle(corners) => {
            let [a, b, c] = corners.map(|i| positions[i]);
            let front = polygon::hull_along_own_axis(&positions, (b - a).cross(c - a));
            let back = front[..1].iter().chain(front[1..].iter().rev()).copied().collect();
            (2, vec![front, back])
        }
        Simplex::Tetrahedron(corners) => (3, quickhull::hull(&positions, corners)),
    };
    const UNUSED: u32 = u32::MAX;
    let mut vertex_of = vec![UNUSED; distinct.len()];
    faces.iter().flatten().for_each(|p| vertex_of[*p as usize] = 0);
    // Points that are not source vertices share one index; order them by position.
    let used = (0..distinct.len() as u32).filter(|p| vertex_of[*p as usize] != UNUSED);
    let mut chosen: Vec<(u32, u32)> = used.map(|p| (distinct[p as usize].1, p)).collect();
    chosen.sort_unstable();
    for (vertex, (_, p)) in (0..).zip(&chosen) {
        vertex_of[*p as usize] = vertex;
    }
    let vertices = chosen.iter().map(|(_, p)| distinct[*p as usize].0).collect();
    drop(distinct);
    let source_vertices = chosen.into_iter().map(|(source, _)| source).collect();
    let mut faces = if rank < 2 { Vec::new() } else { faces };
    for face in &mut faces {
        face.iter_mut().for_each(|p| *p = vertex_of[*p as usize]);
        let least = face.iter().enumerate().min_by_key(|(_, v)| **v).map_or(0, |(at, _)| at);
        face.rotate_left(least);
    }
    drop(vertex_of);
    if rank == 3 {
        quickhull::sort(&mut faces);
    } else {
        faces.sort_unstable();
    }
    let mut hull = Hull { rank, vertices, source_vertices, faces, diameter: 0.0, containment_error: 0.0 };
    hull.diameter = crate::diameter::diameter(&hull.positions());
    hull.containment_error = certify::certify(&hull, &positions)?;
    Ok(hull)
}

/// Maximum distance of a point of `points` outside `hull`, relative to its diameter.
///
/// # Errors
/// The distance exceeds [`CONTAINMENT`](crate::CONTAINMENT), or `points` is not valid input for
/// [`build`].
pub fn containment_error(hull: &Hull, points: &PointSet) -> Result<f64, BakeError> {
    let positions: Vec<DVec3> = distinct(points)?.iter().map(|(p, _)| DVec3::from_array(p.map(f64::from))).collect();
    Ok(certify::certify(hull, &positions)?)
}

/// The two points that are farthest in either direction along the line of `ends`.
fn segment_ends(positions: &[DVec3], ends: [usize; 2]) -> Vec<u32> {
    let along = positions[ends[1]] - positions[ends[0]];
    let by_reach = |a: &u32, b: &u32| positions[*a as usize].dot(along).total_cmp(&positions[*b as usize].dot(along));
    let all = 0..positions.len() as u32;
    all.clone().min_by(by_reach).into_iter().chain(all.max_by(by_reach)).collect()
}

/// Distinct positions without negative zeros, ascending, each with its lowest source vertex.
fn distinct(points: &PointSet) -> Result<Vec<([f32; 3], u32)>, BakeError> {
    if points.positions.is_empty() {
        return Err(BakeError::Empty);
    }
    if points.positions.len() > MAX_POINTS {
        return Err(BakeError::TooManyPoints { found: points.positions.len() });
    }
    let mut all: Vec<([f32; 3], u32)> = Vec::with_capacity(points.positions.len());
    for (position, &source) in points.positions.iter().zip(&points.source_vertices) {
        if !position.iter().all(|c| c.is_finite()) {
            return Err(BakeError::NotFinite { source_vertex: source });
        }
        all.push((position.map(|c| c + 0.0), source));
    }
    let by_position =
        |a: &[f32; 3], b: &[f32; 3]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
    all.sort_unstable_by(|a, b| by_position(&a.0, &b.0).then(a.1.cmp(&b.1)));
    all.dedup_by(|b, a| a.0 == b.0);
    Ok(all)
}
