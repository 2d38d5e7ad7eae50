//! `bake export --into`: colliders in glTF files that keep everything else, and come back as the
//! same hulls.

use std::collections::BTreeMap;
use std::fs;

use hullmap::Pack;
use hullmap_testkit::command::{Run, bake_line as bake};
use hullmap_testkit::files::{self, write};
use serde_json::Value;
use shapes::gltf::{self, Parts};
use shapes::mesh::Mesh;
use shapes::solids::{extrusion, regular_polygon};
use tempfile::TempDir;

/// An L, which a decomposition divides.
fn ell() -> Mesh {
    extrusion(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]], 0.0, 1.0)
}

/// Two meshes in nodes that turn, scale and mirror them; the last one is distorted.
fn model() -> Parts {
    let drum = extrusion(&regular_polygon(24, 0.7), -0.5, 0.25);
    let nodes = concat!(
        r#"{"name":"root","children":[1,3],"translation":[1,2,3]},"#,
        r#"{"name":"arm","mesh":0,"rotation":[0.5,0.5,0.5,0.5],"children":[2]},"#,
        r#"{ "name":"drum","mesh":1,"translation":[0,0,4],"scale":[-2,2,2],"extras":{"n":1.50,"big":1.0e+2} },"#,
        r#"{"name":"flat","mesh":1,"rotation":[0,0.6,0,0.8],"scale":[1,3,0.2]}"#
    );
    gltf::parts(&[("ell", &ell()), ("drum", &drum)], nodes, "0")
}

/// A folder with a file `m.glb`, and the pack `m.hullmap` of its objects.
fn baked(file: &[u8], options: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "m.glb", file);
    bake(&folder, &format!("build m.glb --split object --out . --quiet {options}")).expect(0);
    folder
}

/// Text and BIN chunk of a GLB file.
fn chunks(file: &[u8]) -> (String, Vec<u8>) {
    let length = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let text = &file[20..20 + length(12)];
    assert_eq!(length(8), file.len());
    (String::from_utf8(text.to_vec()).unwrap(), file[28 + text.len()..].to_vec())
}

fn has_insertions_only(old: &str, new: &str) -> bool {
    let mut rest = new.bytes();
    old.trim_end().bytes().all(|byte| rest.any(|other| other == byte))
}

fn hulls(folder: &TempDir, pack: &str) -> BTreeMap<String, Vec<[u32; 3]>> {
    let pack = Pack::open(folder.path().join(pack)).unwrap();
    let vertices = |hull: &hullmap::Hull| hull.vertices().map(|v| v.to_array().map(|x| (x + 0.0).to_bits())).collect();
    pack.hulls().map(|hull| (hull.name().to_owned(), vertices(&hull))).collect()
}

