//! Prints how well convex decompositions fit concave meshes, beside the parts of another tool.
//!
//! ```text
//! python benches/peers/decompose.py coacd MESHES PEER
//! cargo program decompose-table -- MESHES --peer PEER
//! ```
//!
//! PEER holds the other tool's parts of each mesh, as the objects of an OBJ file of the mesh's
//! name, `seconds.tsv` with the processor time of each mesh, and `proof.txt` with the tool's parts
//! of two known boxes, which stands above the table. Ours has at most as many parts. Without it,
//! the limit is a maximum error. A cell has our figure and the other's; lengths are in percent of
//! the diagonal. Both are measured by the same code.
//!
//! One thread decomposes. Seconds are its processor time, where the system states it.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::Parser;
use hullmap_bake::{
    PointSet,
    decompose::{Cover, Length, decompose},
    fit::{Fit, Solid, fits, looseness},
    hull::{self, Hull},
};
use hullmap_import::{ImportOptions, Limits, Split, import, read};
use hullmap_testkit::clock::timed;

/// Convex decomposition of the meshes of a folder.
#[derive(Parser)]
struct Arguments {
    /// Folder of OBJ files
    folder: PathBuf,
    /// Folder of the parts of another tool
    #[arg(long)]
    peer: Option<PathBuf>,
    /// Maximum error in percent of the diagonal, where there is no peer
    #[arg(long, default_value_t = 2.0)]
    max_error: f64,
    /// Maximum number of vertices of a part
    #[arg(long, value_name = "N")]
    max_vertices: Option<u32>,
    /// Only meshes whose name contains this
    #[arg(long, default_value = "")]
    only: String,
}

/// Measures of a decomposition.
const MEASURES: [&str; 8] =
    ["parts", "vertices", "worst %", "mean %", "overlap %", "outside hull %", "uncovered %", "seconds"];

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(file) = arguments.peer.as_ref().map(|folder| folder.join("proof.txt")) {
        let Ok(proof) = std::fs::read_to_string(&file) else {
            eprintln!("decompose-table: {} is missing; run benches/peers/decompose.py again", file.display());
            return ExitCode::from(2);
        };
        println!("{proof}");
    }
    let seconds = arguments.peer.as_ref().map(|folder| seconds_of(folder)).unwrap_or_default();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let (mut sums, mut wins, mut meshes) = ([[0.0; 2]; MEASURES.len()], [0; MEASURES.len()], 0);
    println!("mesh | triangles | {}", MEASURES.join(" | "));
    for (name, mesh) in &meshes_of(&arguments.folder, &arguments.only) {
        let peer =
            arguments.peer.as_ref().map(|folder| folder.join(format!("{name}.obj"))).filter(|path| path.exists());
        let peer = peer.map(|path| hulls(&sets(name, &path, Split::Object)));
        let any = Cover { max_vertices: arguments.max_vertices, ..Cover::default() };
        let cover = match &peer {
            Some(peer) => Cover { max_parts: Some(peer.len() as u32), ..any },
            None => Cover { max_error: Length::Relative(0.01 * arguments.max_error), ..any },
        };
        let (sets, taken) = one.install(|| timed(|| decompose(mesh, &cover)));
        let ours = hulls(&sets.expect("the mesh can be decomposed").unwrap_or_else(|| vec![mesh.clone()]));
        let fits = fits(mesh, &ours.iter().collect::<Vec<_>>(), None).expect("the parts are measured");
        let mut figures = vec![measured(mesh, &ours, &fits, taken)];
        if let Some(peer) = &peer {
            let fits = hullmap_bake::fit::fits(mesh, &peer.iter().collect::<Vec<_>>(), None);
            let taken = seconds.get(name).copied().unwrap_or(f64::NAN);
            figures.push(measured(mesh, peer, &fits.expect("the parts are measured"), taken));
            meshes += 1;
            for (k, sum) in sums.iter_mut().enumerate() {
                (sum[0], sum[1]) = (sum[0] + figures[0][k], sum[1] + figures[1][k]);
                // To the third digit.
                wins[k] += usize::from(figures[0][k] <= figures[1][k] * 1.001 + 1e-4);
            }
        }
        let cell = |k: usize| figures.iter().map(|figures| shown(figures[k])).collect::<Vec<_>>().join(" / ");
        let cells: Vec<String> = (0..MEASURES.len()).map(cell).collect();
        println!("{name} | {} | {}", mesh.triangles.len(), cells.join(" | "));
    }
    for (k, name) in MEASURES.iter().enumerate().filter(|_| meshes > 0) {
        println!(
            "{name}: {} / {} in sum, at most the peer's for {} of {meshes}",
            shown(sums[k][0]),
            shown(sums[k][1]),
            wins[k]
        );
    }
    ExitCode::SUCCESS
}

fn shown(figure: f64) -> String {
    if figure >= 100.0 || figure.fract() == 0.0 { format!("{figure:.0}") } else { format!("{figure:.3}") }
}

fn hulls(sets: &[PointSet]) -> Vec<Hull> {
    sets.iter().map(|set| hull::build(set).expect("a part has a hull")).collect()
}

/// The figures of [`MEASURES`].
fn measured(mesh: &PointSet, parts: &[Hull], fits: &[Fit], seconds: f64) -> [f64; MEASURES.len()] {
    let (solid, whole) = (Solid::new(mesh), hull::build(mesh).expect("the mesh has a hull"));
    let share = 100.0 / solid.diagonal();
    let loose = looseness(&solid, &whole, &parts.iter().collect::<Vec<_>>());
    let vertices: usize = parts.iter().map(|hull| hull.vertices.len()).sum();
    let worst = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
    [
        parts.len() as f64,
        vertices as f64,
        share * worst,
        share * loose.mean_protrusion,
        100.0 * loose.overlap,
        share * loose.outside_hull,
        share * fits[0].uncovered,
        seconds,
    ]
}

/// Seconds by the name of the mesh.
fn seconds_of(folder: &std::path::Path) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(folder.join("seconds.tsv")).expect("seconds.tsv can be read");
    text.lines()
        .filter_map(|line| line.split_once('\t'))
        .filter_map(|(name, s)| Some((name.to_owned(), s.parse().ok()?)))
        .collect()
}

/// The OBJ meshes of a folder, with their names, sorted by path.
fn meshes_of(folder: &Path, only: &str) -> Vec<(String, PointSet)> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    paths.sort();
    let named =
        paths.into_iter().map(|path| (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), path));
    let named = named.filter(|(name, _)| name.contains(only));
    named.map(|(name, path)| (name.clone(), sets(&name, &path, Split::None).swap_remove(0))).collect()
}

/// The whole of an OBJ file, or its objects.
fn sets(name: &str, path: &Path, split: Split) -> Vec<PointSet> {
    let source = read(name, path, &Limits::DEFAULT).expect("the mesh can be read");
    let options = ImportOptions { split, ..ImportOptions::DEFAULT };
    let imported = import(name, name, path, &source, &options, &Limits::DEFAULT);
    let mut imported = imported.expect("the mesh can be imported");
    imported.give_triangles();
    imported.point_sets
}
