use glam::{DQuat, DVec3};
use hullmap_format::header::HEADER_LEN;
use hullmap_format::triangle_mesh::{check, class::VertexClass, sections::Sections};
use rkyv::util::AlignedVec;
use shapes::rng::SplitMix64;

use super::*;
use crate::test_meshes::{block, on_threads};

fn bake(positions: &[[f32; 3]], corners: &[[u32; 3]]) -> BakedTriangleMesh {
    bake_triangle_mesh(&Triangles { positions, corners, materials: &[] }).unwrap()
}

fn checked(baked: &BakedTriangleMesh) {
    let file = write_triangle_mesh(baked.clone(), &SourceRecord::default()).unwrap();
    let mut payload = AlignedVec::<HEADER_LEN>::new();
    payload.extend_from_slice(&file[HEADER_LEN..]);
    let sections = Sections::read(&payload).unwrap();
    check::check(&sections, &payload).unwrap();
}

fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let cube = block([0.0; 3], [1.0; 3]);
    (cube.positions, cube.triangles)
}

#[test]
fn a_cube_has_ridges_and_its_inside_has_valleys() {
    let (positions, corners) = cube();
    let turned: Vec<[u32; 3]> = corners.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    for (corners, edges, class) in
        [(corners, [0, 12, 24, 0, 0, 0], VertexClass::Convex), (turned, [0, 12, 0, 24, 0, 0], VertexClass::Concave)]
    {
        let baked = bake(&positions, &corners);
        assert_eq!(baked.counts().edges, edges);
        assert!(baked.mesh.vertex_classes.iter().all(|found| *found == class.code()));
        checked(&baked);
    }
}

#[test]
fn vertices_that_files_repeat_are_merged() {
    let (positions, corners) = cube();
    let unshared: Vec<[f32; 3]> = corners.as_flattened().iter().map(|corner| positions[*corner as usize]).collect();
    let own: Vec<[u32; 3]> = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let baked = bake(&unshared, &own);
    let counts = baked.counts();
    assert_eq!((counts.vertices, counts.merged), (8, 28));
    assert_eq!(counts, MeshCounts { merged: 28, ..bake(&positions, &corners).counts() });
    // -0 equals 0.
    let baked = bake(&[[0.0; 3], [-0.0, 0.0, -0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 2, 3], [1, 3, 2]]);
    assert_eq!((baked.counts().vertices, baked.counts().duplicate), (3, 1));
}

#[test]
fn flaws_are_kept_and_counted() {
    let (mut positions, mut corners) = cube();
    // Twice the same triangle, one with a corner twice, one on a line, and one reversed.
    corners.push(corners[3]);
    corners.push([0, 0, 7]);
    positions.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [7.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, -1.0, 0.0]]);
    corners.push([8, 9, 10]);
    corners.extend([[8, 9, 11], [8, 9, 12]]);
    let baked = bake(&positions, &corners);
    let counts = baked.counts();
    assert_eq!((counts.triangles, counts.duplicate, counts.degenerate), (17, 1, 2));
    assert_eq!(counts.edges[usize::from(EdgeClass::NonManifold.code())], 3);
    checked(&baked);
    let baked = bake(&positions, &[[8, 9, 11], [8, 9, 12]]);
    assert_eq!(baked.counts().edges, [4, 0, 0, 0, 0, 2]);
    checked(&baked);
}

#[test]
fn errors_name_what_is_wrong() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
    let of = |corners: &[[u32; 3]], materials: &[u16]| {
        bake_triangle_mesh(&Triangles { positions: &positions, corners, materials }).unwrap_err()
    };
    assert_eq!(of(&[], &[]), BakeError::Empty);
    assert_eq!(of(&[[0, 1, 1], [0, 1, 3]], &[]), BakeError::Corner { triangle: 1, found: 3, vertex_count: 3 });
    assert_eq!(of(&[[0, 1, 2]], &[]), BakeError::NotFinite { source_vertex: 2 });
    assert_eq!(of(&[[0, 1, 1]], &[1, 2]), BakeError::Materials { found: 2, expected: 1 });
}

/// Random soups, flat and far, from one triangle on: every file passes the check, every triangle is
/// there once, and neither threads nor the order of equal keys change a byte.
#[test]
fn random_soups_pass_the_check() {
    const SEED: u64 = 39;
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    for count in (1..40).chain([1000, 9000]) {
        let scale = [1e-3_f32, 1.0, 1e6][count % 3];
        let offset = [0.0, 1e4, -3e7][count / 3 % 3];
        let is_flat = count % 5 == 0;
        let vertex_count = count + 2;
        let positions: Vec<[f32; 3]> = (0..vertex_count)
            .map(|_| {
                let [x, y, z] = [(); 3].map(|()| rng.unit() as f32 * scale + offset);
                [x, y, if is_flat { offset } else { z }]
            })
            .collect();
        let corner = |rng: &mut SplitMix64| (rng.next_u64() % vertex_count as u64) as u32;
        let corners: Vec<[u32; 3]> = (0..count).map(|_| [(); 3].map(|()| corner(&mut rng))).collect();
        let baked = bake(&positions, &corners);
        checked(&baked);
        let mut sources = baked.mesh.source_triangles.clone();
        sources.sort_unstable();
        assert!(sources.into_iter().eq(0..count as u32));
        for (at, source) in baked.mesh.source_triangles.iter().enumerate() {
            let own = baked.mesh.triangles[at].map(|corner| baked.mesh.vertices[corner as usize]);
            assert_eq!(own, corners[*source as usize].map(|corner| positions[corner as usize].map(|c| c + 0.0)));
        }
        let again = on_threads(1, || bake(&positions, &corners));
        let bytes = |baked: BakedTriangleMesh| write_triangle_mesh(baked, &SourceRecord::default()).unwrap();
        assert_eq!(bytes(again), bytes(baked));
    }
}

