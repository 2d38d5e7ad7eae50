//! The sections of a pack, each freed as soon as it is serialised, with the archive layout of
//! [`Pack`]. Writing a pack of a million vertices takes half as much memory this way.

use std::cell::Cell;

use hullmap_format::archive::{Block, BvhNode, HullRecord, MassRecord, Pack, PrimitiveRecord, Quad, Span, VoidsRecord};
use rkyv::{
    Archive, Place, Serialize,
    rancor::Fallible,
    ser::{Allocator, Writer},
    vec::{ArchivedVec, VecResolver},
};

/// A list that is empty after it was serialised.
struct Section<T>(Cell<Vec<T>>);

impl<T: Archive> Archive for Section<T> {
    type Archived = ArchivedVec<T::Archived>;
    type Resolver = (VecResolver, usize);

    fn resolve(&self, (place, len): Self::Resolver, out: Place<Self::Archived>) {
        ArchivedVec::resolve_from_len(len, place, out);
    }
}

impl<T, S> Serialize<S> for Section<T>
where
    T: Serialize<S>,
    S: Fallible + Allocator + Writer + ?Sized,
{
    fn serialize(&self, serializer: &mut S) -> Result<Self::Resolver, S::Error> {
        let list = self.0.take();
        Ok((ArchivedVec::<T::Archived>::serialize_from_slice(&list, serializer)?, list.len()))
    }
}

/// [`Pack`], which can be serialised once.
#[derive(Archive, Serialize)]
pub struct Sections {
    blocks: Section<Block>,
    source_path: Section<u8>,
    options: Section<u8>,
    names: Section<u8>,
    spans: Section<Span>,
    hulls: Section<HullRecord>,
    masses: Section<MassRecord>,
    nodes: Section<BvhNode>,
    vertices: Section<[f32; 3]>,
    source_vertices: Section<u32>,
    face_starts: Section<u32>,
    face_vertices: Section<u32>,
    quads: Section<Quad>,
    neighbour_starts: Section<u32>,
    neighbours: Section<u32>,
    neighbour_faces: Section<u32>,
    outer_vertices: Section<[f32; 3]>,
    slots: Section<u32>,
    edges: Section<i16>,
}

/// [`ExtendedPack`](hullmap_format::archive::ExtendedPack), which can be serialised once.
#[derive(Archive)]
pub struct ExtendedSections {
    voids: Section<VoidsRecord>,
    primitives: Section<PrimitiveRecord>,
    pack: Sections,
}

impl ExtendedSections {
    pub fn new(pack: Pack, voids: Vec<VoidsRecord>, primitives: Vec<PrimitiveRecord>) -> Self {
        Self { voids: section(voids), primitives: section(primitives), pack: Sections::from(pack) }
    }
}

impl<S> Serialize<S> for ExtendedSections
where
    S: Fallible + Allocator + Writer + ?Sized,
{
    fn serialize(&self, serializer: &mut S) -> Result<Self::Resolver, S::Error> {
        let pack = self.pack.serialize(serializer)?;
        let voids = self.voids.serialize(serializer)?;
        Ok(ExtendedSectionsResolver { voids, primitives: self.primitives.serialize(serializer)?, pack })
    }
}

fn section<T>(list: Vec<T>) -> Section<T> {
    Section(Cell::new(list))
}

impl From<Pack> for Sections {
    fn from(pack: Pack) -> Self {
        // Without `..`, so that a new field is not forgotten.
        let Pack {
            blocks,
            source_path,
            options,
            names,
            spans,
            hulls,
            masses,
            nodes,
            vertices,
            source_vertices,
            face_starts,
            face_vertices,
            quads,
            neighbour_starts,
            neighbours,
            neighbour_faces,
            outer_vertices,
            slots,
            edges,
        } = pack;
        Self {
            blocks: section(blocks),
            source_path: section(source_path),
            options: section(options),
            names: section(names),
            spans: section(spans),
            hulls: section(hulls),
            masses: section(masses),
            nodes: section(nodes),
            vertices: section(vertices),
            source_vertices: section(source_vertices),
            face_starts: section(face_starts),
            face_vertices: section(face_vertices),
            quads: section(quads),
            neighbour_starts: section(neighbour_starts),
            neighbours: section(neighbours),
            neighbour_faces: section(neighbour_faces),
            outer_vertices: section(outer_vertices),
            slots: section(slots),
            edges: section(edges),
        }
    }
}

#[cfg(test)]
mod tests {
    use hullmap_format::archive::{ExtendedPack, LANES};
    use rkyv::{api::high::to_bytes_in, rancor};

    use super::*;

    #[test]
    fn sections_have_the_bytes_of_a_pack() {
        let span = |at: u32| Span { name: at, vertex: 2 * at, face: 3, quad: at, ..Span::default() };
        let small = Pack { names: b"one".to_vec(), spans: vec![span(0), span(1)], ..Pack::default() };
        let mut large = Pack {
            source_path: b"a/b.obj".to_vec(),
            options: b"x".to_vec(),
            hulls: vec![HullRecord { diameter: 2.5, rank: 3, ..HullRecord::default() }; 3],
            masses: vec![MassRecord { volume: 1.5, ..MassRecord::default() }; 2],
            nodes: vec![BvhNode::default(); 5],
            vertices: vec![[1.0, -2.0, 3.5]; 7],
            outer_vertices: vec![[0.5; 3]; 2],
            quads: vec![Quad::default(); 2],
            blocks: vec![Block { x: [1.0; LANES], y: [2.0; LANES], z: [3.0; LANES], vertex: [7; LANES] }; 3],
            ..small.clone()
        };
        for (at, list) in [
            &mut large.source_vertices,
            &mut large.face_starts,
            &mut large.face_vertices,
            &mut large.neighbour_starts,
            &mut large.neighbours,
            &mut large.neighbour_faces,
            &mut large.slots,
        ]
        .into_iter()
        .enumerate()
        {
            *list = (0..at as u32 * 3 + 1).map(|i| i * 7 + at as u32).collect();
        }
        large.edges = vec![-1, 2, 3, -4, 5];
        for pack in [Pack::default(), small, large] {
            let expected = to_bytes_in::<_, rancor::Error>(&pack, vec![0; 64]).unwrap();
            let found = to_bytes_in::<_, rancor::Error>(&Sections::from(pack.clone()), vec![0; 64]).unwrap();
            assert_eq!(found, expected);
            let voids = vec![VoidsRecord { hull: 3, share: 0.5, error: 0.25 }; 2];
            let primitives = vec![PrimitiveRecord { hull: 1, sizes: [1.0; 3], ..PrimitiveRecord::default() }; 3];
            let extended = ExtendedPack { voids: voids.clone(), primitives: primitives.clone(), pack: pack.clone() };
            let expected = to_bytes_in::<_, rancor::Error>(&extended, vec![0; 64]).unwrap();
            let extended = ExtendedSections::new(pack, voids, primitives);
            assert_eq!(to_bytes_in::<_, rancor::Error>(&extended, vec![0; 64]).unwrap(), expected);
        }
    }
}
