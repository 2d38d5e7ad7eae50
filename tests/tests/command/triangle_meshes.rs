//! `--keep-triangles`: static triangle meshes, from the command to files, and back.

use std::fs;
use std::path::Path;

use hullmap::TriangleMesh;
use hullmap_bake::{
    SourceRecord,
    triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh},
};
use hullmap_format::{
    header::{FileKind, HEADER_LEN, Header},
    triangle_mesh::sections::Sections,
};
use hullmap_outside::command::{Run, bake_in};
use serde_json::Value;
use shapes::rng::SplitMix64;
use tempfile::TempDir;

const SEED: u64 = 39;

/// The options that `--keep-triangles` alone records.
const OPTIONS: &str = "split none, vertices referenced, index none, keep_triangles true";

fn run(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

/// A rough floor of squares in y-up, with two materials and a part without one.
fn level(cells: usize) -> String {
    let mut rng = SplitMix64::new(SEED);
    let mut text = String::new();
    for z in 0..=cells {
        for x in 0..=cells {
            text += &format!("v {x} {:.3} {z}\n", rng.unit());
        }
    }
    for z in 0..cells {
        match z {
            1 => text += "usemtl rock\n",
            2 => text += "usemtl wet grass\n",
            _ => {}
        }
        for x in 0..cells {
            let first = 1 + z * (cells + 1) + x;
            text += &format!("f {first} {} {} {}\n", first + cells + 1, first + cells + 2, first + 1);
        }
    }
    text
}

/// A folder with a level `in/level.obj`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    fs::write(folder.path().join("in/level.obj"), level(6)).unwrap();
    folder
}

fn row(folder: &TempDir, line: &str, code: i32) -> Value {
    run(folder, line).expect(code).json().remove(0)
}

#[test]
fn a_level_keeps_its_triangles_and_materials() {
    let folder = folder();
    let row = row(&folder, "build in/level.obj --out o --keep-triangles --up-axis y-to-z --unit-scale 2 --json", 0);
    assert_eq!((&row["status"], &row["output"]), (&"baked".into(), &"o/level.hullmesh".into()), "{row}");
    let mesh = &row["triangle_mesh"];
    assert_eq!((&mesh["triangles"], &mesh["vertices"]), (&72.into(), &49.into()), "{row}");
    assert_eq!(mesh["materials"], serde_json::json!(["rock", "wet grass"]));
    assert_eq!((&mesh["edges"]["border"], &row["hulls"]), (&24.into(), &Value::Null));
    let mesh = TriangleMesh::open(folder.path().join("o/level.hullmesh")).unwrap();
    assert_eq!(mesh.options(), OPTIONS.replace("none, keep", "none, unit_scale 2, up_axis y-to-z, keep"));
    for triangle in 0..72 {
        let row = mesh.source_triangle(triangle).unwrap() / 12;
        assert_eq!(mesh.material(triangle), Some([0, 1, 2, 2, 2, 2][row as usize]));
        // z of the file, from 0 to 6, is -y.
        let corners = mesh.triangle(triangle).unwrap().corners();
        let at = -2.0 * f64::from(row);
        assert!(corners.iter().all(|corner| corner.y <= at && corner.y >= at - 2.0), "{row} {corners:?}");
        let [a, b, c] = corners;
        assert!((b - a).cross(c - a).z > 0.0, "the front is up");
    }
}

