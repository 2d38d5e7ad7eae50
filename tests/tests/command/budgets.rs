//! `--for-engine` and `bake verify --budget`: hulls within the limits of engines, counted here by
//! the faces of packs.

use std::fs;

use hullmap::{Hull, Pack};
use hullmap_outside::command::{Run, bake_in};
use hullmap_outside::files::workspace;
use shapes::families::Family;
use shapes::mesh::Mesh;
use shapes::obj::{Document, Object};
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

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

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
    fs::write(
        folder.path().join(name),
        Document { objects: vec![Object::from_mesh(None, mesh)], ..Document::default() }.to_text(),
    )
    .unwrap();
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
            let line = format!("build . --out p --index none --for-engine {engine} {options} --quiet");
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
            bake(&folder, &format!("verify p --budget {engine} --directions 200")).expect(0);
        }
        fs::remove_dir_all(folder.path().join("p")).unwrap();
    }
}

/// 84 vertices, 44 faces and 126 edges are within the limits of box3d, though only hulls of at most
/// 44 vertices always are.
#[test]
fn hulls_that_fit_stay_exact() {
    let folder = meshes();
    let run = bake(&folder, "build . --out p --for-engine box3d").expect(0);
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
    bake(&folder, "build rock.obj --out p --for-engine box3d --max-vertices 12 --quiet").expect(0);
    assert!(Pack::open(folder.path().join("p/rock.hullmap")).unwrap().hull(0).unwrap().vertex_count() <= 12);
    // The engine is one of the recorded options.
    let run = bake(&folder, "build drum.obj --out p --for-engine physx-gpu --check").expect(1);
    assert!(run.stdout.contains("stale") || run.stderr.contains("stale"), "{run:?}");
}

#[test]
fn verify_names_what_does_not_fit() {
    let folder = meshes();
    bake(&folder, "build . --out p --quiet").expect(0);
    bake(&folder, "verify p --directions 200").expect(0);
    let run = bake(&folder, "verify p --directions 200 --budget box3d --json").expect(1);
    for result in run.json() {
        let file = result["file"].as_str().unwrap();
        let fits = ["drum", "ell", "box"].iter().any(|name| file.contains(name));
        assert_eq!(result["pass"], fits, "{result}");
        assert_eq!(result["budget"].as_array().unwrap().is_empty(), fits, "{result}");
    }
    assert!(run.stderr.contains("constants.h"), "{run:?}");
    let run = bake(&folder, "verify p/rock.hullmap --budget physx-gpu").expect(1);
    assert!(run.stderr.contains("vertices, and at most 64 fit"), "{run:?}");
    bake(&folder, "verify p --budget quake").expect(2);
    // Lean packs have no faces of large hulls: they are counted all the same.
    bake(&folder, "build wheel.obj --out lean --lean --quiet").expect(0);
    let run = bake(&folder, "verify lean --budget jolt --directions 200").expect(1);
    assert!(run.stderr.contains("600 vertices, and at most 256 fit"), "{run:?}");
}

/// No number of vertices makes a needle or a plate fit: the build warns, and verification fails.
#[test]
fn needles_and_plates_get_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let square = |size: f64| [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
    write(&folder, "needle.obj", &extrusion(&square(0.01), 0.0, 1.0));
    write(&folder, "plate.obj", &extrusion(&square(1.0), 0.0, 0.002));
    let run = bake(&folder, "build needle.obj --out p --for-engine physx-gpu").expect(0);
    assert!(run.stderr.contains("an aspect of 100:1, and at most 64:1 fits"), "{run:?}");
    bake(&folder, "verify p --budget physx-gpu --directions 200").expect(1);
    bake(&folder, "verify p --budget physx --directions 200").expect(0);
    let run = bake(&folder, "build plate.obj --out q --for-engine box3d").expect(0);
    assert!(run.stderr.contains("a thickness of 2.00 mm") && run.stderr.contains("at least 5 mm"), "{run:?}");
    bake(&folder, "verify q --budget box3d --directions 200").expect(1);
    bake(&folder, "verify q --budget jolt --directions 200").expect(0);
}

#[test]
fn robots_keep_the_limits_too() {
    let folder = tempfile::tempdir().unwrap();
    let robots = workspace().join("tests/robots");
    let run = bake_in(
        folder.path(),
        [
            "robot".as_ref(),
            robots.join("arm.urdf").as_os_str(),
            "--out".as_ref(),
            folder.path().join("out").as_os_str(),
            "--for-engine".as_ref(),
            "physx-gpu".as_ref(),
        ],
    )
    .expect(0);
    let run = (run, bake_in(folder.path(), ["verify", "out", "--budget", "physx-gpu", "--directions", "200"]));
    assert_eq!(run.1.code, 0, "{run:?}");
    assert!(run.1.stdout.lines().count() > 2, "{run:?}");
}
