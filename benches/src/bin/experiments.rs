//! The paper's Figures 6 and 7 with our data: time of collision tests, a line per vertex count.

use std::{io, path::PathBuf, process::ExitCode};

use clap::Parser;
use hullmap_bake::IndexKind;
use hullmap_bench::{
    chart::{Chart, Scale, Series, thousands},
    collision::{Bodies, Run, Scene},
    csv::Csv,
    fit::{self, Sample},
    machine::Machine,
    matrix::Matrix,
    output,
    subject::SEED,
};

/// Vertex counts of both figures, and of the tree alone.
const COUNTS: [usize; 6] = [8, 32, 128, 512, 2048, 8192];
const TREE_COUNTS: [usize; 2] = [32_768, 65_536];

/// Vertex counts of a quick run.
const QUICK_COUNTS: [usize; 4] = [8, 128, 1024, 4096];

/// Number of checkpoints of a line.
const CHECKPOINTS: usize = 10;

/// Number of tests between two checkpoints, and in a quick run.
const STEP: usize = 1_000;
const QUICK_STEP: usize = 200;

/// Number of runs of each line. The result is their median at each checkpoint.
const ROUNDS: usize = 5;
const QUICK_ROUNDS: usize = 3;

/// Reproduces the paper's Figures 6 and 7.
///
/// Writes figure6.svg, figure6.csv (linear scan), figure7.svg and figure7.csv (tree). Fits to the
/// paper's equation 3 go to standard output, progress to standard error.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin experiments -- --out target/figures")]
struct Arguments {
    /// Folder for the figures
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Fewer vertex counts and tests
    #[arg(long)]
    quick: bool,
}

/// One line of a figure.
struct Line {
    n: usize,
    /// Medians over the rounds at each checkpoint, in nanoseconds.
    times_ns: Vec<f64>,
    support_queries_per_test: f64,
    hit_share: f64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> io::Result<()> {
    let quick = arguments.quick;
    let (counts, step, rounds) =
        if quick { (&QUICK_COUNTS[..], QUICK_STEP, QUICK_ROUNDS) } else { (&COUNTS[..], STEP, ROUNDS) };
    let scene = Scene::new(CHECKPOINTS * step, SEED);
    let mut stage = Vec::new();
    for &n in counts {
        eprintln!("baking {n}");
        let [scan, tree] = Bodies::bake(n, [IndexKind::None, IndexKind::Tree]);
        stage.push((n, scene.place(&tree), Some(scan), tree));
    }
    for &n in if quick { &[][..] } else { &TREE_COUNTS[..] } {
        eprintln!("baking {n}");
        let [tree] = Bodies::bake(n, [IndexKind::Tree]);
        stage.push((n, scene.place(&tree), None, tree));
    }
    let (mut scans, mut trees) = (Runs::default(), Runs::default());
    // Lines take turns, so that a slow spell of the machine affects all of them.
    for round in 0..rounds {
        eprintln!("round {} of {rounds}", round + 1);
        for (n, tests, scan, tree) in &stage {
            trees.push(*n, tree.run(tests, step));
            if let Some(scan) = scan {
                scans.push(*n, scan.run(tests, step));
            }
        }
    }
    let (scans, trees) = (scans.lines(CHECKPOINTS * step), trees.lines(CHECKPOINTS * step));
    let machine = Machine::here();
    let subtitle =
        format!("{}, one thread, {}; pairs of rocks, half of them overlapping", machine.processor, machine.date);
    let figures = [
        ("figure6", "Linear scan: collision tests and time (paper's Figure 6)", &scans),
        ("figure7", "Direction tree: collision tests and time (paper's Figure 7)", &trees),
    ];
    for (name, title, lines) in figures {
        output::write(&arguments.out.join(format!("{name}.svg")), &chart(title, &subtitle, lines, step).to_svg())?;
        output::write(&arguments.out.join(format!("{name}.csv")), csv(lines, step).as_str())?;
    }
    print!("{}", summary(&scans, &trees, CHECKPOINTS * step, step));
    eprint!("{}", machine.to_markdown());
    Ok(())
}

/// Runs by vertex count, in the order of first occurrence.
#[derive(Default)]
struct Runs(Vec<(usize, Vec<Run>)>);

impl Runs {
    fn push(&mut self, n: usize, run: Run) {
        match self.0.iter_mut().find(|(of, _)| *of == n) {
            Some((_, runs)) => runs.push(run),
            None => self.0.push((n, vec![run])),
        }
    }

