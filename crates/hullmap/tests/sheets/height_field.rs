//! Queries of height fields give the answers of the same surface as a triangle mesh, which the
//! truth of meshes judges by brute force.

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::{HalfSpace, Sphere};
use hullmap::{
    Cache, CastSettings, CompoundManifolds, Contact, EdgeClass, Geometry, HeightField, Hull, ManifoldSettings, Motion,
    MotionSettings, Pack, Pose, Ray, RigidMotion, Settings, Status, TriangleMesh, VertexClass,
};
use hullmap_testkit::packs::{self, height_field as field};
use hullmap_testkit::ray::{Fraction, Line};
use shapes::rng::SplitMix64;

use crate::meshes::mesh;

const SEED: u64 = 0xf139;

/// A grid centred on the origin, with cells of this size.
pub fn centred(columns: usize, rows: usize, spacing: [f64; 2], diagonal: Diagonal) -> Layout {
    let origin =
        [(columns, spacing[0]), (rows, spacing[1])].map(|(count, spacing)| -0.5 * spacing * (count - 1) as f64);
    Layout { columns, rows, origin, spacing, diagonal }
}

/// All triangles, with their indices.
fn triangles(field: &HeightField) -> Vec<(usize, [DVec3; 3])> {
    let corners = |index: usize| Some((index, field.triangle(index)?.corners()));
    (0..field.triangle_count()).filter_map(corners).collect()
}

/// Fields whose vertices f32 can represent: rough, of one row, with holes, 2 × 2, flat, steep,
/// tiny, huge, far away, with cells that are not square.
fn dyadic_fields(rng: &mut SplitMix64) -> Vec<HeightField> {
    let tiny = 2_f64.powi(-13);
    let mut fields = Vec::new();
    for (columns, rows, share, spacing, height) in [
        (9, 17, 0.0, [0.5, 0.75], 1.5),
        (12, 7, 0.3, [0.5, 0.75], 1.5),
        (2, 9, 0.1, [0.5, 0.75], 1.5),
        (20, 20, 0.8, [0.5, 0.75], 1.5),
        (2, 2, 0.0, [1.0, 1.0], 1.0),
        (8, 5, 0.0, [1.0, 1.0], 0.0),
        (5, 12, 0.0, [0.25, 0.25], 9.0),
        (7, 8, 0.1, [tiny, tiny], tiny),
        (4, 5, 0.1, [4096.0, 8192.0], 2048.0),
        (6, 6, 0.1, [1.0, 1.5], 1.0),
    ] {
        for diagonal in Diagonal::ALL {
            let heights: Vec<f32> = (0..columns * rows).map(|_| (height * rng.unit()) as f32).collect();
            let holes: Vec<bool> = (1..(columns - 1) * (rows - 1)).map(|_| rng.unit() < share).chain([false]).collect();
            let mut layout = centred(columns, rows, spacing, diagonal);
            if columns == 6 {
                layout.origin = [2_f64.powi(18), -(2_f64.powi(19))];
            }
            fields.push(field(layout, &heights, &holes));
        }
    }
    fields
}

/// A body of four to eight vertices, about as large as a cell, and near the surface.
fn body(field: &HeightField, rng: &mut SplitMix64) -> (Pack, Pose) {
    let (layout, [low, high]) = (field.layout(), field.bounds());
    let size = layout.spacing[0].min(layout.spacing[1]);
    let count = 4 + rng.below(5);
    let points: Vec<[f32; 3]> = (0..count).map(|_| rng.direction().map(|c| (0.6 * size * c) as f32)).collect();
    let turn = DQuat::from_xyzw(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5).normalize();
    let share = DVec3::new(rng.unit(), rng.unit(), rng.unit()) * 1.2 - 0.1;
    let mut position = low + share * (high - low);
    position.z += size * (rng.unit() - 0.5);
    (packs::tree_pack(&points), Pose::new(position, turn).unwrap())
}

