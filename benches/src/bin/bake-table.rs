//! Prints processor time, peak memory and exponents of a bake, stage by stage, for 1,000 to
//! 1,000,000 points.
//!
//! Each bake runs in a process of its own, on two threads, so that none reuses the memory of an
//! earlier one. Exponents are of the time, between two sizes ten times apart: 1 is linear work, 2
//! is quadratic work.

use std::{error::Error, fmt::Write as _, fs, path::PathBuf, process::Command};

use clap::Parser;
use hullmap::Pack;
use hullmap_bake::{
    BakedHull, IndexKind, PointSet, SourceRecord, hull, index, interior, mass, outer,
    simplify::{Limit, simplify},
    write_owned_pack,
};
use hullmap_bench::{csv::Csv, machine::Machine, output};
use hullmap_outside::clock::process_time;
use shapes::families::Family;

/// Measures each stage of a bake: points on a sphere, points in a ball, and a cube grid.
///
/// Tables go to standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin bake-table -- --rounds 3")]
struct Arguments {
    /// Number of rounds; the result is the median
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Maximum number of points
    #[arg(long, default_value_t = 1_000_000)]
    max_points: usize,
    /// Number of threads of each bake
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Write the tables to FILE, and the figures to a CSV file beside it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Measure one bake of this family, and print its figures
    #[arg(long, hide = true, requires = "points")]
    family: Option<String>,
    /// Number of points of that bake
    #[arg(long, hide = true)]
    points: Option<usize>,
}

const FAMILIES: [Family; 3] = [Family::Sphere, Family::Ball, Family::CubeGrid];

const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Minimum processor time that is measured reliably, in seconds: the system counts it in steps of 4
/// ms. Shorter times are printed as less than this, and have no exponent.
const STEP: f64 = 0.004;

/// Sizes of hulls that are simplified.
const SIMPLIFIED: [usize; 3] = [2_000, 20_000, 200_000];

/// Vertices of simplified hulls.
const LIMITS: [usize; 3] = [16, 64, 256];

/// Processor time and peak memory of a stage.
#[derive(Clone, Debug)]
struct Figure {
    stage: String,
    seconds: f64,
    megabytes: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    if let (Some(family), Some(points)) = (&arguments.family, arguments.points) {
        let family = Family::from_name(family).ok_or("unknown family")?;
        for figure in bake(family, points)? {
            println!("{}\t{}\t{}", figure.stage, figure.seconds, figure.megabytes);
        }
        return Ok(());
    }
    let mut text = format!("# Bakes\n\n{}- threads: {}\n", Machine::here().to_markdown(), arguments.threads);
    let mut csv = Csv::new(&["family", "points", "stage", "seconds", "megabytes"]);
    for family in FAMILIES {
        let sizes: Vec<usize> = SIZES.into_iter().filter(|n| *n <= arguments.max_points).collect();
        let _ = write!(text, "\n## {}\n\n", family.name());
        text += &table(&arguments, family, &sizes, "", &mut csv)?;
    }
    let sizes: Vec<usize> = SIMPLIFIED.into_iter().filter(|n| *n <= arguments.max_points).collect();
    let _ = write!(text, "\n## sphere, simplified\n\n");
    text += &table(&arguments, Family::Sphere, &sizes, "simplify", &mut csv)?;
    print!("{text}");
    if let Some(path) = arguments.out {
        output::write(&path, &text)?;
        output::write(&path.with_extension("csv"), csv.as_str())?;
    }
    Ok(())
}

/// A line for each stage whose name starts with `start`, a column for each size.
fn table(
    arguments: &Arguments,
    family: Family,
    sizes: &[usize],
    start: &str,
    csv: &mut Csv,
) -> Result<String, Box<dyn Error>> {
    let measured: Vec<Vec<Figure>> =
        sizes.iter().map(|points| median_of(arguments, family, *points)).collect::<Result<_, _>>()?;
    let mut text = String::from("| stage |");
    sizes.iter().for_each(|points| text += &format!(" {points} |"));
    text += " exponents | peak, MB |\n|---|";
    text += &"---:|".repeat(sizes.len());
    text += "---|---:|\n";
    let stages = measured.last().into_iter().flatten().filter(|figure| figure.stage.starts_with(start));
    for Figure { stage, megabytes, .. } in stages {
        let seconds: Vec<f64> = measured
            .iter()
            .map(|figures| figures.iter().find(|f| f.stage == *stage).map_or(f64::NAN, |f| f.seconds))
            .collect();
        let _ = write!(text, "| {stage} |");
        seconds.iter().for_each(|seconds| text += &format!(" {} |", shown(*seconds)));
        let exponent = |pair: &[f64]| {
            let is_measured = pair.iter().all(|seconds| *seconds >= STEP);
            if is_measured { format!("{:.2}", (pair[1] / pair[0]).log10()) } else { "–".to_owned() }
        };
        let exponents: Vec<String> = seconds.windows(2).map(exponent).collect();
        let _ = writeln!(text, " {} | {megabytes:.0} |", exponents.join(", "));
    }
    for (points, figures) in sizes.iter().zip(&measured) {
        for Figure { stage, seconds, megabytes } in figures.iter().filter(|figure| figure.stage.starts_with(start)) {
            csv.line(&[
                family.name(),
                &points.to_string(),
                stage,
                &format!("{seconds:.6}"),
                &format!("{megabytes:.1}"),
            ]);
        }
    }
    Ok(text)
}

