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
    /// The help of the command has its first sentence, docs/COMMAND.md all of it.
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
    option("split", Words(&["none", "object", "auto"]), "none", "none|object|auto", Section::Mesh)
        .help("One hull per file, object, or collision part. The values are none, object and auto, in this order")
        .recorded(Record::Always),
    option("vertices", Words(&["referenced", "all"]), "referenced", "referenced|all", Section::Mesh)
        .help("Use the vertices that elements reference, or all vertices")
        .advanced()
        .recorded(Record::Always),
    option(
        "index",
        Words(&["tree", "medium", "compact", "binary", "cubemap", "none"]),
        "tree",
        "tree|medium|compact|binary|cubemap|none",
        Section::Index,
    )
    .help("Direction index; medium and compact are smaller than tree")
    .advanced()
    .recorded(Record::Always),
    option("unit_scale", Positive, "1", "F", Section::Mesh)
        .help("Multiply coordinates by F. 0.01 turns centimetres into metres")
        .within(Scope::Meshes),
    option("up_axis", Words(&["keep", "y-to-z", "z-to-y"]), "keep", "TURN", Section::Mesh)
        .help("Rotate: y-to-z or z-to-y. y-to-z turns a y-up mesh into a z-up one")
        .within(Scope::Meshes),
    option("recentre", Switch, "false", "BOOL", Section::Mesh)
        .help("Move the origin to the centre of the bounds, for meshes far from the origin")
        .advanced(),
    option("decompose", Switch, "false", "BOOL", Section::Parts).help("Decompose concave meshes into convex parts"),
    option("max_vertices", CountOrNone { min: MIN_VERTICES }, "none", "N", Section::Parts)
        .help("Maximum number of vertices (hulls: all; parts: 64)")
        .grouped(Group::Limit),
    option("max_error", LengthOrNone, "none", "E|E%", Section::Parts)
        .help(
            "Maximum protrusion (hulls: exact; parts: 2%). A length (2mm is 0.002 units of the mesh), or a share \
                 of the diagonal such as 1%",
        )
        .grouped(Group::Limit),
    option("pack_names", Words(&["auto", "stem", "full"]), "auto", "auto|stem|full", Section::Files)
        .help("Names of packs: x (stem), x.obj (full), or full on a clash (auto)")
        .advanced()
        .recorded(Record::Never)
        .within(Scope::All),
    option("max_parts", CountOrNone { min: 1 }, "none", "N", Section::Parts)
        .help("Maximum number of parts. The search then looks for the smallest error")
        .within(Scope::Parts),
    option("solid", Words(&["auto", "closed", "walls"]), "auto", "RULE", Section::Parts)
        .help(
            "Solid of an open mesh: closed, walls or auto. The solid is its inside (closed), its triangles (walls), or as \
                 the sizes of walls and holes say (auto)",
        )
        .within(Scope::Parts),
    option("wall", LengthOrNone, "0.5%", "T|T%", Section::Parts)
        .help(
            "Thickness of the parts of walls: a length, or a share of the mesh's diagonal; at most half of the \
                 maximum error",
        )
        .advanced()
        .within(Scope::Parts),
    option("decompose_seconds", PositiveOrNone, "none", "S", Section::Parts)
        .help(
            "Find and measure the parts of a mesh within S seconds; the error may then exceed the limit, and \
                 packs may differ from run to run",
        )
        .advanced()
        .within(Scope::Parts),
    option("record_source", Words(&["relative", "name", "none"]), "relative", "relative|name|none", Section::Files)
        .help(
            "Path of the mesh in the record of a pack: relative to the pack (if both lie below the folder where \
                 bake starts), only its name, or nothing",
        )
        .advanced()
        .recorded(Record::Never)
        .within(Scope::All),
    option("lean", Switch, "false", "BOOL", Section::Files)
        .help(
            "Leave out data that only manifolds, hints and walks over the surface need; packs have less than \
                 half the size",
        )
        .advanced(),
    option("for_engine", Words(&crate::budget::NAMES), "none", "ENGINE", Section::Parts).help(
        "Meet the limits of an engine. One of physx, physx-gpu, jolt, box3d, unity, unreal, newton or \
                 mujoco-warp",
    ),
    option("primitives", Switch, "false", "BOOL", Section::Parts)
        .help(
            "Record a box, sphere, capsule or cylinder for each part that it can replace within both bounds, and \
                 export it instead of the hull",
        )
        .advanced()
        .within(Scope::Parts),
    option("keep_triangles", Switch, "false", "BOOL", Section::Mesh)
        .help("Keep all triangles, as a static mesh. The file is a .hullmesh, without hulls")
        .grouped(Group::Content)
        .within(Scope::Meshes),
    option("terrain", Switch, "false", "BOOL", Section::Mesh)
        .help("Bake .asc, .png and .f32 as height fields. Such files are grids of heights")
        .grouped(Group::Content)
        .within(Scope::All),
    terrain_option("spacing", SpacingOrNone, "none", "X[,Y]")
        .help("Distance between vertices; PNG and raw files require it"),
    terrain_option("height_scale", FiniteOrNone, "none", "S")
        .help("Height of white above black, which PNG requires, or a factor"),
    terrain_option("height_offset", Finite, "0", "O").help("Height of a sample of 0"),
    terrain_option("origin", PairOrNone, "none", "X,Y")
        .help("First vertex; default: stated in the file, or such that the field is centred at 0 0"),
    terrain_option("hole", HoleOrNone, "none", "V").help("Sample that means no ground, compared as samples are stored"),
    terrain_option("hole_image", NameOrNone, "none", "NAME")
        .help("PNG beside the source in which black pixels are holes"),
    terrain_option("rows", CountOrNone { min: 2 }, "none", "N")
        .help("Number of rows of raw numbers; the first has the least y"),
    terrain_option("columns", CountOrNone { min: 2 }, "none", "N").help("Number of columns of raw numbers"),
    terrain_option("diagonal", Words(&["rising", "falling"]), "rising", "rising|falling")
        .help("Diagonal that divides each cell"),
];

pub const OPTION_COUNT: usize = 29;

/// An option of packs, which is recorded if it differs from its default.
const fn option(
    key: &'static str,
    syntax: Syntax,
    default: &'static str,
    value_name: &'static str,
    section: Section,
) -> BuildOption {
    let (help, is_advanced, group) = ("", false, Group::Single);
    let (scope, record) = (Scope::Hulls, Record::IfChanged);
    BuildOption { key, syntax, default, value_name, help, section, is_advanced, group, scope, record }
}

const fn terrain_option(
    key: &'static str,
    syntax: Syntax,
    default: &'static str,
    value_name: &'static str,
) -> BuildOption {
    option(key, syntax, default, value_name, Section::Terrain).advanced().within(Scope::Terrains)
}

impl BuildOption {
    const fn help(self, help: &'static str) -> Self {
        Self { help, ..self }
    }

    const fn advanced(self) -> Self {
        Self { is_advanced: true, ..self }
    }

    const fn recorded(self, record: Record) -> Self {
        Self { record, ..self }
    }

    const fn grouped(self, group: Group) -> Self {
        Self { group, ..self }
    }

    const fn within(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }
}

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
