//! One-sided sheets: triangles that collide on their fronts alone.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::bvh::Nodes;
use super::parts::{Parts, Tree};
use crate::hull::Hull;
use crate::shapes::triangle::VisitTriangle;

/// A triangle mesh, or another sheet, whose triangles collide on their fronts alone. A cheap copy:
/// it borrows the mesh. Hulls and shapes are not affected.
///
/// Which side is the front follows from the order of the corners: from there, they are
/// counter-clockwise. Physics engines call this back-face culling.
///
/// # What a body behind the front gets
/// A body is behind a triangle if its [interior point](crate::SupportMap::interior_point) is behind
/// the triangle's plane, or in it.
/// - `intersects`, `contact`, `contacts` and manifolds ignore a triangle that a body is behind. So
///   a body that has come through a floor by more than half falls on, and is not pushed up.
/// - If the interior point is in front, but the shortest way out leads through the back of the
///   triangle, the contact is the one with the half-space behind the triangle's plane: the body is
///   pushed out to the front, by the depth of its lowest point, and the interval bounds this depth.
/// - Rays and casts ignore triangles whose front they do not move towards: the dot product of
///   velocity and normal must be negative, for rays its exact value. A cast also ignores triangles
///   that the body is behind at its start.
/// - `distance`, `signed_distance`, `clear` and `cast_motion` count both sides.
///
/// At a border, a contact may lean backwards, as on any edge.
///
/// # Examples
/// A ball that has sunk into a floor to its middle, and a little farther:
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use hullmap::compound::OneSided;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Cache, CastSettings, Pose, Ray, Settings, TriangleMesh};
/// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
/// # let positions = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
/// # let corners = [[0, 1, 2], [0, 2, 3]];
/// # let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] })?;
/// # let file = write_triangle_mesh(baked, &Default::default())?;
///
/// let (ground, ball) = (TriangleMesh::from_bytes(&file)?, Sphere::new(0.5)?);
/// let (floor, settings, mut cache) = (OneSided::new(&ground), Settings::default(), Cache::new());
/// let mut contact = |z: f64| -> Result<_, Box<dyn std::error::Error>> {
///     let at = Pose::from_translation(DVec3::new(1.0, 2.0, z))?;
///     Ok(hullmap::contact(&floor, &ball, at, &settings, &mut cache))
/// };
/// let above = contact(0.001)?;
/// assert!(above.normal.distance(DVec3::Z) < 1e-6 && (above.depth - 0.499).abs() < 1e-6);
/// assert!(!contact(-0.001)?.hit);
///
/// let up = Ray::new(DVec3::new(1.0, 2.0, -5.0), DVec3::Z)?;
/// assert!(hullmap::ray(&ground, &up, &CastSettings::default()).hit);
/// assert!(!hullmap::ray(&floor, &up, &CastSettings::default()).hit);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct OneSided<'m, M: ?Sized>(&'m M);

impl<'m, M: Parts + ?Sized> OneSided<'m, M> {
    /// The fronts of `mesh`.
    pub fn new(mesh: &'m M) -> Self {
        Self(mesh)
    }
}

impl<M: ?Sized> Clone for OneSided<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: ?Sized> Copy for OneSided<'_, M> {}

impl<M: Parts + ?Sized> Tree for OneSided<'_, M> {
    type Part<'p>
        = M::Part<'p>
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        self.0.part_count()
    }

    fn part(&self, index: usize) -> Option<M::Part<'_>> {
        self.0.part(index)
    }

    fn part_as_hull(&self, index: usize) -> Option<Hull<'_>> {
        self.0.part_as_hull(index)
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        self.0.sheet_normal(index)
    }

    fn is_one_sided(&self) -> bool {
        true
    }

    fn nodes(&self) -> Nodes<'_> {
        self.0.nodes()
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        self.0.any_in_box(bounds, visit)
    }
}
