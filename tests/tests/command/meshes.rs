//! Meshes by other people: the three in `tests/meshes`, and every OBJ file in the folder that
//! `HULLMAP_MESHES` names. Each folder has a `MANIFEST.tsv` with facts found by Qhull.
//!
//! The manifest describes the decimal numbers in the file, a pack holds them rounded to f32. The
//! counts of vertices agree on all meshes except `manifold_Offset1`. It lies five diameters from
//! the origin, where f32 is coarse, and has rows of nearly coplanar vertices.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use hullmap::{Hull, Pack};
use hullmap_testkit::{command::bake, files};

/// Columns of the manifest that the tests read.
const COLUMNS: [&str; 6] =
    ["file", "vertices", "hull_vertices", "hull_volume", "diameter", "hull_vertices_referenced_only"];

/// The mesh whose rounded points have fewer vertices than its decimal ones, and their number.
const ROUNDED: (&str, usize) = ("manifold_Offset1.obj", 222);

/// Relative tolerances: the manifest has nine digits, and rounding to f32 costs more of them far
/// from the origin.
const VOLUME: f64 = 1e-5;
const DIAMETER: f64 = 1e-6;

/// The folder of committed meshes, and the one that `HULLMAP_MESHES` names.
fn folders() -> Vec<PathBuf> {
    let committed = files::workspace().join("tests/meshes");
    [committed].into_iter().chain(files::path("HULLMAP_MESHES", "more meshes")).collect()
}

/// Rows of the manifest, by column.
fn manifest(folder: &Path) -> Vec<HashMap<String, String>> {
    let text = fs::read_to_string(folder.join("MANIFEST.tsv")).expect("the folder has a manifest");
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().unwrap_or_default().split('\t').collect();
    assert!(COLUMNS.iter().all(|column| columns.contains(column)), "{columns:?}");
    let row = |line: &str| columns.iter().zip(line.split('\t')).map(|(k, v)| ((*k).to_owned(), v.to_owned())).collect();
    lines.map(row).collect()
}

fn field(row: &HashMap<String, String>, column: &str) -> Option<f64> {
    row.get(column).filter(|text| !text.is_empty()).map(|text| text.parse().expect("a number"))
}

#[test]
fn every_mesh_bakes_verifies_and_agrees_with_the_manifest() {
    for folder in folders() {
        let out = tempfile::tempdir().unwrap();
        let (meshes, packs) = (folder.to_str().unwrap(), out.path().to_str().unwrap());
        let rows = manifest(&folder);
        assert!(rows.len() >= 3, "{meshes}");
        let built = bake(["build", meshes, "--out", packs, "--json"]).expect(0).json();
        assert_eq!(built.len(), rows.len(), "{meshes}: every file of the manifest, and no other");
        let verified = bake(["verify", packs, "--source", meshes, "--json", "--set", "seed=3"]).expect(0).json();
        assert_eq!(verified.len(), rows.len());
        for report in &verified {
            let regret = report["max_regret"].as_f64().unwrap();
            assert!(report["pass"] == true && report["against"] == "source" && regret <= 2e-7, "{report}");
        }
        for row in &rows {
            let file = &row["file"];
            let pack = Pack::open(out.path().join(file).with_extension("hullmap")).unwrap();
            check(row, &pack.hull(0).unwrap(), false);
        }
    }
}

/// The Cornell box has four vertices without a face. So has the bunny, and 60 are on its hull.
#[test]
fn unreferenced_vertices_count_with_vertices_all() {
    let mut seen = 0;
    for folder in folders() {
        let out = tempfile::tempdir().unwrap();
        for row in manifest(&folder).iter().filter(|row| field(row, "hull_vertices_referenced_only").is_some()) {
            let file = folder.join(&row["file"]);
            let words = ["build", file.to_str().unwrap(), "--set", "vertices=all", "--verify", "--json", "--out"];
            let built = bake(words.into_iter().chain([out.path().to_str().unwrap()])).expect(0).json();
            assert_eq!(built[0]["vertices_in"].to_string(), row["vertices"], "{}", built[0]);
            let pack = Pack::open(out.path().join(&row["file"]).with_extension("hullmap")).unwrap();
            let hull = pack.hull(0).unwrap();
            check(row, &hull, true);
            assert!(row["file"] != "stanford_bunny.obj" || hull.vertex_count() == 1562);
            seen += 1;
        }
    }
    assert!(seen >= 1);
}

/// Compares a hull with the row of its mesh.
fn check(row: &HashMap<String, String>, hull: &Hull, all: bool) {
    let file = &row["file"];
    let diameter = field(row, "diameter").expect("every mesh has a diameter");
    // The manifest's diameters are of all vertices; no mesh has an unreferenced one at its far end.
    assert!((hull.diameter() / diameter - 1.0).abs() <= DIAMETER, "{file}: diameter {}", hull.diameter());
    let referenced = field(row, "hull_vertices_referenced_only").filter(|_| !all);
    let Some(stated) = referenced.or(field(row, "hull_vertices")).map(|count| count as usize) else {
        assert_eq!((hull.rank(), hull.volume()), (2, 0.0), "{file}: Qhull finds no solid");
        println!("{file:24} rank 2, {} vertices", hull.vertex_count());
        return;
    };
    assert_eq!(hull.rank(), 3, "{file}");

    let expected = if *file == ROUNDED.0 { ROUNDED.1 } else { stated };
    assert_eq!(hull.vertex_count(), expected, "{file}");
    // The manifest's volumes are of all vertices, also where it counts the referenced ones.
    if referenced.is_none() || stated == field(row, "hull_vertices").unwrap_or_default() as usize {
        let volume = field(row, "hull_volume").expect("a solid has a volume");
        assert!((hull.volume() / volume - 1.0).abs() <= VOLUME, "{file}: volume {}", hull.volume());
    }
}
