//! The options that shape a bake, and the text by which a pack remembers them.
//!
//! An [`OptionLayer`] says where an option comes from: the command line, a rule, the defaults of a file. The options
//! here are what is left when the layers lie on each other, with nothing undecided.

use std::fmt;

use hullmap_bake::{IndexKind, LeafBlocks};
use hullmap_import::ImportOptions;

use crate::option_layer::OptionLayer;

/// Greatest cube-map resolution that may be asked for.
pub const MAX_RESOLUTION: u32 = 1024;

/// Cube-map resolution where none is asked for.
pub const DEFAULT_RESOLUTION: u32 = 64;

/// How V-HACD counts the inside of a voxelised mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Fill {
    /// What the outside cannot reach is inside.
    Flood,
    /// The same, but closed cavities count as outside.
    Cavities,
    /// The surface's voxels alone: for open meshes.
    Surface,
}

/// How a concave mesh is cut into convex parts: the parameters of V-HACD. The defaults are those of parry3d 0.31,
/// written down here, so that a recorded text keeps its meaning whatever parry3d does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecomposeOptions {
    /// Volume by which a part may differ from its hull, relative to the whole, 0 to 1.
    pub concavity: f32,
    /// Voxels along the mesh's longest side, 1 to [`MAX_VOXELS`](DecomposeOptions::MAX_VOXELS).
    pub resolution: u32,
    /// Most parts, at least 1.
    pub max_parts: u32,
    /// Weight of cuts into halves of equal volume, 0 to 1.
    pub alpha: f32,
    /// Weight of cuts through an axis of revolution, 0 to 1.
    pub beta: f32,
    /// Every how many-th cutting plane is tried, 1 to [`MAX_DOWNSAMPLING`](DecomposeOptions::MAX_DOWNSAMPLING).
    pub plane_downsampling: u32,
    /// Every how many-th voxel a trial hull is of, 1 to [`MAX_DOWNSAMPLING`](DecomposeOptions::MAX_DOWNSAMPLING).
    pub hull_downsampling: u32,
    /// Whether trial hulls are of voxels rather than of the mesh.
    pub hull_approximation: bool,
    /// What is inside.
    pub fill: Fill,
}

impl DecomposeOptions {
    /// What is used where nothing is asked for.
    pub const DEFAULT: Self = Self {
        concavity: 0.01,
        resolution: 64,
        max_parts: 1024,
        alpha: 0.05,
        beta: 0.05,
        plane_downsampling: 4,
        hull_downsampling: 4,
        hull_approximation: true,
        fill: Fill::Flood,
    };
    /// Greatest voxel resolution: its cube is the number of voxels, 134 million.
    pub const MAX_VOXELS: u32 = 512;
    /// Greatest downsampling of planes and hulls, as in V-HACD itself.
    pub const MAX_DOWNSAMPLING: u32 = 16;
}

/// Whether a hull is replaced by an outer one of fewer vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Simplify {
    /// No: it is exact.
    None,
    /// One with at most this many vertices, at least [`MIN_VERTICES`](Simplify::MIN_VERTICES).
    MaxVertices(u32),
    /// One that leaves the hull by at most this length, above 0, in units of the scaled source.
    MaxError(f64),
}

impl Simplify {
    /// The fewest vertices that can hold a solid.
    pub const MIN_VERTICES: u32 = 4;
}

/// Everything, beside the source's bytes, that the bytes of a pack depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// How the source is read.
    pub import: ImportOptions,
    /// Whether and how each point set is cut into convex parts.
    pub decompose: Option<DecomposeOptions>,
    /// Whether hulls are simplified.
    pub simplify: Simplify,
    /// Which direction index is built.
    pub index: IndexKind,
}

impl BuildOptions {
    /// What is used where nothing is asked for.
    pub const DEFAULT: Self =
        Self { import: ImportOptions::DEFAULT, decompose: None, simplify: Simplify::None, index: IndexKind::TREE };
}

