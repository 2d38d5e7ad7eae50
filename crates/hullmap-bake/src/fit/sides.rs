//! Tests whether a region cut by triangles of the mesh lies inside the solid, for instance where
//! shells overlap.
//!
//! # Steps
//! 1. Clip the triangles by the region, and cut each of these polygons by the planes of those that
//!    cross it.
//! 2. Take a point on either side of each piece, at half the distance of the nearest triangle of
//!    another plane.
//! 3. The region is inside if all these points are.
//!
//! # Why that is enough
//! The winding number is constant between the triangles. The region is convex, so each space
//! between triangles reaches a side of a piece. No triangle crosses a piece, so the space next to
//! one of its sides is connected, and contains the point of that side, since no triangle is closer.
//!
//! Triangles closer than the solid's tolerance count as one, as everywhere else.

use glam::DVec3;

use super::winding::ClosedSurface;
use hullmap_geometry::{
    bounds,
    planes::{self, HalfSpace},
    triangle::{self, Triangle},
};

/// Maximum number of polygons in a region. More are not tested.
const MAX_POLYGONS: usize = 12;

/// Maximum number of triangles near one that is tested.
const MAX_NEAR: usize = 256;

/// Maximum number of pieces into which a polygon is cut.
const MAX_PIECES: usize = 32;

/// Least distance of the nearest other triangle, relative to the solid's tolerance.
const CLEAR: f64 = 8.0;

/// A convex polygon of a triangle's plane.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// The corners, in order.
    pub corners: Vec<DVec3>,
    /// The plane of the triangle.
    pub plane: HalfSpace,
}

impl Polygon {
    /// A whole triangle; `None` without area, since it separates nothing.
    pub fn new(triangle: &Triangle) -> Option<Self> {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a).try_normalize()?;
        let plane = HalfSpace { normal, offset: normal.dot(triangle::centroid(triangle)) };
        Some(Self { corners: triangle.to_vec(), plane })
    }

    /// The part of the polygon inside all of `region`; `None` if there is none.
    pub fn clipped<'a>(&self, region: impl IntoIterator<Item = &'a HalfSpace>) -> Option<Self> {
        let mut corners = self.corners.clone();
        for plane in region {
            if corners.iter().all(|p| plane.height(*p) <= 0.0) {
                continue;
            }
            [corners, _] = planes::cut(&corners, plane, 0.0);
            if corners.is_empty() {
                return None;
            }
        }
        Some(Self { corners, plane: self.plane })
    }

    /// The corners of the box around the polygon.
    pub fn bounds(&self) -> [DVec3; 2] {
        bounds(self.corners.iter().copied())
    }

    /// Pieces of the polygon that none of `others` crosses. `None` if there are too many, or if the
    /// polygon is too thin for its plane to be known.
    fn pieces(&self, others: &[Polygon], margin: f64) -> Option<Vec<Vec<DVec3>>> {
        let plane = &self.plane;
        if !self.corners.iter().all(|p| plane.height(*p).abs() <= margin) {
            return None;
        }
        // A polygon that only touches an edge does not cross.
        let slab = [*plane, plane.opposite()].map(|side| side.moved(margin));
        let edges = planes::around(&self.corners, plane.normal).into_iter().map(|edge| edge.moved(-2.0 * margin));
        let inner: Vec<HalfSpace> = slab.into_iter().chain(edges).collect();
        let mut pieces = vec![self.corners.clone()];
        for other in others {
            let is_in_plane = other.corners.iter().all(|p| plane.height(*p).abs() <= margin);
            if is_in_plane || other.clipped(&inner).is_none() {
                continue;
            }
            pieces = pieces.iter().flat_map(|piece| planes::cut(piece, &other.plane, margin)).collect();
            pieces.retain(|piece| !piece.is_empty());
            if pieces.len() > MAX_PIECES {
                return None;
            }
        }
        Some(pieces)
    }
}

/// Whether a convex region is inside a surface, except closer than its tolerance to a triangle.
/// `polygons` are all triangles that touch the region, clipped by it. `false` may mean unknown,
/// unless there are no polygons: then any point of the region decides.
///
/// # Complexity
/// O(k³ log n) for k polygons and n triangles of the surface; k is bounded.
pub fn are_sides_inside(surface: &ClosedSurface, polygons: &[Polygon]) -> bool {
    let margin = surface.tolerance();
    if polygons.is_empty() || polygons.len() > MAX_POLYGONS {
        return false;
    }
    polygons.iter().all(|polygon| {
        let pieces = polygon.pieces(polygons, margin);
        pieces.is_some_and(|pieces| pieces.iter().all(|piece| sides(surface, piece, &polygon.plane) == [Some(true); 2]))
    })
}

/// Whether a triangle of the surface has the inside on one side. `false` may mean unknown.
///
/// # Complexity
/// O(k² log n) for k triangles near it and n triangles of the surface; k is bounded.
pub fn is_beside_inside(surface: &ClosedSurface, index: u32) -> bool {
    let triangle = &surface.triangles()[index as usize];
    let Some(polygon) = Polygon::new(triangle) else { return false };
    let [low, high] = polygon.bounds();
    let near = surface.triangles_in(low, high);
    if near.len() > MAX_NEAR {
        return false;
    }
    let others: Vec<Polygon> =
        near.iter().filter_map(|other| Polygon::new(&surface.triangles()[*other as usize])).collect();
    let pieces = polygon.pieces(&others, surface.tolerance());
    pieces.is_some_and(|pieces| pieces.iter().all(|piece| sides(surface, piece, &polygon.plane).contains(&Some(true))))
}

/// Whether each side of a piece is inside; `None` where that is not known.
fn sides(surface: &ClosedSurface, piece: &[DVec3], plane: &HalfSpace) -> [Option<bool>; 2] {
    let centre = piece.iter().sum::<DVec3>() / piece.len() as f64;
    let clear = surface.clearance(centre, plane);
    if !(clear > CLEAR * surface.tolerance()) {
        return [None; 2];
    }
    let step = plane.normal * (0.5 * clear);
    [centre + step, centre - step].map(|p| surface.winding_number(p).map(|winding| winding != 0))
}
