//! Unpacks and packs the corpora of the fuzz targets, and writes first inputs.

use std::{fs, io, path::PathBuf};

use clap::{Parser, ValueEnum};
use hullmap_testkit::files::workspace;
use hullmap_tests::fuzzed::{TARGETS, corpus, seeds::seeds};

/// Unpack, pack or seed the corpora in fuzz/corpus.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo program fuzz-corpus -- unpack solver")]
struct Arguments {
    /// Action to perform
    action: Action,
    /// Targets to process; all by default
    #[arg(value_parser = target)]
    targets: Vec<&'static str>,
    /// Folder of the archives [default: fuzz/corpus]
    #[arg(long)]
    dir: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Action {
    /// Write the inputs of DIR/TARGET.tar.gz into the folder DIR/TARGET
    Unpack,
    /// Write the inputs of the folder DIR/TARGET into DIR/TARGET.tar.gz
    Pack,
    /// Write first inputs of each target into the folder DIR/TARGET
    Seed,
}

fn target(name: &str) -> Result<&'static str, String> {
    let found = TARGETS.iter().map(|(known, _)| *known).find(|known| *known == name);
    found.ok_or_else(|| format!("targets are {}", TARGETS.map(|(known, _)| known).join(", ")))
}

fn main() -> io::Result<()> {
    let Arguments { action, targets, dir } = Arguments::parse();
    let dir = dir.unwrap_or_else(|| workspace().join("fuzz/corpus"));
    let targets = if targets.is_empty() { TARGETS.map(|(name, _)| name).to_vec() } else { targets };
    for target in targets {
        let (archive, folder) = (corpus::archive_path(&dir, target), dir.join(target));
        let inputs = match action {
            Action::Unpack => corpus::unpack(&fs::read(&archive)?)?,
            Action::Pack => corpus::read_folder(&folder)?,
            Action::Seed => seeds(target),
        };
        eprintln!("{target}: {} inputs", inputs.len());
        match action {
            Action::Pack => fs::write(&archive, corpus::pack(inputs)?)?,
            Action::Unpack | Action::Seed => corpus::write_folder(&folder, &inputs)?,
        }
    }
    Ok(())
}
