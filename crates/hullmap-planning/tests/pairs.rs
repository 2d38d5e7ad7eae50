//! Which pairs are tested, which are not, and why: for each rule of each format.

mod described;

use std::f64::consts::PI;

use described::{file, robot};
use hullmap::Verdict;
use hullmap_planning::glam::DVec3;
use hullmap_planning::{EdgeSettings, PlanningError, Robot, Skipped};

const RIGID: &str = "rigidly connected";
const ADJACENT: &str = "adjacent: connected by a joint";
const IMMOBILE: &str = "neither body has degrees of freedom";
const MASKS: &str = "`contype` and `conaffinity` do not match";

/// The pairs that are tested, and the skipped ones with their reasons, by initials of links.
fn pairs(robot: &Robot) -> [String; 2] {
    let tested = robot.tested();
    let tested: Vec<String> =
        tested.iter().map(|pair| pair.map(|index| robot.collider(index).unwrap()).concat()).collect();
    let skipped = robot.skipped().into_iter().map(|skipped| match skipped {
        Skipped::Pair { links, geoms: None, reason } => format!("{}: {reason}", links.concat()),
        other => other.to_string(),
    });
    [tested.join(" "), skipped.collect::<Vec<_>>().join("; ")]
}

/// An MJCF model: `b` is a body with a ball, `j` a joint.
fn mjcf(bodies: &str, others: &str) -> String {
    let bodies = bodies
        .replace("<b ", "<body name=")
        .replace("</b>", "</body>")
        .replace("<j/>", "<joint type='slide' axis='1 0 0'/>");
    let bodies = bodies.replace("<g", "<geom size='1'");
    format!("<mujoco>{others}<worldbody>{bodies}</worldbody></mujoco>")
}

#[test]
fn mujoco_decides_in_mjcf() {
    let chain = "<b 'a'><j/><g/><b 'b'><g/><b 'c'><j/><g/><b 'd'><j/><g/></b></b></b></b>";
    let two = "<b 'a'><j/><g name='x'/></b><b 'b'><j/><g name='y'/></b>";
    let table: &[(String, &str, String)] = &[
        // Parent and child, where rigidly connected bodies count as one: `b` is a part of `a`.
        (mjcf(chain, ""), "ad bd", format!("ab: {RIGID}; ac: {ADJACENT}; bc: {ADJACENT}; cd: {ADJACENT}")),
        (mjcf(chain, "<option><flag filterparent='disable'/></option>"), "ac ad bc bd cd", format!("ab: {RIGID}")),
        // The world, and what is connected to it, are no parent.
        (
            mjcf("<g/><b 'a'><g/><b 'b'><j/><g/></b></b><b 'c'><j/><g/></b>", ""),
            "worldb worldc ab ac bc",
            format!("worlda: {RIGID}"),
        ),
        // A mocap body is no part of the world, and a parent. It has no degrees of freedom.
        (
            mjcf("<g/><b 'm' mocap='true'><g/><b 'n'><g/></b><b 'c'><j/><g/></b></b><b 'd'><j/><g/></b>", ""),
            "worldc worldd md nd cd",
            format!("worldm: {IMMOBILE}; worldn: {IMMOBILE}; mn: {RIGID}; mc: {ADJACENT}; nc: {ADJACENT}"),
        ),
        // All worlds are one.
        (
            mjcf("<g/></worldbody><worldbody><b 'a'><g/></b><b 'b'><j/><g/></b>", ""),
            "worldb ab",
            format!("worlda: {RIGID}"),
        ),
        (mjcf(two, "<contact><exclude body1='b' body2='a'/></contact>"), "", "ab: excluded by `exclude`".to_owned()),
        // A pair of geoms overrides masks, `exclude`, parents, and even rigid connections.
        (
            mjcf(two, "<contact><exclude body1='b' body2='a'/><pair geom1='y' geom2='x'/></contact>"),
            "ab",
            String::new(),
        ),
        (
            mjcf(
                "<b 'a'><j/><g name='x' contype='0' conaffinity='0'/><b 'b'><j/><g name='y' contype='0' conaffinity='0'/></b></b>",
                "<sensor><distance geom1='x' geom2='y'/></sensor><contact><pair geom1='x' geom2='y'/></contact>",
            ),
            "ab",
            String::new(),
        ),
        (
            mjcf("<b 'a'><j/><g name='x'/><g name='y'/></b>", "<contact><pair geom1='x' geom2='y'/></contact>"),
            "aa",
            String::new(),
        ),
        // Masks, for all geoms and for some.
        (
            mjcf("<b 'a'><j/><g contype='2' conaffinity='4'/></b><b 'b'><j/><g contype='2' conaffinity='8'/></b>", ""),
            "",
            format!("ab: {MASKS}"),
        ),
        (
            mjcf(
                "<b 'a'><j/><g name='x' conaffinity='0'/></b><b 'b'><j/><g name='y' conaffinity='0'/><g name='z'/></b>",
                "",
            ),
            "ab",
            format!("`x` of `a` and `y` of `b`: {MASKS}"),
        ),
        (
            mjcf(two, "<option><flag contact='disable'/></option><contact><pair geom1='x' geom2='y'/></contact>"),
            "",
            "ab: contacts are disabled by `flag`".to_owned(),
        ),
        (
            mjcf(
                two,
                "<option><flag contact='disable'/></option><option><flag contact='enable' energy='enable'/></option>",
            ),
            "ab",
            String::new(),
        ),
        // Unnamed bodies of one line.
        (mjcf("<body><j/><g/></body><body><j/><g/></body>", ""), "body in line 1body 2 in line 1", String::new()),
    ];
    for (text, tested, skipped) in table {
        assert_eq!(pairs(&robot("r.xml", text)), [*tested, skipped], "{text}");
    }
}

