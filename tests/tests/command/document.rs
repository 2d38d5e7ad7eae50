//! docs/COMMAND.md is correct: it lists every JSON field of each command, and no others. Its flags
//! are made from the command (`args/reference.rs` in the crate of the command), and
//! `tests/cases/options.md` tests its exit codes.

use std::{collections::BTreeSet, fs};

use hullmap_testkit::{command::bake_in, files::workspace};
use serde_json::Value;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// The part of the page below `## bake <name>`.
fn section(name: &str) -> String {
    let page = fs::read_to_string(workspace().join("docs/COMMAND.md")).unwrap();
    let heading = format!("\n## bake {name}\n");
    let start = page.find(&heading).unwrap_or_else(|| panic!("no section `bake {name}`")) + heading.len();
    let rest = &page[start..];
    rest[..rest.find("\n## ").unwrap_or(rest.len())].to_owned()
}

/// Names in the list below the line `heading:`.
fn list(section: &str, heading: &str) -> BTreeSet<String> {
    let lines = section.lines().skip_while(|line| *line != format!("{heading}:")).skip(2);
    lines.map_while(|line| line.strip_prefix("- `")?.split('`').next()).map(str::to_owned).collect()
}

/// Fields of an object and of the objects in it, as `hulls[].index.kind`; `empty` are the fields
/// without a value.
fn fields(value: &Value, prefix: &str, found: &mut BTreeSet<String>, empty: &mut BTreeSet<String>) {
    match value {
        Value::Null => _ = empty.insert(prefix.to_owned()),
        Value::Array(values) if values.is_empty() => _ = empty.insert(prefix.to_owned()),
        Value::Object(map) => {
            for (key, value) in map {
                let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                fields(value, &name, found, empty);
                found.insert(name);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| fields(value, &format!("{prefix}[]"), found, empty)),
        _ => {}
    }
}

#[test]
fn every_json_field_is_documented_and_every_documented_one_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    for name in ["a.obj", "gone.obj"] {
        fs::write(folder.path().join("in").join(name), CUBE).unwrap();
    }
    let run = |line: &str| bake_in(folder.path(), line.split_whitespace());
    run("build in --out o").expect(0);
    // A level of two triangles with a material.
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl grass\nf 1 2 3 4\n";
    fs::write(folder.path().join("level.obj"), text).unwrap();
    run("build level.obj --out l --keep-triangles").expect(0);
    fs::write(folder.path().join("dem.asc"), "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n").unwrap();
    run("build dem.asc --out h --terrain").expect(0);
    // A sheet of two parts.
    let sheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nf 1 2 3 4\nf 1 4 6 5\n";
    fs::write(folder.path().join("sheet.obj"), sheet).unwrap();
    // A closed box.
    let sides = "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\n";
    let closed = CUBE.replace("f 1 2 4 3", "f 1 3 4 2") + sides;
    fs::write(folder.path().join("box.obj"), closed).unwrap();
    let collision = "<collision><geometry><mesh filename='in/a.obj'/></geometry></collision>";
    let link = |name: &str| format!("<link name='{name}'>{collision}</link>");
    let joint = "<joint name='j' type='fixed'><parent link='l'/><child link='m'/></joint>";
    let robot = format!("<robot name='r'>{}{}{joint}</robot>", link("l"), link("m"));
    fs::write(folder.path().join("r.urdf"), robot).unwrap();
    fs::remove_file(folder.path().join("in/gone.obj")).unwrap();
    fs::write(folder.path().join("in/bad.obj"), "v\n").unwrap();
    // A heading "Fields" followed by more words belongs to another kind of object.
    for (name, lines) in [
        (
            "build",
            [
                "build in --out o --json",
                "build in --out o --check --json",
                "build in --out p --json",
                "build sheet.obj --out q --decompose --json",
                "build box.obj --out t --decompose --set primitives=true --json",
                "build level.obj --out l --keep-triangles --force --json",
                "build dem.asc --out h --terrain --json",
            ]
            .as_slice(),
        ),
        ("decompose", &["decompose in/a.obj a.glb --json"]),
        ("farm key", &["farm key in/a.obj --json"]),
        ("farm plan", &["farm plan in/a.obj --out o"]),
        ("farm status", &["farm status in --out o --json", "farm status in --out p --json --shards 3"]),
        ("verify", &["verify o --json", "verify o in/a.obj --json", "verify q --json"]),
        ("inspect", &["inspect o --json", "inspect o --json --vertices", "inspect q --json", "inspect t --json"]),
        ("verify: Fields of a triangle mesh or height field", &["verify l --json", "verify h --json"]),
        ("inspect: Fields of a triangle mesh", &["inspect l --json", "inspect l --json --vertices"]),
        ("inspect: Fields of a height field", &["inspect h --json", "inspect h --json --vertices"]),
        ("export", &["export o/a.hullmap --format json"]),
        ("robot", &["robot r.urdf --out o/r.urdf --json", "robot r.urdf --out o/r.urdf --json --exclude-pairs"]),
        (
            "query",
            &[
                "query o/a.hullmap o/a.hullmap --json",
                "query o/a.hullmap o/a.hullmap --mode distance --json",
                "query o/a.hullmap o/a.hullmap --mode intersect --json",
            ],
        ),
    ] {
        let (name, heading) = name.split_once(": ").unwrap_or((name, "Fields"));
        let mut documented = list(&section(name), heading);
        // Other kinds of files have the fields of packs, and the counts that `bake build` prints.
        if let ("inspect", Some(kind)) = (name, heading.strip_prefix("Fields of a ")) {
            let of_build = list(&section("build"), "Fields").into_iter().filter_map(|field| {
                let field = field.strip_prefix("triangle_mesh.")?.to_owned();
                let is_shared = kind == "triangle mesh" || field.starts_with("edges.");
                is_shared.then(|| format!("{}.{field}", kind.replace(' ', "_")))
            });
            let of_packs = list(&section(name), "Fields").into_iter();
            let of_packs = of_packs.filter(|field| !field.starts_with("hulls") && field != "lean");
            documented.extend(of_build.chain(of_packs));
        }
        let mut all = BTreeSet::new();
        for line in lines {
            let (mut printed, mut empty) = (BTreeSet::new(), BTreeSet::new());
            for value in run(line).json() {
                fields(&value, "", &mut printed, &mut empty);
            }
            // Something without a value has no fields of its own.
            let is_below = |field: &String, parent: &String| {
                field.strip_prefix(parent.as_str()).is_some_and(|rest| rest.starts_with(['.', '[']))
            };
            let is_expected =
                |field: &&String| printed.contains(*field) || !empty.iter().any(|parent| is_below(field, parent));
            let expected: BTreeSet<String> = documented.iter().filter(is_expected).cloned().collect();
            assert_eq!(printed, expected, "{line}: printed, documented");
            all.append(&mut printed);
        }
        assert_eq!(all, documented, "{name}: printed by any line, documented");
    }
}