#[test]
fn everything_else_keeps_its_bytes_and_colliders_come_back() {
    let file = model().glb();
    let folder = baked(&file, "--decompose");
    let before = hulls(&folder, "m.hullmap");
    assert!(before.len() > 4 && before.contains_key("drum"), "{:?}", before.keys());
    let (old_text, old_bytes) = chunks(&file);
    for target in ["khr-physics", "omi", "both", "godot", "khr-physics --set draft=2026-06"] {
        bake(&folder, &format!("export m.hullmap --into m.glb --for {target} --out out.glb --force")).expect(0);
        let out = fs::read(folder.path().join("out.glb")).unwrap();
        let (text, bytes) = chunks(&out);
        assert!(bytes.starts_with(&old_bytes), "{target}: render data changed");
        // Only the length of the file's buffer has changed.
        let length = |text: &str| text.split("\"buffers\":[{\"byteLength\":").nth(1).unwrap()[..].to_owned();
        let digits = |text: &str| length(text).find('}').map(|end| length(text)[..end].to_owned()).unwrap();
        let adapted = old_text.replace(
            &format!("\"byteLength\":{}}}]", digits(&old_text)),
            &format!("\"byteLength\":{}}}]", digits(&text)),
        );
        assert!(has_insertions_only(&adapted, &text), "{target}: {text}");
        assert!(text.contains(r#"{"n":1.50,"big":1.0e+2}"#) && !text.contains("extensionsRequired"));
        bake(&folder, "build out.glb --split auto --out . --quiet").expect(0);
        let after = hulls(&folder, "out.hullmap");
        assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>(), "{target}");
        for (name, hull) in &before {
            if name.starts_with("flat") {
                // A distorted node rounds the positions.
                assert_eq!(hull.len(), after[name].len());
                for (a, b) in hull.iter().flatten().zip(after[name].iter().flatten()) {
                    let (a, b) = (f32::from_bits(*a), f32::from_bits(*b));
                    assert!((a - b).abs() <= 1e-6, "{name}: {a} {b}");
                }
            } else {
                assert_eq!(hull, &after[name], "{target}: {name}");
            }
        }
        // A file with colliders gets no more of them.
        let run = bake(&folder, &format!("export m.hullmap --into out.glb --out more.glb --for {target}")).expect(1);
        assert!(run.stderr.contains("already has") && !folder.path().join("more.glb").exists(), "{run:?}");
    }
    // An independent reader accepts it.
    gltf_crate(&folder, "out.glb");
}

/// Unreal finds collision parts by their names, and only in the file of their mesh.
#[test]
fn unreal_gets_hulls_beside_their_meshes() {
    let file = model().glb();
    let folder = baked(&file, "--decompose");
    bake(&folder, "export m.hullmap --into m.glb --for unreal --out out.glb").expect(0);
    let (text, bytes) = chunks(&fs::read(folder.path().join("out.glb")).unwrap());
    assert!(bytes.starts_with(&chunks(&file).1) && !text.contains("KHR_") && !text.contains("\"extensions"));
    // Nodes are named after the node, meshes after its mesh.
    for name in ["UCX_arm_00", "UCX_ell_00", "UCX_drum_00"] {
        assert!(text.contains(&format!("\"name\":\"{name}\"")), "{text}");
    }
    bake(&folder, "build out.glb --split auto --out . --quiet").expect(0);
    // Two nodes have the mesh of the drum, which is one static mesh in Unreal.
    let mut before = hulls(&folder, "m.hullmap");
    assert!(before.remove("flat").is_some());
    assert_same_parts(&before, &hulls(&folder, "out.hullmap"));
    gltf_crate(&folder, "out.glb");
    let run = bake(&folder, "export m.hullmap --into out.glb --for unreal --out more.glb").expect(1);
    assert!(run.stderr.contains("out.glb: already has the collision part UCX_"), "{}", run.stderr);
}

/// Whether the parts of objects came back as collision parts for Unreal, to within rounding.
#[track_caller]
fn assert_same_parts(before: &BTreeMap<String, Vec<[u32; 3]>>, after: &BTreeMap<String, Vec<[u32; 3]>>) {
    assert!(before.len() == after.len() && before.len() >= 4, "{:?} {:?}", before.keys(), after.keys());
    for (name, hull) in before {
        let (object, number) = name.rsplit_once("_part_").unwrap_or((name, "00"));
        let other = &after[&format!("UCX_{object}_{number}")];
        let mut sorted: Vec<[f32; 3]> = other.iter().map(|v| v.map(f32::from_bits)).collect();
        assert_eq!(hull.len(), sorted.len(), "{name}");
        for vertex in hull.iter().map(|v| v.map(f32::from_bits)) {
            let is_near = |w: &[f32; 3]| w.iter().zip(vertex).all(|(a, b)| (a - b).abs() <= 1e-5);
            let found = sorted.iter().position(is_near).unwrap_or_else(|| panic!("{name}: {vertex:?}"));
            sorted.swap_remove(found);
        }
    }
}

/// Reads a file with the crate `gltf`.
fn gltf_crate(folder: &TempDir, name: &str) {
    let document = ::gltf::Gltf::open(folder.path().join(name)).unwrap();
    assert_eq!(document.default_scene().unwrap().nodes().count(), 1);
    assert!(document.nodes().len() > 4 && document.meshes().len() > 2);
}

fn written(folder: &TempDir, name: &str) -> Value {
    let (text, _) = chunks(&fs::read(folder.path().join(name)).unwrap());
    serde_json::from_str(&text).unwrap()
}

/// The node `drum` is below `arm`, so both are one body. Masses are in kilograms of the file's
/// units, whatever the units of the pack.
#[test]
fn bodies_have_the_mass_of_their_meshes() {
    let motion = |options: &str| {
        let folder = baked(&model().glb(), options);
        bake(&folder, "export m.hullmap --into m.glb --for both --density 2 --out out.glb").expect(0);
        let document = written(&folder, "out.glb");
        let extension = |node: usize, name: &str| document["nodes"][node]["extensions"][name]["motion"].clone();
        for node in [0, 2] {
            assert!(document["nodes"][node].get("extensions").is_none(), "{}", document["nodes"][node]);
        }
        assert_eq!(extension(1, "OMI_physics_body")["type"], "dynamic");
        (extension(1, "KHR_physics_rigid_bodies"), extension(3, "OMI_physics_body"))
    };
    let drum_area = 12.0 * 0.49 * (std::f64::consts::TAU / 24.0).sin();
    let close = |value: &Value, expected: f64| {
        let value = value.as_f64().unwrap();
        assert!((value - expected).abs() <= 1e-5 * expected.abs().max(1.0), "{value}, not {expected}");
    };
    for options in ["", "--unit-scale 100 --up-axis y-to-z", "--set recentre=true --unit-scale 0.25"] {
        let (arm, flat) = motion(options);
        // 5 for the L; the drum has 0.75 of height, and is twice as long each way.
        let (ell_mass, drum_mass) = (2.0 * 5.0, 2.0 * 8.0 * 0.75 * drum_area);
        close(&arm["mass"], ell_mass + drum_mass);
        close(&flat["mass"], 2.0 * 0.6 * 0.75 * drum_area);
        // In the frame of the node: the L's centre, and the drum's, whose node is at z = 4.
        let ell_center = [(3.0 * 1.5 + 2.0 * 0.5) / 5.0, (3.0 * 0.5 + 2.0 * 2.0) / 5.0, 0.5];
        let drum_center = [0.0, 0.0, 4.0 - 2.0 * 0.125];
        for axis in 0..3 {
            let expected = (ell_mass * ell_center[axis] + drum_mass * drum_center[axis]) / (ell_mass + drum_mass);
            close(&arm["centerOfMass"][axis], expected);
        }
        close(&flat["centerOfMass"][2], -0.125);
    }
    let folder = baked(&model().glb(), "");
    bake(&folder, "export m.hullmap --into m.glb --for both --static --out static.glb").expect(0);
    let text = written(&folder, "static.glb").to_string();
    assert!(text.contains("collider") && !text.contains("motion"));
}

/// A hull of the whole file belongs to its only node, or to the scene.
#[test]
fn hulls_find_their_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let one = gltf::parts(&[("ell", &ell())], r#"{"children":[1]},{"mesh":0,"translation":[0,9,0]}"#, "0");
    fs::write(folder.path().join("one.glb"), one.glb()).unwrap();
    fs::write(folder.path().join("model.glb"), model().glb()).unwrap();
    bake(&folder, "build one.glb model.glb --out . --quiet").expect(0);
    bake(&folder, "export one.hullmap --into one.glb --for omi --out a.glb").expect(0);
    let document = written(&folder, "a.glb");
    assert_eq!(document["nodes"][1]["children"], serde_json::json!([2]));
    assert!(document["nodes"][1]["extensions"]["OMI_physics_body"]["motion"]["mass"].as_f64().unwrap() > 0.0);
    let run = bake(&folder, "export model.hullmap --into model.glb --for omi --out b.glb").expect(0);
    assert!(run.stderr.contains("--split object for a body per node"), "{run:?}");
    let document = written(&folder, "b.glb");
    assert_eq!(document["scenes"][0]["nodes"], serde_json::json!([0, 4]));
    let run = bake(&folder, "export model.hullmap --into one.glb --for omi --out c.glb").expect(0);
    assert!(written(&folder, "c.glb")["nodes"][1]["children"].is_array(), "{run:?}");
    bake(&folder, "build model.glb --split object --out . --quiet").expect(0);
    let run = bake(&folder, "export model.hullmap --into one.glb --for omi --out d.glb").expect(1);
    assert!(run.stderr.contains("has the name of hull arm (it has ell)"), "{run:?}");
    assert!(!folder.path().join("d.glb").exists());
}

/// A flat hull is left out with a warning, and the others stay with their nodes.
#[test]
fn flat_hulls_are_left_out() {
    let sheet = Mesh { vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], faces: vec![vec![0, 1, 2]] };
    let drum = extrusion(&regular_polygon(6, 0.5), 0.0, 1.0);
    let nodes = r#"{"name":"sheet","mesh":0},{"name":"ell","mesh":1},{"name":"drum","mesh":2}"#;
    let folder = baked(&gltf::parts(&[("sheet", &sheet), ("ell", &ell()), ("drum", &drum)], nodes, "0,1,2").glb(), "");
    let run = bake(&folder, "export m.hullmap --into m.glb --for omi --density 1 --out out.glb").expect(0);
    assert!(run.stderr.contains("1 hull left out") && run.stderr.contains("sheet"), "{run:?}");
    let document = written(&folder, "out.glb");
    assert!(document["nodes"][0].get("children").is_none());
    for (node, name, mass) in [(1, "ell", 5.0), (2, "drum", 0.375 * 3.0_f64.sqrt())] {
        let child = document["nodes"][node]["children"][0].as_u64().unwrap() as usize;
        assert_eq!(document["nodes"][child]["name"], name);
        let found = document["nodes"][node]["extensions"]["OMI_physics_body"]["motion"]["mass"].as_f64().unwrap();
        assert!((found - mass).abs() < 1e-5, "{name}: {found}, not {mass}");
    }
    // A file for each hull has its collider.
    bake(&folder, "export m.hullmap --for godot --parts --out parts").expect(0);
    bake(&folder, "build parts --split auto --out again --quiet").expect(0);
    for name in ["ell", "drum"] {
        assert_eq!(hulls(&folder, &format!("again/{name}.hullmap"))[name], hulls(&folder, "m.hullmap")[name]);
    }
}

