use shapes::{concave, families::Family, rng::SplitMix64};

use super::{body::Body, *};
use crate::decompose::{Cover, Length, decompose};
use crate::fit::{Accuracy, Solid, coverage::uncovered, protrusion};
use crate::hull::Hull;
use crate::test_meshes::{self, block, hull_of, hulls_of, joined, on_threads, point_set, surface_of};
use hullmap_geometry::PointSet;

fn limits(limit: f64, solid: &Solid) -> PartitionLimits<'static> {
    let (thickness, diagonal, stage) = (0.5 * limit, solid.diagonal(), Stage::default());
    let bounds = HullLimits { limit, max_vertices: 64, diagonal, thickness, deadline: None, stage };
    PartitionLimits { bounds, most: usize::MAX, wanted: 1, bridges: false }
}

/// Searches, and checks both promises: by the certified cover, and at random points of the parts.
fn checked(mesh: &PointSet, share: f64) -> Vec<Part> {
    let solid = Solid::new(mesh);
    let limit = share * solid.diagonal();
    let surface = Surface::new(mesh, &solid);
    let found = search(&surface, &mut Field::new(&solid), &limits(limit, &solid)).unwrap().whole;
    let hulls: Vec<&Hull> = found.iter().map(|part| &part.hull).collect();
    let bound = uncovered(mesh, &hulls).bound;
    assert!(bound <= 1e-7 * solid.diagonal(), "{bound}");
    let mut rng = SplitMix64::new(1);
    for Part { hull, bound, .. } in &found {
        assert!(*bound <= limit && hull.vertices.len() <= 64, "{bound} {}", hull.vertices.len());
        let points = hull.positions();
        for _ in 0..2_000 {
            let weights: Vec<f64> = points.iter().map(|_| -libm::log(rng.between(1e-9, 1.0))).collect();
            let total: f64 = weights.iter().sum();
            let p: DVec3 = points.iter().zip(&weights).map(|(p, w)| *p * (w / total)).sum();
            let q = p + (points[rng.below(points.len())] - p) * rng.between(0.0, 1.0);
            assert!([p, q].iter().all(|p| solid.distance(*p) <= limit * (1.0 + 1e-9)));
        }
    }
    found
}

#[test]
fn boxes_become_boxes() {
    let vertices = |found: Vec<Part>| found.iter().map(|part| part.hull.vertices.len()).collect::<Vec<_>>();
    assert_eq!(vertices(checked(&point_set(&concave::l()), 0.001)), [8, 8]);
    // Eight boxes, of which each of the back legs continues in a post.
    assert_eq!(checked(&point_set(&concave::chair()), 0.001).len(), 6);
    assert_eq!(vertices(checked(&point_set(&concave::open_box()), 0.001)), [8; 5]);
}

#[test]
fn round_shapes_take_few_parts() {
    let counts = [(concave::pipe(32), 0.0142), (concave::horseshoe(24), 0.0178)]
        .map(|(mesh, share)| checked(&point_set(&mesh), share).len());
    // The legs of the horseshoe stay flat.
    assert!(counts[0] <= 10 && counts[1] <= 7, "{counts:?}");
}

/// Nothing inside a cube protrudes, so the cheapest hull around a ball in it would be a box.
#[test]
fn hulls_do_not_swell_inside_the_solid() {
    let mesh = block([0.0; 3], [1.0; 3]);
    let solid = Solid::new(&mesh);
    let (limit, radius) = (0.012 * solid.diagonal(), 0.3 * solid.diagonal() / 3.0_f64.sqrt());
    let mut rng = SplitMix64::new(1);
    let middle = 0.5 * (solid.bounds()[0] + solid.bounds()[1]);
    let points: Vec<DVec3> = (0..500).map(|_| middle + radius * DVec3::from_array(rng.direction())).collect();
    let body = Body::new(&points, 0.0);
    let field = Field::new(&solid);
    let (hull, bound) = shape::shaped(&field, &body, &limits(limit, &solid).bounds).unwrap();
    let volume = crate::mass::mass(&hull).volume;
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!(hull.vertices.len() <= 64 && bound <= limit && volume >= body.volume());
    assert!(volume <= ball(radius + limit), "{volume}, {}", body.volume());
}

#[test]
fn parts_are_the_same_at_any_number_of_threads() {
    let mesh = point_set(&concave::pipe(8));
    let of_threads = |threads| {
        let parts = on_threads(threads, || decompose(&mesh, &Cover::default())).unwrap().unwrap();
        parts.into_iter().map(|part| (part.name, part.positions)).collect::<Vec<_>>()
    };
    let one = of_threads(1);
    assert!([2, 16].into_iter().all(|threads| of_threads(threads) == one));
}

