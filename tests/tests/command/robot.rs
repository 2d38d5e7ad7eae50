//! `bake robot` and planners.

use std::fs;

use hullmap_planning::{Packs, Robot, Skipped};
use hullmap_robot::Places;
use hullmap_testkit::command::bake_line as run;
use hullmap_testkit::files::{contents, workspace, write};
use serde_json::{Value, json};

/// A planner that reads the output leaves out the same, apart from numbers of lines.
#[test]
fn skipped_is_what_a_planner_skips_in_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let robots = contents(&workspace().join("tests/robots"));
    robots.iter().for_each(|(name, bytes)| write(&folder, &format!("in/{name}"), bytes));
    fs::create_dir(folder.path().join(".git")).unwrap();
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
