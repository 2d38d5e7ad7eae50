//! Descriptions in each format: what is found, and what changes.

use std::path::Path;

use hullmap_robot::{Change, Description, Frame, Geometry, Places, Unresolved};

use super::{folder, read};

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

const URDF: &str = include_str!("files/r.urdf");

#[test]
fn urdf() {
    let (_guard, root) = folder(&[("r.urdf", URDF), ("a.stl", ""), ("meshes/b.stl", "")]);
    let description = read(&root, "r.urdf").unwrap();
    let own = |name: &str, all: &[&str]| (name.to_owned(), meshes(all));
    assert_eq!(kinds(&description), [own("base", &["mesh a.stl", "box"]), own("arm", &[]), own("hand", &["missing"])]);
    let Geometry::Mesh(mesh) = &description.links[0].collisions[0].geometry else { panic!() };
    assert_eq!((mesh.scale, mesh.stretch()), ([1.0, -1.0, 1.0], 1.0));
    assert_eq!(changed(&description, &[]), [URDF]);
    let from_visual = Change::FromVisual { link: 1, visual: 0, meshes: Some(meshes(&["b.obj"])) };
    let found = changed(&description, &[replace(0, 0, &["h/x.obj", "y.obj", "z.obj"]), from_visual]);
    assert_eq!(found, [include_str!("files/r_changed.urdf")]);
}

/// With the line ends of Windows.
#[test]
fn sdf() {
    let text = include_str!("files/model.sdf").replace('\n', "\r\n");
    let (_guard, root) = folder(&[("m/model.sdf", &text), ("m/model.config", ""), ("m/a.stl", "")]);
    let description = read(&root, "m/model.sdf").unwrap();
    assert_eq!(kinds(&description)[0], ("l".to_owned(), meshes(&["mesh a.stl"])));
    assert_eq!(changed(&description, &[]), [text]);
    let name = description.mesh_name(&root.join("m/h/x.obj"), &root.join("m")).unwrap();
    assert_eq!(name, "model://m/h/x.obj");
    let sphere = Change::FromVisual { link: 1, visual: 0, meshes: None };
    let found = changed(&description, &[replace(0, 0, &[&name, "y.obj"]), sphere]);
    assert_eq!(found, [include_str!("files/model_changed.sdf").replace('\n', "\r\n")]);
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
        let (_guard, root) = folder(&[("m.sdf", &text(mesh(optimization, inner, "a.stl"))), ("a.stl", "")]);
        let description = read(&root, "m.sdf").unwrap();
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
    let text = include_str!("files/inertia.sdf");
    let (_guard, root) = folder(&[("m.sdf", text), ("a.stl", "")]);
    let description = read(&root, "m.sdf").unwrap();
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
    let found = changed(&description, &[inertia(0), inertia(1)]);
    assert_eq!(found, [include_str!("files/inertia_changed.sdf")]);
}

/// ROS programs skip all slashes behind `package:`, and TinyXML ignores what follows the root.
#[test]
fn third_slashes_and_second_end_tags_are_read_as_by_others() {
    let text = "<robot name='r'>\n <link name='l'><collision><geometry>\
        <mesh filename='package:///p/a.stl'/></geometry></collision></link>\n</robot>\n</robot>\n<!-- end -->\n";
    let (_guard, root) =
        folder(&[("p/package.xml", "<package><name>p</name></package>"), ("p/a.stl", ""), ("p/r.urdf", text)]);
    let description = read(&root, "p/r.urdf").unwrap();
    let Geometry::Mesh(mesh) = &description.links[0].collisions[0].geometry else { panic!("{description:?}") };
    assert_eq!(mesh.file.as_ref().unwrap(), &root.join("p/a.stl"));
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
        let (_guard, root) = folder(&[
            ("my-robot/package.xml", "<package><name>my_robot</name></package>"),
            ("my-robot/m/x.stl", ""),
            ("my-robot/r.urdf", &text),
        ]);
        let description = read(&root, "my-robot/r.urdf").unwrap();
        let mesh =
            |target: &str| description.mesh_name(&root.join(target).join("h/x.obj"), &root.join(target)).unwrap();
        assert_eq!([mesh("my-robot"), mesh("other")], [format!("package://{name}/h/x.obj"), "h/x.obj".to_owned()]);
    }
}

const MJCF: &str = include_str!("files/r.xml");
const PART: &str = include_str!("files/part.xml");

#[test]
fn mjcf() {
    let files = [("r.xml", MJCF), ("inc/part.xml", PART), ("assets/a.stl", ""), ("assets/b.obj", "")];
    let (_guard, root) = folder(&files);
    let description = read(&root, "r.xml").unwrap();
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
    let name = description.mesh_name(&root.join("r_collision/a_hull.obj"), &root).unwrap();
    assert_eq!(name, "../r_collision/a_hull.obj");
    let changes = [
        // A hidden geom of a body with an inertial: only its mesh changes.
        replace(1, 0, &[&name]),
        // A hidden geom that gives the body its mass: a copy keeps the mass, and does not collide.
        replace(2, 0, &["x.obj", "y.obj"]),
        // A geom that is drawn, in an included file.
        replace(2, 2, &["z.obj"]),
        Change::FromVisual { link: 3, visual: 0, meshes: Some(meshes(&["v.obj"])) },
    ];
    let expected = [include_str!("files/r_changed.xml"), include_str!("files/part_changed.xml")];
    assert_eq!(changed(&description, &changes), expected);
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
        let (_guard, root) =
            folder(&[("r.xml", &text), ("inc/assets.xml", assets), ("md/a.stl", ""), ("ad/a.stl", "")]);
        let texts = changed(&read(&root, "r.xml").unwrap(), &[replace(1, 0, &["../x.obj"])]);
        let at = usize::from(!is_in_model);
        let added = |text: &str| text.contains("<mesh name='x' file='../x.obj' scale='2 2 2'/>");
        assert!(added(&texts[at]) && !added(&texts[1 - at]), "{texts:?}");
        assert_eq!(texts[0].contains("</worldbody><asset>"), is_in_model, "{texts:?}");
    }
}

#[test]
fn bad_descriptions_are_errors_with_line_and_remedy() {
    for row in include_str!("files/damaged.txt").split("\n=== ").skip(1) {
        let (head, text) = row.split_once('\n').unwrap();
        let (name, words) = head.split_once(" | ").unwrap();
        let (_guard, root) = folder(&[(name, text)]);
        let error = read(&root, name).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let cycle = [
        ("a.xml", "<mujoco><include file='b.xml'/></mujoco>"),
        ("b.xml", "<mujocoinclude>\n<include file='a.xml'/></mujocoinclude>"),
    ];
    let (_guard, root) = folder(&cycle);
    let error = read(&root, "a.xml").unwrap_err().to_string();
    assert!(error.contains("b.xml:2: `a.xml` is included already"), "{error}");
    assert!(Description::read(Path::new("/no/such.urdf"), &Places::default()).unwrap_err().is_unreadable);
}
