//! Support queries beside parry3d: time in three modes, regret, bytes and build time, of all index
//! kinds in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bake::IndexKind;
use hullmap_bench::{
    directions,
    regret::Truth,
    rows::{Row, Rows, finish, three_digits},
    subject::{FAMILIES, SEED, Subject, first_hull},
    support::{self, Effort, Mode},
};
use shapes::families::{Family, MIN_POINTS};

/// Vertex counts of the full table, and of the quick one.
const COUNTS: [u32; 10] = [8, 32, 128, 256, 512, 1024, 2048, 8192, 32_768, 65_536];
const QUICK_COUNTS: [u32; 4] = [8, 128, 1024, 8192];

/// Families of the quick table.
const QUICK_FAMILIES: [Family; 3] = [Family::Sphere, Family::Rock, Family::Prism];

/// Number of directions in which answers are judged.
const JUDGED: usize = 4_000;

const COLUMNS: [&str; 11] = [
    "family",
    "n",
    "vertices",
    "rival",
    "mode",
    "ns",
    "ns_quartile_1",
    "ns_quartile_3",
    "index_bytes",
    "build_ms",
    "max_regret",
];

/// Compares support queries with parry3d's, in one run.
///
/// Tables go to standard output, progress to standard error.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  cargo run --release -p hullmap-bench --bin support-table -- --families rock,prism --n 128,8192"
)]
struct Arguments {
    /// Short table: three families, four vertex counts, less time each
    #[arg(long)]
    quick: bool,
    /// Families, separated by commas [default: all eight; with --quick: sphere,rock,prism]
    #[arg(long, value_delimiter = ',', value_parser = family)]
    families: Vec<Family>,
    /// Point counts, separated by commas [default: 8 to 65536]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(MIN_POINTS as i64..))]
    n: Vec<u32>,
    /// Also write the measurements as CSV
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

fn family(name: &str) -> Result<Family, String> {
    Family::from_name(name).filter(|f| FAMILIES.contains(f)).ok_or_else(|| {
        let names: Vec<&str> = FAMILIES.iter().map(|f| f.name()).collect();
        format!("unknown family; expected one of {}", names.join(", "))
    })
}

fn main() -> ExitCode {
    let Arguments { quick, mut families, mut n, out } = Arguments::parse();
    if families.is_empty() {
        families = if quick { QUICK_FAMILIES.to_vec() } else { FAMILIES.to_vec() };
    }
    if n.is_empty() {
        n = if quick { QUICK_COUNTS.to_vec() } else { COUNTS.to_vec() };
    }
    let start = Instant::now();
    let mut rows = Rows::new(&COLUMNS);
    for &family in &families {
        for &n in &n {
            eprintln!("{:5.1} s  {} {n}", start.elapsed().as_secs_f64(), family.name());
            measure(family, n as usize, if quick { Effort::QUICK } else { Effort::FULL }, &mut rows);
        }
        let name = family.name();
        let table = |title: &str, labels: &[&str], cell: &dyn Fn(Row<'_>) -> String| {
            let cell = |row: Row<'_>| (row.text("family") == name).then(|| cell(row));
            println!("{}", rows.table(&format!("{name}: {title}"), labels, "n", cell));
        };
        table("ns per query", &["mode", "rival"], &|row| three_digits(row.number("ns")));
        table("maximum regret over the diameter; bytes per vertex; ms to build the index", &["rival"], &|row| {
            let bytes = row.number("index_bytes") / row.number("vertices");
            format!("{:.0e}; {bytes:.0}; {}", row.number("max_regret"), row.text("build_ms"))
        });
    }
    let file = out.map(|path| (path, &rows));
    finish(file.as_slice())
}

fn measure(family: Family, n: usize, effort: Effort, rows: &mut Rows) {
    let subject = Subject::new(family, n, SEED);
    let methods = support::methods(&subject);
    let pack = subject.pack(IndexKind::None).0;
    let hull = first_hull(&pack);
    let truth = Truth::new(&subject.points, hull.diameter(), directions::awkward(&hull, JUDGED, SEED));
    let regrets: Vec<f64> = methods.iter().map(|method| truth.max_regret(&method.answers(truth.dirs()))).collect();
    for (mode_name, mode) in Mode::ALL {
        let times = support::time(&methods, mode, effort, SEED);
        for ((method, [low, median, high]), regret) in methods.iter().zip(times).zip(&regrets) {
            rows.push(vec![
                family.name().to_owned(),
                n.to_string(),
                hull.vertex_count().to_string(),
                method.name.to_owned(),
                mode_name.to_owned(),
                format!("{median:.3}"),
                format!("{low:.3}"),
                format!("{high:.3}"),
                method.index_bytes.to_string(),
                method.build_time.map_or(String::new(), |time| format!("{:.3}", time.as_secs_f64() * 1e3)),
                format!("{regret:e}"),
            ]);
        }
    }
}
