//! Whether a file keeps the promises that the runtime relies on.
//!
//! Two depths. [`structure`] looks only at what is needed to hand out a hull's slices: rkyv's own bounds, and the spans;
//! its cost grows with the number of hulls. [`contents`] looks at every number that a query could follow or return.

use rkyv::{
    rancor,
    rend::{f32_le, u32_le},
};

use crate::{
    archive::{ArchivedHullRecord, ArchivedPack, ArchivedSpan, LANES, NO_SOURCE_VERTEX, index_kind},
    bvh, edge,
    header::HEADER_LEN,
    walk::{Branches, Cost, IndexError, Shape, walk},
};

/// Why an archive is not one that the runtime may answer from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckError {
    /// rkyv finds a vector outside the file, or two that overlap.
    #[error("the archive is not one: {0}; bake the source again")]
    Archive(String),
    /// There are no hulls, or the spans do not divide the sections.
    #[error("hull {hull}: its runs of {section} do not follow one another to the section's end; bake the source again")]
    Spans {
        /// The hull.
        hull: usize,
        /// The section.
        section: &'static str,
    },
    /// No hulls.
    #[error("the pack holds no hull; bake the source again")]
    NoHulls,
    /// Bytes stand between the sections, or after the last one, that no section owns.
    #[error("{what} do not stand where this version writes them; bake the source again")]
    Layout {
        /// Which bytes.
        what: &'static str,
    },
    /// A name or the source's path is not UTF-8.
    #[error("{what} is not UTF-8; bake the source again")]
    Text {
        /// Which text.
        what: &'static str,
    },
    /// A hull's numbers contradict each other.
    #[error("hull {hull}: {what}; bake the source again")]
    Hull {
        /// The hull.
        hull: usize,
        /// What is wrong.
        what: &'static str,
    },
    /// The tree of boxes over the hulls is not one.
    #[error("the tree of boxes over the hulls: {what}; bake the source again")]
    Boxes {
        /// What is wrong.
        what: &'static str,
    },
    /// A hull's direction index is not one.
    #[error("hull {hull}: {source}; bake the source again")]
    Index {
        /// The hull.
        hull: usize,
        /// What is wrong.
        source: IndexError,
    },
}

/// The archive in `payload` (all bytes behind the header), its vectors and spans checked.
///
/// `payload` must start on a multiple of 64 bytes in memory.
///
/// # Errors
/// A vector outside the payload; no hulls; spans that are not ascending or do not end where the sections end.
///
/// # Complexity
/// O(number of hulls).
pub fn structure(payload: &[u8]) -> Result<&ArchivedPack, CheckError> {
    let pack =
        rkyv::access::<ArchivedPack, rancor::Error>(payload).map_err(|error| CheckError::Archive(error.to_string()))?;
    if pack.hulls.is_empty() {
        return Err(CheckError::NoHulls);
    }
    layout(pack, payload)?;
    spans(pack)?;
    Ok(pack)
}

/// Checks that the sections stand where the baker puts them: in order, each at the next multiple of its alignment, the
/// first on a cache line, the root behind the last, and zeros in the gaps. So equal packs are equal bytes.
fn layout(pack: &ArchivedPack, payload: &[u8]) -> Result<(), CheckError> {
    fn section<T>(section: &[T]) -> (usize, usize, usize) {
        (section.as_ptr().addr(), size_of_val(section), align_of::<T>())
    }
    let start = payload.as_ptr().addr();
    if !start.is_multiple_of(BLOCK_ALIGNMENT) {
        return Err(CheckError::Layout { what: "the blocks" });
    }
    let sections = [
        section(&pack.blocks),
        section(&pack.source_path),
        section(&pack.options),
        section(&pack.names),
        section(&pack.spans),
        section(&pack.hulls),
        section(&pack.nodes),
        section(&pack.vertices),
        section(&pack.source_vertices),
        section(&pack.face_starts),
        section(&pack.face_vertices),
        section(&pack.neighbour_starts),
        section(&pack.neighbours),
        section(&pack.neighbour_faces),
        section(&pack.outer_vertices),
        section(&pack.slots),
        section(&pack.edges),
        section(std::slice::from_ref(pack)),
    ];
    let mut end = start;
    for (at, len, alignment) in sections {
        // rkyv gives an empty section the place where it would have stood.
        if at != end.next_multiple_of(alignment) {
            return Err(CheckError::Layout { what: "the sections" });
        }
        if payload[end - start..at - start].iter().any(|byte| *byte != 0) {
            return Err(CheckError::Layout { what: "the bytes between sections" });
        }
        end = at + len;
    }
    if end == start + payload.len() { Ok(()) } else { Err(CheckError::Layout { what: "the last bytes" }) }
}

