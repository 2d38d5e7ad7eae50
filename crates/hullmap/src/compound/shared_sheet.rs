//! A triangle mesh or a height field as one type, which its users share.

#![forbid(unsafe_code)]

use std::sync::Arc;

use glam::DVec3;

use super::bvh::Nodes;
use super::parts::Tree;
use crate::height_field::HeightField;
use crate::shapes::Triangle;
use crate::shapes::triangle::VisitTriangle;
use crate::triangle_mesh::TriangleMesh;

/// A triangle mesh or a height field: one side of a query of programs that open both. A cheap copy.
#[derive(Clone, Debug)]
pub enum SharedSheet {
    /// A triangle mesh.
    Mesh(Arc<TriangleMesh>),
    /// A height field.
    Field(Arc<HeightField>),
}

impl From<Arc<TriangleMesh>> for SharedSheet {
    fn from(mesh: Arc<TriangleMesh>) -> Self {
        Self::Mesh(mesh)
    }
}

impl From<Arc<HeightField>> for SharedSheet {
    fn from(field: Arc<HeightField>) -> Self {
        Self::Field(field)
    }
}

impl SharedSheet {
    /// Name of its kind, with the article.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Mesh(_) => "a triangle mesh",
            Self::Field(_) => "a height field",
        }
    }

    /// Number of triangles, including the triangles of a field's holes.
    pub fn triangle_count(&self) -> usize {
        self.part_count()
    }

    /// The triangle with this index; `None` in a hole, and if the index is not below
    /// [`triangle_count`](Self::triangle_count).
    pub fn triangle(&self, index: usize) -> Option<Triangle> {
        self.part(index)
    }

    /// Unit normal of a triangle, to its front; `None` in a hole, and if it has no area.
    pub fn normal(&self, index: usize) -> Option<DVec3> {
        self.sheet_normal(index)
    }
}

impl Tree for SharedSheet {
    type Part<'p> = Triangle;

    fn part_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangle_count(),
            Self::Field(field) => field.triangle_count(),
        }
    }

    fn part(&self, index: usize) -> Option<Triangle> {
        match self {
            Self::Mesh(mesh) => mesh.triangle(index),
            Self::Field(field) => field.triangle(index),
        }
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        match self {
            Self::Mesh(mesh) => mesh.normal(index),
            Self::Field(field) => field.normal(index),
        }
    }

    fn nodes(&self) -> Nodes<'_> {
        match self {
            Self::Mesh(mesh) => mesh.nodes(),
            Self::Field(field) => field.nodes(),
        }
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        match self {
            Self::Mesh(mesh) => Tree::any_in_box(mesh.as_ref(), bounds, visit),
            Self::Field(field) => Tree::any_in_box(field.as_ref(), bounds, visit),
        }
    }
}
