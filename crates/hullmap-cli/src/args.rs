//! The command line: subcommands and flags of `bake`.
//!
//! The flags that shape a pack come from the table in `options/table.rs`; all others are here and
//! in `args/`.

pub mod export;
mod guesses;
mod limits;
mod numbers;
pub mod options;
mod project;
#[cfg(test)]
mod reference;
pub mod running;
#[cfg(test)]
mod tests;
pub mod usd;
pub mod verify;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, Resettable, StyledStr, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use hullmap_import::{EXTENSIONS, height_field};
use hullmap_report::input::Up;

use crate::terminal::Escaped;
use export::ExportArgs;
use hullmap_pipeline::content::DEFAULT_DIRECTIONS;
use hullmap_pipeline::glob::Glob;
use hullmap_pipeline::jobs::Selection;
use hullmap_pipeline::jobs::batch::BatchSize;
use hullmap_pipeline::jobs::shard::Shard;
use hullmap_pipeline::options::flag;
use hullmap_pipeline::options::table::Section;
use limits::LimitArgs;
use numbers::{at_least_one, size};
use options::{OptionFlags, joined, with_set};
use running::{RUNNING, RunArgs, ThreadArgs};
use verify::VerifyArgs;

const FILES: &str = Section::Files.heading();

/// Default of `--memory` in bytes: what a machine with 8 GiB can spare.
pub const DEFAULT_MEMORY: u64 = 4 << 30;

// The first line states how to start, so that the help fits a screen. docs/COMMAND.md lists exit
// codes.
/// Turn render meshes into collision hulls. Start: `bake build FOLDER --out DIR`.
#[derive(Debug, Parser)]
#[command(name = "bake", version, disable_help_subcommand = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake meshes into .hullmap packs
    #[command(after_help = "Examples:\n  \
                      bake build assets --out baked --exclude drafts    (convex hulls)\n  \
                      bake build chair.glb --out baked --decompose      (convex parts)\n  \
                      bake build level.obj --out baked --keep-triangles (a static mesh)")]
    Build(Box<BuildArgs>),
    /// Decompose a mesh file into a file of convex parts, without a pack
    #[command(after_help = "Examples:\n  \
                      bake decompose chair.obj parts.obj\n  \
                      bake decompose chair.glb parts.glb --max-error 1% --max-parts 16")]
    Decompose(Box<DecomposeArgs>),
    /// Replace collision meshes in robots: URDF, MJCF, SDF
    #[command(after_help = "Examples:\n  \
                      bake robot arm.urdf --out arm_hulls.urdf                   (exact hulls)\n  \
                      bake robot arm.xml --out baked --decompose --max-error 2mm (parts)\n  \
                      bake robot arm.urdf --out arm_hulls.urdf --check           (for CI)")]
    Robot(Box<RobotArgs>),
    /// Verify packs against the meshes they were baked from
    #[command(after_help = "Example:\n  bake verify baked --source assets --directions 200000")]
    Verify(VerifyArgs),
    /// Write hulls as meshes, into glTF, or as a layer of USD
    #[command(after_help = "Examples:\n  \
                      bake export baked/rock.hullmap --out rock.glb\n  \
                      bake export baked/chair.hullmap --for unreal --out UCX_chair.glb\n  \
                      bake export baked --for godot --out collision          (a file per pack)\n  \
                      bake export baked/car.hullmap --into car.glb --for both --out car_physics.glb\n  \
                      bake export baked/arm.hullmap --for urdf --out arm\n  \
                      bake export baked/seat.hullmap --for usd --prim /World/seat --out hulls.usda")]
    Export(ExportArgs),
    /// Describe the hulls in packs
    #[command(after_help = "Example:\n  bake inspect baked/gear.hullmap --json")]
    Inspect(InspectArgs),
    /// Write an HTML report of packs: meshes, hulls, query costs
    #[command(after_help = "Example:\n  bake report baked --out report.html")]
    Report(ReportArgs),
    /// Compute intersection, distance or contact of two hulls or packs
    #[command(after_help = "Example:\n  bake query baked/rock.hullmap baked/cube.hullmap --pose \"0.5 0 0 0 0 0 1\"")]
    Query(QueryArgs),
    /// Write a hullmap.toml with every option commented out
    #[command(after_help = "Example:\n  bake init")]
    Init(InitArgs),
    /// Share one build between many machines
    #[command(
        subcommand,
        after_help = "Examples:\n  \
                      bake farm build assets --out baked --shard 0/8\n  \
                      bake farm plan assets --out baked > plan.jsonl"
    )]
    Farm(Farm),
    /// Print a completion script for a shell
    #[command(
        hide = true,
        after_help = "Example:\n  bake completions bash > ~/.local/share/bash-completion/completions/bake"
    )]
    Completions(CompletionsArgs),
    /// Write a manual page of each command to a folder
    #[command(hide = true, after_help = "Example:\n  bake man ~/.local/share/man/man1")]
    Man(ManArgs),
}

