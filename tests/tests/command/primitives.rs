//! The option `primitives`: boxes, balls, capsules and cylinders instead of parts, from the command
//! to the documents of robots and scenes.

use std::fs;

use glam::{DQuat, DVec3};
use hullmap::Pack;
use hullmap_testkit::command::{Run, bake_line as bake};
use hullmap_testkit::files::{contents, folder, write};
use hullmap_testkit::packs::{Further, with_record};
use shapes::{mesh::Mesh, obj::text, rng::SplitMix64, solids::lathe};
use tempfile::TempDir;

use crate::parts::boxes;

const SEED: u64 = 47;

/// A slab on four legs of different heights.
const TABLE: [[[f64; 3]; 2]; 5] = [
    [[0.0, 0.0, 0.0], [3.0, 2.0, 0.2]],
    [[0.1, 0.1, -1.5], [0.4, 0.4, 0.0]],
    [[2.6, 0.1, -1.2], [2.9, 0.4, 0.0]],
    [[0.1, 1.6, -1.0], [0.4, 1.9, 0.0]],
    [[2.6, 1.6, -1.4], [2.9, 1.9, 0.0]],
];

/// A folder with the table as a mesh, and with its pack in `baked`; and the run.
fn baked_table() -> (TempDir, Run) {
    let folder = folder(&[("table.obj", &boxes(&TABLE.map(|bounds| ("", bounds))))]);
    let line = "build table.obj --out baked --decompose --max-error 1% --set primitives=true --json";
    let row = bake(&folder, line).expect(0);
    (folder, row)
}

/// A body of revolution with round ends, between which it is straight.
fn rounded(half: f64) -> Mesh {
    let angle = |k: usize| std::f64::consts::PI * (k as f64 / 25.0 - 0.5);
    let ring = |k: usize| [angle(k).cos(), angle(k).sin() + if k <= 12 { -half } else { half }];
    let profile: Vec<[f64; 2]> =
        [[0.0, -1.0 - half]].into_iter().chain((1..=24).map(ring)).chain([[0.0, 1.0 + half]]).collect();
    lathe(&profile, 32)
}

fn numbers(element: &str, attribute: &str) -> Vec<f64> {
    let (_, rest) = element.split_once(&format!(" {attribute}=\"")).unwrap_or_else(|| panic!("{element}"));
    rest.split('"').next().unwrap().split(' ').map(|number| number.parse().unwrap()).collect()
}

#[test]
fn a_table_is_exported_as_boxes() {
    println!("seed {SEED}");
    let (folder, row) = baked_table();
    let notes = row.json()[0]["notes"].to_string();
    assert!(notes.contains("5 of 5 parts can be replaced by a box, sphere, capsule or cylinder, proven"), "{notes}");
    bake(&folder, "export baked/table.hullmap --for mjcf --out mjcf").expect(0);
    // No mesh is written.
    assert!(contents(&folder.path().join("mjcf")).keys().eq(["table.xml"]));
    let text = fs::read_to_string(folder.path().join("mjcf/table.xml")).unwrap();
    let geoms: Vec<&str> = text.split("<geom ").skip(1).collect();
    let boxes: Vec<(DVec3, DVec3, DQuat)> = geoms
        .iter()
        .map(|geom| {
            assert!(geom.contains("type=\"box\""), "{geom}");
            let [w, x, y, z] = numbers(geom, "quat")[..] else { panic!("{geom}") };
            let of = |attribute: &str| DVec3::from_slice(&numbers(geom, attribute));
            (of("pos"), of("size"), DQuat::from_xyzw(x, y, z, w))
        })
        .collect();
    // Points of the surface are in a box, and boxes are near the table.
    let diagonal = (3.0_f64.powi(2) + 2.0_f64.powi(2) + 1.7_f64.powi(2)).sqrt();
    let mut rng = SplitMix64::new(SEED);
    for round in 0..4000 {
        let [low, high] = TABLE[round % 5].map(DVec3::from_array);
        let mut p = low + (high - low) * DVec3::new(rng.unit(), rng.unit(), rng.unit());
        let axis = round / 5 % 3;
        p[axis] = if rng.unit() < 0.5 { low[axis] } else { high[axis] };
        let is_in = |(center, size, turn): &(DVec3, DVec3, DQuat)| {
            // The OBJ's numbers are rounded to f32.
            ((turn.inverse() * (p - *center)).abs() - *size).max_element() <= 1e-6
        };
        assert!(boxes.iter().any(is_in), "{p}");
    }
    for (center, size, turn) in &boxes {
        for i in 0..8 {
            let signs = DVec3::from_array([0, 1, 2].map(|k| f64::from(2 * (i >> k & 1) - 1)));
            let p = *center + *turn * (*size * signs);
            let from =
                |[low, high]: &[[f64; 3]; 2]| p.distance(p.clamp(DVec3::from_array(*low), DVec3::from_array(*high)));
            let distance = TABLE.iter().map(from).fold(f64::INFINITY, f64::min);
            assert!(distance <= 0.01 * diagonal, "{p}: {distance}");
        }
    }
    for (target, element) in [("urdf", "<box size=\""), ("sdf", "<box><size>")] {
        bake(&folder, &format!("export baked/table.hullmap --for {target} --out {target}")).expect(0);
        let text = fs::read_to_string(folder.path().join(format!("{target}/table.{target}"))).unwrap();
        assert_eq!((text.matches(element).count(), text.matches("mesh").count()), (5, 0), "{text}");
    }
    for (target, list) in [("khr-physics", "KHR_implicit_shapes"), ("omi", "OMI_physics_shape")] {
        bake(&folder, &format!("export baked/table.hullmap --for {target} --out {target}.glb")).expect(0);
        let text =
            String::from_utf8_lossy(&fs::read(folder.path().join(format!("{target}.glb"))).unwrap()).into_owned();
        assert!(
            text.contains(list) && text.matches("\"type\":\"box\"").count() == 5 && !text.contains("convex"),
            "{text}"
        );
        // Read again, they are the same boxes.
        bake(&folder, &format!("build {target}.glb --out again --split auto")).expect(0);
        let pack = Pack::open(folder.path().join(format!("again/{target}.hullmap"))).unwrap();
        let volume: f64 = pack.hulls().map(|hull| hull.volume()).sum();
        let expected: f64 = boxes.iter().map(|(_, size, _)| 8.0 * size.element_product()).sum();
        assert!(pack.hull_count() == 5 && (volume - expected).abs() < 1e-5, "{volume} {expected}");
    }
}

