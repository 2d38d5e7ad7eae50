//! Index kinds: `tree`, `medium`, `compact`, `binary`, `cubemap` and `none`.
//!
//! [`IndexKind`] is the only type for this choice. The runtime and the baker re-export it; the
//! command line, `hullmap.toml` and reports use its names.
//!
//! # How to add a kind
//! 1. Here: the variant, its line in [`IndexKind::NAMED`], name, code, roots and branches.
//! 2. `hullmap-bake`, `index/mod.rs`: how it is built.
//! 3. `hullmap`, `support/index.rs`: how a direction finds its leaf.
//! 4. `hullmap-cli`, `options/`: its name, and its text in a pack's record.
//! 5. `docs/contributors/FORMAT.md`, and the test `format_document`, which implements it
//!    independently.
//!
//! Matches have no wildcard, so the compiler reports each location of steps 1 to 4.

use std::{fmt, num::NonZeroU32, str::FromStr};

use crate::{
    archive::{ArchivedHullRecord, LANES},
    node::Branches,
};

/// Which direction index a hull has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum IndexKind {
    /// Level-compressed tree over the six cube faces, with leaves of 8 candidates: the fastest.
    #[default]
    Tree,
    /// [`Tree`](Self::Tree) with leaves of 16 candidates.
    Medium,
    /// [`Tree`](Self::Tree) with leaves of 32 candidates, in half the bytes.
    Compact,
    /// Binary tree over the six cube faces, as in Kenwright 4.9.
    Binary,
    /// Uniform cube map with `resolution`² cells on each face, as in Kenwright 4.8.
    CubeMap { resolution: u32 },
    /// No index: every query scans all vertices.
    None,
}

mod code {
    pub const SCAN: u32 = 0;
    pub const CUBE_MAP: u32 = 1;
    pub const BINARY: u32 = 2;
    pub const TREE: u32 = 3;
}

impl IndexKind {
    /// Resolution of a cube map if no resolution is given.
    pub const DEFAULT_RESOLUTION: u32 = 64;

    /// Every kind, in the order of messages; the cube map at its default resolution.
    pub const NAMED: [Self; 6] = [
        Self::Tree,
        Self::Medium,
        Self::Compact,
        Self::Binary,
        Self::CubeMap { resolution: Self::DEFAULT_RESOLUTION },
        Self::None,
    ];

    /// Name of the kind, without the resolution of a cube map.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Medium => "medium",
            Self::Compact => "compact",
            Self::Binary => "binary",
            Self::CubeMap { .. } => "cubemap",
            Self::None => "none",
        }
    }

    /// Code of the kind in [`HullRecord::index_kind`](crate::archive::HullRecord::index_kind).
    /// Trees share one; [`leaf_blocks`](Self::leaf_blocks) distinguishes them.
    pub const fn code(self) -> u32 {
        match self {
            Self::Tree | Self::Medium | Self::Compact => code::TREE,
            Self::Binary => code::BINARY,
            Self::CubeMap { .. } => code::CUBE_MAP,
            Self::None => code::SCAN,
        }
    }

    /// Blocks of a plain leaf: 1, 2 or 4.
    pub const fn leaf_blocks(self) -> u32 {
        match self {
            Self::Tree | Self::Binary | Self::CubeMap { .. } | Self::None => 1,
            Self::Medium => 2,
            Self::Compact => 4,
        }
    }

    /// Candidates of a plain leaf: 8, 16 or 32.
    pub const fn leaf_size(self) -> u32 {
        LANES as u32 * self.leaf_blocks()
    }

    /// Cells along the edge of a cube map's face; 0 for the other kinds.
    pub const fn resolution(self) -> u32 {
        match self {
            Self::CubeMap { resolution } => resolution,
            Self::Tree | Self::Medium | Self::Compact | Self::Binary | Self::None => 0,
        }
    }

    /// This kind, with this resolution if it is a cube map.
    #[must_use]
    pub const fn with_resolution(self, resolution: u32) -> Self {
        match self {
            Self::CubeMap { .. } => Self::CubeMap { resolution },
            Self::Tree | Self::Medium | Self::Compact | Self::Binary | Self::None => self,
        }
    }

    /// Whether the index is a tree of squares, with leaves of any size.
    #[inline]
    pub const fn is_tree(self) -> bool {
        matches!(self, Self::Tree | Self::Medium | Self::Compact)
    }

    /// Slots at the front of the index: one for each face of the cube, or for each cell of a cube
    /// map. Saturates at `u64::MAX`, which no index reaches.
    pub const fn root_count(self) -> u64 {
        match self {
            Self::Tree | Self::Medium | Self::Compact | Self::Binary => 6,
            // The square of a 32-bit number fits into 64 bits; six times the largest does not.
            Self::CubeMap { resolution } => (resolution as u64 * resolution as u64).saturating_mul(6),
            Self::None => 0,
        }
    }

    /// How a branch of the index divides its cell.
    pub const fn branches(self) -> Branches {
        match self {
            Self::Tree | Self::Medium | Self::Compact => Branches::Squares,
            Self::Binary => Branches::Halves,
            Self::CubeMap { .. } | Self::None => Branches::None,
        }
    }

    /// The kind that a hull's record states.
    ///
    /// # Errors
    /// The code is unknown, or no kind of this code has the leaf size or the resolution: see
    /// [`RecordedKindError`]. The leaf size of a kind that is not a tree need only be in range.
    pub fn of_record(record: &ArchivedHullRecord) -> Result<Self, RecordedKindError> {
        Self::from_fields(record.index_kind.to_native(), record.leaf_blocks.to_native(), record.resolution.to_native())
    }

    const fn from_fields(code: u32, leaf_blocks: u32, resolution: u32) -> Result<Self, RecordedKindError> {
        if code > code::TREE {
            return Err(RecordedKindError::Code { found: code });
        }
        if (code == code::CUBE_MAP) != (resolution > 0) {
            return Err(RecordedKindError::Resolution { code, found: resolution });
        }
        let tree = match leaf_blocks {
            1 => Self::Tree,
            2 => Self::Medium,
            4 => Self::Compact,
            _ => return Err(RecordedKindError::LeafBlocks { found: leaf_blocks }),
        };
        Ok(match code {
            code::CUBE_MAP => Self::CubeMap { resolution },
            code::BINARY => Self::Binary,
            code::TREE => tree,
            _ => Self::None,
        })
    }
}

