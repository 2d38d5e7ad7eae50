//! Coordinates of sources: far from the origin, and turned, scaled and named by artists.

use std::fs;

use hullmap::Pack;
use hullmap::glam::Vec3;
use hullmap_outside::command::bake_line as bake;
use shapes::mesh::Mesh;
use shapes::{gltf, solids};

fn prism() -> Mesh {
    solids::extrusion(&solids::regular_polygon(7, 1.0), -0.5, 0.5)
}

#[test]
fn recentred_hulls_keep_the_digits_of_distant_points() {
    let folder = tempfile::tempdir().unwrap();
    let far = |x: &str, y: &str, z: &str| format!("v 1000000.{x} -2000000.{y} 3000000.{z}\n");
    let corners =
        ["0001", "0003"].map(|x| ["0010", "0040"].map(|y| ["0100", "0900"].map(|z| far(x, y, z)).concat()).concat());
    fs::write(folder.path().join("far.obj"), corners.concat()).unwrap();
    let plain = bake(folder.path(), "build far.obj --out plain --json").expect(0);
    let warnings = plain.json()[0]["warnings"].to_string();
    assert!(warnings.contains("--recentre"), "{warnings}");

    let moved = bake(folder.path(), "build far.obj --out moved --recentre --verify --json").expect(0);
    assert!(!moved.json()[0]["warnings"].to_string().contains("--recentre"));
    let pack = Pack::open(folder.path().join("moved/far.hullmap")).unwrap();
    let hull = pack.hull(0).unwrap();
    let (origin, point) = (hull.origin(), hull.support(Vec3::ONE).point);
    for (axis, expected) in [1.000_000_000_3e6, -2.000_000_001e6, 3.000_000_09e6].into_iter().enumerate() {
        let found = origin[axis] + f64::from(point[axis]);
        assert!((found - expected).abs() < 1e-8, "axis {axis}: {found} for {expected}");
    }
    bake(folder.path(), "verify moved --source . --require-source").expect(0);
}

#[test]
fn artists_parts_are_used_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = prism();
    let nodes = r#"{"mesh":0,"name":"Crate"},{"mesh":0,"name":"UCX_Crate_00","scale":[2,2,2]},{"mesh":0,"name":"UCX_Crate_01"}"#;
    let bytes = gltf::parts(&[("prism", &mesh)], nodes, "0,1,2").glb();
    fs::write(folder.path().join("crate.glb"), bytes).unwrap();
    let run = bake(
        folder.path(),
        "build crate.glb --out out --split auto --unit-scale 0.01 --up-axis y-to-z --verify --json",
    );
    let row = &run.expect(0).json()[0];
    assert_eq!((&row["hulls"], &row["vertices_hull"]), (&2.into(), &28.into()));
    assert!(row["notes"].to_string().contains("collision parts named as in Unreal"), "{row}");
    let pack = Pack::open(folder.path().join("out/crate.hullmap")).unwrap();
    let names: Vec<&str> = pack.hulls().map(|hull| hull.name()).collect();
    assert_eq!(names, ["UCX_Crate_00", "UCX_Crate_01"]);
    // The prism stood along z, which is now turned to -y, and is a hundredth of its size.
    let lowest = pack.hull(1).unwrap().support(Vec3::NEG_Y).point;
    assert!((lowest.y + 0.005).abs() < 1e-9, "{lowest}");
}
