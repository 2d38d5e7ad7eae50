//! Compares the mass of meshes with closed forms, and with sums that share no code with it.

use glam::{DMat3, DQuat, DVec3};

use super::mesh_mass;
use crate::mass::Mass;
use hullmap_geometry::PointSet;

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> PointSet {
    PointSet { triangles, ..PointSet::of_positions(positions) }
}

fn block(low: [f32; 3], high: [f32; 3]) -> PointSet {
    let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh((0..8).map(corner).collect(), triangles.collect())
}

fn inside_out(mut mesh: PointSet) -> PointSet {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

fn joined(meshes: &[PointSet]) -> PointSet {
    let mut all = PointSet::default();
    for part in meshes {
        let first = all.positions.len() as u32;
        all.positions.extend(&part.positions);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh(all.positions, all.triangles)
}

fn mapped(mut mesh: PointSet, map: impl Fn(DVec3) -> DVec3) -> PointSet {
    for p in &mut mesh.positions {
        *p = map(DVec3::from_array(p.map(f64::from))).to_array().map(|c| c as f32);
    }
    mesh
}

fn ball(bands: u32, sectors: u32, radius: f32) -> PointSet {
    let point = |band: u32, sector: u32| {
        let (polar, around) = (
            std::f64::consts::PI / f64::from(bands) * f64::from(band),
            f64::from(sector) / f64::from(sectors) * std::f64::consts::TAU,
        );
        let at =
            DVec3::new(libm::sin(polar) * libm::cos(around), libm::sin(polar) * libm::sin(around), libm::cos(polar));
        (at * f64::from(radius)).to_array().map(|c| c as f32)
    };
    let mut positions = vec![[0.0, 0.0, radius], [0.0, 0.0, -radius]];
    positions.extend((1..bands).flat_map(|band| (0..sectors).map(move |sector| point(band, sector))));
    let at = |band: u32, sector: u32| match band {
        0 => 0,
        band if band == bands => 1,
        band => 2 + (band - 1) * sectors + sector % sectors,
    };
    let mut triangles = Vec::new();
    for (band, sector) in (0..bands).flat_map(|band| (0..sectors).map(move |sector| (band, sector))) {
        let [a, b, c, d] = [at(band, sector), at(band + 1, sector), at(band + 1, sector + 1), at(band, sector + 1)];
        triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    mesh(positions, triangles)
}

#[track_caller]
fn assert_mass(found: Option<Mass>, volume: f64, centroid: [f64; 3], moments: [f64; 6], relative: f64) {
    let found = found.expect("the mesh bounds a solid");
    let size = moments[..3].iter().sum::<f64>();
    let off = |found: &[f64], expected: &[f64]| {
        found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max)
    };
    // NaN fails.
    assert!((found.volume - volume).abs() <= relative * volume, "volume {} instead of {volume}", found.volume);
    assert!(off(&found.centroid, &centroid) <= relative * size.sqrt(), "{:?} instead of {centroid:?}", found.centroid);
    assert!(
        off(&found.second_moments, &moments) <= relative * size,
        "{:?} instead of {moments:?}",
        found.second_moments
    );
}

fn of_box([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x * x / 12.0, y * y / 12.0, z * z / 12.0, 0.0, 0.0, 0.0]
}

#[test]
fn a_cube_and_a_box_off_the_origin() {
    assert_mass(mesh_mass(&block([0.0; 3], [1.0; 3])), 1.0, [0.5; 3], of_box([1.0; 3]), 1e-14);
    let found = mesh_mass(&block([3.0, -7.0, 1.5], [4.0, -5.0, 6.5]));
    assert_mass(found, 10.0, [3.5, -6.0, 4.0], of_box([1.0, 2.0, 5.0]), 1e-14);
    assert!((found.unwrap().surface_area - 34.0).abs() < 1e-12);
}

/// Integrals over the simplex of the unit vectors: 1/6, 1/24 and, for products, 1/60 or 1/120.
#[test]
fn a_tetrahedron() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let own = 6.0 / 60.0 - 1.0 / 16.0;
    let mixed = 6.0 / 120.0 - 1.0 / 16.0;
    let found = mesh_mass(&mesh(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]));
    assert_mass(found, 1.0 / 6.0, [0.25; 3], [own, own, own, mixed, mixed, mixed], 1e-14);
}

