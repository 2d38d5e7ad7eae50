//! `bake export`: exported hulls bake to the same hull, engines find the names that they expect,
//! and untrusted names do no harm.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use hullmap::{Hull, Pack};
use hullmap_bake::{IndexKind, PointSet, SourceRecord};
use hullmap_testkit::command::{Run, bake_in, bake_line as bake};
use hullmap_testkit::files::workspace;
use hullmap_testkit::packs::{self, point_set};
use shapes::families::Family;
use tempfile::TempDir;

/// An L: two boxes, which a decomposition separates.
const ELL: &str = "o ell
v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0
v 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1
f 6 5 4 3 2 1\nf 7 8 9 10 11 12
f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12
";

fn open(folder: &TempDir, path: &str) -> Pack {
    Pack::open(folder.path().join(path)).unwrap()
}

fn write_pack(folder: &TempDir, path: &str, sets: &[PointSet]) {
    let bytes = packs::bytes(sets, IndexKind::None, &SourceRecord::default()).unwrap();
    fs::write(folder.path().join(path), bytes).unwrap();
}

fn tetrahedron(name: &str) -> PointSet {
    point_set(name, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Bits of the vertices, in their order.
fn bits(hull: &Hull) -> Vec<[u32; 3]> {
    hull.vertices().map(|vertex| vertex.to_array().map(f32::to_bits)).collect()
}

/// Faces as sets of positions, whatever the order of vertices. Both zeros count as one.
fn faces(hull: &Hull) -> BTreeSet<BTreeSet<[u32; 3]>> {
    let position = |index| hull.vertex(index).unwrap().to_array().map(|c: f32| (c + 0.0).to_bits());
    hull.faces().map(|face| face.map(position).collect()).collect()
}

#[track_caller]
fn assert_same(before: &Pack, after: &Pack, keeps_order: bool, what: &str) {
    assert_eq!(before.hull_count(), after.hull_count(), "{what}");
    for (a, b) in before.hulls().zip(after.hulls()) {
        let what = format!("{what}, hull {}", a.name());
        assert_eq!(
            (a.rank(), a.vertex_count(), a.face_count()),
            (b.rank(), b.vertex_count(), b.face_count()),
            "{what}"
        );
        if keeps_order {
            assert_eq!(bits(&a), bits(&b), "{what}");
        }
        assert_eq!(faces(&a), faces(&b), "{what}");
        assert!((a.volume() - b.volume()).abs() <= 1e-12 * a.volume(), "{what}");
    }
}

/// Files in a folder, sorted.
fn listed(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_asset_bakes_to_the_same_hull_again() {
    let folder = tempfile::tempdir().unwrap();
    let assets = workspace().join("assets");
    let line = ["build", assets.to_str().unwrap(), "--out", "packs", "--split", "object", "--quiet"];
    bake_in(folder.path(), line).expect(0);
    // A simplified hull, and coordinates that are hard to write.
    let rock = assets.join("rock.obj");
    let line = ["build", rock.to_str().unwrap(), "--out", "packs/simple", "--max-vertices", "40", "--quiet"];
    bake_in(folder.path(), line).expect(0);
    fs::rename(folder.path().join("packs/simple/rock.hullmap"), folder.path().join("packs/simple.hullmap")).unwrap();
    fs::remove_dir(folder.path().join("packs/simple")).unwrap();
    let hard: Vec<[f32; 3]> = Family::Rock.points(60, 3).iter().map(|p| p.map(|c| c * 7.038_531e-26)).collect();
    let corner = [7.038_531e-26, 3.0e-25, f32::from_bits(0x15ae_43fd)];
    write_pack(&folder, "packs/hard.hullmap", &[point_set("hard", &[&hard[..], &[corner]].concat())]);
    let packs = listed(&folder.path().join("packs"));
    assert!(packs.len() >= 18, "{packs:?}");
    let (mut solids, mut all) = (0, 0);
    for pack in &packs {
        let stem = pack.trim_end_matches(".hullmap");
        let before = open(&folder, &format!("packs/{pack}"));
        all += 1;
        for format in ["obj", "glb", "stl"] {
            let is_flat = before.hulls().any(|hull| hull.rank() < 2);
            let code = if format == "stl" && is_flat { 1 } else { 0 };
            if format == "stl" && before.hull_count() > 1 {
                continue;
            }
            let run = bake(&folder, &format!("export packs/{pack} --out out/{stem}.{format}")).expect(code);
            if code == 1 {
                assert!(run.stderr.contains("STL takes triangles only"), "{run:?}");
                continue;
            }
            let line = format!("build out/{stem}.{format} --out again/{format} --split object --verify --quiet");
            bake(&folder, &line).expect(0);
            let after = open(&folder, &format!("again/{format}/{stem}.hullmap"));
            assert_same(&before, &after, format != "stl", &format!("{pack} by {format}"));
            solids += usize::from(before.hulls().all(|hull| hull.rank() == 3));
        }
    }
    assert!(solids > 40 && all >= 18, "{solids} of {all}");
}

#[test]
fn parts_bake_to_the_same_hulls_under_every_name() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ell.obj"), ELL).unwrap();
    bake(&folder, "build ell.obj --out . --decompose --quiet").expect(0);
    let before = open(&folder, "ell.hullmap");
    let count = before.hull_count();
    assert!(count >= 2, "{count}");
    for (line, file, first) in [
        ("--format obj", "ell.obj", "ell_part_00"),
        ("--format glb", "ell.glb", "ell_part_00"),
        ("--for unreal", "ell.glb", "UCX_ell_00"),
        ("--for unreal --format obj --name SM_Ell", "ell.obj", "UCX_SM_Ell_00"),
        ("--for godot", "ell.glb", "ell_part_00"),
        ("--for godot --visible --name Ell", "ell.glb", "Ell_00"),
        ("--for khr-physics", "ell.glb", "ell_part_00"),
        ("--for khr-physics --set draft=2026-06", "ell.glb", "ell_part_00"),
        ("--for both", "ell.glb", "ell_part_00"),
    ] {
        bake(&folder, &format!("export ell.hullmap {line} --out out/{file} --force")).expect(0);
        let split = if line.contains("--for ") { "auto" } else { "object" };
        bake(&folder, &format!("build out/{file} --out again --split {split} --quiet")).expect(0);
        let after = open(&folder, "again/ell.hullmap");
        assert_same(&before, &after, true, line);
        assert_eq!(after.hull(0).unwrap().name(), first, "{line}");
    }
    for (line, document) in
        [("--for mjcf", Some("ell.xml")), ("--for urdf --format stl", Some("ell.urdf")), ("--parts --format glb", None)]
    {
        let run = bake(&folder, &format!("export ell.hullmap {line} --out parts --force")).expect(0);
        let names = listed(&folder.path().join("parts"));
        assert_eq!(names.len(), count + usize::from(document.is_some()), "{names:?}");
        assert_eq!(run.stdout.lines().count(), names.len());
        let text = document.map(|name| fs::read_to_string(folder.path().join("parts").join(name)).unwrap());
        for (hull, name) in before.hulls().zip(names.iter().filter(|name| Some(name.as_str()) != document)) {
            assert!(name.starts_with(hull.name()), "{name}");
            assert!(text.as_ref().is_none_or(|text| text.contains(&format!("\"{name}\""))), "{name}: {text:?}");
            bake(&folder, &format!("build parts/{name} --out again --quiet")).expect(0);
            let after = open(&folder, &format!("again/{}.hullmap", hull.name()));
            assert_eq!(faces(&hull), faces(&after.hull(0).unwrap()), "{line}: {name}");
        }
        fs::remove_dir_all(folder.path().join("parts")).unwrap();
    }
}

/// The numbers of an attribute in a document.
fn numbers(text: &str, attribute: &str) -> Vec<f64> {
    let (_, rest) = text.split_once(&format!(" {attribute}=\"")).unwrap_or_else(|| panic!("no {attribute}: {text}"));
    let (value, _) = rest.split_once('"').unwrap();
    value.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64]) {
    let near = |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-6 * expected.abs().max(1.0);
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}, not {expected:?}");
}

