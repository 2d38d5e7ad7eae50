//! The command line: what may be asked of `bake`.

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use hullmap_bake::IndexKind;

use crate::options::{BuildOptions, ImportOptions, MAX_RESOLUTION, Split, Vertices};

/// Cube-map resolution where none is asked for.
const DEFAULT_RESOLUTION: u32 = 64;

/// Directions that a verification tries on each hull where nothing else is asked for.
pub const DEFAULT_DIRECTIONS: usize = 10_000;

/// Turn render meshes into collision hulls, and check, describe and query them.
#[derive(Debug, Parser)]
#[command(name = "bake", version, after_help = "Exit: 0 done, 1 an input was found wanting, 2 usage or I/O.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake OBJ files into .hullmap packs
    #[command(after_help = "Example:\n  bake build assets --out baked --verify")]
    Build(BuildArgs),
    /// Check packs against the meshes they were baked from
    #[command(after_help = "Example:\n  bake verify baked --source assets --directions 200000")]
    Verify(VerifyArgs),
    /// Describe the hulls in a pack
    #[command(after_help = "Example:\n  bake inspect baked/gear.hullmap --json")]
    Inspect(InspectArgs),
    /// Intersection, distance or contact of two hulls
    #[command(after_help = "Example:\n  bake query baked/rock.hullmap baked/cube.hullmap --pose \"0.5 0 0 0 0 0 1\"")]
    Query(QueryArgs),
    /// Show packs on a page that any browser opens: meshes, hulls, indices, figures
    #[command(after_help = "Example:\n  bake report baked --out report.html")]
    Report(ReportArgs),
}

/// What `bake build` takes.
#[derive(Debug, clap::Args)]
pub struct BuildArgs {
    /// OBJ files, or folders to search for them
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Folder for the packs; it mirrors the folders of the input
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// One hull a file, or one for each `o` line
    #[arg(long, value_enum, default_value_t = Split::None, value_name = "none|object", hide_possible_values = true)]
    split: Split,
    /// The points that elements reference, or all
    #[arg(long, value_enum, default_value_t = Vertices::Referenced, value_name = "referenced|all", hide_possible_values = true)]
    vertices: Vertices,
    /// The direction index: tree, compact, binary, cubemap or none
    #[arg(long, value_enum, default_value_t = Index::Tree, value_name = "KIND", hide_possible_values = true)]
    index: Index,
    /// Instead of --index: the fastest one of at most this many bytes a hull vertex
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "index")]
    index_budget: Option<u32>,

    /// Cells along the edge of a cube face, 1 to 1024, for --index cubemap [default: 64]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RESOLUTION)))]
    resolution: Option<u32>,
    /// Verify each pack before it is put in place
    #[arg(long)]
    pub verify: bool,
    /// Threads to use [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Bake even what is up to date
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object a file
    #[arg(long)]
    pub json: bool,
}

/// The direction indices by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Index {
    /// The level-compressed tree over the six cube faces: the fastest
    Tree,
    /// The same with larger leaves: half the bytes
    Compact,
    /// The paper's binary tree
    Binary,
    /// A uniform cube map
    Cubemap,
    /// No index: every query scans all vertices
    None,
}

impl BuildArgs {
    /// The options that shape the packs.
    pub fn options(&self) -> BuildOptions {
        let index = match self.index {
            Index::Tree => IndexKind::TREE,
            Index::Compact => IndexKind::COMPACT,
            Index::Binary => IndexKind::Binary,
            Index::Cubemap => IndexKind::CubeMap { resolution: self.resolution.unwrap_or(DEFAULT_RESOLUTION) },
            Index::None => IndexKind::None,
        };
        let index = match self.index_budget {
            Some(bytes_per_vertex) => IndexKind::Budget { bytes_per_vertex },
            None => index,
        };
        BuildOptions { import: ImportOptions { split: self.split, vertices: self.vertices }, index }
    }
}

/// What `bake verify` takes.
#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Packs, or folders to search for them
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// The OBJ file, or a folder with the OBJ files [default: beside the pack, then at the
    /// path it records; where neither is there, the stored hull stands in]
    #[arg(long, value_name = "PATH")]
    pub source: Option<PathBuf>,
    /// Directions to try on each hull
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DIRECTIONS)]
    pub directions: usize,
    /// Seed of the random directions
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Print one JSON object a hull
    #[arg(long)]
    pub json: bool,
}

/// What `bake inspect` takes.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The pack
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What `bake query` takes.
#[derive(Debug, clap::Args)]
pub struct QueryArgs {
    /// First hull: FILE, FILE#name or FILE#number; results are in its frame
    #[arg(value_name = "A")]
    pub a: String,
    /// Second hull
    #[arg(value_name = "B")]
    pub b: String,
    /// Pose of B in A's frame: translation and quaternion; may be repeated [default: the identity]
    #[arg(long = "pose", value_name = "tx ty tz qx qy qz qw", allow_hyphen_values = true)]
    pub poses: Vec<String>,
    /// File with a pose a line (`-` reads standard input); `#` starts a remark
    #[arg(long = "poses", value_name = "FILE")]
    pub pose_file: Option<PathBuf>,
    /// What to compute
    #[arg(long, value_enum, default_value_t = Mode::Contact, value_name = "intersect|distance|contact", hide_possible_values = true)]
    pub mode: Mode,
    /// Print one JSON object a pose
    #[arg(long)]
    pub json: bool,
}