/// `hullmap_tests::sheets::joints` judges other rays.
#[test]
fn vertical_rays_find_the_ground() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let fields = dyadic_fields(&mut rng);
    let (mut ground, mut none) = (0, 0);
    for round in 0..1500 {
        let field = &fields[round % fields.len()];
        let [low, high] = field.bounds();
        let size = (high - low).max(DVec3::splat(0.1 * (high.x - low.x)));
        let origin = low + DVec3::new(rng.unit() * 1.1 - 0.05, rng.unit() * 1.1 - 0.05, 1.5) * size;
        let down = DVec3::new(0.0, 0.0, -size.z);
        let found = hullmap::ray(field, &Ray::new(origin, down).unwrap(), &CastSettings::default());
        let line = Line::new(origin, down, f64::INFINITY);
        let first = triangles(field).into_iter().filter_map(|(_, corners)| line.meet(corners)).reduce(Fraction::min);
        let at_point = field.height_at(origin.x, origin.y);
        assert_eq!([found.hit, at_point.is_some()], [first.is_some(); 2], "round {round}: {found:?}");
        let (Some(first), Some(at_point)) = (first.map(|first| first.rounded()), at_point) else {
            none += 1;
            continue;
        };
        ground += 1;
        let (z, slack) = (origin.z + first * down.z, 1e-9 * (1.0 + first));
        assert!(found.t_lower <= first + slack && first <= found.t_upper + slack, "round {round}: {found:?} {first}");
        assert!(found.t_upper - found.t_lower <= 1e3 * slack, "round {round}: {found:?}");
        assert!((at_point.height - z).abs() <= 1e-9 * size.z + 1e-9 * z.abs(), "round {round}: {at_point:?} {z}");
        assert_eq!(at_point.triangle, found.part as usize, "round {round}");
        let [a, b, c] = field.triangle(at_point.triangle).unwrap().corners();
        let normal = (b - a).cross(c - a).normalize();
        assert!(at_point.normal.distance(normal) < 1e-12 && normal.z > 0.0);
    }
    println!("{ground} with ground, {none} without");
    assert!(ground > 500 && none > 100);
}