fn t_junctions_by_hand(mesh: &TriangleMesh) -> usize {
    let at = |corner: u32| DVec3::from_array(mesh.vertices[corner as usize].map(f64::from));
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for corners in &mesh.triangles {
        for edge in 0..3 {
            edges.push(([corners[edge], corners[(edge + 1) % 3]], corners[(edge + 2) % 3]));
        }
    }
    let is_same = |a: &[u32; 2], b: &[u32; 2]| a == b || *a == [b[1], b[0]];
    let border = |edge: &&([u32; 2], u32)| edges.iter().filter(|other| is_same(&other.0, &edge.0)).count() == 1;
    let border: Vec<_> = edges.iter().filter(border).collect();
    let [low, high] = bounds(&mesh.vertices).map(|corner| DVec3::from_array(corner.map(f64::from)));
    let tolerance = 1e-6 * low.distance(high);
    let is_junction = |vertex: &u32| {
        border.iter().any(|([a, b], c)| {
            let (p, a_at, b_at) = (at(*vertex), at(*a), at(*b));
            let (to_a, to_b) = (p.distance(a_at), p.distance(b_at));
            // A point of a segment is as far from both ends together as they are from each other.
            let off = (p - a_at).cross(b_at - a_at).length() / a_at.distance(b_at);
            let is_inside = (p - a_at).dot(b_at - a_at) > 0.0 && (p - b_at).dot(a_at - b_at) > 0.0;
            ![a, b, c].contains(&vertex) && is_inside && off <= tolerance && to_a.min(to_b) > 2.0 * tolerance
        })
    };
    let on_border = |vertex: &u32| border.iter().any(|(ends, _)| ends.contains(vertex));
    (0..mesh.vertices.len() as u32).filter(on_border).filter(is_junction).count()
}

/// Rows of squares, narrower in each row, so that their corners lie on edges of others.
fn rows(widths: &[usize], turn: DQuat, scale: f64) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for (row, count) in widths.iter().enumerate() {
        for column in 0..*count {
            let first = positions.len() as u32;
            for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                let p = DVec3::new((column + x) as f64 / *count as f64 * 10.0, (row + y) as f64, 0.0);
                positions.push((turn * p * scale).as_vec3().to_array());
            }
            corners.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    (positions, corners)
}

#[test]
fn t_junctions_are_those_of_the_slow_twin() {
    let turned = DQuat::from_xyzw(0.1, 0.35, 0.8, 0.4).normalize();
    for (widths, expected) in [(&[4, 4, 4][..], 0), (&[1, 2], 1), (&[2, 3], 3), (&[1, 10, 1], 18), (&[7, 5, 3], 16)] {
        for (turn, scale) in [(DQuat::IDENTITY, 1.0), (turned, 1.0), (turned, 1e-3), (turned, 1e4)] {
            let (positions, corners) = rows(widths, turn, scale);
            let baked = bake(&positions, &corners);
            let found = TJunctions { count: expected, is_complete: true };
            assert_eq!(
                (baked.t_junctions(), t_junctions_by_hand(&baked.mesh)),
                (found, expected),
                "{widths:?} {scale}"
            );
        }
    }
    let (positions, corners) = cube();
    assert_eq!(bake(&positions, &corners).t_junctions().count, 0);
    // The third corner of a triangle without area is on its longest edge.
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.25, 0.0, 0.0]];
    assert_eq!(bake(&line, &[[0, 1, 2]]).t_junctions().count, 0);
}

/// Edges that all cross in one place: the work stays bounded, and the count is a lower bound.
#[test]
fn edges_that_cross_in_one_place_cost_no_square() {
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    let count = 20_000;
    for edge in 0..count {
        let t = 2.0 * f64::from(edge) / f64::from(count) - 1.0;
        let [x, y] = [1.0 - t * t, 2.0 * t].map(|c| c / (1.0 + t * t));
        let first = positions.len() as u32;
        positions.extend([[x, y, 0.0], [-x, -y, 0.0], [y, -x, 2.0 + t]].map(|p| p.map(|c| c as f32)));
        corners.push([first, first + 1, first + 2]);
    }
    let near = |i: usize| [1e-4 * (i % 100) as f32, 1e-4 * (i / 100) as f32, 0.3];
    for i in 0..5_000 {
        let first = positions.len() as u32;
        positions.extend([near(i), near(i + 1), near(i + 100)]);
        corners.push([first, first + 1, first + 2]);
    }
    let found = bake(&positions, &corners).t_junctions();
    assert!(!found.is_complete);
    assert_eq!(on_threads(1, || bake(&positions, &corners).t_junctions()), found);
}