/// A URDF link with a box at its origin, or the joint `kind` between two.
fn link(name: &str, size: &str) -> String {
    format!("<link name='{name}'><collision name='{name}'><geometry><box size='{size}'/></geometry></collision></link>")
}

fn joint(kind: &str, [parent, child]: [&str; 2], at: &str) -> String {
    format!(
        "<joint name='{parent}{child}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
         <origin xyz='{at}'/><axis xyz='1 0 0'/><limit lower='-4' upper='4'/></joint>"
    )
}

#[test]
fn only_direct_neighbours_are_left_out_of_urdf() {
    // A carriage on a rail drives into a table; both are fixed to the world.
    let cell = [
        "<robot name='r'><link name='w'/>",
        &link("t", "0.4 0.4 0.4"),
        "<link name='r'/>",
        &link("c", "0.2 0.2 0.2"),
        &link("o", "0.1 0.1 0.1"),
        &joint("fixed", ["w", "t"], "1 0 0"),
        &joint("fixed", ["w", "r"], "0 0 0"),
        &joint("prismatic", ["r", "c"], "0 0 0"),
        &joint("floating", ["t", "o"], "0 0 1"),
        "</robot>",
    ];
    let cell = robot("cell.urdf", &cell.concat());
    assert_eq!(pairs(&cell), ["tc co", &format!("to: {ADJACENT}")]);
    let mut memory = cell.memory();
    let hit = |x: f64, memory: &mut _| cell.in_collision(&[x], 0.0, memory).unwrap();
    assert_eq!([0.0, 0.5, 0.6, 0.75, 1.0].map(|x| hit(x, &mut memory)), [false, false, false, true, true]);
    let edge = cell.clear(&[0.0], &[1.5], &EdgeSettings::default(), &mut memory).unwrap();
    assert_eq!(edge.answer.verdict, Verdict::Hit);
    assert!(edge.answer.t_lower <= 0.7 / 1.5 && 0.7 / 1.5 <= edge.answer.t_upper);
    // A tool that is fixed to a flange folds into the arm.
    let arm = [
        "<robot name='r'>",
        &link("a", "2 0.1 0.1"),
        &link("f", "0.1 0.1 0.1"),
        &link("t", "0.1 0.1 0.3"),
        &joint("revolute", ["a", "f"], "0 0 0.3"),
        &joint("fixed", ["f", "t"], "0 0 0.2"),
        "</robot>",
    ];
    let arm = robot("arm.urdf", &arm.concat());
    assert_eq!(pairs(&arm), ["at", &format!("af: {ADJACENT}; ft: {RIGID}")]);
    let mut memory = arm.memory();
    assert_eq!([0.0, PI].map(|q| arm.in_collision(&[q], 0.0, &mut memory).unwrap()), [false, true]);
    let poses = arm.link_poses(&[PI], &mut memory).unwrap();
    assert!((poses[2].translation() - DVec3::new(0.0, 0.0, 0.1)).length() < 1e-15, "{poses:?}");
    assert!(arm.in_collision_at(&poses, 0.0, &mut memory).unwrap());
}

