//! The command line: what may be asked of `bake`.

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};

use crate::import::LimitArgs;
use crate::option_layer::OptionLayer;

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
    /// Bake source files into .hullmap packs
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
}

/// What `bake build` takes.
#[derive(Debug, clap::Args)]
pub struct BuildArgs {
    /// OBJ, glTF, GLB, STL and PLY files, or folders to search for them
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Folder for the packs; it mirrors the folders of the input
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What shapes the packs.
    #[command(flatten)]
    pub options: OptionLayer,
    /// What a source file may ask for.
    #[command(flatten)]
    pub limits: LimitArgs,
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

/// What `bake verify` takes.
#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Packs, or folders to search for them
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// The source file, or a folder with the source files [default: beside the pack, then at the
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
        && let Some((key, why)) = args.options.clash()
    {
        let message = format!("--{} {why}", key.replace('_', "-"));
        return Err(Cli::command().error(ErrorKind::ArgumentConflict, message));
    }
    if let Command::Verify(VerifyArgs { directions: 0, .. }) = &cli.command {
        return Err(Cli::command().error(ErrorKind::ValueValidation, "--directions must be at least 1"));
    }
    Ok(cli)
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::options::{BuildOptions, DecomposeOptions, ImportOptions, Simplify, Split, UpAxis, Vertices};

    fn build(words: &str) -> Result<BuildOptions, i32> {
        let line = format!("bake build in.obj --out out {words}");
        match parse(line.split_whitespace()) {
            Ok(Cli { command: Command::Build(args) }) => Ok(args.options.options()),
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
        let usual = BuildOptions::DEFAULT;
        assert_eq!(build(""), Ok(usual));
        assert_eq!(build("--index none").unwrap().index, IndexKind::None);
        assert_eq!(build("--index compact").unwrap().index, IndexKind::COMPACT);
        assert_eq!(build("--index-budget 40").unwrap().index, IndexKind::Budget { bytes_per_vertex: 40 });
        assert_eq!(build("--index binary").unwrap().index, IndexKind::Binary);
        assert_eq!(build("--index cubemap").unwrap().index, IndexKind::CubeMap { resolution: 64 });
        assert_eq!(build("--index cubemap --resolution 1024").unwrap().index, IndexKind::CubeMap { resolution: 1024 });
        let import = ImportOptions { split: Split::Object, vertices: Vertices::All, ..usual.import };
        assert_eq!(build("--split object --vertices all").unwrap().import, import);
        let import = ImportOptions { unit_scale: 0.01, up_axis: UpAxis::YToZ, recentre: true, ..usual.import };
        assert_eq!(build("--unit-scale 0.01 --up-axis y-to-z --recentre").unwrap().import, import);
        assert!(!build("--recentre=false").unwrap().import.recentre);
        assert_eq!(build("--max-vertices 64").unwrap().simplify, Simplify::MaxVertices(64));
        assert_eq!(build("--max-error 1e-3").unwrap().simplify, Simplify::MaxError(1e-3));
        let parts = DecomposeOptions { max_parts: 8, hull_approximation: false, ..DecomposeOptions::DEFAULT };
        let words = "--decompose --vhacd-max-parts 8 --vhacd-hull-approximation false";
        assert_eq!(build(words).unwrap().decompose, Some(parts));
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
            "--unit-scale 0",
            "--unit-scale nan",
            "--up-axis x",
            "--max-vertices 3",
            "--max-vertices 8 --max-error 1",
            "--vhacd-max-parts 8",
            "--decompose --vhacd-resolution 0",
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
        assert!(message.contains("none, object, auto"), "{message}");
    }

    #[test]
    fn every_subcommand_has_an_example() {
        for subcommand in Cli::command().get_subcommands() {
            let help = subcommand.clone().render_help().to_string();
            assert!(help.contains("Example:"), "{}", subcommand.get_name());
        }
    }
}
