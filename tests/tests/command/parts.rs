//! Simplified hulls and convex parts, from the command to the runtime. Recorded errors are measured
//! here by other means.

use std::fs;

use glam::{DVec3, Vec3};
use hullmap::{Cache, Compound, CompoundCache, Pack, Pose, Settings, compound};
use hullmap_testkit::packs::reseal;
use hullmap_tests::command::{Run, bake_in};
use shapes::{families::Family, rng::SplitMix64};
use tempfile::TempDir;

/// A U of three bars, as boxes that touch.
const HORSESHOE: [[[f64; 3]; 2]; 3] =
    [[[0.0, 0.0, 0.0], [3.0, 1.0, 1.0]], [[0.0, 1.0, 0.0], [1.0, 3.0, 1.0]], [[2.0, 1.0, 0.0], [3.0, 3.0, 1.0]]];

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

fn horseshoe(name: &str) -> String {
    let mut text = format!("o {name}\n");
    for [low, high] in HORSESHOE {
        for i in 0..8 {
            let corner: [f64; 3] = std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
            text += &format!("v {} {} {}\n", corner[0], corner[1], corner[2]);
        }
    }
    for first in [1, 9, 17] {
        for quad in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            let [a, b, c, d] = quad.map(|corner| corner + first);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

fn points(points: &[[f32; 3]]) -> String {
    points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

#[test]
fn a_decomposed_mesh_has_its_gaps_and_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("u.obj"), horseshoe("u")).unwrap();
    let run = bake(&folder, "build u.obj --out baked --decompose --verify --json").expect(0);
    let row = &run.json()[0];
    let parts = row["hulls"].as_u64().unwrap() as usize;
    assert!((2..40).contains(&parts), "{row}");
    assert!(row["notes"].to_string().contains(&format!("{parts} parts")), "{row}");
    for report in bake(&folder, "verify baked --json").expect(0).json() {
        assert_eq!((&report["pass"], report["against"].as_str()), (&true.into(), Some("source")), "{report}");
        assert!(report["uncovered"].as_f64().unwrap() < 1e-6, "{report}");
    }
    let pack = Pack::open(folder.path().join("baked/u.hullmap")).unwrap();
    assert!(
        pack.hulls()
            .enumerate()
            .all(|(index, hull)| { hull.part() as usize == index && hull.name() == format!("u_part_{index:02}") })
    );

    // A small ball: inside a bar or not, by the bars themselves.
    let whole = Compound::new(&pack);
    let ball: Vec<[f32; 3]> = Family::Sphere.points(200, 1).iter().map(|p| p.map(|c| 0.05 * c)).collect();
    fs::write(folder.path().join("ball.obj"), points(&ball)).unwrap();
    bake(&folder, "build ball.obj --out baked").expect(0);
    let ball = Pack::open(folder.path().join("baked/ball.hullmap")).unwrap();
    let ball = Compound::new(&ball);
    let (mut cache, mut rng) = (CompoundCache::default(), SplitMix64::new(8));
    let (mut hits, mut in_hull) = (0, 0);
    for _ in 0..4_000 {
        let p = DVec3::new(rng.between(-0.5, 3.5), rng.between(-0.5, 3.5), rng.between(0.0, 1.0));
        let away = |[low, high]: [[f64; 3]; 2]| {
            (DVec3::from_array(low) - p).max(p - DVec3::from_array(high)).max(DVec3::ZERO).length()
        };
        let gap = HORSESHOE.into_iter().map(away).fold(f64::INFINITY, f64::min);
        // The ball is a polytope, and the parts are clipped by voxels. Distances within this
        // tolerance are undecided.
        if (gap - 0.05).abs() < 0.02 {
            continue;
        }
        let pose = Pose::from_translation(p).unwrap();
        let hit = compound::intersects(&whole, &ball, pose, &mut cache).answer.is_hit();
        assert!(hit || gap > 0.05, "{p} is in a bar");
        hits += usize::from(hit);
        in_hull += usize::from((0.0..3.0).contains(&p.x) && (0.0..3.0).contains(&p.y));
        if gap > 0.2 {
            let found = compound::distance(&whole, &ball, pose, &Settings::default(), &mut cache).answer;
            assert!((found.distance - (gap - 0.05)).abs() < 0.06, "{p}: {} {gap}", found.distance);
        }
    }
    println!("{hits} hits, {in_hull} in the hull of all");
    assert!(hits > 1_000 && hits + 300 < in_hull, "the gap between the arms is free: {hits} {in_hull}");
}

#[test]
fn parts_have_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("u.obj"), horseshoe("u")).unwrap();
    fs::write(folder.path().join("rock.obj"), points(&Family::Rock.points(800, 3))).unwrap();
    let bytes = |jobs: u32| {
        let line = format!("build u.obj rock.obj --out out{jobs} --decompose --max-vertices 24 --jobs {jobs}");
        bake(&folder, &line).expect(0);
        ["u", "rock"].map(|stem| fs::read(folder.path().join(format!("out{jobs}/{stem}.hullmap"))).unwrap())
    };
    let one = bytes(1);
    assert!(bytes(2) == one && bytes(16) == one);
}

