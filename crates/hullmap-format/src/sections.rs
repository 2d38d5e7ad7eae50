//! The sections of a pack as slices. Only this file turns the root's numbers into addresses, once.
//!
//! [`Sections::read`] copies the root, checks each offset and count, and cuts the payload into
//! slices. All other numbers are values, or indices that are looked up in slices. Further sections,
//! if any, follow the sections of every pack, with entries in front of the root.
//!
//! # Deviations
//! `rkyv::access` would check the same offsets, but its accessors follow those in the file again at
//! each call: a mapped file that is rewritten would move the slices out of the mapping. It also
//! rejects extended packs. The tests compare both.

use std::mem::offset_of;

use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    archive::{
        ArchivedBlock, ArchivedBvhNode, ArchivedExtendedPack, ArchivedHullRecord, ArchivedMassRecord, ArchivedPack,
        ArchivedPrimitiveRecord, ArchivedQuad, ArchivedSpan, ArchivedVoidsRecord,
    },
    check_error::CheckError,
    cutter::Cutter,
};

pub use crate::cutter::PAYLOAD_ALIGNMENT;

/// Length of the root in bytes: an offset and a count, four bytes each, for each of 19 sections.
const ROOT_LEN: usize = size_of::<ArchivedPack>();

/// Length of the root with the entries of further sections in front, in bytes.
const EXTENDED_ROOT_LEN: usize = size_of::<ArchivedExtendedPack>();

/// All sections of a pack, in the order of the file. See
/// [`ExtendedPack`](crate::archive::ExtendedPack) for what each holds.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "each field is documented in `archive::ExtendedPack`")]
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
    pub voids: &'a [ArchivedVoidsRecord],
    pub primitives: &'a [ArchivedPrimitiveRecord],
}

macro_rules! field {
    ($section:ident) => {
        offset_of!(ArchivedExtendedPack, pack) + offset_of!(ArchivedPack, $section)
    };
}

impl<'a> Sections<'a> {
    /// Cuts `payload`, all bytes after the header, into its sections, in O(1). `payload` must start
    /// on a multiple of [`PAYLOAD_ALIGNMENT`] bytes in memory. Nothing but the root is read.
    ///
    /// # Errors
    /// The payload is misaligned or shorter than the root. A section does not start where the
    /// section before it ends, or ends after the payload. Bytes are left over.
    pub fn read(payload: &'a [u8]) -> Result<Self, CheckError> {
        let mut cutter = Cutter::<EXTENDED_ROOT_LEN>::new(payload, ROOT_LEN)?;
        let mut sections = Self {
            blocks: cutter.cut("blocks", field!(blocks))?,
            source_path: cutter.cut("source_path", field!(source_path))?,
            options: cutter.cut("options", field!(options))?,
            names: cutter.cut("names", field!(names))?,
            spans: cutter.cut("spans", field!(spans))?,
            hulls: cutter.cut("hulls", field!(hulls))?,
            masses: cutter.cut("masses", field!(masses))?,
            nodes: cutter.cut("nodes", field!(nodes))?,
            vertices: cutter.cut("vertices", field!(vertices))?,
            source_vertices: cutter.cut("source_vertices", field!(source_vertices))?,
            face_starts: cutter.cut("face_starts", field!(face_starts))?,
            face_vertices: cutter.cut("face_vertices", field!(face_vertices))?,
            quads: cutter.cut("quads", field!(quads))?,
            neighbour_starts: cutter.cut("neighbour_starts", field!(neighbour_starts))?,
            neighbours: cutter.cut("neighbours", field!(neighbours))?,
            neighbour_faces: cutter.cut("neighbour_faces", field!(neighbour_faces))?,
            outer_vertices: cutter.cut("outer_vertices", field!(outer_vertices))?,
            slots: cutter.cut("slots", field!(slots))?,
            edges: cutter.cut("edges", field!(edges))?,
            voids: &[],
            primitives: &[],
        };
        if cutter.has_more() {
            // Damage to the root of any pack is reported as such.
            let as_usual = cutter.finish();
            cutter.extend_root(EXTENDED_ROOT_LEN - ROOT_LEN);
            let voids = cutter.cut("voids", offset_of!(ArchivedExtendedPack, voids));
            let primitives = cutter.cut("primitives", offset_of!(ArchivedExtendedPack, primitives));
            let (Ok(voids), Ok(primitives)) = (voids, primitives) else { return as_usual.map(|()| sections) };
            (sections.voids, sections.primitives) = (voids, primitives);
            if !sections.is_extended() {
                return as_usual.map(|()| sections);
            }
        }
        cutter.finish()?;
        Ok(sections)
    }

    /// Whether the pack has sections that only some packs have.
    pub fn is_extended(&self) -> bool {
        !self.voids.is_empty() || !self.primitives.is_empty()
    }

