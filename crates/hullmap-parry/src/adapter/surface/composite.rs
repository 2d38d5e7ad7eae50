//! A surface as parry's `CompositeShape`, for algorithms of parry that solve each triangle alone.

use super::super::parry::bounding_volume::BoundingVolume as _;
use super::super::parry::math::Pose;
use super::super::parry::partitioning::{Bvh, BvhBuildStrategy};
use super::super::parry::query::details::NormalConstraints;
use super::super::parry::shape::{CompositeShape, Shape};
use super::{BakedSurface, SurfaceTile};

impl CompositeShape for BakedSurface {
    fn map_part_at(&self, shape_id: u32, f: &mut dyn FnMut(Option<&Pose>, &dyn Shape, Option<&dyn NormalConstraints>)) {
        if let Some((tile, index)) = self.locate(shape_id)
            && let Some(triangle) = tile.parry_triangle(index)
        {
            f(tile.pose(), &triangle, None);
        }
    }

    /// Built at the first call, in O(n log n) for n triangles.
    fn bvh(&self) -> &Bvh {
        self.content.tree.get_or_init(|| {
            let leaves = self.tiles().iter().flat_map(|tile| {
                let triangles = (0..tile.triangle_count()).filter_map(|index| {
                    let place = tile.pose().copied().unwrap_or(Pose::IDENTITY);
                    let tight = tile.parry_triangle(index)?.compute_aabb(&place);
                    let largest = tight.mins.abs().max(tight.maxs.abs()).max_element();
                    Some((tile.subshape(index) as usize, tight.loosened(SurfaceTile::MARGIN * largest)))
                });
                triangles.collect::<Vec<_>>()
            });
            Bvh::from_iter(BvhBuildStrategy::Binned, leaves)
        })
    }
}
