use shapes::{concave, mesh::Mesh, rng::SplitMix64};

use super::*;
use crate::decompose::{Cover, Length, Method, decompose};
use crate::parts::uncovered::uncovered;

fn point_set(mesh: &Mesh) -> PointSet {
    PointSet {
        name: "mesh".into(),
        positions: mesh.vertices.clone(),
        source_vertices: (0..mesh.vertices.len() as u32).collect(),
        triangles: mesh.fans(),
        ..PointSet::default()
    }
}

/// Searches, and checks both promises by other means: the certified cover, and random points of the
/// parts.
fn checked(mesh: &PointSet, share: f64) -> Vec<(Hull, f64)> {
    let solid = Solid::new(mesh);
    let limit = share * solid.diagonal();
    let found = search(mesh, &solid, &Search { limit, max_vertices: 64, deadline: None });
    let hulls: Vec<&Hull> = found.iter().map(|(hull, _)| hull).collect();
    let bound = uncovered(mesh, &hulls).bound;
    assert!(bound <= 1e-7 * solid.diagonal(), "{bound}");
    let mut rng = SplitMix64::new(1);
    for (hull, bound) in &found {
        assert!(*bound <= limit && hull.vertices.len() <= 64, "{bound} {}", hull.vertices.len());
        let points = hull.positions();
        for _ in 0..2_000 {
            let weights: Vec<f64> = points.iter().map(|_| -libm::log(rng.between(1e-9, 1.0))).collect();
            let total: f64 = weights.iter().sum();
            let p: DVec3 = points.iter().zip(&weights).map(|(p, w)| *p * (w / total)).sum();
            // Near the border, too.
            let q = p + (points[rng.below(points.len())] - p) * rng.between(0.0, 1.0);
            assert!([p, q].iter().all(|p| solid.distance(*p) <= limit * (1.0 + 1e-9)));
        }
    }
    found
}

#[test]
fn boxes_become_boxes() {
    let vertices = |found: Vec<(Hull, f64)>| found.iter().map(|(hull, _)| hull.vertices.len()).collect::<Vec<_>>();
    assert_eq!(vertices(checked(&point_set(&concave::l()), 0.001)), [8, 8]);
    assert_eq!(vertices(checked(&point_set(&concave::chair()), 0.001)), [8; 8]);
    assert_eq!(vertices(checked(&point_set(&concave::open_box()), 0.001)), [8; 5]);
}

#[test]
fn round_shapes_take_few_parts() {
    assert!(checked(&point_set(&concave::pipe(32)), 0.0142).len() <= 9);
    assert!(checked(&point_set(&concave::horseshoe(24)), 0.0178).len() <= 7);
}

#[test]
fn parts_are_the_same_at_any_number_of_threads() {
    let mesh = point_set(&concave::pipe(20));
    let of_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let method = Method::Cover(Cover { max_error: Length::Relative(0.02), ..Cover::default() });
        let parts = pool.install(|| decompose(&mesh, &method)).unwrap().unwrap();
        parts.into_iter().map(|part| (part.name, part.positions)).collect::<Vec<_>>()
    };
    let one = of_threads(1);
    assert!([2, 16].into_iter().all(|threads| of_threads(threads) == one));
}

#[test]
fn limits_of_parts_and_time_hold() {
    let mesh = point_set(&concave::horseshoe(12));
    let parts = |cover: Cover| decompose(&mesh, &Method::Cover(cover)).unwrap().unwrap();
    for max_parts in [1, 3] {
        let found = parts(Cover { max_parts: Some(max_parts), ..Cover::default() });
        assert!((1..=max_parts as usize).contains(&found.len()), "{}", found.len());
    }
    // Without time, the first cover is returned, and is proven all the same.
    let solid = Solid::new(&mesh);
    let limit = 0.02 * solid.diagonal();
    let what = Search { limit, max_vertices: 64, deadline: Some(Deadline::after(0.0)) };
    let found = search(&mesh, &solid, &what);
    assert!(found.iter().all(|(_, bound)| *bound <= limit));
    assert!(uncovered(&mesh, &found.iter().map(|(hull, _)| hull).collect::<Vec<_>>()).bound <= 1e-7 * solid.diagonal());
}

/// Random triangles, open, crossing each other, with duplicates and degenerate ones.
#[test]
fn triangle_soups_are_covered() {
    for seed in 0..12 {
        let mut rng = SplitMix64::new(seed);
        let far = [0.0, 1000.0][seed as usize % 2];
        let positions: Vec<[f32; 3]> =
            (0..12).map(|_| [0, 1, 2].map(|_| (far + rng.between(-1.0, 1.0)) as f32)).collect();
        let triangles: Vec<[u32; 3]> = (0..10).map(|_| [0, 1, 2].map(|_| rng.below(12) as u32)).collect();
        let mesh = PointSet { source_vertices: (0..12).collect(), positions, triangles, ..PointSet::default() };
        let solid = Solid::new(&mesh);
        let limit = 0.05 * solid.diagonal();
        let found = search(&mesh, &solid, &Search { limit, max_vertices: 64, deadline: None });
        let bound = uncovered(&mesh, &found.iter().map(|(hull, _)| hull).collect::<Vec<_>>()).bound;
        assert!(bound <= 1e-6 * solid.diagonal(), "seed {seed}: {bound}");
        assert!(found.iter().all(|(_, bound)| *bound <= limit), "seed {seed}");
    }
}
