//! Compares bounds with samplers and slow twins that share no code with them.

use glam::DVec3;
use shapes::{concave, rng::SplitMix64, solids::extrusion};

use super::sides::{Polygon, are_sides_inside};
use super::*;
use super::{peaks::Peaks, protrusion::protrusion_beside};
use crate::{
    hull::Hull,
    simplify::nearest::Nearest,
    test_meshes::{
        block, box_hull, doubled, hull_of, in_triangle, inside_out, joined, mesh, open_block, point_set, surface_of,
        turned,
    },
};
use hullmap_geometry::{PointSet, planes::HalfSpace, triangle};

/// Each arm is one wide, and one longer than that.
fn letter_l() -> PointSet {
    let mut l = extrusion(&[[1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], 0.0, 1.0);
    // Both caps are fans from the concave corner.
    l.faces[0].rotate_right(1);
    point_set(&l)
}

fn tight(solid: &Solid, part: &Hull) -> Protrusion {
    protrusion(solid, part, &Accuracy::tight(solid.diagonal()))
}

/// The last two numbers are the least and the greatest bound.
#[test]
fn known_parts_protrude_by_known_lengths() {
    use SolidKind::{Closed, Walls, Watertight};
    let (unit, l, open) = (block([0.0; 3], [1.0; 3]), letter_l(), open_block([0.0; 3], [1.0; 3]));
    let hollow = joined(&[block([-1.0; 3], [1.0; 3]), inside_out(block([-0.75; 3], [0.75; 3]))]);
    let sheet = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let sheet = mesh(sheet, vec![[0, 1, 2], [0, 2, 3]]);
    let own = |mesh: &PointSet| hull_of(mesh.positions.clone());
    let corner = 0.25 * 3.0_f64.sqrt();
    let (larger, taller) = (box_hull([-0.25; 3], [1.25; 3]), box_hull([0.0; 3], [1.0, 1.0, 1.1]));
    let above = box_hull([0.0; 3], [1.0, 1.0, 0.25]);
    let (empty, any, nothing) = (PointSet::default(), hull_of(vec![[0.0; 3], [1.0; 3]]), f64::INFINITY);
    let (auto, closed) = (SolidRule::Auto, SolidRule::Closed);
    for (name, mesh, rule, kind, part, least, most) in [
        ("a box in itself", &unit, auto, Watertight, own(&unit), 0.0, 1e-9),
        ("a larger box", &unit, auto, Watertight, larger.clone(), corner, 1.006 * corner),
        ("the hull of an L", &l, auto, Watertight, own(&l), 0.5, 0.5026),
        ("of one inside out", &inside_out(l.clone()), auto, Watertight, own(&l), 0.5, 0.5026),
        ("over a cavity", &hollow, auto, Watertight, own(&hollow), 0.75, 0.85),
        ("a closed box in itself", &open, closed, Closed, own(&open), 0.0, 1e-5),
        ("taller than a closed box", &open, closed, Closed, taller, 0.0999, 0.102),
        ("above a sheet", &sheet, auto, Walls, above, 0.25, 0.2513),
        ("a sheet in itself", &sheet, auto, Walls, own(&sheet), 0.0, 1e-9),
        ("around nothing", &empty, auto, Walls, any, nothing, nothing),
    ] {
        let solid = Solid::by(mesh, rule);
        assert_eq!(solid.kind(), kind, "{name}");
        let found = tight(&solid, &part);
        assert!((least..=most).contains(&found.bound) && found.reached <= found.bound, "{name}: {found:?}");
        let is_within = |limit: f64| protrusion(&solid, &part, &Accuracy::decide(limit)).bound <= limit;
        assert!(least == 0.0 || least == nothing || !is_within(0.998 * least), "{name}");
        if mesh.triangles.len() == l.triangles.len() {
            assert!(is_within(0.501), "{name}");
        }
    }
    let found = tight(&Solid::new(&unit), &larger);
    assert!(found.reached > 0.98 * corner, "{found:?}");
}

/// Known local maxima change no decision, and a cavity is one.
#[test]
fn local_maxima_change_no_decision() {
    let around = block([0.0; 3], [4.0; 3]);
    let hollow = |size: f32| joined(&[around.clone(), inside_out(block([2.0 - size; 3], [2.0 + size; 3]))]);
    let mut rng = SplitMix64::new(9);
    let mut decided = [0, 0];
    for mesh in [around.clone(), hollow(0.5), hollow(1.5), letter_l()] {
        let solid = Solid::new(&mesh);
        for limit in [0.3, 0.49, 0.51, 1.0, 1.6] {
            let peaks = Peaks::new(&solid, 0.8 * limit, 1_000_000, None).expect("the maxima are found");
            for _ in 0..12 {
                let [a, b] = [0, 1].map(|_| [0; 3].map(|_: i32| rng.between(-0.3, 4.3) as f32));
                let part = [0, 1, 2].map(|i| [a[i].min(b[i]), a[i].max(b[i]) + 0.1]);
                let part = box_hull(part.map(|p| p[0]), part.map(|p| p[1]));
                for part in [&part, &hull_of(mesh.positions.clone())] {
                    let accuracy = Accuracy::decide(limit);
                    let without = protrusion(&solid, part, &accuracy).bound <= limit;
                    let with = protrusion_beside(&solid, part, &accuracy, Some(&peaks)).bound <= limit;
                    assert_eq!(with, without, "limit {limit}");
                    decided[usize::from(with)] += 1;
                }
            }
        }
    }
    assert!(decided.iter().all(|count| *count > 60), "{decided:?}");
}

/// Climbs from random points to local maxima, by steps that are halved where none leads farther.
#[test]
fn every_local_maximum_is_in_a_box() {
    let seed = 12;
    println!("seed {seed}");
    let mut rng = SplitMix64::new(seed);
    let mut open = point_set(&concave::mug(24));
    open.triangles.drain(..30);
    let (mut found, mut boxes) = (0, 0);
    for (mesh, above) in [
        (point_set(&concave::mug(24)), 0.1),
        (point_set(&concave::pipe(16)), 0.1),
        (point_set(&concave::bowl(16, 5)), 0.05),
        (open, 0.1),
    ] {
        let solid = Solid::new(&mesh);
        let above = above * solid.diagonal();
        let peaks = Peaks::new(&solid, above, 1_000_000, None).expect("the maxima are found");
        boxes += peaks.boxes().len();
        let [low, high] = solid.bounds();
        for _ in 0..30 {
            let mut p = low + (high - low) * DVec3::from_array(std::array::from_fn(|_| rng.unit()));
            let mut distance = solid.distance(p);
            let mut step = 0.02 * solid.diagonal();
            while step > 1e-9 * solid.diagonal() && distance < solid.diagonal() {
                let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
                let directions = (0..24).map(|_| DVec3::from_array(rng.direction())).chain(axes);
                let next = directions.map(|direction| p + direction * step);
                let farthest = next.map(|q| (solid.distance(q), q)).max_by(|a, b| a.0.total_cmp(&b.0));
                match farthest {
                    Some(next) if next.0 > distance => (distance, p) = next,
                    _ => step *= 0.5,
                }
            }
            if distance > above && distance < solid.diagonal() {
                let slack = 1e-6 * solid.diagonal();
                let holds = |[l, h]: &[DVec3; 2]| (*l - p).max(p - *h).max_element() <= slack;
                assert!(peaks.boxes().iter().any(holds), "{distance} at {p}");
                found += 1;
            }
        }
    }
    assert!(found > 20 && boxes > 0, "{found} local maxima, {boxes} boxes");
}

/// A triangle that is nearly in the plane of a part's face, and rises out of it inside another
/// part. Within a tolerance, the first part seems to contain all of it, with an error.
#[test]
fn a_triangle_in_two_parts_is_covered_exactly() {
    let triangle = mesh(vec![[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.0, 0.6, 0.0]], vec![[0, 1, 2]]);
    let top = |x: f32| 3e-8 - 3.3e-7 * x;
    let corners = [-0.1, 0.7].map(|x: f32| [-0.1, 0.7].map(|y: f32| [[x, y, -0.3], [x, y, top(x)]]));
    let leaning = hull_of(corners.as_flattened().concat());
    let other = box_hull([0.05, -0.1, -0.3], [0.7, 0.7, 0.1]);
    let bound = |parts: &[&Hull]| uncovered(&triangle, parts).bound;
    let one = bound(&[&leaning]);
    assert!(one > 1.5e-7 && one < 2e-7, "{one}");
    let both = bound(&[&leaning, &other]);
    assert!(both < 1e-11, "{both}");
}

/// The other sides of a box's quads, along the other diagonals, so that no triangle is repeated.
fn two_sided(mesh: &PointSet) -> PointSet {
    let mut both = mesh.clone();
    for pair in mesh.triangles.chunks_exact(2) {
        let ([a, b, c], d) = (pair[0], pair[1][2]);
        both.triangles.extend([[a, d, b], [d, c, b]]);
    }
    both
}

/// Numbers stand for points with three equal coordinates: first inside, then outside. Mouths, of
/// one layer and of two, are open. Small holes of a surface with one side are closed, and so is
/// whatever has no holes. An apple beside a bowl stays solid.
#[test]
fn openings_are_kept_and_holes_are_closed() {
    use SolidKind::{Closed, Walls, Watertight};
    let cube = block([0.0; 3], [1.0; 3]);
    let open = open_block([0.0; 3], [1.0; 3]);
    let rings = (1..20).map(|i| f64::from(i) * std::f64::consts::PI / 20.0).map(|a| [libm::sin(a), -libm::cos(a)]);
    let profile: Vec<[f64; 2]> = [[0.0, -1.0]].into_iter().chain(rings).chain([[0.0, 1.0]]).collect();
    let mut scan = point_set(&shapes::solids::lathe(&profile, 30));
    // A quad of its 600 is missing.
    scan.triangles.drain(300..302);
    let opposite = joined(&[cube.clone(), inside_out(block([2.0; 3], [3.0; 3]))]);
    let apple = joined(&[open.clone(), block([3.0; 3], [4.0; 3])]);
    let around = joined(&[cube.clone(), block([-1.0; 3], [2.0; 3])]);
    let hollow = joined(&[block([-1.0; 3], [1.0; 3]), inside_out(block([-0.75; 3], [0.75; 3]))]);
    // Each triangle has its own corners, which differ by rounding.
    let mut rng = SplitMix64::new(5);
    let corners = cube.triangles.iter().flatten().map(|v| cube.positions[*v as usize]);
    let split = corners.map(|p| p.map(|c| c + (rng.unit() as f32 - 0.5) * 3e-7)).collect();
    let split = mesh(split, (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect());
    let on_itself = joined(&[cube.clone(), inside_out(cube.clone())]);
    let [auto, closed, walls] = SolidRule::ALL;
    for (name, mesh, rule, expected, inside, outside) in [
        ("cube", &cube, auto, Watertight, &[0.5][..], &[1.1][..]),
        ("cube", &cube, walls, Walls, &[], &[0.5]),
        ("cube of split vertices", &split, auto, Watertight, &[0.5], &[1.1]),
        ("cube of two layers", &doubled(cube.clone()), auto, Watertight, &[0.5], &[1.1]),
        ("cube on cube", &on_itself, auto, Watertight, &[0.5], &[1.1]),
        ("cube of other diagonals", &two_sided(&cube), auto, Watertight, &[0.3], &[1.4, 2.2]),
        ("cubes of other diagonals", &two_sided(&around), auto, Watertight, &[0.3, 1.4], &[2.2]),
        ("opposite cubes", &opposite, auto, Watertight, &[0.5, 2.5], &[1.5]),
        ("cavity", &hollow, auto, Watertight, &[0.9], &[0.1]),
        ("box", &open, auto, Walls, &[], &[0.5]),
        ("box", &open, closed, Closed, &[0.5], &[1.1]),
        ("box of two layers", &doubled(open.clone()), auto, Walls, &[], &[0.5]),
        ("box of other diagonals", &two_sided(&open), auto, Walls, &[], &[0.5]),
        ("bowl and apple", &apple, auto, Walls, &[3.5], &[0.5]),
        ("bowl and apple", &apple, walls, Walls, &[], &[0.5, 3.5]),
        ("scan", &scan, auto, Closed, &[0.0], &[0.6]),
        ("scan", &scan, walls, Walls, &[], &[0.0]),
        ("bottle of two layers", &doubled(scan.clone()), auto, Walls, &[], &[0.0]),
    ] {
        let solid = Solid::by(mesh, rule);
        assert_eq!((solid.kind(), solid.is_hollow()), (expected, inside.is_empty()), "{name}, {rule}");
        assert_eq!(solid.triangles().len() > solid.mesh_count(), expected == Closed, "{name}, {rule}");
        let is_inside = |x: &f64| solid.is_inside(DVec3::splat(*x));
        assert!(inside.iter().all(is_inside) && !outside.iter().any(is_inside), "{name}, {rule}");
    }
}

/// A skin whose faces are repeated and meet in threes has no opening.
#[test]
fn a_divided_skin_of_two_layers_is_solid() {
    let mut skin = block([0.0; 3], [1.0; 3]);
    // A wall inside divides the cube.
    skin.triangles.extend([[0, 1, 7], [0, 7, 6]]);
    // Two faces have one side only, so that the two sides do not cancel.
    skin.triangles.extend(inside_out(skin.clone()).triangles.split_off(2));
    for first in 0..skin.triangles.len() {
        skin.triangles.rotate_left(first);
        let solid = Solid::new(&skin);
        let [inside, outside] = [[0.5, 0.25, 0.75], [0.5, 0.25, 1.25]].map(|p| solid.is_inside(DVec3::from_array(p)));
        assert!(solid.kind() != SolidKind::Walls && inside && !outside, "{first}");
    }
}

/// A cube of 96 square frames is a cage if the bars are thin, and has holes to close if they are
/// not.
#[test]
fn holes_are_kept_if_they_exceed_the_mesh_together() {
    let cage = |bar: f32| {
        let mut set = PointSet::default();
        for (face, i, j) in (0..6).flat_map(|face| (0..4).flat_map(move |i| (0..4).map(move |j| (face, i, j)))) {
            let at = |u: f32, v: f32| {
                let mut p = [(i as f32 + u) / 4.0, (j as f32 + v) / 4.0, (face / 3) as f32];
                p.rotate_right(face % 3);
                p
            };
            let square = |low: f32, high: f32| [at(low, low), at(high, low), at(high, high), at(low, high)];
            let first = set.positions.len() as u32;
            set.positions.extend(square(0.0, 1.0).into_iter().chain(square(bar, 1.0 - bar)));
            let ring = (0..4).flat_map(|k| {
                let next = (k + 1) % 4;
                [[k, next, next + 4], [k, next + 4, k + 4]]
            });
            let outward = |[a, b, c]: [u32; 3]| if face < 3 { [a, c, b] } else { [a, b, c] };
            set.triangles.extend(ring.map(|t| outward(t.map(|v| v + first))));
        }
        set
    };
    for (bar, share, expected) in [(0.1, 0.64 / 0.36, SolidKind::Walls), (0.25, 0.25 / 0.75, SolidKind::Closed)] {
        let mesh = cage(bar);
        assert!((Solid::by(&mesh, SolidRule::Closed).hole_share() - share).abs() < 1e-5);
        assert_eq!(Solid::new(&mesh).kind(), expected, "{bar}");
    }
}

fn random_soup(rng: &mut SplitMix64, count: usize) -> PointSet {
    let positions: Vec<[f32; 3]> = (0..count).map(|_| std::array::from_fn(|_| rng.unit() as f32)).collect();
    let mut index = || (rng.unit() * count as f64) as u32;
    let triangles: Vec<[u32; 3]> = (0..2 * count).map(|_| [index(), index(), index()]).collect();
    mesh(positions, triangles)
}

#[test]
fn rays_agree_with_solid_angles() {
    let mut rng = SplitMix64::new(7);
    let (mut inside, mut all) = (0, 0);
    for _ in 0..60 {
        let solid = Solid::by(&random_soup(&mut rng, 12), SolidRule::Closed);
        for _ in 0..50 {
            let p = DVec3::from_array(std::array::from_fn(|_| rng.unit()));
            let is_inside = solid.surface().solid_angles(p) != 0;
            assert_eq!(solid.is_inside(p), is_inside, "{p}");
            inside += usize::from(is_inside);
            all += 1;
        }
    }
    assert!(inside > all / 40 && inside < all * 4 / 5, "{inside} of {all}");
}

fn polygons_in(solid: &Solid, low: DVec3, high: DVec3) -> Vec<Polygon> {
    let sides = DVec3::AXES.map(|normal| {
        let (least, greatest) = (normal.dot(low), normal.dot(high));
        [HalfSpace { normal, offset: greatest }, HalfSpace { normal: -normal, offset: -least }]
    });
    solid.triangles().iter().filter_map(|triangle| Polygon::new(triangle)?.clipped(sides.as_flattened())).collect()
}

#[test]
fn sides_agree_with_solid_angles() {
    let mut rng = SplitMix64::new(29);
    let (mut known, mut unknown, mut outside) = (0, 0, 0);
    for round in 0..4000 {
        let solid = Solid::new(&match round % 3 {
            0 => random_soup(&mut rng, 8),
            1 => joined(&[0, 1, 2].map(|_| {
                let low = std::array::from_fn(|_| (4.0 * rng.unit()).floor() as f32 / 8.0);
                let block = block(low, low.map(|x| x + 0.5));
                if rng.unit() < 0.2 { inside_out(block) } else { block }
            })),
            _ => joined(&[0, 1, 2].map(|_| {
                let points = (0..4).map(|_| std::array::from_fn(|_| rng.unit() as f32)).collect();
                mesh(points, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
            })),
        });
        if solid.kind() == SolidKind::Walls {
            continue;
        }
        let triangle = solid.triangles()[(rng.unit() * solid.triangles().len() as f64) as usize];
        let (centre, half) = (in_triangle(&triangle, &mut rng), 0.1 * rng.unit());
        let polygons = polygons_in(&solid, centre - half, centre + half);
        let mut point = || centre + half * DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.unit() - 1.0));
        let is_outside = (0..60).any(|_| solid.surface().solid_angles(point()) == 0);
        match (are_sides_inside(solid.surface(), &polygons), is_outside) {
            (true, true) => panic!("round {round}: a point outside"),
            (true, false) => known += 1,
            (false, false) => unknown += 1,
            (false, true) => outside += 1,
        }
    }
    assert!(known > 150 && outside > 1000 && unknown * 10 < known, "{known} known, {unknown} not, {outside} outside");
}

#[test]
fn overlapping_boxes_take_few_measurements() {
    let union = joined(&[
        block([0.0; 3], [2.0, 1.0, 1.0]),
        block([1.0, 0.0, 0.25], [3.0, 1.0, 0.75]),
        block([0.5, 0.25, -1.0], [1.5, 0.75, 2.0]),
    ]);
    let solid = Solid::new(&union);
    let part = box_hull([0.25, 0.3, 0.3], [2.75, 0.7, 0.7]);
    let accuracy = Accuracy { measurements: 3000, ..Accuracy::tight(solid.diagonal()) };
    let found = protrusion(&solid, &part, &accuracy);
    assert!(found.bound <= 1e-5 * solid.diagonal(), "{found:?}");
}

fn samples(part: &Hull, rng: &mut SplitMix64, count: usize) -> Vec<DVec3> {
    let surface = surface_of(part);
    (0..count).map(|i| in_triangle(&surface.corners(&surface.triangles[i % surface.triangles.len()]), rng)).collect()
}

fn slow_distance(solid: &Solid, mesh: &PointSet, p: DVec3) -> f64 {
    if solid.kind() != SolidKind::Walls && solid.surface().solid_angles(p) != 0 {
        return 0.0;
    }
    let nearest = |t: &[u32; 3]| triangle::nearest(&mesh.corners(t), p).distance(p);
    mesh.triangles.iter().map(nearest).fold(f64::INFINITY, f64::min)
}

#[test]
fn protrusion_is_never_below_a_sample() {
    let mut rng = SplitMix64::new(11);
    let mut close = 0;
    for round in 0..40 {
        let soup = if round % 2 == 0 { random_soup(&mut rng, 9) } else { letter_l() };
        let solid = Solid::by(&soup, SolidRule::Closed);
        let scale = 0.6 + rng.unit() as f32;
        let part = hull_of((0..7).map(|_| std::array::from_fn(|_| scale * rng.unit() as f32)).collect());
        let found = tight(&solid, &part);
        // Closing triangles make the bound larger than the slow distance, never smaller.
        let sampled =
            samples(&part, &mut rng, 4000).into_iter().map(|p| slow_distance(&solid, &soup, p)).fold(0.0, f64::max);
        if solid.kind() == SolidKind::Watertight {
            assert!(found.bound >= sampled, "round {round}: {found:?} below {sampled}");
            close += usize::from(found.bound <= 1.1 * sampled + 2e-3);
        }
        assert!(found.reached <= found.bound, "{found:?}");
    }
    assert!(close >= 15, "{close}");
}

/// Part of a closing triangle may be outside, so that its distance is no bound for the solid.
#[test]
fn closing_triangles_that_are_whole_have_the_inside_beside_them() {
    let mut rng = SplitMix64::new(31);
    let (mut whole, mut partly, mut unknown) = (0, 0, 0);
    for round in 0..600 {
        let soup = random_soup(&mut rng, 7);
        let solid = Solid::by(&soup, SolidRule::Closed);
        for triangle in &solid.triangles()[soup.triangles.len()..] {
            let Some(normal) = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).try_normalize() else {
                continue;
            };
            let centre = triangle::centroid(triangle) + 1e-9 * normal;
            let near = solid.near(centre, f64::INFINITY).unwrap();
            if near.triangle != *triangle {
                continue;
            }
            let is_beside =
                |p: DVec3| [1e-9, -1e-9].iter().any(|step| solid.surface().solid_angles(p + *step * normal) != 0);
            let all = (0..100).all(|_| is_beside(in_triangle(triangle, &mut rng)));
            assert!(all || !near.is_whole, "round {round}: {triangle:?}");
            match (near.is_whole, all) {
                (true, _) => whole += 1,
                (false, true) => unknown += 1,
                (false, false) => partly += 1,
            }
        }
    }
    assert!(whole > 500 && partly > 50 && unknown * 20 < whole, "{whole} whole, {partly} partly, {unknown} unknown");
}

