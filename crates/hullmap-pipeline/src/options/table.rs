//! The table of all options that shape a file: key, accepted values, default, help.
//!
//! Flags, their help, the keys of `hullmap.toml`, its template, and the record in a pack come from
//! this table. Flags of a whole run (`--jobs`, `--verify`, …) are in `args.rs`.

use hullmap_format::header::FileKind;

use super::removed::instead_of_value;
use super::value::Syntax::{
    self, CountOrNone, Finite, FiniteOrNone, HoleOrNone, LengthOrNone, NameOrNone, PairOrNone, Positive,
    PositiveOrNone, SpacingOrNone, Switch, Words,
};
use super::value::Value;

#[derive(Debug)]
pub struct BuildOption {
    pub key: &'static str,
    pub syntax: Syntax,
    /// As in `hullmap.toml`, without quotes. With `decompose`, `none` of `max_error` and of
    /// `max_vertices` stands for the value in [`Cover::default`](hullmap_bake::decompose::Cover).
    pub default: &'static str,
    pub value_name: &'static str,
    /// `-h` has its first sentence.
    pub help: &'static str,
    pub section: Section,
    /// Whether the command line has it as `--set key=value`, not as a flag of its own.
    pub is_advanced: bool,
    pub group: Group,
    pub scope: Scope,
    pub record: Record,
}

impl BuildOption {
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        self.syntax.parse(text).map_err(|expected| match instead_of_value(self.key, text) {
            Some(instead) => instead.to_owned(),
            None => expected,
        })
    }
}

/// The contents that an option applies to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Packs.
    Hulls,
    /// Packs of decomposed meshes.
    Parts,
    /// Packs and triangle meshes.
    Meshes,
    /// Height fields.
    Terrains,
    All,
}

impl Scope {
    pub fn includes(self, kind: FileKind) -> bool {
        match self {
            Self::Hulls | Self::Parts => kind == FileKind::Pack,
            Self::Meshes => kind != FileKind::HeightField,
            Self::Terrains => kind == FileKind::HeightField,
            Self::All => true,
        }
    }
}

/// Section of the help, by what an option changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    Parts,
    Mesh,
    Files,
    Index,
    Terrain,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    Single,
    Limit,
    /// Decides which kind of file a source becomes.
    Content,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    Always,
    /// Only if it differs from its default: options that are newer than the first packs.
    IfChanged,
    /// Never: an option that changes no hull.
    Never,
}

impl Section {
    pub const ALL: [Self; 5] = [Self::Parts, Self::Mesh, Self::Files, Self::Index, Self::Terrain];

    pub const fn heading(self) -> &'static str {
        match self {
            Self::Parts => "Hulls and parts",
            Self::Mesh => "Mesh",
            Self::Files => "Files",
            Self::Index => "Index",
            Self::Terrain => "Terrain",
        }
    }

    /// Its options: the ones that most bakes need first, then in the order of the table.
    pub fn options(self) -> impl Iterator<Item = &'static BuildOption> {
        const FIRST: [&str; 4] = ["decompose", "max_parts", "max_error", "max_vertices"];
        let mut own: Vec<_> = OPTIONS.iter().filter(|option| option.section == self).collect();
        own.sort_by_key(|option| FIRST.iter().position(|key| *key == option.key).unwrap_or(FIRST.len()));
        own.into_iter()
    }
}

const MIN_VERTICES: u32 = 4;

