//! Checks that the neighbours of a hull match its faces: each edge of a face is listed once, at the
//! vertex where it starts, with that face beside it. Queries choose the face towards a direction
//! among those listed at one vertex.
//!
//! # Steps
//! 1. There are as many neighbours as face corners, that is, as directed edges of faces.
//! 2. The neighbours of a vertex ascend, so no two entries are for the same edge v → w.
//! 3. Each entry that names a triangle is one of its edges. So different entries are different
//!    edges.
//! 4. Each edge of a larger face has an entry that names the face, and no two of its edges have the
//!    same entry. As many entries name larger faces as these have edges.
//!
//! So entries and edges correspond one to one. Triangles are checked from the entries, without a
//! search; in faces of many corners, that would take quadratic time.

use rkyv::rend::u32_le;

use crate::check_error::HullError;

/// The faces and neighbours of one hull, whose runs and indices are in range.
pub(crate) struct Adjacency<'a> {
    pub(crate) face_starts: &'a [u32_le],
    pub(crate) face_vertices: &'a [u32_le],
    pub(crate) neighbour_starts: &'a [u32_le],
    pub(crate) neighbours: &'a [u32_le],
    pub(crate) neighbour_faces: &'a [u32_le],
}

impl Adjacency<'_> {
    /// Compares the neighbours with the faces. O(C log d) for C face corners and at most d
    /// neighbours of a vertex. `found` is scratch: one bit per neighbour, if a face has more than
    /// three corners.
    pub(crate) fn check(&self, found: &mut Vec<u64>) -> Result<(), HullError> {
        // A segment has neighbours, but no faces.
        if self.face_starts.is_empty() {
            return Ok(());
        }
        let (neighbours, corners) = (self.neighbours.len(), self.face_vertices.len());
        if neighbours != corners {
            return Err(HullError::NeighbourCount { found: neighbours, expected: corners });
        }
        let in_larger = self.check_entries()?;
        self.check_larger_faces(in_larger, found)
    }

    /// Steps 2 and 3. Returns the number of entries that name larger faces than triangles.
    fn check_entries(&self) -> Result<usize, HullError> {
        let mut in_larger = 0;
        let ends = self.neighbour_starts.iter().skip(1).map(|start| start.to_native() as usize);
        let ends = ends.chain([self.neighbours.len()]);
        for (vertex, (start, end)) in self.neighbour_starts.iter().zip(ends).enumerate() {
            let range = start.to_native() as usize..end;
            let neighbours = self.neighbours.get(range.clone()).unwrap_or_default();
            let faces = self.neighbour_faces.get(range).unwrap_or_default();
            let from = vertex as u32;
            let mut before = None;
            for (to, face) in neighbours.iter().zip(faces) {
                let (to, face) = (to.to_native(), face.to_native());
                if before >= Some(to) {
                    return Err(HullError::NeighbourOrder { vertex, found: to });
                }
                before = Some(to);
                match *self.face(face) {
                    [a, b, c] => {
                        let [a, b, c] = [a, b, c].map(u32_le::to_native);
                        let is_edge = (a == from) & (b == to) | (b == from) & (c == to) | (c == from) & (a == to);
                        if !is_edge {
                            return Err(HullError::FaceEdge { face: face as usize, from, to });
                        }
                    }
                    _ => in_larger += 1,
                }
            }
        }
        Ok(in_larger)
    }

    /// Step 4.
    fn check_larger_faces(&self, in_larger: usize, found: &mut Vec<u64>) -> Result<(), HullError> {
        found.clear();
        let mut edge_count = 0;
        for face in 0..self.face_starts.len() as u32 {
            let corners = self.face(face);
            let Some(last) = corners.last().filter(|_| corners.len() > 3) else { continue };
            found.resize(self.neighbours.len().div_ceil(64), 0);
            edge_count += corners.len();
            let mut from = last.to_native();
            for to in corners.iter().map(|to| to.to_native()) {
                let is_new = self.entry(face, from, to).is_some_and(|entry| {
                    let Some(word) = found.get_mut(entry / 64) else { return false };
                    let bit = 1 << (entry % 64);
                    let is_new = *word & bit == 0;
                    *word |= bit;
                    is_new
                });
                if !is_new {
                    return Err(HullError::FaceEdge { face: face as usize, from, to });
                }
                from = to;
            }
        }
        if in_larger == edge_count {
            Ok(())
        } else {
            Err(HullError::NeighbourCount { found: in_larger, expected: edge_count })
        }
    }

    fn face(&self, face: u32) -> &[u32_le] {
        let at = face as usize;
        let end = self.face_starts.get(at + 1).map_or(self.face_vertices.len(), |start| start.to_native() as usize);
        let start = self.face_starts.get(at).map_or(end, |start| start.to_native() as usize);
        self.face_vertices.get(start..end).unwrap_or_default()
    }

    /// The entry for the edge `from` → `to` with `face` beside it.
    fn entry(&self, face: u32, from: u32, to: u32) -> Option<usize> {
        let at = from as usize;
        let start = self.neighbour_starts.get(at)?.to_native() as usize;
        let end = self.neighbour_starts.get(at + 1).map_or(self.neighbours.len(), |start| start.to_native() as usize);
        let run = self.neighbours.get(start..end)?;
        let entry = start + run.binary_search_by_key(&to, |neighbour| neighbour.to_native()).ok()?;
        (self.neighbour_faces.get(entry)?.to_native() == face).then_some(entry)
    }
}
