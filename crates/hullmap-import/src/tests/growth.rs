//! Growth of the import's time with each count in a file: m, 2 m, 4 m and 8 m items are imported 8,
//! 4, 2 and 1 times as often. The exponent is the slope of a line through the logarithms.
//!
//! The test fails only if all of several attempts exceed the bound, and each attempt keeps the
//! shortest times so far, of the processor on Linux. Other processes take their part of the caches,
//! so it runs on a quiet machine.

use std::fmt::Write as _;
use std::time::Duration;

use hullmap_testkit::clock::thread_time;

use super::limits::soup;
use super::*;

/// Divisor of the number of items for the smallest of the files.
const SMALL: usize = 16;

/// Maximum exponent of the time. Sorting alone has about 1.1.
const MAX_EXPONENT: f64 = 1.2;

/// Lower bound of each time. The system counts processor time in steps of some milliseconds.
const CLOCK_STEPS: Duration = Duration::from_millis(12);

const ATTEMPTS: usize = 8;

struct Case {
    name: &'static str,
    file: &'static str,
    count: usize,
    source: Box<dyn Fn(usize) -> SourceFile>,
    is_faulty: bool,
}

fn text_file(text: String) -> SourceFile {
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

fn list(count: usize, piece: &str) -> String {
    pieces(count, &format!("{piece},")).trim_end_matches(',').to_owned()
}

/// glTF text with these members besides `asset`, and one buffer of 64 bytes in the file `0.bin`.
fn document(members: &str) -> SourceFile {
    let bytes = format!(r#"{{"asset":{{"version":"2.0"}},{members}}}"#).into_bytes();
    SourceFile { beside: vec![("0.bin".to_owned(), vec![0; 64])], ..SourceFile::alone(bytes) }
}

/// A text with copies in place of each text between two `@`.
fn expanded(text: &str, copies: impl Fn(&str) -> String) -> String {
    let texts = text.split('@').enumerate();
    texts.map(|(at, text)| if at % 2 == 0 { text.to_owned() } else { copies(text) }).collect()
}

fn grown(template: &str, count: usize) -> SourceFile {
    let text = unescaped(template).replace("COUNT", &count.to_string()).replace("TWICE", &(2 * count).to_string());
    text_file(expanded(&text, |piece| pieces(count, piece)))
}

/// A glTF file, or the members of a [`document`].
fn listed(template: &str, count: usize) -> SourceFile {
    let text = template.replace("POINT", POINT).replace("MESH", MESH);
    let text = expanded(&text, |piece| list(count, piece));
    if text.starts_with('{') { text_file(text) } else { document(&text) }
}

const POINT: &str = r#""accessors":[{"componentType":5126,"type":"VEC3","count":1}]"#;

const MESH: &str = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}]"#;

/// Nodes of a mesh of many primitives, and of a mesh of a long name.
const REPEATED: [&str; 2] = [
    r#"POINT,"nodes":[@{"mesh":0}@],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0},@{}@]}]"#,
    r#"POINT,"nodes":[@{"mesh":0}@],"meshes":[{"name":"@n@","primitives":[{"attributes":{"POSITION":0},"mode":0}]}]"#,
];

fn indexed(mode: u32, count: usize, index: fn(usize) -> u16) -> SourceFile {
    let vertex_count = if mode == 4 { count } else { 100 };
    let mut bytes: Vec<u8> = (0..3 * vertex_count).flat_map(|x| (x as f32).to_le_bytes()).collect();
    let start = bytes.len();
    bytes.extend((0..count).flat_map(|at| index(at).to_le_bytes()));
    let length = bytes.len();
    let mut source = document(&format!(
        r#""buffers":[{{"uri":"0.bin","byteLength":{length}}}],"bufferViews":[{{"buffer":0,"byteLength":{start}}},{{"buffer":0,"byteOffset":{start},"byteLength":{}}}],"accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{vertex_count}}},{{"bufferView":1,"componentType":5123,"type":"SCALAR","count":{count}}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}}]}}]"#,
        length - start
    ));
    source.beside = vec![("0.bin".to_owned(), bytes)];
    source
}

fn sparse(count: usize) -> SourceFile {
    let mut bytes: Vec<u8> = (0..count as u32).flat_map(u32::to_le_bytes).collect();
    let start = bytes.len();
    bytes.extend((0..3 * count).flat_map(|x| (x as f32).to_le_bytes()));
    let mut source = document(&format!(
        r#"{MESH},"buffers":[{{"uri":"0.bin","byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteLength":{start}}},{{"buffer":0,"byteOffset":{start},"byteLength":{}}}],"accessors":[{{"componentType":5126,"type":"VEC3","count":{count},"sparse":{{"count":{count},"indices":{{"bufferView":0,"componentType":5125}},"values":{{"bufferView":1}}}}}}]"#,
        bytes.len(),
        bytes.len() - start
    ));
    source.beside = vec![("0.bin".to_owned(), bytes)];
    source
}

/// The rows of `growing.txt`.
fn texts() -> impl Iterator<Item = Case> {
    rows(include_str!("growing.txt")).map(|row| {
        let [name, file, count, text] = row[..] else { panic!("{row:?}") };
        let (file, is_faulty) = file.split_once(' ').map_or((file, false), |(file, _)| (file, true));
        let source = Box::new(move |count| if file == "a.gltf" { listed(text, count) } else { grown(text, count) });
        Case { name, file, count: count.parse().unwrap(), source, is_faulty }
    })
}

