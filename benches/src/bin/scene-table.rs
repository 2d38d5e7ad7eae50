//! Queries on scenes of many different hulls, beside parry3d, in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bake::IndexKind;
use hullmap_bench::{
    machine::Machine,
    output,
    scene::{
        Scene,
        race::{self, Effort},
        tables::{self, Record},
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
/// Packs larger than the machine's last-level cache are marked. Tables go to standard output,
/// progress to standard error.
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
    /// Also write the tables as markdown, with facts about the machine, and as CSV beside it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let records = measure(&arguments);
    let tables = tables::all(&records);
    tables.iter().for_each(|table| println!("{}", table.to_text()));
    print!("{}", tables::legend());
    let machine = Machine::here();
    eprint!("{}", machine.to_markdown());
    let sections: Vec<String> = tables.iter().map(|table| table.to_markdown()).collect();
    let markdown =
        format!("# Scenes of many hulls\n\n{}\n{}\n{}", machine.to_markdown(), tables::legend(), sections.join("\n"));
    let write = |path: PathBuf| {
        output::write(&path, &markdown)?;
        output::write(&path.with_extension("csv"), tables::to_csv(&records).as_str())
    };
    match arguments.out.map_or(Ok(()), write) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn measure(arguments: &Arguments) -> Vec<Record> {
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
    let mut records = Vec::new();
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
                let cells = race::run(&scene, vertices, effort);
                records.push(Record { hulls, vertices, index: kind.to_string(), bytes: scene.byte_len(), cells });
            }
        }
    }
    eprintln!("{:5.1} s  done", start.elapsed().as_secs_f64());
    records
}