/// The field as a triangle mesh, and for each triangle of the mesh the triangle of the field.
fn as_mesh(field: &HeightField) -> (TriangleMesh, Vec<usize>) {
    let mut positions = Vec::new();
    let of_field: Vec<usize> = triangles(field)
        .into_iter()
        .map(|(index, corners)| {
            positions.extend(corners);
            index
        })
        .collect();
    let corners: Vec<[u32; 3]> = (0..of_field.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = mesh(&positions, &corners);
    let sources = (0..mesh.triangle_count()).map(|i| of_field[mesh.source_triangle(i).unwrap() as usize]).collect();
    (mesh, sources)
}

/// Whether queries of a surface and a hull hit, and the intervals of their lengths or times:
/// distance, contact, a half-space that the surface falls on, intersection, cast, turning motion.
fn answers<G: Geometry>(surface: &G, hull: &Hull, pose: Pose, plane: &HalfSpace, size: f64) -> [(bool, [f64; 2]); 6] {
    let (settings, cache) = (Settings::default(), &mut Cache::new());
    let gap = hullmap::distance(surface, hull, pose, &settings, cache);
    let deep = hullmap::contact(surface, hull, pose, &settings, cache);
    let below = hullmap::contact(plane, surface, pose, &settings, cache);
    let yes = hullmap::intersects(surface, hull, pose, cache);
    let start = Pose::new(pose.translation() + DVec3::Z * 6.0 * size, pose.rotation()).unwrap();
    let fall = Motion::new(DVec3::new(0.6, -0.4, -4.0) * size).unwrap();
    let met = hullmap::cast(surface, hull, start, fall, &CastSettings::default(), cache);
    let (still, turning) = (RigidMotion::still(Pose::IDENTITY), RigidMotion::between(start, pose).unwrap());
    let turned = hullmap::cast_motion(surface, &still, hull, &turning, &MotionSettings::default(), cache);
    [
        (gap.status == Status::Overlapping, [gap.lower, gap.upper]),
        (deep.hit, [deep.depth_lower, deep.depth_upper]),
        (below.hit, [below.depth; 2]),
        (yes.is_hit(), [0.0; 2]),
        (met.hit, [met.t_lower, met.t_upper]),
        (turned.hit, [turned.t_lower, turned.t_upper]),
    ]
}

#[test]
fn answers_are_those_of_the_same_surface_as_a_mesh() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let pairs: Vec<_> = dyadic_fields(&mut rng).into_iter().map(|field| (as_mesh(&field), field)).collect();
    let mut hits = [0; 6];
    for round in 0..1200 {
        let ((mesh, sources), field) = &pairs[round % pairs.len()];
        let size = field.layout().spacing[0];
        let noise = 1e-9 * size + 64.0 * f64::EPSILON * field.bounds()[0].abs().max_element();
        let (pack, pose) = body(field, &mut rng);
        let hull = pack.hull(0).unwrap();
        let plane = HalfSpace::new(DVec3::from_array(rng.direction()), size).unwrap();
        let [own, twins] = [answers(field, &hull, pose, &plane, size), answers(mesh, &hull, pose, &plane, size)];
        for (query, ((hit, [lower, upper]), (other_hit, [other_lower, other_upper]))) in
            own.into_iter().zip(twins).enumerate()
        {
            let slack = if query < 3 { noise } else { 0.0 };
            let is_same = !hit && query > 0 || lower <= other_upper + slack && other_lower <= upper + slack;
            assert!(hit == other_hit && is_same, "round {round}, query {query}: {own:?} {twins:?}");
            hits[query] += usize::from(hit);
        }
        if !own[1].0 {
            continue;
        }
        // Each triangle that touches is visited once, with the contact that it has alone.
        let (settings, mut cache) = (Settings::default(), Cache::new());
        let (mut visited, mut twins) = (HashMap::new(), HashMap::new());
        hullmap::contacts(field, &hull, pose, &settings, &mut cache, |contact| {
            assert!(visited.insert(contact.parts[0] as usize, *contact).is_none(), "round {round}: {contact:?} twice");
        });
        hullmap::contacts(mesh, &hull, pose, &settings, &mut cache, |contact| {
            twins.insert(sources[contact.parts[0] as usize], *contact);
        });
        for (triangle, contact) in &visited {
            let twin = twins.get(triangle).map_or(0.0, |twin| twin.depth);
            assert!((contact.depth - twin).abs() <= noise + 2e-5 * twin, "round {round}: {contact:?} {twin}");
        }
        let is_missing = |(triangle, twin): (&usize, &Contact)| twin.depth > noise && !visited.contains_key(triangle);
        assert!(!twins.iter().any(is_missing), "round {round}");
        // Manifolds belong to the same triangles, and have the same normals.
        let manifold_settings = ManifoldSettings::default();
        let [mut first, mut second] = [(); 2].map(|()| CompoundManifolds::new(200));
        first.update(field, &hull, pose, &manifold_settings);
        second.update(mesh, &hull, pose, &manifold_settings);
        assert_eq!(first.len(), second.len(), "round {round}");
        let normals: HashMap<_, _> = first.iter().map(|([t, _], manifold)| (t, manifold.normal())).collect();
        for ([triangle, _], manifold) in second.iter() {
            let normal = normals[&sources[triangle]];
            assert!(normal.distance(manifold.normal()) < 1e-6, "round {round}: {normal} {}", manifold.normal());
        }
    }
    println!("hits {hits:?}");
    assert!(hits.into_iter().all(|count| count > 100) && hits[1] > 200);
}

