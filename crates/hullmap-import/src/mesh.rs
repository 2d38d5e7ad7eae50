//! What every reader makes of a file: vertices, elements over them, and where objects begin.

use crate::ears::triangulate;

/// Vertices in file order, with the digits that the file has or that the options need.
#[derive(Debug)]
pub enum Positions {
    /// As f32.
    Single(Vec<[f32; 3]>),
    /// As f64: where the file says so, or where they are scaled, moved or transformed before they are rounded once.
    Double(Vec<[f64; 3]>),
}

impl Positions {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Self::Single(positions) => positions.len(),
            Self::Double(positions) => positions.len(),
        }
    }

    /// A vertex in f64.
    #[expect(clippy::indexing_slicing, reason = "asked only of vertices that the mesh has")]
    pub fn get(&self, vertex: u32) -> [f64; 3] {
        match self {
            Self::Single(positions) => positions[vertex as usize].map(f64::from),
            Self::Double(positions) => positions[vertex as usize],
        }
    }
}

/// Polygons as one list of corners, and the places where each ends.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygons {
    /// Vertex numbers of all corners, one polygon after the other.
    pub corners: Vec<u32>,
    /// Where the corners of each polygon end; they start where the previous polygon's end.
    pub ends: Vec<u32>,
}

impl Polygons {
    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Where the corners of polygon `number` start; for the number of polygons, where the last one's end.
    #[expect(clippy::indexing_slicing, reason = "asked only up to the number of polygons; objects begin within them")]
    pub fn start(&self, number: usize) -> usize {
        if number == 0 { 0 } else { self.ends[number - 1] as usize }
    }

    /// Adds a polygon.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.end();
    }

    /// Ends a polygon at the last corner that was pushed.
    pub fn end(&mut self) {
        self.ends.push(self.corners.len() as u32);
    }

    /// The polygons over `points` as triangles, two fewer than each has corners, whether it is convex or not. The winding is the
    /// file's.
    ///
    /// # Complexity
    /// O(corners) for convex polygons; for others see `triangulate`.
    #[expect(
        clippy::indexing_slicing,
        reason = "ends ascend, and none lies behind the last corner, as `end` pushes them"
    )]
    pub fn triangles(&self, points: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.corners.len().saturating_sub(2 * self.len()));
        for number in 0..self.len() {
            let corners = &self.corners[self.start(number)..self.ends[number] as usize];
            triangulate(corners, points, &mut triangles);
        }
        triangles
    }
}

/// Where an object begins; it ends where the next one begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// First vertex that was declared in it.
    pub first_vertex: u32,
    /// First polygon in it.
    pub first_face: u32,
    /// First of its loose references.
    pub first_loose: u32,
}

/// Everything in a file that can shape a hull.
#[derive(Debug)]
pub struct Mesh {
    /// All vertices, finite, in file order.
    pub positions: Positions,
    /// Faces of two-dimensional elements. All corners are in range.
    pub faces: Polygons,
    /// Vertices that lines, strips of lines and points reference, in range.
    pub loose: Vec<u32>,
    /// Objects in file order; at least one, and the first begins at 0.
    pub objects: Vec<Object>,
    /// Whether objects beyond the limit were joined to the last one: the file cannot be cut at objects.
    pub has_too_many_objects: bool,
    /// Whether vertices that equal an earlier one say something about the mesh: in a file without vertex numbers, each
    /// corner of a triangle is spelled out, and says nothing.
    pub may_share_vertices: bool,
    /// Whether the file is parted in ways other than objects, which a cut at objects ignores.
    pub has_only_groups: bool,
    /// What a user may want to know, a sentence each.
    pub notes: Vec<String>,
    /// What a user should look at, a sentence each, with the remedy.
    pub warnings: Vec<String>,
}

impl Mesh {
    /// A mesh of one nameless object.
    pub fn of(positions: Positions, faces: Polygons) -> Self {
        Self {
            positions,
            faces,
            loose: Vec::new(),
            objects: vec![Object { name: String::new(), first_vertex: 0, first_face: 0, first_loose: 0 }],
            has_too_many_objects: false,
            may_share_vertices: true,
            has_only_groups: false,
            notes: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Begins an object with what is pushed next, unless there are `limit` already.
    pub fn begin_object(&mut self, name: String, limit: usize) {
        if self.objects.len() > limit {
            self.has_too_many_objects = true;
            return;
        }
        self.objects.push(Object {
            name,
            first_vertex: self.positions.len() as u32,
            first_face: self.faces.len() as u32,
            first_loose: self.loose.len() as u32,
        });
    }

    /// Whether anything references vertices at all; faces without corners do not.
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