#[derive(Debug, Subcommand)]
pub enum Farm {
    /// Bake one shard of the meshes
    #[command(after_help = "Example:\n  bake farm build assets --out baked --shard 0/8")]
    Build(Box<ShardArgs>),
    /// List the work of a build as tasks for other machines
    #[command(after_help = "Examples:\n  \
                      bake farm plan assets --out baked > plan.jsonl\n  \
                      bake farm plan assets --out baked --emit ninja > build.ninja")]
    Plan(Box<PlanArgs>),
    /// Bake tasks of a plan
    #[command(after_help = "Example:\n  bake farm task plan.jsonl 3")]
    Task(TaskArgs),
    /// Print a hash of everything that each pack depends on
    #[command(after_help = "Example:\n  bake farm key assets --set record_source=name")]
    Key(Box<KeyArgs>),
    /// List packs that are missing or stale, by their headers
    #[command(after_help = "Example:\n  bake farm status assets --out baked --shards 64")]
    Status(Box<StatusArgs>),
}

#[derive(Clone, Debug, clap::Args)]
pub struct MeshArgs {
    /// Meshes (OBJ, glTF, GLB, STL, PLY, COLLADA, MSH), or folders
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The meshes and folders of a project that were named, if `inputs` are its sources.
    #[arg(skip)]
    pub only: Vec<PathBuf>,
    #[command(flatten)]
    pub options: OptionFlags,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Read FILE, or `none` [default: the nearest hullmap.toml]
    #[arg(long, hide_short_help = true, value_name = "FILE", help_heading = FILES)]
    pub config: Option<PathBuf>,
    /// Leave out meshes and folders that match GLOB; repeatable
    #[arg(long, hide_short_help = true, value_name = "GLOB", value_parser = Glob::new, help_heading = FILES)]
    pub exclude: Vec<Glob>,
    /// Bake hidden meshes too, and those that .gitignore names
    #[arg(long, hide_short_help = true, help_heading = FILES)]
    pub no_ignore: bool,
    /// In folders, bake only these formats, such as obj,glb
    #[arg(
        long, hide_short_help = true, value_name = "LIST", value_delimiter = ',', help_heading = FILES, ignore_case = true,
        value_parser = PossibleValuesParser::new(EXTENSIONS.into_iter().chain(height_field::EXTENSIONS))
    )]
    pub ext: Vec<String>,
}