    /// Whether this is a lean pack: one without neighbours, quads and edges, and without the faces
    /// of hulls of more than [`LEAN_FACES`](crate::archive::LEAN_FACES) vertices.
    pub fn is_lean(&self) -> bool {
        self.neighbour_starts.is_empty()
    }

    /// The options that shaped the bake, then a line for each warning; empty if they are not UTF-8.
    pub fn options_text(&self) -> &'a str {
        std::str::from_utf8(self.options).unwrap_or_default()
    }
}

const _: () = assert!(ROOT_LEN == 19 * 8, "the root is 19 offsets and counts without padding");
const _: () = assert!(EXTENDED_ROOT_LEN == 21 * 8, "the extended root is 21 offsets and counts without padding");
const _: () = assert!(offset_of!(ArchivedExtendedPack, pack) == 16, "the root of all packs is last");

#[cfg(test)]
mod tests {
    use rkyv::util::AlignedVec;

    use super::*;
    use crate::{
        archive::{
            Block, BvhNode, ExtendedPack, HullRecord, LANES, MassRecord, Pack, PrimitiveRecord, Quad, Span, VoidsRecord,
        },
        check,
    };

    fn sample() -> AlignedVec<PAYLOAD_ALIGNMENT> {
        aligned(&rkyv::to_bytes::<rkyv::rancor::Error>(&sample_pack()).unwrap())
    }

    fn sample_pack() -> Pack {
        let block = Block { x: [1.0; LANES], y: [2.0; LANES], z: [3.0; LANES], vertex: [4; LANES] };
        Pack {
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
        }
    }

    fn aligned(bytes: &[u8]) -> AlignedVec<PAYLOAD_ALIGNMENT> {
        let mut payload = AlignedVec::new();
        payload.extend_from_slice(bytes);
        payload
    }

    fn extended_sample() -> AlignedVec<PAYLOAD_ALIGNMENT> {
        let record = |hull: u32| VoidsRecord { hull, share: 0.25, error: 0.5 };
        let extended = ExtendedPack {
            voids: vec![record(3), record(7)],
            primitives: vec![PrimitiveRecord::default(); 3],
            pack: sample_pack(),
        };
        aligned(&rkyv::to_bytes::<rkyv::rancor::Error>(&extended).unwrap())
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
    fn extended_packs_have_the_same_sections_and_more() {
        let (usual, extended) = (sample(), extended_sample());
        let [found, expected] = [&extended, &usual].map(|payload| Sections::read(payload).unwrap());
        assert!(found.is_extended() && !expected.is_extended());
        assert_eq!((found.vertices, found.edges), (expected.vertices, expected.edges));
        assert_eq!(found.hulls.len(), expected.hulls.len());
        let voids: Vec<u32> = found.voids.iter().map(|record| record.hull.to_native()).collect();
        assert_eq!((voids, found.primitives.len()), (vec![3, 7], 3));
        // All sections before the root have the same bytes.
        let shared = usual.len() - ROOT_LEN;
        assert_eq!(extended[..shared], usual[..shared]);
        // Without records, a pack is not extended.
        let none = ExtendedPack { pack: sample_pack(), ..ExtendedPack::default() };
        let none = aligned(&rkyv::to_bytes::<rkyv::rancor::Error>(&none).unwrap());
        assert!(matches!(Sections::read(&none), Err(CheckError::Section { section: "root", .. })));
    }

    #[test]
    fn every_changed_root_is_rejected() {
        for (payload, root_len) in [(sample(), ROOT_LEN), (extended_sample(), EXTENDED_ROOT_LEN)] {
            let root_at = payload.len() - root_len;
            for at in (root_at..payload.len()).step_by(4) {
                let old = u32::from_le_bytes(payload[at..at + 4].try_into().unwrap());
                for new in [0, 1, old ^ 1, old ^ 4, old ^ 64, old ^ 1 << 20, old ^ 1 << 31, u32::MAX, i32::MAX as u32] {
                    let mut changed = payload.clone();
                    changed[at..at + 4].copy_from_slice(&new.to_le_bytes());
                    // No section of the sample is followed by a gap, so no section can grow into
                    // one. If a section is shorter, its last bytes become a gap, which must be
                    // zero.
                    let gaps = |pack: Sections<'_>| check::gaps(&pack, &changed);
                    let is_rejected = Sections::read(&changed).and_then(gaps).is_err();
                    assert!(is_rejected || new == old, "byte {}: {old:#x} to {new:#x}", at - root_at);
                }
            }
        }
    }

    #[test]
    fn payloads_of_every_other_length_are_rejected() {
        for mut payload in [sample(), extended_sample()] {
            for len in 0..payload.len() {
                assert!(Sections::read(&payload[..len]).is_err(), "{len} bytes");
            }
            payload.extend_from_slice(&[0; 4]);
            assert!(Sections::read(&payload).is_err());
            assert_eq!(Sections::read(&payload[4..]).unwrap_err(), CheckError::Misaligned);
        }
    }
}
