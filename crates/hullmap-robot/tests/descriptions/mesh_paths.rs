//! Which files names of meshes lead to: a table that `tests/robots/check_paths.py` tests in MuJoCo.

use std::collections::BTreeMap;
use std::path::Path;

use hullmap_robot::{Description, Unresolved, relative};
use serde_json::Value;

use super::{folder, read};

const TABLE: &str = include_str!("../../../../tests/robots/mesh_paths.json");

fn strings(values: &Value) -> BTreeMap<&str, &str> {
    values.as_object().unwrap().iter().map(|(key, value)| (key.as_str(), value.as_str().unwrap())).collect()
}

/// Links and the files of their first meshes, relative to the folder.
fn mesh_files(description: &Description, root: &Path) -> BTreeMap<String, String> {
    let first = |link: &hullmap_robot::Link| {
        let file = link.meshes().next()?.file.as_ref().map(|file| relative(file, root).unwrap());
        Some((link.name.clone(), file.unwrap_or_else(|error| format!("{error:?}"))))
    };
    description.links.iter().filter_map(first).collect()
}

/// The files that are copied beside the description. They include all files that a model opens,
/// also through attached models.
fn copied(description: &Description, root: &Path) -> Vec<String> {
    description.references.iter().map(|own| relative(&own.file, root).unwrap()).collect()
}

#[test]
fn names_lead_to_the_files_that_mujoco_opens() {
    let table: Vec<Value> = serde_json::from_str(TABLE).unwrap();
    let mut attached = 0;
    for case in &table {
        let name = case["name"].as_str().unwrap();
        let meshes = case["meshes"].as_array().unwrap().iter().map(|mesh| (mesh.as_str().unwrap(), ""));
        let (_guard, root) = folder(&meshes.chain(strings(&case["files"])).collect::<Vec<_>>());
        let description = read(&root, case["model"].as_str().unwrap()).unwrap();
        let found = mesh_files(&description, &root);
        for (body, file) in strings(&case["expected"]) {
            let own = description.links.iter().any(|link| link.name == body);
            attached += usize::from(!own);
            assert!(!own || found[body] == file, "{name}: {found:?}");
            let is_named = !case.to_string().contains("package://");
            assert!(!is_named || copied(&description, &root).contains(&file.to_owned()), "{name}: {description:?}");
        }
        assert!(
            description.warnings.is_empty() != name.ends_with("both folders have the mesh"),
            "{name}: {description:?}"
        );
    }
    assert!(table.len() > 30 && attached == 2);
}

#[test]
fn new_meshes_are_found_by_their_names() {
    let table: Vec<Value> = serde_json::from_str(TABLE).unwrap();
    let names = |name: &str, mesh: &str| {
        let case = table.iter().find(|case| case["name"] == name).unwrap();
        let meshes = case["meshes"].as_array().unwrap().iter().map(|mesh| (mesh.as_str().unwrap(), ""));
        let (_guard, root) = folder(&meshes.chain(strings(&case["files"])).collect::<Vec<_>>());
        let description = read(&root, case["model"].as_str().unwrap()).unwrap();
        let folder = description.mesh_folder(&root).map(|folder| relative(&folder, &root).unwrap());
        (folder, description.mesh_name(&root.join(mesh), &root).unwrap())
    };
    let md = || Some("md".to_owned());
    assert_eq!(names("URDF: names start from meshdir", "h/x.obj"), (None, "../h/x.obj".to_owned()));
    assert_eq!(names("URDF: strippath", "md/x.obj"), (md(), "md/x.obj".to_owned()));
    assert_eq!(names("URDF: strippath and packages", "md/x.obj"), (md(), "package://arm/md/x.obj".to_owned()));
    assert_eq!(names("URDF: no folder is removed by default", "h/x.obj"), (None, "h/x.obj".to_owned()));
    assert_eq!(names("strippath removes folders", "md/x.obj"), (md(), "x.obj".to_owned()));
    assert_eq!(names("a later meshdir overrides an assetdir", "h/x.obj"), (None, "../h/x.obj".to_owned()));
}