/// An L has 5 of the 7 that its hull has. Closed forms: two boxes, of 3 and of 2, about their
/// common centre.
#[test]
fn robots_weigh_as_much_as_their_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let open_ell = ELL.rsplit_once("f 6 1").unwrap().0;
    fs::write(folder.path().join("ell.obj"), ELL).unwrap();
    fs::write(folder.path().join("open.obj"), open_ell).unwrap();
    let center = [1.1, 1.1, 0.5];
    let xx = 3.0 / 12.0 + 3.0 * 0.36 + 2.0 * 4.0 / 12.0 + 2.0 * 0.81;
    let xy = 3.0 * 0.4 * -0.6 + 2.0 * -0.6 * 0.9;
    let (across, up) = (xx + 5.0 / 12.0, 2.0 * xx);
    for options in
        ["", "--decompose --max-parts 1", "--decompose --max-error 1%", "--max-vertices 6 --decompose --max-parts 2"]
    {
        bake(&folder, &format!("build ell.obj {options} --out . --quiet")).expect(0);
        let pack = open(&folder, "ell.hullmap");
        let hulls: f64 = pack.hulls().map(|hull| hull.volume()).sum();
        assert!(options.contains("1%") || hulls > 5.2, "{options}: the hulls have {hulls}");
        for up_axis in ["keep", "y-to-z"] {
            let run = bake(&folder, &format!("export ell.hullmap --for mjcf --up-axis {up_axis} --out m --force"));
            assert!(!run.expect(0).stderr.contains("the mass is"), "{options}");
            let text = fs::read_to_string(folder.path().join("m/ell.xml")).unwrap();
            assert_near(&numbers(&text, "mass"), &[5000.0]);
            let [x, y, z] = center;
            let (pos, inertia) = match up_axis {
                "keep" => ([x, y, z], [across, across, up, -xy, 0.0, 0.0]),
                _ => ([x, -z, y], [across, up, across, 0.0, -xy, 0.0]),
            };
            assert_near(&numbers(&text, "pos"), &pos);
            assert_near(&numbers(&text, "fullinertia"), &inertia.map(|entry| 1000.0 * entry));
        }
    }
    bake(&folder, "export ell.hullmap --for sdf --density 2700 --out s").expect(0);
    let text = fs::read_to_string(folder.path().join("s/ell.sdf")).unwrap();
    let element = |name: &str| -> f64 {
        let rest = text.split_once(&format!("<{name}>")).unwrap_or_else(|| panic!("no {name}: {text}")).1;
        rest.split('<').next().unwrap().parse().unwrap()
    };
    assert_near(&["mass", "ixx", "ixy", "izz"].map(element), &[13_500.0, 2700.0 * across, 2700.0 * -xy, 2700.0 * up]);
    let file = text.split_once("<mesh><uri>").unwrap().1.split_once("</uri></mesh>").unwrap().0;
    assert!(folder.path().join("s").join(file).is_file(), "{text}");
    // Without its last face, the mesh bounds no solid.
    bake(&folder, "build open.obj --out . --quiet").expect(0);
    let run = bake(&folder, "export open.hullmap --for mjcf --out o").expect(0);
    assert!(run.stderr.contains("the mass comes from the hull, because the pack does not record"), "{}", run.stderr);
    let text = fs::read_to_string(folder.path().join("o/open.xml")).unwrap();
    assert_near(&numbers(&text, "mass"), &[7000.0]);
}