/// A text file keeps its line breaks and its buffers; new data is in a buffer of its own.
#[test]
fn text_files_are_changed_in_place() {
    let parts = model();
    let text = "\u{feff}".to_owned() + &parts.text("data.bin").replace("},{", "},\r\n\t{") + "\n";
    let folder = files::folder(&[("in/model.gltf", &text)]);
    write(&folder, "in/data.bin", &parts.buffer);
    bake(&folder, "build in/model.gltf --split object --out . --quiet").expect(0);
    let line = "export model.hullmap --into in/model.gltf --for both --out";
    let run = bake(&folder, &format!("{line} out.gltf")).expect(2);
    assert!(run.stderr.contains("data.bin") && run.stderr.contains("the same folder"), "{run:?}");
    bake(&folder, &format!("{line} in/out.gltf")).expect(0);
    let out = fs::read_to_string(folder.path().join("in/out.gltf")).unwrap();
    assert!(has_insertions_only(&text, &out) && out.ends_with("}\n"), "{out}");
    bake(&folder, "build in/out.gltf --split auto --out . --quiet").expect(0);
    assert_eq!(hulls(&folder, "model.hullmap")["drum"], hulls(&folder, "out.hullmap")["drum"]);
    // In place, as for any file that exists.
    bake(&folder, &format!("{line} in/model.gltf")).expect(2);
    bake(&folder, &format!("{line} in/model.gltf --force")).expect(0);
    assert_eq!(fs::read_to_string(folder.path().join("in/model.gltf")).unwrap(), out);
}