/// One number of a span, the section it starts in, and that section's length.
type SpanField = (&'static str, fn(&ArchivedSpan) -> u32, usize);

fn spans(pack: &ArchivedPack) -> Result<(), CheckError> {
    let hull_count = pack.hulls.len();
    let fields: [SpanField; 9] = [
        ("names", |s| s.name.to_native(), pack.names.len()),
        ("vertices", |s| s.vertex.to_native(), pack.vertices.len()),
        ("faces", |s| s.face.to_native(), pack.face_starts.len()),
        ("face vertices", |s| s.face_vertex.to_native(), pack.face_vertices.len()),
        ("neighbours", |s| s.neighbour.to_native(), pack.neighbours.len()),
        ("edges", |s| s.edge.to_native(), pack.edges.len()),
        ("slots", |s| s.slot.to_native(), pack.slots.len()),
        ("blocks", |s| s.block.to_native(), pack.blocks.len()),
        ("outer vertices", |s| s.outer.to_native(), pack.outer_vertices.len()),
    ];
    // Readers are promised a hull.
    if hull_count == 0 || pack.spans.len() != hull_count + 1 {
        return Err(CheckError::Spans { hull: hull_count, section: "spans" });
    }
    if pack.source_vertices.len() != pack.vertices.len() {
        return Err(CheckError::Spans { hull: hull_count, section: "source vertices" });
    }
    if pack.neighbour_starts.len() != pack.vertices.len() {
        return Err(CheckError::Spans { hull: hull_count, section: "neighbour starts" });
    }
    if pack.neighbour_faces.len() != pack.neighbours.len() {
        return Err(CheckError::Spans { hull: hull_count, section: "neighbour faces" });
    }
    for (section, start, len) in fields {
        let mut last = 0;
        for (hull, span) in pack.spans.iter().enumerate() {
            let at = start(span);
            if at < last || (hull == 0 && at != 0) {
                return Err(CheckError::Spans { hull, section });
            }
            last = at;
        }
        if last as usize != len {
            return Err(CheckError::Spans { hull: hull_count, section });
        }
    }
    Ok(())
}

/// Checks every number that a query could follow or return, in an archive that passed [`structure`].
///
/// # Errors
/// The first hull that contradicts itself, and how.
///
/// # Complexity
/// One pass over the archive.
pub fn contents(pack: &ArchivedPack) -> Result<(), CheckError> {
    std::str::from_utf8(&pack.source_path).map_err(|_| CheckError::Text { what: "the source's path" })?;
    std::str::from_utf8(&pack.options).map_err(|_| CheckError::Text { what: "the options" })?;
    std::str::from_utf8(&pack.names).map_err(|_| CheckError::Text { what: "a hull's name" })?;
    pack.spans.windows(2).zip(pack.hulls.iter()).enumerate().try_for_each(|(hull, (spans, record))| {
        let [start, end] = spans else { return Ok(()) };
        HullCheck { hull, pack, start, end, record }.run()
    })?;
    bvh::check(pack).map_err(|what| CheckError::Boxes { what })
}

struct HullCheck<'a> {
    hull: usize,
    pack: &'a ArchivedPack,
    start: &'a ArchivedSpan,
    end: &'a ArchivedSpan,
    record: &'a ArchivedHullRecord,
}