/// Beside closing triangles, a point may be closer to the solid than its measured distance. A limit
/// that holds is recorded all the same.
#[test]
fn a_limit_that_is_proven_is_recorded() {
    let mut proven = 0;
    for seed in 550..580 {
        let mut rng = SplitMix64::new(seed);
        let mut corner = |low: f64, high: f64| std::array::from_fn(|_| (low + (high - low) * rng.unit()) as f32);
        let blocks = [(); 2].map(|()| block(corner(0.0, 0.5), corner(0.6, 1.0)));
        let mut mesh = joined(&blocks);
        mesh.triangles.remove((rng.unit() * mesh.triangles.len() as f64) as usize);
        let solid = Solid::new(&mesh);
        let part = hull_of((0..7).map(|_| mesh.positions[(rng.unit() * 16.0) as usize]).collect());
        let measured = tight(&solid, &part);
        let limit = 0.995 * measured.reached;
        let decided = protrusion(&solid, &part, &Accuracy::decide(limit));
        if decided.bound <= limit {
            assert_eq!(solid.kind(), SolidKind::Closed, "seed {seed}: {measured:?} {decided:?}");
            let fit = fits(&mesh, &[&part], Some(limit)).unwrap()[0];
            assert!(fit.protrusion <= limit, "seed {seed}: {fit:?}, limit {limit}");
            proven += 1;
        }
    }
    assert!(proven >= 2, "{proven} cases");
}

