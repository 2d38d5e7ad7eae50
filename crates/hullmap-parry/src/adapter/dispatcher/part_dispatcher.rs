//! Dispatcher for parts of compounds: corrects the normals of their manifolds at internal edges.
//!
//! parry splits compounds, and passes each pair of parts to a dispatcher, without the compounds.
//! This dispatcher keeps the compounds.

use super::super::parry::math::{Pose, Real, Vector};
use super::super::parry::query::details::{ContactManifoldsWorkspace, NormalConstraints};
use super::super::parry::query::{
    ClosestPoints, Contact, ContactManifold, NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher,
    ShapeCastHit, ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
};
use super::super::parry::shape::Shape;
use super::HullDispatcher;
use super::compound_union::CompoundUnion;
use super::manifold::solve;

pub(super) struct PartDispatcher<'c> {
    compounds: [Option<CompoundUnion<'c>>; 2],
}

impl<'c> PartDispatcher<'c> {
    pub(super) fn new(shape1: &'c dyn Shape, shape2: &'c dyn Shape) -> Self {
        Self { compounds: [shape1, shape2].map(CompoundUnion::from_shape) }
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

/// parry requires these methods of every dispatcher. They call `HullDispatcher`.
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
