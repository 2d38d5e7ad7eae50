//! Tries any number of hostile files: packs, triangle meshes and height fields.

use std::{process::ExitCode, time::Instant};

use clap::{Parser, ValueEnum};
use hullmap::Pack;
use hullmap_tests::hostile::inquiry::Extent;
use hullmap_tests::hostile::large::{self, Large};
use hullmap_tests::hostile::samples::{self, Sample};
use hullmap_tests::hostile::series::Series;
use hullmap_tests::hostile::trial::Tally;
use hullmap_tests::hostile::{sheets, tries};

/// Changes packs, triangle meshes and height fields in many ways. Runs 1000 support queries and 20
/// contacts on each pack that opens, and queries at 8 places on each mesh or field.
///
/// Counts go to standard output, progress to standard error. A panic or a hang ends the run and
/// names the change.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo program hostile-packs -- --flips 10000000 --seed 1 --threads 2")]
struct Arguments {
    /// Number of bits to flip: all bits of the small files, then all bits of random ones
    #[arg(long, default_value_t = 10_000_000)]
    flips: usize,
    /// Seed of the random packs and changes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Index of the first file; earlier files count as done
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Number of random changes for each small file
    #[arg(long, default_value_t = 4_000)]
    drawn: usize,
    /// Series of changes to try [default: all]
    #[arg(long, value_delimiter = ',')]
    only: Vec<Kind>,
    /// Files to change
    #[arg(long, value_enum, default_value_t = Files::All)]
    files: Files,
    /// Try one change in N of each series
    #[arg(long, default_value_t = 1)]
    every: usize,
    /// Size in MB of the largest of the large packs; the others have a quarter and a sixteenth. At
    /// 64, baking the prism takes many minutes
    #[arg(long, default_value_t = 16)]
    largest: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Files {
    /// All kinds
    All,
    /// Packs
    Packs,
    /// Triangle meshes and height fields
    Sheets,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// The slowest query on packs of growing size
    Large,
    /// Prefixes and extensions by 1 to 4096 bytes
    Lengths,
    /// Words set to lengths, ends of ranges and special floats
    Words,
    /// Several words at once
    Drawn,
    /// Flipped bits in packs that are opened without checks
    Unchecked,
    /// Flipped bits, with the old and with a correct checksum
    Flips,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    println!("seed {}", arguments.seed);
    let (packs, sheets) = (samples::small(), sheets::small());
    for (name, samples) in [("packs", &packs), ("meshes and fields", &sheets)] {
        let bytes: usize = samples.iter().map(|sample| sample.file.len()).sum();
        println!("{} small {name}, {bytes} bytes", samples.len());
    }
    let small = match arguments.files {
        Files::All => [packs.clone(), sheets].concat(),
        Files::Packs => packs.clone(),
        Files::Sheets => sheets,
    };
    for kind in Kind::value_variants() {
        if !arguments.only.is_empty() && !arguments.only.contains(kind) {
            continue;
        }
        match kind {
            Kind::Large => large(arguments.largest),
            Kind::Lengths => total("lengths", Series::Lengths, &small, &arguments),
            Kind::Words => total("words", Series::Words, &small, &arguments),
            Kind::Drawn => total("several words", Series::Drawn, &small, &arguments),
            Kind::Unchecked => {
                let with = (arguments.seed, arguments.threads);
                let (sum, queried) = tries::unchecked(&packs, with, chosen(&arguments));
                println!("opened without checks: {sum}; {queried} sets of queries");
            }
            Kind::Flips => flips(&small, &arguments),
        }
    }
    ExitCode::SUCCESS
}

/// The slowest query on each large pack, at three sizes. Panics if its time grows faster than the
/// size, or a malicious pack is too slow for its size.
fn large(largest_mb: usize) {
    let sizes = [largest_mb * 1_000_000 / 16, largest_mb * 1_000_000 / 4, largest_mb * 1_000_000];
    let mut times = Vec::new();
    for kind in Large::ALL {
        let points = sizes.map(|size| {
            let file = kind.file(size);
            let pack = Pack::from_bytes(&file).unwrap_or_else(|error| panic!("{kind}: {error}"));
            let slowest = large::slowest(&pack);
            let ms = slowest.time.as_secs_f64() * 1e3;
            println!("{kind}, {:.1} MB: slowest query {ms:.3} ms ({})", file.len() as f64 / 1e6, slowest.query);
            (file.len(), slowest.time)
        });
        let exponent = large::exponent(points[0], points[2]);
        println!("{kind}: exponent {exponent:.2}");
        assert!(exponent <= large::MAX_EXPONENT, "{kind}: the time grows faster than the size");
        times.push((kind, points[2].1.as_secs_f64()));
    }
    let slowest = |is_honest| {
        let times = times.iter().filter(|(kind, _)| kind.is_honest() == is_honest);
        times.map(|(_, time)| *time).fold(0.0, f64::max)
    };
    let ratio = slowest(false) / slowest(true);
    println!("malicious to honest, {largest_mb} MB: {ratio:.1}");
    assert!(ratio <= large::MAX_RATIO, "malicious packs are too slow for their size");
}

/// The members of a series that are tried.
fn chosen(arguments: &Arguments) -> impl Fn(Option<usize>) -> Vec<usize> {
    |count| (0..count.unwrap_or(arguments.drawn)).step_by(arguments.every).collect()
}

/// One series over all small files.
fn total(name: &str, series: Series, small: &[Sample], arguments: &Arguments) {
    let mut sum = Tally::default();
    for sample in small {
        sum += tries::checked(sample, series, (arguments.seed, arguments.threads, Extent::FULL), chosen(arguments));
        eprintln!("{name}, {}: {sum}", sample.name);
    }
    println!("{name}: {sum}");
}

fn flips(small: &[Sample], arguments: &Arguments) {
    let (mut plain, mut sealed, mut files, mut passed) = (Tally::default(), Tally::default(), 0, 0);
    let start = Instant::now();
    while passed < arguments.flips {
        let sample = match (small.get(files as usize), arguments.files) {
            (Some(sample), _) => sample.clone(),
            (None, Files::Sheets) => sheets::drawn(arguments.seed, files),
            (None, Files::All | Files::Packs) => samples::drawn(arguments.seed, files),
        };
        let count = (8 * sample.file.len()).min(arguments.flips - passed);
        passed += count;
        files += 1;
        if files <= arguments.first {
            continue;
        }
        let with = (arguments.seed, arguments.threads, Extent::FULL);
        plain += tries::checked(&sample, Series::Bits, with, |_| chosen(arguments)(Some(count)));
        sealed += tries::checked(&sample, Series::SealedBits, with, |_| chosen(arguments)(Some(count)));
        eprintln!("{:6.0} s  file {files}, {}: {sealed}", start.elapsed().as_secs_f64(), sample.name);
    }
    println!("flipped bits of {} files, old checksum: {plain}", files - arguments.first.min(files));
    println!("flipped bits, correct checksum: {sealed}");
}
