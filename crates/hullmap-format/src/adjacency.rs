//! The neighbours of a hull are those of its faces: each edge of a face is listed once, at the
//! vertex at which it starts, with that face beside it.
//!
//! Queries rely on it: the face towards a direction is chosen among the faces listed at one vertex.
//!
//! # Steps
//! 1. There are as many neighbours as face corners, that is, as directed edges of faces.
//! 2. For each edge v → w of each face, an entry w in the run of v names this face.
//! 3. No entry is found twice. So each entry is found once, and belongs to one edge of a face.

use rkyv::rend::u32_le;

use crate::check_error::HullError;

/// Runs of at most this many neighbours are searched from the front. On average, a vertex has six.
const SHORT_RUN: usize = 16;

/// The faces and neighbours of one hull, whose runs and indices are in range.
pub(crate) struct Adjacency<'a> {
    pub(crate) face_starts: &'a [u32_le],
    pub(crate) face_vertices: &'a [u32_le],
    pub(crate) neighbour_starts: &'a [u32_le],
    pub(crate) neighbours: &'a [u32_le],
    pub(crate) neighbour_faces: &'a [u32_le],
}

impl Adjacency<'_> {
    /// Compares the neighbours with the faces. `found` is scratch memory.
    ///
    /// # Complexity
    /// O(C log d) for C face corners and at most d neighbours of a vertex; one bit of scratch
    /// memory per neighbour.
    pub(crate) fn check(&self, found: &mut Vec<u64>) -> Result<(), HullError> {
        // A segment has neighbours, but no faces.
        if self.face_starts.is_empty() {
            return Ok(());
        }
        let (neighbours, corners) = (self.neighbours.len(), self.face_vertices.len());
        if neighbours != corners {
            return Err(HullError::NeighbourCount { found: neighbours, expected: corners });
        }
        found.clear();
        found.resize(neighbours.div_ceil(64), 0);
        let ends = self.face_starts.iter().skip(1).map(|start| start.to_native() as usize).chain([corners]);
        for (face, (start, end)) in self.face_starts.iter().zip(ends).enumerate() {
            let face_vertices = self.face_vertices.get(start.to_native() as usize..end).unwrap_or_default();
            let Some(last) = face_vertices.last() else { continue };
            let mut from = last.to_native();
            for to in face_vertices {
                let to = to.to_native();
                let is_new = self.entry(face as u32, from, to).and_then(|entry| {
                    let (word, bit) = (found.get_mut(entry / 64)?, 1 << (entry % 64));
                    let is_new = *word & bit == 0;
                    *word |= bit;
                    Some(is_new)
                });
                if is_new != Some(true) {
                    return Err(HullError::FaceEdge { face, from, to });
                }
                from = to;
            }
        }
        Ok(())
    }

    /// The entry for the edge `from` → `to` with `face` beside it.
    fn entry(&self, face: u32, from: u32, to: u32) -> Option<usize> {
        let start = self.neighbour_starts.get(from as usize)?.to_native() as usize;
        let end =
            self.neighbour_starts.get(from as usize + 1).map_or(self.neighbours.len(), |s| s.to_native() as usize);
        let run = self.neighbours.get(start..end)?;
        let offset = if run.len() <= SHORT_RUN {
            run.iter().position(|neighbour| neighbour.to_native() == to)?
        } else {
            run.binary_search_by_key(&to, |neighbour| neighbour.to_native()).ok()?
        };
        let entry = start + offset;
        (self.neighbour_faces.get(entry)?.to_native() == face).then_some(entry)
    }
}
