//! The options that shape a bake, and the hash by which a pack remembers them.

use hullmap_bake::IndexKind;
use twox_hash::XxHash3_64;

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

impl BuildOptions {
    /// XXH3-64 of a text that spells the options out. It must never change for the same options.
    pub fn hash(&self) -> u64 {
        let split = match self.import.split {
            Split::None => "none",
            Split::Object => "object",
        };
        let vertices = match self.import.vertices {
            Vertices::Referenced => "referenced",
            Vertices::All => "all",
        };
        let index = match self.index {
            IndexKind::Tree => "tree".to_owned(),
            IndexKind::CubeMap { resolution } => format!("cubemap {resolution}"),
            IndexKind::None => "none".to_owned(),
        };
        XxHash3_64::oneshot(
            format!("split {split}\nvertices {vertices}\nindex {index}\n").as_bytes(),
        )
    }

    /// The options with this hash: a pack stores the hash alone, and there are few enough options to try them all.
    ///
    /// `None` where a later version of the tool, with more options, baked the pack.
    pub fn from_hash(hash: u64) -> Option<Self> {
        let cube_maps = (1..=MAX_RESOLUTION).map(|resolution| IndexKind::CubeMap { resolution });
        [IndexKind::Tree, IndexKind::None]
            .into_iter()
            .chain(cube_maps)
            .find_map(|index| {
                [Split::None, Split::Object].into_iter().find_map(|split| {
                    [Vertices::Referenced, Vertices::All]
                        .into_iter()
                        .find_map(|vertices| {
                            let options = Self {
                                import: ImportOptions { split, vertices },
                                index,
                            };
                            (options.hash() == hash).then_some(options)
                        })
                })
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn options(split: Split, vertices: Vertices, index: IndexKind) -> BuildOptions {
        BuildOptions {
            import: ImportOptions { split, vertices },
            index,
        }
    }

    #[test]
    fn options_come_back_from_their_hash() {
        let mut hashes = HashSet::new();
        for split in [Split::None, Split::Object] {
            for vertices in [Vertices::Referenced, Vertices::All] {
                for index in [
                    IndexKind::Tree,
                    IndexKind::None,
                    IndexKind::CubeMap { resolution: 1 },
                    IndexKind::CubeMap {
                        resolution: MAX_RESOLUTION,
                    },
                ] {
                    let options = options(split, vertices, index);
                    assert!(hashes.insert(options.hash()));
                    assert_eq!(BuildOptions::from_hash(options.hash()), Some(options));
                }
            }
        }
        assert_eq!(BuildOptions::from_hash(0), None);
    }

    #[test]
    fn the_hash_of_the_defaults_never_changes() {
        let defaults = options(Split::None, Vertices::Referenced, IndexKind::Tree);
        let text = "split none\nvertices referenced\nindex tree\n";
        assert_eq!(defaults.hash(), XxHash3_64::oneshot(text.as_bytes()));
    }
}