impl MeshArgs {
    pub fn selection(&self) -> Selection {
        let own = self.clone();
        Selection {
            inputs: own.inputs,
            only: own.only,
            options: own.options.0,
            config: own.config,
            exclude: own.exclude,
            no_ignore: own.no_ignore,
            extensions: own.ext,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct BuildArgs {
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Write packs to DIR [default: as hullmap.toml says]
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
    /// Bake every mesh, even if its pack is fresh
    #[arg(long, hide_short_help = true, help_heading = RUNNING)]
    pub force: bool,
    /// Bake nothing; exit with 1 if packs are stale or missing
    ///
    /// They are listed
    #[arg(long, conflicts_with_all = ["force", "verify", "watch", "depfile"], help_heading = RUNNING)]
    pub check: bool,
    /// Remove packs whose source is gone
    ///
    /// With --check, exit with 1 if there are any
    #[arg(long, hide_short_help = true, help_heading = FILES)]
    pub prune: bool,
    /// Verify each pack before it replaces the old one
    #[arg(long, hide_short_help = true, help_heading = RUNNING)]
    pub verify: bool,
    /// Keep running, and bake files that change
    ///
    /// Files whose packs are deleted are baked, too
    #[arg(long, hide_short_help = true, help_heading = RUNNING)]
    pub watch: bool,
    /// Write dependencies to FILE, for Ninja and Make
    #[arg(long, hide_short_help = true, value_name = "FILE", help_heading = FILES)]
    pub depfile: Option<PathBuf>,
    /// Write a single target, which depends on all sources and folders, to the depfile
    #[arg(long = "set depfile_target", value_name = "TARGET", requires = "depfile", help_heading = FILES)]
    pub depfile_target: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
    /// The shard of `bake farm build`.
    #[arg(skip)]
    pub shard: Option<Shard>,
    /// Share finished packs in DIR [env: HULLMAP_CACHE]
    ///
    /// Takes packs of other machines and branches from it, and adds baked ones
    #[arg(long, env = "HULLMAP_CACHE", hide_env = true, value_name = "DIR", hide_short_help = true, help_heading = FILES)]
    pub cache: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub struct ShardArgs {
    /// Bake only the meshes of shard I of N, counted from 0, for instance 0/8
    #[arg(long, value_name = "I/N")]
    pub shard: Shard,
    #[command(flatten)]
    pub build: BuildArgs,
}

#[derive(Debug, clap::Args)]
pub struct DecomposeArgs {
    /// Mesh file (OBJ, glTF, GLB, STL, PLY, COLLADA, MSH)
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File of the parts; its extension names the format: obj or glb
    #[arg(value_name = "OUT", required_unless_present_any = ["out", "curve"])]
    output: Option<PathBuf>,
    /// The same as OUT
    #[arg(short, long, value_name = "OUT", conflicts_with = "output")]
    out: Option<PathBuf>,
    /// Write no file; print how many parts each error gives
    ///
    /// The errors are around the maximum error
    #[arg(long, help_heading = RUNNING, conflicts_with_all = ["output", "out", "max_parts", "force"])]
    pub curve: bool,
    #[command(flatten)]
    pub options: OptionFlags,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Replace OUT, also if bake did not write it
    #[arg(long, help_heading = RUNNING)]
    pub force: bool,
    #[command(flatten)]
    pub threads: ThreadArgs,
    /// Print all notes
    #[arg(short, long, help_heading = RUNNING)]
    pub verbose: bool,
    /// Print only errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = RUNNING)]
    pub quiet: bool,
    /// Print one JSON object
    #[arg(long, help_heading = RUNNING)]
    pub json: bool,
}

impl DecomposeArgs {
    /// The file to write; `None` with `--curve`.
    pub fn file(&self) -> Option<&Path> {
        self.output.as_deref().or(self.out.as_deref())
    }
}

#[derive(Debug, clap::Args)]
pub struct KeyArgs {
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Folder in which the packs would be: paths in packs are relative to it [default: beside the
    /// meshes]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object per mesh, with everything that goes into its key
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, clap::Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Folder of the packs, which mirrors the input folders
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
    /// Approximate number of meshes per task
    #[arg(long, value_name = "N", default_value_t = BatchSize::default().meshes, value_parser = at_least_one, help_heading = "Tasks")]
    pub batch: usize,
    /// Approximate bytes of source per task; a mesh above a quarter of it is a task of its own
    /// [default: 32M]
    #[arg(long = "set batch_bytes", value_name = "SIZE", value_parser = size, help_heading = "Tasks")]
    pub batch_bytes: Option<u64>,
    /// Form of the plan: one JSON object per task, or a file for Ninja
    #[arg(long, value_enum, default_value_t = Emit::Json, value_name = "json|ninja", help_heading = "Tasks")]
    pub emit: Emit,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    Json,
    Ninja,
}

#[derive(Debug, clap::Args)]
pub struct TaskArgs {
    /// The plan: a file of tasks, one per line (`-`: standard input)
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// Tasks to run, by their indices [default: all tasks]
    #[arg(value_name = "INDEX")]
    pub indices: Vec<usize>,
    /// Folder of the packs [default: the one that the plan names]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Bake every mesh, even if its pack is fresh
    #[arg(long)]
    pub force: bool,
    /// Verify each pack before it replaces the old one
    #[arg(long)]
    pub verify: bool,
    /// Share finished packs in DIR [env: HULLMAP_CACHE]
    ///
    /// Takes packs of other machines and branches from it, and adds baked ones
    #[arg(long, env = "HULLMAP_CACHE", hide_env = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Write the results as JSON to FILE, and exit with 0 even if meshes were rejected
    #[arg(long, value_name = "FILE")]
    pub results: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, clap::Args)]
pub struct StatusArgs {
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Folder of the packs, which mirrors the input folders
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
    /// Number of shards of the bake; lists those that are incomplete
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
    /// Print one JSON object per pack, also for packs that are present
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// Baked files, or folders of them [default: `output` of hullmap.toml]
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// Also print vertex positions and faces
    #[arg(long, requires = "json")]
    pub vertices: bool,
    /// Print one JSON object per pack
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, clap::Args)]
pub struct RobotArgs {
    /// Robot descriptions: URDF, MJCF or SDF
    #[arg(required = true, value_name = "FILE")]
    pub inputs: Vec<PathBuf>,
    /// File to write, or folder of several
    ///
    /// Hulls go to a folder beside each
    #[arg(short, long, value_name = "DIR|FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    pub options: OptionFlags,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Folder of packages or models; repeatable
    ///
    /// It contains them, or is one itself
    #[arg(long = "package-path", hide_short_help = true, value_name = "DIR", help_heading = FILES)]
    pub packages: Vec<PathBuf>,
    /// Make collisions from visuals: missing, always or never
    ///
    /// Visuals are used by links of URDF and SDF without a collision (missing), by all links, which
    /// lose their own (always), or by none (never)
    #[arg(long, value_enum, default_value_t = FromVisual::Missing, value_name = "RULE")]
    pub from_visual: FromVisual,
    /// Leave links that match GLOB alone; repeatable
    #[arg(long, hide_short_help = true, value_name = "GLOB", value_parser = Glob::new)]
    pub exclude: Vec<Glob>,
    /// Compute the inertia of links from their meshes
    ///
    /// The mass stays as the link states it
    #[arg(long, hide_short_help = true)]
    pub inertia: bool,
    /// Exclude contacts of pairs of links that always touch
    ///
    /// These are pairs that touch in the neutral pose or in all poses. MJCF gets `exclude`
    /// elements. A URDF file gets an SRDF file, which also has parents and children, and pairs that
    /// touched in no random pose, which is no proof
    #[arg(long, hide_short_help = true, help_heading = FILES)]
    pub exclude_pairs: bool,
    /// Number of random configurations for the tests of pairs of links
    #[arg(long = "set samples", value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(0..=1_000_000), help_heading = FILES)]
    pub samples: u32,
    /// Seed of these random configurations
    #[arg(long = "set seed", value_name = "S", default_value_t = 0, help_heading = FILES)]
    pub seed: u64,
    /// Write a page of the robot: links in 3D, joints, pairs
    ///
    /// It states the protrusion, and the pairs of links that touch
    #[arg(long, hide_short_help = true, value_name = "FILE.html", conflicts_with = "check", help_heading = FILES)]
    pub report: Option<PathBuf>,
    /// Read FILE, or `none` [default: the nearest hullmap.toml]
    #[arg(long, hide_short_help = true, value_name = "FILE", help_heading = FILES)]
    pub config: Option<PathBuf>,
    /// Bake every mesh again, and allow --out to name an input
    #[arg(long, hide_short_help = true, help_heading = RUNNING)]
    pub force: bool,
    /// Write nothing; exit with 1 if a description would change
    ///
    /// Such descriptions are listed
    #[arg(long, conflicts_with = "force", help_heading = RUNNING)]
    pub check: bool,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FromVisual {
    /// Links of URDF and SDF without a collision
    Missing,
    /// All links with a visual mesh, in place of their collisions
    Always,
    /// None
    Never,
}

/// Options that `bake robot` does not take, because the description decides.
#[rustfmt::skip]
pub const DECIDED_BY_ROBOTS: [&str; 9] = [
    "split", "unit_scale", "up_axis", "recentre", "pack_names", "record_source", "keep_triangles", "terrain", "primitives",
];

pub fn reason_of_robots(key: &str) -> &'static str {
    let chooses = ["keep_triangles", "terrain", "primitives"].contains(&key);
    if chooses { "whose collisions become hulls" } else { "whose descriptions state it" }
}

#[derive(Debug, clap::Args)]
pub struct QueryArgs {
    /// A pack as one body (FILE), or one of its hulls (FILE#name or FILE#index); results are in its
    /// frame
    #[arg(value_name = "A")]
    pub a: String,
    /// The other pack or hull, in the same notation
    #[arg(value_name = "B")]
    pub b: String,
    /// Pose of B in A's frame: translation and quaternion; repeatable [default: identity]
    #[arg(long = "pose", value_name = "tx ty tz qx qy qz qw", allow_hyphen_values = true)]
    pub poses: Vec<String>,
    /// Read poses from FILE, one per line (`-`: standard input); `#` starts a comment
    #[arg(long = "poses", value_name = "FILE")]
    pub pose_file: Option<PathBuf>,
    /// Query to compute
    #[arg(long, value_enum, default_value_t = Mode::Contact, value_name = "intersect|distance|contact")]
    pub mode: Mode,
    /// Print one JSON object per pose
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// A pack, or a folder of packs [default: `output` of hullmap.toml]
    ///
    /// A folder gets an overview and a page per pack
    #[arg(value_name = "FILE|DIR")]
    pub input: PathBuf,
    /// HTML file to write, without need of a network; of a folder, the pages of its packs go to a
    /// folder beside it
    #[arg(short, long, value_name = "REPORT.html")]
    pub out: PathBuf,
    /// The source mesh, or a folder of meshes [default: as for `bake verify`]
    #[arg(long, value_name = "PATH")]
    pub source: Option<PathBuf>,
    /// Write the pages of shard I of N, counted from 0, and no overview; --merge adds it
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    pub shard: Option<Shard>,
    /// Write the overview of pages that all shards have written, and verify nothing
    #[arg(long)]
    pub merge: bool,
    /// Axis that points up in the pictures [default: as usual in the source's format]
    #[arg(long, value_parser = up(), value_name = "z|y")]
    pub up: Option<Up>,
    /// Number of directions to test on each hull
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DIRECTIONS, value_parser = at_least_one)]
    pub directions: usize,
    /// Seed of the random directions
    #[arg(long = "set seed", value_name = "S", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub limits: LimitArgs,
    #[command(flatten)]
    pub threads: ThreadArgs,
    /// Print only errors
    #[arg(short, long, help_heading = RUNNING)]
    pub quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// Whether the two overlap
    Intersect,
    /// The distance between them
    Distance,
    /// Penetration depth, contact points and normal
    Contact,
}

#[derive(Debug, clap::Args)]
pub struct InitArgs {
    /// Root folder of the project [default: the current folder]
    #[arg(value_name = "DIR", default_value = ".", hide_default_value = true)]
    pub folder: PathBuf,
}

#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum, value_name = "bash|elvish|fish|powershell|zsh")]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder of the pages
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

fn up() -> impl TypedValueParser<Value = Up> {
    PossibleValuesParser::new(["z", "y"]).map(|axis| if axis == "y" { Up::Y } else { Up::Z })
}

/// The name under which the command was started, for help texts: `bake`, or another entry point,
/// such as `python -m hullmap`.
pub fn program(words: &[OsString]) -> String {
    let name = words.first().and_then(|word| Path::new(word).file_name()).and_then(|name| name.to_str());
    name.filter(|name| !name.is_empty()).unwrap_or("bake").to_owned()
}

pub fn command(program: &str) -> clap::Command {
    let of_robots = |own: clap::Command| {
        own.mut_args(|option| {
            let is_decided = DECIDED_BY_ROBOTS.contains(&option.get_id().as_str());
            if is_decided { option.hide(true) } else { option }
        })
    };
    let color = Arg::new("color").long("color").global(true).hide_short_help(true).hide_possible_values(true);
    let color = color.value_name("WHEN").value_parser(["auto", "always", "never"]);
    let color = color.help("Use colours: auto, always, never [default: auto]");
    let command =
        Cli::command().arg(color).bin_name(program).mut_subcommand("robot", of_robots).mut_subcommands(with_set);
    // CI sets variables to nothing where it has no value.
    let is_empty = |arg: &Arg| arg.get_env().and_then(std::env::var_os).is_some_and(|value| value.is_empty());
    let without = |arg: Arg| if is_empty(&arg) { arg.env(None::<&str>) } else { arg };
    let command = command.mut_subcommands(|own| own.mut_args(without).mut_subcommands(|own| own.mut_args(without)));
    let command =
        command.mut_subcommand("decompose", |own| own.mut_arg("decompose_seconds", |arg| arg.conflicts_with("curve")));
    if program == "bake" {
        return command;
    }
    fn renamed(command: clap::Command, program: &str) -> clap::Command {
        let text = |text: Option<&StyledStr>| {
            let renamed = text.map(|text| text.to_string().replace("bake ", &format!("{program} ")).into());
            Resettable::<StyledStr>::from(renamed)
        };
        let (about, examples) = (text(command.get_about()), text(command.get_after_help()));
        command.about(about).after_help(examples).mut_subcommands(|own| renamed(own, program))
    }
    renamed(command, program)
}

/// The value of `--color`, also in a line with errors, which are printed in colour.
pub fn color(words: &[OsString]) -> &str {
    let mut words = words.iter().filter_map(|word| word.to_str()).skip_while(|word| !word.starts_with("--color"));
    let first = words.next().unwrap_or_default();
    first.strip_prefix("--color=").or(words.next()).unwrap_or_default()
}

/// Parses the command line. The error is clap's: exit code 2, or 0 for `--help` and `--version`.
pub fn parse<I, T>(words: I) -> Result<Cli, clap::Error>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    let words = joined(&words);
    let completed = |error| match project::completed(&words, &error, command(&program(&words))) {
        Ok(Some(completed)) => parse_words(&completed.words).map(|mut cli| {
            if let Some((sources, meshes)) = completed.sources.zip(cli.command.meshes_mut()) {
                meshes.only = std::mem::replace(&mut meshes.inputs, sources);
            }
            cli
        }),
        Ok(None) => Err(error),
        Err(failure) => Err(clap::Error::raw(ErrorKind::Io, format!("{failure}\n"))),
    };
    parse_words(&words).or_else(completed).map_err(|error| {
        if error.kind() == ErrorKind::DisplayHelp && words.iter().any(|word| word == "--help") {
            return help_of(&words, command(&program(&words))).unwrap_or(error);
        }
        // The error quotes arguments, which may be file names that a shell expanded.
        let escaped: Vec<OsString> = words.iter().map(|word| Escaped(word.display()).to_string().into()).collect();
        if escaped == words { error } else { parse_words(&escaped).err().unwrap_or(error) }
    })
}

