//! Whether a file keeps the promises that the runtime relies on.
//!
//! Four depths, each needing those before it:
//!
//! 1. [`access`]: rkyv's own bounds. O(1).
//! 2. [`structure`]: what is needed to hand out a hull's slices: sections and spans. O(number of hulls).
//! 3. [`contents`]: every number that a query could follow or return. One pass over the archive, at the speed of memory: loops
//!    without early exits, over whole sections where they can be, are what the compiler makes vectors of.
//! 4. [`crate::repeats`]: that what the file holds twice agrees. No query needs it; `bake verify` asks.

use rkyv::{
    rancor,
    rend::{f32_le, u32_le},
};

use crate::{
    archive::{ArchivedHullRecord, ArchivedPack, ArchivedSpan, NO_SOURCE_VERTEX, index_kind},
    bvh,
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

/// The archive in `payload` (all bytes behind the header), its vectors inside the payload; nothing else is looked at.
///
/// # Errors
/// A vector outside the payload.
///
/// # Complexity
/// O(1).
pub fn access(payload: &[u8]) -> Result<&ArchivedPack, CheckError> {
    rkyv::access::<ArchivedPack, rancor::Error>(payload).map_err(|error| CheckError::Archive(error.to_string()))
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
    let pack = access(payload)?;
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
        if payload.get(end - start..at - start).is_none_or(|gap| gap.iter().any(|byte| *byte != 0)) {
            return Err(CheckError::Layout { what: "the bytes between sections" });
        }
        end = at + len;
    }
    if end == start + payload.len() { Ok(()) } else { Err(CheckError::Layout { what: "the last bytes" }) }
}

/// The numbers of a span and the sections they start in.
fn starts(span: &ArchivedSpan) -> [u32; SECTIONS.len()] {
    let s = span;
    [s.name, s.vertex, s.face, s.face_vertex, s.neighbour, s.edge, s.slot, s.block, s.outer].map(u32_le::to_native)
}

const SECTIONS: [&str; 9] =
    ["names", "vertices", "faces", "face vertices", "neighbours", "edges", "slots", "blocks", "outer vertices"];