/// Files of other kinds.
fn cases() -> Vec<Case> {
    let case = |name, file, count, source: fn(usize) -> SourceFile| {
        let source = Box::new(source);
        Case { name, file, count, source, is_faulty: false }
    };
    let others = [
        case("glTF buffers", "a.gltf", 8_192, |count| {
            let mut source = listed(r##"POINT,MESH,"buffers":[@{"uri":"#.bin","byteLength":0}@]"##, count);
            source.beside = (0..count).map(|index| (format!("{index}.bin"), Vec::new())).collect();
            source
        }),
        case("glTF nodes in a chain", "a.gltf", 8_192, |count| {
            let nodes: Vec<String> = (1..count).map(|child| format!(r#"{{"children":[{child}]}}"#)).collect();
            document(&format!(r#"{POINT},{MESH},"nodes":[{},{{"mesh":0}}]"#, nodes.join(",")))
        }),
        case("OBJ blank lines behind a continuation", "a.obj", 65_536, |count| {
            // Longer than a part, so that the cut falls on the blank lines.
            let long = " ".repeat(crate::obj::PART_BYTES);
            text_file(format!("v 0 0 0\n#{long}\\{}", "\n".repeat(count)))
        }),
        case("OBJ in UTF-16", "a.obj", 16_384, |count| {
            let text = format!("\u{FEFF}{}", pieces(count, "v # 0 1\n"));
            SourceFile::alone(text.encode_utf16().flat_map(u16::to_le_bytes).collect())
        }),
        case("glTF vertices", "a.gltf", 16_384, |count| indexed(4, count, |_| 0)),
        case("glTF corners of a strip", "a.gltf", 16_384, |count| indexed(5, count, |at| at as u16 % 100)),
        case("glTF restarts of a strip", "a.gltf", 16_384, |count| {
            indexed(5, count, |at| if at % 4 == 3 { u16::MAX } else { at as u16 % 100 })
        }),
        case("glTF sparse replacements", "a.gltf", 16_384, sparse),
        case("GLB triangles compressed by Draco", "a.glb", 8_192, |count| {
            SourceFile::alone(draco::sheet(count as u32))
        }),
        case("GLB vertices compressed by meshopt", "a.glb", 65_536, |count| SourceFile::alone(meshopt::zeros(count))),
        case("GLB chunks", "a.glb", 65_536, |count| {
            let mut bytes = shapes::gltf::glb(&document(&format!("{POINT},{MESH}")).bytes, b"");
            bytes.extend([4, 0, 0, 0, b'x', 0, 0, 0, 1, 2, 3, 4].repeat(count));
            let length = (bytes.len() as u32).to_le_bytes();
            bytes[8..12].copy_from_slice(&length);
            SourceFile::alone(bytes)
        }),
        case("binary STL triangles", "a.stl", 16_384, |count| SourceFile::alone(soup(count))),
        case("binary STL of bytes behind the triangles", "a.stl", 524_288, |count| {
            SourceFile::alone([soup(2), vec![0; count]].concat())
        }),
    ];
    texts().chain(others).collect()
}

/// Time of repeated imports in one thread, whether it succeeds or fails.
fn time(case: &Case, source: &SourceFile, repetitions: usize) -> Duration {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let start = thread_time();
        for _ in 0..repetitions {
            drop(import_source(case.file, source, OBJECTS));
            if case.file.ends_with(".gltf") {
                drop(crate::gltf::buffer_paths(&source.bytes));
            }
        }
        thread_time() - start
    })
}

/// Slope of the line through the logarithms of `times` at 1, 2, 4, … items, by least squares.
fn slope(times: &[Duration]) -> f64 {
    let middle = (times.len() - 1) as f64 / 2.0;
    let terms = times.iter().enumerate().map(|(x, time)| {
        let x = x as f64 - middle;
        (x * time.as_secs_f64().log2(), x * x)
    });
    let (products, squares) = terms.fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
    products / squares
}

#[test]
fn slopes_match_the_exponent() {
    for exponent in [0.0, 1.0, 2.0_f64] {
        let times = [1.0_f64, 2.0, 4.0, 8.0].map(|n| Duration::from_secs_f64(n.powf(exponent)));
        assert!((slope(&times) - exponent).abs() < 1e-6, "{exponent}");
    }
}

#[test]
#[ignore = "needs a quiet machine; .ci/nightly runs it"]
fn the_exponent_of_every_count_is_1() {
    const FACTORS: [usize; 4] = [1, 2, 4, 8];
    let mut failed = Vec::new();
    for case in cases() {
        let files = FACTORS.map(|factor| (case.source)(factor * case.count / SMALL));
        for file in &files {
            let result = import_source(case.file, file, OBJECTS);
            assert_eq!(result.is_err(), case.is_faulty, "{}: {result:?}", case.name);
        }
        let mut repetitions = SMALL;
        while time(&case, &files[FACTORS.len() - 1], repetitions) < CLOCK_STEPS && repetitions < 1 << 12 {
            repetitions *= 2;
        }
        let mut times = [Duration::MAX; FACTORS.len()];
        let mut exponent = f64::MAX;
        for _ in 0..ATTEMPTS {
            for ((time_so_far, file), factor) in times.iter_mut().zip(&files).zip(FACTORS) {
                *time_so_far = time(&case, file, repetitions * FACTORS[3] / factor).max(CLOCK_STEPS).min(*time_so_far);
            }
            // All of them import the same number of items.
            exponent = 1.0 + slope(&times);
            if exponent < MAX_EXPONENT {
                break;
            }
        }
        println!("{}: {times:.1?}, exponent {exponent:.2}", case.name);
        if exponent >= MAX_EXPONENT {
            failed.push(format!("{}: {times:.1?}, exponent {exponent:.2}", case.name));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn repeated_primitives_and_names_reach_the_limit() {
    for template in REPEATED {
        let import = |count: usize| import_source("a.gltf", &listed(template, count), OBJECTS);
        fails(import(4096), "max_instanced");
        assert_eq!(import(64).unwrap().point_sets.len(), 64);
    }
}
