//! Convex parts, from the command to the runtime. Records of packs are compared with figures found
//! here by other means, and `bake verify` finds wrong ones.

use std::fs;

use glam::DVec3;
use hullmap::{Cache, Compound, Hull, Pack, Pose, Settings};
use hullmap_bake::{
    BakedHull, IndexKind, NO_SOURCE_VERTEX, PointSet, SolidKind, SourceRecord, bake_hull, fit::fits, write_pack,
};
use hullmap_format::{archive::ArchivedHullRecord, header::source_hash, version::EXTENDED_FORMAT_VERSION};
use hullmap_testkit::command::bake_line as bake;
use hullmap_testkit::files::{folder, write};
use hullmap_testkit::packs::{self, Further};
use hullmap_tests::hostile::patch::{archive, changed, payload};
use shapes::{concave, families::Family, obj, rng::SplitMix64};
use tempfile::TempDir;

/// A U of three bars, as boxes that touch.
const HORSESHOE: [[[f64; 3]; 2]; 3] =
    [[[0.0, 0.0, 0.0], [3.0, 1.0, 1.0]], [[0.0, 1.0, 0.0], [1.0, 3.0, 1.0]], [[2.0, 1.0, 0.0], [3.0, 3.0, 1.0]]];

/// Faces of a box, whose corners are numbered by their signs.
const QUADS: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// An OBJ file of boxes, each in the object of its name, or in the object before it if the name is
/// empty.
pub fn boxes(boxes: &[(&str, [[f64; 3]; 2])]) -> String {
    let mut text = String::new();
    for (index, (name, bounds)) in boxes.iter().enumerate() {
        if !name.is_empty() {
            text += &format!("o {name}\n");
        }
        for i in 0..8 {
            let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| bounds[i >> axis & 1][axis]);
            text += &format!("v {x} {y} {z}\n");
        }
        for quad in QUADS {
            let [a, b, c, d] = quad.map(|corner| corner + 8 * index + 1);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

fn horseshoe(name: &str) -> String {
    let [base, left, right] = HORSESHOE;
    boxes(&[(name, base), ("", left), ("", right)])
}

#[test]
fn a_decomposed_mesh_has_its_gaps_and_is_verified() {
    let (folder, file) = baked_horseshoe("--verify");
    let pack = Pack::from_bytes(&file).unwrap();
    assert!((2..40).contains(&pack.hull_count()), "{}", pack.hull_count());
    let is_named =
        |(index, hull): (usize, Hull)| hull.part() as usize == index && hull.name() == format!("x_part_{index:02}");
    assert!(pack.hulls().enumerate().all(is_named));
    let report = bake(&folder, "verify baked --json").expect(0).json().remove(0);
    assert!(report["against"] == "source" && report["uncovered"].as_f64().unwrap() < 1e-6, "{report}");

    // A small ball: inside a bar or not, by the bars themselves.
    let whole = Compound::new(&pack);
    let ball: Vec<[f32; 3]> = Family::Sphere.points(200, 1).iter().map(|p| p.map(|c| 0.05 * c)).collect();
    let ball = packs::tree_pack(&ball);
    let ball = Compound::new(&ball);
    let (mut cache, mut rng) = (Cache::new(), SplitMix64::new(8));
    let (mut hits, mut in_hull) = (0, 0);
    for _ in 0..4_000 {
        let p = DVec3::new(rng.between(-0.5, 3.5), rng.between(-0.5, 3.5), rng.between(0.0, 1.0));
        let away = |[low, high]: [[f64; 3]; 2]| {
            (DVec3::from_array(low) - p).max(p - DVec3::from_array(high)).max(DVec3::ZERO).length()
        };
        let gap = HORSESHOE.into_iter().map(away).fold(f64::INFINITY, f64::min);
        // The ball is a polytope, and the parts protrude by up to 2 %. Distances within this
        // tolerance are undecided.
        if (gap - 0.05).abs() < 0.02 {
            continue;
        }
        let pose = Pose::from_translation(p).unwrap();
        let hit = hullmap::intersects(&whole, &ball, pose, &mut cache).is_hit();
        assert!(hit || gap > 0.05, "{p} is in a bar");
        hits += usize::from(hit);
        in_hull += usize::from((0.0..3.0).contains(&p.x) && (0.0..3.0).contains(&p.y));
        if gap > 0.2 {
            let found = hullmap::distance(&whole, &ball, pose, &Settings::default(), &mut cache);
            assert!((found.distance - (gap - 0.05)).abs() < 0.06, "{p}: {} {gap}", found.distance);
        }
    }
    println!("{hits} hits, {in_hull} in the hull of all");
    assert!(hits > 1_000 && hits + 300 < in_hull, "the gap between the arms is free: {hits} {in_hull}");
}

/// Verifies a pack of `x.obj` in the folder, and returns the problems of all rows as text.
fn verified(folder: &TempDir, file: &[u8], exit: i32) -> String {
    write(folder, "false/x.hullmap", file);
    let rows = bake(folder, "verify false --source x.obj --json --directions 200").expect(exit).json();
    assert!(rows.iter().any(|row| row["pass"] == (exit == 0)), "{rows:?}");
    rows.iter().map(|row| row["problems"].to_string()).collect()
}

/// The same after the recorded lengths of all hulls were multiplied by [`OVERSTATED`].
fn overstated(folder: &TempDir, file: &[u8], which: fn(&ArchivedHullRecord) -> &rkyv::rend::f64_le) -> String {
    let count = Pack::from_bytes(file).unwrap().hull_count();
    let edited = (0..count).fold(file.to_vec(), |file, hull| {
        let payload = payload(&file);
        let length = which(&archive(&payload).hulls[hull]).to_native() * OVERSTATED;
        changed(&file, |pack| which(&pack.hulls[hull]), &length.to_le_bytes())
    });
    verified(folder, &edited, 1)
}

/// A folder with the U as `x.obj`, and the bytes of its pack.
fn baked_horseshoe(options: &str) -> (TempDir, Vec<u8>) {
    let folder = folder(&[("x.obj", &horseshoe("u"))]);
    bake(&folder, &format!("build x.obj --out baked --decompose {options}")).expect(0);
    let file = fs::read(folder.path().join("baked/x.hullmap")).unwrap();
    (folder, file)
}

/// A recorded bound is at most 0.5 % above the truth: 1.5 % less is at least 1 % below it.
const OVERSTATED: f64 = 0.985;

/// Asserts that a pack passes, and fails if it claims that its parts cover more, or protrude less,
/// than they do.
fn assert_claims_are_tight(folder: &TempDir, file: &[u8], has_gaps: bool) {
    let pack = Pack::from_bytes(file).unwrap();
    verified(folder, file, 0);
    let found = overstated(folder, file, |record| &record.protrusion);
    assert!(found.contains("outside the solid of"), "{found}");
    if has_gaps {
        let found = overstated(folder, file, |record| &record.uncovered);
        assert!(found.contains("outside all parts"), "{found}");
    }
    // The recorded points may be elsewhere; the truth is found without them.
    let moved = pack.hulls().enumerate().fold(file.to_vec(), |file, (index, hull)| {
        let vertex = hull.vertex(0).unwrap().as_dvec3();
        (0..3).fold(file, |file, axis| {
            changed(&file, |pack| &pack.hulls[index].protrusion_at[axis], &vertex[axis].to_le_bytes())
        })
    });
    verified(folder, &moved, 0);
    overstated(folder, &moved, |record| &record.protrusion);
    let far = changed(file, |pack| &pack.hulls[0].protrusion_at[1], &1e3_f64.to_le_bytes());
    assert!(verified(folder, &far, 1).contains("is not a point of the part"));
}

#[test]
fn overstated_covers_and_protrusions_fail() {
    let (folder, file) = baked_horseshoe("--max-parts 2");
    assert_claims_are_tight(&folder, &file, false);
    write(&folder, "x.obj", obj::text(&concave::horseshoe(8)));
    bake(&folder, "build x.obj --out baked --decompose --max-parts 4").expect(0);
    assert_claims_are_tight(&folder, &fs::read(folder.path().join("baked/x.hullmap")).unwrap(), false);
}

/// The recorded mass of the U is the mass of its three bars: a sum of boxes. Its parts are the
/// bars, which leave no voids. Packs that record other numbers are rejected.
#[test]
fn wrong_masses_and_voids_fail_verify() {
    let (folder, file) = baked_horseshoe("");
    let (mut volume, mut moment, mut second) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for [low, high] in HORSESHOE.map(|bar| bar.map(DVec3::from_array)) {
        let box_volume = (high - low).element_product();
        volume += box_volume;
        moment += box_volume * (low + high) / 2.0;
        second += box_volume * (low * low + low * high + high * high) / 3.0;
    }
    let centre = moment / volume;
    let second = second / volume - centre * centre;
    let pack = Pack::from_bytes(&file).unwrap();
    assert_eq!(pack.header().format_version, EXTENDED_FORMAT_VERSION);
    let recorded = pack.hull(0).unwrap().mesh_mass_properties(1.0).unwrap();
    assert!((recorded.mass - volume).abs() < 1e-9 && recorded.center_of_mass.distance(centre) < 1e-9);
    let about_x = volume * (second.y + second.z);
    assert!((recorded.inertia.x_axis.x - about_x).abs() < 1e-9, "{recorded:?} {about_x}");
    let voids = pack.hull(0).unwrap().voids().unwrap();
    assert!(voids.share <= voids.error && voids.error < 1e-3, "{voids:?}");
    assert!(pack.hulls().all(|hull| hull.voids() == Some(voids)));
    assert_eq!(verified(&folder, &file, 0).replace("[]", ""), "");
    let with_voids = |at: usize, share: f32| packs::with_record(&file, Further::Voids, 0, at, &share.to_le_bytes());
    for (wrong, expected) in [
        (
            changed(&file, |pack| &pack.masses[0].volume, &(volume * 1.001).to_le_bytes()),
            "the volume of x is 7, but the pack records 7.007",
        ),
        (
            changed(&file, |pack| &pack.masses[0].centroid[1], &(centre.y + 1e-6).to_le_bytes()),
            "the centre of mass of x is at 1.5 ",
        ),
        (
            changed(&file, |pack| &pack.masses[0].second_moments[0], &(second.x * 1.001).to_le_bytes()),
            "the recorded inertia is not the inertia of x",
        ),
        (with_voids(4, 0.25), "the share of x in no part is "),
        (with_voids(8, 0.0), "but the pack records"),
    ] {
        let found = verified(&folder, &wrong, 1);
        assert!(found.contains(expected), "{expected}: {found}");
    }
    let described = bake(&folder, "inspect baked/x.hullmap --json").expect(0).json();
    let of_hull = &described[0]["hulls"][0];
    // The numbers are read back to within a digit of f64.
    let is_same = |field: &str, stored: f64| (of_hull[field].as_f64().unwrap() - stored).abs() <= 1e-15 * stored;
    assert!(is_same("voids", voids.share) && is_same("voids_error", voids.error), "{of_hull} {voids:?}");
}

/// Packs of versions that had V-HACD: they open, and are stale with a reason.
#[test]
fn packs_of_removed_options_open_and_are_stale() {
    let folder = folder(&[("x.obj", &horseshoe("u"))]);
    let positions = HORSESHOE.iter().flatten().map(|corner| corner.map(|c| c as f32)).collect();
    let points = PointSet { source_vertices: (0..6).collect(), positions, ..PointSet::default() };
    let hull = bake_hull(&points, IndexKind::Tree).unwrap();
    let hash = source_hash(&fs::read(folder.path().join("x.obj")).unwrap());
    let options = "split none, vertices referenced, index tree 8, decompose true, vhacd_max_parts 2".to_owned();
    let record = SourceRecord { path: "x.obj".into(), hash, options: options.clone(), ..SourceRecord::default() };
    fs::write(folder.path().join("x.hullmap"), write_pack(&[hull], &record).unwrap()).unwrap();
    let described = bake(&folder, "inspect x.hullmap --json").expect(0).json();
    assert_eq!(described[0]["options"], options);
    let row = bake(&folder, "build x.obj --out . --decompose --check --json").expect(1).json()[0].clone();
    assert_eq!(row["status"], "stale", "{row}");
    for (message, words) in [
        (bake(&folder, "verify x.hullmap").expect(1).stderr, ["V-HACD was removed", "bake it again"]),
        (row["reason"].to_string(), ["decompose true, vhacd_max_parts 2` to `", "V-HACD was removed"]),
        (bake(&folder, "build x.obj --out . --decompose=vhacd").expect(2).stderr, ["V-HACD was removed", ""]),
    ] {
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    assert_eq!(bake(&folder, "build x.obj --out . --decompose --json").expect(0).json()[0]["status"], "baked");
}

/// Parts that another program cut: they are judged against the mesh, whatever made them.
#[test]
fn packs_made_by_hand_are_judged_as_well() {
    let folder = folder(&[("x.obj", &horseshoe("u"))]);
    let corners =
        |bar: &[[f64; 3]; 2]| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [0, 1, 2].map(|axis| bar[i >> axis & 1][axis] as f32));
    let positions: Vec<[f32; 3]> = HORSESHOE.iter().flat_map(corners).collect();
    let of_quad = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    let triangles =
        (0..3).flat_map(|bar| QUADS.into_iter().flat_map(of_quad).map(move |t| t.map(|v| (v + 8 * bar) as u32)));
    let mesh = PointSet {
        name: "x".into(),
        source_vertices: (0..24).collect(),
        triangles: triangles.collect(),
        positions,
        ..PointSet::default()
    };
    // The left arm with half of the base, and the right arm: what is left of the base is a gap.
    let parts = [vec![0, 2, 4, 6, 8, 9, 10, 11, 12, 13, 14, 15], (16..24).collect::<Vec<usize>>()];
    let baked = |part: &Vec<usize>| {
        let positions = part.iter().map(|v| mesh.positions[*v]).collect();
        let source_vertices = part.iter().map(|v| *v as u32).collect();
        let points = PointSet { positions, source_vertices, triangles: Vec::new(), ..mesh.clone() };
        bake_hull(&points, IndexKind::None).unwrap()
    };
    let mut hulls: Vec<BakedHull> = parts.iter().map(baked).collect();
    // A point beyond the left arm, so that it protrudes by a known length.
    let mut points = mesh.positions[8..16].to_vec();
    points.push([0.5, 3.5, 0.5]);
    let beyond = PointSet { source_vertices: vec![NO_SOURCE_VERTEX; 9], positions: points, ..PointSet::default() };
    hulls.push(bake_hull(&beyond, IndexKind::None).unwrap());
    let fits = fits(&mesh, &hulls.iter().map(|baked| &baked.hull).collect::<Vec<_>>(), None).unwrap();
    for (index, (baked, fit)) in hulls.iter_mut().zip(fits).enumerate() {
        (baked.part, baked.part_count, baked.fit) = (index as u32, 3, Some(fit));
    }
    let apex = hulls[2].fit.unwrap();
    assert!((0.5..0.5026).contains(&apex.protrusion), "{apex:?}");
    // At (x, 0), the edge from (0, 0) to (1, 1) is x / √2 away, and the right arm √((2 − x)² + 1).
    // Both are equal at x = 4 − √6.
    let truth = (4.0 - 6_f64.sqrt()) / 2_f64.sqrt();
    assert!((truth..1.006 * truth).contains(&apex.uncovered), "{apex:?}");
    let hash = source_hash(&fs::read(folder.path().join("x.obj")).unwrap());
    let options = "split none, vertices referenced, index tree 8".to_owned();
    let file =
        write_pack(&hulls, &SourceRecord { path: "x.obj".into(), hash, options, ..SourceRecord::default() }).unwrap();
    assert_claims_are_tight(&folder, &file, true);
    // A kind of solid other than the mesh's.
    let sheet = SolidKind::Walls.code().to_le_bytes();
    let file = (0..3).fold(file, |file, hull| changed(&file, |pack| &pack.hulls[hull].solid, &sheet));
    let found = verified(&folder, &file, 1);
    assert!(found.contains("is recorded as walls, but it is watertight"), "{found}");
}
