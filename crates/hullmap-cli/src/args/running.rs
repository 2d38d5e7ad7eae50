//! Arguments that do not change what is made.

use super::numbers::size;

pub const RUNNING: &str = "Running";

#[derive(Clone, Copy, Debug, clap::Args)]
pub struct ThreadArgs {
    /// Threads [default: one per core] [env: HULLMAP_JOBS]
    #[arg(short, long, env = "HULLMAP_JOBS", hide_env = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), help_heading = RUNNING)]
    pub jobs: Option<u16>,
}

#[derive(Clone, Copy, Debug, clap::Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub threads: ThreadArgs,
    /// Maximum memory [default: 4G] [env: HULLMAP_MEMORY]
    ///
    /// All files in progress share it
    #[arg(long, env = "HULLMAP_MEMORY", hide_env = true, hide_short_help = true, value_name = "SIZE", value_parser = size, help_heading = RUNNING)]
    pub memory: Option<u64>,
    /// List fresh packs too, and all notes
    #[arg(short, long, hide_short_help = true, help_heading = RUNNING)]
    pub verbose: bool,
    /// Print only errors
    #[arg(short, long, hide_short_help = true, conflicts_with = "verbose", help_heading = RUNNING)]
    pub quiet: bool,
    /// Print one JSON object per file
    #[arg(long, hide_short_help = true, help_heading = RUNNING)]
    pub json: bool,
}
