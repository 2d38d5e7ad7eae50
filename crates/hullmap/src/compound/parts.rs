//! Arguments of queries of parts: a compound, a triangle mesh, a height field, or a single shape.

use super::bvh::{BoxShape, Node, Nodes};
use super::members::Compound;
use crate::height_field::HeightField;
use crate::hull::Hull;
use crate::pose::Pose;
use crate::shapes::triangle::VisitTriangle;
use crate::shapes::{Shape, Triangle};
use crate::support::SupportMap;
use crate::triangle_mesh::TriangleMesh;
use glam::DVec3;

/// A geometry with parts: a [`Compound`], whose parts are its hulls; a [`TriangleMesh`] or a
/// [`HeightField`], whose parts are their triangles; and any [`Shape`], as its only part.
pub trait Parts: Tree {}

impl<T: Tree + ?Sized> Parts for T {}

/// Methods of [`Parts`]. In a private module, so that only this crate implements it.
pub trait Tree {
    /// A part.
    type Part<'p>: Shape
    where
        Self: 'p;

    /// Number of parts.
    fn part_count(&self) -> usize;

    /// The part with this index; `None` if the index is not below the number of parts, and for a
    /// triangle in a hole.
    fn part(&self, index: usize) -> Option<Self::Part<'_>>;

    /// The part with this index as a hull, if it is a hull of a pack.
    fn part_as_hull(&self, index: usize) -> Option<Hull<'_>> {
        let _ = index;
        None
    }

    /// A unit normal of the part with this index, if it is a piece of a sheet, which has two faces.
    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        let _ = index;
        None
    }

    /// Whether the parts of a sheet collide on their fronts alone, to which their normals point.
    fn is_one_sided(&self) -> bool {
        false
    }

    /// The front of the part with this index: its normal, if it is a piece of a one-sided sheet.
    fn front(&self, index: usize) -> Option<DVec3> {
        if self.is_one_sided() { self.sheet_normal(index) } else { None }
    }

    /// The BVH of the parts.
    fn nodes(&self) -> Nodes<'_>;

    /// The box of a node of the BVH as a shape.
    fn box_shape(node: Node) -> impl SupportMap {
        BoxShape(node)
    }

    /// Visits all triangles, with their corners, whose boxes overlap a box, given by two corners,
    /// and maybe others near it, until a visit says `true`. Returns whether one did, and the number
    /// of boxes compared; `None` if the parts are no triangles, or have no faster way than their
    /// BVH.
    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        let _ = (bounds, visit);
        None
    }
}

impl Tree for Compound<'_> {
    type Part<'p>
        = Hull<'p>
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        self.hull_count()
    }

    fn part(&self, index: usize) -> Option<Hull<'_>> {
        self.hull(index)
    }

    fn part_as_hull(&self, index: usize) -> Option<Hull<'_>> {
        self.hull(index)
    }

    fn nodes(&self) -> Nodes<'_> {
        Compound::nodes(self)
    }
}

impl Tree for TriangleMesh {
    type Part<'p>
        = Triangle
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        self.triangle_count()
    }

    fn part(&self, index: usize) -> Option<Triangle> {
        self.triangle(index)
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        self.normal(index)
    }

    fn nodes(&self) -> Nodes<'_> {
        Nodes::of_mesh(self)
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        Some(TriangleMesh::any_in_box(self, bounds, visit))
    }
}

impl Tree for HeightField {
    type Part<'p>
        = Triangle
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        self.triangle_count()
    }

    fn part(&self, index: usize) -> Option<Triangle> {
        self.triangle(index)
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        self.normal(index)
    }

    fn nodes(&self) -> Nodes<'_> {
        Nodes::of_field(self)
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        HeightField::any_in_box(self, bounds, visit)
    }
}

impl<S: Shape + ?Sized> Tree for S {
    type Part<'p>
        = &'p S
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        1
    }

    fn part(&self, index: usize) -> Option<&S> {
        (index == 0).then_some(self)
    }

    fn nodes(&self) -> Nodes<'_> {
        let bounds = self.bounds_under(Pose::IDENTITY);
        Nodes::one(bounds.min, bounds.max)
    }
}
