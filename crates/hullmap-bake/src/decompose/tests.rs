use shapes::{concave, mesh::Mesh, solids::extrusion};

use super::*;
use crate::{
    fit::{Looseness, fits, looseness},
    mass::{Mass, mass},
};

/// A mesh as a point set.
pub fn point_set(mesh: &Mesh) -> PointSet {
    PointSet {
        name: "mesh".into(),
        positions: mesh.vertices.clone(),
        source_vertices: (0..mesh.vertices.len() as u32).collect(),
        triangles: mesh.fans(),
        ..PointSet::default()
    }
}

fn hulls(mesh: &PointSet, cover: &Cover) -> Vec<Hull> {
    let parts = decompose(mesh, cover).unwrap().unwrap();
    parts.iter().map(|part| hull::build(part).unwrap()).collect()
}

fn loose(mesh: &PointSet, parts: &[Hull]) -> Looseness {
    looseness(&Solid::new(mesh), &hull::build(mesh).unwrap(), &parts.iter().collect::<Vec<_>>())
}

/// Two bars that cross, each closed.
fn cross() -> PointSet {
    let bar = |x: f64, y: f64| extrusion(&[[-x, -y], [x, -y], [x, y], [-x, y]], -0.5, 0.5);
    let [mut mesh, other] = [bar(3.0, 0.5), bar(0.5, 3.0)].map(|mesh| point_set(&mesh));
    mesh.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|v| v + 8)));
    mesh.positions.extend(other.positions);
    mesh.source_vertices = (0..16).collect();
    mesh
}

/// The result for a smaller error is a candidate for a larger one.
#[test]
fn larger_errors_take_fewer_parts() {
    for mesh in [concave::horseshoe(6), concave::pipe(10), concave::l()] {
        let mesh = point_set(&mesh);
        let mut last = (usize::MAX, usize::MAX);
        let mut first = None;
        for error in [1.0, 2.0, 2.9, 4.0, 6.5, 10.0] {
            let cover = Cover { max_error: Length::Relative(0.01 * error), ..Cover::default() };
            let parts = hulls(&mesh, &cover);
            let size = (parts.len(), parts.iter().map(|part| part.vertices.len()).sum());
            assert!(size <= last, "{error} %: {size:?} after {last:?}");
            for part in &parts {
                let Mass { volume, surface_area, .. } = mass(part);
                assert!(4.0 * volume > 1e-3 * part.diameter * surface_area, "{error} %: a sliver of {volume}");
            }
            first.get_or_insert(size.0);
            last = size;
        }
        assert!(first.unwrap() > last.0 || last.0 == 2, "the sample is not representative");
    }
}

#[test]
fn parts_are_tight_and_apart() {
    for mesh in [concave::pipe(24), concave::horseshoe(16)] {
        let mesh = point_set(&mesh);
        let cover = Cover::default();
        let parts = hulls(&mesh, &cover);
        let diagonal = Solid::new(&mesh).diagonal();
        let found = loose(&mesh, &parts);
        assert!(found.overlap < 0.01 && found.outside_hull < 1e-3 * diagonal, "{found:?}");
        let fits = fits(&mesh, &parts.iter().collect::<Vec<_>>(), None).unwrap();
        let worst = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
        assert!(worst > 0.005 * diagonal && found.mean_protrusion < 0.5 * worst, "{found:?} {worst}");
    }
}

/// Two bars of volume 6 have a cube in common. Apart, they are three.
#[test]
fn parts_that_cross_are_divided_if_they_may_not_overlap() {
    let mesh = cross();
    let of = |overlap| hulls(&mesh, &Cover { overlap, ..Cover::default() });
    let (free, apart) = (of(f64::INFINITY), of(0.05));
    assert_eq!((free.len(), apart.len()), (2, 3));
    assert!((loose(&mesh, &free).overlap - 1.0 / 11.0).abs() < 0.02, "{:?}", loose(&mesh, &free));
    assert!(loose(&mesh, &apart).overlap < 0.01, "{:?}", loose(&mesh, &apart));
}

/// A sheet has no inside; its parts have a thickness.
#[test]
fn parts_of_a_sheet_have_a_thickness() {
    let positions = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0], [0.0, 4.0, 4.0]];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]];
    let mesh = PointSet { positions, source_vertices: (0..5).collect(), triangles, ..PointSet::default() };
    let diagonal = Solid::new(&mesh).diagonal();
    let parts = hulls(&mesh, &Cover::default());
    for part in &parts {
        let thickness = 2.0 * mass(part).volume / mass(part).surface_area;
        assert!(thickness > 4e-3 * diagonal, "{thickness} {:?}", part.vertices);
    }
    let fits = fits(&mesh, &parts.iter().collect::<Vec<_>>(), None).unwrap();
    assert!(fits.iter().all(|fit| fit.protrusion <= 0.02 * diagonal && fit.uncovered <= 1e-7 * diagonal), "{fits:?}");
}

/// Triangles that no part covers are absorbed, or become parts where there may be more.
#[test]
fn the_number_of_parts_is_never_exceeded() {
    let mesh = point_set(&concave::l());
    let (solid, cover) = (Solid::new(&mesh), Cover::default());
    let mut levels = Levels::new(&mesh, &solid, &cover, 64, Stage::default(), None);
    let Found { mut parts, limit } = levels.parts().unwrap();
    assert_eq!(parts.len(), 2);
    parts.truncate(1);
    for max_parts in [Some(1), Some(2), None] {
        let found = Found { parts: parts.clone(), limit };
        let hulls = finished(&mesh, &SourceVertices::new(&mesh), &levels, found, max_parts);
        assert!(max_parts.is_none_or(|count| hulls.len() <= count as usize), "{} of {max_parts:?}", hulls.len());
        let fits = fits(&mesh, &hulls.iter().collect::<Vec<_>>(), None).unwrap();
        assert!(fits[0].uncovered <= 1e-7 * solid.diagonal(), "{max_parts:?}: {:?}", fits[0]);
        // Without a maximum, the maximum error holds.
        let worst = fits.iter().map(|fit| fit.protrusion).fold(0.0, f64::max);
        let error = cover.max_error.of(solid.diagonal());
        assert!(max_parts.is_some() || worst <= error, "{worst} of {error}");
    }
}