    fn lines(&self, tests: usize) -> Vec<Line> {
        let line = |(n, runs): &(usize, Vec<Run>)| Line {
            n: *n,
            times_ns: (0..runs[0].times.len())
                .map(|checkpoint| median(runs.iter().map(|r| r.times[checkpoint].as_secs_f64() * 1e9).collect()))
                .collect(),
            support_queries_per_test: runs[0].support_queries as f64 / tests as f64,
            hit_share: runs[0].hits as f64 / tests as f64,
        };
        self.0.iter().map(line).collect()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

fn chart(title: &str, subtitle: &str, lines: &[Line], step: usize) -> Chart {
    let series = lines.iter().map(|line| Series {
        name: thousands(&line.n.to_string()),
        points: line.times_ns.iter().enumerate().map(|(i, ns)| [((i + 1) * step) as f64, ns / 1e6]).collect(),
        colour: None,
    });
    Chart {
        title: title.to_owned(),
        subtitle: subtitle.to_owned(),
        x_label: "object-object collision tests".to_owned(),
        y_label: "time, ms".to_owned(),
        legend_title: "vertices".to_owned(),
        scale: Scale::Linear,
        series: series.collect(),
    }
}

fn csv(lines: &[Line], step: usize) -> Csv {
    let mut csv = Csv::new(&["vertices", "tests", "time_ms", "support_queries_per_test", "overlapping"]);
    for line in lines {
        for (i, ns) in line.times_ns.iter().enumerate() {
            csv.line(&[
                line.n.to_string(),
                ((i + 1) * step).to_string(),
                format!("{:.4}", ns / 1e6),
                format!("{:.2}", line.support_queries_per_test),
                format!("{:.3}", line.hit_share),
            ]);
        }
    }
    csv
}

fn samples(lines: &[Line], step: usize) -> Vec<Sample> {
    let of = |line: &Line| {
        let n = line.n as f64;
        let at = |(i, ns): (usize, &f64)| Sample { n, tests: ((i + 1) * step) as f64, time_ns: *ns };
        line.times_ns.iter().enumerate().map(at).collect::<Vec<_>>()
    };
    lines.iter().flat_map(of).collect()
}

/// Nanoseconds per test, the fit of the scan to equation 3, and the exponent of the tree.
fn summary(scans: &[Line], trees: &[Line], tests: usize, step: usize) -> String {
    let mut table = Matrix::new(&format!("ns per collision test, over {tests} tests"), "vertices");
    for (row, lines) in [("scan", scans), ("tree", trees)] {
        for line in lines {
            let ns = line.times_ns.last().copied().unwrap_or_default() / tests as f64;
            table.set(row, &line.n.to_string(), format!("{ns:.0}"));
        }
    }
    for line in trees {
        let column = line.n.to_string();
        table.set("support queries a test", &column, format!("{:.1}", line.support_queries_per_test));
        table.set("overlapping", &column, format!("{:.0} %", 100.0 * line.hit_share));
    }
    let (scan, tree) = (samples(scans, step), samples(trees, step));
    let (proportional, affine) = (fit::proportional(&scan), fit::affine(&scan));
    // From the n at which the scan dominates: below, the constant part hides the exponent.
    let large: Vec<Sample> = scan.iter().copied().filter(|s| s.n >= 512.0).collect();
    let (smallest, largest) = (trees.first(), trees.last());
    let rise = match (smallest, largest) {
        (Some(smallest), Some(largest)) => {
            largest.times_ns[largest.times_ns.len() - 1] / smallest.times_ns[smallest.times_ns.len() - 1]
        }
        _ => f64::NAN,
    };
    let grown = match (smallest, largest) {
        (Some(smallest), Some(largest)) => largest.n as f64 / smallest.n as f64,
        _ => f64::NAN,
    };
    format!(
        "{}\nscan, the paper's equation 3, t = n c: {:.3} ns per vertex and test, R² = {:.4}\n\
         scan, t = (a + b n) c: a = {:.0} ns, b = {:.3} ns, R² = {:.4}\n\
         scan, exponent of n from 512 vertices up: {:.2} (1 is proportional)\n\
         tree, exponent of n: {:.3} (0 is flat); {rise:.2} times the time for {grown:.0} times the vertices\n",
        table.to_text(),
        proportional.factor_ns,
        proportional.r_squared,
        affine.per_test_ns,
        affine.per_vertex_ns,
        affine.r_squared,
        fit::exponent(&large),
        fit::exponent(&tree),
    )
}