/// A second opinion on GLB: the crate `gltf` validates the file.
#[test]
fn glb_files_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    let flat = point_set("flat", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let segment = point_set("segment", &[[0.0; 3], [1.0, 2.0, 3.0]]);
    let point = point_set("point", &[[1.0, 2.0, 3.0]]);
    write_pack(&folder, "x.hullmap", &[tetrahedron("a \"name\"\n"), flat, segment, point]);
    bake(&folder, "export x.hullmap --out x.glb").expect(0);
    let file = gltf::Gltf::open(folder.path().join("x.glb")).unwrap();
    let buffer = file.blob.as_deref().unwrap();
    let meshes: Vec<_> = file.meshes().map(|mesh| mesh.primitives().next().unwrap()).collect();
    let modes: Vec<gltf::mesh::Mode> = meshes.iter().map(gltf::Primitive::mode).collect();
    use gltf::mesh::Mode::{Lines, Points, Triangles};
    assert_eq!(modes, [Triangles, Triangles, Lines, Points]);
    let pack = open(&folder, "x.hullmap");
    let names: Vec<&str> = file.nodes().filter_map(|node| node.name()).collect();
    assert!(names.iter().copied().eq(pack.hulls().map(|hull| hull.name())), "{names:?}");
    for (hull, primitive) in pack.hulls().zip(&meshes) {
        let reader = primitive.reader(|_| Some(buffer));
        let read: Vec<[u32; 3]> = reader.read_positions().unwrap().map(|p| p.map(f32::to_bits)).collect();
        assert_eq!(read, bits(&hull));
        let bounds = primitive.bounding_box();
        assert_eq!([bounds.min, bounds.max], hull.bounds().map(|corner| corner.to_array()));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert!(indices.iter().all(|index| (*index as usize) < hull.vertex_count()));
        let expected = match hull.rank() {
            3 => 12,
            2 => 6,
            rank => rank as usize + 1,
        };
        assert_eq!(indices.len(), expected, "{}", hull.name());
    }
}

