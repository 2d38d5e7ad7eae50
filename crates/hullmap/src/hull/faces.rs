//! Faces and neighbours of a hull, and the face towards a direction.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rkyv::rend::u32_le;

use super::Hull;
use crate::facets::table::triangle_normal;
use crate::support::SupportMap;
use crate::vector::unit;

impl<'a> Hull<'a> {
    /// Number of faces: all faces of a solid, both sides of a polygon, 0 for a segment or a point.
    pub fn face_count(&self) -> usize {
        self.face_starts.len()
    }

    /// Vertex indices of all faces. The vertices of a face are in counter-clockwise order, seen
    /// from outside.
    pub fn faces(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = u32> + 'a> + 'a {
        let (starts, vertices) = (self.face_starts, self.face_vertices);
        starts.iter().enumerate().map(move |(face, start)| {
            let start = start.to_native() as usize;
            let end = starts.get(face + 1).map_or(vertices.len(), |next| next.to_native() as usize);
            vertices.get(start..end).unwrap_or_default().iter().map(|v| v.to_native())
        })
    }

    /// Indices of the vertices that share an edge with vertex `index`, ascending. Empty if there is
    /// no such vertex.
    pub fn neighbours(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.neighbour_run(index).iter().map(|v| v.to_native())
    }

    #[inline]
    pub(super) fn neighbour_run(&self, index: u32) -> &'a [u32_le] {
        self.neighbours.get(self.neighbour_range(index)).unwrap_or_default()
    }

    #[inline]
    fn neighbour_range(&self, index: u32) -> Range<usize> {
        let at = index as usize;
        let start = |at: usize| self.neighbour_starts.get(at).map_or(self.neighbours.len(), |s| s.to_native() as usize);
        start(at)..start(at.saturating_add(1))
    }

    /// Vertex indices of face `face` in counter-clockwise order, seen from outside. Empty if there
    /// is no such face.
    pub fn face(&self, face: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.face_run(face).iter().map(|v| v.to_native())
    }

    #[inline]
    pub(super) fn face_run(&self, face: u32) -> &'a [u32_le] {
        let at = face as usize;
        let end =
            self.face_starts.get(at.saturating_add(1)).map_or(self.face_vertices.len(), |s| s.to_native() as usize);
        let start = self.face_starts.get(at).map_or(end, |s| s.to_native() as usize);
        self.face_vertices.get(start..end).unwrap_or_default()
    }

    /// Indices of the faces that meet at vertex `index`, each once. There are as many as the vertex
    /// has neighbours. Empty below rank 2, and if there is no such vertex.
    pub fn faces_at(&self, index: u32) -> impl ExactSizeIterator<Item = u32> + 'a {
        let range = if self.record.rank < 2 { 0..0 } else { self.neighbour_range(index) };
        self.neighbour_faces.get(range).unwrap_or_default().iter().map(|f| f.to_native())
    }

    /// The face to the left of the edge from `v` to `w`: the one in which `w` follows `v`. `None`
    /// if there is no such edge, and below rank 2.
    ///
    /// # Complexity
    /// A binary search in the neighbours of `v`.
    pub(super) fn face_left_of(&self, v: u32, w: u32) -> Option<u32> {
        let at = self.neighbour_run(v).binary_search_by_key(&w, |neighbour| neighbour.to_native()).ok()?;
        self.faces_at(v).nth(at)
    }

    /// Unit outward normal of face `face`; `None` if there is no such face.
    ///
    /// # Complexity
    /// O(1). Faces are planar, so three corners a third of the way around from each other span the
    /// plane well.
    pub fn face_normal(&self, face: u32) -> Option<DVec3> {
        if let Some(table) = self.facets {
            return table.exact.get(face as usize).copied();
        }
        let [first, second, third] = self.corners_apart(face)?;
        triangle_normal(first, second, third)
    }

    /// Three corners of face `face`, a third of the way around from each other.
    pub(super) fn corners_apart(&self, face: u32) -> Option<[DVec3; 3]> {
        // By index: an iterator would read each corner that it skips.
        let corners = self.face_run(face);
        // A face has three corners or more.
        let third = (corners.len() / 3).max(1);
        let corner = |i: usize| corners.get(i).and_then(|v| self.vertex(v.to_native())).map(Vec3::as_dvec3);
        Some([corner(0)?, corner(third)?, corner(2 * third)?])
    }

    /// The face that faces `dir` (local frame, any length): of the faces at the support vertex, the
    /// one whose normal is closest to `dir`. `None` below rank 2, and if `dir` is zero or not
    /// finite.
    ///
    /// # Complexity
    /// One support query, and one normal for each face at its vertex. A vertex has six faces on
    /// average; the tip of a cone has one for each neighbour.
    pub fn face_towards(&self, dir: DVec3) -> Option<u32> {
        let dir = unit(dir)?;
        let vertex = SupportMap::support_point(self, dir).feature;
        let alignment = |face: u32| self.face_normal(face).map_or(f64::NEG_INFINITY, |n| n.dot(dir));
        let mut best = (f64::NEG_INFINITY, None);
        for face in self.faces_at(vertex) {
            let found = alignment(face);
            if found > best.0 {
                best = (found, Some(face));
            }
        }
        best.1
    }
}
