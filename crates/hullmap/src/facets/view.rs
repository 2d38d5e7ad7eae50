//! Faces of a small polytope, as the separating axis test (SAT) reads them: the faces of a hull lie
//! in its [`FacetTable`], and a box makes its table for each query.

use glam::DVec3;

use super::table::{Edge, FacetTable, LANES, MAX_VERTICES, NormalBlock, PointBlock};
use crate::hull::Hull;
use crate::support::simd::Dispatch;

/// The faces of a small polytope, from [`SupportMap::facets`](crate::SupportMap::facets).
///
/// Hulls of few vertices and boxes have them. They cannot be made outside of this crate.
#[derive(Clone, Copy, Debug)]
pub struct Facets<'a>(Kind<'a>);

#[derive(Clone, Copy, Debug)]
enum Kind<'a> {
    Hull(&'a FacetTable, &'a Hull<'a>),
    Cuboid(DVec3),
}

/// The blocks and arcs of a box, made for one query.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Buffer {
    normals: [NormalBlock; 1],
    points: [PointBlock; 1],
}

/// The arrays that the first pass reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'v> {
    pub(crate) normals: &'v [NormalBlock],
    pub(crate) points: &'v [PointBlock],
    /// Each arc once.
    pub(crate) edges: &'v [Edge],
}

/// The arcs of a box. Vertices are numbered by the signs of their coordinates as in
/// [`Cuboid`](crate::shapes::Cuboid), faces by axis and sign.
const BOX_EDGES: [Edge; 12] = box_edges();

#[expect(clippy::indexing_slicing, reason = "12 of the 15 pairs of faces are not opposite")]
const fn box_edges() -> [Edge; 12] {
    let mut edges = [Edge { faces: [0; 2], vertex: 0, cosine: 0.0 }; 12];
    let (mut pair, mut edge) = (0, 0);
    while pair < 36 {
        let (face, beyond) = (pair / 6, pair % 6);
        if face < beyond && face / 2 != beyond / 2 {
            // Take the end of the edge with the positive third coordinate.
            let vertex = (face & 1) << (face / 2) | (beyond & 1) << (beyond / 2);
            edges[edge] = Edge { faces: [face as u8, beyond as u8], vertex: vertex as u8, cosine: 0.0 };
            edge += 1;
        }
        pair += 1;
    }
    edges
}

impl<'a> Facets<'a> {
    #[inline(always)]
    pub(crate) fn of_hull(table: &'a FacetTable, hull: &'a Hull<'a>) -> Self {
        Self(Kind::Hull(table, hull))
    }

    /// The faces of a box; `None` if it is flat.
    #[inline(always)]
    pub(crate) fn of_box(half: DVec3) -> Option<Self> {
        (half.min_element() > 0.0).then_some(Self(Kind::Cuboid(half)))
    }

    #[cfg(test)]
    pub(crate) fn face_count(&self) -> usize {
        match self.0 {
            Kind::Hull(table, _) => table.exact.len(),
            Kind::Cuboid(_) => 6,
        }
    }

    /// Number of vertices, at most [`MAX_VERTICES`].
    #[inline(always)]
    pub(crate) fn vertex_count(&self) -> usize {
        match self.0 {
            Kind::Hull(_, hull) => hull.vertex_count().min(MAX_VERTICES),
            Kind::Cuboid(_) => 8,
        }
    }

    /// The arrays; a box's are written to `buffer`.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "a box has 3 axes, 6 faces and 8 vertices, of 8 lanes")]
    pub(crate) fn view<'v>(&self, buffer: &'v mut Buffer) -> View<'v>
    where
        'a: 'v,
    {
        match self.0 {
            Kind::Hull(table, _) => View { normals: &table.normals, points: &table.points, edges: &table.edges },
            Kind::Cuboid(half) => {
                let half = half.as_vec3().to_array();
                let NormalBlock { normal, offset } = &mut buffer.normals[0];
                *offset = [f32::INFINITY; LANES];
                for face in 0..6 {
                    offset[face] = half[face / 2];
                    normal[face / 2][face] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
                }
                for (axis, components) in buffer.points[0].0.iter_mut().enumerate() {
                    for (vertex, component) in components.iter_mut().enumerate() {
                        *component = if vertex >> axis & 1 == 0 { half[axis] } else { -half[axis] };
                    }
                }
                View { normals: &buffer.normals, points: &buffer.points, edges: &BOX_EDGES }
            }
        }
    }

    /// Unit outward normal of a face. It defines the end of the face's arcs.
    #[inline]
    pub(crate) fn normal(&self, face: usize) -> Option<DVec3> {
        match self.0 {
            Kind::Hull(table, _) => table.exact.get(face).copied(),
            Kind::Cuboid(_) => {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z].get(face / 2).copied()?;
                Some(if face.is_multiple_of(2) { axis } else { -axis })
            }
        }
    }

    /// The vertex that is farthest along a face's normal, of several the one with the lowest index.
    /// It is the support point of the shape in that direction.
    #[inline(always)]
    pub(crate) fn support(&self, face: usize) -> Option<usize> {
        match self.0 {
            Kind::Hull(table, _) => table.supports.get(face).map(|vertex| usize::from(*vertex)),
            // The corner with positive coordinates except for the face's axis.
            Kind::Cuboid(_) => Some((face & 1) << (face / 2)),
        }
    }

    /// Position of a vertex, which has the number of its feature.
    #[inline(always)]
    pub(crate) fn vertex(&self, vertex: usize) -> Option<DVec3> {
        match self.0 {
            Kind::Hull(_, hull) => hull.position(vertex as u32),
            Kind::Cuboid(half) => {
                let side = |bit: usize, half: f64| if vertex & bit == 0 { half } else { -half };
                Some(DVec3::new(side(1, half.x), side(2, half.y), side(4, half.z)))
            }
        }
    }

    /// Maximum height by which the shape extends beyond a vertex in a direction of the cone that is
    /// spanned by the normals of the vertex's faces.
    #[inline(always)]
    pub(crate) fn slack(&self) -> f64 {
        match self.0 {
            Kind::Hull(table, _) => table.slack,
            Kind::Cuboid(_) => 0.0,
        }
    }

    /// The instruction set of the hull, or the best one.
    #[inline(always)]
    pub(crate) fn dispatch(&self) -> Option<Dispatch> {
        match self.0 {
            Kind::Hull(_, hull) => Some(hull.dispatch()),
            Kind::Cuboid(_) => None,
        }
    }
}
