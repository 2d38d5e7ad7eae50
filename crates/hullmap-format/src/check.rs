//! Checks of an archive: whether it meets the requirements that the runtime relies on.
//!
//! The runtime (`hullmap/src/pack/mod.rs`) decides which checks a file has to pass.
//! [`crate::header`] checks the header; the levels follow one another:
//!
//! 1. [`Sections::read`]: the root. O(1).
//! 2. [`layout`]: the sections of the format version. O(1).
//! 3. [`structure`]: sections and spans, so that a hull's slices can be handed out. O(hulls).
//! 4. [`contents`]: every value that a query could follow or return. One pass at the speed of
//!    memory, in loops without an early exit over whole sections, which the compiler vectorises.
//!    Only a failed loop is repeated to find the first error.
//! 5. [`crate::repeats`]: redundant values agree. Queries are safe without it, and only `bake
//!    verify` runs it. It may run before level 4.

use rkyv::rend::u32_le;

pub use crate::archive::MAX_OUTER_VERTICES;
pub use crate::check_error::{CheckError, HullError};
pub use crate::header::MAX_PACK_LEN;
use crate::{
    archive::{ArchivedExtendedPack, ArchivedPack, ArchivedSpan},
    bvh,
    hull_check::HullCheck,
    primitive,
    sections::Sections,
    version::Layout,
    voids,
};

/// Checks what is needed to hand out a hull's slices of `pack`, which was read from `payload`, in
/// O(hulls).
///
/// # Errors
/// Bytes between sections that are not zero; no hulls; spans that do not ascend or do not end where
/// the sections end.
pub fn structure(pack: &Sections<'_>, payload: &[u8]) -> Result<(), CheckError> {
    if pack.hulls.is_empty() {
        return Err(CheckError::NoHulls);
    }
    gaps(pack, payload)?;
    spans(pack)
}

/// Checks that the bytes between sections are zero. So equal packs have equal bytes.
pub(crate) fn gaps(pack: &Sections<'_>, payload: &[u8]) -> Result<(), CheckError> {
    fn extent<T>(name: &'static str, section: &[T]) -> (&'static str, usize, usize) {
        (name, size_of_val(section), align_of::<T>())
    }
    let root = if pack.is_extended() {
        ("root", size_of::<ArchivedExtendedPack>(), align_of::<ArchivedExtendedPack>())
    } else {
        ("root", size_of::<ArchivedPack>(), align_of::<ArchivedPack>())
    };
    let sections = [
        extent("blocks", pack.blocks),
        extent("source_path", pack.source_path),
        extent("options", pack.options),
        extent("names", pack.names),
        extent("spans", pack.spans),
        extent("hulls", pack.hulls),
        extent("masses", pack.masses),
        extent("nodes", pack.nodes),
        extent("vertices", pack.vertices),
        extent("source_vertices", pack.source_vertices),
        extent("face_starts", pack.face_starts),
        extent("face_vertices", pack.face_vertices),
        extent("quads", pack.quads),
        extent("neighbour_starts", pack.neighbour_starts),
        extent("neighbours", pack.neighbours),
        extent("neighbour_faces", pack.neighbour_faces),
        extent("outer_vertices", pack.outer_vertices),
        extent("slots", pack.slots),
        extent("edges", pack.edges),
    ];
    let further = [extent("voids", pack.voids), extent("primitives", pack.primitives)];
    let further = if pack.is_extended() { &further[..] } else { &[] };
    zeros_between(payload, sections.into_iter().chain(further.iter().copied()).chain([root]))
}