#[test]
fn round_bodies_are_exported_as_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let flat = lathe(&[[0.0, -1.5], [0.8, -1.5], [0.8, 1.5], [0.0, 1.5]], 40);
    for (name, mesh, sizes) in [
        ("sphere", rounded(0.0), vec![1.0]),
        ("capsule", rounded(1.5), vec![1.0, 1.5]),
        ("cylinder", flat, vec![0.8, 1.5]),
    ] {
        fs::write(folder.path().join(format!("{name}.obj")), text(&mesh)).unwrap();
        bake(&folder, &format!("build {name}.obj --out baked --decompose --set primitives=true")).expect(0);
        bake(&folder, &format!("export baked/{name}.hullmap --for mjcf --out {name}")).expect(0);
        let text = fs::read_to_string(folder.path().join(format!("{name}/{name}.xml"))).unwrap();
        assert!(text.contains(&format!("type=\"{name}\"")), "{text}");
        let found = numbers(text.split("<geom ").nth(1).unwrap(), "size");
        assert!(found.len() == sizes.len() && found.iter().zip(&sizes).all(|(a, b)| (a - b).abs() < 0.1), "{found:?}");
        let json = bake(&folder, &format!("inspect baked/{name}.hullmap --json")).expect(0).json()[0].clone();
        let primitive = &json["hulls"][0]["primitive"];
        assert!(primitive["kind"] == name && primitive["protrusion"].as_f64().unwrap() < 0.1, "{json}");
        // A URDF has no capsules.
        bake(&folder, &format!("export baked/{name}.hullmap --for urdf --out {name}-urdf")).expect(0);
        let text = fs::read_to_string(folder.path().join(format!("{name}-urdf/{name}.urdf"))).unwrap();
        assert_eq!(text.contains("<mesh "), name == "capsule", "{text}");
    }
}

#[test]
fn wrong_primitives_fail_verify() {
    let (folder, _) = baked_table();
    let file = fs::read(folder.path().join("baked/table.hullmap")).unwrap();
    let size = Pack::from_bytes(&file).unwrap().hull(0).unwrap().primitive().unwrap().sizes[0];
    for (factor, exit, expected) in [
        (1.0, 0, ""),
        (0.99, 1, "is in this part, but not in the box that may replace it"),
        (1.5, 1, "outside the solid, but the pack records at most"),
    ] {
        let edited = with_record(&file, Further::Primitives, 0, 64, &(factor * size).to_le_bytes());
        write(&folder, "baked/table.hullmap", edited);
        let found = bake(&folder, "verify baked --source table.obj --json --directions 100").expect(exit).stdout;
        assert!(found.contains(expected), "{factor}: {found}");
    }
}