#[test]
fn a_simplified_hull_contains_its_source_and_records_its_outer_error() {
    let folder = tempfile::tempdir().unwrap();
    let source = Family::Rock.points(3_000, 5);
    fs::write(folder.path().join("rock.obj"), points(&source)).unwrap();
    bake(&folder, "build rock.obj --out few --max-vertices 48 --verify").expect(0);
    bake(&folder, "build rock.obj --out near --max-error 0.01 --verify").expect(0);
    bake(&folder, "build rock.obj --out all --max-vertices 3000").expect(0);
    let table = bake(&folder, "verify few").expect(0).stdout;
    assert!(
        table.contains("contains its source  ") && table.contains("\n0 exact, 1 simplified, 0 failed; "),
        "{table}"
    );
    let mut rng = SplitMix64::new(9);
    let mut counts = Vec::new();
    for (folder_name, is_exact) in [("few", false), ("near", false), ("all", true)] {
        let pack = Pack::open(folder.path().join(folder_name).join("rock.hullmap")).unwrap();
        let hull = pack.hull(0).unwrap();
        counts.push(hull.vertex_count());
        assert_eq!(hull.outer_error() == 0.0, is_exact, "{folder_name}");
        assert_eq!(hull.source_vertex(0).is_some(), is_exact);
        let mut max_outside = 0.0_f64;
        for _ in 0..5_000 {
            let dir = Vec3::from_array(rng.direction().map(|c| c as f32));
            let reach = |p: Vec3| p.as_dvec3().dot(dir.as_dvec3()) / dir.as_dvec3().length();
            let theirs = source.iter().map(|p| reach(Vec3::from_array(*p))).fold(f64::NEG_INFINITY, f64::max);
            let outside = reach(hull.support(dir).point) - theirs;
            assert!(outside >= -1e-12 && outside <= hull.outer_error() + 1e-12, "{folder_name}: {outside:e}");
            max_outside = max_outside.max(outside);
        }
        assert!(max_outside >= 0.5 * hull.outer_error(), "{folder_name}: {max_outside} of {}", hull.outer_error());
        let report = &bake(&folder, &format!("verify {folder_name} --json")).expect(0).json()[0];
        let is_stated = |value: &serde_json::Value| {
            value["outer_error"].as_f64().is_some_and(|error| (error - hull.outer_error()).abs() <= 1e-12)
        };
        assert!(is_stated(report), "{report}");
        let shown =
            &bake(&folder, &format!("inspect {folder_name}/rock.hullmap --json")).expect(0).json()[0]["hulls"][0];
        assert!(is_stated(shown), "{shown}");
    }
    println!("{counts:?} vertices");
    assert!(counts[0] <= 48 && counts[1] < counts[2] && counts[1] > 48, "{counts:?}");
}