/// Checks that the bytes between sections, given by name, length and alignment, are zero.
pub(crate) fn zeros_between(
    payload: &[u8],
    sections: impl IntoIterator<Item = (&'static str, usize, usize)>,
) -> Result<(), CheckError> {
    let mut end = 0_usize;
    for (section, len, alignment) in sections {
        let start = end.next_multiple_of(alignment);
        let gap = payload.get(end..start).unwrap_or_default();
        if let Some(byte) = gap.iter().position(|byte| *byte != 0) {
            return Err(CheckError::Gap { next_section: section, offset: end + byte });
        }
        end = start + len;
    }
    Ok(())
}

/// Checks that a pack has the sections of the format version in its header.
///
/// # Errors
/// [`CheckError::SectionCount`] if a lean pack has starts of neighbours or another one lacks them,
/// and if a pack that is not extended has records of voids or primitives.
pub fn layout(pack: &Sections<'_>, layout: Layout) -> Result<(), CheckError> {
    let Layout { is_lean, is_extended } = layout;
    let found = pack.neighbour_starts.len();
    let expected = if is_lean { 0 } else { pack.vertices.len() };
    if found != expected {
        return Err(CheckError::SectionCount { section: "neighbour_starts", found, expected });
    }
    if pack.is_extended() == is_extended {
        Ok(())
    } else {
        let found = pack.voids.len() + pack.primitives.len();
        Err(CheckError::SectionCount { section: "voids and primitives", found, expected: usize::from(is_extended) })
    }
}

fn starts(span: &ArchivedSpan) -> [u32; SECTIONS.len()] {
    let s = span;
    [s.name, s.vertex, s.face, s.face_vertex, s.quad, s.neighbour, s.edge, s.slot, s.block, s.outer, s.mass]
        .map(u32_le::to_native)
}

const SECTIONS: [&str; 11] = [
    "names",
    "vertices",
    "faces",
    "face vertices",
    "quads",
    "neighbours",
    "edges",
    "slots",
    "blocks",
    "outer vertices",
    "mass records",
];

/// Checks that the spans divide every section into one run per hull.
fn spans(pack: &Sections<'_>) -> Result<(), CheckError> {
    let counts = [
        ("spans", pack.spans.len(), pack.hulls.len() + 1),
        ("source_vertices", pack.source_vertices.len(), pack.vertices.len()),
        ("neighbour_faces", pack.neighbour_faces.len(), pack.neighbours.len()),
    ];
    let starts_of_neighbours = ("neighbour_starts", pack.neighbour_starts.len(), pack.vertices.len());
    let absent =
        [("neighbours", pack.neighbours.len(), 0), ("quads", pack.quads.len(), 0), ("edges", pack.edges.len(), 0)];
    let of_detail = if pack.is_lean() { &absent[..] } else { std::slice::from_ref(&starts_of_neighbours) };
    for &(section, found, expected) in counts.iter().chain(of_detail) {
        if found != expected {
            return Err(CheckError::SectionCount { section, found, expected });
        }
    }
    let mut last = [0; SECTIONS.len()];
    for (hull, span) in pack.spans.iter().enumerate() {
        let now = starts(span);
        for (section, (found, least)) in SECTIONS.into_iter().zip(now.into_iter().zip(last)) {
            if hull == 0 && found != 0 {
                return Err(CheckError::FirstSpan { section, found });
            }
            if found < least {
                return Err(CheckError::SpanOrder { hull, section, found, least });
            }
        }
        last = now;
    }
    let lengths = [
        pack.names.len(),
        pack.vertices.len(),
        pack.face_starts.len(),
        pack.face_vertices.len(),
        pack.quads.len(),
        pack.neighbours.len(),
        pack.edges.len(),
        pack.slots.len(),
        pack.blocks.len(),
        pack.outer_vertices.len(),
        pack.masses.len(),
    ];
    for (section, (found, expected)) in SECTIONS.into_iter().zip(last.into_iter().zip(lengths)) {
        if found as usize != expected {
            return Err(CheckError::SpanEnd { section, found, expected });
        }
    }
    Ok(())
}

/// Checks every value that a query could follow or return, in an archive that passed [`structure`].
///
/// # Errors
/// The first value that violates a requirement, with what was expected: see [`CheckError`].
///
/// # Complexity
/// One pass over the archive, and a search in a vertex's neighbours for each corner of a face. One
/// bit of memory per neighbour of the largest hull.
pub fn contents(pack: &Sections<'_>) -> Result<(), CheckError> {
    for (section, text) in [("source_path", pack.source_path), ("options", pack.options), ("names", pack.names)] {
        std::str::from_utf8(text).map_err(|error| CheckError::Text { section, at: error.valid_up_to() })?;
    }
    let spans = pack.spans.iter().zip(pack.spans.iter().skip(1));
    let mut scratch = Vec::new();
    for (hull, ((start, end), record)) in spans.zip(pack.hulls).enumerate() {
        let check = HullCheck { hull, pack, start, end, record };
        check.run(&mut scratch).map_err(|source| CheckError::Hull { hull, source })?;
    }
    voids::check(pack.voids, pack.hulls, pack.spans)?;
    primitive::check(pack.primitives, pack.hulls)?;
    bvh::check(pack)?;
    Ok(())
}
