use std::path::PathBuf;

use clap::builder::PossibleValuesParser;

use super::limits::LimitArgs;
use super::numbers::at_least_one;
use super::running::{RUNNING, ThreadArgs};
use hullmap_pipeline::budget::NAMES;
use hullmap_pipeline::content::DEFAULT_DIRECTIONS;

#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Packs, or folders to search for them [default: `output` of hullmap.toml]
    #[arg(required = true, value_name = "FILE|DIR")]
    pub inputs: Vec<PathBuf>,
    /// The source mesh, or a folder of meshes [default: beside the pack, then the recorded path]
    #[arg(long, value_name = "PATH")]
    pub source: Option<PathBuf>,
    /// Exit with 1 if the source of a pack is not found
    #[arg(long)]
    pub require_source: bool,
    /// Fail if a hull is not within the limits of an engine: physx, physx-gpu, jolt, box3d, unity,
    /// unreal, newton or mujoco-warp
    #[arg(long = "for", value_name = "ENGINE", value_parser = PossibleValuesParser::new(&NAMES[1..]))]
    pub engine: Option<String>,
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
    /// List every hull in the table, not one line per pack, and all notes
    #[arg(short, long, help_heading = RUNNING)]
    pub verbose: bool,
    /// Print only errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = RUNNING)]
    pub quiet: bool,
    /// Print one JSON object per hull
    #[arg(long, help_heading = RUNNING)]
    pub json: bool,
}
