//! Whether a file keeps the promises that the runtime relies on.
//!
//! Two depths. [`structure`] looks only at what is needed to hand out a hull's slices: rkyv's own bounds, and the spans;
//! its cost grows with the number of hulls. [`contents`] looks at every number that a query could follow or return.

use rkyv::rancor;

use crate::{
    archive::{ArchivedHullRecord, ArchivedPack, ArchivedSpan, LANES, index_kind},
    header::HEADER_LEN,
    walk::{Cost, IndexError, walk},
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
    if !pack.blocks.as_ptr().addr().is_multiple_of(BLOCK_ALIGNMENT) {
        return Err(CheckError::Archive("its blocks do not start on a cache line".to_owned()));
    }
    spans(pack)?;
    Ok(pack)
}

/// One number of a span, the section it starts in, and that section's length.
type SpanField = (&'static str, fn(&ArchivedSpan) -> u32, usize);

fn spans(pack: &ArchivedPack) -> Result<(), CheckError> {
    let hull_count = pack.hulls.len();
    let fields: [SpanField; 6] = [
        ("names", |s| s.name.to_native(), pack.names.len()),
        ("vertices", |s| s.vertex.to_native(), pack.vertices.len()),
        ("faces", |s| s.face.to_native(), pack.face_starts.len()),
        ("face vertices", |s| s.face_vertex.to_native(), pack.face_vertices.len()),
        ("slots", |s| s.slot.to_native(), pack.slots.len()),
        ("blocks", |s| s.block.to_native(), pack.blocks.len()),
    ];
    // Readers are promised a hull.
    if hull_count == 0 || pack.spans.len() != hull_count + 1 {
        return Err(CheckError::Spans { hull: hull_count, section: "spans" });
    }
    if pack.source_vertices.len() != pack.vertices.len() {
        return Err(CheckError::Spans { hull: hull_count, section: "source vertices" });
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
    })
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
        self.vertices()?;
        self.faces()?;
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
        // `>=` is false for NaN.
        let sound = lengths.iter().all(|l| l.to_native() >= 0.0 && l.to_native().is_finite())
            && r.centroid.iter().chain(&r.interior_point).chain(&r.second_moments).all(|c| c.to_native().is_finite())
            && r.bounds_min.iter().chain(&r.bounds_max).all(|c| c.to_native().is_finite());
        self.require(sound, "a length is negative or a number is not finite")?;
        let rank = r.rank.to_native();
        self.require(rank <= 3, "its rank is not 0 to 3")?;
        let fits = if rank == 0 { self.vertex_count() == 1 } else { self.vertex_count() > rank };
        self.require(fits, "its rank and its number of vertices contradict each other")?;
        self.require(rank > 1 || self.vertex_count() <= 2, "a segment has more than two vertices")?;
        self.require(r.inner_radius <= r.outer_radius, "its inner ball is larger than its outer one")
    }

    fn vertices(&self) -> Result<(), CheckError> {
        let vertices = &self.pack.vertices[range(self.start.vertex.to_native(), self.end.vertex.to_native())];
        let (low, high) = (&self.record.bounds_min, &self.record.bounds_max);
        // A NaN is in no bounds.
        let inside = vertices.iter().all(|v| (0..3).all(|i| low[i] <= v[i] && v[i] <= high[i]));
        self.require(inside, "a vertex lies outside the bounds or is not finite")
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

    fn index(&self) -> Result<(), CheckError> {
        let slots = &self.pack.slots[range(self.start.slot.to_native(), self.end.slot.to_native())];
        let resolution = u64::from(self.record.resolution.to_native());
        let (root_count, axis_nodes) = match self.record.index_kind.to_native() {
            index_kind::SCAN => (0, false),
            // No array is as long as a number of cells that does not fit into 64 bits.
            index_kind::CUBE_MAP => (resolution.saturating_mul(resolution).saturating_mul(6), false),
            index_kind::TREE => (6, true),
            _ => return self.require(false, "its kind of index is not known"),
        };
        let is_map = self.record.index_kind == index_kind::CUBE_MAP;
        self.require(is_map == (resolution > 0), "its resolution and its kind of index contradict each other")?;
        let root_count = usize::try_from(root_count).unwrap_or(usize::MAX);
        let walked = walk(root_count, axis_nodes, slots.len(), |i| slots[i].to_native(), self.block_count())
            .map_err(|source| CheckError::Index { hull: self.hull, source })?;
        let cost = if root_count == 0 {
            Cost { nodes: 0, dots: self.block_count().saturating_mul(LANES as u32) }
        } else {
            walked
        };
        let stated = Cost { nodes: self.record.max_nodes.to_native(), dots: self.record.max_dots.to_native() };
        self.require(self.block_count() > 0, "it has no blocks")?;
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

/// Blocks start on a multiple of this many bytes.
const BLOCK_ALIGNMENT: usize = 64;

/// Length of the longest pack: its 32-bit offsets reach 2 GiB.
pub const MAX_PACK_LEN: usize = HEADER_LEN + i32::MAX as usize;
