//! Compares the golden hashes with what this build computes on this machine, or renews them.

use std::{path::Path, process::ExitCode};

use hullmap_golden::{FILE, golden::Golden};

const HELP: &str = "Compares the golden hashes of packs and answers with what this build computes on this machine.

Usage: golden [--renew [--unreleased]] [--threads N]

  --renew       Write the computed hashes. Rejected if packs of the same format version changed
  --unreleased  With --renew: accept changed packs, because the format version was never released
  --threads N   Number of threads for bakes and queries [default: all processors]

Exits with 0 if all hashes are equal, 1 if any differ, 2 for wrong usage or I/O.

Example:
  cargo run --release -p hullmap-golden";

fn main() -> ExitCode {
    let (mut renew, mut unreleased, mut threads) = (false, false, 0);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--renew" => renew = true,
            "--unreleased" => unreleased = true,
            "--threads" => match words.next().and_then(|word| word.parse().ok()) {
                Some(number) => threads = number,
                None => return usage("--threads requires a number"),
            },
            "--help" | "-h" => {
                println!("{HELP}");
                return ExitCode::SUCCESS;
            }
            _ => return usage(&format!("unknown option {word:?}")),
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
    let golden = match std::fs::read_to_string(&path) {
        Ok(text) => Golden::read(&text),
        Err(error) if renew => {
            eprintln!("{}: {error}; starting a new one", path.display());
            Ok(Golden { format_version: 0, hashes: Default::default() })
        }
        Err(error) => Err(error.to_string()),
    };
    let golden = match golden {
        Ok(golden) => golden,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            return ExitCode::from(2);
        }
    };
    let found = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(|| Golden::small().join(Golden::large())),
        Err(error) => return usage(&error.to_string()),
    };
    let differences = golden.differences(&found);
    println!("{} hashes, {} differ", found.hashes.len(), differences.len());
    differences.iter().for_each(|line| println!("{line}"));
    if !renew {
        return if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) };
    }
    let breaks = |line: &String| line.contains("raise FORMAT_VERSION");
    if differences.iter().any(breaks) && !unreleased {
        eprintln!(
            "not renewed: the bytes of a released format version must not change; pass --unreleased if this version was never released"
        );
        return ExitCode::from(1);
    }
    match std::fs::write(&path, found.text()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::from(2)
        }
    }
}

fn usage(what: &str) -> ExitCode {
    eprintln!("{what}; see --help");
    ExitCode::from(2)
}
