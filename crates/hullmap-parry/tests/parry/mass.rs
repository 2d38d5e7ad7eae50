//! Bodies weigh as much as their mesh: compounds of overlapping parts, against parry's own mass
//! properties of the triangle mesh.

use std::sync::Arc;

use hullmap::{MassSource, Pack};
use hullmap_bake::fit::mesh_mass;
use hullmap_bake::{BakedHull as Baked, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_parry::{BakedHull, PartMass, compound, objects, union};
use hullmap_testkit::packs::{corners, point_set};
use parry3d::mass_properties::MassProperties;
use parry3d::math::Vector;
use parry3d::shape::{Shape, TriMesh};

/// Largest relative difference: parry computes in f32.
const ROUNDING: f32 = 1e-4;

/// An L of height 1 and volume 4.
fn letter_l() -> PointSet {
    let l = shapes::concave::l();
    PointSet { triangles: l.fans(), ..point_set("l", &l.vertices) }
}

fn block(high: [f32; 3]) -> Baked {
    bake_hull(&point_set("l", &corners([0.0; 3], high)), IndexKind::Tree).unwrap()
}

/// The L as two bars that overlap in its corner, then a cube that is an object of its own.
fn pack() -> Arc<Pack> {
    let part = |part, baked| Baked { part, part_count: 2, ..baked };
    let first = Baked { mesh_mass: mesh_mass(&letter_l()), ..part(0, block([2.0, 1.0, 1.0])) };
    let hulls = [first, part(1, block([1.0, 3.0, 1.0])), block([1.0, 1.0, 1.0])];
    Arc::new(Pack::from_bytes(&write_pack(&hulls, &SourceRecord::default()).unwrap()).unwrap())
}

/// parry's mass properties of the triangles, scaled.
fn judge(scale: Vector, density: f32) -> MassProperties {
    let mesh = letter_l();
    let vertices = mesh.positions.iter().map(|p| Vector::from_array(*p) * scale).collect();
    let mut triangles = mesh.triangles;
    if scale.x * scale.y * scale.z < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    }
    TriMesh::new(vertices, triangles).unwrap().mass_properties(density)
}

#[track_caller]
fn assert_same(found: &MassProperties, expected: &MassProperties) {
    assert!((found.mass() / expected.mass() - 1.0).abs() < ROUNDING, "{} {}", found.mass(), expected.mass());
    assert!(found.local_com.distance(expected.local_com) < ROUNDING, "{} {}", found.local_com, expected.local_com);
    let [found, expected] = [found, expected].map(|mass| mass.reconstruct_inertia_matrix().to_cols_array());
    let size = expected.iter().fold(0.0, |size: f32, entry| size.max(entry.abs()));
    // NaN fails.
    let near = |(found, expected): (&f32, &f32)| (found - expected).abs() < ROUNDING * size;
    assert!(found.iter().zip(&expected).all(near), "{found:?} {expected:?}");
}

#[test]
fn a_compound_of_overlapping_parts_weighs_as_much_as_its_mesh() {
    let pack = pack();
    let body = pack.mass_properties_of(0..2, 7.0).unwrap();
    assert!((body.mass - 28.0).abs() < 1e-9 && body.source == MassSource::Mesh);
    // The cube has no mesh, so the whole pack is a mixture.
    let all = pack.mass_properties(7.0);
    assert!((all.mass - 35.0).abs() < 1e-9 && all.source == MassSource::Hulls);
    let found = objects(&pack);
    assert_same(&found[0].shape.mass_properties(7.0), &judge(Vector::ONE, 7.0));
    assert!((found[1].shape.mass_properties(7.0).mass() - 7.0).abs() < 1e-4);
    let whole = compound(&pack).unwrap().mass_properties(7.0);
    assert!((whole.mass() - 35.0).abs() < 1e-3, "{}", whole.mass());
}

#[test]
fn scaled_and_mirrored_bodies_weigh_as_much_as_their_scaled_mesh() {
    let pack = pack();
    for scale in [Vector::new(2.0, 0.5, 3.0), Vector::new(-1.0, 1.5, 0.25)] {
        let parts = [0, 1].map(|index| BakedHull::new(pack.shared_hull(index).unwrap()).scaled(scale).unwrap());
        assert_same(&union(parts).unwrap().mass_properties(2.0), &judge(scale, 2.0));
    }
}

/// A part alone, parts out of order and parts at different scales have their own masses.
#[test]
fn incomplete_bodies_have_the_mass_of_their_hulls() {
    let pack = pack();
    let part = |index| BakedHull::new(pack.shared_hull(index).unwrap());
    assert_eq!(part(0).part_mass(), PartMass::Hull);
    let mass = |parts: Vec<BakedHull>| union(parts).unwrap().mass_properties(1.0).mass();
    assert!((mass(vec![part(0)]) - 2.0).abs() < 1e-4);
    assert!((mass(vec![part(1), part(0)]) - 5.0).abs() < 1e-4);
    assert!((mass(vec![part(0), part(2)]) - 3.0).abs() < 1e-4);
    assert!((mass(vec![part(0), part(1).scaled(Vector::splat(2.0)).unwrap()]) - 26.0).abs() < 1e-3);
    assert!((mass(vec![part(0), part(1), part(0), part(1)]) - 8.0).abs() < 1e-4, "two bodies");
}

/// A hull of a whole mesh that is not convex.
#[test]
fn a_single_hull_weighs_as_much_as_its_mesh() {
    let baked = bake_hull(&letter_l(), IndexKind::Tree).unwrap();
    let pack = Arc::new(Pack::from_bytes(&write_pack(&[baked], &SourceRecord::default()).unwrap()).unwrap());
    assert!((pack.hull(0).unwrap().volume() - 5.0).abs() < 1e-9);
    let hull = BakedHull::new(pack.shared_hull(0).unwrap());
    assert_same(&hull.mass_properties(3.0), &judge(Vector::ONE, 3.0));
    assert_same(&compound(&pack).unwrap().mass_properties(3.0), &judge(Vector::ONE, 3.0));
}

#[cfg(feature = "serde")]
#[test]
fn saved_bodies_keep_their_mass() {
    use hullmap_parry::SavedShape;
    use std::collections::BTreeMap;

    let packs = BTreeMap::from([("l".to_owned(), pack())]);
    let shape = compound(&packs["l"]).unwrap();
    let text = serde_json::to_string(&SavedShape::from_shape(&shape, &packs).unwrap()).unwrap();
    let loaded = serde_json::from_str::<SavedShape>(&text).unwrap().load(&packs).unwrap();
    assert_eq!(loaded.mass_properties(1.0), shape.mass_properties(1.0));
    // A file of an earlier version has no such field.
    let old = text.replace(",\"mass\":\"Mesh\"", "").replace(",\"mass\":\"Nothing\"", "");
    let loaded = serde_json::from_str::<SavedShape>(&old).unwrap().load(&packs).unwrap();
    assert!((loaded.mass_properties(1.0).mass() - 6.0).abs() < 1e-4);
}