/// Arguments with all of their sentences in `--help`. The further sentences of the others are in
/// docs/COMMAND.md and the manual pages.
const EXPLAINED: [&str; 8] = ["set", "for_engine", "target", "into", "name", "density", "from_visual", "exclude_pairs"];

/// The command with every flag in its short help.
pub fn whole(command: clap::Command) -> clap::Command {
    let shown = |arg: Arg| match arg.get_long_help() {
        Some(help) if EXPLAINED.contains(&arg.get_id().as_str()) => {
            let help = help.to_string().replace("\n\n", ". ");
            arg.help(help).hide_short_help(false)
        }
        _ => arg.hide_short_help(false),
    };
    command.mut_args(shown).mut_subcommands(whole)
}

/// The help that the words ask for. `--help` has every flag, one line each: clap's own takes three
/// times as many lines.
fn help_of(words: &[OsString], command: clap::Command) -> Option<clap::Error> {
    let command = if words.iter().any(|word| word == "--help") { whole(command) } else { command };
    let short = |word: &OsString| if word == "--help" { OsString::from("-h") } else { word.clone() };
    command.try_get_matches_from(words.iter().map(short)).err()
}

fn parse_words(words: &[OsString]) -> Result<Cli, clap::Error> {
    let program = program(words);
    let parsed = command(&program)
        .try_get_matches_from(words)
        .and_then(|found| Cli::from_arg_matches(&found).map_err(|error| error.format(&mut command(&program))));
    let mut cli = parsed.map_err(|error| match unquoted_pose(words) {
        Some(pose) if error.kind() == ErrorKind::UnknownArgument => {
            let message = format!("--pose requires its seven numbers in quotes: --pose \"{pose}\"");
            subcommand(words).error(ErrorKind::WrongNumberOfValues, message)
        }
        _ => guesses::with_tip(with_variable(with_usage(error, words), words), &subcommand(words)),
    })?;
    if let Command::Farm(Farm::Build(args)) = &mut cli.command {
        args.build.shard = Some(args.shard);
    }
    if let Some(options) = cli.command.options() {
        let clash = options.0.clash().map(|clash| clash.message(flag));
        if let Some(message) = clash.or_else(|| guesses::detached_value(words)) {
            return Err(subcommand(words).error(ErrorKind::ArgumentConflict, message));
        }
    }
    Ok(cli)
}

