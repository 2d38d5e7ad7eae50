//! Hulls as collision geometry of a robot or a scene: a document that names one mesh file per hull.
//!
//! | document | root | collision geometry |
//! |---|---|---|
//! | MJCF | `mujoco` | a `mesh` asset and a `geom` each, in one body without joints |
//! | URDF | `robot` | a `collision` each, in one link |
//! | SDF | `sdf` | a `collision` each, in one link of one model |
//!
//! A primitive that may replace a hull is written instead of it. URDF has no capsules.
//!
//! All documents load as they are. Copy the elements from them into a model. The element
//! `inertial` has the mass, so that the simulator does not add the masses of overlapping parts.
//!
//! # Reference
//! MuJoCo, "XML Reference"; ROS, "URDF XML Specification"; Open Robotics, "SDFormat Specification".

use std::f64::consts::FRAC_PI_2;

use glam::DQuat;
use hullmap::PrimitiveKind;
use hullmap_robot::escaped;

use crate::args::export::Target;
use hullmap_pipeline::mesh_file::body::{BodyPrimitive, Inertial};
use hullmap_pipeline::mesh_file::seal::SEAL;

#[derive(Clone, Debug)]
pub enum Geometry {
    Mesh(String),
    Primitive(BodyPrimitive),
}

pub fn can_hold(target: Option<Target>, kind: PrimitiveKind) -> bool {
    match target {
        Some(Target::Mjcf | Target::Sdf) => true,
        Some(Target::Urdf) => kind != PrimitiveKind::Capsule,
        _ => false,
    }
}

/// Angles about the fixed axes x, y and z: roll, pitch and yaw (Diebel, "Representing attitude",
/// 2006, section 5.8).
fn roll_pitch_yaw(rotation: DQuat) -> [f64; 3] {
    let [x, y, z, w] = rotation.normalize().to_array();
    let sine = 2.0 * (w * y - z * x);
    if sine.abs() >= 1.0 - 1e-12 {
        // Pitch of a right angle: roll and yaw turn about one axis, so one of them is enough.
        return [2.0 * x.atan2(w), FRAC_PI_2.copysign(sine), 0.0];
    }
    let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
    [roll, sine.asin(), (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))]
}

fn spaced(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

#[derive(Debug)]
pub struct Robot<'a> {
    pub name: &'a str,
    pub prefix: &'a str,
    pub colliders: &'a [(String, Geometry)],
    pub inertial: Option<Inertial>,
}

impl Robot<'_> {
    pub fn mjcf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let mut text = format!("<!-- {SEAL} -->\n<mujoco model=\"{name}\">\n  <asset>\n");
        for (mesh, geometry) in self.colliders {
            let Geometry::Mesh(file) = geometry else { continue };
            let (mesh, file) = (escaped(mesh), escaped(file));
            text += &format!("    <mesh name=\"{mesh}\" file=\"{prefix}{file}\"/>\n");
        }
        text += &format!("  </asset>\n  <worldbody>\n    <body name=\"{name}\">\n");
        if let Some(Inertial { mass, center: [x, y, z], inertia: [[xx, xy, xz], [_, yy, yz], [.., zz]] }) =
            self.inertial
        {
            text += &format!("      <inertial pos=\"{x} {y} {z}\" mass=\"{mass}\"");
            text += &format!(" fullinertia=\"{xx} {yy} {zz} {xy} {xz} {yz}\"/>\n");
        }
        for (name, geometry) in self.colliders {
            let name = escaped(name);
            text += &match geometry {
                Geometry::Mesh(_) => format!("      <geom name=\"{name}\" type=\"mesh\" mesh=\"{name}\"/>\n"),
                Geometry::Primitive(primitive) => {
                    let sizes = spaced(&primitive.sizes[..primitive.kind.size_count()]);
                    let [x, y, z, w] = primitive.rotation;
                    let (kind, pos, quat) = (primitive.kind, spaced(&primitive.center), spaced(&[w, x, y, z]));
                    format!(
                        "      <geom name=\"{name}\" type=\"{kind}\" size=\"{sizes}\" pos=\"{pos}\" quat=\"{quat}\"/>\n"
                    )
                }
            };
        }
        text + "    </body>\n  </worldbody>\n</mujoco>\n"
    }

    pub fn urdf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let mut text =
            format!("<?xml version=\"1.0\"?>\n<!-- {SEAL} -->\n<robot name=\"{name}\">\n  <link name=\"{name}\">\n");
        if let Some(Inertial { mass, center: [x, y, z], inertia: [[xx, xy, xz], [_, yy, yz], [.., zz]] }) =
            self.inertial
        {
            text += &format!("    <inertial>\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n");
            text += &format!("      <mass value=\"{mass}\"/>\n      <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\"");
            text += &format!(" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n");
        }
        for (mesh, geometry) in self.colliders {
            text += &format!("    <collision name=\"{}\">\n", escaped(mesh));
            let shape = match geometry {
                Geometry::Mesh(file) => format!("<mesh filename=\"{prefix}{}\"/>", escaped(file)),
                Geometry::Primitive(primitive) => {
                    let (xyz, rpy) = (spaced(&primitive.center), spaced(&roll_pitch_yaw(primitive.turn())));
                    text += &format!("      <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\n");
                    let [a, b, _] = primitive.sizes;
                    match primitive.kind {
                        PrimitiveKind::Box => format!("<box size=\"{}\"/>", spaced(&primitive.sizes.map(|x| 2.0 * x))),
                        PrimitiveKind::Sphere => format!("<sphere radius=\"{a}\"/>"),
                        kind => format!("<{kind} radius=\"{a}\" length=\"{}\"/>", 2.0 * b),
                    }
                }
            };
            text += &format!("      <geometry>\n        {shape}\n      </geometry>\n    </collision>\n");
        }
        text + "  </link>\n</robot>\n"
    }
}

