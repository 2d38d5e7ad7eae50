//! Hulls as collision geometry of a robot or a scene: a document that names one mesh file per hull.
//!
//! | document | root | collision geometry |
//! |---|---|---|
//! | MJCF | `mujoco` | a `mesh` asset and a `geom` each, in one body without joints |
//! | URDF | `robot` | a `collision` each, in one link |
//! | SDF | `sdf` | a `collision` each, in one link of one model |
//!
//! All documents load as they are. Copy the elements from them into a model. The element
//! `inertial` has the mass, so that the simulator does not add the masses of overlapping parts.
//!
//! # Reference
//! MuJoCo, "XML Reference", elements `mesh`, `geom` and `inertial`; ROS, "URDF XML Specification",
//! elements `collision` and `inertial`; Open Robotics, "SDFormat Specification", elements `link`,
//! `inertial` and `collision`.

use hullmap_robot::escaped;

use crate::mesh_file::body::Inertial;

/// Collision meshes of one body.
#[derive(Debug)]
pub struct Robot<'a> {
    /// Name of the body or the link.
    pub name: &'a str,
    /// Prefix of file names, for instance `package://robot/meshes/`.
    pub prefix: &'a str,
    /// Name and file of each hull.
    pub meshes: &'a [(String, String)],
    /// Mass of the body; `None` if it has none.
    pub inertial: Option<Inertial>,
}

impl Robot<'_> {
    /// The MJCF document.
    pub fn mjcf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let mut text = format!("<mujoco model=\"{name}\">\n  <asset>\n");
        for (mesh, file) in self.meshes {
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
        for (mesh, _) in self.meshes {
            let mesh = escaped(mesh);
            text += &format!("      <geom name=\"{mesh}\" type=\"mesh\" mesh=\"{mesh}\"/>\n");
        }
        text + "    </body>\n  </worldbody>\n</mujoco>\n"
    }

    /// The URDF document.
    pub fn urdf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{name}\">\n  <link name=\"{name}\">\n");
        if let Some(Inertial { mass, center: [x, y, z], inertia: [[xx, xy, xz], [_, yy, yz], [.., zz]] }) =
            self.inertial
        {
            text += &format!("    <inertial>\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n");
            text += &format!("      <mass value=\"{mass}\"/>\n      <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\"");
            text += &format!(" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n");
        }
        for (mesh, file) in self.meshes {
            let (mesh, file) = (escaped(mesh), escaped(file));
            text += &format!("    <collision name=\"{mesh}\">\n      <geometry>\n");
            text += &format!("        <mesh filename=\"{prefix}{file}\"/>\n");
            text += "      </geometry>\n    </collision>\n";
        }
        text + "  </link>\n</robot>\n"
    }
}

impl Robot<'_> {
    /// The SDF document.
    pub fn sdf(&self) -> String {
        let (name, prefix) = (escaped(self.name), escaped(self.prefix));
        let mut text = format!("<?xml version=\"1.0\"?>\n<sdf version=\"1.7\">\n  <model name=\"{name}\">\n");
        text += &format!("    <link name=\"{name}\">\n");
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
        for (mesh, file) in self.meshes {
            let (mesh, file) = (escaped(mesh), escaped(file));
            text += &format!("      <collision name=\"{mesh}\">\n        <geometry>\n");
            text += &format!("          <mesh><uri>{prefix}{file}</uri></mesh>\n");
            text += "        </geometry>\n      </collision>\n";
        }
        text + "    </link>\n  </model>\n</sdf>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_attributes() {
        let meshes = [("a\"/><evil x='\n".to_owned(), "a&b.obj".to_owned())];
        let robot = Robot { name: "r<1>", prefix: "package://p/", meshes: &meshes, inertial: None };
        for text in [robot.mjcf(), robot.urdf(), robot.sdf()] {
            assert!(!text.contains("<evil") && text.contains("package://p/a&amp;b.obj"), "{text}");
            assert!(text.contains("\"r&lt;1&gt;\"") && text.contains("\"a&quot;/&gt;&lt;evil x=&apos;_\""), "{text}");
        }
    }
}