/// Seconds with three significant digits.
fn shown(seconds: f64) -> String {
    if seconds < STEP {
        return format!("< {STEP}");
    }
    let decimals = (2.0 - seconds.max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{seconds:.decimals$}")
}

/// Medians of the figures of several bakes.
fn median_of(arguments: &Arguments, family: Family, points: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let rounds: Vec<Vec<Figure>> =
        (0..arguments.rounds.max(1)).map(|_| in_own_process(arguments, family, points)).collect::<Result<_, _>>()?;
    let median = |stage: usize, pick: fn(&Figure) -> f64| {
        let mut all: Vec<f64> = rounds.iter().filter_map(|round| round.get(stage)).map(pick).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let figure = |(index, figure): (usize, &Figure)| Figure {
        stage: figure.stage.clone(),
        seconds: median(index, |f| f.seconds),
        megabytes: median(index, |f| f.megabytes),
    };
    Ok(rounds[0].iter().enumerate().map(figure).collect())
}

fn in_own_process(arguments: &Arguments, family: Family, points: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    let mut command = Command::new(program);
    command.args(["--family", family.name(), "--points", &points.to_string()]);
    let output = command.env("RAYON_NUM_THREADS", arguments.threads.to_string()).output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    let figure = |line: &str| -> Option<Figure> {
        let mut fields = line.split('\t');
        let stage = fields.next()?.to_owned();
        Some(Figure { stage, seconds: fields.next()?.parse().ok()?, megabytes: fields.next()?.parse().ok()? })
    };
    String::from_utf8(output.stdout)?.lines().map(|line| figure(line).ok_or("a line has other fields".into())).collect()
}

/// Bakes points of a family in this process, and measures each stage.
fn bake(family: Family, points: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let positions = family.points(points, 1);
    let source_vertices = (0..positions.len() as u32).collect();
    let set = PointSet { name: "hull".to_owned(), positions, source_vertices, ..PointSet::default() };
    let mut stages = Stages::default();
    let hull = stages.measure("hull", || hull::build(&set))?;
    if SIMPLIFIED.contains(&points) {
        for limit in LIMITS {
            stages.measure(&format!("simplify to {limit}"), || simplify(&hull, Limit::Vertices(limit)))?;
        }
        return Ok(stages.0);
    }
    let (mass, interior, outer) = stages.measure("properties", || {
        let mass = mass::mass(&hull);
        (mass, interior::interior(&hull, &mass), outer::outer(&hull))
    });
    let index = stages.measure("index", || index::build(&hull, IndexKind::Tree))?;
    let baked = vec![BakedHull {
        name: set.name,
        point_count: set.positions.len(),
        origin: [0.0; 3],
        outer_error: 0.0,
        part: 0,
        part_count: 0,
        fit: None,
        mesh_mass: None,
        voids: None,
        primitive: None,
        hull,
        mass,
        interior,
        outer,
        index,
    }];
    let bytes = stages.measure("write", || write_owned_pack(baked, &SourceRecord::default()))?;
    let pack = stages.measure("open", || Pack::from_bytes(&bytes))?;
    stages.measure("check repeats", || pack.check_repeats())?;
    let all = Figure {
        stage: "all".to_owned(),
        seconds: stages.0.iter().map(|figure| figure.seconds).sum(),
        megabytes: stages.0.iter().map(|figure| figure.megabytes).fold(0.0, f64::max),
    };
    stages.0.push(all);
    Ok(stages.0)
}

/// The stages measured so far.
#[derive(Default)]
struct Stages(Vec<Figure>);

impl Stages {
    fn measure<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        forget_peak();
        let start = process_time();
        let result = work();
        let seconds = (process_time() - start).as_secs_f64();
        self.0.push(Figure { stage: stage.to_owned(), seconds, megabytes: peak_megabytes() });
        result
    }
}

/// Resets the peak memory to the current memory. Does nothing on systems other than Linux.
fn forget_peak() {
    // Without permission, peaks count from the start of the process.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Maximum resident memory, in MB; NaN on systems other than Linux.
fn peak_megabytes() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kibibytes.map_or(f64::NAN, |kibibytes| kibibytes * 1024.0 / 1e6)
}