/// Exports colliders of `model.glb` into a file with this text, and returns the run. The file of a
/// failed run is not written.
fn export_into(folder: &TempDir, text: &str) -> Run {
    let out = folder.path().join("out.glb");
    let _ = fs::remove_file(&out);
    fs::write(folder.path().join("hostile.glb"), gltf::glb(text.as_bytes(), &model().buffer)).unwrap();
    let run = bake(folder, "export m.hullmap --into hostile.glb --for both --out out.glb");
    assert!(run.code == 0 || run.stderr.contains("hostile.glb"), "{run:?}");
    assert!(!run.stderr.contains("panicked") && out.exists() == (run.code == 0), "{run:?}");
    run
}

/// Documents that are wrong or unusual: an error with the place, or a file that readers accept.
#[test]
fn hostile_documents_are_rejected_or_kept_whole() {
    let file = model().glb();
    let folder = baked(&file, "");
    let (text, _) = chunks(&file);
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    let last = r#""scale":[1,3,0.2]}"#;
    let used = |list: &str| with(r#""scene":0"#, &format!(r#""scene":0,"extensionsUsed":{list}"#));

    // Nodes outside of the scene that are their own ancestors, above a node of the scene.
    let around = format!(r#"{last},{{"children":[0,5]}},{{"children":[4]}}"#);
    export_into(&folder, &with(last, &around)).expect(0);
    let run = export_into(&folder, &with(last, &format!(r#"{last},{{"children":[2]}}"#))).expect(1);
    assert!(run.stderr.contains("node 2 is below node 1 and below node 4; expected a tree"), "{run:?}");
    let run = export_into(&folder, &with(r#""extras":{"n""#, r#""children":[0],"extras":{"n""#)).expect(1);
    assert!(run.stderr.contains("expected a tree"), "{run:?}");

    // Names of extensions with escapes, and one that is there already.
    export_into(&folder, &used(r#"["KHR_lights\u005fpunctual","OMI_physics\u005fbody"]"#)).expect(0);
    let used_after = written(&folder, "out.glb")["extensionsUsed"].clone();
    assert_eq!(used_after.as_array().unwrap().iter().filter(|name| **name == "OMI_physics_body").count(), 1);
    export_into(&folder, &used("7")).expect(1);

    // Members of a wrong type, with the node.
    for (from, to) in [
        (r#""name":"arm""#, r#""name":"arm","extensions":[]"#),
        (r#""extras":{"n""#, r#""extensions":7,"extras":{"n""#),
        (r#""children":[1,3]"#, r#""children":{"a":1}"#),
        (r#""nodes":[0]"#, r#""nodes":7"#),
        (r#""buffers":[{"#, r#""buffers":[{"byteLength":"all"},{"#),
    ] {
        export_into(&folder, &with(from, to)).expect(1);
    }

    // Deep nesting, in what no reader needs, and huge numbers.
    let deep = format!(r#""extras":{}1{},"scene":0"#, "[".repeat(100_000), "]".repeat(100_000));
    export_into(&folder, &with(r#""scene":0"#, &deep));
    for (from, to) in [
        (r#""componentType":5126,"type":"VEC3","count":"#, r#""componentType":5126,"type":"VEC3","count":4000000000"#),
        (r#""byteOffset":0"#, r#""byteOffset":18446744073709551615"#),
        (r#""children":[1,3]"#, r#""children":[1,3,99999999999]"#),
        (r#""scene":0"#, r#""scene":9"#),
    ] {
        export_into(&folder, &with(from, to)).expect(1);
    }

    // A member twice: readers disagree on its meaning, or the last one counts.
    let run = export_into(&folder, &with(r#""scene":0"#, r#""scene":0,"nodes":[]"#));
    assert!(run.code == 1 || written(&folder, "out.glb")["nodes"].as_array().unwrap().len() > 4, "{run:?}");

    // A buffer in another folder.
    let out_of_folder = text.replacen(r#""buffers":[{"#, r#""buffers":[{"uri":"../../secret.bin","#, 1);
    let run = export_into(&folder, &out_of_folder);
    assert!(run.code != 0 && run.stderr.contains("secret.bin"), "{run:?}");
}

/// Names with quotes, line breaks and other characters are kept.
#[test]
fn names_of_all_kinds_are_kept() {
    let name = r#"a\"b\n\\c\t{é}\u2028"#;
    let nodes = format!(r#"{{"name":"{name}","mesh":0}},{{"name":"plain","mesh":0,"translation":[9,0,0]}}"#);
    let folder = baked(&gltf::parts(&[("ell", &ell())], &nodes, "0,1").glb(), "");
    bake(&folder, "export m.hullmap --into m.glb --for both --out out.glb").expect(0);
    let document = written(&folder, "out.glb");
    assert_eq!(document["nodes"][0]["name"], "a\"b\n\\c\t{é}\u{2028}");
    for node in [0, 1] {
        assert!(document["nodes"][node]["extensions"]["OMI_physics_body"]["motion"]["mass"].as_f64().unwrap() > 0.0);
    }
    bake(&folder, "build out.glb --split auto --out . --quiet").expect(0);
    assert_eq!(hulls(&folder, "m.hullmap").len(), hulls(&folder, "out.hullmap").len());
}

/// Prefixes, and each length in the header and the chunks of a GLB file, too small and too large.
#[test]
fn damaged_files_are_rejected() {
    let file = model().glb();
    let folder = baked(&file, "");
    let mut all: Vec<Vec<u8>> = (0..file.len()).step_by(97).map(|length| file[..length].to_vec()).collect();
    let text_length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    for at in [4, 8, 12, 20 + text_length] {
        let right = u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        for wrong in [0, 1, right - 1, right + 1, right + 4, u32::MAX, u32::MAX - 3] {
            let mut damaged = file.clone();
            damaged[at..at + 4].copy_from_slice(&wrong.to_le_bytes());
            all.push(damaged);
        }
    }
    for (index, damaged) in all.iter().enumerate() {
        write(&folder, "damaged.glb", damaged);
        let run = bake(&folder, "export m.hullmap --into damaged.glb --for both --out out.glb").expect(1);
        assert!(run.stderr.contains("damaged.glb") && !run.stderr.contains("panicked"), "{index}: {run:?}");
        assert!(!folder.path().join("out.glb").exists(), "{index}");
    }
}
