//! Writes the concave meshes on which decompositions are compared as OBJ files, so that any tool
//! can decompose them.
//!
//! ```text
//! cargo program concave-meshes -- --meshes FOLDER --write FOLDER
//! ```
//!
//! Each is scaled to a diagonal of 1, about the origin.

use std::path::{Path, PathBuf};

use clap::Parser;
use hullmap_bake::PointSet;
use hullmap_import::{ImportOptions, Limits, import, read};

/// Convex decomposition of concave meshes.
#[derive(Parser)]
struct Arguments {
    /// Folder of the meshes that cannot be generated
    #[arg(long)]
    meshes: Option<PathBuf>,
    /// Folder to write the meshes to
    #[arg(long)]
    write: PathBuf,
    /// Only meshes whose name contains this
    #[arg(long, default_value = "")]
    only: String,
}

/// Meshes of the repository.
const ASSETS: [&str; 4] = ["two_objects", "pawn", "torus_knot", "gear"];

/// Meshes of the folder.
const FOREIGN: [&str; 7] = [
    "odedstein_torus",
    "odedstein_goathead",
    "kuka_link_3",
    "ur5e_forearm_2",
    "trimesh_chair_model",
    "kivy_monkey",
    "vhacd_teapot",
];

fn main() {
    let arguments = Arguments::parse();
    let meshes: Vec<PointSet> =
        meshes(arguments.meshes.as_deref()).into_iter().filter(|mesh| mesh.name.contains(&arguments.only)).collect();
    for mesh in &meshes {
        let vertices = mesh.positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let faces = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| v + 1);
            format!("f {a} {b} {c}\n")
        });
        let text: String = vertices.chain(faces).collect();
        std::fs::write(arguments.write.join(format!("{}.obj", mesh.name)), text).expect("the folder can be written");
    }
}

/// All meshes, scaled.
fn meshes(folder: Option<&Path>) -> Vec<PointSet> {
    let generated = shapes::concave::all().into_iter().map(|(name, mesh)| PointSet {
        name: name.to_owned(),
        triangles: mesh.fans(),
        source_vertices: (0..mesh.vertices.len() as u32).collect(),
        positions: mesh.vertices,
        ..PointSet::default()
    });
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let files = ASSETS.iter().map(|name| (*name, assets.clone()));
    let foreign = folder.iter().flat_map(|folder| FOREIGN.iter().map(|name| (*name, folder.to_path_buf())));
    let read = files.chain(foreign).map(|(name, folder)| from_file(name, &folder.join(format!("{name}.obj"))));
    generated.chain(read).map(scaled).collect()
}

fn from_file(name: &str, path: &Path) -> PointSet {
    let (file, limits) = (path.display().to_string(), Limits::DEFAULT);
    let source = read(&file, path, &limits).unwrap_or_else(|error| panic!("{file}: {error:?}"));
    let options = ImportOptions::DEFAULT;
    let mut imported = import(&file, name, path, &source, &options, &limits).unwrap_or_else(|error| panic!("{error}"));
    imported.give_triangles();
    imported.point_sets.into_iter().next().unwrap_or_else(|| panic!("{file}: no mesh"))
}

/// Moved and scaled to a diagonal of 1 about the origin.
fn scaled(mut mesh: PointSet) -> PointSet {
    let bound = |k: usize, pick: fn(f32, f32) -> f32| mesh.positions.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
    let (low, high) = ([0, 1, 2].map(|k| bound(k, f32::min)), [0, 1, 2].map(|k| bound(k, f32::max)));
    let diagonal = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f32>().sqrt();
    for p in &mut mesh.positions {
        *p = [0, 1, 2].map(|k| (p[k] - 0.5 * (low[k] + high[k])) / diagonal);
    }
    mesh
}