/// What `bake report` takes.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// The pack, or a folder to search for packs: then one page for all, and one for each in OUT's `.pages` folder
    #[arg(value_name = "FILE|DIR")]
    pub input: PathBuf,
    /// The page to write; it needs no other file and no network
    #[arg(long, value_name = "REPORT.html")]
    pub out: PathBuf,
    /// The source file, or a folder with the source files [default: found as by `bake verify`]
    #[arg(long, value_name = "PATH")]
    pub source: Option<PathBuf>,
    /// Which axis points up in the pictures
    #[arg(long, value_enum, default_value_t = Up::Z, value_name = "z|y", hide_possible_values = true)]
    pub up: Up,
    /// Directions in which each hull is verified
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DIRECTIONS, value_parser = at_least_one)]
    pub directions: usize,
    /// Seed of the random directions
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
}

/// An axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// As in Blender and Unreal
    Z,
    /// As in glTF, Unity and Godot
    Y,
}

/// A count that is at least 1.
fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("must be at least 1".to_owned()),
        Ok(count) => Ok(count),
        Err(error) => Err(error.to_string()),
    }
}

/// What a query computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// Whether they overlap
    Intersect,
    /// How far they are apart
    Distance,
    /// How deep they overlap, where and in which direction
    Contact,
}

/// Reads the command line.
///
/// # Errors
/// clap's error, which exits with 2 (or 0 for `--help` and `--version`).
pub fn parse<I, T>(words: I) -> Result<Cli, clap::Error>
where
    I: IntoIterator<Item = T>,
    T: Into<std::ffi::OsString> + Clone,
{
    let cli = Cli::try_parse_from(words)?;
    if let Command::Build(args) = &cli.command
        && args.resolution.is_some()
        && args.index != Index::Cubemap
    {
        let message = "--resolution belongs to --index cubemap; leave it out or choose that index";
        return Err(Cli::command().error(ErrorKind::ArgumentConflict, message));
    }
    if let Command::Verify(VerifyArgs { directions: 0, .. }) = &cli.command {
        return Err(Cli::command().error(ErrorKind::ValueValidation, "--directions must be at least 1"));
    }
    Ok(cli)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(words: &str) -> Result<BuildOptions, i32> {
        let line = format!("bake build in.obj --out out {words}");
        match parse(line.split_whitespace()) {
            Ok(Cli { command: Command::Build(args) }) => Ok(args.options()),
            Ok(_) => unreachable!(),
            Err(error) => Err(error.exit_code()),
        }
    }

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn build_options() {
        let import = ImportOptions { split: Split::None, vertices: Vertices::Referenced };
        assert_eq!(build(""), Ok(BuildOptions { import, index: IndexKind::TREE }));
        assert_eq!(build("--index none").unwrap().index, IndexKind::None);
        assert_eq!(build("--index compact").unwrap().index, IndexKind::COMPACT);
        assert_eq!(build("--index-budget 40").unwrap().index, IndexKind::Budget { bytes_per_vertex: 40 });
        assert_eq!(build("--index binary").unwrap().index, IndexKind::Binary);
        assert_eq!(build("--index cubemap").unwrap().index, IndexKind::CubeMap { resolution: 64 });
        assert_eq!(build("--index cubemap --resolution 1024").unwrap().index, IndexKind::CubeMap { resolution: 1024 });
        let import = ImportOptions { split: Split::Object, vertices: Vertices::All };
        assert_eq!(build("--split object --vertices all").unwrap().import, import);
    }

    #[test]
    fn wrong_arguments_exit_with_2() {
        for words in [
            "--index cubemap --resolution 0",
            "--index cubemap --resolution 1025",
            "--resolution 64",
            "--index-budget 0",
            "--index-budget 40 --index tree",
            "--index octree",
            "--split group",
            "--vertices some",
            "--jobs 0",
            "--jobs many",
            "--unknown",
        ] {
            assert_eq!(build(words), Err(2), "{words}");
        }
        for line in [
            "bake",
            "bake build",
            "bake build a.obj",
            "bake report x",
            "bake verify",
            "bake query a",
            "bake verify x --directions 0",
            "bake query a b --mode overlap",
        ] {
            assert_eq!(parse(line.split_whitespace()).unwrap_err().exit_code(), 2, "{line}");
        }
        assert_eq!(parse(["bake", "--help"]).unwrap_err().exit_code(), 0);
    }

    #[test]
    fn poses_may_start_with_a_minus() {
        let cli = parse(["bake", "query", "a", "b", "--pose", "-1 0 0 0 0 0 1", "--pose", "1 0 0 0 0 0 1"]).unwrap();
        let Command::Query(args) = cli.command else { unreachable!() };
        assert_eq!(args.poses.len(), 2);
    }

    #[test]
    fn a_wrong_value_is_told_the_right_ones() {
        let message = parse("bake build a --out b --split group".split_whitespace()).unwrap_err().to_string();
        assert!(message.contains("none, object"), "{message}");
    }

    #[test]
    fn every_subcommand_has_an_example() {
        for subcommand in Cli::command().get_subcommands() {
            let help = subcommand.clone().render_help().to_string();
            assert!(help.contains("Example:"), "{}", subcommand.get_name());
        }
    }
}
