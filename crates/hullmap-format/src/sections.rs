//! The sections of a pack as slices. Only this file turns the root's numbers into addresses, once.
//!
//! The root is the last structure of the payload. It holds, for each section, an offset relative to
//! the offset's own position, and an element count. [`Sections::read`] copies the root, checks each
//! pair, and cuts the payload into slices. From then on no number in the file is used as an
//! address: the rest are values, and indices that are looked up in slices.
//!
//! The order of sections and their alignment fix every offset, given the counts. So an offset is
//! not merely in range: it equals the only offset that this version writes.
//!
//! # Deviations
//! `rkyv::access` would check the same offsets, but it hands out the root itself, whose accessors
//! follow the offsets in the file again at each call. A file that is mapped and rewritten after the
//! check would then move the slices out of the mapping. The tests compare both.

use std::mem::offset_of;

use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    archive::{
        ArchivedBlock, ArchivedBvhNode, ArchivedHullRecord, ArchivedMassRecord, ArchivedPack, ArchivedQuad,
        ArchivedSpan,
    },
    check_error::CheckError,
    cutter::Cutter,
};

pub use crate::cutter::PAYLOAD_ALIGNMENT;

/// Length of the root in bytes: an offset and a count, four bytes each, for each of 19 sections.
const ROOT_LEN: usize = size_of::<ArchivedPack>();

/// All sections of a pack, in the order of the file. See [`Pack`](crate::archive::Pack) for what
/// each holds.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the fields are those of `archive::Pack`, where each is documented")]
pub struct Sections<'a> {
    pub blocks: &'a [ArchivedBlock],
    pub source_path: &'a [u8],
    pub options: &'a [u8],
    pub names: &'a [u8],
    pub spans: &'a [ArchivedSpan],
    pub hulls: &'a [ArchivedHullRecord],
    pub masses: &'a [ArchivedMassRecord],
    pub nodes: &'a [ArchivedBvhNode],
    pub vertices: &'a [[f32_le; 3]],
    pub source_vertices: &'a [u32_le],
    pub face_starts: &'a [u32_le],
    pub face_vertices: &'a [u32_le],
    pub quads: &'a [ArchivedQuad],
    pub neighbour_starts: &'a [u32_le],
    pub neighbours: &'a [u32_le],
    pub neighbour_faces: &'a [u32_le],
    pub outer_vertices: &'a [[f32_le; 3]],
    pub slots: &'a [u32_le],
    pub edges: &'a [i16_le],
}

impl<'a> Sections<'a> {
    /// Cuts `payload`, all bytes after the header, into its sections.
    ///
    /// `payload` must start on a multiple of [`PAYLOAD_ALIGNMENT`] bytes in memory. Nothing but the
    /// root is read.
    ///
    /// # Errors
    /// The payload is misaligned or shorter than the root. A section does not start where the
    /// section before it ends, or ends after the payload. Bytes are left over.
    ///
    /// # Complexity
    /// O(1).
    pub fn read(payload: &'a [u8]) -> Result<Self, CheckError> {
        let mut cutter = Cutter::<ROOT_LEN>::new(payload)?;
        let sections = Self {
            blocks: cutter.cut("blocks", offset_of!(ArchivedPack, blocks))?,
            source_path: cutter.cut("source_path", offset_of!(ArchivedPack, source_path))?,
            options: cutter.cut("options", offset_of!(ArchivedPack, options))?,
            names: cutter.cut("names", offset_of!(ArchivedPack, names))?,
            spans: cutter.cut("spans", offset_of!(ArchivedPack, spans))?,
            hulls: cutter.cut("hulls", offset_of!(ArchivedPack, hulls))?,
            masses: cutter.cut("masses", offset_of!(ArchivedPack, masses))?,
            nodes: cutter.cut("nodes", offset_of!(ArchivedPack, nodes))?,
            vertices: cutter.cut("vertices", offset_of!(ArchivedPack, vertices))?,
            source_vertices: cutter.cut("source_vertices", offset_of!(ArchivedPack, source_vertices))?,
            face_starts: cutter.cut("face_starts", offset_of!(ArchivedPack, face_starts))?,
            face_vertices: cutter.cut("face_vertices", offset_of!(ArchivedPack, face_vertices))?,
            quads: cutter.cut("quads", offset_of!(ArchivedPack, quads))?,
            neighbour_starts: cutter.cut("neighbour_starts", offset_of!(ArchivedPack, neighbour_starts))?,
            neighbours: cutter.cut("neighbours", offset_of!(ArchivedPack, neighbours))?,
            neighbour_faces: cutter.cut("neighbour_faces", offset_of!(ArchivedPack, neighbour_faces))?,
            outer_vertices: cutter.cut("outer_vertices", offset_of!(ArchivedPack, outer_vertices))?,
            slots: cutter.cut("slots", offset_of!(ArchivedPack, slots))?,
            edges: cutter.cut("edges", offset_of!(ArchivedPack, edges))?,
        };
        cutter.finish()?;
        Ok(sections)
    }

