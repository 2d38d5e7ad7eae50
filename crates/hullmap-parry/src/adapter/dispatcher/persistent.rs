//! Implements parry's `contact_manifolds`: hullmap solves the pairs that it supports, parry solves
//! the others, and the parts of composite shapes are passed to this dispatcher again.

use super::super::parry::math::{Pose, Real};
use super::super::parry::query::details as default;
use super::super::parry::query::details::{ContactManifoldsWorkspace, NormalConstraints};
use super::super::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, Unsupported};
use super::super::parry::shape::Shape;
use super::HullDispatcher;
use super::manifold::{Touching, barely_moved, contact_manifold_convex_convex};
use super::memory::{Memory, in_workspace};
use super::part_dispatcher::PartDispatcher;
use super::patches::{places, thin};
use super::split::{Split, split};
use super::surface_manifold::SurfaceMemory;
use super::surface_pair::surface_pair;

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
        if let Some(pair) = Touching::new(pos12, shape1, shape2) {
            manifolds.resize_with(1, ContactManifold::new);
            let Some(manifold) = manifolds.first_mut() else { return Err(Unsupported) };
            if !barely_moved(pos12, manifold)
                && let Some(Memory { manifold: kept, cache }) = in_workspace(workspace)
            {
                pair.update(prediction, (kept, cache), [None, None], manifold);
            }
            return Ok(());
        }
        if let Some(pair) = surface_pair(pos12, shape1, shape2)
            && let Some(memory) = in_workspace::<SurfaceMemory>(workspace)
        {
            memory.update(pos12, &pair, prediction, manifolds);
            return Ok(());
        }
        let hull = match (shape1.as_shape(), shape2.as_shape()) {
            (None, Some(hull)) => Some((hull, true)),
            (Some(hull), None) => Some((hull, false)),
            _ => None,
        };
        let before = hull.map(|(_, is_second)| places(manifolds, is_second)).unwrap_or_default();
        update_parts(pos12, [shape1, shape2], prediction, manifolds, workspace)?;
        if let Some(hull) = hull {
            thin(manifolds, hull, &before, prediction);
        }
        Ok(())
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
        let constraints = [normal_constraints1, normal_constraints2];
        contact_manifold_convex_convex(pos12, [shape1, shape2], constraints, prediction, [None, None], manifold)
    }
}

/// Updates the manifolds of a pair that hullmap does not solve as a whole.
fn update_parts<M, C>(
    pos12: &Pose,
    [shape1, shape2]: [&dyn Shape; 2],
    prediction: Real,
    manifolds: &mut Vec<ContactManifold<M, C>>,
    workspace: &mut Option<ContactManifoldsWorkspace>,
) -> Result<(), Unsupported>
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    use Split::{Composite, Field, Voxels, Whole};
    let (kinds, dispatcher) = (split(shape1, shape2), PartDispatcher::new(shape1, shape2));
    let has_mesh = shape1.as_trimesh().or(shape2.as_trimesh()).is_some();
    let has_ball = shape1.as_ball().or(shape2.as_ball()).is_some();
    // For functions whose first shape must be the one with parts.
    let pos21 = &pos12.inverse();
    let update = match kinds {
        [Composite(composite1), Composite(composite2)] => {
            default::contact_manifolds_composite_shape_composite_shape(
                &dispatcher,
                pos12,
                composite1,
                composite2,
                prediction,
                manifolds,
                workspace,
            );
            return Ok(());
        }
        _ if has_mesh => default::contact_manifolds_trimesh_shape_shapes,
        [Field(field), Composite(composite)] | [Composite(composite), Field(field)] => {
            let flipped = matches!(kinds, [Composite(_), _]);
            let [pos12, pos21] = if flipped { [pos21, pos12] } else { [pos12, pos21] };
            default::contact_manifolds_heightfield_composite_shape(
                &HullDispatcher,
                pos12,
                pos21,
                field,
                composite,
                prediction,
                manifolds,
                workspace,
                flipped,
            );
            return Ok(());
        }
        [Field(_), _] | [_, Field(_)] => default::contact_manifolds_heightfield_shape_shapes,
        [Voxels(_), Composite(_)] | [Composite(_), Voxels(_)] => {
            default::contact_manifolds_voxels_composite_shape_shapes
        }
        [Voxels(_), Whole] | [Whole, Voxels(_)] if !has_ball => default::contact_manifolds_voxels_shape_shapes,
        [Composite(composite), Whole] | [Whole, Composite(composite)] => {
            let flipped = matches!(kinds, [Whole, _]);
            let (pos12, shape) = if flipped { (pos21, shape1) } else { (pos12, shape2) };
            default::contact_manifolds_composite_shape_shape(
                &dispatcher,
                pos12,
                composite,
                shape,
                prediction,
                manifolds,
                workspace,
                flipped,
            );
            return Ok(());
        }
        [Voxels(_) | Whole, Voxels(_) | Whole] => {
            return DefaultQueryDispatcher.contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
        }
    };
    update(&HullDispatcher, pos12, shape1, shape2, prediction, manifolds, workspace);
    Ok(())
}
