//! The manifold function for a pair of shapes, chosen as in parry, with this dispatcher for parts.

use super::super::parry::math::{Pose, Real};
use super::super::parry::query::details as default;
use super::super::parry::query::details::{ContactManifoldsWorkspace, NormalConstraints};
use super::super::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, Unsupported};
use super::super::parry::shape::{Shape, ShapeType};
use super::contacts::{hardly_moved, solve, update, update_plane};
use super::pair::{pair, plane};
use super::patches::Body;
use super::welder::Welder;
use super::workspace::Memory;
use super::{BakedHull, HullDispatcher};

impl<M, C> PersistentQueryDispatcher<M, C> for HullDispatcher
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
        if let Some(found) = pair(pos12, shape1, shape2) {
            manifolds.resize_with(1, ContactManifold::new);
            let Some(manifold) = manifolds.first_mut() else { return Err(Unsupported) };
            if !hardly_moved(pos12, manifold)
                && let Some(memory) = Memory::of(workspace)
            {
                update(&found, prediction, (&mut memory.manifold, &mut memory.cache), [None, None], manifold);
            }
            return Ok(());
        }
        if let Some(found) = plane(pos12, shape1, shape2) {
            manifolds.resize_with(1, ContactManifold::new);
            let Some(manifold) = manifolds.first_mut() else { return Err(Unsupported) };
            if !hardly_moved(pos12, manifold)
                && let Some(memory) = Memory::of(workspace)
            {
                update_plane(&found, prediction, &mut memory.manifold, manifold);
            }
            return Ok(());
        }
        let body = match (shape1.as_shape::<BakedHull>(), shape2.as_shape::<BakedHull>()) {
            (None, Some(hull)) => Some(Body { hull, is_second: true }),
            (Some(hull), None) => Some(Body { hull, is_second: false }),
            _ => None,
        };
        let before = body.as_ref().map(|body| body.points(manifolds)).unwrap_or_default();
        let (composite1, composite2) = (shape1.as_composite_shape(), shape2.as_composite_shape());
        let welder = Welder::new(shape1, shape2);
        if let (Some(composite1), Some(composite2)) = (composite1, composite2) {
            default::contact_manifolds_composite_shape_composite_shape(
                &welder, pos12, composite1, composite2, prediction, manifolds, workspace,
            );
            return Ok(());
        }
        match (shape1.shape_type(), shape2.shape_type()) {
            (ShapeType::TriMesh, _) | (_, ShapeType::TriMesh) => default::contact_manifolds_trimesh_shape_shapes(
                self, pos12, shape1, shape2, prediction, manifolds, workspace,
            ),
            (ShapeType::HeightField, _) | (_, ShapeType::HeightField)
                if composite1.is_none() && composite2.is_none() =>
            {
                default::contact_manifolds_heightfield_shape_shapes(
                    self, pos12, shape1, shape2, prediction, manifolds, workspace,
                );
            }
            (ShapeType::HeightField, _) => {
                let (Some(field), Some(composite)) = (shape1.as_heightfield(), composite2) else {
                    return Err(Unsupported);
                };
                default::contact_manifolds_heightfield_composite_shape(
                    self,
                    pos12,
                    &pos12.inverse(),
                    field,
                    composite,
                    prediction,
                    manifolds,
                    workspace,
                    false,
                );
            }
            (_, ShapeType::HeightField) => {
                let (Some(field), Some(composite)) = (shape2.as_heightfield(), composite1) else {
                    return Err(Unsupported);
                };
                default::contact_manifolds_heightfield_composite_shape(
                    self,
                    &pos12.inverse(),
                    pos12,
                    field,
                    composite,
                    prediction,
                    manifolds,
                    workspace,
                    true,
                );
            }
            (ShapeType::Voxels, ShapeType::Voxels | ShapeType::Ball) | (ShapeType::Ball, ShapeType::Voxels) => {
                return DefaultQueryDispatcher
                    .contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
            }
            (ShapeType::Voxels, _) | (_, ShapeType::Voxels) => {
                if composite1.is_some() || composite2.is_some() {
                    default::contact_manifolds_voxels_composite_shape_shapes(
                        self, pos12, shape1, shape2, prediction, manifolds, workspace,
                    );
                } else {
                    default::contact_manifolds_voxels_shape_shapes(
                        self, pos12, shape1, shape2, prediction, manifolds, workspace,
                    );
                }
            }
            _ => {
                if let Some(composite1) = composite1 {
                    default::contact_manifolds_composite_shape_shape(
                        &welder, pos12, composite1, shape2, prediction, manifolds, workspace, false,
                    );
                } else if let Some(composite2) = composite2 {
                    default::contact_manifolds_composite_shape_shape(
                        &welder,
                        &pos12.inverse(),
                        composite2,
                        shape1,
                        prediction,
                        manifolds,
                        workspace,
                        true,
                    );
                } else {
                    return DefaultQueryDispatcher
                        .contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
                }
            }
        }
        if let Some(body) = body {
            body.thin(manifolds, &before, prediction);
        }
        Ok(())
    }

    /// Called for the parts of composite shapes too. These have no memory, so that each update
    /// starts from the last normal only.
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
        // Constraints change the normal between the contact and the features; only parry does that.
        if normal_constraints1.is_none()
            && normal_constraints2.is_none()
            && solve(pos12, shape1, shape2, prediction, [None, None], manifold)
        {
            return Ok(());
        }
        DefaultQueryDispatcher.contact_manifold_convex_convex(
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
