//! Source mesh: the result of every reader, with vertices, elements and objects.

use crate::ears::triangulate;
use crate::materials::Materials;

#[derive(Debug)]
pub enum Positions {
    Single(Vec<[f32; 3]>),
    /// For a file in `f64`, or for transforms before the only rounding.
    Double(Vec<[f64; 3]>),
}

impl Positions {
    pub fn len(&self) -> usize {
        match self {
            Self::Single(positions) => positions.len(),
            Self::Double(positions) => positions.len(),
        }
    }

    #[expect(clippy::indexing_slicing, reason = "callers pass vertices of the mesh")]
    pub fn get(&self, vertex: u32) -> [f64; 3] {
        match self {
            Self::Single(positions) => positions[vertex as usize].map(f64::from),
            Self::Double(positions) => positions[vertex as usize],
        }
    }
}

/// Polygons, as one list of corners and the end of each polygon in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygons {
    /// Vertex indices of all corners, polygon by polygon.
    pub corners: Vec<u32>,
    /// End of each polygon in `corners`. A polygon starts at the end of the previous one.
    pub ends: Vec<u32>,
}

impl Polygons {
    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no polygons.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Start of polygon `index` in `corners`; for [`Polygons::len`], the end of the last one.
    ///
    /// # Panics
    /// If `index` is greater than [`Polygons::len`].
    #[expect(clippy::indexing_slicing, reason = "a documented panic; objects start within the list")]
    pub fn start(&self, index: usize) -> usize {
        if index == 0 { 0 } else { self.ends[index - 1] as usize }
    }

    /// Appends a polygon with these vertex indices.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.end();
    }

    pub(crate) fn end(&mut self) {
        self.ends.push(self.corners.len() as u32);
    }

    /// Triangulates the polygons over `points`. A polygon of n corners gives n - 2 triangles,
    /// convex or not, with its winding.
    ///
    /// # Panics
    /// If a corner is not an index into `points`.
    ///
    /// # Complexity
    /// O(corners) for convex polygons, O(corners · log corners) with a bounded number of tests a
    /// corner for others.
    #[expect(
        clippy::indexing_slicing,
        reason = "ends ascend and none exceeds the number of corners, since `end` pushes them"
    )]
    pub fn triangles(&self, points: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.corners.len().saturating_sub(2 * self.len()));
        for index in 0..self.len() {
            let corners = &self.corners[self.start(index)..self.ends[index] as usize];
            triangulate(corners, points, &mut triangles);
        }
        triangles
    }
}

/// Start of an object. It ends where the next one starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceObject {
    /// Its name in the file, or an empty string.
    pub name: String,
    pub first_vertex: u32,
    pub first_face: u32,
    pub first_loose: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceCollider {
    pub object: usize,
    /// Index of the object whose shape it stands for, if that is known.
    pub stands_for: Option<usize>,
}

/// Everything in a source file that affects a hull or a triangle mesh.
#[derive(Debug)]
pub struct SourceMesh {
    /// Positions of all vertices, finite, in file order.
    pub positions: Positions,
    /// Faces. All corners are in range.
    pub faces: Polygons,
    /// Materials of the faces. They affect no hull.
    pub materials: Materials,
    /// Vertices that lines and points reference, in range.
    pub loose: Vec<u32>,
    /// Objects in file order. There is at least one, and the first starts at 0.
    pub objects: Vec<SourceObject>,
    /// Colliders by an extension of the file, ascending. Names have no effect then.
    pub colliders: Vec<SourceCollider>,
    /// Whether objects beyond the limit were joined to the last one. The file cannot be split by
    /// object then.
    pub has_too_many_objects: bool,
    /// Whether duplicate vertices are worth a note. In some formats they are the rule.
    pub may_share_vertices: bool,
    /// Whether the file has groups but no objects. A split by object ignores groups.
    pub has_only_groups: bool,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
}

impl SourceMesh {
    pub fn new(positions: Positions, faces: Polygons) -> Self {
        Self {
            positions,
            faces,
            materials: Materials::default(),
            loose: Vec::new(),
            objects: vec![SourceObject { name: String::new(), first_vertex: 0, first_face: 0, first_loose: 0 }],
            colliders: Vec::new(),
            has_too_many_objects: false,
            may_share_vertices: true,
            has_only_groups: false,
            notes: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Starts an object, unless `limit` is reached. Later additions belong to it.
    pub fn begin_object(&mut self, name: String, limit: usize) {
        if self.objects.len() > limit {
            self.has_too_many_objects = true;
            return;
        }
        self.objects.push(SourceObject {
            name,
            first_vertex: self.positions.len() as u32,
            first_face: self.faces.len() as u32,
            first_loose: self.loose.len() as u32,
        });
    }

    /// Whether any element references a vertex. Faces without corners do not.
    pub fn has_elements(&self) -> bool {
        !self.faces.corners.is_empty() || !self.loose.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn convex_faces_become_fans() {
        let on_circle = |i: u8| [(f32::from(i) * 0.5).cos(), (f32::from(i) * 0.5).sin(), 0.0];
        let points: Vec<[f32; 3]> = (0..10).map(on_circle).collect();
        let mut faces = Polygons::default();
        for corners in [&[4, 5, 6][..], &[7], &[0, 1, 2, 3, 9], &[8, 8], &[3, 2, 1, 0]] {
            faces.push(corners);
        }
        let fans = [[4, 5, 6], [0, 1, 2], [0, 2, 3], [0, 3, 9], [3, 2, 1], [3, 1, 0]];
        assert_eq!(faces.triangles(&points), fans);
        assert_eq!(Polygons::default().triangles(&points), [[0; 3]; 0]);
    }
}
