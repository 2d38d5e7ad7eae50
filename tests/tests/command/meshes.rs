//! Meshes by other people: the three in `tests/meshes`, and every OBJ file in the folder that
//! `HULLMAP_MESHES` names. Each folder has a `MANIFEST.tsv` with facts found by Qhull.
//!
//! # Vertex counts
//! The manifest describes the decimal numbers in the file, read in f64. A pack holds them rounded
//! to f32, and its hull is exactly the hull of the rounded points. Rounding can push a vertex into
//! the hull of the others, or out of it. Also, Qhull merges facets that are coplanar within its
//! rounding error, and their vertices with them. So three counts are compared:
//!
//! 1. the count in the manifest;
//! 2. the count of the exact hull of the decimal points, computed here. It may exceed the first by
//!    vertices that protrude from the hull of the others by less than [`MERGED`];
//! 3. the count in the pack. A vertex of only one of the second and third hull must lie within δ of
//!    the surface of the other, where δ is the maximum distance by which rounding to f32 moves a
//!    point of the mesh. The two hulls lie within δ of each other.
//!
//! The three counts agree on all meshes except `manifold_Offset1`. It lies five diameters from the
//! origin, where f32 is coarse (δ is 3e-7 of the diameter), and has rows of nearly coplanar
//! vertices: Qhull counts 231, the exact hull of the decimal points has 232, and the hull of the
//! rounded points 222.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use glam::DVec3;
use hullmap::{Hull, Pack};
use hullmap_bake::hull::{quickhull, rank, rank::Simplex};
use hullmap_outside::{command::bake, files};
use hullmap_tests::wavefront;

/// Columns of the manifest that the tests read.
const COLUMNS: [&str; 5] = ["file", "hull_vertices", "hull_volume", "diameter", "hull_vertices_referenced_only"];

/// Maximum protrusion, relative to the diameter, of a vertex that Qhull may merge away: a few times
/// the 1e-15 by which f64 rounds the decimal numbers of a mesh five diameters from the origin. The
/// one vertex it does merge protrudes by 1e-16.
const MERGED: f64 = 1e-14;

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

/// A solid's vertices, and its facets as indices of vertices.
struct Solid {
    vertices: Vec<DVec3>,
    facets: Vec<Vec<u32>>,
}

impl Solid {
    /// The exact hull of points.
    fn exact(points: &[DVec3]) -> Self {
        let mut points = points.to_vec();
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        points.dedup();
        let Simplex::Tetrahedron(simplex) = rank::spanning_simplex(&points) else { panic!("the points span no space") };
        let mut facets = quickhull::hull(&points, simplex);
        let mut used: Vec<u32> = facets.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for v in facets.iter_mut().flatten() {
            *v = used.binary_search(v).expect("used") as u32;
        }
        Self { vertices: used.into_iter().map(|v| points[v as usize]).collect(), facets }
    }

    /// A pack's hull.
    fn stored(hull: &Hull) -> Self {
        Self {
            vertices: hull.vertices().map(|v| v.as_dvec3()).collect(),
            facets: hull.faces().map(Iterator::collect).collect(),
        }
    }

    fn volume(&self) -> f64 {
        let at = |v: u32| self.vertices[v as usize] - self.vertices[0];
        let cone = |f: &Vec<u32>| f[1..].windows(2).map(|w| at(f[0]).dot(at(w[0]).cross(at(w[1])))).sum::<f64>();
        self.facets.iter().map(cone).sum::<f64>() / 6.0
    }