/// The direction indices by the names that command line, `hullmap.toml` and `bake inspect` have for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum IndexName {
    /// The level-compressed tree over the six cube faces, with leaves of 8: the fastest
    Tree,
    /// The same with leaves of 16
    Medium,
    /// The same with leaves of 32: half the bytes
    Compact,
    /// The paper's binary tree
    Binary,
    /// A uniform cube map
    Cubemap,
    /// No index: every query scans all vertices
    None,
}

impl IndexName {
    /// The name of the tree whose leaves have this many candidates.
    pub fn of_tree(leaf: usize) -> Self {
        match leaf {
            0..=8 => Self::Tree,
            9..=16 => Self::Medium,
            _ => Self::Compact,
        }
    }

    /// The index of this name; `resolution` is that of a cube map.
    pub fn kind(self, resolution: u32) -> IndexKind {
        match self {
            Self::Tree => IndexKind::TREE,
            Self::Medium => IndexKind::Tree { leaf_blocks: LeafBlocks::Two },
            Self::Compact => IndexKind::COMPACT,
            Self::Binary => IndexKind::Binary,
            Self::Cubemap => IndexKind::CubeMap { resolution },
            Self::None => IndexKind::None,
        }
    }
}

/// The one word for a value, on the command line, in `hullmap.toml` and in packs.
pub fn word<T: clap::ValueEnum>(value: &T) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// The options as a pack records them: `split none, vertices referenced, index cubemap 64`. Options that are newer
/// than these three follow where they differ from their defaults, in a fixed order: `…, unit_scale 0.01, recentre true`.
///
/// Equal options have equal texts in every version of the tool: a pack is fresh while the hash of this text is that in
/// its header.
impl fmt::Display for BuildOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let import = &self.import;
        write!(f, "split {}, vertices {}, index ", word(&import.split), word(&import.vertices))?;
        match self.index {
            IndexKind::Tree { leaf_blocks } => write!(f, "tree {}", leaf_blocks.lanes())?,
            IndexKind::Budget { bytes_per_vertex } => write!(f, "budget {bytes_per_vertex}")?,
            IndexKind::Binary => f.write_str("binary")?,
            IndexKind::CubeMap { resolution } => write!(f, "cubemap {resolution}")?,
            IndexKind::None => f.write_str("none")?,
        }
        // Numbers in their shortest decimal form that reads back as the same number.
        let mut others: Vec<(&str, String)> = Vec::new();
        let mut put = |differs: bool, key: &'static str, value: String| {
            if differs {
                others.push((key, value));
            }
        };
        let usual = ImportOptions::DEFAULT;
        put(import.unit_scale != usual.unit_scale, "unit_scale", import.unit_scale.to_string());
        put(import.up_axis != usual.up_axis, "up_axis", word(&import.up_axis));
        put(import.recentre, "recentre", "true".to_owned());
        if let Some(parts) = &self.decompose {
            let usual = DecomposeOptions::DEFAULT;
            put(true, "decompose", "true".to_owned());
            put(parts.concavity != usual.concavity, "vhacd_concavity", parts.concavity.to_string());
            put(parts.resolution != usual.resolution, "vhacd_resolution", parts.resolution.to_string());
            put(parts.max_parts != usual.max_parts, "vhacd_max_parts", parts.max_parts.to_string());
            put(parts.alpha != usual.alpha, "vhacd_alpha", parts.alpha.to_string());
            put(parts.beta != usual.beta, "vhacd_beta", parts.beta.to_string());
            let planes = parts.plane_downsampling;
            put(planes != usual.plane_downsampling, "vhacd_plane_downsampling", planes.to_string());
            let hulls = parts.hull_downsampling;
            put(hulls != usual.hull_downsampling, "vhacd_hull_downsampling", hulls.to_string());
            put(!parts.hull_approximation, "vhacd_hull_approximation", "false".to_owned());
            put(parts.fill != usual.fill, "vhacd_fill", word(&parts.fill));
        }
        match self.simplify {
            Simplify::None => {}
            Simplify::MaxVertices(count) => put(true, "max_vertices", count.to_string()),
            Simplify::MaxError(error) => put(true, "max_error", error.to_string()),
        }
        others.iter().try_for_each(|(key, value)| write!(f, ", {key} {value}"))
    }
}

