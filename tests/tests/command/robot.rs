//! `bake robot`: what it writes, that it writes it once, and that faults leave nothing behind.

use std::fs;
use std::path::Path;

use hullmap_outside::command::{Run, bake_in};
use hullmap_outside::files::workspace;
use serde_json::Value;

/// A folder with a copy of the robots, as a project.
fn robots() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let source = workspace().join("tests/robots");
    let descriptions = ["arm.urdf", "arm.xml", "arm.sdf", "tip.xml", "wedge.urdf", "crowd.xml", "crowd.urdf"];
    for name in descriptions.into_iter().chain(["meshes/bracket.obj", "meshes/wedge.dae"]) {
        let target = folder.path().join("in").join(name);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(source.join(name), target).unwrap();
    }
    fs::create_dir(folder.path().join(".git")).unwrap();
    folder
}

fn run(folder: &Path, line: &str) -> Run {
    bake_in(folder, line.split_whitespace())
}

/// Every file below a folder, by its path.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut waiting = vec![folder.to_owned()];
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                waiting.push(path)
            } else {
                found.push((path.display().to_string(), fs::read(&path).unwrap()))
            }
        }
    }
    found.sort();
    found
}

fn actions(row: &Value) -> Vec<&str> {
    row["collisions"].as_array().unwrap().iter().map(|own| own["action"].as_str().unwrap()).collect()
}

