//! What a file's bytes go to, section by section.

use hullmap_format::{
    archive::{ArchivedBlock, ArchivedBvhNode, ArchivedHullRecord, ArchivedPack, ArchivedSpan},
    header::HEADER_LEN,
};

/// One section of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name in `docs/FORMAT.md`.
    pub name: &'static str,
    /// What it is for.
    pub purpose: &'static str,
    /// Elements.
    pub count: usize,
    /// Bytes.
    pub bytes: usize,
}

/// The sections of a file of `byte_len` bytes; the last entry is what no section holds: the root and padding.
pub fn sections(archive: &ArchivedPack, byte_len: usize) -> Vec<Section> {
    let of = |name, purpose, count: usize, size: usize| Section { name, purpose, count, bytes: count * size };
    let mut list = vec![
        of("header", "magic, version, hashes, checksum", 1, HEADER_LEN),
        of("blocks", "candidates of the direction index", archive.blocks.len(), size_of::<ArchivedBlock>()),
        of("source_path", "where the source was", archive.source_path.len(), 1),
        of("options", "how it was baked", archive.options.len(), 1),
        of("names", "the hulls' names", archive.names.len(), 1),
        of("spans", "where each hull's data start", archive.spans.len(), size_of::<ArchivedSpan>()),
        of("hulls", "facts about each hull", archive.hulls.len(), size_of::<ArchivedHullRecord>()),
        of("nodes", "boxes over the hulls", archive.nodes.len(), size_of::<ArchivedBvhNode>()),
        of("vertices", "positions", archive.vertices.len(), 12),
        of("source_vertices", "the vertices' numbers in the source", archive.source_vertices.len(), 4),
        of("face_starts", "where each face's corners start", archive.face_starts.len(), 4),
        of("face_vertices", "the faces' corners", archive.face_vertices.len(), 4),
        of("neighbour_starts", "where each vertex's neighbours start", archive.neighbour_starts.len(), 4),
        of("neighbours", "vertices that share an edge", archive.neighbours.len(), 4),
        of("neighbour_faces", "the face beside each edge", archive.neighbour_faces.len(), 4),
        of("outer_vertices", "a coarse polytope around each hull", archive.outer_vertices.len(), 12),
        of("slots", "words of the direction index", archive.slots.len(), 4),
        of("edges", "directions of the edges, for hints", archive.edges.len(), 2),
    ];
    let known: usize = list.iter().map(|section| section.bytes).sum();
    list.push(of("root", "where the sections are, and padding", 1, byte_len.saturating_sub(known)));
    list
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::super::index_reader::tests::{baked, cloud};

    /// A section that is not listed would be taken for padding.
    #[test]
    fn no_section_is_left_out() {
        let (pack, contents) = baked(cloud(600), IndexKind::TREE);
        let sum: usize = contents.sections.iter().map(|section| section.bytes).sum();
        assert_eq!(sum, pack.byte_len());
        let root = contents.sections.last().unwrap();
        assert!(root.bytes < 160, "{root:?}");
        // This pack records no source and no options; of all else it has something.
        let empty = contents.sections.iter().filter(|section| section.bytes == 0).map(|section| section.name);
        assert_eq!(empty.collect::<Vec<_>>(), ["source_path", "options"]);
    }
}