/// The polyhedron is inside the ball. Its volume falls short by less than twice the square of the
/// angle between its vertices.
#[test]
fn a_ball() {
    let (bands, sectors, radius) = (60, 120, 2.0);
    let mass = mesh_mass(&ball(bands, sectors, radius as f32)).unwrap();
    let full = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    let angle = std::f64::consts::PI / f64::from(bands);
    let missing = 1.0 - mass.volume / full;
    assert!(missing > 0.0 && missing < 2.0 * angle * angle, "{missing}");
    assert_mass(
        Some(mass),
        full,
        [0.0; 3],
        [0.2 * radius * radius, 0.2 * radius * radius, 0.2 * radius * radius, 0.0, 0.0, 0.0],
        2.0 * angle * angle,
    );
}

#[test]
fn far_tiny_and_huge_meshes() {
    let found = mesh_mass(&block([10_000.0, -10_000.0, 10_000.0], [10_001.0, -9_998.0, 10_005.0]));
    assert_mass(found, 10.0, [10_000.5, -9_999.0, 10_002.5], of_box([1.0, 2.0, 5.0]), 1e-12);
    for exponent in [-40_i32, -20, 20, 40] {
        let scale = 2.0_f64.powi(exponent);
        let found = mesh_mass(&mapped(block([1.0; 3], [2.0, 3.0, 6.0]), |p| p * scale));
        let edges = [scale, 2.0 * scale, 5.0 * scale];
        assert_mass(found, 10.0 * scale.powi(3), [1.5, 2.0, 3.5].map(|c| c * scale), of_box(edges), 1e-12);
    }
    for scale in [1e-6, 1e-12, 1e9] {
        let found = mesh_mass(&mapped(block([1.0; 3], [2.0, 3.0, 6.0]), |p| p * scale));
        let edges = [scale, 2.0 * scale, 5.0 * scale];
        assert_mass(found, 10.0 * scale.powi(3), [1.5, 2.0, 3.5].map(|c| c * scale), of_box(edges), 1e-6);
    }
}

#[test]
fn a_turned_box_has_products() {
    let turn = DQuat::from_array([0.3, -0.2, 0.5, 0.7]).normalize();
    let found = mesh_mass(&mapped(block([-0.5, -1.0, -2.5], [0.5, 1.0, 2.5]), |p| turn * p + DVec3::X));
    let [xx, yy, zz, ..] = of_box([1.0, 2.0, 5.0]);
    let turn = DMat3::from_quat(turn);
    let c = (turn * DMat3::from_diagonal(DVec3::new(xx, yy, zz)) * turn.transpose()).to_cols_array_2d();
    assert!(c[0][1].abs() > 0.02 && c[1][2].abs() > 0.02);
    assert_mass(found, 10.0, [1.0, 0.0, 0.0], [c[0][0], c[1][1], c[2][2], c[1][2], c[2][0], c[0][1]], 1e-6);
}

#[test]
fn disjoint_cubes_add_up() {
    let both = joined(&[block([0.0; 3], [1.0; 3]), block([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])]);
    // Each is 1.5 from the common centre.
    let moments = [1.0 / 12.0 + 2.25, 1.0 / 12.0, 1.0 / 12.0, 0.0, 0.0, 0.0];
    assert_mass(mesh_mass(&both), 2.0, [2.0, 0.5, 0.5], moments, 1e-14);
}

#[test]
fn an_inside_out_mesh_bounds_the_same_solid() {
    let found = mesh_mass(&inside_out(block([0.0; 3], [1.0, 2.0, 5.0])));
    assert_mass(found, 10.0, [0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]), 1e-14);
}

#[test]
fn a_cavity_is_not_solid() {
    let hollow = joined(&[block([0.0; 3], [3.0; 3]), inside_out(block([1.0; 3], [2.0; 3]))]);
    let moment = (27.0 * 9.0 / 12.0 - 1.0 / 12.0) / 26.0;
    assert_mass(mesh_mass(&hollow), 26.0, [1.5; 3], [moment, moment, moment, 0.0, 0.0, 0.0], 1e-13);
}