#[test]
fn uncovered_is_never_below_a_sample() {
    let mut rng = SplitMix64::new(13);
    let (mut covered, mut missed) = (0, 0);
    for round in 0..60 {
        let soup = if round % 2 == 0 { random_soup(&mut rng, 7) } else { letter_l() };
        let size = 0.7 + 1.6 * rng.unit() as f32;
        let hulls: Vec<Hull> = (0..1 + round % 4)
            .map(|_| {
                let centre: [f32; 3] = std::array::from_fn(|_| rng.unit() as f32);
                let mut point = || centre.map(|c| c + size * (2.0 * rng.unit() as f32 - 1.0));
                hull_of((0..10).map(|_| point()).collect())
            })
            .collect();
        let parts: Vec<&Hull> = hulls.iter().collect();
        let found = uncovered(&soup, &parts);
        let prepared: Vec<Nearest> = hulls.iter().map(Nearest::new).collect();
        let mut sampled = 0.0_f64;
        for i in 0..3000 {
            let p = in_triangle(&soup.corners(&soup.triangles[i % soup.triangles.len()]), &mut rng);
            let distances = prepared.iter().map(|part| part.certain(p).point.distance(p));
            sampled = sampled.max(distances.fold(f64::INFINITY, f64::min));
        }
        assert!(found.bound >= sampled - 1e-12, "round {round}: {found:?} below {sampled}");
        assert!(found.bound <= 1.01 * found.reached + 1e-5, "round {round}: {found:?}");
        if found.bound < 1e-9 {
            covered += 1;
        } else {
            missed += 1;
        }
    }
    assert!(covered >= 4 && missed >= 20, "{covered} covered, {missed} not");
}