/// Classes of edges and vertices, neighbours and borders are the same as in the mesh.
#[test]
fn classes_are_those_of_the_mesh() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let mut counts: HashMap<EdgeClass, usize> = HashMap::new();
    for field in dyadic_fields(&mut rng) {
        let (mesh, sources) = as_mesh(&field);
        for (index, triangle) in sources.iter().enumerate() {
            // Both are counter-clockwise; the mesh may start at another corner.
            let corners = field.triangle(*triangle).unwrap().corners();
            let of_mesh = mesh.triangle(index).unwrap().corners();
            let shift = of_mesh.iter().position(|corner| *corner == corners[0]).unwrap();
            let (classes, expected) = (field.edge_classes(*triangle).unwrap(), mesh.edge_classes(index).unwrap());
            let (near, near_expected) = (field.neighbours(*triangle).unwrap(), mesh.neighbours(index).unwrap());
            for (edge, (class, near)) in classes.into_iter().zip(near).enumerate() {
                let same = (edge + shift) % 3;
                assert_eq!(class, expected[same]);
                assert_eq!(near, near_expected[same].map(|near| sources[near as usize]));
                *counts.entry(class).or_default() += 1;
            }
        }
        let classes: HashMap<[u64; 3], VertexClass> = (0..mesh.triangle_count())
            .flat_map(|t| {
                let corners = mesh.triangle(t).unwrap().corners();
                let class = |vertex: u32| mesh.vertex_class(vertex as usize).unwrap();
                corners.into_iter().zip(mesh.corners(t).unwrap().map(class))
            })
            .map(|(corner, class)| (corner.to_array().map(f64::to_bits), class))
            .collect();
        for row in 0..field.layout().rows {
            for column in 0..field.layout().columns {
                let vertex = field.vertex(column, row).unwrap().to_array().map(f64::to_bits);
                assert_eq!(field.vertex_class(column, row), classes.get(&vertex).copied(), "{column} {row}");
            }
        }
    }
    println!("{counts:?}");
    let border_convex_concave = [EdgeClass::Border, EdgeClass::Convex, EdgeClass::Concave];
    assert!(border_convex_concave.iter().all(|class| counts[class] > 100));
}

#[test]
fn heights_at_edges_of_holes_are_those_of_the_ground_beside_them() {
    let layout = centred(4, 3, [1.0, 1.0], Diagonal::Rising);
    let mut holes = [false; 6];
    holes[1] = true;
    let field = field(layout, &[2.0; 12], &holes);
    for (x, y, expected) in [
        (-1.5, -1.0, Some(0)),
        (-0.5, -0.5, Some(0)),
        (0.0, -0.5, None),
        (0.5, -0.5, Some(2)),
        (0.0, 0.0, Some(4)),
        (1.5, 1.0, Some(5)),
        (1.6, 0.0, None),
        (0.0, -1.1, None),
        (f64::NAN, 0.0, None),
        (0.0, f64::INFINITY, None),
    ] {
        let found = field.height_at(x, y);
        assert_eq!(found.map(|ground| ground.triangle / 2), expected, "{x} {y}");
        assert!(found.is_none_or(|ground| ground.height == 2.0 && ground.normal == DVec3::Z));
    }
    assert!(field.is_hole(1, 0) && !field.is_hole(0, 0) && field.is_hole(3, 0) && field.hole_count() == 1);
    assert_eq!(
        (field.triangle(2), field.triangle(12), field.material(3), field.material(4)),
        (None, None, None, Some(0))
    );
}

/// Only the border of a large field has ground: a ray passes its hole, and a distance costs little.
#[test]
fn large_holes_cost_little() {
    let ball = Sphere::new(0.5).unwrap();
    let near = Pose::from_translation(DVec3::new(0.2, 0.1, 0.4)).unwrap();
    let ray = Ray::new(DVec3::new(0.2, 0.1, 9.0), DVec3::NEG_Z).unwrap();
    for cells in [8, 32, 128, 512] {
        let size = cells + 1;
        let holes: Vec<bool> = (0..cells * cells)
            .map(|cell| [cell % cells, cell / cells].iter().all(|at| (1..cells - 1).contains(at)))
            .collect();
        let ring = field(centred(size, size, [1.0; 2], Diagonal::Rising), &vec![0.0; size * size], &holes);
        assert!(!hullmap::ray(&ring, &ray, &CastSettings::default()).hit);
        let gap = hullmap::distance(&ring, &ball, near, &Settings::default(), &mut Cache::new());
        let expected = 0.5 * cells as f64 - 1.2;
        assert!(gap.lower <= expected && gap.upper >= expected - 0.5, "{gap:?}");
        assert!(gap.support_calls < 200 + 8 * cells as u32, "{gap:?}");
    }
}
