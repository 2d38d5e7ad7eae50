//! Draws the chart of benches/README.md from a committed result.

use std::{error::Error, fs, path::PathBuf};

use clap::Parser;
use hullmap_bench::{comparison, output};

/// Draws the time of a query against the vertex count, hullmap beside parry3d.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin comparison-chart -- \\\n      \
                  benches/results/DATE-contact.csv --source \"AMD EPYC, DATE\" --out docs/images/contact.svg")]
struct Arguments {
    /// CSV written by contact-table
    input: PathBuf,
    /// Machine and date, for the subtitle
    #[arg(long, default_value = "")]
    source: String,
    /// SVG to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { input, source, out } = Arguments::parse();
    let text = fs::read_to_string(&input).map_err(|e| format!("cannot read {}: {e}", input.display()))?;
    let chart = comparison::chart(&text, &source).map_err(|e| format!("{}: {e}", input.display()))?;
    output::write(&out, &chart.to_svg())?;
    Ok(())
}
