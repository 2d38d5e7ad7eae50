//! Shapes that parry splits into parts, which it passes to a dispatcher.

use super::super::parry::shape::{CompositeShape, HeightField, Shape, Voxels};

#[derive(Clone, Copy)]
pub(super) enum Split<'s> {
    /// A compound, a triangle mesh, a surface, or another shape with a tree of its parts.
    Composite(&'s (dyn CompositeShape + Sync)),
    Field(&'s HeightField),
    Voxels(&'s Voxels),
    /// The shape has no parts.
    Whole,
}

/// How parry splits two shapes.
pub(super) fn split<'s>(shape1: &'s dyn Shape, shape2: &'s dyn Shape) -> [Split<'s>; 2] {
    [shape1, shape2].map(|shape| {
        let composite = shape.as_composite_shape().map(Split::Composite);
        let field = || shape.as_heightfield().map(Split::Field);
        composite.or_else(field).or_else(|| shape.as_voxels().map(Split::Voxels)).unwrap_or(Split::Whole)
    })
}
