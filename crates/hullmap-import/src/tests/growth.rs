//! Growth of the import's time with each count in a file.
//!
//! Each case imports a file of n items 8 times, and a file of 8 n items once. Linear work takes the
//! same time for both, quadratic work 8 times as long for the second. The bound lies between the
//! two. Only the ratio is tested, and only if all of several attempts exceed the bound. On Linux
//! the time is that of the processor, so that other processes do not disturb it.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use super::super::*;
use crate::options::Split;

/// Factor between the two sizes.
const FACTOR: usize = 8;

/// Maximum ratio of the two times.
const MAX_RATIO: f64 = 4.0;

/// Lower bound of the first time. The system counts processor time in steps of some milliseconds.
const CLOCK_STEPS: Duration = Duration::from_millis(12);

const ATTEMPTS: usize = 5;

const OBJECTS: ImportOptions = ImportOptions { split: Split::Object, ..ImportOptions::DEFAULT };

struct Case {
    name: &'static str,
    file: &'static str,
    /// Number of items in the smaller file.
    count: usize,
    source: fn(usize) -> SourceFile,
}

fn text(text: String) -> SourceFile {
    SourceFile::alone(text.into_bytes())
}

/// `count` copies of `piece`, each with its index in place of `#`.
fn pieces(count: usize, piece: &str) -> String {
    let mut text = String::new();
    for index in 0..count {
        write!(text, "{}", piece.replace('#', &index.to_string())).unwrap();
    }
    text
}

/// The same, separated by commas.
fn list(count: usize, piece: &str) -> String {
    pieces(count, &format!("{piece},")).trim_end_matches(',').to_owned()
}

