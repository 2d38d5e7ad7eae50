//! Triangle meshes and height fields, from the command to files, and back; and folders that mix
//! props, triangle meshes and height fields.

use std::fs;
use std::path::Path;

use hullmap::glam::DVec3;
use hullmap::{Asset, HeightField, TriangleMesh};
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

/// A grid of 4 × 3 samples with a hole. The first row of the file has the greatest y.
const GRID: &str =
    "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n8 9 10 11\n4 5 6 -1\n0 1 2 3\n";

const TET: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
    folder
}

/// A folder with a level `in/level.obj`.
fn folder() -> TempDir {
    folder_with(&[("in/level.obj", &level(6))])
}

fn folder_with_grid() -> TempDir {
    folder_with(&[("in/dem.asc", GRID)])
}

const RULES: &str = "[defaults]\nmax_vertices = 32\nlean = true\n[terrain]\nheight_offset = 0.5\n\
                     [[rule]]\nfiles = \"level*\"\nkeep_triangles = true\n\
                     [[rule]]\nfiles = \"dem*\"\nterrain = true\n";

/// A prop, a level and a terrain in one folder, with an image that is no terrain.
fn mixed() -> TempDir {
    let level = level(6);
    let files = [("in/dem.asc", GRID), ("in/level.obj", &level), ("in/rock.obj", TET), ("in/rock.png", "texture")];
    folder_with(&[&files[..], &[("in/hullmap.toml", RULES)]].concat())
}

/// The files of [`mixed`] in `o`, and their sources.
const MIXED: [(&str, &str); 3] =
    [("o/dem.hullfield", "in/dem.asc"), ("o/level.hullmesh", "in/level.obj"), ("o/rock.hullmap", "in/rock.obj")];

