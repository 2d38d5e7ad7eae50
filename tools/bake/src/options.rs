//! The options that shape a bake, and the text by which a pack remembers them.

use std::fmt;

use hullmap_bake::IndexKind;

/// Greatest cube-map resolution that may be asked for.
pub const MAX_RESOLUTION: u32 = 1024;

/// Which points of a source file a hull is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Vertices {
    /// Those that any face, line or point element references; all of them when nothing does.
    Referenced,
    /// Every `v` line.
    All,
}

/// Into how many hulls a source file is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Split {
    /// One hull of the whole file.
    None,
    /// One hull for each `o` line.
    Object,
}

/// What an import needs to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImportOptions {
    /// How the file is cut.
    pub split: Split,
    /// Which points count.
    pub vertices: Vertices,
}

/// Everything, beside the source's bytes, that the bytes of a pack depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// How the source is read.
    pub import: ImportOptions,
    /// Which direction index is built.
    pub index: IndexKind,
}

/// The options as a pack records them: `split none, vertices referenced, index cubemap 64`.
///
/// Equal options have equal texts in every version of the tool: a pack is fresh while the hash of this text is that in
/// its header.
impl fmt::Display for BuildOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let split = match self.import.split {
            Split::None => "none",
            Split::Object => "object",
        };
        let vertices = match self.import.vertices {
            Vertices::Referenced => "referenced",
            Vertices::All => "all",
        };
        write!(f, "split {split}, vertices {vertices}, index ")?;
        match self.index {
            IndexKind::Tree { leaf_blocks } => write!(f, "tree {}", leaf_blocks.lanes()),
            IndexKind::Budget { bytes_per_vertex } => write!(f, "budget {bytes_per_vertex}"),
            IndexKind::Binary => f.write_str("binary"),
            IndexKind::CubeMap { resolution } => write!(f, "cubemap {resolution}"),
            IndexKind::None => f.write_str("none"),
        }
    }
}

impl ImportOptions {
    /// How the source of a pack with these recorded options was read.
    ///
    /// `None` where a version of the tool with other options baked the pack.
    pub fn from_recorded(text: &str) -> Option<Self> {
        let value = |key: &str| text.split(", ").find_map(|part| part.strip_prefix(key)?.strip_prefix(' '));
        let split = match value("split")? {
            "none" => Split::None,
            "object" => Split::Object,
            _ => return None,
        };
        let vertices = match value("vertices")? {
            "referenced" => Vertices::Referenced,
            "all" => Vertices::All,
            _ => return None,
        };
        Some(Self { split, vertices })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn import_options_come_back_from_the_record() {
        for split in [Split::None, Split::Object] {
            for vertices in [Vertices::Referenced, Vertices::All] {
                for index in [IndexKind::TREE, IndexKind::Binary, IndexKind::None, IndexKind::CubeMap { resolution: 7 }]
                {
                    let import = ImportOptions { split, vertices };
                    let text = BuildOptions { import, index }.to_string();
                    assert_eq!(ImportOptions::from_recorded(&text), Some(import), "{text}");
                }
            }
        }
        assert_eq!(ImportOptions::from_recorded("split convex, vertices all, index tree"), None);
        assert_eq!(ImportOptions::from_recorded(""), None);
    }

    #[test]
    fn the_text_of_the_defaults_never_changes() {
        let import = ImportOptions { split: Split::None, vertices: Vertices::Referenced };
        let text = BuildOptions { import, index: IndexKind::TREE }.to_string();
        assert_eq!(text, "split none, vertices referenced, index tree 8");
    }
}