fn spans(pack: &ArchivedPack) -> Result<(), CheckError> {
    let hull_count = pack.hulls.len();
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
    let lengths = [
        pack.names.len(),
        pack.vertices.len(),
        pack.face_starts.len(),
        pack.face_vertices.len(),
        pack.neighbours.len(),
        pack.edges.len(),
        pack.slots.len(),
        pack.blocks.len(),
        pack.outer_vertices.len(),
    ];
    let mut last = [0; SECTIONS.len()];
    for (hull, span) in pack.spans.iter().enumerate() {
        let now = starts(span);
        for (section, (now, last)) in SECTIONS.into_iter().zip(now.into_iter().zip(last)) {
            if now < last || (hull == 0 && now != 0) {
                return Err(CheckError::Spans { hull, section });
            }
        }
        last = now;
    }
    for (section, (last, length)) in SECTIONS.into_iter().zip(last.into_iter().zip(lengths)) {
        if last as usize != length {
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
        let name = run(&self.pack.names, self.start.name, self.end.name);
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
        let before = self.hull.checked_sub(1).and_then(|before| self.pack.hulls.get(before));
        let part = self.record.part.to_native();
        let follows = part == 0 || before.is_some_and(|before| before.part.to_native().checked_add(1) == Some(part));
        self.require(follows, "the number of its part does not follow the one before")?;
        let shared = before.is_none_or(|before| before.origin == self.record.origin);
        self.require(shared, "its frame is not that of the hull before")
    }

    fn vertices(&self) -> Result<(), CheckError> {
        let vertices = run(&self.pack.vertices, self.start.vertex, self.end.vertex);
        let (low, high) = (self.record.bounds_min, self.record.bounds_max);
        // Four vertices at a time; a NaN is in no bounds.
        let fours = vertices.as_chunks::<4>();
        let four = |bound: [f32_le; 3]| [bound; 4].map(|v| v.map(f32_le::to_native));
        let (lows, highs) = (four(low), four(high));
        let mut inside = true;
        for four in fours.0 {
            for (v, (low, high)) in four.as_flattened().iter().zip(lows.as_flattened().iter().zip(highs.as_flattened()))
            {
                inside &= (*low <= v.to_native()) & (v.to_native() <= *high);
            }
        }
        let is_within = |v: &[f32_le; 3]| v.iter().zip(low.iter().zip(&high)).all(|(v, (l, h))| l <= v && v <= h);
        inside &= fours.1.iter().all(is_within);
        self.require(inside, "a vertex lies outside the bounds or is not finite")?;
        let numbers = run(&self.pack.source_vertices, self.start.vertex, self.end.vertex);
        let later = numbers.get(1..).unwrap_or_default();
        let ascend = numbers.iter().zip(later).fold(true, |ascend, (a, b)| {
            let (a, b) = (a.to_native(), b.to_native());
            ascend & ((a < b) | ((a == NO_SOURCE_VERTEX) & (b == NO_SOURCE_VERTEX)))
        });
        self.require(ascend, "its source vertices do not ascend")
    }

    /// Every face has three vertices or more, every vertex number is in range, and V − E + F = 2.
    fn faces(&self) -> Result<(), CheckError> {
        let starts = run(&self.pack.face_starts, self.start.face, self.end.face);
        let loops = run(&self.pack.face_vertices, self.start.face_vertex, self.end.face_vertex);
        if self.record.rank < 2 {
            return self.require(starts.is_empty() && loops.is_empty(), "a segment or point has faces");
        }
        let (least, _) = run_lengths(starts, loops.len()).unwrap_or_default();
        self.require(least >= 3, "a face has fewer than three vertices")?;
        let n = self.vertex_count();
        self.require(all_below(loops, n), "a face names a vertex that is not there")?;
        let euler = i64::from(n) - loops.len() as i64 / 2 + starts.len() as i64;
        self.require(loops.len().is_multiple_of(2) && euler == 2, "vertices, edges and faces do not make a polyhedron")
    }

    /// Every vertex has a run of neighbours, in range.
    fn neighbours(&self) -> Result<(), CheckError> {
        let starts = run(&self.pack.neighbour_starts, self.start.vertex, self.end.vertex);
        let all = run(&self.pack.neighbours, self.start.neighbour, self.end.neighbour);
        let most = run_lengths(starts, all.len()).map(|(_, most)| most);
        let fits = most == Some(self.record.max_neighbours.to_native());
        self.require(fits, "its neighbours do not follow one another")?;
        let n = self.vertex_count();
        self.require(all_below(all, n), "a neighbour is a vertex that is not there")?;
        let left = run(&self.pack.neighbour_faces, self.start.neighbour, self.end.neighbour);
        // Without faces the entries are 0.
        let faces = (self.end.face.to_native() - self.start.face.to_native()).max(1);
        self.require(all_below(left, faces), "the face beside an edge is one that is not there")
    }

    /// A solid has three numbers for each neighbour; others have none.
    fn edges(&self) -> Result<(), CheckError> {
        let neighbours = (self.end.neighbour.to_native() - self.start.neighbour.to_native()) as usize;
        let edges = (self.end.edge.to_native() - self.start.edge.to_native()) as usize;
        let expected = if self.record.rank == 3 { 3 * neighbours } else { 0 };
        self.require(edges == expected, "it has not three numbers for each edge")
    }

    /// None, or enough for a solid, all finite.
    fn outer(&self) -> Result<(), CheckError> {
        let outer = run(&self.pack.outer_vertices, self.start.outer, self.end.outer);
        let count = outer.is_empty() || (4..=MAX_OUTER_VERTICES).contains(&outer.len());
        self.require(count, "its outer hull has too few or too many vertices")?;
        let finite = outer.iter().flatten().all(|c| c.to_native().is_finite());
        self.require(finite, "a vertex of its outer hull is not finite")
    }

    #[expect(clippy::indexing_slicing, reason = "`walk` reads words below the length that it is given")]
    fn index(&self) -> Result<(), CheckError> {
        let slots = run(&self.pack.slots, self.start.slot, self.end.slot);
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

    /// Every lane of every block names a vertex that is there, and has its place inside the bounds.
    #[expect(clippy::indexing_slicing, reason = "three axes, three coordinates; the loop is one for vectors")]
    fn blocks(&self) -> Result<(), CheckError> {
        let blocks = run(&self.pack.blocks, self.start.block, self.end.block);
        let n = self.vertex_count();
        let (low, high) = (self.record.bounds_min, self.record.bounds_max);
        let mut named = true;
        let mut inside = true;
        for block in blocks {
            for (axis, lanes) in [&block.x, &block.y, &block.z].into_iter().enumerate() {
                let (low, high) = (low[axis].to_native(), high[axis].to_native());
                for lane in lanes {
                    // A NaN is in no bounds.
                    inside &= (low <= lane.to_native()) & (lane.to_native() <= high);
                }
            }
            for vertex in &block.vertex {
                named &= vertex.to_native() < n;
            }
        }
        self.require(named && inside, "a block of its index contradicts its vertices")
    }
}

/// Whether all numbers are below `limit`. No early exit: so it is done in vectors.
fn all_below(numbers: &[u32_le], limit: u32) -> bool {
    numbers.iter().fold(true, |below, number| below & (number.to_native() < limit))
}

/// Shortest and longest of the runs that start at `starts` and follow one another up to `end`; nothing where they do not, or there
/// are none.
fn run_lengths(starts: &[u32_le], end: usize) -> Option<(u32, u32)> {
    let (first, later) = starts.split_first()?;
    let (first, last, end) = (first.to_native(), starts.last()?.to_native(), u32::try_from(end).ok()?);
    let (mut least, mut most, mut farthest) = (u32::MAX, 0, 0);
    // Of numbers up to the end, one that comes before the other is more than the end behind it, modulo 2³².
    let mut take = |start: u32, end: u32| {
        let length = end.wrapping_sub(start);
        least = least.min(length);
        most = most.max(length);
        farthest = farthest.max(start);
    };
    for (start, end) in starts.iter().zip(later) {
        take(start.to_native(), end.to_native());
    }
    take(last, end);
    (first == 0 && farthest <= end && most <= end).then_some((least, most))
}

/// A hull's run of a section.
#[expect(clippy::indexing_slicing, reason = "`spans` has found that runs ascend, and end where their sections end")]
fn run<T>(section: &[T], start: u32_le, end: u32_le) -> &[T] {
    &section[start.to_native() as usize..end.to_native() as usize]
}

/// Most vertices of an outer hull: all of them are looked at in a query.
pub const MAX_OUTER_VERTICES: usize = 64;

/// Blocks start on a multiple of this many bytes.
const BLOCK_ALIGNMENT: usize = 64;

/// Length of the longest pack: its 32-bit offsets reach 2 GiB.
pub const MAX_PACK_LEN: usize = HEADER_LEN + i32::MAX as usize;
