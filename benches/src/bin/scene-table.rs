//! Queries on scenes of many different hulls, beside parry3d, in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bake::IndexKind;
use hullmap_bench::{
    rows::{Rows, finish},
    scene::{
        Scene,
        race::{self, Effort, Order, SceneQuery},
    },
};

/// Hull counts, full and quick.
const HULLS: [&[usize]; 2] = [&[1, 16, 1_000, 10_000], &[1, 100]];

/// Vertex counts, full and quick.
const VERTICES: [&[usize]; 2] = [&[32, 128, 512, 2_048], &[32, 128]];

/// Approximate bytes of a vertex in a pack, for the limit.
const BYTES_OF_A_VERTEX: usize = 230;

/// Times queries on scenes of many different hulls, in one thread.
///
/// Random pairs with empty caches of the solver, and neighbours in a moving crowd with warm ones.
/// *loop* and *batch* are hullmap, one query after the other and in a batch. Tables go to standard
/// output, progress to standard error.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  cargo run --release -p hullmap-bench --bin scene-table -- --hulls 8000 --vertices 128 \
                  --index tree,compact"
)]
struct Arguments {
    /// Short table: small scenes, few pairs and rounds
    #[arg(long)]
    quick: bool,
    /// Numbers of different hulls [default: 1,16,1000,10000; with --quick: 1,100]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    hulls: Vec<u32>,
    /// Numbers of vertices of each hull [default: 32,128,512,2048; with --quick: 32,128]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(8..))]
    vertices: Vec<u32>,
    /// Kinds of direction index [default: tree]
    #[arg(long, value_delimiter = ',')]
    index: Vec<IndexKind>,
    /// Skip scenes whose packs would be larger than this, in MiB; parry3d needs as much
    /// memory on top
    #[arg(long, default_value_t = 2048, value_name = "MIB")]
    max_mib: usize,
    /// Also write the times as CSV
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let rows = measure(&arguments);
    for (order, query) in [Order::Random, Order::Crowd].into_iter().flat_map(|o| SceneQuery::ALL.map(|q| (o, q))) {
        // Support queries have no pose.
        if (order, query) == (Order::Crowd, SceneQuery::Support) {
            continue;
        }
        let title = format!("{}, {}: ns per query", query.name(), order.name());
        let table = rows.table(&title, &["hulls", "vertices", "index", "bytes"], "engine", |row| {
            let is_shown = row.text("order") == order.name() && row.text("query") == query.name();
            is_shown.then(|| format!("{:.0}", row.number("ns")))
        });
        println!("{table}");
    }
    finish(arguments.out.map(|path| (path, &rows)).as_slice())
}

fn measure(arguments: &Arguments) -> Rows {
    let start = Instant::now();
    let counts = |chosen: &[u32], usual: [&[usize]; 2]| -> Vec<usize> {
        if chosen.is_empty() {
            usual[usize::from(arguments.quick)].to_vec()
        } else {
            chosen.iter().map(|&n| n as usize).collect()
        }
    };
    let kinds = if arguments.index.is_empty() { vec![IndexKind::Tree] } else { arguments.index.clone() };
    let effort = if arguments.quick { Effort::QUICK } else { Effort::FULL };
    let mut rows = Rows::new(&["hulls", "vertices", "index", "bytes", "order", "query", "engine", "ns"]);
    for vertices in counts(&arguments.vertices, VERTICES) {
        for hulls in counts(&arguments.hulls, HULLS) {
            let at = start.elapsed().as_secs_f64();
            if hulls * vertices * BYTES_OF_A_VERTEX > arguments.max_mib << 20 {
                eprintln!("{at:5.1} s  {hulls} hulls of {vertices} vertices: skipped, larger than --max-mib");
                continue;
            }
            for kind in &kinds {
                eprintln!("{:5.1} s  {hulls} hulls of {vertices} vertices, {kind}", start.elapsed().as_secs_f64());
                let scene = Scene::bake(hulls, vertices, *kind);
                for cell in race::run(&scene, vertices, effort) {
                    rows.push(vec![
                        hulls.to_string(),
                        vertices.to_string(),
                        kind.to_string(),
                        scene.byte_len().to_string(),
                        cell.order.name().to_owned(),
                        cell.query.name().to_owned(),
                        cell.engine.name().to_owned(),
                        format!("{:.1}", cell.ns),
                    ]);
                }
            }
        }
    }
    rows
}
