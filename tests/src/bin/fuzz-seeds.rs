//! First inputs of the fuzz targets.

use std::{fs, path::PathBuf};

use clap::Parser;
use hullmap_tests::fuzzed::{TARGETS, seeds::seeds};

/// Writes first inputs of each fuzz target into a folder of its name, in DIR.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-tests --bin fuzz-seeds -- fuzz/corpus")]
struct Arguments {
    /// Folder of the corpora
    dir: PathBuf,
}

fn main() -> std::io::Result<()> {
    let Arguments { dir } = Arguments::parse();
    for (target, _) in TARGETS {
        let folder = dir.join(target);
        fs::create_dir_all(&folder)?;
        let seeds = seeds(target);
        eprintln!("{}: {} inputs", folder.display(), seeds.len());
        for (name, bytes) in seeds {
            fs::write(folder.join(name), bytes)?;
        }
    }
    Ok(())
}
