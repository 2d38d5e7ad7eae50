//! Descriptions in each format: what is found, and what changes.

use std::path::{Path, PathBuf};

use hullmap_robot::{Change, Description, Frame, Geometry, Places, RobotError, Unresolved};

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

fn read(folder: &Path, name: &str) -> Result<Description, RobotError> {
    let places = Places { roots: vec![folder.canonicalize().unwrap()], ..Places::default() };
    Description::read(&folder.join(name), &places)
}

/// Collisions of each link, by kind.
fn kinds(description: &Description) -> Vec<(String, Vec<String>)> {
    let kind = |geometry: &Geometry| match geometry {
        Geometry::Mesh(mesh) => match &mesh.file {
            Ok(file) => format!("mesh {}", file.file_name().unwrap().display()),
            Err(Unresolved::Inline(own)) => format!("inline {}", own.name),
            Err(_) => "missing".to_owned(),
        },
        Geometry::Primitive(primitive) => primitive.name.clone(),
        Geometry::Other(_) => "other".to_owned(),
    };
    let shapes = |link: &hullmap_robot::Link| link.collisions.iter().map(|shape| kind(&shape.geometry)).collect();
    description.links.iter().map(|link| (link.name.clone(), shapes(link))).collect()
}

fn meshes(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn replace(link: usize, collision: usize, names: &[&str]) -> Change {
    Change::Replace { link, collision, meshes: meshes(names) }
}

fn changed(description: &Description, changes: &[Change]) -> Vec<String> {
    description.changed(changes).unwrap().into_iter().map(|bytes| String::from_utf8(bytes).unwrap()).collect()
}

const URDF: &str = r#"<?xml version="1.0"?>
<robot name="r"> <!-- a -- comment -->
  <link name="base">
    <visual name="v"><geometry><mesh filename="a.stl"/></geometry></visual>
    <collision name="c">
      <origin xyz="0 0 1"/> <!-- kept -->
      <geometry>
        <mesh scale='1 -1 1'   filename='a.stl' />
      </geometry>
    </collision>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <link name="arm">
    <visual name="shell">
      <origin rpy="0 0 1"/>
      <geometry><mesh filename="meshes/b.stl" scale="0.001 0.001 0.001"/></geometry>
      <material name="red"/>
    </visual>
  </link>
  <link name="hand"><collision><geometry><mesh filename="gone.stl"/></geometry></collision></link>
</robot>
"#;

#[test]
fn urdf() {
    let folder = folder(&[("r.urdf", URDF), ("a.stl", ""), ("meshes/b.stl", "")]);
    let description = read(folder.path(), "r.urdf").unwrap();
    let own = |name: &str, all: &[&str]| (name.to_owned(), meshes(all));
    assert_eq!(kinds(&description), [own("base", &["mesh a.stl", "box"]), own("arm", &[]), own("hand", &["missing"])]);
    let Geometry::Mesh(mesh) = &description.links[0].collisions[0].geometry else { panic!() };
    assert_eq!((mesh.scale, mesh.stretch()), ([1.0, -1.0, 1.0], 1.0));
    assert_eq!(changed(&description, &[]), [URDF]);
    let one = changed(&description, &[replace(0, 0, &["h/x.obj"])]);
    assert_eq!(one, [URDF.replace("filename='a.stl'", "filename='h/x.obj'")]);
    let three = changed(&description, &[replace(0, 0, &["x.obj", "y.obj", "z.obj"])]).remove(0);
    let copy = |name: &str, mesh: &str| {
        format!(
            "\n    <collision name=\"{name}\">\n      <origin xyz=\"0 0 1\"/> <!-- kept -->\n      <geometry>\n        \
             <mesh scale='1 -1 1'   filename='{mesh}' />\n      </geometry>\n    </collision>"
        )
    };
    let first = URDF.replace("filename='a.stl'", "filename='x.obj'");
    let at = first.find("</collision>").unwrap() + "</collision>".len();
    let expected = [&first[..at], &copy("c_part_01", "y.obj"), &copy("c_part_02", "z.obj"), &first[at..]].concat();
    assert_eq!(three, expected);
    let change = Change::FromVisual { link: 1, visual: 0, meshes: Some(meshes(&["b.obj"])) };
    let from_visual = changed(&description, &[change]).remove(0);
    let collision = "\n    <collision name=\"shell\">\n      <origin rpy=\"0 0 1\"/>\n      <geometry>\
                     <mesh filename=\"b.obj\" scale=\"0.001 0.001 0.001\"/></geometry>\n    </collision>";
    let at = URDF.find("      <material name=\"red\"/>\n    </visual>").unwrap()
        + "      <material name=\"red\"/>\n    </visual>".len();
    assert_eq!(from_visual, [&URDF[..at], collision, &URDF[at..]].concat());
}

const SDF: &str = "<sdf version='1.9'>\r\n<model name='m'>\r\n <link name='l'>\r\n  <collision name='c'>\r\n   <geometry><mesh>\
<uri> model://m/a.stl </uri><scale>2 2 2</scale></mesh></geometry>\r\n   <surface/>\r\n  </collision>\r\n  <visual name='v'>\
<geometry><box><size>1 1 1</size></box></geometry><material/></visual>\r\n </link>\r\n <link name='k'>\r\n  <visual name='w'>\
<geometry><sphere/></geometry><material/></visual>\r\n </link>\r\n</model>\r\n</sdf>\r\n";

#[test]
fn sdf() {
    let folder = folder(&[("m/model.sdf", SDF), ("m/model.config", ""), ("m/a.stl", "")]);
    let description = read(folder.path(), "m/model.sdf").unwrap();
    assert_eq!(kinds(&description)[0], ("l".to_owned(), meshes(&["mesh a.stl"])));
    assert_eq!(changed(&description, &[]), [SDF]);
    let folder = folder.path().canonicalize().unwrap().join("m");
    let name = description.mesh_name(&folder.join("h/x.obj"), &folder).unwrap();
    assert_eq!(name, "model://m/h/x.obj");
    let two = changed(&description, &[replace(0, 0, &[&name, "y.obj"])]).remove(0);
    let first = SDF.replace(" model://m/a.stl ", "model://m/h/x.obj");
    let copy = "\r\n  <collision name='c_part_01'>\r\n   <geometry><mesh><uri>y.obj</uri><scale>2 2 2</scale></mesh></geometry>\
                \r\n   <surface/>\r\n  </collision>";
    let at = first.find("</collision>").unwrap() + "</collision>".len();
    assert_eq!(two, [&first[..at], copy, &first[at..]].concat());
    let sphere = changed(&description, &[Change::FromVisual { link: 1, visual: 0, meshes: None }]).remove(0);
    assert!(
        sphere.contains("\r\n  <collision name='w'><geometry><sphere/></geometry></collision>\r\n </link>"),
        "{sphere}"
    );
}

/// Parts are convex: a simulator that divides or encloses them again would change them.
#[test]
fn sdf_optimization_is_removed_from_parts() {
    let mesh = |optimization: &str, inner: &str, uri: &str| {
        format!(
            "<collision name='c'><geometry><mesh{optimization}>{inner}<uri>{uri}</uri></mesh></geometry></collision>"
        )
    };
    for (optimization, inner) in [
        (
            " optimization='convex_decomposition'",
            "<convex_decomposition><max_convex_hulls>4</max_convex_hulls></convex_decomposition>",
        ),
        (" optimization=\"convex_hull\"", ""),
        ("", ""),
    ] {
        let text = |own: String| {
            format!(
                "<sdf version='1.12'><model name='m'><link name='l'>{own}<visual name='v'><geometry><mesh optimization='convex_hull'><uri>a.stl</uri></mesh></geometry></visual></link></model></sdf>"
            )
        };
        let folder = folder(&[("m.sdf", &text(mesh(optimization, inner, "a.stl"))), ("a.stl", "")]);
        let description = read(folder.path(), "m.sdf").unwrap();
        let found = changed(&description, &[replace(0, 0, &["x.obj", "y.obj"])]).remove(0);
        let second = mesh("", "", "y.obj").replace("name='c'", "name='c_part_01'");
        assert_eq!(found, text(mesh("", "", "x.obj") + &second));
        let visual = Change::FromVisual { link: 0, visual: 0, meshes: Some(meshes(&["v.obj"])) };
        let found = changed(&description, &[visual]).remove(0);
        assert!(
            found.contains("<collision name='v'><geometry><mesh><uri>v.obj</uri></mesh></geometry></collision>"),
            "{found}"
        );
    }
}

/// Poses of collisions, and what happens to each kind of `inertial`.
#[test]
fn sdf_inertia() {
    let shape = |name: &str, pose: &str| {
        format!("  <collision name='{name}'>{pose}<geometry><mesh><uri>a.stl</uri></mesh></geometry></collision>\n")
    };
    let text = [
        "<sdf version='1.9'><model name='m'><link name='a'>\n",
        "  <inertial>\n    <!-- kept -->\n    <mass>2</mass>\n  </inertial>\n",
        &shape("c", "<pose degrees='true'>1 2 3 0 0 90</pose>"),
        &shape("d", "<pose relative_to='x'>1 2 3 0 0 0</pose>"),
        &shape("e", "<pose>1 2 3</pose>"),
        "</link>\n<link name='b'><inertial><mass>3</mass><pose relative_to='x'>9 9 9 1 1 1</pose>",
        "<inertia><izz>7</izz></inertia></inertial></link>\n",
        "<link name='c'><inertial auto='true'><mass>4</mass></inertial></link>\n</model></sdf>\n",
    ]
    .concat();
    let folder = folder(&[("m.sdf", &text), ("a.stl", "")]);
    let description = read(folder.path(), "m.sdf").unwrap();
    let masses: Vec<Option<f64>> = description.links.iter().map(|link| link.mass).collect();
    assert_eq!(masses, [Some(2.0), Some(3.0), None]);
    let poses: Vec<_> = description.links[0].collisions.iter().map(|shape| shape.pose).collect();
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!(poses, [Some(Frame::of_xyz_rpy([1.0, 2.0, 3.0, 0.0, 0.0, quarter])), None, None]);
    let inertia = |link| Change::Inertia {
        link,
        center: [1.0, 0.5, 2.0],
        inertia: [[1.0, 0.25, 0.0], [0.25, 2.0, 0.0], [0.0, 0.0, 3.0]],
    };
    let found = changed(&description, &[inertia(0), inertia(1)]).remove(0);
    let written = "<inertia><ixx>1</ixx><ixy>0.25</ixy><ixz>0</ixz><iyy>2</iyy><iyz>0</iyz><izz>3</izz></inertia>";
    let pose = "<pose>1 0.5 2 0 0 0</pose>";
    let expected = text
        .replace("    <mass>2</mass>\n", &format!("    {pose}\n    <mass>2</mass>\n    {written}\n"))
        .replace("<pose relative_to='x'>9 9 9 1 1 1</pose>", pose)
        .replace("<inertia><izz>7</izz></inertia>", written);
    assert_eq!(found, expected);
}

/// ROS programs skip all slashes behind `package:`, and TinyXML ignores what follows the root.
#[test]
fn third_slashes_and_second_end_tags_are_read_as_by_others() {
    let text = "<robot name='r'>\n <link name='l'><collision><geometry>\
        <mesh filename='package:///p/a.stl'/></geometry></collision></link>\n</robot>\n</robot>\n<!-- end -->\n";
    let folder = folder(&[("p/package.xml", "<package><name>p</name></package>"), ("p/a.stl", ""), ("p/r.urdf", text)]);
    let description = read(folder.path(), "p/r.urdf").unwrap();
    let Geometry::Mesh(mesh) = &description.links[0].collisions[0].geometry else { panic!("{description:?}") };
    assert_eq!(mesh.file.as_ref().unwrap(), &folder.path().canonicalize().unwrap().join("p/a.stl"));
    let found = changed(&description, &[replace(0, 0, &["package://p/h.obj"])]).remove(0);
    assert_eq!(found, text.replace("package:///p/a.stl", "package://p/h.obj"));
}

/// Pinocchio and PyBullet look for a folder of this name, ROS for the name in `package.xml`:
/// whichever the description uses is kept.
#[test]
fn packages_keep_the_name_that_the_description_uses() {
    for name in ["my-robot", "my_robot"] {
        let text = format!(
            "<robot name='r'><link name='l'><collision><geometry><mesh filename='package://{name}/m/x.stl'/></geometry></collision></link></robot>"
        );
        let folder = folder(&[
            ("my-robot/package.xml", "<package><name>my_robot</name></package>"),
            ("my-robot/m/x.stl", ""),
            ("my-robot/r.urdf", &text),
        ]);
        let description = read(folder.path(), "my-robot/r.urdf").unwrap();
        let root = folder.path().canonicalize().unwrap();
        let mesh =
            |target: &str| description.mesh_name(&root.join(target).join("h/x.obj"), &root.join(target)).unwrap();
        assert_eq!([mesh("my-robot"), mesh("other")], [format!("package://{name}/h/x.obj"), "h/x.obj".to_owned()]);
    }
}

const MJCF: &str = r#"<mujoco>
  <compiler meshdir="assets"/>
  <default>
    <geom group="2"/>
    <default class="col"><geom type="mesh" group="3" rgba="1 0 0 1"/></default>
    <default class="vis"><geom type="mesh" contype="0" conaffinity="0"/></default>
  </default>
  <asset>
    <mesh file="a.stl" scale="0.1 0.1 0.1"/>
    <mesh name="bee" file="b.obj" maxhullvert="8"/>
    <mesh name="inline" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="one" childclass="col">
      <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
      <geom name="g" mesh="a" pos="1 2 3"/>
      <geom class="vis" mesh="bee"/>
      <frame><geom type="box" size="1 1 1"/></frame>
      <body name="two">
        <geom class="col" mesh="bee" mass="2"/>
        <include file="inc/part.xml"/>
      </body>
      <body name="three"><geom class="vis" mesh="bee" name="drawn"/></body>
    </body>
  </worldbody>
  <contact><pair geom1="g" geom2="p"/></contact>
</mujoco>
"#;

const PART: &str = "<mujocoinclude>\n  <geom name=\"p\" type=\"mesh\" mesh=\"inline\"/>\n  <geom type='mesh' mesh='a'/>\n</mujocoinclude>\n";

#[test]
fn mjcf() {
    let files = [("r.xml", MJCF), ("inc/part.xml", PART), ("assets/a.stl", ""), ("assets/b.obj", "")];
    let folder = folder(&files);
    let description = read(folder.path(), "r.xml").unwrap();
    let own = |name: &str, all: &[&str]| (name.to_owned(), meshes(all));
    let expected = [
        own("world", &["other"]),
        own("one", &["mesh a.stl", "box"]),
        own("two", &["mesh b.obj", "inline inline", "mesh a.stl"]),
        own("three", &[]),
    ];
    assert_eq!(kinds(&description), expected);
    assert!(description.links[1].collisions[0].stays_single.is_some(), "a pair names it");
    assert_eq!(changed(&description, &[]), [MJCF, PART]);
    let root = folder.path().canonicalize().unwrap();
    let name = description.mesh_name(&root.join("r_collision/a_hull.obj"), &root).unwrap();
    assert_eq!(name, "../r_collision/a_hull.obj");
    // A hidden geom of a body with an inertial: only its mesh changes.
    let texts = changed(&description, &[replace(1, 0, &[&name])]);
    let asset = "<mesh file=\"a.stl\" scale=\"0.1 0.1 0.1\"/>";
    let added = "\n    <mesh file=\"../r_collision/a_hull.obj\" scale=\"0.1 0.1 0.1\" name=\"a_hull\"/>";
    let expected = MJCF.replace(asset, &format!("{asset}{added}")).replace("\"g\" mesh=\"a\"", "\"g\" mesh=\"a_hull\"");
    assert_eq!(texts, [expected.as_str(), PART]);
    // A hidden geom that gives the body its mass: a copy keeps the mass, and does not collide.
    let texts = changed(&description, &[replace(2, 0, &["x.obj", "y.obj"])]);
    let geom = "<geom class=\"col\" mesh=\"bee\" mass=\"2\"/>";
    let copies = [
        "<geom class=\"col\" mesh=\"x\" mass=\"0\" group=\"3\"/>",
        "\n        <geom class=\"col\" mesh=\"y\" mass=\"0\" group=\"3\"/>",
        "\n        <geom class=\"col\" mesh=\"bee\" mass=\"2\" contype=\"0\" conaffinity=\"0\"/>",
    ];
    assert_eq!(texts[0].replace(&copies.concat(), geom).len(), MJCF.len() + added_len(&texts[0]));
    assert!(texts[0].contains(&copies.concat()), "{}", texts[0]);
    assert!(texts[0].contains("<mesh name=\"x\" file=\"x.obj\"/>"), "no limit on vertices: {}", texts[0]);
    // A geom that is drawn, in an included file.
    let texts = changed(&description, &[replace(2, 2, &["z.obj"])]);
    let geom = "<geom type='mesh' mesh='z' group=\"3\" mass=\"0\"/>\n  <geom type='mesh' mesh='a' contype=\"0\" conaffinity=\"0\"/>";
    assert_eq!(texts[1], PART.replace("<geom type='mesh' mesh='a'/>", geom));
    let change = Change::FromVisual { link: 3, visual: 0, meshes: Some(meshes(&["v.obj"])) };
    let text = changed(&description, &[change]).remove(0);
    let geom = "<geom class=\"vis\" mesh=\"bee\" name=\"drawn\"/>";
    let collision = "<geom class=\"vis\" mesh=\"v\" contype=\"1\" conaffinity=\"1\" group=\"3\" mass=\"0\"/>";
    assert!(text.contains(&format!("{geom}{collision}")), "{text}");
}

/// MuJoCo looks for names of an included file in `md` first, and opens them in `ad`: a new name
/// would be found in neither, so its asset goes to the model's own file.
#[test]
fn new_assets_are_in_the_model_if_an_included_file_would_hide_them() {
    let assets = "<mujocoinclude><asset><mesh name='a' file='a.stl' scale='2 2 2'/></asset></mujocoinclude>";
    let model = |compilers: &str| {
        format!(
            "<mujoco>{compilers}<include file='inc/assets.xml'/><worldbody><body name='b'><geom type='mesh' mesh='a' group='3'/></body></worldbody>\n</mujoco>"
        )
    };
    let one = "<compiler meshdir='ad'/>";
    for (compilers, is_in_model) in [("<compiler meshdir='md'/><compiler assetdir='ad'/>", true), (one, false)] {
        let text = model(compilers);
        let folder = folder(&[("r.xml", &text), ("inc/assets.xml", assets), ("md/a.stl", ""), ("ad/a.stl", "")]);
        let texts = changed(&read(folder.path(), "r.xml").unwrap(), &[replace(1, 0, &["../x.obj"])]);
        let at = usize::from(!is_in_model);
        let added = |text: &str| text.contains("<mesh name='x' file='../x.obj' scale='2 2 2'/>");
        assert!(added(&texts[at]) && !added(&texts[1 - at]), "{texts:?}");
        assert_eq!(texts[0].contains("</worldbody><asset>"), is_in_model, "{texts:?}");
    }
}

/// Length of the assets that were added.
fn added_len(text: &str) -> usize {
    ["\n    <mesh name=\"x\" file=\"x.obj\"/>", "\n    <mesh name=\"y\" file=\"y.obj\"/>"]
        .iter()
        .filter(|added| text.contains(**added))
        .map(|added| added.len())
        .sum()
}

#[test]
fn bad_descriptions_are_errors_with_line_and_remedy() {
    for (name, text, expected) in [
        (
            "a.urdf",
            "<robot>\n<link name='a'/>\n<link name='a'/></robot>",
            "a.urdf:3: link `a` exists already, in line 2; rename",
        ),
        ("a.urdf", "<robot>\n<link/></robot>", "a.urdf:2: this link has no name; add one"),
        (
            "a.urdf.xacro",
            "<robot xmlns:xacro='x'>\n<xacro:macro name='m'/></robot>",
            "a.urdf.xacro:2: has macros of xacro; expand them first: xacro ",
        ),
        (
            "a.sdf",
            "<sdf><model name='m'><link name='a'/>\n<link name='a'/></model></sdf>",
            "a.sdf:2: link `a` exists already",
        ),
        (
            "a.xml",
            "<mujoco><worldbody><body name='b'/>\n<body name='b'/></worldbody></mujoco>",
            "a.xml:2: body `b` exists already, in line 1",
        ),
        (
            "a.xml",
            "<mujoco><asset><mesh file='m.obj'/>\n<mesh name='m' file='n.obj'/></asset></mujoco>",
            "a.xml:2: mesh `m` exists already",
        ),
        (
            "a.xml",
            "<mujoco>\n<include file='a.xml'/></mujoco>",
            "a.xml:2: `a.xml` is included already; MuJoCo includes a file once, so this may be a cycle",
        ),
        (
            "a.xml",
            "<mujoco>\n<include file='b.xml'/></mujoco>",
            "a.xml:2: no file `b.xml`; restore it, or remove this include",
        ),
        (
            "a.xml",
            "<mujoco>\n<include file='../../../../../../../../etc/hosts'/></mujoco>",
            "a.xml:2: `../../../../../../../../etc/hosts` leads out",
        ),
        ("a.xml", "<mujoco>\n<include/></mujoco>", "a.xml:2: this include names no file"),
        ("a.xml", "<mujocoinclude/>", "a.xml:1: is a part of a model; name the file that includes it"),
        ("a.xml", "<html/>", "`html` is not the root of a URDF (robot), MJCF (mujoco) or SDF (sdf) file"),
        ("a.xml", "<mujoco>\n", "invalid XML"),
        ("a.urdf", "<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>", "remove <!DOCTYPE>"),
    ] {
        let folder = folder(&[(name, text)]);
        let error = read(folder.path(), name).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let cycle = [
        ("a.xml", "<mujoco><include file='b.xml'/></mujoco>"),
        ("b.xml", "<mujocoinclude>\n<include file='a.xml'/></mujocoinclude>"),
    ];
    let folder = folder(&cycle);
    let error = read(folder.path(), "a.xml").unwrap_err().to_string();
    assert!(error.contains("b.xml:2: `a.xml` is included already"), "{error}");
    assert!(Description::read(&PathBuf::from("/no/such.urdf"), &Places::default()).unwrap_err().is_unreadable);
}
