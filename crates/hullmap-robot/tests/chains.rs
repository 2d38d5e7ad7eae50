//! Joints of each format, against poses that were computed by hand.

use std::f64::consts::FRAC_PI_2;

use hullmap_robot::glam::DVec3;
use hullmap_robot::{Description, Displacement, Geometry, Motion, NamedPrimitive, Places, Primitive};

fn read(text: &str) -> Description {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.xml");
    std::fs::write(&file, text).unwrap();
    Description::read(&file, &Places::default()).unwrap()
}

/// Position of a point of a link, for displacements of the joints that follow no other.
fn point(robot: &Description, link: &str, at: [f64; 3], displacements: &[f64]) -> DVec3 {
    let mut all: Vec<Displacement> = displacements.iter().copied().map(Displacement::Scalar).collect();
    all.resize(robot.chain.joints.len(), Displacement::Scalar(0.0));
    robot.chain.follow(&mut all);
    let index = robot.links.iter().position(|own| own.name == link).unwrap();
    robot.chain.poses(&all)[index].apply(DVec3::from_array(at))
}

#[track_caller]
fn assert_near(found: DVec3, expected: [f64; 3]) {
    assert!(found.abs_diff_eq(DVec3::from_array(expected), 1e-12), "{found} {expected:?}");
}

#[test]
fn urdf() {
    let link = |name: &str| format!("<link name='{name}'/>\n");
    let text = [
        "<robot name='r'>",
        &["a", "b", "c", "d"].map(link).concat(),
        "<joint name='ab' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/>\
         <axis xyz='0 0 2'/><limit lower='0.5' upper='1.5'/></joint>\n",
        "<joint name='bc' type='prismatic'><parent link='b'/><child link='c'/><origin xyz='1 0 0'/>\
         <limit lower='-1' upper='1'/><mimic joint='ab' multiplier='2' offset='0.25'/></joint>\n",
        "<joint name='cd' type='fixed'><parent link='c'/><child link='d'/><origin xyz='0 0 3'/></joint>\n",
        "<joint name='da' type='fixed'><parent link='d'/><child link='a'/></joint>\n",
        "<joint name='x' type='fixed'><parent link='d'/><child link='none'/></joint>\n",
        "<joint name='ac' type='fixed'><parent link='a'/><child link='c'/></joint>\n",
        "<transmission name='t'><joint name='ab'/></transmission></robot>",
    ]
    .concat();
    let robot = read(&text);
    let joints = &robot.chain.joints;
    assert_eq!([joints.len(), robot.chain.warnings.len()], [2, 3], "{:?}", robot.chain.warnings);
    for warning in [
        "line 8: joint `da`: its child is above its parent, so it closes a loop",
        "line 10: joint `ac`: its child has another joint already, so it closes a loop",
    ] {
        assert!(robot.chain.warnings.iter().any(|own| own.starts_with(warning)), "{:?}", robot.chain.warnings);
    }
    assert_eq!((joints[0].limits, joints[0].neutral), (Some([0.5, 1.5]), 1.0));
    assert_near(point(&robot, "d", [0.0; 3], &[0.0]), [1.0, 1.25, 3.0]);
    assert_near(point(&robot, "d", [0.0, 1.0, 0.0], &[FRAC_PI_2]), [-0.25 - 2.0 * FRAC_PI_2, -1.0, 3.0]);
}

#[test]
fn mjcf() {
    let robot = read(
        "<mujoco><compiler angle='degree' eulerseq='XYZ'/>
         <default><joint axis='0 1 0'/><default class='far'><joint pos='0 0 1' range='-90 90'/>
          <geom type='capsule' size='0.1'/></default></default>
         <worldbody><body name='a' pos='1 0 0' euler='0 0 90'><freejoint name='f'/>
          <body name='b' pos='1 0 0' childclass='far'><joint name='j' ref='90'/><joint name='s' type='slide' axis='1 0 0'/>
           <geom fromto='0 0 -1 0 0 3'/>
           <frame pos='0 1 0' axisangle='0 0 1 90'><geom type='box' size='1 2 3' pos='1 0 0'/>
            <body name='c' pos='1 0 0'><joint name='k' type='ball' range='0 30'/></body></frame>
          </body></body></worldbody>
         <equality><joint joint1='s' joint2='j' polycoef='0.5 0 2'/></equality></mujoco>",
    );
    let joints = &robot.chain.joints;
    assert_eq!(
        joints.iter().map(|own| own.motion).collect::<Vec<_>>(),
        [Motion::Free, Motion::Hinge, Motion::Slide, Motion::Ball]
    );
    let quarter = FRAC_PI_2;
    assert_eq!((joints[1].limits, joints[1].reference), (Some([-quarter, quarter]), quarter));
    assert!((joints[3].limits.unwrap()[1] - 30_f64.to_radians()).abs() < 1e-15);
    assert!(robot.chain.links[0].is_world && robot.chain.notes.is_empty());
    // About y through (0, 0, 1): the origin goes to (-1, 0, 1), then slides along x, which is -z.
    let slide = 0.5 + 2.0 * quarter * quarter;
    let at = point(&robot, "b", [0.0; 3], &[0.0, quarter]);
    // The frame of a: y of the world is its x, and -x its y.
    assert_near(at, [1.0, 1.0 - 1.0, 1.0 - slide]);
    assert_near(point(&robot, "c", [0.0; 3], &[0.0, 0.0]), [1.0 - 2.0, 1.0 + 0.5, 0.0]);
    let shapes = &robot.links[2].collisions;
    let primitive = |at: usize| match &shapes[at].geometry {
        Geometry::Primitive(NamedPrimitive { shape, .. }) => shape.unwrap(),
        other => panic!("{other:?}"),
    };
    assert_eq!([primitive(0), primitive(1)], [Primitive::Capsule([0.1, 2.0]), Primitive::Box([1.0, 2.0, 3.0])]);
    assert_near(shapes[0].pose.unwrap().translation, [0.0, 0.0, 1.0]);
    assert_near(shapes[1].pose.unwrap().translation, [0.0, 2.0, 0.0]);
}

