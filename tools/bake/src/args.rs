//! The command line: what may be asked of `bake`.

use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};

use hullmap_import::Limits;

use crate::option_layer::OptionLayer;

/// Directions that a verification tries on each hull where nothing else is asked for.
pub const DEFAULT_DIRECTIONS: usize = 10_000;

/// Memory in bytes that the files in work may take where nothing else is asked for: what a machine of 8 GiB can spare.
pub const DEFAULT_MEMORY: u64 = 4 << 30;

/// Turn render meshes into collision hulls, and check, describe and query them.
#[derive(Debug, Parser)]
#[command(
    name = "bake",
    version,
    disable_help_subcommand = true,
    after_help = "Start with `bake build FOLDER --out DIR`; `bake COMMAND --help` tells more.\n\
                  Exit: 0 done, 1 an input was found wanting, 2 usage or I/O, 130 Ctrl-C."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake meshes into .hullmap packs
    #[command(after_help = "Examples:\n  \
                      bake build assets --out baked --verify\n  \
                      bake build assets --out baked --check          (for CI: exit 1 if anything is stale)\n  \
                      bake build rock.obj --out baked --index compact --depfile rock.d")]
    Build(Box<BuildArgs>),
    /// Check packs against the meshes they were baked from
    #[command(after_help = "Example:\n  bake verify baked --source assets --directions 200000")]
    Verify(VerifyArgs),
    /// Describe the hulls in packs
    #[command(after_help = "Example:\n  bake inspect baked/gear.hullmap --json")]
    Inspect(InspectArgs),
    /// Intersection, distance or contact of two hulls or packs
    #[command(after_help = "Example:\n  bake query baked/rock.hullmap baked/cube.hullmap --pose \"0.5 0 0 0 0 0 1\"")]
    Query(QueryArgs),
    /// Show packs on a page for any browser: meshes, hulls, figures
    #[command(after_help = "Example:\n  bake report baked --out report.html")]
    Report(ReportArgs),
    /// Write a commented hullmap.toml
    #[command(after_help = "Example:\n  bake init assets")]
    Init(InitArgs),
    /// Print completions for a shell
    #[command(after_help = "Example:\n  bake completions bash > ~/.local/share/bash-completion/completions/bake")]
    Completions(CompletionsArgs),
}

/// What `bake build` takes.
#[derive(Debug, clap::Args)]
pub struct BuildArgs {
    /// Meshes (OBJ, glTF, GLB, STL, PLY), or folders to search for them
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
    /// Take options from this file [default: the nearest hullmap.toml above each mesh]
    #[arg(long, value_name = "FILE", help_heading = "Configuration")]
    pub config: Option<PathBuf>,
    /// Read no hullmap.toml
    #[arg(long, conflicts_with = "config", help_heading = "Configuration")]
    pub no_config: bool,
    /// Bake even what is up to date
    #[arg(long, help_heading = "What is baked")]
    pub force: bool,
    /// Bake nothing; name what is stale or missing, and exit with 1 if anything is
    #[arg(long, conflicts_with_all = ["force", "verify", "watch", "depfile"], help_heading = "What is baked")]
    pub check: bool,
    /// Remove packs whose source is gone; with --check, exit with 1 if there are any
    #[arg(long, help_heading = "What is baked")]
    pub prune: bool,
    /// Verify each pack before it is put in place
    #[arg(long, help_heading = "What is baked")]
    pub verify: bool,
    /// Go on, and bake again whatever changes, until Ctrl-C
    #[arg(long, help_heading = "What is baked")]
    pub watch: bool,
    /// Write what each pack depends on, for Ninja and Make
    #[arg(long, value_name = "FILE", help_heading = "What is baked")]
    pub depfile: Option<PathBuf>,
    /// In the depfile, let this one target depend on everything
    #[arg(long, hide_short_help = true, value_name = "TARGET", requires = "depfile", help_heading = "What is baked")]
    pub depfile_target: Option<PathBuf>,
    /// Threads to use [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), help_heading = "How it runs")]
    pub jobs: Option<u16>,
    /// Memory for the files in work together; one that needs more is baked alone [default: 4G]
    #[arg(long, value_name = "SIZE", value_parser = size, help_heading = "How it runs")]
    pub memory: Option<u64>,
    /// List what is fresh too
    #[arg(long, help_heading = "How it runs")]
    pub verbose: bool,
    /// Print errors alone
    #[arg(long, conflicts_with = "verbose", help_heading = "How it runs")]
    pub quiet: bool,
    /// Print one JSON object a file
    #[arg(long, help_heading = "How it runs")]
    pub json: bool,
}

