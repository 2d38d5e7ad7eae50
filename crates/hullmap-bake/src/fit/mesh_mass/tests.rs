//! Compares the mass of meshes with closed forms.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};
use shapes::solids::lathe;

use super::mesh_mass;
use crate::test_meshes::{block, doubled, inside_out, joined, mesh, point_set};
use hullmap_geometry::PointSet;

fn mapped(mut mesh: PointSet, map: impl Fn(DVec3) -> DVec3) -> PointSet {
    for p in &mut mesh.positions {
        *p = map(DVec3::from_array(p.map(f64::from))).as_vec3().to_array();
    }
    mesh
}

#[track_caller]
fn assert_mass(name: &str, mesh: &PointSet, volume: f64, centroid: [f64; 3], moments: [f64; 6], relative: f64) {
    let found = mesh_mass(mesh).unwrap_or_else(|| panic!("{name} bounds no solid"));
    let size = moments[..3].iter().sum::<f64>();
    let is_near = |found: &[f64], expected: &[f64], within: f64| {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= within)
    };
    assert!(is_near(&[found.volume], &[volume], relative * volume), "{name}: {} is not {volume}", found.volume);
    assert!(is_near(&found.centroid, &centroid, relative * size.sqrt()), "{name}: {:?}", found.centroid);
    assert!(is_near(&found.second_moments, &moments, relative * size), "{name}: {:?}", found.second_moments);
}

fn of_box([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x * x / 12.0, y * y / 12.0, z * z / 12.0, 0.0, 0.0, 0.0]
}

/// A box of edges 1, 2 and 5 in the middle of which is (0.5, 1, 2.5).
fn bar() -> PointSet {
    block([0.0; 3], [1.0, 2.0, 5.0])
}

#[test]
fn solids_have_the_mass_of_their_closed_forms() {
    let unit = || block([0.0; 3], [1.0; 3]);
    // Integrals over the simplex of the unit vectors are 1/6, 1/24 and, for products, 1/60 or
    // 1/120.
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let tetrahedron = mesh(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let (own, mixed) = (6.0 / 60.0 - 1.0 / 16.0, 6.0 / 120.0 - 1.0 / 16.0);
    let hollow = joined(&[block([0.0; 3], [3.0; 3]), inside_out(block([1.0; 3], [2.0; 3]))]);
    let of_hollow = (27.0 * 9.0 / 12.0 - 1.0 / 12.0) / 26.0;
    let apart = joined(&[unit(), block([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])]);
    let touching = joined(&[unit(), block([1.0, 0.0, 0.0], [3.0, 1.0, 1.0])]);
    let mut repeated = bar();
    repeated.triangles.push(repeated.triangles[3]);
    let (middle, of_bar) = ([0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]));
    let far = block([10_000.0, -10_000.0, 10_000.0], [10_001.0, -9_998.0, 10_005.0]);
    let cases = [
        ("a cube", unit(), 1.0, [0.5; 3], of_box([1.0; 3]), 1e-14),
        ("off the origin", block([3.0, -7.0, 1.5], [4.0, -5.0, 6.5]), 10.0, [3.5, -6.0, 4.0], of_bar, 1e-14),
        ("far from the origin", far, 10.0, [10_000.5, -9_999.0, 10_002.5], of_bar, 1e-12),
        ("inside out", inside_out(bar()), 10.0, middle, of_bar, 1e-14),
        ("a box twice", joined(&[bar(), bar()]), 10.0, middle, of_bar, 1e-14),
        ("a triangle twice", repeated, 10.0, middle, of_bar, 1e-14),
        ("a tetrahedron", tetrahedron, 1.0 / 6.0, [0.25; 3], [own, own, own, mixed, mixed, mixed], 1e-14),
        ("a cavity", hollow, 26.0, [1.5; 3], [of_hollow, of_hollow, of_hollow, 0.0, 0.0, 0.0], 1e-13),
        // Each cube is 1.5 from the common centre.
        ("apart", apart, 2.0, [2.0, 0.5, 0.5], [28.0 / 12.0, 1.0 / 12.0, 1.0 / 12.0, 0.0, 0.0, 0.0], 1e-14),
        ("touching boxes", touching, 3.0, [1.5, 0.5, 0.5], of_box([3.0, 1.0, 1.0]), 1e-14),
    ];
    for (name, mesh, volume, centroid, moments, relative) in cases {
        assert_mass(name, &mesh, volume, centroid, moments, relative);
    }
    assert!((mesh_mass(&bar()).unwrap().surface_area - 34.0).abs() < 1e-12);
}

/// The polyhedron is inside the ball. Its volume falls short by less than twice the square of the
/// angle between its vertices.
#[test]
fn a_ball() {
    let (bands, radius) = (60, 2.0_f64);
    let angle = PI / f64::from(bands);
    let at = |band: u32| [libm::sin(angle * f64::from(band)), -libm::cos(angle * f64::from(band))].map(|c| c * radius);
    let mut profile: Vec<[f64; 2]> = (0..=bands).map(at).collect();
    (profile[0][0], profile[bands as usize][0]) = (0.0, 0.0);
    let ball = point_set(&lathe(&profile, 2 * bands));
    let full = 4.0 / 3.0 * PI * radius.powi(3);
    let missing = 1.0 - mesh_mass(&ball).unwrap().volume / full;
    assert!(missing > 0.0 && missing < 2.0 * angle * angle, "{missing}");
    let own = 0.2 * radius * radius;
    assert_mass("a ball", &ball, full, [0.0; 3], [own, own, own, 0.0, 0.0, 0.0], 2.0 * angle * angle);
}