#[test]
fn json_has_the_vertices_and_faces_of_the_pack() {
    let folder = tempfile::tempdir().unwrap();
    write_pack(&folder, "x.hullmap", &[tetrahedron("a"), point_set("rock", &Family::Rock.points(40, 2))]);
    let pack = open(&folder, "x.hullmap");
    let exported = bake(&folder, "export x.hullmap --format json").expect(0).json().remove(0);
    let inspected = bake(&folder, "inspect x.hullmap --json --vertices").expect(0).json().remove(0);
    for found in [exported, inspected] {
        for (index, hull) in pack.hulls().enumerate() {
            let found = &found["hulls"][index];
            let positions: Vec<[f32; 3]> = serde_json::from_value(found["positions"].clone()).unwrap();
            assert_eq!(positions.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>(), bits(&hull));
            let polygons: Vec<Vec<u32>> = serde_json::from_value(found["polygons"].clone()).unwrap();
            assert_eq!(polygons, hull.faces().map(Iterator::collect).collect::<Vec<Vec<u32>>>());
        }
    }
    let plain = bake(&folder, "inspect x.hullmap --json").expect(0).json().remove(0);
    assert!(plain["hulls"][0]["positions"].is_null());
    bake(&folder, "inspect x.hullmap --vertices").expect(2);
}

/// The names in a pack are untrusted.
#[test]
fn untrusted_names_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let names = [
        "../../escape",
        "/absolute",
        "..",
        "",
        "a\nf 1 1 1\no b",
        "tail\\",
        "\"/><evil/>",
        "con",
        "\u{1b}[2J\u{202e}",
        "same",
        "SAME",
    ];
    write_pack(&folder, "x.hullmap", &names.map(tetrahedron));
    let inside = |run: &Run| assert!(!run.stdout.contains('\u{1b}') && !run.stderr.contains('\u{1b}'), "{run:?}");
    for line in ["--parts --format obj", "--parts --for unreal --format obj", "--for mjcf", "--for urdf"] {
        let run = bake(&folder, &format!("export x.hullmap {line} --out deep/out")).expect(0);
        inside(&run);
        let found = listed(&folder.path().join("deep/out"));
        let document = usize::from(!line.contains("--parts"));
        assert_eq!(found.len(), names.len() + document, "{line}: {found:?}");
        let folded: BTreeSet<String> = found.iter().map(|name| name.to_lowercase()).collect();
        assert_eq!(folded.len(), found.len(), "{found:?}");
        for name in &found {
            assert!(!name.starts_with(['.', '-']) && !name.contains(['"', '<', '\\', '\n', '\u{1b}']), "{name:?}");
            let text = fs::read_to_string(folder.path().join("deep/out").join(name)).unwrap();
            assert!(name.ends_with(".obj") || !text.contains("<evil"), "{name}: {text}");
        }
        assert_eq!(listed(&folder.path().join("deep")), ["out"]);
        assert_eq!(listed(folder.path()), ["deep", "x.hullmap"]);
        fs::remove_dir_all(folder.path().join("deep")).unwrap();
    }
    // In one file, every hull is one object, whatever its name.
    for line in
        ["--format obj --out x.obj", "--format glb --out x.glb", "--for unreal --out u.obj", "--for godot --out g.glb"]
    {
        inside(&bake(&folder, &format!("export x.hullmap {line}")).expect(0));
        let file = PathBuf::from(line.rsplit(' ').next().unwrap());
        let split = if line.contains("godot") { "auto" } else { "object" };
        bake(&folder, &format!("build {} --out again --split {split} --quiet", file.display())).expect(0);
        let again = open(&folder, &format!("again/{}.hullmap", file.file_stem().unwrap().display()));
        assert_eq!(again.hull_count(), names.len(), "{line}");
        assert!(again.hulls().all(|hull| hull.vertex_count() == 4), "{line}");
    }
}