/// `verify` measures the recorded error again. If the record is too small, it fails and prints the
/// measured error.
#[test]
fn a_simplified_hull_with_too_small_a_recorded_error_fails_verify() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rock.obj"), points(&Family::Rock.points(400, 5))).unwrap();
    bake(&folder, "build rock.obj --out few --max-vertices 48 --verify").expect(0);
    let path = folder.path().join("few/rock.hullmap");
    let promise = Pack::open(&path).unwrap().hull(0).unwrap().outer_error();
    for (share, exit) in [(1.01, 0), (0.99, 1), (0.5, 1)] {
        let mut file = fs::read(&path).unwrap();
        let offsets: Vec<usize> =
            file.windows(8).enumerate().filter(|(_, w)| **w == promise.to_le_bytes()).map(|(at, _)| at).collect();
        let [at] = offsets[..] else { panic!("{promise:e} at {offsets:?}") };
        file[at..at + 8].copy_from_slice(&(promise * share).to_le_bytes());
        reseal(&mut file);
        fs::create_dir_all(folder.path().join("false")).unwrap();
        fs::write(folder.path().join("false/rock.hullmap"), file).unwrap();
        let ran = bake(&folder, "verify false --source rock.obj --json").expect(exit);
        let row = &ran.json()[0];
        assert_eq!(row["pass"], exit == 0, "{share}: {row}");
        println!("{share}: {row}");
    }
}

/// With a whole pack on one side or both, `bake query` answers for the deciding pair of hulls, and
/// names it.
#[test]
fn the_command_queries_whole_packs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("u.obj"), horseshoe("u")).unwrap();
    bake(&folder, "build u.obj --out baked --decompose").expect(0);
    let file = "baked/u.hullmap";
    let query = |b: &str, mode: &str, x: f64| {
        let pose = format!("{x} 0 0 0 0 0 1");
        let words = ["query", file, b, "--mode", mode, "--json", "--pose", &pose];
        bake_in(folder.path(), words).expect(0).json().remove(0)
    };
    let pack = Pack::open(folder.path().join(file)).unwrap();
    let pose = Pose::from_translation(DVec3::new(3.5, 0.0, 0.0)).unwrap();
    let slow = pack
        .hulls()
        .flat_map(|a| pack.hulls().map(move |b| (a, b)))
        .map(|(a, b)| hullmap::distance(&a, &b, pose, &Settings::default(), &mut Cache::new()).distance);
    let slow = slow.fold(f64::INFINITY, f64::min);
    let answer = query(file, "distance", 3.5);
    assert!((answer["distance"].as_f64().unwrap() - slow).abs() < 1e-5 && (slow - 0.5).abs() < 1e-5, "{answer}");
    assert!(answer["hull_a"].as_str().unwrap().starts_with("u_part_"), "{answer}");
    let answer = query(file, "contact", 2.75);
    assert_eq!((&answer["hit"], answer["depth"].as_f64().unwrap() > 0.1), (&true.into(), true), "{answer}");
    assert_eq!(query(file, "contact", 4.0)["hit"], false);
    assert_eq!(query(file, "intersect", 2.9)["hit"], true);
    let table = bake(&folder, &format!("query {file} {file} --mode distance")).expect(0).stdout;
    assert!(table.contains("hull of A") && table.lines().nth(1).unwrap().matches("u_part_").count() == 2, "{table}");
    assert!(!bake(&folder, &format!("query {file}#0 {file}#1")).expect(0).stdout.contains("hull of A"));
    let one = query("baked/u.hullmap#0", "distance", 30.0);
    assert!(one["distance"].as_f64().unwrap() > 20.0 && one["hull_b"].is_string(), "{one}");
}