#[test]
fn a_second_run_changes_nothing_and_neither_does_one_on_the_output() {
    let folder = robots();
    for options in ["", " --decompose --max-error 2mm"] {
        let line = format!("robot in/arm.urdf in/arm.xml in/arm.sdf in/wedge.urdf --out out{options} --json");
        let missing = run(folder.path(), &format!("{line} --check")).expect(1);
        let state = if options.is_empty() { "missing" } else { "stale" };
        assert!(
            missing.json().iter().all(|row| row["status"] == state || row["file"] == "in/wedge.urdf"),
            "{}",
            missing.stdout
        );
        let first = run(folder.path(), &line).expect(0);
        let parts = usize::from(!options.is_empty());
        assert_eq!(
            actions(&first.json()[0]),
            [[["hull", "kept", "hull", "primitive"]], [["parts", "kept", "parts", "primitive"]]][parts][0]
        );
        let before = files(&folder.path().join("out"));
        run(folder.path(), &format!("{line} --check")).expect(0);
        let second = run(folder.path(), &line).expect(0);
        assert!(second.json().iter().all(|row| row["status"] == "fresh" && row["baked"] == 0), "{}", second.stdout);
        let own = run(folder.path(), "robot out/arm.urdf out/arm.xml out/arm.sdf --out out --json").expect(0);
        assert!(own.json().iter().all(|row| row["status"] == "fresh"), "{}", own.stdout);
        assert!(files(&folder.path().join("out")) == before, "files have changed");
    }
    fs::write(folder.path().join("in/meshes/bracket.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
        .unwrap();
    let stale = run(folder.path(), "robot in/arm.urdf --out out --check --json").expect(1);
    assert_eq!(stale.json()[0]["status"], "stale", "{}", stale.stdout);
}

/// Removing additions from the output, and renaming its hulls, gives the input.
#[test]
fn only_collisions_change() {
    let folder = robots();
    run(folder.path(), "robot in/arm.urdf in/arm.sdf --out in/baked --from-visual never").expect(0);
    for (name, hull) in [("arm.urdf", "arm_collision/bracket_hull.obj"), ("arm.sdf", "arm_collision/bracket_hull.obj")]
    {
        let before = fs::read_to_string(folder.path().join("in").join(name)).unwrap();
        let after = fs::read_to_string(folder.path().join("in/baked").join(name)).unwrap();
        assert_ne!(before, after);
        assert_eq!(after.replace(hull, "meshes/bracket.obj"), before, "{name}");
    }
    let rows = run(folder.path(), "robot in/arm.urdf --out in/hulls.urdf --json").expect(0).json();
    let one = &rows[0]["collisions"];
    assert_eq!(one[0]["meshes"], one[2]["meshes"], "a mirror shares the hull");
    assert_eq!(rows[0]["baked"], 1);
}

#[test]
fn rules_and_flags_choose_for_each_link() {
    let folder = robots();
    let rules =
        "[defaults]\ndecompose = true\nmax_error = \"2mm\"\nunit_scale = 2\n\n[[rule]]\nlinks = \"l*\"\nskip = true\n";
    fs::write(folder.path().join("in/hullmap.toml"), rules).unwrap();
    let found = run(folder.path(), "robot in/arm.urdf --out out --json").expect(0);
    assert_eq!(actions(&found.json()[0]), ["parts", "kept", "kept", "primitive"]);
    assert!(found.json()[0]["collisions"][0]["protrusion_mm"].as_f64().unwrap() <= 2.0, "{}", found.stdout);
    assert!(found.stderr.contains("hullmap.toml: unit_scale has no effect on robots"), "{}", found.stderr);
    let found =
        run(folder.path(), "robot in/arm.urdf --out out --no-config --skip base --from-visual never --json").expect(0);
    assert_eq!(actions(&found.json()[0]), ["kept", "kept", "hull"]);
    assert!(!found.stderr.contains("links without a collision"), "{}", found.stderr);
    let found = run(folder.path(), "robot in/arm.urdf --out out --no-config --json").expect(0);
    assert!(found.stderr.contains("links without a collision get one from their visuals: `"), "{}", found.stderr);
    let found = run(folder.path(), "robot in/arm.urdf --out out --no-config --from-visual always --json").expect(0);
    assert_eq!(actions(&found.json()[0]), ["removed", "removed", "hull", "hull", "primitive"]);
    let text = fs::read_to_string(folder.path().join("out/arm.urdf")).unwrap();
    assert!(!text.contains("foot") && text.matches("<collision").count() == 3, "{text}");
    run(folder.path(), "robot in/arm.urdf --out out --unit-scale 2").expect(2);
    run(folder.path(), "robot in/arm.urdf --out out --no-config --max-parts 2").expect(2);
    // A rule of links does not match meshes.
    run(folder.path(), "build in --out packs").expect(0);
}

#[test]
fn a_description_that_fails_leaves_no_output_and_the_others_go_on() {
    let folder = robots();
    let write = |name: &str, text: &str| fs::write(folder.path().join("in").join(name), text).unwrap();
    let collision = |file: &str| {
        format!(
            "<robot name='r'>\n<link name='l'><collision><geometry>\n<mesh filename='{file}'/></geometry></collision></link></robot>"
        )
    };
    write("gone.urdf", &collision("gone.stl"));
    write("out.urdf", &collision("../../../../../../../etc/passwd"));
    write("text.urdf", &collision("arm.urdf"));
    write("cycle.xml", "<mujoco>\n<include file='cycle.xml'/></mujoco>");
    write("bomb.urdf", "<!DOCTYPE r [<!ENTITY a 'aaaaaaaa'>]>\n<robot name='&a;'/>");
    write("deep.urdf", &"<a>".repeat(3_400_000));
    write("macros.urdf", "<robot xmlns:xacro='x'><xacro:if value='1'/></robot>");
    write("m.xacro", "<robot xmlns:xacro='x'><xacro:if value='1'/></robot>");
    write("x.urdf.xacro", "<robot xmlns:xacro='x'><xacro:if value='1'/></robot>");
    let all = "in/gone.urdf in/out.urdf in/text.urdf in/cycle.xml in/bomb.urdf in/deep.urdf in/x.urdf.xacro in/macros.urdf in/m.xacro in/none.urdf in/arm.urdf";
    let found = run(folder.path(), &format!("robot {all} --out out --json")).expect(2);
    let states: Vec<String> = found.json().iter().map(|row| row["status"].as_str().unwrap().to_owned()).collect();
    assert_eq!(states[..10], ["failed"; 10]);
    assert_eq!(states[10], "written");
    for expected in [
        "in/gone.urdf:2: link `l`: no file `gone.stl`; restore it, or leave its link alone with `bake robot --skip`",
        "leads out of the project and of all packages; name its folder with --package-path (in Python: packages)",
        "a rule or --skip leaves its link alone",
        "in/cycle.xml:2: `cycle.xml` is included already",
        "remove <!DOCTYPE>",
        "in/deep.urdf:1: elements are nested deeper than 1000",
        "expand them first: xacro in/x.urdf.xacro > in/x.urdf",
        "expand them first: xacro in/macros.urdf > in/macros_expanded.urdf",
        "expand them first: xacro in/m.xacro > in/m.urdf",
        "in/none.urdf: cannot read",
    ] {
        assert!(found.stderr.contains(expected), "{expected}: {}", found.stderr);
    }
    // Beside the description, where names have no folder.
    let beside = run(&folder.path().join("in"), "robot gone.urdf --out x.urdf").expect(1);
    assert!(beside.stderr.contains("no file `gone.stl`; restore it"), "{}", beside.stderr);
    assert!(beside.stdout.contains("gone.urdf: failed; nothing written"), "{}", beside.stdout);
    let written = files(&folder.path().join("out"));
    assert!(
        !written
            .iter()
            .any(|(path, _)| ["gone", "out.urdf", "text.urdf", "cycle"].iter().any(|name| path.ends_with(name)))
    );
}

/// The bracket has a foot of 4 x 1 x 1 and a post of 1 x 1 x 2; the link `left` mirrors it in y.
#[test]
fn inertia_is_that_of_the_mesh_at_the_stated_mass() {
    let folder = robots();
    let found = run(folder.path(), "robot in/arm.urdf --out out --inertia --from-visual never --json").expect(0);
    assert!(found.stderr.contains("link `base` keeps its inertia"), "it has a box: {}", found.stderr);
    let text = fs::read_to_string(folder.path().join("out/arm.urdf")).unwrap();
    let left = text.split("<link name=\"left\">").nth(1).unwrap().split("</link>").next().unwrap();
    let numbers = |from: &str| -> Vec<f64> {
        let value = left.split(from).nth(1).unwrap().split('"').next().unwrap();
        value.split(' ').map(|number| number.parse().unwrap()).collect()
    };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-7, "{found} {expected}: {left}");
    // Volumes 4 and 2, so centres (2, 0.5, 0.5) and (0.5, 0.5, 2) count 2 : 1, in decimetres.
    for (found, expected) in numbers("xyz=\"").into_iter().zip([0.15, -0.05, 0.1]) {
        near(found, expected);
    }
    // 2 kg: a foot of 4/3 kg and a post of 2/3 kg.
    let (foot, post) = (4.0 / 3.0, 2.0 / 3.0);
    let ixx = foot * (2.0 / 1200.0 + 0.05 * 0.05) + post * (5.0 / 1200.0 + 0.1 * 0.1);
    let iyy = foot * (17.0 / 1200.0 + 0.05 * 0.05 + 0.05 * 0.05) + post * (5.0 / 1200.0 + 0.1 * 0.1 + 0.1 * 0.1);
    let ixz = -(foot * 0.05 * -0.05 + post * -0.1 * 0.1);
    near(numbers("ixx=\"")[0], ixx);
    near(numbers("iyy=\"")[0], iyy);
    near(numbers("ixz=\"")[0], ixz);
    near(numbers("ixy=\"")[0], 0.0);
    assert!(left.contains("<mass value=\"2\"/>"));
    // The body `left` of the model has the mass of its `inertial`, and no orientation beside it.
    run(folder.path(), "robot in/arm.xml --out out --inertia").expect(0);
    let text = fs::read_to_string(folder.path().join("out/arm.xml")).unwrap();
    let inertial = text.split("<inertial ").nth(1).unwrap().split("/>").next().unwrap();
    assert!(inertial.contains("mass=\"2\"") && !inertial.contains("diaginertia"), "{inertial}");
    let listed = |name: &str| -> Vec<f64> {
        let value = inertial.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap();
        value.split(' ').map(|number| number.parse().unwrap()).collect()
    };
    for (found, expected) in listed("pos").into_iter().zip([0.15, -0.05, 0.1]) {
        assert!((found - expected).abs() < 1e-7, "{inertial}");
    }
    let tensor = listed("fullinertia");
    for (at, expected) in [(0, ixx), (1, iyy), (3, 0.0), (4, ixz)] {
        assert!((tensor[at] - expected).abs() < 1e-7, "{at}: {inertial}");
    }
    // The same link in SDF, whose collision is made from its visual.
    run(folder.path(), "robot in/arm.sdf --out out --inertia").expect(0);
    let text = fs::read_to_string(folder.path().join("out/arm.sdf")).unwrap();
    let left = text.split("<link name=\"left\">").nth(1).unwrap().split("</link>").next().unwrap();
    let number = |name: &str| -> Vec<f64> {
        let value = left.split(&format!("<{name}>")).nth(1).unwrap().split('<').next().unwrap();
        value.split(' ').map(|number| number.parse().unwrap()).collect()
    };
    for (found, expected) in number("pose").into_iter().zip([0.15, -0.05, 0.1, 0.0, 0.0, 0.0]) {
        assert!((found - expected).abs() < 1e-7, "{left}");
    }
    for (name, expected) in [("mass", 2.0), ("ixx", ixx), ("iyy", iyy), ("ixz", ixz), ("ixy", 0.0)] {
        assert!((number(name)[0] - expected).abs() < 1e-7, "{name}: {left}");
    }
}

#[test]
fn inputs_are_not_replaced_by_accident() {
    let folder = robots();
    let before = files(&folder.path().join("in"));
    let found = run(folder.path(), "robot in/arm.urdf --out in").expect(2);
    assert!(found.stderr.contains("is an input, and would be replaced"), "{}", found.stderr);
    assert!(files(&folder.path().join("in")) == before, "nothing is baked before that is clear");
    let found = run(folder.path(), "robot in/arm.xml --out in/other.xml").expect(2);
    assert!(found.stderr.contains("tip.xml: is an input"), "the included file has collisions: {}", found.stderr);
    let after = files(&folder.path().join("in"));
    let kept = |all: &[(String, Vec<u8>)]| -> Vec<(String, Vec<u8>)> {
        all.iter().filter(|(path, _)| !path.contains("_collision")).cloned().collect()
    };
    assert!(kept(&after) == kept(&before));
    run(folder.path(), "robot in/arm.urdf --out in --force").expect(0);
    run(folder.path(), "robot in/arm.urdf in/arm.xml --out in/x.urdf").expect(2);
}

/// The text of a section of a report page, without its tags.
fn section(page: &str, id: &str) -> String {
    let section = page.split(&format!("id=\"{id}\"")).nth(1).unwrap().split("</section>").next().unwrap();
    let words = section.split('<').map(|tag| tag.split('>').next_back().unwrap().trim());
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("|")
}

#[test]
fn a_report_shows_links_joints_and_pairs_that_touch() {
    let folder = robots();
    let line = "robot in/crowd.urdf --out out --report page/r.html";
    run(folder.path(), line).expect(0);
    let page = fs::read_to_string(folder.path().join("page/r.html")).unwrap();
    assert!(!page.contains("://") && !page.contains(" src=\"/"), "it is self-contained");
    let touching = section(&page, "touching");
    assert!(touching.contains("|first|third|touch|touch|") && !touching.contains("|second|fourth|"), "{touching}");
    // A mesh of 6 volumes in a hull of 9: the worst link, and the only one with a bound.
    let links = section(&page, "links");
    let worst = links.split("uncovered, mm|").nth(1).unwrap();
    assert!(worst.starts_with("tool|hull|1|1|10|"), "{links}");
    let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    let joints = data["joints"].as_array().unwrap();
    let names: Vec<&str> = joints.iter().map(|joint| joint["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["a", "b", "d", "e"], "a fixed joint has no slider");
    assert_eq!((&joints[3]["leader"], &joints[3]["coefficients"][1]), (&Value::from(2), &Value::from(-0.5)));
    let layers = |link: usize| -> Vec<&str> {
        let shapes = data["links"][link]["shapes"].as_array().unwrap();
        shapes.iter().map(|shape| shape["layer"].as_str().unwrap()).collect()
    };
    assert_eq!(layers(0), ["before", "before", "after", "after"]);
    assert!(section(&page, "excluded").contains("|first|third|Default"), "what --exclude-pairs would write");
    // Equal inputs give equal pages, and a page does not make its robot stale.
    let again = run(folder.path(), &format!("{line} --json")).expect(0);
    assert_eq!(again.json()[0]["status"], "fresh");
    assert_eq!(fs::read_to_string(folder.path().join("page/r.html")).unwrap(), page);
    run(folder.path(), "robot in/crowd.urdf in/arm.urdf --out out --report r.html").expect(2);
    run(folder.path(), &format!("{line} --check")).expect(2);
}

/// The bracket protrudes from its solid by the most at the middle of the slope over its corner.
#[test]
fn protrusion_of_a_hull_is_reported_in_millimetres_of_the_robot() {
    let folder = robots();
    run(folder.path(), "robot in/crowd.urdf --out out --report r.html").expect(0);
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    let links = section(&page, "links");
    let cells: Vec<&str> = links.split("|tool|").nth(1).unwrap().split('|').collect();
    // A foot of 4 x 1 x 1 and a post of 1 x 1 x 2 on it. The slope from (1, 3) to (4, 1) has the
    // points (1 + 3 t, 3 - 2 t), at 3 t from the post and 2 - 2 t from the foot: the most is 1.2,
    // of 50 mm.
    let bound: f64 = cells[5].parse().unwrap();
    assert!((60.0..60.6).contains(&bound), "{links}");
}

#[test]
fn pairs_are_excluded_once() {
    let folder = robots();
    let line = "robot in/crowd.urdf in/crowd.xml --out out --exclude-pairs --json";
    let rows = run(folder.path(), line).expect(0).json();
    let pairs = |row: &Value| -> Vec<String> {
        let pairs = row["excluded_pairs"].as_array().unwrap().iter();
        let words = pairs.map(|pair| format!("{} {} {}", pair["links"][0], pair["links"][1], pair["reason"]));
        words.map(|words| words.replace('"', "")).collect()
    };
    assert_eq!(pairs(&rows[1]), ["first third Default"], "fourth and second are excluded already");
    let urdf = pairs(&rows[0]);
    assert!(urdf.contains(&"third tool Adjacent".to_owned()), "a fixed joint: {urdf:?}");
    assert!(!urdf.contains(&"second tool Adjacent".to_owned()), "they move relative to each other: {urdf:?}");
    let skipped = rows[1]["skipped_pairs"].as_array().unwrap();
    assert!(skipped.iter().any(|pair| pair["reason"] == "excluded by `exclude`"), "{skipped:?}");
    assert!(urdf.contains(&"second fourth Never".to_owned()), "half a metre apart: {urdf:?}");
    let text = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let srdf = text("crowd.srdf");
    assert_eq!(srdf.matches("<disable_collisions ").count(), urdf.len());
    assert!(srdf.contains("<robot name=\"crowd\">") && srdf.contains("10000 random configurations (seed 0)"));
    let mjcf = text("crowd.xml");
    let added = "\n    <exclude body1=\"first\" body2=\"third\"/>\n  </contact>\n</mujoco>";
    assert!(mjcf.contains(added), "{mjcf}");
    let again = run(folder.path(), line).expect(0);
    assert!(again.json().iter().all(|row| row["status"] == "fresh"), "{}", again.stdout);
    let own = run(folder.path(), "robot out/crowd.xml --out out --exclude-pairs --json").expect(0);
    assert_eq!((&own.json()[0]["status"], pairs(&own.json()[0]).len()), (&Value::from("fresh"), 0), "{}", own.stdout);
    // Without samples, nothing is always or never so.
    let few = run(folder.path(), "robot in/crowd.urdf --out few --exclude-pairs --samples 0 --json").expect(0);
    assert!(pairs(&few.json()[0]).iter().all(|pair| !pair.ends_with("Never")));
    // An SRDF file of the user's own.
    fs::write(folder.path().join("out/crowd.srdf"), "<robot name='crowd'><group name='arm'/></robot>").unwrap();
    let rejected = run(folder.path(), line).expect(2);
    assert!(rejected.stderr.contains("crowd.srdf: exists, and was not written by bake"), "{}", rejected.stderr);
    run(folder.path(), "robot in/arm.sdf --out out --exclude-pairs").expect(2);
}

/// In MJCF, a geom that is drawn or has mass stays. A second run, and one on the output, change
/// nothing.
#[test]
fn collisions_of_mjcf_are_made_from_visuals() {
    let folder = robots();
    let line = "robot in/arm.xml --out out --from-visual always --json";
    let found = run(folder.path(), line).expect(0);
    let left: Vec<String> = found.json()[0]["collisions"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|own| own["link"] == "left")
        .map(|own| own["action"].to_string())
        .collect();
    assert_eq!(left, ["\"removed\"", "\"hull\""]);
    let text = fs::read_to_string(folder.path().join("out/arm.xml")).unwrap();
    let body = text.split("<body name=\"left\"").nth(1).unwrap();
    assert!(!body.contains("name=\"left\" class=\"collision\""), "it was neither drawn nor had mass: {body}");
    assert!(
        body.contains("class=\"visual\" mesh=\"mirrored\"/>") && body.contains("contype=\"1\" conaffinity=\"1\""),
        "{body}"
    );
    assert_eq!(run(folder.path(), line).expect(0).json()[0]["status"], "fresh");
    let own = run(folder.path(), "robot out/arm.xml --out out --from-visual always --json").expect(0);
    assert_eq!(own.json()[0]["status"], "fresh", "{}", own.stdout);
}

/// Two boxes in one file: one is used as it is, the other in the middle of its frame.
#[test]
fn submeshes_of_sdf_become_hulls_of_their_own() {
    let folder = robots();
    let cube = |name: &str, x: f64, first: usize| {
        let corner = |i: usize| format!("v {} {} {}\n", x + (i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let face = |corners: [usize; 4]| format!("f {}\n", corners.map(|c| (c + first).to_string()).join(" "));
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        format!("o {name}\n{}{}", (0..8).map(corner).collect::<String>(), faces.map(face).concat())
    };
    let both = cube("near", 0.0, 1) + &cube("far away", 10.0, 9);
    fs::write(folder.path().join("in/both.obj"), both).unwrap();
    let mesh = |submesh: &str| {
        format!("<geometry><mesh><uri>both.obj</uri>\n    {submesh}<scale>1 2 1</scale></mesh></geometry>")
    };
    let text = [
        "<sdf version='1.9'><model name='m'><link name='l'>\n <inertial><mass>3</mass></inertial>\n",
        &format!(" <collision name='a'>{}</collision>\n", mesh("<submesh><name>near</name></submesh>")),
        &format!(" <collision name='b'>{}</collision>\n", mesh("<submesh><name>gone</name></submesh>")),
        "</link><link name='k'>\n <inertial><mass>3</mass></inertial>\n",
        &format!(
            " <collision name='c'>{}</collision>\n",
            mesh("<submesh><name>far away</name><center>1</center></submesh>")
        ),
        "</link></model></sdf>\n",
    ]
    .concat();
    fs::write(folder.path().join("in/m.sdf"), &text).unwrap();
    let line = "robot in/m.sdf --out out --inertia --report r.html --json";
    let found = run(folder.path(), line).expect(0);
    let row = &found.json()[0];
    assert_eq!((actions(row), &row["baked"]), (vec!["hull", "kept", "hull"], &Value::from(1)), "one bake for both");
    assert!(found.stderr.contains("no submesh `gone` (it has near, far away)"), "{}", found.stderr);
    let hull = |collision: usize| {
        let name = row["collisions"][collision]["meshes"][0].as_str().unwrap();
        let mesh = fs::read_to_string(folder.path().join("out").join(name)).unwrap();
        let first = |line: &str| -> f64 { line.split(' ').nth(1).unwrap().parse().unwrap() };
        let xs: Vec<f64> = mesh.lines().filter(|line| line.starts_with("v ")).map(first).collect();
        (
            xs.len(),
            xs.iter().copied().fold(f64::INFINITY, f64::min),
            xs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    assert_eq!([hull(0), hull(2)], [(8, 0.0, 1.0), (8, -0.5, 0.5)]);
    let after = fs::read_to_string(folder.path().join("out/m.sdf")).unwrap();
    assert_eq!(after.matches("<submesh>").count(), 1, "{after}");
    let centred = after.split("<link name='k'>").nth(1).unwrap();
    assert!(centred.contains("<pose>0 0 0 0 0 0</pose>") || centred.contains("<pose>-0 "), "{centred}");
    assert_eq!(run(folder.path(), line).expect(0).json()[0]["status"], "fresh");
}

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// A project with these files.
fn project(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join(".git")).unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

/// Vertices and faces in the text: a file beside the hulls, baked like others.
#[test]
fn meshes_in_mjcf_are_baked_like_files() {
    let model = |height: &str| {
        format!(
            "<mujoco><asset>\n<mesh name='a b' vertex='0 0 0 1 0 0 0 1 0 0 0 {height}'/>\n\
             <mesh name='f' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>\n\
             <worldbody><body name='b'><geom type='mesh' mesh='a b'/><geom type='mesh' mesh='f'/></body></worldbody></mujoco>"
        )
    };
    let folder = project(&[("m.xml", &model("1"))]);
    let line = "robot m.xml --out o --decompose --max-error 1mm --json";
    assert_eq!(run(folder.path(), &format!("{line} --check")).expect(1).json()[0]["status"], "missing");
    let found = run(folder.path(), line).expect(0);
    assert_eq!(actions(&found.json()[0]), ["hull", "hull"]);
    let text = fs::read_to_string(folder.path().join("o/m.xml")).unwrap();
    assert!(text.contains("<mesh name='a_b_inline_hull' file=\"m_collision/a_b_inline_hull.obj\"/>"), "{text}");
    assert!(found.stderr.contains("becomes one hull, because its mesh is the hull of points"), "{}", found.stderr);
    assert_eq!(run(folder.path(), line).expect(0).json()[0]["status"], "fresh");
    run(folder.path(), &format!("{line} --check --report r.html")).expect(2);
    run(folder.path(), &format!("{line} --report r.html")).expect(0);
    run(folder.path(), "verify o/m_collision --require-source").expect(0);
    fs::write(folder.path().join("m.xml"), model("2")).unwrap();
    let stale = run(folder.path(), &format!("{line} --check")).expect(1).json().remove(0);
    assert_eq!(stale["status"], "stale");
    assert!(stale["reason"].as_str().unwrap().contains("a_b_inline.obj is not the mesh in the description"), "{stale}");
    run(folder.path(), line).expect(0);
    let hull = fs::read_to_string(folder.path().join("o/m_collision/a_b_inline_hull.obj")).unwrap();
    assert!(hull.contains("v 0 0 2\n"), "{hull}");
}

/// A geom of MJCF states that it does not collide; a link of URDF only has no collision.
#[test]
fn bodies_of_mjcf_that_do_not_collide_stay_so() {
    let text = "<mujoco><asset><mesh file='t.obj'/></asset><default><default class='v'><geom contype='0' conaffinity='0'/></default></default>\
                <worldbody><body name='target' mocap='true'><geom type='mesh' mesh='t' contype='0' conaffinity='0'/></body>\
                <body name='shell'><freejoint/><geom class='v' type='mesh' mesh='t'/></body>\
                <body name='solid'><freejoint/><geom type='mesh' mesh='t'/></body></worldbody></mujoco>";
    let folder = project(&[("m.xml", text), ("t.obj", TETRAHEDRON)]);
    let found = run(folder.path(), "robot m.xml --out o --json").expect(0);
    assert_eq!(actions(&found.json()[0]), ["hull"]);
    let note = "bodies whose geoms do not collide stay so: `target`, `shell`; --from-visual always";
    assert!(found.stderr.contains(note), "{}", found.stderr);
    let always = run(folder.path(), "robot m.xml --out o --from-visual always --json").expect(0);
    assert_eq!(actions(&always.json()[0]), ["hull", "hull", "hull"]);
}

/// The output loads where it lies, or a warning says what will not be found.
#[test]
fn files_that_the_output_needs_are_copied_or_named() {
    let attach = "<mujoco><asset><model name='rob' file='sub/robot.xml'/></asset>\n\
                  <worldbody><frame pos='0 0 1'><attach model='rob' body='r' prefix='x_'/></frame></worldbody></mujoco>";
    let robot = "<mujoco><compiler meshdir='assets'/><include file='more/a.xml'/>\
                 <worldbody><body name='r'><geom type='mesh' mesh='t'/></body></worldbody></mujoco>";
    let part = "<mujocoinclude><asset><mesh name='t' file='t.obj'/></asset></mujocoinclude>";
    let mesh = |name: &str| format!("<geometry><mesh filename='{name}'/></geometry>");
    let arm = format!(
        "<robot name='r'>\n<link name='a'><visual>{0}</visual><collision>{0}</collision></link>\n<link name='b'/>\n\
         <joint name='orphan' type='fixed'><parent link='a'/><child link='none'/></joint>\n\
         <joint name='ab' type='fixed'><parent link='a'/><child link='b'/></joint>\n\
         <joint name='ba' type='fixed'><parent link='b'/><child link='a'/></joint></robot>",
        mesh("package://my-robot/m/t.obj")
    );
    let folder = project(&[
        ("scene.xml", attach),
        ("sub/robot.xml", robot),
        ("sub/more/a.xml", part),
        ("sub/assets/t.obj", TETRAHEDRON),
        ("my-robot/package.xml", "<package><name>my_robot</name></package>"),
        ("my-robot/m/t.obj", TETRAHEDRON),
        ("my-robot/arm.urdf", &arm),
    ]);
    let found = run(folder.path(), "robot scene.xml --out o --json").expect(0);
    assert!(
        found.stderr.contains("the attached model `rob` keeps its collisions; name its file, too"),
        "{}",
        found.stderr
    );
    for file in ["sub/robot.xml", "sub/more/a.xml", "sub/assets/t.obj"] {
        let copy = fs::read(folder.path().join("o").join(file)).unwrap();
        assert_eq!(copy, fs::read(folder.path().join(file)).unwrap());
    }
    let beside = run(folder.path(), "robot my-robot/arm.urdf --out my-robot/hulls.urdf").expect(0);
    for expected in [
        "warning: my-robot/arm.urdf: line 4: joint `orphan`: its parent or child is not a link",
        "warning: my-robot/arm.urdf: line 6: joint `ba`: its child is above its parent, so it closes a loop",
    ] {
        assert!(beside.stderr.contains(expected), "{}", beside.stderr);
    }
    let text = fs::read_to_string(folder.path().join("my-robot/hulls.urdf")).unwrap();
    assert!(text.contains("package://my-robot/hulls_collision/t_hull.obj"), "{text}");
    let lost = "names that lead to no file from";
    assert!(!beside.stderr.contains(lost), "{}", beside.stderr);
    // From another folder of the project, the package is found by its folder; from outside, it is
    // not.
    let above = run(folder.path(), "robot my-robot/arm.urdf --out x").expect(0);
    assert!(!above.stderr.contains(lost), "{}", above.stderr);
    let elsewhere = tempfile::tempdir().unwrap();
    let line = format!("robot my-robot/arm.urdf --out {}", elsewhere.path().display());
    let found = run(folder.path(), &line).expect(0);
    assert!(
        found.stderr.contains(lost) && found.stderr.contains("`package://my-robot/m/t.obj`; write the output into"),
        "{}",
        found.stderr
    );
}
