//! Versions of the format. Any change to the bytes or to their meaning gets a new one, listed in
//! `docs/contributors/FORMAT.md`. There are four at a time, so that older programs can read a pack
//! unless it has data that they cannot read.
//!
//! | | lean | |
//! |---|---|---|
//! | usual | 8 | 7 |
//! | extended: with records of voids or primitives | 10 | 9 |

/// Version of packs with the sections that all packs have.
pub const FORMAT_VERSION: u32 = 7;

/// Version of *lean* packs: the same format, but without neighbours, quads and edges, and without
/// the faces of hulls of more than [`LEAN_FACES`](crate::archive::LEAN_FACES) vertices.
pub const LEAN_FORMAT_VERSION: u32 = 8;

/// Version of packs with the sections of [`ExtendedPack`](crate::archive::ExtendedPack).
pub const EXTENDED_FORMAT_VERSION: u32 = 9;

/// Version of lean packs with these sections.
pub const LEAN_EXTENDED_FORMAT_VERSION: u32 = 10;

/// The versions of packs that this crate reads, ascending.
pub const ALL: [u32; 4] = [FORMAT_VERSION, LEAN_FORMAT_VERSION, EXTENDED_FORMAT_VERSION, LEAN_EXTENDED_FORMAT_VERSION];

/// The sections that the version of a pack states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Whether it is lean.
    pub is_lean: bool,
    /// Whether it is extended.
    pub is_extended: bool,
}

impl Layout {
    /// The layout of packs of a version; `None` if this crate does not read them.
    pub fn of_version(version: u32) -> Option<Self> {
        let layouts = [false, true]
            .map(|is_lean| [false, true].map(|is_extended| Self { is_lean, is_extended }))
            .into_iter()
            .flatten();
        layouts.into_iter().find(|layout| layout.version() == version)
    }

    /// The version of packs of this layout.
    pub fn version(self) -> u32 {
        match (self.is_lean, self.is_extended) {
            (false, false) => FORMAT_VERSION,
            (true, false) => LEAN_FORMAT_VERSION,
            (false, true) => EXTENDED_FORMAT_VERSION,
            (true, true) => LEAN_EXTENDED_FORMAT_VERSION,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_and_layouts_match() {
        let layouts: Vec<Layout> = (0..64).filter_map(Layout::of_version).collect();
        let versions: Vec<u32> = layouts.iter().map(|layout| layout.version()).collect();
        assert_eq!(versions, [7, 8, 9, 10]);
        assert!(ALL.iter().all(|version| versions.contains(version)) && ALL.is_sorted());
        assert_eq!(Layout::default().version(), FORMAT_VERSION);
    }
}