/// Messages say which attribute leads astray, and what is missing.
#[test]
fn faults_name_their_cause() {
    let model = |compiler: &str, rest: &str| {
        format!(
            "<mujoco><compiler {compiler}/><asset><mesh name='m' file='m.obj'/></asset>\n<worldbody><body name='b'><geom type='mesh' mesh='m'/>{rest}</body></worldbody></mujoco>"
        )
    };
    let error = |text: &str| {
        let (_guard, root) = folder(&[("a.xml", text), ("m.obj", "")]);
        let description = read(&root, "a.xml").unwrap();
        match description.links.iter().find_map(|link| link.meshes().next()).unwrap().file.clone() {
            Err(Unresolved::Failed(message)) => message,
            other => panic!("{other:?}"),
        }
    };
    let outside = error(&model("meshdir='../../../../../../../..'", ""));
    assert!(
        outside.starts_with("`m.obj` from meshdir=\"../../../../../../../..\" leads out of the project"),
        "{outside}"
    );
    let outside = error(&model("assetdir='/'", ""));
    assert!(outside.starts_with("`m.obj` from assetdir=\"/\" leads out of the project"), "{outside}");
    let missing = error(&model("meshdir='md'", ""));
    assert!(missing.starts_with("no file `m.obj` from meshdir=\"md\"; restore it"), "{missing}");
    let text = model(
        "",
        "\n<geom type='mesh' mesh='gone'/><geom type='mesh'/>\n<geom class='none' size='1'/><body childclass='none'/><site class='other'/>",
    );
    let (_guard, root) = folder(&[("a.xml", text.as_str()), ("m.obj", "")]);
    let warnings = read(&root, "a.xml").unwrap().warnings;
    for (line, expected) in [
        (3, "no mesh `gone` is among the assets"),
        (3, "this geom names no mesh"),
        (4, "no default class `none` exists"),
        (4, "no default class `other` exists"),
    ] {
        assert!(
            warnings.iter().any(|own| own.contains(&format!("a.xml:{line}: {expected}"))),
            "{expected}: {warnings:?}"
        );
    }
    assert_eq!(warnings.len(), 4, "{warnings:?}");
    // A model that attaches itself, and one that is missing.
    let attach = "<mujoco><asset><model name='a' file='a.xml'/><model name='b' file='sub/b.xml'/></asset>\
                  <worldbody><attach model='a' body='x' prefix='p'/></worldbody></mujoco>";
    let (_guard, root) = folder(&[("a.xml", attach), ("sub/b.xml", "<mujoco>\n<include file='c.xml'/></mujoco>")]);
    let description = read(&root, "a.xml").unwrap();
    let others = description.others.iter().map(|other| (&*other.written, other.path.clone().unwrap()));
    assert!(others.eq([("a.xml", root.join("a.xml")), ("sub/b.xml", root.join("sub/b.xml"))]));
    let [warning] = &description.warnings[..] else { panic!("{:?}", description.warnings) };
    assert!(
        warning.contains("b.xml:2: no file `c.xml`; restore it, or remove this include, so the files"),
        "{warning}"
    );
}

/// Vertices and faces in the model.
#[test]
fn meshes_in_the_model_are_read() {
    let mesh = |attributes: &str| {
        let text = format!(
            "<mujoco><asset><mesh name='m' {attributes}/></asset><worldbody><body name='b'><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        let (_guard, root) = folder(&[("a.xml", text.as_str())]);
        read(&root, "a.xml").unwrap().links[1].collisions[0].clone()
    };
    let file = |attributes: &str| match mesh(attributes).geometry {
        hullmap_robot::Geometry::Mesh(mesh) => mesh.file,
        other => panic!("{other:?}"),
    };
    let points = "vertex='0 0 0  1e0 0 0\n0 1 0 0 0 -0.5'";
    let Err(Unresolved::Inline(own)) = file(&format!("{points} face='0 1 2 3 2 1'")) else { panic!() };
    assert_eq!((own.vertices[3], own.triangles.as_slice()), ([0.0, 0.0, -0.5], &[[0, 1, 2], [3, 2, 1]][..]));
    assert!(mesh(&format!("{points} face='0 1 2 3 2 1'")).stays_single.is_none());
    assert!(mesh(points).stays_single.is_some_and(|reason| reason == "its mesh is the hull of points"));
    assert!(matches!(mesh("builtin='sphere'").geometry, hullmap_robot::Geometry::Other(_)));
    for attributes in [
        "vertex=''",
        "vertex='0 0'",
        "vertex='0 0 x'",
        "vertex='0 0 inf'",
        "vertex='0 0 0' face='0 0 1'",
        "vertex='0 0 0' face='0 0 -1'",
        "vertex='0 0 0' face='0'",
    ] {
        assert!(matches!(file(attributes), Err(Unresolved::Failed(_))), "{attributes}");
    }
}