    /// Lower bound of the distance of `point` from the surface; negative inside, where it is the
    /// exact depth.
    fn height(&self, point: DVec3) -> f64 {
        let plane = |facet: &Vec<u32>| {
            let corners: Vec<DVec3> = facet.iter().map(|v| self.vertices[*v as usize]).collect();
            let spokes = corners.windows(2).map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
            let height = (point - corners[0]).dot(spokes.sum::<DVec3>().normalize());
            assert!(height.is_finite(), "a facet without a normal");
            height
        };
        self.facets.iter().map(plane).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Vertices whose rounded positions are not vertices of `other`: their maximum distance from
    /// its surface, and their count.
    fn missing_in(&self, other: &Self) -> (f64, usize) {
        let rounded = |p: &DVec3| p.as_vec3() + 0.0;
        let theirs: Vec<_> = other.vertices.iter().map(rounded).collect();
        let alone: Vec<&DVec3> = self.vertices.iter().filter(|p| !theirs.contains(&rounded(p))).collect();
        (alone.iter().map(|p| other.height(**p).abs()).fold(0.0, f64::max), alone.len())
    }

    /// Protrusion of each vertex from the hull of the others, ascending.
    fn protrusions(&self) -> Vec<f64> {
        let one = |lost: usize| {
            let mut rest = self.vertices.clone();
            let point = rest.remove(lost);
            Self::exact(&rest).height(point)
        };
        let mut all: Vec<f64> = (0..self.vertices.len()).map(one).collect();
        all.sort_unstable_by(f64::total_cmp);
        all
    }
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
        let verified = bake(["verify", packs, "--source", meshes, "--json", "--seed", "3"]).expect(0).json();
        assert_eq!(verified.len(), rows.len());
        for report in &verified {
            let regret = report["max_regret"].as_f64().unwrap();
            assert!(report["pass"] == true && report["against"] == "source" && regret <= 2e-7, "{report}");
        }
        for row in &rows {
            let file = &row["file"];
            let pack = Pack::open(out.path().join(file).with_extension("hullmap")).unwrap();
            check(row, &pack.hull(0).unwrap(), &fs::read_to_string(folder.join(file)).unwrap(), false);
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
            let words = ["build", file.to_str().unwrap(), "--vertices", "all", "--verify", "--json", "--out"];
            let built = bake(words.into_iter().chain([out.path().to_str().unwrap()])).expect(0).json();
            let text = fs::read_to_string(&file).unwrap();
            assert_eq!(built[0]["vertices_in"], wavefront::points(&text, true).len(), "{}", built[0]);
            assert!(wavefront::points(&text, false).len() < wavefront::points(&text, true).len());
            let pack = Pack::open(out.path().join(&row["file"]).with_extension("hullmap")).unwrap();
            let hull = pack.hull(0).unwrap();
            check(row, &hull, &text, true);
            assert!(row["file"] != "stanford_bunny.obj" || hull.vertex_count() == 1562);
            seen += 1;
        }
    }
    assert!(seen >= 1);
}

/// Compares a hull with the row of its mesh and with the exact hull of the text's points.
fn check(row: &HashMap<String, String>, hull: &Hull, text: &str, all: bool) {
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

    let points = wavefront::points(text, all);
    let reach = points.iter().fold(DVec3::ZERO, |reach, p| reach.max(p.abs()));
    // Half a unit in the last place of an f32 is at most 2⁻²⁴ of it.
    let delta = reach.length() * 2_f64.powi(-24);
    let (exact, ours) = (Solid::exact(&points), Solid::stored(hull));
    let (lost_by, lost) = exact.missing_in(&ours);
    let (gained_by, gained) = ours.missing_in(&exact);
    let volume_error = hull.volume() / exact.volume() - 1.0;
    let count = exact.vertices.len();
    println!(
        "{file:24} vertices {}, exact in f64 {count}, manifest {stated}; volume {volume_error:+.0e}",
        ours.vertices.len()
    );
    if lost + gained > 0 {
        let [delta, lost_by, gained_by] = [delta, lost_by, gained_by].map(|length| length / diameter);
        println!(
            "    rounding: {lost} lost within {lost_by:.1e}, {gained} gained within {gained_by:.1e}; δ = {delta:.1e}"
        );
    }
    assert!(lost_by <= delta && gained_by <= delta, "{file}: {lost_by:e}, {gained_by:e}, {delta:e}");
    assert!(lost + gained > 0 || ours.vertices.len() == count, "{file}");
    assert!(volume_error.abs() <= VOLUME, "{file}");
    if count != stated {
        let least = exact.protrusions();
        println!(
            "    least protrusions: {:.0e} {:.0e} {:.0e} of the diameter",
            least[0] / diameter,
            least[1] / diameter,
            least[2] / diameter
        );
        assert!(count > stated && least[count - stated - 1] <= MERGED * diameter, "{file}");
    }
    // The manifest's volumes are of all vertices, also where it counts the referenced ones.
    if referenced.is_none() || stated == field(row, "hull_vertices").unwrap_or_default() as usize {
        let volume = field(row, "hull_volume").expect("a solid has a volume");
        assert!((hull.volume() / volume - 1.0).abs() <= VOLUME, "{file}: volume {}", hull.volume());
    }
}
