//! Simplified hulls by means of their own: dot products for what is inside, nearest points of facets for what is outside.

use shapes::{families::Family, rng::SplitMix64};

use super::*;

fn build(positions: Vec<[f32; 3]>) -> Hull {
    let source_vertices = (0..positions.len() as u32).collect();
    hull::build(&PointSet { positions, source_vertices, ..PointSet::default() }).unwrap()
}

fn reach(hull: &Hull, direction: DVec3) -> f64 {
    hull.positions().iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}

/// Inside by support values, and outside by no more than is said.
fn assert_promise(name: &str, hull: &Hull, simplified: &Simplified, seed: u64) {
    let mut rng = SplitMix64::new(seed);
    let rounding = 1e-13 * hull.diameter + 1e-15 * hull.positions().iter().fold(0.0, |s: f64, p| s.max(p.length()));
    let slack = simplified.hull.containment_error * simplified.hull.diameter + rounding;
    let mut most = 0.0_f64;
    let nearest = Nearest::new(hull);
    let middle = hull.positions().iter().sum::<DVec3>() / hull.vertices.len() as f64;
    for round in 0..2_000 {
        let random = DVec3::from_array(rng.direction());
        // Towards the vertices it is farthest outside.
        let vertices = simplified.hull.positions();
        let direction = if round % 2 == 0 {
            random
        } else {
            let p = vertices[round / 2 % vertices.len()];
            let from = if hull.rank == 3 { nearest.certain(p).point } else { middle };
            (p - from).normalize_or_zero()
        };
        let outside = reach(&simplified.hull, direction) - reach(hull, direction);
        assert!(outside >= -slack, "{name}: {outside:e} in direction {direction}, seed {seed}");
        assert!(outside <= simplified.outer_error + rounding, "{name}: {outside} beyond {}", simplified.outer_error);
        most = most.max(outside);
    }
    assert!(most >= 0.5 * simplified.outer_error, "{name}: {} said, {most} found", simplified.outer_error);
}

#[test]
fn holds_the_hull_and_keeps_the_distance() {
    for family in Family::ALL {
        for far in [0.0_f32, 50.0] {
            let positions: Vec<[f32; 3]> = family.points(400, 1).iter().map(|p| [p[0] + far, p[1], p[2]]).collect();
            let hull = build(positions);
            let mut before = f64::INFINITY;
            for most in [4, 8, 16, 32, 64, 128] {
                let Some(found) = simplify(&hull, Limit::Vertices(most)).unwrap() else {
                    assert!(hull.vertices.len() <= most || hull.rank < 2, "{family:?} {most}");
                    continue;
                };
                assert!(found.hull.vertices.len() <= most, "{family:?} {most}");
                assert!(found.hull.containment_error == 0.0 || hull.rank == 2, "{family:?} {most}");
                assert!(found.hull.source_vertices.iter().all(|v| *v == NO_SOURCE_VERTEX));
                assert_promise(family.name(), &hull, &found, most as u64);
                assert!(found.outer_error <= before * 1.05, "{family:?} {most}: {} {before}", found.outer_error);
                before = found.outer_error;
            }
        }
    }
}

#[test]
fn a_distance_is_kept_with_few_vertices() {
    for family in Family::ALL {
        let hull = build(family.points(600, 2));
        let mut before = hull.vertices.len();
        for share in [1e-4, 1e-3, 1e-2, 1e-1] {
            let distance = share * hull.diameter;
            let Some(found) = simplify(&hull, Limit::Distance(distance)).unwrap() else { continue };
            assert!(found.outer_error <= distance, "{family:?} {share}");
            assert!(
                found.hull.vertices.len() < hull.vertices.len() && found.hull.vertices.len() <= before + 2,
                "{family:?}"
            );
            before = found.hull.vertices.len();
            assert_promise(family.name(), &hull, &found, 9);
        }
        assert!(before <= hull.vertices.len().min(40), "{family:?}: {before}");
    }
}

#[test]
fn limits_that_are_none_are_refused_and_those_kept_change_nothing() {
    let hull = build(Family::Rock.points(300, 1));
    assert!(matches!(simplify(&hull, Limit::Vertices(3)), Err(BakeError::TooFewVertices { asked: 3 })));
    assert!(simplify(&hull, Limit::Distance(-1.0)).is_err() && simplify(&hull, Limit::Distance(f64::NAN)).is_err());
    assert!(simplify(&hull, Limit::Distance(0.0)).unwrap().is_none());
    assert!(simplify(&hull, Limit::Vertices(hull.vertices.len())).unwrap().is_none());
    assert!(simplify(&build(vec![[0.0; 3], [1.0, 2.0, 3.0]]), Limit::Vertices(4)).unwrap().is_none());
}

/// A sphere tells how good it is: the best known polytopes of n vertices around a ball leave it by about 2.42 / n of its radius.
#[test]
fn a_ball_is_left_by_less_than_twice_the_best_known() {
    let hull = build(Family::Sphere.points(5_000, 1));
    for most in [16, 64, 256] {
        let found = simplify(&hull, Limit::Vertices(most)).unwrap().unwrap();
        let error = found.outer_error / (0.5 * hull.diameter);
        println!("{most} vertices: {error:.5} of the radius, {:.2} times the best known", error * most as f64 / 2.42);
        assert!(error * most as f64 <= 2.0 * 2.42, "{most}: {error}");
    }
}

/// For people: `cargo test -p hullmap-bake simplify::tests::table -- --ignored --nocapture`, with MESHES naming a folder of OBJ files.
#[test]
#[ignore = "prints a table"]
fn table() {
    let mut sets: Vec<(String, Vec<[f32; 3]>)> = Family::ALL
        .iter()
        .map(|family| {
            (
                family.name().to_owned(),
                family.points(std::env::var("POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000), 1),
            )
        })
        .collect();
    let folder = std::env::var("MESHES").ok().and_then(|folder| std::fs::read_dir(folder).ok());
    let mut paths: Vec<_> = folder.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths.iter().filter(|path| path.extension().is_some_and(|extension| extension == "obj")) {
        let text = std::fs::read_to_string(path).unwrap();
        let number = |line: &str| line.split_whitespace().take(3).map(|c| c.parse().unwrap()).collect::<Vec<f32>>();
        let points =
            text.lines().filter_map(|line| line.strip_prefix("v ")).map(|line| number(line)[..3].try_into().unwrap());
        sets.push((path.file_stem().unwrap().to_string_lossy().into_owned(), points.collect()));
    }
    for (name, points) in sets {
        let hull = build(points);
        let mut line = format!("| {name} | {} |", hull.vertices.len());
        let start = std::time::Instant::now();
        for most in [16, 32, 64, 128, 256] {
            let found = simplify(&hull, Limit::Vertices(most)).unwrap();
            line += &found.map_or(" exact |".into(), |found| format!(" {:.2e} |", found.outer_error / hull.diameter));
        }
        println!("{line} {:.2} s", start.elapsed().as_secs_f64());
    }
}