/// glTF text with these members besides `asset`, and one buffer of 64 bytes in the file `0.bin`.
fn document(members: &str) -> SourceFile {
    let bytes = format!(r#"{{"asset":{{"version":"2.0"}},{members}}}"#).into_bytes();
    SourceFile { beside: vec![("0.bin".to_owned(), vec![0; 64])], ..SourceFile::alone(bytes) }
}

const POINT: &str = r#""accessors":[{"componentType":5126,"type":"VEC3","count":1}]"#;

fn distinct_buffers(count: usize) -> SourceFile {
    let mut source = document(&format!(
        r#"{POINT},"buffers":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":0}}]}}]"#,
        list(count, r##"{"uri":"#.bin","byteLength":0}"##)
    ));
    source.beside = (0..count).map(|index| (format!("{index}.bin"), Vec::new())).collect();
    source
}

/// `count` nodes that all show one mesh of `count` primitives without elements.
fn empty_primitives(count: usize) -> SourceFile {
    document(&format!(
        r#"{POINT},"nodes":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":0}},{}]}}]"#,
        list(count, r#"{"mesh":0}"#),
        list(count, "{}")
    ))
}

/// `count` nodes that all take the name of one mesh, of `count` letters.
fn long_mesh_name(count: usize) -> SourceFile {
    let name = "n".repeat(count);
    document(&format!(
        r#"{POINT},"nodes":[{}],"meshes":[{{"name":"{name}","primitives":[{{"attributes":{{"POSITION":0}},"mode":0}}]}}]"#,
        list(count, r#"{"mesh":0}"#)
    ))
}

fn cases() -> Vec<Case> {
    let case = |name, file, count, source| Case { name, file, count, source };
    vec![
        case("glTF buffers", "a.gltf", 8_192, distinct_buffers),
        case("glTF nodes of a mesh of many primitives", "a.gltf", 4_096, empty_primitives),
        case("glTF nodes of a mesh of a long name", "a.gltf", 16_384, long_mesh_name),
        case("OBJ vertices", "a.obj", 16_384, |count| text(pieces(count, "v # 0 1\n"))),
        case("OBJ faces", "a.obj", 16_384, |count| text("v 0 0 0\n".to_owned() + &pieces(count, "f 1 1 1\n"))),
        case("OBJ objects", "a.obj", 8_192, |count| text("v 0 0 0\n".to_owned() + &pieces(count, "o o#\np 1\n"))),
        case("OBJ objects of one name", "a.obj", 8_192, |count| {
            text("v 0 0 0\n".to_owned() + &pieces(count, "o o\np 1\n"))
        }),
        case("OBJ corners of a face", "a.obj", 65_536, |count| text(format!("v 0 0 0\nf{}\n", pieces(count, " 1")))),
        case("OBJ continuations", "a.obj", 32_768, |count| text(format!("v 0 0 0\nf 1{}\n", pieces(count, " \\\n1")))),
        case("OBJ continuations of a long word", "a.obj", 32_768, |count| {
            text(format!("v 0 0 0\n{}{}\n", "x".repeat(4 * count), pieces(count, "\\\n")))
        }),
        case("OBJ blank lines behind a continuation", "a.obj", 65_536, |count| {
            // Longer than a part, so that the cut falls on the blank lines.
            let long = " ".repeat(super::super::obj::PART_BYTES);
            text(format!("v 0 0 0\n#{long}\\{}", "\n".repeat(count)))
        }),
        case("OBJ faults", "a.obj", 16_384, |count| text(pieces(count, "f 9\n") + "v 0 0 0\n")),
        case("STL facets", "a.stl", 8_192, |count| {
            let facet = "facet normal 0 0 0 outer loop vertex # 0 0 vertex # 1 0 vertex # 0 1 endloop endfacet\n";
            text(format!("solid a\n{}endsolid\n", pieces(count, facet)))
        }),
        case("STL solids", "a.stl", 4_096, |count| {
            let solid =
                "solid s\nfacet normal 0 0 0 outer loop vertex # 0 0 vertex # 1 0 vertex # 0 1 endloop endfacet\n";
            text(pieces(count, solid))
        }),
        case("PLY vertices", "a.ply", 16_384, |count| {
            let header = format!("ply\nformat ascii 1.0\nelement vertex {count}\n");
            text(
                header
                    + "property float x\nproperty float y\nproperty float z\nend_header\n"
                    + &pieces(count, "# 0 1\n"),
            )
        }),
        case("PLY properties", "a.ply", 16_384, |count| {
            let header =
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
            text(format!("{header}{}end_header\n0 0 0{}", pieces(count, "property float a#\n"), pieces(count, " 1")))
        }),
        case("PLY elements", "a.ply", 16_384, |count| {
            let header =
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
            text(format!("{header}{}end_header\n0 0 0\n", pieces(count, "element e# 0\n")))
        }),
        case("glTF nodes in a chain", "a.gltf", 8_192, |count| {
            let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}]"#;
            let nodes: Vec<String> = (1..count).map(|child| format!(r#"{{"children":[{child}]}}"#)).collect();
            document(&format!(r#"{POINT},{mesh},"nodes":[{},{{"mesh":0}}]"#, nodes.join(",")))
        }),
        case("glTF primitives of one accessor", "a.gltf", 8_192, |count| {
            let primitives = list(count, r#"{"attributes":{"POSITION":0},"mode":0}"#);
            document(&format!(r#"{POINT},"meshes":[{{"primitives":[{primitives}]}}]"#))
        }),
    ]
}

/// Processor time of this thread where the system reports it, else the time since `start`.
fn thread_time(start: Instant) -> Duration {
    let schedstat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = schedstat.split_whitespace().next().and_then(|word| word.parse().ok());
    nanoseconds.map_or_else(|| start.elapsed(), Duration::from_nanos)
}

/// Time of repeated imports in one thread, whether it succeeds or fails.
fn time(case: &Case, source: &SourceFile, repetitions: usize) -> Duration {
    let path = Path::new(case.file);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let start = Instant::now();
        let before = thread_time(start);
        for _ in 0..repetitions {
            drop(import(case.file, "shape", path, source, &OBJECTS, &Limits::DEFAULT));
            if case.file.ends_with(".gltf") {
                drop(crate::gltf::buffer_paths(&source.bytes));
            }
        }
        thread_time(start) - before
    })
}

#[test]
fn no_import_grows_quadratically() {
    let mut failed = Vec::new();
    for case in cases() {
        let [small, large] = [1, FACTOR].map(|factor| (case.source)(factor * case.count));
        // The shortest of several times is the one with the least noise.
        let mut times = [Duration::MAX; 2];
        let mut ratio = f64::MAX;
        for _ in 0..ATTEMPTS {
            times = [times[0].min(time(&case, &small, FACTOR)), times[1].min(time(&case, &large, 1))];
            ratio = times[1].as_secs_f64() / times[0].max(CLOCK_STEPS).as_secs_f64();
            if ratio <= MAX_RATIO {
                break;
            }
        }
        println!("{}: {:.1?}, {:.1?}, ratio {ratio:.1}", case.name, times[0], times[1]);
        if ratio > MAX_RATIO {
            failed.push(format!("{}: {:.1?} became {:.1?}", case.name, times[0], times[1]));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Repetition by primitives or names counts towards the limit of the user.
#[test]
fn repeated_primitives_and_names_reach_the_limit() {
    for (source, count) in [(empty_primitives as fn(usize) -> SourceFile, 4096), (long_mesh_name, 4096)] {
        let import =
            |source: &SourceFile, limits: &Limits| import("a.gltf", "a", Path::new("a.gltf"), source, &OBJECTS, limits);
        let error = import(&source(count), &Limits::DEFAULT).unwrap_err().to_string();
        assert!(error.contains("--max-instanced"), "{error}");
        assert_eq!(import(&source(64), &Limits::DEFAULT).unwrap().point_sets.len(), 64);
    }
}
