//! A parry compound as a hullmap union of parts, for the correction of normals at internal edges.

use hullmap::compound::seams::{Neighbour, Union, face_of, faces_of_hull, faces_of_shape};
use hullmap::glam::DVec3;

use super::super::convert::{narrow, real, wide_pose};
use super::super::parry::bounding_volume::Aabb;
use super::super::parry::math::Vector;
use super::super::parry::shape::{Compound, Shape};
use super::manifold::PartOf;
use super::pieces::Convex;

/// Relative allowance for rounding a point to parry's precision.
const ROUNDING: f64 = 1e-6;

/// A parry compound, as a union of hullmap's shapes. Parts without a shape in hullmap are left out.
pub(super) struct CompoundUnion<'c>(&'c Compound);

impl<'c> CompoundUnion<'c> {
    /// The union of the parts of a shape; `None` if it has fewer than two.
    pub(super) fn from_shape(shape: &'c dyn Shape) -> Option<Self> {
        shape.as_shape::<Compound>().filter(|compound| compound.shapes().len() > 1).map(Self)
    }

    pub(super) fn part(&self, part: usize) -> Option<PartOf<'_>> {
        let (place, _) = self.0.shapes().get(part)?;
        Some((self, part, wide_pose(place)?))
    }

    fn convex(&self, part: usize) -> Option<Convex<'_>> {
        Convex::from_shape(&*self.0.shapes().get(part)?.1)
    }
}

impl Union for CompoundUnion<'_> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        let half = reach + ROUNDING * point.abs().max_element();
        let near = Aabb::from_half_extents(narrow(point), Vector::splat(real(half)));
        self.0.bvh().intersect_aabb(&near).any(|leaf| {
            let index = leaf as usize;
            let (Some((_, _, place)), Some(convex)) = (self.part(index), self.convex(index)) else { return false };
            test(Neighbour { index, shape: convex.shape(), place })
        })
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        let (_, _, place) = self.part(part)?;
        let local = place.inverse_transform_vector(dir);
        let normal = match self.convex(part)? {
            Convex::Hull(hull) => hull.face_normal(hull.face_towards(local)?)?,
            Convex::Primitive(primitive) => face_of(primitive.shape(), local)?.0,
        };
        Some(place.transform_vector(normal))
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        let Some((_, _, place)) = self.part(part) else { return };
        let mut give =
            |normal: DVec3, point: DVec3| visit(place.transform_vector(normal), place.transform_point(point));
        match self.convex(part) {
            Some(Convex::Hull(hull)) => {
                let scale = hull.scale_factors();
                faces_of_hull(hull.hull(), vertex, &mut |normal, point| {
                    if let Some(normal) = (normal / scale).try_normalize() {
                        give(normal, point * scale);
                    }
                });
            }
            Some(Convex::Primitive(primitive)) => faces_of_shape(primitive.shape(), &mut give),
            None => {}
        }
    }
}