/// Every option, in the order of a pack's record. **This order and the defaults never change**:
/// records would change, and with them the hashes by which packs are found fresh.
pub static OPTIONS: [BuildOption; OPTION_COUNT] = [
    BuildOption {
        key: "split",
        syntax: Words(&["none", "object", "auto"]),
        default: "none",
        value_name: "UNIT",
        help: "One hull per file (none), object, or collision part (auto)",
        section: Section::Mesh,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "vertices",
        syntax: Words(&["referenced", "all"]),
        default: "referenced",
        value_name: "referenced|all",
        help: "Use the vertices that elements reference, or all vertices",
        section: Section::Mesh,
        is_advanced: true,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "index",
        syntax: Words(&["tree", "medium", "compact", "binary", "cubemap", "none"]),
        default: "tree",
        value_name: "tree|medium|compact|binary|cubemap|none",
        help: "Direction index; medium and compact are smaller than tree",
        section: Section::Index,
        is_advanced: true,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "unit_scale",
        syntax: Positive,
        default: "1",
        value_name: "F",
        help: "Multiply coordinates by F; 0.01 turns centimetres into metres",
        section: Section::Mesh,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "up_axis",
        syntax: Words(&["keep", "y-to-z", "z-to-y"]),
        default: "keep",
        value_name: "TURN",
        help: "Rotate: keep, y-to-z (y-up becomes z-up) or z-to-y",
        section: Section::Mesh,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "recentre",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Move the origin to the centre of the bounds, for meshes far from the origin",
        section: Section::Mesh,
        is_advanced: true,
        ..OPTION
    },
    BuildOption {
        key: "decompose",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Decompose concave meshes into convex parts",
        section: Section::Parts,
        ..OPTION
    },
    BuildOption {
        key: "max_vertices",
        syntax: CountOrNone { min: MIN_VERTICES },
        default: "none",
        value_name: "N",
        help: "Maximum number of vertices of a hull (default all) or part (default 64)",
        section: Section::Parts,
        group: Group::Limit,
        ..OPTION
    },
    BuildOption {
        key: "max_error",
        syntax: LengthOrNone,
        default: "none",
        value_name: "E|E%",
        help: "Maximum protrusion of a hull (default exact) or part (default 2%). A length (2mm is 0.002 units of the mesh), or a share of the diagonal such as 1%",
        section: Section::Parts,
        group: Group::Limit,
        ..OPTION
    },
    BuildOption {
        key: "pack_names",
        syntax: Words(&["auto", "stem", "full"]),
        default: "auto",
        value_name: "auto|stem|full",
        help: "Names of packs: x (stem), x.obj (full), or full on a clash (auto)",
        section: Section::Files,
        is_advanced: true,
        record: Record::Never,
        scope: Scope::All,
        ..OPTION
    },
    BuildOption {
        key: "max_parts",
        syntax: CountOrNone { min: 1 },
        default: "none",
        value_name: "N",
        help: "Maximum number of parts; the search then looks for the smallest error",
        section: Section::Parts,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "solid",
        syntax: Words(&["auto", "closed", "walls"]),
        default: "auto",
        value_name: "RULE",
        help: "Solid of an open mesh: closed (its inside), walls (openings stay open), or auto, which decides by the sizes of walls and holes",
        section: Section::Parts,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "wall",
        syntax: LengthOrNone,
        default: "0.5%",
        value_name: "T|T%",
        help: "Thickness of the parts of walls: a length, or a share of the mesh's diagonal; at most half of the maximum error",
        section: Section::Parts,
        is_advanced: true,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "decompose_seconds",
        syntax: PositiveOrNone,
        default: "none",
        value_name: "S",
        help: "Find and measure the parts of a mesh within S seconds; the error may then exceed the limit, and packs may differ from run to run",
        section: Section::Parts,
        is_advanced: true,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "record_source",
        syntax: Words(&["relative", "name", "none"]),
        default: "relative",
        value_name: "relative|name|none",
        help: "Path of the mesh in the record of a pack: relative to the pack (if both lie below the folder where bake starts), only its name, or nothing",
        section: Section::Files,
        is_advanced: true,
        record: Record::Never,
        scope: Scope::All,
        ..OPTION
    },
    BuildOption {
        key: "lean",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Leave out data that only manifolds, hints and walks over the surface need; packs have less than half the size",
        section: Section::Files,
        is_advanced: true,
        ..OPTION
    },
    BuildOption {
        key: "for_engine",
        syntax: Words(&crate::budget::NAMES),
        default: "none",
        value_name: "ENGINE",
        help: "Meet the limits of an engine. One of physx, physx-gpu, jolt, box3d, unity, unreal, newton or mujoco-warp",
        section: Section::Parts,
        ..OPTION
    },
    BuildOption {
        key: "primitives",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Record a box, sphere, capsule or cylinder for each part that it can replace within both bounds, and export it instead of the hull",
        section: Section::Parts,
        is_advanced: true,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "keep_triangles",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Keep all triangles, as a static mesh (.hullmesh) instead of hulls",
        section: Section::Mesh,
        group: Group::Content,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "terrain",
        default: "false",
        value_name: "BOOL",
        help: "Bake grids of heights (.asc, .png, .f32) as height fields",
        section: Section::Mesh,
        group: Group::Content,
        scope: Scope::All,
        ..OPTION
    },
    BuildOption {
        key: "spacing",
        syntax: SpacingOrNone,
        value_name: "X[,Y]",
        help: "Distance between vertices; PNG and raw files require it",
        ..TERRAIN
    },
    BuildOption {
        key: "height_scale",
        syntax: FiniteOrNone,
        value_name: "S",
        help: "Height of white above black, which PNG requires, or a factor",
        ..TERRAIN
    },
    BuildOption {
        key: "height_offset",
        syntax: Finite,
        default: "0",
        value_name: "O",
        help: "Height of a sample of 0",
        ..TERRAIN
    },
    BuildOption {
        key: "origin",
        syntax: PairOrNone,
        value_name: "X,Y",
        help: "First vertex; default: stated in the file, or such that the field is centred at 0 0",
        ..TERRAIN
    },
    BuildOption {
        key: "hole",
        syntax: HoleOrNone,
        value_name: "V",
        help: "Sample that means no ground, compared as samples are stored",
        ..TERRAIN
    },
    BuildOption {
        key: "hole_image",
        syntax: NameOrNone,
        value_name: "NAME",
        help: "PNG beside the source in which black pixels are holes",
        ..TERRAIN
    },
    BuildOption {
        key: "rows",
        syntax: CountOrNone { min: 2 },
        value_name: "N",
        help: "Number of rows of raw numbers; the first has the least y",
        ..TERRAIN
    },
    BuildOption {
        key: "columns",
        syntax: CountOrNone { min: 2 },
        value_name: "N",
        help: "Number of columns of raw numbers",
        ..TERRAIN
    },
    BuildOption {
        key: "diagonal",
        syntax: Words(&["rising", "falling"]),
        default: "rising",
        value_name: "rising|falling",
        help: "Diagonal that divides each cell",
        ..TERRAIN
    },
];

pub const OPTION_COUNT: usize = 29;

const OPTION: BuildOption = BuildOption {
    key: "",
    syntax: Switch,
    default: "false",
    value_name: "",
    help: "",
    section: Section::Parts,
    is_advanced: false,
    group: Group::Single,
    scope: Scope::Hulls,
    record: Record::IfChanged,
};

const TERRAIN: BuildOption =
    BuildOption { default: "none", section: Section::Terrain, is_advanced: true, scope: Scope::Terrains, ..OPTION };

pub fn position(key: &str) -> Option<usize> {
    OPTIONS.iter().position(|option| option.key == key)
}

/// The name of an option in `hullmap.toml` and on the command line. Records and bindings have its
/// key, since `for` is a keyword of Python.
pub fn name(key: &str) -> &str {
    if key == "for_engine" { "for" } else { key }
}

/// The option of a [`name`].
pub fn named(text: &str) -> Option<usize> {
    OPTIONS.iter().position(|option| name(option.key) == text)
}
