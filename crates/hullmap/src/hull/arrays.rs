//! The arrays of a hull as slices of its pack, for bindings and GPU buffers.

#![forbid(unsafe_code)]

use bytemuck::{AnyBitPattern, NoUninit, try_cast_slice};

use super::Hull;

/// The arrays of a hull, in place: what [`Hull::vertices`], [`Hull::faces`] and
/// [`Hull::neighbours`] iterate over. [`Hull::arrays`] returns them.
///
/// Points are in the hull's local frame. Indices of vertices count from the hull's first vertex,
/// positions in an array from the start of that array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullArrays<'a> {
    /// Positions of the vertices.
    pub vertices: &'a [[f32; 3]],
    /// For each vertex, its index in the source file; [`u32::MAX`] for a vertex that the bake
    /// created.
    pub source_vertices: &'a [u32],
    /// For each face, the position in `face_vertices` at which its vertices start. They end where
    /// the next face's start; the last face's end with the array.
    pub face_starts: &'a [u32],
    /// Vertices of the faces, counter-clockwise seen from outside.
    pub face_vertices: &'a [u32],
    /// For each vertex, the position in `neighbours` at which its neighbours start. They end where
    /// the next vertex's start; the last vertex's end with the array.
    pub neighbour_starts: &'a [u32],
    /// Vertices that share an edge with each vertex, ascending.
    pub neighbours: &'a [u32],
}

impl<'a> Hull<'a> {
    /// The arrays of the hull as slices of the pack, without a copy.
    ///
    /// `None` on a big-endian processor, because packs hold little-endian numbers. The iterators
    /// such as [`vertices`](Self::vertices) work everywhere.
    ///
    /// # Complexity
    /// O(1), no allocation.
    pub fn arrays(&self) -> Option<HullArrays<'a>> {
        Some(HullArrays {
            vertices: native(self.vertices)?,
            source_vertices: native(self.source_vertices)?,
            face_starts: native(self.face_starts)?,
            face_vertices: native(self.face_vertices)?,
            neighbour_starts: native(self.neighbour_starts)?,
            neighbours: native(self.neighbours)?,
        })
    }
}

/// Little-endian numbers as native ones, if the processor is little-endian.
fn native<L: NoUninit, N: AnyBitPattern>(numbers: &[L]) -> Option<&[N]> {
    if cfg!(target_endian = "little") { try_cast_slice(numbers).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use shapes::families;

    use crate::pack::Pack;

    #[test]
    fn arrays_match_the_iterators() {
        for positions in [families::rock(60, 1), families::sphere(200, 2), vec![[1.0, 2.0, 3.0]]] {
            let pack = Pack::from_bytes(&hullmap_testkit::packs::tree_bytes(&positions)).unwrap();
            let hull = pack.hull(0).unwrap();
            let Some(arrays) = hull.arrays() else {
                if cfg!(target_endian = "little") {
                    panic!("a little-endian processor has them in place");
                }
                return;
            };
            let run = |starts: &[u32], all: &'_ [u32], at: usize| {
                let end = starts.get(at + 1).map_or(all.len(), |end| *end as usize);
                all[starts[at] as usize..end].to_vec()
            };
            assert!(arrays.vertices.iter().copied().eq(hull.vertices().map(|v| v.to_array())));
            assert_eq!(arrays.face_starts.len(), hull.face_count());
            for face in 0..hull.face_count() {
                let expected: Vec<u32> = hull.face(face as u32).collect();
                assert_eq!(run(arrays.face_starts, arrays.face_vertices, face), expected);
            }
            for vertex in 0..hull.vertex_count() {
                let expected: Vec<u32> = hull.neighbours(vertex as u32).collect();
                assert_eq!(run(arrays.neighbour_starts, arrays.neighbours, vertex), expected);
                let source = hull.source_vertex(vertex as u32).unwrap_or(u32::MAX);
                assert_eq!(arrays.source_vertices[vertex], source);
            }
        }
    }
}
