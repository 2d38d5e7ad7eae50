//! Joints of each format, against poses that were computed by hand.

use std::f64::consts::FRAC_PI_2;

use hullmap_robot::glam::DVec3;
use hullmap_robot::{Description, Displacement, Geometry, Motion, NamedPrimitive, Primitive};

fn read(text: &str) -> Description {
    let (_guard, root) = super::folder(&[("robot.xml", text)]);
    super::read(&root, "robot.xml").unwrap()
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
    let robot = read(include_str!("files/chain.urdf"));
    let joints = &robot.chain.joints;
    assert_eq!([joints.len(), robot.chain.warnings.len()], [2, 3], "{:?}", robot.chain.warnings);
    for warning in [
        "line 11: joint `da`: its child is above its parent, so it closes a loop",
        "line 13: joint `ac`: its child has another joint already, so it closes a loop",
    ] {
        assert!(robot.chain.warnings.iter().any(|own| own.starts_with(warning)), "{:?}", robot.chain.warnings);
    }
    assert_eq!((joints[0].limits, joints[0].neutral), (Some([0.5, 1.5]), 1.0));
    assert_near(point(&robot, "d", [0.0; 3], &[0.0]), [1.0, 1.25, 3.0]);
    assert_near(point(&robot, "d", [0.0, 1.0, 0.0], &[FRAC_PI_2]), [-0.25 - 2.0 * FRAC_PI_2, -1.0, 3.0]);
}

#[test]
fn mjcf() {
    let robot = read(include_str!("files/chain.xml"));
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
    let robot = read(include_str!("files/chain.sdf"));
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
