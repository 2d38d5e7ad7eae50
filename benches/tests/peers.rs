//! The harness of decompositions, with tools of the test's own: it passes V-HACD groups of four
//! numbers, and refuses to go on with parts that are not the known boxes.
#![cfg(unix)]

use std::{fs, path::Path, process::Command};

/// As much of trimesh as the harness uses, without its dependencies.
const TRIMESH: &str = "
class load:
    def __init__(self, path, force, process):
        rows = [line.split() for line in open(path)]
        self.vertices = [[float(x) for x in row[1:]] for row in rows if row[0] == 'v']
        self.faces = [[int(i) - 1 for i in row[1:]] for row in rows if row[0] == 'f']
";

/// A tool that reads faces as V-HACD's package does, and returns the two boxes that they form. If
/// they do not, it returns slivers.
const VHACDX: &str = "
def compute_vhacd(points, faces, maxConvexHulls):
    faces = [int(i) for i in faces]
    groups = [faces[at : at + 4] for at in range(0, len(faces), 4)]
    if all(len(group) == 4 and group[0] == 3 for group in groups):
        boxes = [[[i % 8 for i in group[1:]] for group in groups if group[1] // 8 == box] for box in (0, 1)]
        return [(points[8 * box : 8 * box + 8], boxes[box]) for box in (0, 1)]
    return [(points[:4], [[0, 1, 2]])] * 64
";

/// Runs the harness on an empty folder. Returns its status, what it printed, and its errors; `None`
/// without Python.
fn run(harness: &str) -> Option<(bool, String, String)> {
    let folder = tempfile::tempdir().unwrap();
    let peers = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers");
    for name in ["known.py", "known.txt"] {
        fs::copy(peers.join(name), folder.path().join(name)).unwrap();
    }
    for (name, text) in [("decompose.py", harness), ("trimesh.py", TRIMESH), ("vhacdx.py", VHACDX)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let package = folder.path().join("vhacdx-0.1.1.dist-info");
    fs::create_dir(&package).unwrap();
    fs::write(package.join("METADATA"), "Metadata-Version: 2.1\nName: vhacdx\nVersion: 0.1.1\n").unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    let mut python = Command::new("python3");
    let out = python.args(["decompose.py", "vhacd", "meshes", "out"]).current_dir(folder.path()).output().ok()?;
    let proof = fs::read_to_string(folder.path().join("out/proof.txt")).unwrap_or_default();
    let [printed, errors] = [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(!out.status.success() || proof == printed, "{proof:?} {printed:?}");
    Some((out.status.success(), printed, errors))
}

#[test]
fn a_decomposition_is_proven_before_it_is_measured() {
    let harness = include_str!("../peers/decompose.py");
    let Some((succeeds, printed, errors)) = run(harness) else {
        println!("skipped: there is no python3");
        return;
    };
    assert!(succeeds, "{errors}");
    assert_eq!(printed, "vhacdx 0.1.1, two known boxes: parts 2, smaller volume 3, larger volume 32\n");
    // Rows of three corners, as once.
    let rows = harness.replace("(3, *face)", "face");
    assert_ne!(rows, harness);
    let (succeeds, printed, errors) = run(&rows).unwrap();
    assert!(!succeeds && printed.is_empty(), "{printed}");
    assert!(errors.starts_with("vhacdx 0.1.1, two known boxes: parts 64 instead of 2. "), "{errors}");
}
