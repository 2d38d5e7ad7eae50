//! Harnesses of other tools refuse wrong answers to the known boxes. The harness of decompositions
//! is run with tools of the test's own: it passes V-HACD groups of four numbers, and CoACD all
//! triangles.
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

/// A tool that returns the boxes whose triangles it gets.
const COACD: &str = "
class Mesh:
    def __init__(self, points, faces):
        self.points, self.faces = points, faces
def set_log_level(level):
    pass
def run_coacd(mesh, threshold):
    boxes = [[[i % 8 for i in face] for face in mesh.faces if face[0] // 8 == box] for box in (0, 1)]
    return [(mesh.points[8 * box : 8 * box + 8], faces) for box, faces in enumerate(boxes) if faces]
";

/// A tool: its name, its package, its version and its text. Then a fault of the harness, as words
/// and what they become, and the wrong answer.
const TOOLS: [[&str; 7]; 2] = [
    // Rows of three corners, as once.
    ["vhacd", "vhacdx", "0.1.1", VHACDX, "(3, *face)", "face", "parts 64 instead of 2"],
    ["coacd", "coacd", "1.0.14", COACD, "mesh.faces)", "mesh.faces[:12])", "parts 1 instead of 2"],
];

/// Runs the harness on an empty folder. Returns its status, what it printed, and its errors; `None`
/// without Python.
fn run(harness: &str, [tool, package, version, text, ..]: [&str; 7]) -> Option<(bool, String, String)> {
    let folder = tempfile::tempdir().unwrap();
    let peers = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers");
    for name in ["known.py", "known.txt"] {
        fs::copy(peers.join(name), folder.path().join(name)).unwrap();
    }
    for (name, text) in [("decompose.py", harness), ("trimesh.py", TRIMESH), (&format!("{package}.py"), text)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let metadata = folder.path().join(format!("{package}-{version}.dist-info"));
    fs::create_dir(&metadata).unwrap();
    let lines = format!("Metadata-Version: 2.1\nName: {package}\nVersion: {version}\n");
    fs::write(metadata.join("METADATA"), lines).unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    let mut python = Command::new("python3");
    let out = python.args(["decompose.py", tool, "meshes", "out"]).current_dir(folder.path()).output().ok()?;
    let proof = fs::read_to_string(folder.path().join("out/proof.txt")).unwrap_or_default();
    let [printed, errors] = [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(!out.status.success() || proof == printed, "{proof:?} {printed:?}");
    Some((out.status.success(), printed, errors))
}

#[test]
fn a_decomposition_is_proven_before_it_is_measured() {
    let harness = include_str!("../peers/decompose.py");
    for tool in TOOLS {
        let [_, package, version, _, right, wrong, refusal] = tool;
        let Some((succeeds, printed, errors)) = run(harness, tool) else {
            println!("skipped: there is no python3");
            return;
        };
        assert!(succeeds, "{errors}");
        let subject = format!("{package} {version}, two known boxes: ");
        assert_eq!(printed, format!("{subject}parts 2, smaller volume 3, larger volume 32\n"));
        let faulty = harness.replace(right, wrong);
        assert_ne!(faulty, harness);
        let (succeeds, printed, errors) = run(&faulty, tool).unwrap();
        assert!(!succeeds && printed.is_empty(), "{printed}");
        assert!(errors.starts_with(&format!("{subject}{refusal}. ")), "{errors}");
    }
}

/// Every script that measures another engine proves it by this function.
#[test]
fn a_wrong_answer_ends_a_script() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    for script in [
        "peers/decompose.py",
        "peers/pit_mujoco.py",
        "../crates/hullmap-python/benches/robot.py",
        "../tests/robots/check_motions.py",
        "../tests/robots/check_planner.py",
    ] {
        let text = fs::read_to_string(folder.join(script)).unwrap();
        assert!(text.contains("known.require("), "{script}");
    }
    for (answers, is_right) in [
        ("0.25, True", true),
        ("0.2504, True", true),
        ("-0.25, True", false),
        ("0.252, True", false),
        ("float('nan'), True", false),
        ("float('inf'), True", false),
        ("0.25, False", false),
    ] {
        let code =
            format!("import known; d, h = {answers}; known.require('E', [('depth', 0.25, d), ('hit', True, h)])");
        let mut python = Command::new("python3");
        let Ok(out) = python.args(["-B", "-c", &code]).current_dir(folder.join("peers")).output() else {
            println!("skipped: there is no python3");
            return;
        };
        assert_eq!((out.status.success(), out.stdout.is_empty()), (is_right, !is_right), "{answers}: {out:?}");
    }
}
