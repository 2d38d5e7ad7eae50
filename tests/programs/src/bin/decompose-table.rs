//! Prints parts, vertices, proven bounds and time of the convex decomposition of concave meshes,
//! beside CoACD's.
//!
//! ```text
//! cargo run --release -p hullmap-programs --bin concave-meshes -- FOLDER
//! cargo run --release -p hullmap-programs --bin decompose-table -- FOLDER --coacd coacd.tsv
//! ```
//!
//! Each line of the file of CoACD's figures has these columns, separated by tabs: name of the mesh,
//! parts, vertices of all parts, protrusion, seconds of processor time. The protrusion is the limit
//! that is requested here, but at least 5e-4 of the diagonal. Without the file it is 2 %.
//!
//! One thread decomposes. Seconds are its processor time, where the system states it. The parts are
//! measured afterwards. With `--samples`, random points try to refute the bounds
//! ([`hullmap_tests::sampler`]); one that does ends the program with status 1.

use std::{collections::BTreeMap, path::PathBuf, process::ExitCode};

use clap::Parser;
use hullmap_bake::{
    decompose::{Cover, Length, decompose},
    fit::{Solid, fits},
    hull::{self, Hull},
};
use hullmap_programs::meshes_of;
use hullmap_tests::{processor::timed, sampler::refutation};

/// Convex decomposition of the meshes of a folder.
#[derive(Parser)]
struct Arguments {
    /// Folder of OBJ files
    folder: PathBuf,
    /// Figures of CoACD
    #[arg(long)]
    coacd: Option<PathBuf>,
    /// Number of points that try to refute the claims about each mesh
    #[arg(long, default_value_t = 0)]
    samples: usize,
    /// Only meshes whose name contains this
    #[arg(long, default_value = "")]
    only: String,
}

/// Seed of the samples.
const SEED: u64 = 1;

/// Smallest limit, relative to the diagonal.
const LEAST: f64 = 5e-4;

/// Figures of a decomposition.
#[derive(Clone, Copy, Default)]
struct Figures {
    parts: f64,
    vertices: f64,
    protrusion: f64,
    seconds: f64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let text = arguments.coacd.map(|path| std::fs::read_to_string(path).expect("the file of CoACD can be read"));
    let coacd: BTreeMap<String, Figures> = text.iter().flat_map(|text| text.lines()).filter_map(figures).collect();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let mut is_refuted = false;
    let (mut ours, mut theirs) = (Figures::default(), Figures::default());
    println!("mesh | triangles | E % | parts | vertices | protrusion / E | uncovered | seconds");
    for (name, mesh) in &meshes_of(&arguments.folder, &arguments.only) {
        let diagonal = Solid::new(mesh).diagonal();
        let peer = coacd.get(name);
        let share = peer.map_or(0.02, |peer| peer.protrusion.max(LEAST));
        let cover = Cover { max_error: Length::Relative(share), ..Cover::default() };
        let (sets, seconds) = one.install(|| timed(|| decompose(mesh, &cover)));
        let sets = sets.expect("the mesh can be decomposed");
        let sets = sets.unwrap_or_else(|| vec![mesh.clone()]);
        let hulls: Vec<Hull> = sets.iter().map(|set| hull::build(set).expect("a part has a hull")).collect();
        let limit = share * diagonal;
        let fits = fits(mesh, &hulls.iter().collect::<Vec<_>>(), Some(limit)).expect("the parts are measured");
        let protrusion = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
        let vertices: usize = hulls.iter().map(|hull| hull.vertices.len()).sum();
        let largest = hulls.iter().map(|hull| hull.vertices.len()).max().unwrap_or(0);
        let figures = Figures { parts: hulls.len() as f64, vertices: vertices as f64, protrusion, seconds };
        let beside =
            |ours: String, theirs: Option<String>| theirs.map_or(ours.clone(), |theirs| format!("{ours} / {theirs}"));
        println!(
            "{name} | {} | {:.3} | {} | {} (max {largest}) | {:.3} | {:.1e} | {}",
            mesh.triangles.len(),
            100.0 * share,
            beside(figures.parts.to_string(), peer.map(|peer| peer.parts.to_string())),
            beside(figures.vertices.to_string(), peer.map(|peer| peer.vertices.to_string())),
            protrusion / limit,
            fits[0].uncovered / diagonal,
            beside(format!("{seconds:.2}"), peer.map(|peer| format!("{:.1}", peer.seconds))),
        );
        if let Some(why) = refutation(mesh, &hulls, &fits, arguments.samples, SEED) {
            println!("{name}: refuted by a sample of seed {SEED}: {why}");
            is_refuted = true;
        }
        if let Some(peer) = peer {
            add(&mut ours, &figures);
            add(&mut theirs, peer);
        }
    }
    println!(
        "sum: {} / {} parts, {} / {} vertices, {:.1} / {:.1} s",
        ours.parts, theirs.parts, ours.vertices, theirs.vertices, ours.seconds, theirs.seconds
    );
    if is_refuted { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn add(sum: &mut Figures, figures: &Figures) {
    sum.parts += figures.parts;
    sum.vertices += figures.vertices;
    sum.seconds += figures.seconds;
}

fn figures(line: &str) -> Option<(String, Figures)> {
    let mut columns = line.split('\t');
    let name = columns.next()?.to_owned();
    let mut number = || columns.next()?.parse::<f64>().ok();
    let figures = Figures { parts: number()?, vertices: number()?, protrusion: number()?, seconds: number()? };
    Some((name, figures))
}
