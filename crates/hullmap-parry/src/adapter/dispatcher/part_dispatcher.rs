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
use super::manifold::contact_manifold_convex_convex;

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
        let constraints = [normal_constraints1, normal_constraints2];
        contact_manifold_convex_convex(pos12, [shape1, shape2], constraints, prediction, parts, manifold)
    }
}

/// Methods that call `HullDispatcher`. parry requires them of every dispatcher.
macro_rules! delegate {
    ($($method:ident($($argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        $(fn $method(&self, $($argument: $type),*) -> Result<$answer, Unsupported> {
            HullDispatcher.$method($($argument),*)
        })*
    };
}

impl QueryDispatcher for PartDispatcher<'_> {
    delegate! {
        intersection_test(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> ShapeIntersection;
        distance(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> ShapeDistance;
        contact(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape, prediction: Real) -> Option<Contact>;
        closest_points(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape, max_dist: Real) -> ClosestPoints;
        cast_shapes(
            pos12: &Pose, velocity12: Vector, shape1: &dyn Shape, shape2: &dyn Shape, options: ShapeCastOptions
        ) -> Option<ShapeCastHit>;
        cast_shapes_nonlinear(
            motion1: &NonlinearRigidMotion, shape1: &dyn Shape, motion2: &NonlinearRigidMotion, shape2: &dyn Shape,
            start_time: Real, end_time: Real, stop_at_penetration: bool
        ) -> Option<ShapeCastHit>;
    }
}