fn covering(mesh: &PointSet, cover: Cover) -> Vec<Hull> {
    let parts = decompose(mesh, &cover).unwrap().unwrap();
    let hulls = hulls_of(&parts);
    let bound = uncovered(mesh, &hulls.iter().collect::<Vec<_>>()).bound;
    assert!(bound <= 1e-7 * Solid::new(mesh).diagonal(), "{bound}");
    hulls
}

fn farthest(mesh: &PointSet, hulls: &[Hull]) -> f64 {
    let solid = Solid::new(mesh);
    let accuracy = Accuracy::tight(solid.diagonal());
    hulls.iter().map(|hull| protrusion(&solid, hull, &accuracy).bound).fold(0.0, f64::max)
}

/// Five Ls in a row, and a triangle without area beside them.
fn blocks() -> PointSet {
    let beside = |i: i32| {
        let mut l = point_set(&concave::l());
        l.positions.iter_mut().for_each(|p| p[0] += 5.0 * i as f32);
        l
    };
    let line = vec![[30.0, 0.0, 0.0], [31.0, 0.0, 0.0], [32.0, 0.0, 0.0]];
    joined(&[(0..5).map(beside).collect(), vec![test_meshes::mesh(line, vec![[0, 1, 2]])]].concat())
}

#[test]
fn any_number_of_parts_is_reached() {
    let horseshoe = point_set(&concave::horseshoe(12));
    for mesh in [&horseshoe, &blocks()] {
        let mut least = f64::INFINITY;
        for max_parts in [1, 2, 3, 6] {
            let found = covering(mesh, Cover { max_parts: Some(max_parts), ..Cover::default() });
            assert!((1..=max_parts as usize).contains(&found.len()), "{} of {max_parts}", found.len());
            let reached = farthest(mesh, &found);
            assert!(reached <= 1.1 * least, "{max_parts} parts: {reached}, fewer: {least}");
            least = least.min(reached);
        }
    }
}

/// Regressions: mergers ended at the maximum, and an L had three parts; and five searches, each an
/// octave higher, ended before two parts of a horseshoe sufficed.
#[test]
fn no_more_parts_are_used_than_help() {
    let of_l = (2..=5).map(|max_parts| (concave::l(), max_parts, 0.02));
    for (mesh, max_parts, error) in of_l.chain([(concave::horseshoe(12), 2, 0.001)]) {
        let cover = Cover { max_parts: Some(max_parts), max_error: Length::Relative(error), ..Cover::default() };
        assert_eq!(covering(&point_set(&mesh), cover).len(), 2, "{max_parts} from {error}");
    }
}

#[test]
fn more_parts_are_used_where_they_help() {
    let mesh = point_set(&concave::horseshoe(24));
    let found = [4, 5, 6, 7, 8].map(|count| {
        let hulls = covering(&mesh, Cover { max_parts: Some(count), ..Cover::default() });
        (hulls.len(), farthest(&mesh, &hulls))
    });
    // Parts of a symmetric mesh come in pairs, except at the mirror.
    let is_used = |parts: usize, count: usize| parts == count || count == 7 && parts == 6;
    assert!(found.iter().zip([4, 5, 6, 7, 8]).all(|((parts, _), count)| is_used(*parts, count)), "{found:?}");
    assert!(found.windows(2).all(|pair| pair[1].1 <= 1.006 * pair[0].1), "{found:?}");
}

#[test]
fn a_search_without_time_ends_with_halves() {
    let mesh = point_set(&concave::horseshoe(48));
    let found = covering(&mesh, Cover { seconds: Some(1e-9), max_vertices: Some(12), ..Cover::default() });
    assert!(found.len() > 2 && found.len() <= 8, "{}", found.len());
    assert!(found.iter().all(|hull| hull.vertices.len() <= 12));
    let volume = |hulls: &[Hull]| hulls.iter().map(|hull| crate::mass::mass(hull).volume).sum::<f64>();
    let whole = crate::hull::build(&mesh).unwrap();
    assert!(volume(&found) < 0.8 * volume(&[whole]), "{}", volume(&found));
    let two = covering(&mesh, Cover { seconds: Some(1e-9), max_parts: Some(3), ..Cover::default() });
    assert_eq!(two.len(), 2);
}

#[test]
fn a_search_may_end_at_any_time() {
    let mesh = point_set(&concave::mug(24));
    for milliseconds in [1, 3, 10, 30, 100, 300, 1000] {
        for max_parts in [None, Some(4)] {
            let seconds = Some(f64::from(milliseconds) * 1e-3);
            let found = covering(&mesh, Cover { seconds, max_parts, max_vertices: Some(20), ..Cover::default() });
            assert!(found.iter().all(|hull| hull.vertices.len() <= 20), "{milliseconds}");
            assert!(max_parts.is_none_or(|count| found.len() <= count as usize), "{milliseconds}: {}", found.len());
        }
    }
}