impl HullCheck<'_> {
    fn run(&self) -> Result<(), CheckError> {
        self.name()?;
        self.numbers()?;
        self.part()?;
        self.vertices()?;
        self.faces()?;
        self.neighbours()?;
        self.edges()?;
        self.outer()?;
        self.index()?;
        self.blocks()
    }

    fn require(&self, holds: bool, what: &'static str) -> Result<(), CheckError> {
        if holds { Ok(()) } else { Err(CheckError::Hull { hull: self.hull, what }) }
    }

    fn vertex_count(&self) -> u32 {
        self.end.vertex.to_native() - self.start.vertex.to_native()
    }

    fn block_count(&self) -> u32 {
        self.end.block.to_native() - self.start.block.to_native()
    }

    fn name(&self) -> Result<(), CheckError> {
        let name = &self.pack.names[range(self.start.name.to_native(), self.end.name.to_native())];
        self.require(std::str::from_utf8(name).is_ok(), "its name is not UTF-8")
    }

    fn numbers(&self) -> Result<(), CheckError> {
        let r = self.record;
        let lengths = [r.inner_radius, r.outer_radius, r.diameter, r.volume, r.surface_area, r.containment_error];
        let lengths = lengths.into_iter().chain([r.outer_error, r.uncovered]);
        // `>=` is false for NaN.
        let sound = lengths.into_iter().all(|l| l.to_native() >= 0.0 && l.to_native().is_finite())
            && r.centroid.iter().chain(&r.interior_point).chain(&r.second_moments).all(|c| c.to_native().is_finite())
            && r.origin.iter().all(|c| c.to_native().is_finite())
            && r.bounds_min.iter().chain(&r.bounds_max).all(|c| c.to_native().is_finite());
        self.require(sound, "a length is negative or a number is not finite")?;
        let rank = r.rank.to_native();
        self.require(rank <= 3, "its rank is not 0 to 3")?;
        let fits = if rank == 0 { self.vertex_count() == 1 } else { self.vertex_count() > rank };
        self.require(fits, "its rank and its number of vertices contradict each other")?;
        self.require(rank > 1 || self.vertex_count() <= 2, "a segment has more than two vertices")?;
        self.require(r.inner_radius <= r.outer_radius, "its inner ball is larger than its outer one")
    }

    /// Parts of an object are counted from 0 on, one after the other, in one frame.
    fn part(&self) -> Result<(), CheckError> {
        let before = self.hull.checked_sub(1).map(|before| &self.pack.hulls[before]);
        let part = self.record.part.to_native();
        let follows = part == 0 || before.is_some_and(|before| before.part.to_native().checked_add(1) == Some(part));
        self.require(follows, "the number of its part does not follow the one before")?;
        let shared = before.is_none_or(|before| before.origin == self.record.origin);
        self.require(shared, "its frame is not that of the hull before")
    }

    fn vertices(&self) -> Result<(), CheckError> {
        let vertices = &self.pack.vertices[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let (low, high) = (&self.record.bounds_min, &self.record.bounds_max);
        // A NaN is in no bounds.
        let inside = vertices.iter().all(|v| (0..3).all(|i| low[i] <= v[i] && v[i] <= high[i]));
        self.require(inside, "a vertex lies outside the bounds or is not finite")?;
        let numbers = &self.pack.source_vertices[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let ascend = |pair: &[u32_le]| pair[0] < pair[1] || pair[0] == NO_SOURCE_VERTEX && pair[0] == pair[1];
        self.require(numbers.windows(2).all(ascend), "its source vertices do not ascend")
    }

    /// Every face has three vertices or more, every vertex number is in range, and V − E + F = 2.
    fn faces(&self) -> Result<(), CheckError> {
        let starts = &self.pack.face_starts[range(self.start.face.to_native(), self.end.face.to_native())];
        let loops =
            &self.pack.face_vertices[range(self.start.face_vertex.to_native(), self.end.face_vertex.to_native())];
        if self.record.rank < 2 {
            return self.require(starts.is_empty() && loops.is_empty(), "a segment or point has faces");
        }
        let ends = starts.iter().skip(1).map(|s| s.to_native()).chain([loops.len() as u32]);
        let long_enough = starts
            .iter()
            .zip(ends)
            .all(|(start, end)| start.to_native().checked_add(3).is_some_and(|least| least <= end));
        self.require(long_enough && starts.first().is_some_and(|s| *s == 0), "a face has fewer than three vertices")?;
        let n = self.vertex_count();
        self.require(loops.iter().all(|v| *v < n), "a face names a vertex that is not there")?;
        let euler = i64::from(n) - loops.len() as i64 / 2 + starts.len() as i64;
        self.require(loops.len().is_multiple_of(2) && euler == 2, "vertices, edges and faces do not make a polyhedron")
    }

    /// Every vertex has a run of neighbours, in range.
    fn neighbours(&self) -> Result<(), CheckError> {
        let starts = &self.pack.neighbour_starts[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let all = &self.pack.neighbours[range(self.start.neighbour.to_native(), self.end.neighbour.to_native())];
        let ends = starts.iter().skip(1).map(|s| s.to_native()).chain([all.len() as u32]);
        let counts = starts.iter().zip(ends).map(|(start, end)| end.checked_sub(start.to_native()));
        let most = counts.reduce(|most, count| Some(most?.max(count?))).flatten();
        let fits = most == Some(self.record.max_neighbours.to_native());
        self.require(fits && starts.first().is_some_and(|s| *s == 0), "its neighbours do not follow one another")?;
        let n = self.vertex_count();
        self.require(all.iter().all(|v| *v < n), "a neighbour is a vertex that is not there")?;
        let left = &self.pack.neighbour_faces[range(self.start.neighbour.to_native(), self.end.neighbour.to_native())];
        // Without faces the entries are 0.
        let faces = (self.end.face.to_native() - self.start.face.to_native()).max(1);
        self.require(left.iter().all(|f| *f < faces), "the face beside an edge is one that is not there")
    }

    /// Those of a solid are the directions to its neighbours; others have none.
    fn edges(&self) -> Result<(), CheckError> {
        let vertices = &self.pack.vertices[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let starts = &self.pack.neighbour_starts[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let neighbours = &self.pack.neighbours[range(self.start.neighbour.to_native(), self.end.neighbour.to_native())];
        let edges = &self.pack.edges[range(self.start.edge.to_native(), self.end.edge.to_native())];
        let expected = if self.record.rank == 3 { 3 * neighbours.len() } else { 0 };
        self.require(edges.len() == expected, "it has not three numbers for each edge")?;
        if edges.is_empty() {
            return Ok(());
        }
        let ends = starts.iter().skip(1).map(|s| s.to_native() as usize).chain([neighbours.len()]);
        let sound = vertices.iter().zip(starts.iter().zip(ends)).all(|(v, (start, end))| {
            let start = start.to_native() as usize;
            let (run, around) = (&edges[3 * start..3 * end], &neighbours[start..end]);
            around.iter().enumerate().all(|(place, w)| {
                let w = vertices[w.to_native() as usize];
                let edge = edge::quantise(v.map(f32_le::to_native), w.map(f32_le::to_native));
                (0..3).all(|axis| run[axis * around.len() + place] == edge[axis])
            })
        });
        self.require(sound, "an edge contradicts its vertices")
    }

    /// None, or enough for a solid, all finite.
    fn outer(&self) -> Result<(), CheckError> {
        let outer = &self.pack.outer_vertices[range(self.start.outer.to_native(), self.end.outer.to_native())];
        let count = outer.is_empty() || (4..=MAX_OUTER_VERTICES).contains(&outer.len());
        self.require(count, "its outer hull has too few or too many vertices")?;
        let finite = outer.iter().flatten().all(|c| c.to_native().is_finite());
        self.require(finite, "a vertex of its outer hull is not finite")
    }

    fn index(&self) -> Result<(), CheckError> {
        let slots = &self.pack.slots[range(self.start.slot.to_native(), self.end.slot.to_native())];
        let resolution = u64::from(self.record.resolution.to_native());
        let kind = self.record.index_kind.to_native();
        let (roots, branches) = match kind {
            index_kind::SCAN => (0, Branches::None),
            // No product of two 32-bit numbers overflows; six times the greatest would.
            index_kind::CUBE_MAP => ((resolution * resolution).saturating_mul(6), Branches::None),
            index_kind::BINARY => (6, Branches::Halves),
            index_kind::TREE => (6, Branches::Squares),
            _ => return self.require(false, "its kind of index is not known"),
        };
        let is_map = kind == index_kind::CUBE_MAP;
        self.require(is_map == (resolution > 0), "its resolution and its kind of index contradict each other")?;
        let leaf_blocks = self.record.leaf_blocks.to_native();
        self.require(matches!(leaf_blocks, 1 | 2 | 4), "a leaf has not 1, 2 or 4 blocks")?;
        self.require(self.block_count() > 0, "it has no blocks")?;
        let roots = usize::try_from(roots).unwrap_or(usize::MAX);
        let shape = Shape { roots, branches, leaf_blocks, block_count: self.block_count() };
        let walked = walk(shape, slots.len(), |i| slots[i].to_native())
            .map_err(|source| CheckError::Index { hull: self.hull, source })?;
        let cost = if kind == index_kind::SCAN { shape.scan_cost() } else { walked };
        let stated = Cost { nodes: self.record.max_nodes.to_native(), dots: self.record.max_dots.to_native() };
        self.require(cost == stated, "the stated worst case is not that of its index")
    }

    /// Every lane of every block repeats the vertex it names.
    fn blocks(&self) -> Result<(), CheckError> {
        let vertices = &self.pack.vertices[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let blocks = &self.pack.blocks[range(self.start.block.to_native(), self.end.block.to_native())];
        let sound = blocks.iter().all(|block| {
            (0..LANES).all(|lane| {
                vertices
                    .get(block.vertex[lane].to_native() as usize)
                    .is_some_and(|v| block.x[lane] == v[0] && block.y[lane] == v[1] && block.z[lane] == v[2])
            })
        });
        self.require(sound, "a block of its index contradicts its vertices")
    }
}

fn range(start: u32, end: u32) -> std::ops::Range<usize> {
    start as usize..end as usize
}

/// Most vertices of an outer hull: all of them are looked at in a query.
pub const MAX_OUTER_VERTICES: usize = 64;

/// Blocks start on a multiple of this many bytes.
const BLOCK_ALIGNMENT: usize = 64;

/// Length of the longest pack: its 32-bit offsets reach 2 GiB.
pub const MAX_PACK_LEN: usize = HEADER_LEN + i32::MAX as usize;
