//! Dispatcher for parts of compounds: corrects the normals of their manifolds at internal edges.
//!
//! parry splits compounds, and passes each pair of parts to a dispatcher, without the compounds.
//! This one knows them.

use hullmap::compound::seams::{Neighbour, Union, face_of, faces_of_hull, faces_of_shape};
use hullmap::glam::DVec3;

use super::super::convert::{narrow, real};
use super::super::parry::bounding_volume::Aabb;
use super::super::parry::math::{Pose, Real, Vector};
use super::super::parry::query::details::{ContactManifoldsWorkspace, NormalConstraints};
use super::super::parry::query::{
    ClosestPoints, Contact, ContactManifold, NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher,
    ShapeCastHit, ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
};
use super::super::parry::shape::{Compound, Shape};
use super::manifold::{PartOf, solve};
use super::pair::pose;
use super::primitive::Primitive;
use super::{BakedHull, HullDispatcher};

/// Relative allowance for rounding a point to parry's precision.
const ROUNDING: f64 = 1e-6;

/// `HullDispatcher` for the parts of two shapes, each of which may be a compound.
pub(super) struct PartDispatcher<'c> {
    compounds: [Option<Parts<'c>>; 2],
}

impl<'c> PartDispatcher<'c> {
    pub(super) fn new(shape1: &'c dyn Shape, shape2: &'c dyn Shape) -> Self {
        let parts = |shape: &'c dyn Shape| {
            shape.as_shape::<Compound>().filter(|compound| compound.shapes().len() > 1).map(Parts)
        };
        Self { compounds: [parts(shape1), parts(shape2)] }
    }
}

/// A compound of parry's, as a union of hullmap's shapes. Parts that hullmap has no shape for are
/// left out.
struct Parts<'c>(&'c Compound);

impl Parts<'_> {
    /// The part with this index, and its pose in the frame of the compound.
    fn part(&self, part: usize) -> Option<PartOf<'_>> {
        let (place, _) = self.0.shapes().get(part)?;
        Some((self, part, pose(place)?))
    }

    fn hull(&self, part: usize) -> Option<&BakedHull> {
        self.0.shapes().get(part)?.1.as_shape::<BakedHull>()
    }

    fn primitive(&self, part: usize) -> Option<Primitive> {
        Primitive::from_shape(&*self.0.shapes().get(part)?.1)
    }
}

impl Union for Parts<'_> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        let half = reach + ROUNDING * point.abs().max_element();
        let near = Aabb::from_half_extents(narrow(point), Vector::splat(real(half)));
        self.0.bvh().intersect_aabb(&near).any(|leaf| {
            let index = leaf as usize;
            let Some((_, _, place)) = self.part(index) else { return false };
            if let Some(hull) = self.hull(index) {
                return test(Neighbour { index, shape: hull, place });
            }
            self.primitive(index).is_some_and(|primitive| test(Neighbour { index, shape: primitive.shape(), place }))
        })
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        let (_, _, place) = self.part(part)?;
        let local = place.inverse_transform_vector(dir);
        let normal = match self.hull(part) {
            Some(hull) => hull.face_normal(hull.face_towards(local)?)?,
            None => face_of(self.primitive(part)?.shape(), local)?.0,
        };
        Some(place.transform_vector(normal))
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        let Some((_, _, place)) = self.part(part) else { return };
        let mut give =
            |normal: DVec3, point: DVec3| visit(place.transform_vector(normal), place.transform_point(point));
        if let Some(hull) = self.hull(part) {
            let scale = hull.scale_factors();
            faces_of_hull(hull.hull(), vertex, &mut |normal, point| {
                if let Some(normal) = (normal / scale).try_normalize() {
                    give(normal, point * scale);
                }
            });
        } else if let Some(primitive) = self.primitive(part) {
            faces_of_shape(primitive.shape(), &mut give);
        }
    }
}

impl<M, C> PersistentQueryDispatcher<M, C> for PartDispatcher<'_>
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<M, C>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        HullDispatcher.contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace)
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold<M, C>,
    ) -> Result<(), Unsupported> {
        let [compound1, compound2] = &self.compounds;
        let parts = [
            compound1.as_ref().and_then(|compound| compound.part(manifold.subshape1 as usize)),
            compound2.as_ref().and_then(|compound| compound.part(manifold.subshape2 as usize)),
        ];
        if normal_constraints1.is_none()
            && normal_constraints2.is_none()
            && solve(pos12, shape1, shape2, prediction, parts, manifold)
        {
            return Ok(());
        }
        HullDispatcher.contact_manifold_convex_convex(
            pos12,
            shape1,
            shape2,
            normal_constraints1,
            normal_constraints2,
            prediction,
            manifold,
        )
    }
}

/// parry requires these of every dispatcher. All are those of `HullDispatcher`.
impl QueryDispatcher for PartDispatcher<'_> {
    fn intersection_test(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        HullDispatcher.intersection_test(pos12, shape1, shape2)
    }

    fn distance(&self, pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        HullDispatcher.distance(pos12, shape1, shape2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        HullDispatcher.contact(pos12, shape1, shape2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        HullDispatcher.closest_points(pos12, shape1, shape2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        HullDispatcher.cast_shapes(pos12, local_vel12, shape1, shape2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        shape1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        shape2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        HullDispatcher.cast_shapes_nonlinear(
            motion1,
            shape1,
            motion2,
            shape2,
            start_time,
            end_time,
            stop_at_penetration,
        )
    }
}