#[test]
fn a_gap_between_parts_is_found() {
    // A plate covered by two boxes with a gap of 0.2 between them: the middle is 0.1 away.
    let plate = block([0.0; 3], [2.0, 1.0, 0.1]);
    let (left, right) = (box_hull([0.0; 3], [0.9, 1.0, 0.1]), box_hull([1.1, 0.0, 0.0], [2.0, 1.0, 0.1]));
    let found = uncovered(&plate, &[&left, &right]);
    assert!(found.bound > 0.0999 && found.bound < 0.101, "{found:?}");
    assert!(uncovered(&plate, &[&hull_of(plate.positions.clone())]).bound < 1e-11);
    assert_eq!(uncovered(&plate, &[]).bound, f64::INFINITY);
    assert_eq!(uncovered(&PointSet::default(), &[]).bound, 0.0);
}

/// Triangles in another order, orientation and frame are the same solid, also where they cross and
/// leave holes that can be closed in several ways.
#[test]
fn turned_soups_are_the_same_solid() {
    let seed = 3070;
    println!("seed {seed}");
    let mut rng = SplitMix64::new(seed);
    let (mut inside, mut unequal, mut all) = (0, 0, 0);
    for round in 0..300 {
        let soup = random_soup(&mut rng, 9);
        let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]][round % 6];
        let signs = [0; 3].map(|_| if rng.unit() < 0.5 { -1.0 } else { 1.0 });
        let turned = turned(&soup, axes, signs, round % 2 == 0, &mut rng);
        for rule in SolidRule::ALL {
            let [solid, other] = [&soup, &turned].map(|mesh| Solid::by(mesh, rule));
            assert_eq!(solid.kind(), other.kind(), "round {round}, {rule}");
            let [low, high] = solid.bounds();
            for _ in 0..40 {
                let p = low + (high - low) * DVec3::from_array([0; 3].map(|_| rng.unit()));
                let q = DVec3::from_array([0, 1, 2].map(|k| f64::from(signs[k]) * p[axes[k]]));
                let (own, far) = (solid.distance(p), other.distance(q));
                // Beside a closing triangle, distances are upper bounds if its rays are uncertain.
                unequal += usize::from((own - far).abs() > 4e-9);
                assert!((own - far).abs() <= 1e-3, "round {round}, {rule}: {own} and {far}");
                all += 1;
                inside += usize::from(own == 0.0);
            }
        }
    }
    assert!(1000 * unequal < all, "{unequal} of {all}");
    assert!(inside > 500, "the sample is not representative: {inside} points inside");
}