/// Asserts that the line ends with this code, and prints this text.
#[track_caller]
fn prints(folder: &TempDir, line: &str, code: i32, text: &str) {
    let run = run(folder, line).expect(code);
    let all = format!("{}{}", run.stdout, run.stderr);
    assert!(all.contains(text), "{line}: no `{text}` in {all}");
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
fn a_grid_is_baked_and_described() {
    let folder = folder_with_grid();
    let line = "terrain in/dem.asc --height-offset 0.5 --out o";
    let first = row(&folder, &format!("{line} --json"), 0);
    let facts = &first["height_field"];
    assert_eq!((&facts["columns"], &facts["rows"], &facts["holes"]), (&4.into(), &3.into(), &2.into()), "{first}");
    prints(&folder, &format!("{line} --height-scale 2 --check"), 1, "the options have changed from");
    let field = HeightField::open(folder.path().join("o/dem.hullfield")).unwrap();
    // The middle of the lower left cell of the grid is the first vertex.
    assert_eq!(field.vertex(0, 0), Some(DVec3::new(105.0, 205.0, 0.5)));
    assert_eq!(field.vertex(0, 2), Some(DVec3::new(105.0, 225.0, 8.5)));
    assert!(field.is_hole(2, 0) && field.is_hole(2, 1) && !field.is_hole(1, 1));
    let described = row(&folder, "inspect o --json --vertices", 0);
    let facts = &described["height_field"];
    assert_eq!((&facts["holes"], &facts["triangles"], &facts["diagonal"]), (&2.into(), &8.into(), &"rising".into()));
    assert_eq!((&facts["vertices"][0], &facts["edges"]["border"]), (&0.5.into(), &8.into()));
    prints(&folder, "inspect o", 0, "  holes              2 of 6 cells");
}

/// The same rules for hulls, triangles and heights: build, freshness, plans, caches, verification.
#[test]
fn a_folder_mixes_props_levels_and_terrains() {
    let folder = mixed();
    let statuses = |line: &str, code: i32| -> Vec<String> {
        let rows = run(&folder, &format!("{line} --json")).expect(code).json();
        rows.iter().map(|row| row["status"].as_str().unwrap().to_owned()).collect()
    };
    let contents = || MIXED.map(|(file, _)| fs::read(folder.path().join(file)).unwrap());
    assert_eq!(statuses("build in --out o --check", 1), ["missing"; 3]);
    let rows = run(&folder, "build in --out o --json").expect(0).json();
    let outputs: Vec<&str> = rows.iter().map(|row| row["output"].as_str().unwrap()).collect();
    assert_eq!(outputs, MIXED.map(|(file, _)| file), "the image is no terrain");
    assert_eq!((&rows[0]["height_field"]["holes"], &rows[1]["options"]), (&2.into(), &OPTIONS.into()));
    let bytes = contents();
    for line in ["build in --out o --verify", "build in --out o --check"] {
        assert_eq!(statuses(line, 0), ["fresh"; 3], "{line}");
    }
    prints(&folder, "status in --out o", 0, "3 present, 0 stale, 0 missing");
    prints(&folder, "build in --out o --force", 0, "1 hull and 80 triangles in ");
    // The same bytes for any number of threads, from shards, from a cache and from tasks of a plan.
    for line in ["build in --out o --force --jobs 1", "build in --out o --force --jobs 3"] {
        assert_eq!(statuses(line, 0), ["baked"; 3]);
        assert!(contents() == bytes, "{line}");
    }
    fs::write(folder.path().join("plan"), run(&folder, "plan in --out o").expect(0).stdout).unwrap();
    for lines in [
        &["build in --out o --shard 0/2", "build in --out o --shard 1/2"][..],
        &["build in --out other --cache c", "build in --out o --cache c"],
        &["task plan"],
    ] {
        fs::remove_dir_all(folder.path().join("o")).unwrap();
        lines.iter().for_each(|line| drop(run(&folder, line).expect(0)));
        assert!(contents() == bytes, "{lines:?}");
    }
    for (file, _) in MIXED {
        assert!(Asset::open(folder.path().join(file)).is_ok());
    }
    prints(&folder, "verify o --require-source --directions 100", 0, "surfaces: 2 exact, 0 failed");
    prints(&folder, "build in --out d --depfile deps", 0, "3 baked");
    let deps = fs::read_to_string(folder.path().join("deps")).unwrap();
    assert!(MIXED.iter().all(|(_, source)| deps.contains(source)), "{deps}");
    // Damaged files are not fresh.
    for ((file, _), bytes) in MIXED.iter().zip(&bytes) {
        fs::write(folder.path().join(file), &bytes[..bytes.len() - 1]).unwrap();
    }
    assert_eq!(statuses("build in --out o", 0), ["baked"; 3]);
    // By other rules the files are orphans.
    fs::write(folder.path().join("in/hullmap.toml"), "").unwrap();
    let found = statuses("build in --out o --prune", 0);
    assert_eq!(found, ["baked", "baked", "pruned"], "the source of the terrain is still there");
    assert!(folder.path().join("o/level.hullmap").exists() && !folder.path().join("o/level.hullmesh").exists());
    // A pack at the path of the level is not fresh.
    fs::write(folder.path().join("in/hullmap.toml"), RULES).unwrap();
    fs::copy(folder.path().join("o/level.hullmap"), folder.path().join("o/level.hullmesh")).unwrap();
    let again = run(&folder, "build in --out o --json").expect(0).json().remove(1);
    assert!(again["reason"].as_str().unwrap().starts_with("not a hullmap triangle mesh"), "{again}");
}

#[test]
fn a_stale_source_fails_and_none_is_a_comparison_with_itself() {
    let folder = mixed();
    run(&folder, "build in --out o").expect(0);
    for ((file, source), stored) in MIXED.iter().zip(["heights", "triangles", "hull"]) {
        let path = folder.path().join(source);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{text}\n")).unwrap();
        prints(&folder, &format!("verify {file}"), 1, "stale: ");
        fs::remove_file(&path).unwrap();
        prints(&folder, &format!("verify {file}"), 0, &format!("compared with the stored {stored} only"));
        prints(&folder, &format!("verify {file} --require-source"), 1, "name the source with --source");
        fs::create_dir_all(folder.path().join("elsewhere")).unwrap();
        fs::write(folder.path().join("elsewhere").join(source.trim_start_matches("in/")), &text).unwrap();
        run(&folder, &format!("verify {file} --require-source --source elsewhere")).expect(0);
        let mut damaged = fs::read(folder.path().join(file)).unwrap();
        damaged[200] ^= 1;
        fs::write(folder.path().join(file), damaged).unwrap();
        for command in ["verify", "inspect", "query o/rock.hullmap"] {
            if !(*file == "o/rock.hullmap" && command.starts_with("query")) {
                prints(&folder, &format!("{command} {file}"), 1, "the file is damaged");
            }
        }
    }
    prints(&folder, "inspect o/none.hullfield", 2, "cannot read");
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
fn errors_of_terrains_name_file_cause_and_remedy() {
    let folder = folder_with_grid();
    for name in ["in/raw.f32", "in/dem.f32"] {
        fs::write(folder.path().join(name), [0_u8; 24]).unwrap();
    }
    for (line, code, expected) in [
        ("in/raw.f32", 1, "in/raw.f32: expected a greyscale PNG, an ESRI ASCII grid"),
        ("in/raw.f32 --rows 2 --columns 3", 2, "name it with --spacing"),
        ("in/raw.f32 --rows 2 --columns 4 --spacing 1", 1, "take 32; check --rows and --columns"),
        ("in/raw.f32 --rows 2 --columns 3 --spacing 1 --origin 1e300,0", 1, "choose another spacing"),
        ("in/dem.asc --hole-image gone.png", 1, "image of holes gone.png cannot be read"),
        ("in/dem.asc --hole-image dem.asc", 1, "export the image as PNG"),
        ("in/dem.asc --hole-image ../x.png", 2, "without a folder"),
        ("in/dem.asc --spacing 0", 2, "expected one or two lengths above 0"),
        ("in/dem.asc --decompose", 2, "--decompose"),
        ("in/none.asc", 2, "in/none.asc: cannot read"),
    ] {
        prints(&folder, &format!("terrain {line} --out o"), code, expected);
    }
    prints(&folder, "build in/dem.asc --out o --spacing 1", 2, "--spacing");
    prints(&folder, "build in --out o", 2, "in: no meshes");
    // The text of the grid is not six numbers.
    let rows = run(&folder, "terrain in --out o --rows 2 --columns 3 --spacing 1 --json").expect(1).json();
    let outputs: Vec<&Value> = rows.iter().map(|row| &row["output"]).collect();
    assert_eq!(outputs, ["o/dem.asc.hullfield", "o/dem.f32.hullfield", "o/raw.hullfield"]);
}

/// The sample that is a hole, and the value as tools write it. Other values are a warning.
#[test]
fn holes_are_found_as_they_are_stored_or_a_warning_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (sample, hole, warns) in [
        (-9999.9, "-9999.9", false),
        (f32::MAX, "3.4028235e38", false),
        (-3.4e38, "-3.4e38", false),
        (f32::MIN, "-3.402823e+38", false),
        (0.1, "0.1", false),
        (1e30, "1e30", false),
        (-9999.9, "-9999", true),
        (0.25, "0", true),
    ] {
        let samples = (0..20).map(|at| if at == 6 { sample } else { 10.0 + at as f32 });
        let bytes: Vec<u8> = samples.flat_map(f32::to_le_bytes).collect();
        fs::write(folder.path().join("a.f32"), bytes).unwrap();
        let line = format!("terrain a.f32 --rows 4 --columns 5 --spacing 1 --hole={hole} --out o --json");
        for status in ["baked", "fresh"] {
            let found = run(&folder, &line).expect(0);
            let row = found.json().remove(0);
            let holes = if warns { 0 } else { 4 };
            assert_eq!((&row["status"], &row["height_field"]["holes"]), (&status.into(), &holes.into()), "{hole}");
            let text = "no sample is";
            assert_eq!(found.stderr.contains(text), warns, "{hole}: {}", found.stderr);
            assert_eq!(row["warnings"].to_string().contains(text), warns, "{hole}: {row}");
        }
        run(&folder, "verify o/a.hullfield --require-source --directions 50").expect(0);
    }
    let folder = folder_with_grid();
    prints(&folder, "terrain in/dem.asc --hole 77 --out o", 0, "in/dem.asc: no sample is 77, so --hole");
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

/// Other heights, a filled hole and a moved grid, in files that claim the same source.
#[test]
fn verify_finds_what_is_wrong_in_a_field() {
    let folder = folder_with_grid();
    let path = folder.path().join("o/dem.hullfield");
    run(&folder, "terrain in/dem.asc --out o").expect(0);
    let good = fs::read(&path).unwrap();
    for (from, to, expected) in [
        ("8 9 10 11", "8 9 12 11", "differs: heights"),
        ("4 5 6 -1", "4 5 6 7", "ground instead of a hole"),
        ("xllcorner 100", "xllcorner 101", "grid: Layout"),
    ] {
        fs::write(folder.path().join("in/dem.asc"), GRID.replace(from, to)).unwrap();
        run(&folder, "terrain in/dem.asc --out o").expect(0);
        let mut forged = fs::read(&path).unwrap();
        forged[24..40].copy_from_slice(&good[24..40]);
        let header = Header::read_kind(&forged, FileKind::HeightField).unwrap();
        let checksum = header.checksum_of(&forged[HEADER_LEN..]);
        forged[56..HEADER_LEN].copy_from_slice(&checksum.to_le_bytes());
        fs::write(&path, &forged).unwrap();
        fs::write(folder.path().join("in/dem.asc"), GRID).unwrap();
        prints(&folder, "verify o", 1, expected);
        prints(&folder, "report o --out page.html --directions 50", 1, expected);
    }
}

/// In all formats that keep a surface.
#[test]
fn exported_heights_bake_to_the_same_surface() {
    let folder = folder_with_grid();
    run(&folder, "terrain in/dem.asc --out o --diagonal falling").expect(0);
    let a = HeightField::open(folder.path().join("o/dem.hullfield")).unwrap();
    run(&folder, "export o/dem.hullfield --out o/dem.f32").expect(0);
    let again = "terrain o/dem.f32 --rows 3 --columns 4 --spacing 10 --origin 105,205 --diagonal falling --out p";
    run(&folder, again).expect(0);
    let b = HeightField::open(folder.path().join("p/dem.hullfield")).unwrap();
    assert_eq!((a.layout(), a.hole_count(), a.bounds()), (b.layout(), b.hole_count(), b.bounds()));
    assert!((0..a.triangle_count()).all(|triangle| a.triangle(triangle) == b.triangle(triangle)));
    for format in ["obj", "stl", "glb"] {
        prints(&folder, &format!("export o/dem.hullfield --out e/dem.{format}"), 0, "12 vertices, 8 triangles");
        run(&folder, &format!("build e/dem.{format} --out e --keep-triangles --force")).expect(0);
        let mesh = TriangleMesh::open(folder.path().join("e/dem.hullmesh")).unwrap();
        let corners = |triangle| mesh.triangle(triangle).unwrap().corners();
        let expected: Vec<_> = (0..a.triangle_count()).filter_map(|at| Some(a.triangle(at)?.corners())).collect();
        assert!(mesh.triangle_count() == 8 && (0..8).all(|at| expected.contains(&corners(at))), "{format}");
    }
    prints(&folder, "export o/dem.hullfield --out e/dem.obj", 2, "e/dem.obj");
    let text = fs::read_to_string(folder.path().join("e/dem.obj")).unwrap();
    assert!(text.starts_with("v 105 205 0\n") && text.contains("\nf 1 2 5\n"), "{text}");
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
            "bake its source without options of another kind",
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
fn reports_have_a_page_for_each_content() {
    let folder = mixed();
    run(&folder, "build in --out o").expect(0);
    run(&folder, "report o --out all.html --directions 200").expect(0);
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let page = text("all.html");
    assert!(
        ["level.hullmesh", "dem.hullfield", "rock"].iter().all(|own| page.contains(&format!("data-name=\"{own}\"")))
    );
    assert!(page.contains("1 hulls · 80 triangles") && page.contains("72 triangles · 49 vertices"));
    for (name, texts) in [
        ("level.hullmesh", ["data-report=\"mesh\"", "\"name\":\"convex\"", "--edge-non-manifold", "T-junctions"]),
        ("dem.hullfield", ["data:image/png;base64,", "2 of 6 cells", "105 205", "heights between its samples"]),
    ] {
        let page = text(&format!("all.pages/{name}.html"));
        assert!(page.contains(">exact<") && texts.iter().all(|text| page.contains(text)), "{name}: {page}");
    }
}
