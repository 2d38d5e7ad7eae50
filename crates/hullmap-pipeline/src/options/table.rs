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
    pub help: &'static str,
    pub section: Section,
    /// Whether `-h` leaves it out; `--help` lists every option.
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
    Shape,
    Parts,
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
    pub const ALL: [Self; 5] = [Self::Shape, Self::Parts, Self::Files, Self::Index, Self::Terrain];

    pub const fn heading(self) -> &'static str {
        match self {
            Self::Shape => "Shape",
            Self::Parts => "Parts",
            Self::Files => "Files",
            Self::Index => "Index",
            Self::Terrain => "Terrain",
        }
    }

    /// Its options: limits of a shape first, then in the order of the table.
    pub fn options(self) -> impl Iterator<Item = &'static BuildOption> {
        let of = move |is_limit: bool| {
            OPTIONS.iter().filter(move |own| own.section == self && (own.group == Group::Limit) == is_limit)
        };
        of(true).chain(of(false))
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
        value_name: "none|object|auto",
        help: "One hull per file, per object, or per collision part (glTF colliders, UCX_…)",
        section: Section::Parts,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "vertices",
        syntax: Words(&["referenced", "all"]),
        default: "referenced",
        value_name: "referenced|all",
        help: "Use the vertices that elements reference, or all vertices",
        section: Section::Shape,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "index",
        syntax: Words(&["tree", "medium", "compact", "binary", "cubemap", "none"]),
        default: "tree",
        value_name: "KIND",
        help: "Direction index: tree, medium, compact, binary, cubemap or none",
        section: Section::Index,
        record: Record::Always,
        ..OPTION
    },
    BuildOption {
        key: "unit_scale",
        syntax: Positive,
        default: "1",
        value_name: "F",
        help: "Multiply coordinates by F; 0.01 converts centimetres to metres",
        section: Section::Shape,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "up_axis",
        syntax: Words(&["keep", "y-to-z", "z-to-y"]),
        default: "keep",
        value_name: "keep|y-to-z|z-to-y",
        help: "Rotate about x: y-to-z turns a y-up mesh into a z-up mesh",
        section: Section::Shape,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "recentre",
        syntax: Switch,
        default: "false",
        value_name: "BOOL",
        help: "Move the origin to the centre of the bounds, for meshes far from the origin",
        section: Section::Shape,
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
        help: "Maximum number of vertices, 4 or more. Without --decompose: of an enclosing hull; default none, the exact hull. With --decompose: of each part; default 64",
        section: Section::Shape,
        group: Group::Limit,
        ..OPTION
    },
    BuildOption {
        key: "max_error",
        syntax: LengthOrNone,
        default: "none",
        value_name: "E|E%",
        help: "Maximum error: a length (2mm is 0.002 units of the mesh), or a share of the mesh's diagonal such as 1%. Without --decompose: how far an enclosing hull may extend beyond the exact one; default none, the exact hull. With --decompose: how far parts may protrude from the mesh's solid; default 2%",
        section: Section::Shape,
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
        is_advanced: true,
        scope: Scope::Parts,
        ..OPTION
    },
    BuildOption {
        key: "solid",
        syntax: Words(&["auto", "closed", "walls"]),
        default: "auto",
        value_name: "auto|closed|walls",
        help: "closed: close the holes of an open mesh, and count its inside; walls: count its walls only, so that openings stay open; auto: open surfaces are walls if half of their area has faces on both sides, a hole has more than an eighth of it, or all holes together more than all of it; closed surfaces are solid",
        section: Section::Parts,
        is_advanced: true,
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
        help: "Path of the mesh in the record of a pack: relative to the pack, only its name, or nothing",
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
        help: "Simplify hulls and parts to the limits of an engine: physx, physx-gpu, jolt, box3d, unity, unreal, newton or mujoco-warp",
        section: Section::Shape,
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
        help: "Write a static mesh of all triangles (.hullmesh) instead of hulls, for a level that does not move",
        section: Section::Shape,
        group: Group::Content,
        scope: Scope::Meshes,
        ..OPTION
    },
    BuildOption {
        key: "terrain",
        default: "false",
        value_name: "BOOL",
        help: "Bake a grid of heights as a height field (.hullfield): greyscale PNG, ESRI ASCII, raw f32",
        section: Section::Terrain,
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
    section: Section::Shape,
    is_advanced: false,
    group: Group::Single,
    scope: Scope::Hulls,
    record: Record::IfChanged,
};

const TERRAIN: BuildOption =
    BuildOption { default: "none", section: Section::Terrain, scope: Scope::Terrains, ..OPTION };

pub fn position(key: &str) -> Option<usize> {
    OPTIONS.iter().position(|option| option.key == key)
}