    /// Whether this is a lean pack: one without neighbours, quads and edges, and without the faces
    /// of hulls of more than [`LEAN_FACES`](crate::archive::LEAN_FACES) vertices. Every other pack
    /// has a start of neighbours for each vertex.
    pub fn is_lean(&self) -> bool {
        self.neighbour_starts.is_empty()
    }

    /// The options that shaped the bake, then a line for each warning; empty if they are not UTF-8.
    pub fn options_text(&self) -> &'a str {
        std::str::from_utf8(self.options).unwrap_or_default()
    }
}

const _: () = assert!(ROOT_LEN == 19 * 8, "the root is 19 offsets and counts without padding");

#[cfg(test)]
mod tests {
    use rkyv::util::AlignedVec;

    use super::*;
    use crate::{
        archive::{Block, BvhNode, HullRecord, LANES, MassRecord, Pack, Quad, Span},
        check,
    };

    fn sample() -> AlignedVec<PAYLOAD_ALIGNMENT> {
        let block = Block { x: [1.0; LANES], y: [2.0; LANES], z: [3.0; LANES], vertex: [4; LANES] };
        let pack = Pack {
            blocks: vec![block; 2],
            source_path: b"a/b.obj".to_vec(),
            options: b"x".to_vec(),
            names: b"abcd".to_vec(),
            spans: vec![Span::default(); 3],
            hulls: vec![HullRecord { diameter: 7.0, ..HullRecord::default() }; 2],
            masses: vec![MassRecord { volume: 5.0, ..MassRecord::default() }; 2],
            nodes: vec![BvhNode::default(); 3],
            vertices: vec![[1.0, 2.0, 3.0]; 5],
            source_vertices: vec![9; 5],
            face_starts: vec![1; 2],
            face_vertices: vec![],
            quads: vec![Quad { face: 3, ..Quad::default() }; 2],
            neighbour_starts: vec![3; 5],
            neighbours: vec![4; 6],
            neighbour_faces: vec![5; 6],
            outer_vertices: vec![[0.5; 3]; 4],
            slots: vec![6; 7],
            edges: vec![-1; 10],
        };
        let mut payload = AlignedVec::new();
        payload.extend_from_slice(&rkyv::to_bytes::<rkyv::rancor::Error>(&pack).unwrap());
        payload
    }

    #[test]
    fn sections_match_rkyv() {
        fn same<T>(found: &[T], expected: &[T]) {
            assert_eq!((found.as_ptr(), found.len()), (expected.as_ptr(), expected.len()));
        }
        let payload = sample();
        let found = Sections::read(&payload).unwrap();
        let expected = rkyv::access::<ArchivedPack, rkyv::rancor::Error>(&payload).unwrap();
        same(found.blocks, &expected.blocks);
        same(found.source_path, &expected.source_path);
        same(found.options, &expected.options);
        same(found.names, &expected.names);
        same(found.spans, &expected.spans);
        same(found.hulls, &expected.hulls);
        same(found.masses, &expected.masses);
        same(found.nodes, &expected.nodes);
        same(found.vertices, &expected.vertices);
        same(found.source_vertices, &expected.source_vertices);
        same(found.face_starts, &expected.face_starts);
        same(found.face_vertices, &expected.face_vertices);
        same(found.quads, &expected.quads);
        same(found.neighbour_starts, &expected.neighbour_starts);
        same(found.neighbours, &expected.neighbours);
        same(found.neighbour_faces, &expected.neighbour_faces);
        same(found.outer_vertices, &expected.outer_vertices);
        same(found.slots, &expected.slots);
        same(found.edges, &expected.edges);
        assert_eq!(found.hulls[1].diameter.to_native(), 7.0);
        assert_eq!(found.edges[8].to_native(), -1);
    }

    #[test]
    fn every_changed_root_is_rejected() {
        let payload = sample();
        let root_at = payload.len() - ROOT_LEN;
        for at in (root_at..payload.len()).step_by(4) {
            let old = u32::from_le_bytes(payload[at..at + 4].try_into().unwrap());
            for new in [0, 1, old ^ 1, old ^ 4, old ^ 64, old ^ 1 << 20, old ^ 1 << 31, u32::MAX, i32::MAX as u32] {
                let mut changed = payload.clone();
                changed[at..at + 4].copy_from_slice(&new.to_le_bytes());
                // No section of the sample is followed by a gap, so no section can grow into one.
                // If a section is shorter, its last bytes become a gap, which must be zero.
                let gaps = |pack: Sections<'_>| check::gaps(&pack, &changed);
                let is_rejected = Sections::read(&changed).and_then(gaps).is_err();
                assert!(is_rejected || new == old, "byte {}: {old:#x} to {new:#x}", at - root_at);
            }
        }
    }

    #[test]
    fn payloads_of_every_other_length_are_rejected() {
        let payload = sample();
        for len in 0..payload.len() {
            assert!(Sections::read(&payload[..len]).is_err(), "{len} bytes");
        }
        let mut longer = payload.clone();
        longer.extend_from_slice(&[0; 4]);
        assert!(Sections::read(&longer).is_err());
        assert_eq!(Sections::read(&longer[4..]).unwrap_err(), CheckError::Misaligned);
    }
}