/// `c` and `d` are one rigid body, but only `d` is joined to `f`, in a nested model. Joints to the
/// world make no neighbours.
#[test]
fn only_direct_neighbours_are_left_out_of_sdf() {
    let link = |name: &str| {
        let ball = "<geometry><sphere><radius>1</radius></sphere></geometry>";
        format!("<link name='{name}'><collision name='{name}'>{ball}</collision></link>")
    };
    let joint = |kind: &str, parent: &str, child: &str| {
        let ends = format!("<parent>{parent}</parent><child>{child}</child><axis><xyz>0 0 1</xyz></axis>");
        format!("<joint name='{parent}{child}' type='{kind}'>{ends}</joint>").replacen("::", "_", 1)
    };
    for self_collide in ["", "<self_collide>true</self_collide>", "<self_collide>false</self_collide>"] {
        let model = ["a", "b", "c", "d", "e", "g"].map(link).concat()
            + &format!("<model name='n'>{}</model>", link("f"))
            + &joint("revolute", "a", "b")
            + &joint("prismatic", "b", "c")
            + &joint("fixed", "c", "d")
            + &joint("ball", "d", "n::f")
            + &joint("prismatic", "world", "e")
            + &joint("fixed", "world", "g");
        let own = robot("m.sdf", &format!("<sdf version='1.9'><model name='m'>{self_collide}{model}</model></sdf>"));
        let [tested, skipped] = pairs(&own).map(|text| text.replace("m::", "").replace("n::", ""));
        assert_eq!(tested, "ac ad ae ag af bd be bg bf ce cg cf de dg eg ef gf");
        assert_eq!(skipped, format!("ab: {ADJACENT}; bc: {ADJACENT}; cd: {RIGID}; df: {ADJACENT}"));
    }
}

#[test]
fn the_matrix_overrides_the_filter() {
    let text = mjcf("<b 'a'><j/><g contype='0'/><b 'b'><j/><g/><b 'c'><g/></b></b></b>", "");
    let mut own = robot("r.xml", &text);
    assert_eq!(pairs(&own), ["", &format!("ab: {ADJACENT}; ac: {ADJACENT}; bc: {RIGID}")]);
    own.disallow([["b", "a"], ["c", "b"], ["a", "a"]]).unwrap();
    assert_eq!(pairs(&own), ["ab bc", &format!("ac: {ADJACENT}")]);
    // Rigidly connected links always meet, or never.
    let mut memory = own.memory();
    assert!(own.in_collision(&[0.0, 1.0], 0.0, &mut memory).unwrap());
    assert_eq!(own.touching(&[0.0, 1.0], &mut memory).unwrap(), own.tested());
    assert_eq!(own.touching(&[0.0, 9.0], &mut memory).unwrap(), [[2, 3]]);
    let edge = own.clear(&[0.0, 0.0], &[1.0, 1.0], &EdgeSettings::default(), &mut memory).unwrap();
    assert_eq!(edge.answer.verdict, Verdict::Hit);
    own.allow([["b", "a"], ["c", "a"]]).unwrap();
    assert_eq!(pairs(&own), ["bc", "ab: allowed; ac: allowed"]);
    assert!(matches!(own.disallow([["a", "z"]]), Err(PlanningError::UnknownName { .. })));
    let (_guard, srdf) = file(
        "r.srdf",
        "<robot><disable_default_collisions link='b'/><enable_collisions link1='b' link2='a'/>
          <disable_collisions link1='x' link2='a'/></robot>",
    );
    own.allow_srdf(&srdf).unwrap();
    assert_eq!(pairs(&own), ["ab", "ac: allowed; bc: allowed"]);
}

#[test]
fn untested_geometry_is_listed_and_an_error_if_strict() {
    let sdf =
        "<sdf version='1.9'><model name='m'><link name='a'/>\n<include><uri>model://grip</uri></include></model></sdf>";
    let world = "<mujoco><worldbody>\n<geom name='floor' type='plane' size='1 1 1'/><body><joint/><geom size='1'/>\n\
                 <replicate count='2'><geom size='1'/></replicate></body>\n<attach model='m' body='b' prefix='p'/></worldbody>\n\
                 <contact><pair geom1='floor' geom2='pb'/></contact></mujoco>";
    let off = mjcf("<b 'a'><j/><g/></b>", "<option><flag constraint='disable'/></option>");
    for (name, text, expected) in [
        (
            "m.sdf",
            sdf,
            &[
                "line 2: the included model `model://grip` is not tested: it is another file; write its links into this one",
            ][..],
        ),
        (
            "w.xml",
            world,
            &[
                "link `world`, line 2: not tested: `plane` is not a mesh",
                "line 3: `replicate` is not tested: only its first copy is read",
                "line 4: `attach` is not tested: it is not read; write its bodies into this model",
                "line 5: `pair` is not tested: it names a geom that is not read",
            ],
        ),
        ("off.xml", &off, &[]),
    ] {
        let own = robot(name, text);
        let geometry = own.skipped().into_iter().filter(|skipped| matches!(skipped, Skipped::Geometry { .. }));
        assert_eq!(geometry.map(|skipped| skipped.to_string()).collect::<Vec<_>>(), expected);
        assert!(expected.iter().all(|line| own.notes.iter().any(|note| note == line)), "{:?}", own.notes);
        let error = own.strict().err().unwrap().to_string();
        let cause = expected.first().copied().unwrap_or("contacts are disabled by `flag`");
        assert!(error.contains(name) && error.contains(cause), "{error}");
    }
    assert!(robot("r.xml", &mjcf("<b 'a'><j/><g/></b>", "")).strict().is_ok());
}