/// How much a source file may ask for.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct LimitArgs {
    /// Refuse larger source files; importing takes up to 8 times their bytes
    #[arg(
        long,
        value_name = "N",
        help_heading = "Limits",
        hide_short_help = true,
        default_value_t = Limits::DEFAULT.input_bytes,
        value_parser = clap::value_parser!(u64).range(1..)
    )]
    max_input_bytes: u64,
    /// Refuse to cut files of more objects
    #[arg(long, value_name = "N", help_heading = "Limits", hide_short_help = true, default_value_t = Limits::DEFAULT.objects)]
    max_objects: usize,
    /// Refuse glTF files that repeat more vertices and corners by instances
    #[arg(long, value_name = "N", help_heading = "Limits", hide_short_help = true, default_value_t = Limits::DEFAULT.repeated_vertices)]
    max_instanced: usize,
}

impl LimitArgs {
    /// The limits that the flags set.
    pub fn limits(&self) -> Limits {
        Limits { input_bytes: self.max_input_bytes, objects: self.max_objects, repeated_vertices: self.max_instanced }
    }
}

/// What `bake verify` takes.
#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Packs, or folders to search for them
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// The mesh, or a folder of meshes [default: beside the pack, then where it was]
    #[arg(long, value_name = "PATH")]
    pub source: Option<PathBuf>,
    /// Exit with 1 if a pack's source is not found
    #[arg(long)]
    pub require_source: bool,
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
    /// Packs, or folders to search for them
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// Print one JSON object a pack
    #[arg(long)]
    pub json: bool,
}

/// What `bake query` takes.
#[derive(Debug, clap::Args)]
pub struct QueryArgs {
    /// FILE, a whole pack as one body, or one hull of it: FILE#name or FILE#number; results are in its frame
    #[arg(value_name = "A")]
    pub a: String,
    /// The other pack or hull, in the same way
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
    /// The pack, or a folder of packs: one page for all, and one for each in a folder beside it
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

/// What `bake init` takes.
#[derive(Debug, clap::Args)]
pub struct InitArgs {
    /// The folder with the meshes
    #[arg(value_name = "DIR", default_value = ".", hide_default_value = true)]
    pub folder: PathBuf,
}

/// What `bake completions` takes.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum, value_name = "bash|elvish|fish|powershell|zsh", hide_possible_values = true)]
    pub shell: clap_complete::Shell,
}

/// A number of bytes: `4096`, `500K`, `500M`, `8G`, in steps of 1024.
fn size(text: &str) -> Result<u64, String> {
    let units = [("", 1_u64), ("K", 1 << 10), ("M", 1 << 20), ("G", 1 << 30), ("T", 1 << 40)];
    let digits = text.trim_end_matches(|letter: char| !letter.is_ascii_digit());
    let unit = text[digits.len()..].to_uppercase();
    let unit = unit.strip_suffix("IB").or(unit.strip_suffix('B')).unwrap_or(&unit);
    let factor = units.iter().find_map(|(name, factor)| (*name == unit).then_some(*factor));
    let bytes = digits.parse::<u64>().ok().zip(factor).and_then(|(number, factor)| number.checked_mul(factor));
    bytes.filter(|&bytes| bytes > 0).ok_or_else(|| "expected a size above 0 such as 500M or 8G".to_owned())
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
    let words: Vec<std::ffi::OsString> = words.into_iter().map(Into::into).collect();
    let cli = Cli::try_parse_from(&words).map_err(|error| match unquoted_pose(&words) {
        Some(pose) if error.kind() == ErrorKind::UnknownArgument => {
            let message = format!("--pose takes its seven numbers as one word; quote them: --pose \"{pose}\"");
            wrong("query", ErrorKind::WrongNumberOfValues, message)
        }
        _ => with_usage(error, words.get(1)),
    })?;
    match &cli.command {
        Command::Build(args) => {
            if let Some((key, why)) = args.options.clash() {
                let message = format!("--{} {why}", key.replace('_', "-"));
                return Err(wrong("build", ErrorKind::ArgumentConflict, message));
            }
        }
        Command::Verify(VerifyArgs { directions: 0, .. }) => {
            return Err(wrong("verify", ErrorKind::ValueValidation, "--directions must be at least 1".to_owned()));
        }
        _ => {}
    }
    Ok(cli)
}

/// The numbers after a `--pose`, where they are words of their own.
fn unquoted_pose(words: &[std::ffi::OsString]) -> Option<String> {
    let at = words.iter().position(|word| word == "--pose")?;
    let texts = words.iter().skip(at + 1).map_while(|word| word.to_str());
    let numbers: Vec<&str> = texts.take_while(|text| text.trim_end_matches(',').parse::<f64>().is_ok()).collect();
    (numbers.len() > 1).then(|| numbers.join(" "))
}