impl Command {
    pub fn is_quiet(&self) -> bool {
        match self {
            Self::Build(args) => args.run.quiet,
            Self::Farm(Farm::Build(args)) => args.build.run.quiet,
            Self::Farm(Farm::Task(args)) => args.run.quiet,
            Self::Robot(args) => args.run.quiet,
            Self::Decompose(args) => args.quiet,
            Self::Verify(args) => args.quiet,
            Self::Export(args) => args.quiet,
            Self::Report(args) => args.quiet,
            _ => false,
        }
    }

    /// Number of threads of a command that starts none of its own.
    pub fn threads(&self) -> Option<u16> {
        match self {
            Self::Verify(args) => args.threads.jobs,
            Self::Report(args) => args.threads.jobs,
            _ => None,
        }
    }

    fn options(&mut self) -> Option<&OptionFlags> {
        match self {
            Self::Robot(args) => Some(&args.options),
            _ => self.meshes_mut().map(|meshes| &meshes.options),
        }
    }

    fn meshes_mut(&mut self) -> Option<&mut MeshArgs> {
        match self {
            Self::Build(args) => Some(&mut args.meshes),
            Self::Farm(Farm::Build(args)) => Some(&mut args.build.meshes),
            Self::Farm(Farm::Key(args)) => Some(&mut args.meshes),
            Self::Farm(Farm::Plan(args)) => Some(&mut args.meshes),
            Self::Farm(Farm::Status(args)) => Some(&mut args.meshes),
            _ => None,
        }
    }
}