#[test]
fn no_part_has_more_vertices_than_allowed() {
    for (points, max_vertices, share) in [(24, 4, 0.2), (24, 4, 0.06), (24, 6, 0.05), (40, 12, 0.02), (80, 64, 0.008)] {
        let ball = surface_of(&hull_of(Family::Sphere.points(points, 1)));
        assert!(ball.positions.len() > max_vertices as usize, "the sample is not representative");
        let mut small = ball.clone();
        small.positions.iter_mut().for_each(|p| *p = [p[0] * 0.3 + 3.0, p[1] * 0.3, p[2] * 0.3]);
        let mesh = joined(&[ball, small]);
        let found = covering(
            &mesh,
            Cover { max_vertices: Some(max_vertices), max_error: Length::Relative(share), ..Cover::default() },
        );
        let most = found.iter().map(|hull| hull.vertices.len()).max().unwrap();
        assert!(most <= max_vertices as usize, "{most} of {max_vertices} at {share}");
    }
}

#[test]
fn a_polygon_of_many_corners_is_divided() {
    let corner = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 50.0;
        DVec3::new(libm::cos(angle), libm::sin(angle), 0.1)
    };
    let polygon: Vec<DVec3> = (0..50).map(corner).collect();
    for max_vertices in [4, 6, 9, 30, 200] {
        let found = wrap::of_polygon(&polygon, 2.0, 1e-4, max_vertices);
        assert!(found.iter().all(|(_, hull)| hull.vertices.len() <= max_vertices), "{max_vertices}");
        let bodies: Vec<Body> = found.iter().map(|(_, hull)| Body::new(&hull.positions(), 0.0)).collect();
        let mut rng = SplitMix64::new(2);
        for _ in 0..500 {
            let p = polygon[rng.below(50)].lerp(polygon[rng.below(50)], rng.between(0.0, 1.0));
            assert!(bodies.iter().any(|body| body.holds(p, 1e-12)), "{p}");
        }
    }
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
        let mesh = test_meshes::mesh(positions, triangles);
        let solid = Solid::new(&mesh);
        let limit = 0.05 * solid.diagonal();
        let found =
            search(&Surface::new(&mesh, &solid), &mut Field::new(&solid), &limits(limit, &solid)).unwrap().whole;
        let bound = uncovered(&mesh, &found.iter().map(|part| &part.hull).collect::<Vec<_>>()).bound;
        assert!(bound <= 1e-6 * solid.diagonal(), "seed {seed}: {bound}");
        assert!(found.iter().all(|part| part.bound <= limit), "seed {seed}");
    }
}

/// Regression: the progress bar stood still while a mesh was decomposed.
#[test]
fn progress_moves_within_a_mesh() {
    let mesh = point_set(&concave::mug(24));
    let progress = crate::progress::Progress::default();
    let is_done = std::sync::atomic::AtomicBool::new(false);
    let seen = std::thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            let mut seen = std::collections::BTreeSet::new();
            while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                seen.insert((1e6 * progress.share()) as u32);
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            seen
        });
        let parts = crate::decompose::decompose_in(&mesh, &Cover::default(), progress.whole()).unwrap().unwrap();
        is_done.store(true, std::sync::atomic::Ordering::Relaxed);
        let alone = decompose(&mesh, &Cover::default()).unwrap().unwrap();
        assert_eq!(parts.len(), alone.len(), "progress changes no result");
        watcher.join().unwrap()
    });
    assert!(seen.len() > 5 && progress.share() >= 0.9, "{seen:?}, {}", progress.share());
}

/// Points inside both arms of an L, both seen from a small triangle at its outer edge: no cut parts
/// them, since both sides of a cut need some of the surface. One of them fits.
#[test]
fn free_surfaces_are_parts_without_far_points_inside() {
    cuts::tests::with_search(&concave::l(), 0.02, |search, _| {
        let limit = search.scale.limit;
        let [p, q, r] = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]].map(|[x, y]| limit * DVec3::new(1.0 + x, 1.0 + y, 1.0));
        let atom = Arc::new(Atom::new(Patch::new(vec![vec![p, q, r]]).unwrap()));
        let inside = vec![DVec3::new(1.9, 0.5, 0.5), DVec3::new(0.5, 2.6, 0.5)];
        let piece = search.scale.piece(vec![atom], inside, Vec::new(), &[]);
        assert!(!search.beyond(&piece).is_empty());
        let parts = divided(search, piece, 9, 0, &mut Vec::new(), Stage::default()).unwrap();
        assert_eq!((parts.len(), parts[0].piece.corners.len()), (1, 1));
        assert!(parts[0].bound <= search.bounds.limit);
    });
}
