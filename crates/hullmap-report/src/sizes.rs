//! Bytes of a file by section.

use hullmap_format::{
    archive::{ArchivedBlock, ArchivedBvhNode, ArchivedHullRecord, ArchivedQuad, ArchivedSpan},
    header::HEADER_LEN,
    sections::Sections,
};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name in `docs/contributors/FORMAT.md`.
    pub name: &'static str,
    pub purpose: &'static str,
    pub count: usize,
    pub bytes: usize,
}

/// The sections of a file of `byte_len` bytes. The last entry is the rest: root and padding.
pub fn sections(archive: &Sections<'_>, byte_len: usize) -> Vec<Section> {
    let of = |name, purpose, count: usize, size: usize| Section { name, purpose, count, bytes: count * size };
    let mut list = vec![
        of("header", "magic, version, hashes, checksum", 1, HEADER_LEN),
        of("blocks", "candidates of the direction index", archive.blocks.len(), size_of::<ArchivedBlock>()),
        of("source_path", "path of the source", archive.source_path.len(), 1),
        of("options", "build options and warnings", archive.options.len(), 1),
        of("names", "the hulls' names", archive.names.len(), 1),
        of("spans", "start of each hull's data", archive.spans.len(), size_of::<ArchivedSpan>()),
        of("hulls", "record of each hull", archive.hulls.len(), size_of::<ArchivedHullRecord>()),
        of("nodes", "BVH over the hulls", archive.nodes.len(), size_of::<ArchivedBvhNode>()),
        of("vertices", "positions", archive.vertices.len(), 12),
        of("source_vertices", "source vertex of each vertex", archive.source_vertices.len(), 4),
        of("face_starts", "start of each face's corners", archive.face_starts.len(), 4),
        of("face_vertices", "corners of the faces", archive.face_vertices.len(), 4),
        of("quads", "best four corners of large faces", archive.quads.len(), size_of::<ArchivedQuad>()),
        of("neighbour_starts", "start of each vertex's neighbours", archive.neighbour_starts.len(), 4),
        of("neighbours", "vertices that share an edge", archive.neighbours.len(), 4),
        of("neighbour_faces", "face beside each edge", archive.neighbour_faces.len(), 4),
        of("outer_vertices", "outer hull of each hull", archive.outer_vertices.len(), 12),
        of("slots", "words of the direction index", archive.slots.len(), 4),
        of("edges", "edge directions, for hints", archive.edges.len(), 2),
    ];
    let known: usize = list.iter().map(|section| section.bytes).sum();
    list.push(of("root", "positions of the sections, and padding", 1, byte_len.saturating_sub(known)));
    list
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use crate::test_packs::{baked, cloud};

    #[test]
    fn no_section_is_left_out() {
        let (pack, contents) = baked(cloud(600), IndexKind::Tree);
        let sum: usize = contents.sections.iter().map(|section| section.bytes).sum();
        assert_eq!(sum, pack.byte_len());
        let root = contents.sections.last().unwrap();
        assert!(root.bytes < 160, "{root:?}");
        let empty = contents.sections.iter().filter(|section| section.bytes == 0).map(|section| section.name);
        assert_eq!(empty.collect::<Vec<_>>(), ["source_path", "options"]);
    }
}