impl BuildOptions {
    /// The options for people: as recorded, but with the index by its name on the command line.
    pub fn in_words(&self) -> String {
        let text = self.to_string();
        let IndexKind::Tree { leaf_blocks } = self.index else {
            return text;
        };
        let leaf = leaf_blocks.lanes();
        text.replacen(&format!("index tree {leaf}"), &format!("index {}", word(&IndexName::of_tree(leaf))), 1)
    }

    /// The options with this text: what [`Display`](fmt::Display) wrote comes back as it was.
    ///
    /// `None` where a version of the tool with other options baked the pack.
    pub fn from_recorded(text: &str) -> Option<Self> {
        let mut layer = OptionLayer::default();
        let mut index = None;
        for part in text.split(", ") {
            let (key, value) = part.split_once(' ')?;
            if key == "index" {
                index = Some(index_from_recorded(value)?);
            } else {
                layer.set(key, value).ok()?;
            }
        }
        // These two were there from the start.
        let is_whole = layer.split.is_some() && layer.vertices.is_some();
        index.filter(|_| is_whole).map(|index| Self { index, ..layer.options() })
    }
}

/// A number alone, as `budget 40` states it; a tree without one, as the first packs had it, is the default tree.
fn index_from_recorded(text: &str) -> Option<IndexKind> {
    let (name, number) = text.split_once(' ').map_or((text, None), |(name, number)| (name, Some(number)));
    let number: Option<u32> = number.map(|number| number.parse().ok()).map_or(Some(None), |number| number.map(Some))?;
    match (name, number) {
        ("tree", None | Some(8)) => Some(IndexKind::TREE),
        ("tree", Some(16)) | ("medium", None) => Some(IndexKind::Tree { leaf_blocks: LeafBlocks::Two }),
        ("tree", Some(32)) | ("compact", None) => Some(IndexKind::COMPACT),
        ("budget", Some(bytes_per_vertex)) => Some(IndexKind::Budget { bytes_per_vertex }),
        ("cubemap", Some(resolution)) => Some(IndexKind::CubeMap { resolution }),
        ("binary", None) => Some(IndexKind::Binary),
        ("none", None) => Some(IndexKind::None),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use hullmap_import::{Split, UpAxis, Vertices};

    use super::*;

    const INDICES: [IndexKind; 7] = [
        IndexKind::TREE,
        IndexKind::Tree { leaf_blocks: LeafBlocks::Two },
        IndexKind::COMPACT,
        IndexKind::Budget { bytes_per_vertex: 40 },
        IndexKind::Binary,
        IndexKind::None,
        IndexKind::CubeMap { resolution: 7 },
    ];

    /// Options that differ from the default in one thing each, and some in several.
    fn samples() -> Vec<BuildOptions> {
        let usual = BuildOptions::DEFAULT;
        let import = |import| BuildOptions { import, ..usual };
        let parts = |parts| BuildOptions { decompose: Some(parts), ..usual };
        let plain = ImportOptions::DEFAULT;
        let cut = DecomposeOptions::DEFAULT;
        let mut all = vec![
            usual,
            import(ImportOptions { split: Split::Object, ..plain }),
            import(ImportOptions { split: Split::Auto, ..plain }),
            import(ImportOptions { vertices: Vertices::All, ..plain }),
            import(ImportOptions { unit_scale: 0.0254, ..plain }),
            import(ImportOptions { unit_scale: 1e-30, ..plain }),
            import(ImportOptions { unit_scale: 1e300, ..plain }),
            import(ImportOptions { up_axis: UpAxis::YToZ, ..plain }),
            import(ImportOptions { up_axis: UpAxis::ZToY, ..plain }),
            import(ImportOptions { recentre: true, ..plain }),
            parts(cut),
            parts(DecomposeOptions { concavity: 0.1, ..cut }),
            parts(DecomposeOptions { resolution: 128, ..cut }),
            parts(DecomposeOptions { max_parts: 7, ..cut }),
            parts(DecomposeOptions { alpha: 0.1, ..cut }),
            parts(DecomposeOptions { beta: 0.0, ..cut }),
            parts(DecomposeOptions { plane_downsampling: 1, ..cut }),
            parts(DecomposeOptions { hull_downsampling: 16, ..cut }),
            parts(DecomposeOptions { hull_approximation: false, ..cut }),
            parts(DecomposeOptions { fill: Fill::Cavities, ..cut }),
            parts(DecomposeOptions { fill: Fill::Surface, ..cut }),
            BuildOptions { simplify: Simplify::MaxVertices(64), ..usual },
            BuildOptions { simplify: Simplify::MaxError(1e-3), ..usual },
            BuildOptions { simplify: Simplify::MaxError(0.5), ..parts(DecomposeOptions { max_parts: 2, ..cut }) },
        ];
        all.extend(INDICES[1..].iter().map(|&index| BuildOptions { index, ..usual }));
        all
    }

    #[test]
    fn options_come_back_from_the_record() {
        for options in samples() {
            let text = options.to_string();
            assert_eq!(BuildOptions::from_recorded(&text), Some(options), "{text}");
            assert_eq!(BuildOptions::from_recorded(&text).map(|read| read.import), Some(options.import), "{text}");
            let words = options.in_words();
            assert_eq!(BuildOptions::from_recorded(&words), Some(options), "{words}");
            assert!(!words.contains("tree "), "{words}");
        }
        for text in [
            "",
            "split convex, vertices all, index tree 8",
            "split none, index tree 8",
            "split none, vertices all",
            "split none, vertices all, index tree 12",
            "split none, vertices all, index cubemap",
            "split none, vertices all, index tree 8, mirror x",
            "split none, vertices all, index tree 8, unit_scale 0",
            "split none, vertices all, index tree 8, unit_scale nan",
            "split none, vertices all, index tree 8, recentre",
        ] {
            assert_eq!(BuildOptions::from_recorded(text), None, "{text}");
        }
    }

    #[test]
    fn different_options_have_different_texts() {
        let texts: std::collections::BTreeSet<String> = samples().iter().map(BuildOptions::to_string).collect();
        assert_eq!(texts.len(), samples().len());
    }

    /// Packs are fresh by these texts: a change here makes every pack in the world stale.
    #[test]
    fn the_texts_never_change() {
        let texts: Vec<String> = samples().iter().map(BuildOptions::to_string).collect();
        assert_eq!(texts[0], "split none, vertices referenced, index tree 8");
        for text in [
            "split none, vertices referenced, index budget 40",
            "split none, vertices referenced, index cubemap 7",
            "split auto, vertices referenced, index tree 8",
            "split none, vertices referenced, index tree 8, unit_scale 0.0254",
            "split none, vertices referenced, index tree 8, up_axis y-to-z",
            "split none, vertices referenced, index tree 8, recentre true",
            "split none, vertices referenced, index tree 8, decompose true",
            "split none, vertices referenced, index tree 8, decompose true, vhacd_fill surface",
            "split none, vertices referenced, index tree 8, decompose true, vhacd_max_parts 2, max_error 0.5",
            "split none, vertices referenced, index tree 8, max_vertices 64",
        ] {
            assert!(texts.iter().any(|known| known == text), "{text} in {texts:#?}");
        }
    }

    #[test]
    fn the_first_packs_named_the_tree_alone() {
        let text = "split none, vertices referenced, index tree";
        assert_eq!(BuildOptions::from_recorded(text), Some(BuildOptions::DEFAULT));
    }
}
