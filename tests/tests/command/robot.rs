//! `bake robot`: inertia, protrusion and reports, compared with closed forms.

use std::fs;

use hullmap_planning::{Packs, Robot, Skipped};
use hullmap_robot::Places;
use hullmap_testkit::command::bake_line as run;
use hullmap_testkit::files::workspace;
use serde_json::{Value, json};

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

/// A planner that reads the output leaves out the same, apart from numbers of lines.
#[test]
fn skipped_is_what_a_planner_skips_in_the_output() {
    let folder = robots();
    let line = "in/crowd.urdf in/crowd.xml in/arm.urdf in/arm.xml in/arm.sdf --out out --json --from-visual";
    let mut count = 0;
    for visuals in ["missing", "always", "never"] {
        for row in run(folder.path(), &format!("robot {line} {visuals}")).expect(0).json() {
            let output = folder.path().join(row["output"].as_str().unwrap());
            let robot = Robot::read(&output, &Places::beside(&output).unwrap(), &mut Packs::default()).unwrap();
            let text = |value: Value| value.to_string().replace(|c: char| c.is_ascii_digit(), "");
            let rows = robot.skipped().into_iter().map(Skipped::row);
            let expected = rows.map(|(links, geoms, reason)| json!({"links": links, "geoms": geoms, "reason": reason}));
            assert_eq!(text(row["skipped"].clone()), text(expected.collect()), "{output:?} {visuals}");
            count += robot.skipped().len();
        }
    }
    assert!(count > 30, "the sample is not representative: {count}");
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