#[test]
fn files_are_fresh_by_the_rules_of_packs() {
    let folder = folder();
    let path = folder.path().join("o/level.hullmesh");
    let build = "build in --out o --keep-triangles --json";
    assert_eq!(row(&folder, "build in --out o --keep-triangles --check --json", 1)["status"], "missing");
    assert_eq!(row(&folder, build, 0)["status"], "baked");
    let bytes = fs::read(&path).unwrap();
    let fresh = row(&folder, "build in --out o --keep-triangles --verify --json", 0);
    assert_eq!((&fresh["status"], &fresh["triangle_mesh"]["triangles"]), (&"fresh".into(), &72.into()));
    run(&folder, "status in --out o --keep-triangles").expect(0);
    let scaled = "build in --out o --keep-triangles --unit-scale 3 --check --json";
    assert_eq!(row(&folder, scaled, 1)["status"], "stale");
    // The same bytes for any number of threads, and from a task of a plan.
    for line in ["--jobs 1", "--jobs 3"] {
        assert_eq!(row(&folder, &format!("{build} --force {line}"), 0)["status"], "baked");
        assert!(fs::read(&path).unwrap() == bytes, "{line}");
    }
    let plan = run(&folder, "plan in --out o --keep-triangles").expect(0).stdout;
    fs::write(folder.path().join("plan.jsonl"), plan).unwrap();
    fs::remove_file(&path).unwrap();
    run(&folder, "task plan.jsonl").expect(0);
    assert!(fs::read(&path).unwrap() == bytes, "task");
    // A damaged file is not fresh.
    fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let again = row(&folder, build, 0);
    assert_eq!(again["status"], "baked");
    assert!(again["reason"].as_str().unwrap().contains("bytes"), "{again}");
    // Instead of the file, the next build writes a pack, and the file is an orphan.
    let rows = run(&folder, "build in --out o --prune --json").expect(0).json();
    let statuses: Vec<&Value> = rows.iter().map(|row| &row["status"]).collect();
    assert_eq!(statuses, ["baked", "pruned"], "{rows:?}");
    assert!(!path.exists() && folder.path().join("o/level.hullmap").exists());
    // A pack at the path of the file is not fresh.
    fs::copy(folder.path().join("o/level.hullmap"), &path).unwrap();
    assert!(row(&folder, build, 0)["reason"].as_str().unwrap().starts_with("not a hullmap triangle mesh"));
}

#[test]
fn a_rule_chooses_the_levels_of_a_folder() {
    let folder = folder();
    fs::copy(folder.path().join("in/level.obj"), folder.path().join("in/rock.obj")).unwrap();
    let config = "[defaults]\nmax_vertices = 32\nlean = true\n[[rule]]\nfiles = \"level*\"\nkeep_triangles = true\n";
    fs::write(folder.path().join("in/hullmap.toml"), config).unwrap();
    let rows = run(&folder, "build in --out o --json").expect(0).json();
    assert_eq!(rows[0]["options"], OPTIONS);
    assert_eq!(rows[1]["output"], "o/rock.hullmap");
    let text = run(&folder, "build in --out o --force").expect(0).stdout;
    assert!(text.contains("1 hull and 72 triangles in "), "{text}");
    let both = run(&folder, "verify o").expect(0).stdout;
    assert!(both.contains("1 exact") || both.contains("1 simplified"), "{both}");
    assert!(both.contains("triangle mesh: 1 exact, 0 failed"), "{both}");
}

