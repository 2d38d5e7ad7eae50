//! Implements parry's `contact_manifolds`: hullmap solves the pairs that it supports, parry solves
//! the others, and the parts of composite shapes are passed to this dispatcher again.

use super::super::parry::math::{Pose, Real};
use super::super::parry::query::details as default;
use super::super::parry::query::details::{ContactManifoldsWorkspace, NormalConstraints};
use super::super::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, Unsupported};
use super::super::parry::shape::{Shape, ShapeType};
use super::manifold::{barely_moved, solve, update, update_plane};
use super::memory::{Memory, in_workspace};
use super::pair::{pair, plane};
use super::part_dispatcher::PartDispatcher;
use super::patches::Body;
use super::surface_manifold::SurfaceMemory;
use super::surface_pair::surface_pair;
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
            return update_one(pos12, manifolds, workspace, |memory, manifold| {
                update(&found, prediction, (&mut memory.manifold, &mut memory.cache), [None, None], manifold);
            });
        }
        if let Some(found) = plane(pos12, shape1, shape2) {
            return update_one(pos12, manifolds, workspace, |memory, manifold| {
                update_plane(&found, prediction, &mut memory.manifold, manifold);
            });
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some(memory) = in_workspace::<SurfaceMemory>(workspace)
        {
            memory.update(pos12, &pair, prediction, manifolds);
            return Ok(());
        }
        if !has_parts([shape1, shape2]) {
            return DefaultQueryDispatcher.contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
        }
        let body = match (shape1.as_shape::<BakedHull>(), shape2.as_shape::<BakedHull>()) {
            (None, Some(hull)) => Some(Body { hull, is_second: true }),
            (Some(hull), None) => Some(Body { hull, is_second: false }),
            _ => None,
        };
        let before = body.as_ref().map(|body| body.points(manifolds)).unwrap_or_default();
        Split { pos12, shapes: [shape1, shape2], prediction, manifolds, workspace }.update()?;
        if let Some(body) = body {
            body.thin(manifolds, &before, prediction);
        }
        Ok(())
    }

    /// Parts of composite shapes have no `Memory`, so each update starts only from the last normal.
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

/// Updates the only manifold of a pair that hullmap solves, unless the shapes barely moved.
fn update_one<M, C>(
    pos12: &Pose,
    manifolds: &mut Vec<ContactManifold<M, C>>,
    workspace: &mut Option<ContactManifoldsWorkspace>,
    update: impl FnOnce(&mut Memory, &mut ContactManifold<M, C>),
) -> Result<(), Unsupported>
where
    M: Default,
    C: Default + Copy,
{
    manifolds.resize_with(1, ContactManifold::new);
    let Some(manifold) = manifolds.first_mut() else { return Err(Unsupported) };
    if !barely_moved(pos12, manifold)
        && let Some(memory) = in_workspace::<Memory>(workspace)
    {
        update(memory, manifold);
    }
    Ok(())
}

/// Whether parry splits one of the shapes, and passes the parts to a given dispatcher.
fn has_parts(shapes: [&dyn Shape; 2]) -> bool {
    let [composite1, composite2] = shapes.map(|shape| shape.as_composite_shape().is_some());
    if composite1 && composite2 {
        return true;
    }
    match shapes.map(|shape| shape.shape_type()) {
        [ShapeType::Voxels, ShapeType::Voxels | ShapeType::Ball] | [ShapeType::Ball, ShapeType::Voxels] => false,
        types => {
            let is_split = |shape| matches!(shape, ShapeType::TriMesh | ShapeType::HeightField | ShapeType::Voxels);
            composite1 || composite2 || types.into_iter().any(is_split)
        }
    }
}

/// An update of the manifolds of two shapes, at least one of which has parts.
struct Split<'s, M, C> {
    pos12: &'s Pose,
    shapes: [&'s dyn Shape; 2],
    prediction: Real,
    manifolds: &'s mut Vec<ContactManifold<M, C>>,
    workspace: &'s mut Option<ContactManifoldsWorkspace>,
}

impl<M, C> Split<'_, M, C>
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    fn update(self) -> Result<(), Unsupported> {
        let Self { pos12, shapes: [shape1, shape2], prediction, .. } = self;
        match (self.shapes.map(|shape| shape.as_composite_shape()), self.shapes.map(|shape| shape.shape_type())) {
            ([Some(composite1), Some(composite2)], _) => default::contact_manifolds_composite_shape_composite_shape(
                &PartDispatcher::new(shape1, shape2),
                pos12,
                composite1,
                composite2,
                prediction,
                self.manifolds,
                self.workspace,
            ),
            (_, [ShapeType::TriMesh, _] | [_, ShapeType::TriMesh]) => default::contact_manifolds_trimesh_shape_shapes(
                &HullDispatcher,
                pos12,
                shape1,
                shape2,
                prediction,
                self.manifolds,
                self.workspace,
            ),
            (_, [ShapeType::HeightField, _] | [_, ShapeType::HeightField]) => return self.update_height_field(),
            (_, [ShapeType::Voxels, _] | [_, ShapeType::Voxels]) => self.update_voxels(),
            _ => self.update_composite(),
        }
        Ok(())
    }

    fn update_height_field(self) -> Result<(), Unsupported> {
        let Self { pos12, shapes: [shape1, shape2], prediction, manifolds, workspace } = self;
        let (composite1, composite2) = (shape1.as_composite_shape(), shape2.as_composite_shape());
        if composite1.is_none() && composite2.is_none() {
            default::contact_manifolds_heightfield_shape_shapes(
                &HullDispatcher,
                pos12,
                shape1,
                shape2,
                prediction,
                manifolds,
                workspace,
            );
            return Ok(());
        }
        let pos21 = pos12.inverse();
        let is_first = shape1.shape_type() == ShapeType::HeightField;
        let (field, composite, pos12, pos21) = if is_first {
            (shape1.as_heightfield(), composite2, pos12, &pos21)
        } else {
            (shape2.as_heightfield(), composite1, &pos21, pos12)
        };
        let (Some(field), Some(composite)) = (field, composite) else { return Err(Unsupported) };
        default::contact_manifolds_heightfield_composite_shape(
            &HullDispatcher,
            pos12,
            pos21,
            field,
            composite,
            prediction,
            manifolds,
            workspace,
            !is_first,
        );
        Ok(())
    }

    fn update_voxels(self) {
        let Self { pos12, shapes: [shape1, shape2], prediction, manifolds, workspace } = self;
        let has_composite = shape1.as_composite_shape().is_some() || shape2.as_composite_shape().is_some();
        let update = if has_composite {
            default::contact_manifolds_voxels_composite_shape_shapes
        } else {
            default::contact_manifolds_voxels_shape_shapes
        };
        update(&HullDispatcher, pos12, shape1, shape2, prediction, manifolds, workspace);
    }

    fn update_composite(self) {
        let Self { pos12, shapes: [shape1, shape2], prediction, manifolds, workspace } = self;
        let (composite1, composite2) = (shape1.as_composite_shape(), shape2.as_composite_shape());
        let pos21 = pos12.inverse();
        let is_second = composite1.is_none();
        let (composite, shape, pos12) =
            if is_second { (composite2, shape1, &pos21) } else { (composite1, shape2, pos12) };
        if let Some(composite) = composite {
            default::contact_manifolds_composite_shape_shape(
                &PartDispatcher::new(shape1, shape2),
                pos12,
                composite,
                shape,
                prediction,
                manifolds,
                workspace,
                is_second,
            );
        }
    }
}