impl Robot<'_> {
    pub fn sdf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let is_capsule = |(_, geometry): &(String, Geometry)| {
            matches!(geometry, Geometry::Primitive(BodyPrimitive { kind: PrimitiveKind::Capsule, .. }))
        };
        // Capsules came with version 1.8.
        let version = if self.colliders.iter().any(is_capsule) { "1.8" } else { "1.7" };
        let mut text = format!("<?xml version=\"1.0\"?>\n<!-- {SEAL} -->\n<sdf version=\"{version}\">\n");
        text += &format!("  <model name=\"{name}\">\n    <link name=\"{name}\">\n");
        if let Some(Inertial { mass, center: [x, y, z], inertia: [[xx, xy, xz], [_, yy, yz], [.., zz]] }) =
            self.inertial
        {
            text += &format!("      <inertial>\n        <pose>{x} {y} {z} 0 0 0</pose>\n        <mass>{mass}</mass>\n");
            text += "        <inertia>\n";
            for (entry, value) in [("ixx", xx), ("ixy", xy), ("ixz", xz), ("iyy", yy), ("iyz", yz), ("izz", zz)] {
                text += &format!("          <{entry}>{value}</{entry}>\n");
            }
            text += "        </inertia>\n      </inertial>\n";
        }
        for (mesh, geometry) in self.colliders {
            text += &format!("      <collision name=\"{}\">\n", escaped(mesh));
            let shape = match geometry {
                Geometry::Mesh(file) => format!("<mesh><uri>{prefix}{}</uri></mesh>", escaped(file)),
                Geometry::Primitive(primitive) => {
                    let (xyz, rpy) = (spaced(&primitive.center), spaced(&roll_pitch_yaw(primitive.turn())));
                    text += &format!("        <pose>{xyz} {rpy}</pose>\n");
                    let [a, b, _] = primitive.sizes;
                    match primitive.kind {
                        PrimitiveKind::Box => {
                            format!("<box><size>{}</size></box>", spaced(&primitive.sizes.map(|x| 2.0 * x)))
                        }
                        PrimitiveKind::Sphere => format!("<sphere><radius>{a}</radius></sphere>"),
                        kind => format!("<{kind}><radius>{a}</radius><length>{}</length></{kind}>", 2.0 * b),
                    }
                }
            };
            text += &format!("        <geometry>\n          {shape}\n        </geometry>\n      </collision>\n");
        }
        text + "    </link>\n  </model>\n</sdf>\n"
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    #[test]
    fn angles_give_the_rotation() {
        let axis = |k: usize| DVec3::new(1.0, 0.3 * k as f64 - 2.0, (k * k % 7) as f64 - 3.0).normalize();
        let right = [1.0, -1.0].map(|sign| DQuat::from_rotation_y(sign * FRAC_PI_2));
        let turns = (0..40).map(|k| DQuat::from_axis_angle(axis(k), 0.37 * k as f64));
        for rotation in turns.chain(right).chain(right.map(|right| DQuat::from_rotation_z(0.7) * right)) {
            let [roll, pitch, yaw] = roll_pitch_yaw(rotation);
            let found = DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
            assert!(found.abs_diff_eq(DMat3::from_quat(rotation), 1e-6), "{rotation} {roll} {pitch} {yaw}");
        }
    }

    #[test]
    fn names_stay_in_their_attributes() {
        let colliders = [("a\"/><evil x='\n".to_owned(), Geometry::Mesh("a&b.obj".to_owned()))];
        let robot = Robot { name: "r<1>", prefix: "package://p/", colliders: &colliders, inertial: None };
        for text in [robot.mjcf(), robot.urdf(), robot.sdf()] {
            assert!(!text.contains("<evil") && text.contains("package://p/a&amp;b.obj"), "{text}");
            assert!(text.contains("\"r&lt;1&gt;\"") && text.contains("\"a&quot;/&gt;&lt;evil x=&apos;_\""), "{text}");
        }
    }
}