#[test]
fn an_open_or_inconsistent_mesh_has_no_mass() {
    let mut open = block([0.0; 3], [1.0; 3]);
    open.triangles.pop();
    assert_eq!(mesh_mass(&open), None);
    let mut twisted = block([0.0; 3], [1.0; 3]);
    twisted.triangles[0].swap(0, 1);
    assert_eq!(mesh_mass(&twisted), None);
    let mut sheet = block([0.0; 3], [1.0; 3]);
    sheet.triangles.truncate(2);
    assert_eq!(mesh_mass(&sheet), None);
    let other_side: Vec<[u32; 3]> = sheet.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    sheet.triangles.extend(other_side);
    assert_eq!(mesh_mass(&sheet), None, "a sheet of two sides");
    assert_eq!(mesh_mass(&mesh(vec![[1.0; 3]; 4], Vec::new())), None);
    assert_eq!(mesh_mass(&mesh(vec![[1.0; 3]; 4], vec![[0, 1, 2], [1, 2, 3]])), None);
}

/// STL files, for instance: no two triangles share a vertex.
#[test]
fn a_soup_of_triangles_is_welded() {
    let block = block([0.0; 3], [1.0, 2.0, 5.0]);
    let corners = block.triangles.iter().flatten().map(|v| block.positions[*v as usize]);
    let mut soup: Vec<[f32; 3]> = corners.collect();
    let triangles: Vec<[u32; 3]> =
        (0..soup.len() as u32).step_by(3).map(|first| [first, first + 1, first + 2]).collect();
    let expected = (10.0, [0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]));
    assert_mass(mesh_mass(&mesh(soup.clone(), triangles.clone())), expected.0, expected.1, expected.2, 1e-14);
    // Cracks of a millionth are closed, wider ones are not.
    soup[0][0] += 1e-6;
    assert_mass(mesh_mass(&mesh(soup.clone(), triangles.clone())), expected.0, expected.1, expected.2, 1e-5);
    soup[0][0] += 1e-3;
    assert_eq!(mesh_mass(&mesh(soup, triangles)), None);
}

#[test]
fn repeated_triangles_count_once() {
    let block = block([0.0; 3], [1.0, 2.0, 5.0]);
    let twice = joined(&[block.clone(), block.clone()]);
    assert_mass(mesh_mass(&twice), 10.0, [0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]), 1e-14);
    let mut once_more = block;
    once_more.triangles.push(once_more.triangles[3]);
    assert_mass(mesh_mass(&once_more), 10.0, [0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]), 1e-14);
}

#[test]
fn touching_boxes_are_one() {
    let both = joined(&[block([0.0; 3], [1.0; 3]), block([1.0, 0.0, 0.0], [3.0, 1.0, 1.0])]);
    assert_mass(mesh_mass(&both), 3.0, [1.5, 0.5, 0.5], of_box([3.0, 1.0, 1.0]), 1e-14);
}

#[test]
fn overlapping_shells_count_once() {
    let both = joined(&[block([0.0; 3], [2.0, 1.0, 1.0]), block([1.0, 0.1, 0.1], [3.0, 0.9, 0.9])]);
    let (first, second, shared) = (2.0, 2.0 * 0.64, 0.64);
    let volume = first + second - shared;
    let x = (first + second * 2.0 - shared * 1.5) / volume;
    let found = mesh_mass(&both).unwrap();
    assert!((found.volume - volume).abs() < 0.01 * shared, "{} instead of {volume}", found.volume);
    assert!((found.centroid[0] - x).abs() < 0.01 * shared, "{} instead of {x}", found.centroid[0]);
    let nested = joined(&[block([0.0; 3], [3.0; 3]), block([1.0; 3], [2.0; 3])]);
    let found = mesh_mass(&nested).unwrap().volume;
    assert!((found - 27.0).abs() < 0.02, "{found} instead of 27");
    let beside = joined(&[block([0.0; 3], [1.0; 3]), inside_out(block([2.0, 0.0, 0.0], [4.0, 1.0, 1.0]))]);
    let found = mesh_mass(&beside).unwrap().volume;
    assert!((found - 3.0).abs() < 0.02, "{found} instead of 3");
}