/// The numbers after a `--pose`, if they are separate arguments.
fn unquoted_pose(words: &[OsString]) -> Option<String> {
    let at = words.iter().position(|word| word == "--pose")?;
    let texts = words.iter().skip(at + 1).map_while(|word| word.to_str());
    let numbers: Vec<&str> = texts.take_while(|text| text.trim_end_matches(',').parse::<f64>().is_ok()).collect();
    (numbers.len() > 1).then(|| numbers.join(" "))
}

/// The error with the usage of its subcommand, which clap leaves out for wrong values.
fn with_usage(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    if error.get(ContextKind::Usage).is_none() {
        let usage = subcommand(words).render_usage();
        error.insert(ContextKind::Usage, ContextValue::StyledStr(usage));
    }
    error
}

/// The error names the environment variable, if no word ends with the wrong value.
fn with_variable(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.as_str(),
        _ => "",
    };
    let (named, value) = (text(ContextKind::InvalidArg), text(ContextKind::InvalidValue));
    let own = subcommand(words);
    let variable = own.get_arguments().find(|arg| arg.to_string() == named).and_then(Arg::get_env);
    if let Some(variable) = variable.filter(|_| !words.iter().any(|word| word.to_string_lossy().ends_with(value))) {
        let name = variable.to_string_lossy().into_owned();
        error.insert(ContextKind::InvalidArg, ContextValue::String(name));
    }
    error
}

/// The subcommand that the words name.
fn subcommand(words: &[OsString]) -> clap::Command {
    let mut own = command(&program(words));
    // A subcommand gets its full name from this call.
    own.build();
    for word in words.iter().skip(1) {
        match own.find_subcommand(word).cloned() {
            Some(inner) => own = inner,
            None => break,
        }
    }
    own
}