#[test]
fn sdf() {
    let robot = read(
        "<sdf version='1.11'><world name='w'><model name='m'><pose>10 0 0 0 0 0</pose>
         <frame name='f' attached_to='a'><pose degrees='true'>0 1 0 0 0 90</pose></frame>
         <link name='a'><pose>0 0 1 0 0 0</pose></link>
         <link name='b'><pose relative_to='f'>1 0 0 0 0 0</pose></link>
         <joint name='j' type='revolute'><parent>a</parent><child>f2</child><pose>0 0 0.5 0 0 0</pose>
          <axis><xyz expressed_in='__model__'>1 0 0</xyz><limit><lower>-1e16</lower><upper>1</upper></limit></axis></joint>
         <frame name='f2' attached_to='b'/>
         <model name='n'><pose>0 0 5 0 0 0</pose><link name='c'/>
          <joint name='k' type='prismatic'><parent>world</parent><child>c</child><axis><xyz>0 0 1</xyz>
           <mimic joint='none'/></axis></joint></model>
         <joint name='i' type='universal'><parent>b</parent><child>n::c</child>
          <axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz><mimic joint='j' axis='axis'><multiplier>2</multiplier>
          <reference>0.5</reference><offset>1</offset></mimic></axis2></joint>
         <joint name='bad' type='fixed'><parent>c</parent><child>zzz</child></joint>
         <joint name='up' type='fixed'><parent>b</parent><child>a</child></joint>
         <joint name='again' type='fixed'><parent>a</parent><child>b</child></joint>
         <joint name='lone' type='fixed'><parent>zzz</parent><child>a</child></joint>
         </model></world></sdf>",
    );
    assert_near(point(&robot, "m::b", [0.0; 3], &[0.0]), [10.0, 2.0, 1.0]);
    // About x of the model, half a metre above b.
    assert_near(point(&robot, "m::b", [0.0; 3], &[FRAC_PI_2]), [10.0, 2.5, 1.5]);
    let names: Vec<&str> = robot.chain.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["j", "i", "i axis2", "k"]);
    assert!(robot.chain.joints[0].limits.is_none());
    assert_eq!(robot.chain.joints[2].coupling.unwrap().follow(0.0), 0.0);
    assert_eq!(robot.chain.joints[2].coupling.unwrap().follow(1.0), 2.0);
    let notes = robot.chain.warnings.join("\n");
    for note in [
        "joint `bad`: its child is not a link",
        "joint `up`: its child is above its parent, so it closes a loop",
        "joint `again`: its child has another joint already, so it closes a loop",
        "joint `lone`: its parent is not a link",
        "names no joint that moves",
    ] {
        assert!(notes.contains(note), "{notes}");
    }
}

/// Frames in nested models that refer to each other must not take exponential time.
#[test]
fn hostile_frames_end() {
    let mut text = "<sdf version='1.9'><model name='m'>".to_owned();
    for level in 0..90 {
        let next = level + 1;
        text +=
            &format!("<model name='n{level}'><pose relative_to='n{next}::f'/><frame name='f'><pose/></frame></model>");
    }
    text += "<model name='n90'><frame name='f'/></model><link name='l'><pose relative_to='n0::f'/></link>";
    text += "<frame name='x' attached_to='y'/><frame name='y' attached_to='x'/><link name='k'><pose relative_to='x'/></link>";
    let robot = read(&(text + "</model></sdf>"));
    assert_eq!(robot.chain.warnings.len(), 1, "{:?}", robot.chain.warnings);
}