#[test]
fn tiny_and_huge_meshes() {
    // Powers of two round no coordinate.
    let scales = [-40_i32, -20, 20, 40].map(|exponent| (2.0_f64.powi(exponent), 1e-12));
    for (scale, relative) in scales.into_iter().chain([1e-6, 1e-12, 1e9].map(|scale| (scale, 1e-6))) {
        let scaled = mapped(block([1.0; 3], [2.0, 3.0, 6.0]), |p| p * scale);
        let (centroid, moments) = ([1.5, 2.0, 3.5].map(|c| c * scale), of_box([1.0, 2.0, 5.0].map(|c| c * scale)));
        assert_mass(&format!("scale {scale}"), &scaled, 10.0 * scale.powi(3), centroid, moments, relative);
    }
}

#[test]
fn a_turned_box_has_products() {
    let turn = DQuat::from_array([0.3, -0.2, 0.5, 0.7]).normalize();
    let turned = mapped(block([-0.5, -1.0, -2.5], [0.5, 1.0, 2.5]), |p| turn * p + DVec3::X);
    let [xx, yy, zz, ..] = of_box([1.0, 2.0, 5.0]);
    let turn = DMat3::from_quat(turn);
    let c = (turn * DMat3::from_diagonal(DVec3::new(xx, yy, zz)) * turn.transpose()).to_cols_array_2d();
    assert!(c[0][1].abs() > 0.02 && c[1][2].abs() > 0.02);
    let moments = [c[0][0], c[1][1], c[2][2], c[1][2], c[2][0], c[0][1]];
    assert_mass("turned", &turned, 10.0, [1.0, 0.0, 0.0], moments, 1e-6);
}

#[test]
fn an_open_or_inconsistent_mesh_has_no_mass() {
    let changed = |change: fn(&mut PointSet)| {
        let mut cube = block([0.0; 3], [1.0; 3]);
        change(&mut cube);
        cube
    };
    let sheet = changed(|cube| cube.triangles.truncate(2));
    let cases = [
        ("a missing triangle", changed(|cube| _ = cube.triangles.pop())),
        ("a reversed triangle", changed(|cube| cube.triangles[0].swap(0, 1))),
        ("a sheet", sheet.clone()),
        ("a sheet of two sides", doubled(sheet)),
        ("no triangles", mesh(vec![[1.0; 3]; 4], Vec::new())),
        ("triangles at a point", mesh(vec![[1.0; 3]; 4], vec![[0, 1, 2], [1, 2, 3]])),
    ];
    for (name, mesh) in cases {
        assert_eq!(mesh_mass(&mesh), None, "{name}");
    }
}

/// STL files, for instance: no two triangles share a vertex.
#[test]
fn a_soup_of_triangles_is_welded() {
    let bar = bar();
    let corners = bar.triangles.iter().flatten().map(|v| bar.positions[*v as usize]).collect();
    let mut soup = mesh(corners, (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let (middle, of_bar) = ([0.5, 1.0, 2.5], of_box([1.0, 2.0, 5.0]));
    assert_mass("no crack", &soup, 10.0, middle, of_bar, 1e-14);
    // Cracks of a millionth are closed, wider ones are not.
    soup.positions[0][0] += 1e-6;
    assert_mass("a crack", &soup, 10.0, middle, of_bar, 1e-5);
    soup.positions[0][0] += 1e-3;
    assert_eq!(mesh_mass(&soup), None);
}

#[test]
fn overlapping_shells_count_once() {
    let overlapping = joined(&[block([0.0; 3], [2.0, 1.0, 1.0]), block([1.0, 0.1, 0.1], [3.0, 0.9, 0.9])]);
    let (first, second, shared) = (2.0, 2.0 * 0.64, 0.64);
    let volume = first + second - shared;
    let x = (first + second * 2.0 - shared * 1.5) / volume;
    let found = mesh_mass(&overlapping).unwrap().centroid[0];
    assert!((found - x).abs() < 0.01 * shared, "{found} instead of {x}");
    let nested = joined(&[block([0.0; 3], [3.0; 3]), block([1.0; 3], [2.0; 3])]);
    let beside = joined(&[block([0.0; 3], [1.0; 3]), inside_out(block([2.0, 0.0, 0.0], [4.0, 1.0, 1.0]))]);
    for (mesh, volume, within) in [(&overlapping, volume, 0.01 * shared), (&nested, 27.0, 0.02), (&beside, 3.0, 0.02)] {
        let found = mesh_mass(mesh).unwrap().volume;
        assert!((found - volume).abs() < within, "{found} instead of {volume}");
    }
}