#[test]
fn options_of_hulls_are_errors() {
    let folder = folder();
    for (flag, expected) in [
        ("--decompose", "--decompose has no effect with --keep-triangles"),
        ("--recentre", "--recentre has no effect with --keep-triangles"),
        ("--split object", "--split has no effect with --keep-triangles"),
        ("--index tree", "--index has no effect with --keep-triangles"),
    ] {
        let run = run(&folder, &format!("build in --out o --keep-triangles {flag}")).expect(2);
        assert!(run.stderr.contains(expected), "{run:?}");
    }
    fs::write(folder.path().join("cloud.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    let run = run(&folder, "build cloud.obj --out o --keep-triangles").expect(1);
    assert!(run.stderr.contains("cloud.obj: has no faces, and --keep-triangles requires some"), "{run:?}");
}

#[test]
fn flaws_are_counted_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    // Two squares and their T-junction, a repeated triangle, one without area, one on the wrong
    // side, and three at one edge.
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 1 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\nv 9 0 0\nv 9 1 0\nv 8 0 0\n\
                v 10 0 0\nv 9 0 1\nv 20 0 0\nv 21 0 0\nv 20 1 0\nv 20 -1 0\n\
                f 1 2 3 4\nf 4 5 7 6\nf 5 3 8 7\nf 1 2 3\nf 1 1 2\nf 9 10 11\nf 10 9 12\nf 9 10 13\nf 14 15 16\nf 14 15 17\n";
    fs::write(folder.path().join("a.obj"), text).unwrap();
    let row = row(&folder, "build a.obj --out o --keep-triangles --json", 0);
    let mesh = &row["triangle_mesh"];
    let counts = ["degenerate", "duplicate", "t_junctions"].map(|key| mesh[key].as_u64().unwrap());
    assert_eq!(counts, [1, 1, 1], "{mesh}");
    assert_eq!((&mesh["edges"]["non_manifold"], &mesh["edges"]["reversed"]), (&3.into(), &2.into()), "{mesh}");
    let text =
        |key: &str| row[key].as_array().unwrap().iter().map(|t| t.as_str().unwrap()).collect::<Vec<_>>().join("|");
    for (key, words) in
        [("notes", ["(degenerate)", "(duplicate)", ""]), ("warnings", ["not manifold", "reversed", "T-junctions"])]
    {
        assert!(words.iter().all(|word| text(key).contains(word)), "{}", text(key));
    }
    let described = run(&folder, "inspect o").expect(0).stdout;
    let flaws = "1 degenerate triangle, 1 duplicate triangle, 3 non-manifold edges of triangles, \
                 2 reversed edges of triangles, 1 T-junction";
    assert!(described.contains(flaws), "{described}");
    run(&folder, "verify o").expect(0);
}

/// Writes the triangles of the level to a file that claims to be of `in/level.obj`, after a change.
fn forged(folder: &TempDir, change: impl Fn(&mut Vec<[f32; 3]>, &mut Vec<[u32; 3]>, &mut Vec<u16>)) {
    let path = folder.path().join("o/level.hullmesh");
    let mesh = TriangleMesh::open(&path).unwrap();
    let mut positions: Vec<[f32; 3]> = (0..mesh.vertex_count()).map(|v| mesh.vertex(v).unwrap().to_array()).collect();
    let mut order: Vec<usize> = (0..mesh.triangle_count()).collect();
    order.sort_by_key(|triangle| mesh.source_triangle(*triangle));
    let mut corners: Vec<[u32; 3]> = order.iter().map(|t| mesh.corners(*t).unwrap()).collect();
    let mut materials: Vec<u16> = order.iter().map(|t| mesh.material(*t).unwrap()).collect();
    change(&mut positions, &mut corners, &mut materials);
    let source = SourceRecord {
        path: mesh.source_path().to_owned(),
        hash: mesh.header().source_hash,
        options: mesh.options().to_owned(),
        warnings: Vec::new(),
    };
    let triangles = Triangles { positions: &positions, corners: &corners, materials: &materials };
    let baked = bake_triangle_mesh(&triangles).unwrap();
    fs::write(path, write_triangle_mesh(baked, &source).unwrap()).unwrap();
}

/// Bytes of a section of a file, by its place in the payload.
fn place<T>(payload: &[u8], section: &[T]) -> usize {
    section.as_ptr().addr() - payload.as_ptr().addr()
}

/// Changes bytes of the payload, and gives the file a checksum that fits.
fn patched(path: &Path, change: impl Fn(&Sections, &mut Vec<(usize, u8)>, &[u8])) {
    let file = fs::read(path).unwrap();
    let header = Header::read_kind(&file, FileKind::TriangleMesh).unwrap();
    let length = file.len() - HEADER_LEN;
    // Aligned as the sections require.
    let mut room = vec![0_u8; length + HEADER_LEN];
    let start = room.as_ptr().align_offset(HEADER_LEN);
    room[start..start + length].copy_from_slice(&file[HEADER_LEN..]);
    let mut changes = Vec::new();
    let aligned = &room[start..start + length];
    change(&Sections::read(aligned).unwrap(), &mut changes, aligned);
    let mut payload = aligned.to_vec();
    for (place, byte) in changes {
        payload[place] = byte;
    }
    let header = Header::for_triangle_mesh(header.source_hash, header.options_hash, &payload);
    fs::write(path, [&header.to_bytes()[..], &payload].concat()).unwrap();
}

/// Wrong contents in every section that a mesh has, in files that open.
#[test]
fn verify_finds_what_is_wrong_in_each_section() {
    let folder = folder();
    let path = folder.path().join("o/level.hullmesh");
    let fresh = || drop(run(&folder, "build in --out o --keep-triangles --force").expect(0));
    let fails = |name: &str, expected: &str| {
        let run = run(&folder, "verify o --directions 200 --json").expect(1);
        let row = run.json().remove(0);
        let problems = row["problems"].to_string();
        assert!(problems.contains(expected), "{name}: {problems}");
        assert!(row["mismatches"].as_u64().unwrap() > 0, "{row}");
    };
    fresh();
    run(&folder, "verify o --require-source").expect(0);
    for (name, change, expected) in [
        (
            "vertices",
            (|p, _, _| p[20][1] += 0.25) as fn(&mut Vec<[f32; 3]>, &mut Vec<[u32; 3]>, &mut Vec<u16>),
            "differs",
        ),
        ("triangles", |_, c, _| c[7].swap(0, 1), "differs"),
        (
            "missing",
            |_, c, m| {
                c.truncate(70);
                m.truncate(70);
            },
            "number of triangles",
        ),
        ("source_triangles", |_, c, _| c.swap(3, 40), "differs"),
        ("materials", |_, _, m| m[70] = 9, "material of triangle"),
    ] {
        fresh();
        forged(&folder, change);
        fails(name, expected);
    }
    fresh();
    patched(&path, |sections, changes, payload| {
        // An inner edge becomes a border, on both sides.
        let (triangle, edge, beyond) = (0..72)
            .flat_map(|triangle| (0..3).map(move |edge| (triangle, edge)))
            .find_map(|(triangle, edge)| {
                let beyond = sections.neighbours[triangle][edge].to_native();
                (beyond != u32::MAX).then_some((triangle, edge, beyond as usize))
            })
            .unwrap();
        let back = (0..3).find(|back| sections.neighbours[beyond][*back].to_native() as usize == triangle).unwrap();
        for (triangle, edge) in [(triangle, edge), (beyond, back)] {
            let at = place(payload, sections.neighbours) + 12 * triangle + 4 * edge;
            changes.extend((at..at + 4).map(|at| (at, u8::MAX)));
            let classes = sections.edge_classes[triangle].to_native() & !(15 << (4 * edge));
            let at = place(payload, sections.edge_classes) + 2 * triangle;
            changes.extend(classes.to_le_bytes().iter().zip(at..).map(|(byte, at)| (at, *byte)));
        }
    });
    fails("neighbours", "neighbour of triangle");
    fresh();
    patched(&path, |sections, changes, payload| {
        let class = sections.vertex_classes[5];
        changes.push((place(payload, sections.vertex_classes) + 5, if class == 0 { 1 } else { 0 }));
    });
    fails("vertex_classes", "class of vertex 5");
    fresh();
    patched(&path, |sections, changes, payload| {
        // After the bounds.
        changes.push((place(payload, sections.records) + 24, 7));
    });
    fails("records", "number of degenerate triangles");
    // Boxes are checked when the file is opened.
    fresh();
    patched(&path, |sections, changes, payload| changes.push((place(payload, sections.boxes), 3)));
    let row = run(&folder, "verify o --json").expect(1).json().remove(0);
    assert!(row["problems"].to_string().contains("box"), "{row}");
}

#[test]
fn a_stale_source_fails_and_none_is_a_comparison_with_itself() {
    let folder = folder();
    run(&folder, "build in --out o --keep-triangles").expect(0);
    fs::write(folder.path().join("in/level.obj"), level(5)).unwrap();
    let run_ = run(&folder, "verify o").expect(1);
    assert!(run_.stderr.contains("stale"), "{run_:?}");
    fs::remove_file(folder.path().join("in/level.obj")).unwrap();
    let run_ = run(&folder, "verify o").expect(0);
    assert!(run_.stderr.contains("compared with the stored triangles only"), "{run_:?}");
    run(&folder, "verify o --require-source").expect(1);
}

#[test]
fn exported_triangles_bake_to_the_same_mesh() {
    let folder = folder();
    run(&folder, "build in --out o --keep-triangles").expect(0);
    let open = |path: &str| TriangleMesh::open(folder.path().join(path)).unwrap();
    let mesh = open("o/level.hullmesh");
    for format in ["obj", "stl", "glb"] {
        let line = format!("export o/level.hullmesh --out e/level.{format}");
        let summary = run(&folder, &line).expect(0).stdout;
        assert!(summary.contains("49 vertices, 72 triangles"), "{summary}");
        run(&folder, &format!("build e/level.{format} --out e --keep-triangles --force")).expect(0);
        let again = open("e/level.hullmesh");
        let triangles = |mesh: &TriangleMesh| -> Vec<_> {
            let mut all: Vec<_> = (0..mesh.triangle_count())
                .map(|t| (mesh.source_triangle(t), mesh.triangle(t).unwrap().corners(), mesh.material(t)))
                .collect();
            all.sort_by_key(|(source, ..)| *source);
            all
        };
        for ((source, corners, material), expected) in triangles(&again).into_iter().zip(triangles(&mesh)) {
            assert_eq!((source, corners), (expected.0, expected.1), "{format}");
            assert_eq!(material, if format == "obj" { expected.2 } else { Some(0) }, "{format}");
        }
    }
    for (line, expected) in [
        ("export o/level.hullmesh --for unreal --out x.glb", "leave out --for"),
        ("export o/level.hullmesh --hull 0 --out x.obj", "leave out --hull"),
        ("export o/level.hullmesh --format json", "bake inspect --json --vertices"),
        (
            "export o/level.hullmesh --for usd --prim /World/level --out x.usda",
            "bake its source without --keep-triangles",
        ),
        ("query o/level.hullmesh#3 o/level.hullmesh", "leave out `#3`"),
    ] {
        let run = run(&folder, line);
        assert!(run.code != 0 && run.stderr.contains("is a triangle mesh"), "{line}: {run:?}");
        assert!(run.stderr.contains(expected), "{line}: {run:?}");
    }
}

#[test]
fn a_body_is_queried_against_a_level() {
    let folder = folder();
    run(&folder, "build in --out o --keep-triangles").expect(0);
    let corner = |i: usize| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
    fs::write(folder.path().join("box.obj"), (0..8).map(corner).collect::<String>()).unwrap();
    run(&folder, "build box.obj --out o").expect(0);
    // The level is y-up, between 0 and 1.
    let poses = ["--pose", "2 -0.5 2 0 0 0 1", "--pose", "2 3 2 0 0 0 1", "--json"];
    let words = ["query", "o/level.hullmesh", "o/box.hullmap"];
    let answers = bake_in(folder.path(), words.iter().chain(&poses)).expect(0).json();
    assert_eq!((&answers[0]["hit"], &answers[1]["hit"]), (&true.into(), &false.into()), "{answers:?}");
    let triangle: usize = answers[0]["hull_a"].as_str().unwrap().parse().unwrap();
    assert!(triangle < 72);
    let swapped = ["query", "o/box.hullmap", "o/level.hullmesh", "--mode", "distance", "--json"];
    bake_in(folder.path(), swapped).expect(0);
    run(&folder, "query o/level.hullmesh o/level.hullmesh --mode intersect").expect(0);
}

#[test]
fn the_report_draws_the_edges_by_class() {
    let folder = folder();
    run(&folder, "build in --out o --keep-triangles").expect(0);
    run(&folder, "report o/level.hullmesh --out page.html --directions 200").expect(0);
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    for text in ["data-report=\"mesh\"", "\"name\":\"convex\"", "--edge-non-manifold", "T-junctions", ">exact<"] {
        assert!(page.contains(text), "{text}");
    }
    fs::write(folder.path().join("in/rock.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n").unwrap();
    run(&folder, "build in/rock.obj --out o").expect(0);
    run(&folder, "report o --out all.html --directions 200").expect(0);
    let page = fs::read_to_string(folder.path().join("all.html")).unwrap();
    assert!(page.contains("data-name=\"level.hullmesh\"") && page.contains("data-name=\"rock\""));
    assert!(page.contains("1 hulls · 72 triangles") && page.contains("72 triangles · 49 vertices"));
    assert!(folder.path().join("all.pages/level.hullmesh.html").exists());
}
