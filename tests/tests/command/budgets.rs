//! `--for` and `bake verify --for`: hulls within the limits of engines, counted here by
//! the faces of packs.

use std::fs;

use hullmap::{Hull, Pack};
use hullmap_testkit::command::bake_line as bake;
use shapes::families::Family;
use shapes::mesh::Mesh;
use shapes::obj;
use shapes::solids::{extrusion, regular_polygon};
use tempfile::TempDir;

/// Maximum numbers of vertices, faces, triangles, edges, and vertices of a face, as their engines
/// state them.
const LIMITS: [(&str, [usize; 5]); 8] = [
    ("physx", [255, 255, usize::MAX, usize::MAX, usize::MAX]),
    ("physx-gpu", [64, 64, usize::MAX, usize::MAX, 32]),
    ("jolt", [256, usize::MAX, usize::MAX, usize::MAX, usize::MAX]),
    ("box3d", [128, 128, usize::MAX, 128, usize::MAX]),
    ("unity", [255, usize::MAX, 255, usize::MAX, usize::MAX]),
    ("unreal", [32, usize::MAX, usize::MAX, usize::MAX, usize::MAX]),
    ("newton", [64, usize::MAX, usize::MAX, usize::MAX, usize::MAX]),
    ("mujoco-warp", [64, usize::MAX, usize::MAX, usize::MAX, usize::MAX]),
];

fn counts(hull: &Hull) -> [usize; 5] {
    let faces: Vec<usize> = hull.faces().map(|face| face.count()).collect();
    let corners: usize = faces.iter().sum();
    let largest = faces.iter().copied().max().unwrap_or(0);
    [hull.vertex_count(), faces.len(), corners - 2 * faces.len(), corners / 2, largest]
}

fn packs(folder: &TempDir) -> Vec<(String, Pack)> {
    let files = fs::read_dir(folder.path().join("p")).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), Pack::open(path).unwrap())).collect()
}

fn write(folder: &TempDir, name: &str, mesh: &Mesh) {
    fs::write(folder.path().join(name), obj::text(mesh)).unwrap();
}

/// A rock of hundreds of vertices, a prism of many sides, an L, and a box.
fn meshes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let points: String = Family::Rock.points(600, 7).iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    fs::write(folder.path().join("rock.obj"), points).unwrap();
    write(&folder, "drum.obj", &extrusion(&regular_polygon(42, 1.0), 0.0, 1.0));
    write(&folder, "wheel.obj", &extrusion(&regular_polygon(300, 1.0), 0.0, 1.0));
    let ell = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    write(&folder, "ell.obj", &extrusion(&ell, 0.0, 1.0));
    write(&folder, "box.obj", &extrusion(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.0, 1.0));
    folder
}

#[test]
fn builds_are_within_every_limit_of_their_engine() {
    let folder = meshes();
    for (engine, limits) in LIMITS {
        // Parts have a number of vertices that is within every limit, so two engines are enough.
        let options: &[&str] = if ["physx-gpu", "box3d"].contains(&engine) { &["", "--decompose"] } else { &[""] };
        for options in options {
            let line = format!("build . --out p --set index=none --for {engine} {options} --quiet");
            bake(&folder, &line).expect(0);
            let packs = packs(&folder);
            assert_eq!(packs.len(), 5);
            for (name, pack) in &packs {
                for hull in pack.hulls() {
                    let found = counts(&hull);
                    assert!(found.iter().zip(limits).all(|(a, b)| *a <= b), "{engine}, {name}: {found:?}, {limits:?}");
                }
            }
            // It contains its source, and has a bound on its error like any simplified hull.
            bake(&folder, &format!("verify p --for {engine} --directions 200")).expect(0);
        }
        fs::remove_dir_all(folder.path().join("p")).unwrap();
    }
}

/// 84 vertices, 44 faces and 126 edges are within the limits of box3d, though only hulls of at most
/// 44 vertices always are.
#[test]
fn hulls_that_fit_stay_exact() {
    let folder = meshes();
    let run = bake(&folder, "build . --out p --for box3d --verbose").expect(0);
    for (name, pack) in packs(&folder) {
        let hull = pack.hull(0).unwrap();
        match name.as_str() {
            "drum" => assert_eq!((counts(&hull)[..4].to_vec(), hull.outer_error()), (vec![84, 44, 164, 126], 0.0)),
            "box" => assert_eq!((hull.vertex_count(), hull.outer_error()), (8, 0.0)),
            "rock" | "wheel" => assert!(hull.outer_error() > 0.0 && hull.vertex_count() <= 44, "{name}"),
            _ => {}
        }
    }
    assert!(run.stderr.contains("simplified to") && run.stderr.contains("at most 128 fit"), "{run:?}");
    // A smaller limit of the user counts.
    bake(&folder, "build rock.obj --out p --for box3d --max-vertices 12 --quiet").expect(0);
    assert!(Pack::open(folder.path().join("p/rock.hullmap")).unwrap().hull(0).unwrap().vertex_count() <= 12);
    // The engine is one of the recorded options.
    let run = bake(&folder, "build drum.obj --out p --for physx-gpu --check").expect(1);
    assert!(run.stdout.contains("stale") || run.stderr.contains("stale"), "{run:?}");
}