/// Why a hull's record does not state an index kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum RecordedKindError {
    /// The code is not known.
    #[error("index kind {found} is unknown (known kinds are 0 to {})", code::TREE)]
    Code { found: u32 },
    /// A cube map without cells, or another kind with a resolution.
    #[error(
        "index kind {code} has resolution {found} (a cube map, kind {}, requires at least 1; all other kinds require 0)",
        code::CUBE_MAP
    )]
    Resolution { code: u32, found: u32 },
    /// No index kind has this number of blocks per leaf.
    #[error("a leaf of its index has {found} blocks (expected 1, 2 or 4)")]
    LeafBlocks { found: u32 },
}

/// The name, and for a cube map its resolution: `tree`, `cubemap 64`. [`FromStr`] reads it back.
impl fmt::Display for IndexKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CubeMap { resolution } => write!(f, "{} {resolution}", self.as_str()),
            Self::Tree | Self::Medium | Self::Compact | Self::Binary | Self::None => f.write_str(self.as_str()),
        }
    }
}

/// The text is not the name of an index kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown index kind `{found}` (expected tree, medium, compact, binary, cubemap or none)")]
pub struct UnknownIndexKind {
    /// The text.
    pub found: String,
}

/// Reads a name. A cube map may state its resolution: `cubemap 16`; without one it has the default
/// resolution.
impl FromStr for IndexKind {
    type Err = UnknownIndexKind;

    fn from_str(text: &str) -> Result<Self, UnknownIndexKind> {
        let unknown = || UnknownIndexKind { found: text.to_owned() };
        if let Some(kind) = Self::NAMED.into_iter().find(|kind| kind.as_str() == text) {
            return Ok(kind);
        }
        let resolution = text.strip_prefix("cubemap ").and_then(|number| number.parse::<NonZeroU32>().ok());
        resolution.map(|resolution| Self::CubeMap { resolution: resolution.get() }).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        let names = IndexKind::NAMED.map(IndexKind::as_str);
        assert_eq!(names, ["tree", "medium", "compact", "binary", "cubemap", "none"]);
        for kind in IndexKind::NAMED.into_iter().chain([IndexKind::CubeMap { resolution: 7 }]) {
            assert_eq!(kind.to_string().parse(), Ok(kind));
            assert_eq!(kind.as_str().parse(), Ok(kind.with_resolution(IndexKind::DEFAULT_RESOLUTION)));
        }
        for text in ["", "Tree", "trees", "cubemap 0", "cubemap -1", "cubemap", "cubemap 4294967296", "tree 8"] {
            assert_eq!(text.parse::<IndexKind>().is_ok(), text == "cubemap", "{text}");
        }
    }

    #[test]
    fn unknown_names_are_reported_with_the_known_ones() {
        let error = "quadtree".parse::<IndexKind>().unwrap_err().to_string();
        assert!(error.contains("`quadtree`"), "{error}");
        assert!(IndexKind::NAMED.iter().all(|kind| error.contains(kind.as_str())), "{error}");
    }

    #[test]
    fn records_round_trip() {
        for kind in IndexKind::NAMED {
            assert_eq!(IndexKind::from_fields(kind.code(), kind.leaf_blocks(), kind.resolution()), Ok(kind));
        }
    }

    #[test]
    fn records_without_a_kind_are_rejected() {
        let rejected =
            |code, leaf_blocks, resolution| IndexKind::from_fields(code, leaf_blocks, resolution).unwrap_err();
        assert_eq!(rejected(4, 1, 0), RecordedKindError::Code { found: 4 });
        assert_eq!(rejected(code::TREE, 3, 0), RecordedKindError::LeafBlocks { found: 3 });
        assert_eq!(rejected(code::SCAN, 0, 0), RecordedKindError::LeafBlocks { found: 0 });
        assert_eq!(rejected(code::CUBE_MAP, 1, 0), RecordedKindError::Resolution { code: code::CUBE_MAP, found: 0 });
        assert_eq!(rejected(code::BINARY, 1, 9), RecordedKindError::Resolution { code: code::BINARY, found: 9 });
    }

    #[test]
    fn root_counts_do_not_overflow() {
        assert_eq!(IndexKind::CubeMap { resolution: 3 }.root_count(), 54);
        assert_eq!(IndexKind::CubeMap { resolution: u32::MAX }.root_count(), u64::MAX);
    }
}
