//! Packs made in process.

use bevy_math::Vec3;
use hullmap_bake::fit::mesh_mass;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};

/// A pack with a hull for each named set of points.
pub fn pack(sets: &[(&str, Vec<[f32; 3]>)]) -> Vec<u8> {
    let hulls = sets.iter().map(|(name, positions)| {
        let set = PointSet {
            name: (*name).into(),
            source_vertices: (0..positions.len() as u32).collect(),
            positions: positions.clone(),
            ..Default::default()
        };
        bake_hull(&set, IndexKind::Tree).expect("the points have a hull")
    });
    let hulls: Vec<_> = hulls.collect();
    write_pack(&hulls, &SourceRecord::default()).expect("the hulls fit into a pack")
}

/// Corners of a box around `centre`.
pub fn corners(centre: Vec3, half: Vec3) -> Vec<[f32; 3]> {
    let sign = |i: u8, bit: u8| if i & bit == 0 { -1.0 } else { 1.0 };
    (0..8).map(|i| (centre + half * Vec3::new(sign(i, 1), sign(i, 2), sign(i, 4))).to_array()).collect()
}

/// A pack with one box around the origin.
pub fn cube(half: f32) -> Vec<u8> {
    pack(&[("cube", corners(Vec3::ZERO, Vec3::splat(half)))])
}

/// A pack with an L of height 1, as two bars that overlap in its corner. The L has a volume of 4,
/// its bars have volumes of 2 and 3.
pub fn l() -> Vec<u8> {
    let set = |positions: Vec<[f32; 3]>, triangles| PointSet {
        name: "l".into(),
        source_vertices: (0..positions.len() as u32).collect(),
        positions,
        triangles,
        ..Default::default()
    };
    let bar =
        |high: Vec3| bake_hull(&set(corners(high / 2.0, high / 2.0), Vec::new()), IndexKind::Tree).expect("a box");
    let [mut first, mut second] = [bar(Vec3::new(2.0, 1.0, 1.0)), bar(Vec3::new(1.0, 3.0, 1.0))];
    let mesh = shapes::concave::l();
    let mass = mesh_mass(&set(mesh.vertices.clone(), mesh.fans()));
    assert!(mass.is_some_and(|mass| (mass.volume - 4.0).abs() < 1e-6));
    (first.part_count, first.mesh_mass) = (2, mass);
    (second.part_count, second.part) = (2, 1);
    write_pack(&[first, second], &SourceRecord::default()).expect("the hulls fit into a pack")
}

/// Corners of a prism of 256 sides, with its caps at z = ±1.
pub fn prism() -> Vec<[f32; 3]> {
    shapes::families::prism(512, 1)
}

/// Points of a rock of 512 vertices.
pub fn rock() -> Vec<[f32; 3]> {
    shapes::families::rock(512, 1)
}