/// The same error with the usage of the subcommand that was named: clap leaves it out where a value is wrong.
fn with_usage(mut error: clap::Error, subcommand: Option<&std::ffi::OsString>) -> clap::Error {
    let mut command = Cli::command();
    command.build();
    let subcommand = subcommand.and_then(|name| name.to_str()).and_then(|name| command.find_subcommand_mut(name));
    if let Some(subcommand) = subcommand
        && error.get(ContextKind::Usage).is_none()
    {
        error.insert(ContextKind::Usage, ContextValue::StyledStr(subcommand.render_usage()));
    }
    error
}

/// An error in the words of a subcommand, with its usage.
fn wrong(subcommand: &str, kind: ErrorKind, message: String) -> clap::Error {
    let mut command = Cli::command();
    // Without this a subcommand does not know the name that it is called by.
    command.build();
    match command.find_subcommand_mut(subcommand) {
        Some(subcommand) => subcommand.error(kind, message),
        None => command.error(kind, message),
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::*;
    use crate::options::{BuildOptions, DecomposeOptions, Simplify};
    use hullmap_import::{ImportOptions, Split, UpAxis, Vertices};

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
        assert_eq!(build("--vhacd-max-parts 8"), Ok(usual), "hullmap.toml may say that meshes are decomposed");
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
            "--decompose=false --vhacd-max-parts 8",
            "--decompose --vhacd-resolution 0",
            "--split group",
            "--vertices some",
            "--jobs 0",
            "--memory 0",
            "--check --force",
            "--check --verify",
            "--check --depfile x",
            "--quiet --verbose",
            "--config x --no-config",
            "--depfile-target x",
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
        for words in ["a b --pose -3 0 0 0 -0.5 0 1", "--pose -3 0 0 0 -0.5 0 1 a b --json"] {
            let message = parse(format!("bake query {words}").split_whitespace()).unwrap_err().to_string();
            assert!(
                message.contains("quote them: --pose \"-3 0 0 0 -0.5 0 1\"") && message.contains("Usage"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_wrong_value_is_told_the_right_ones() {
        let message = parse("bake build a --out b --split group".split_whitespace()).unwrap_err().to_string();
        assert!(message.contains("none, object, auto"), "{message}");
    }

    #[test]
    fn every_subcommand_has_an_example_that_parses() {
        for subcommand in Cli::command().get_subcommands() {
            let help = subcommand.clone().render_help().to_string();
            let examples = help.split_once("Example").map_or("", |(_, examples)| examples);
            let lines: Vec<&str> =
                examples.lines().filter_map(|line| line.trim_start().strip_prefix("bake ")).collect();
            assert!(!lines.is_empty(), "{}", subcommand.get_name());
            for line in lines {
                let line = line.split(['(', '>']).next().unwrap();
                let (words, quoted) = line.split_once('"').map_or((line, None), |(words, pose)| (words, Some(pose)));
                let quoted = quoted.map(|pose| pose.trim_end().trim_end_matches('"'));
                let words = ["bake"].into_iter().chain(words.split_whitespace()).chain(quoted);
                parse(words).unwrap_or_else(|error| panic!("{line}: {error}"));
            }
        }
    }

    #[test]
    fn help_fits_a_screen() {
        let help = Cli::command().render_help().to_string();
        assert!(help.lines().count() <= 24, "{help}");
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
        // Two screens for the longest: what few need is in `--help`.
        let build = Cli::command().find_subcommand_mut("build").unwrap().render_help().to_string();
        assert!(build.lines().count() <= 48, "{build}");
        let short = Cli::command().get_subcommands().map(|c| c.clone().render_help().to_string()).collect::<String>();
        assert!(short.lines().all(|line| line.chars().count() <= 120), "{short}");
    }

    #[test]
    fn wrong_arguments_show_the_usage_of_their_subcommand() {
        for (line, usage) in [
            ("bake build in --out o --resolution 5", "Usage: bake build"),
            ("bake build in --out o --memory many", "Usage: bake build"),
            ("bake build in --out o --index octree", "Usage: bake build"),
            ("bake query a b --mode overlap", "Usage: bake query"),
            ("bake build in", "Usage: bake build"),
            ("bake build in --out o --max-error 1 --max-vertices 9", "Usage: bake build"),
            ("bake verify x --directions 0", "Usage: bake verify"),
            ("bake inspect", "Usage: bake inspect"),
            ("bake query a", "Usage: bake query"),
            ("bake completions", "Usage: bake completions"),
        ] {
            let message = parse(line.split_whitespace()).unwrap_err().to_string();
            assert!(message.contains(usage), "{line}: {message}");
        }
    }

    #[test]
    fn sizes() {
        for (text, bytes) in
            [("4096", 4096), ("1K", 1024), ("500M", 500 << 20), ("8g", 8 << 30), ("2GiB", 2 << 30), ("1mb", 1 << 20)]
        {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in ["", "0", "M", "-1", "1.5G", "5X", "99999999T"] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}
