// Included by the examples in the documentation: a pack to try things on.

/// A pack file of two hulls: "rock", of 40 points, and "cube", of edge length 2 around the origin.
#[allow(dead_code)]
fn rock_and_cube() -> Vec<u8> {
    let set = |name: &str, positions: Vec<[f32; 3]>| hullmap_bake::PointSet {
        name: name.into(),
        source_vertices: (0..positions.len() as u32).collect(),
        positions,
        ..Default::default()
    };
    let corner = |i: u32| [1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 });
    let sets = [set("rock", shapes::families::rock(40, 1)), set("cube", (0..8).map(corner).collect())];
    let hulls = sets.map(|set| hullmap_bake::bake_hull(&set, hullmap_bake::IndexKind::Tree).unwrap());
    let source = hullmap_bake::SourceRecord::default();
    hullmap_bake::write_pack(&hulls, &source).unwrap()
}

/// The same pack, opened.
#[allow(dead_code)]
fn pack() -> hullmap::Pack {
    hullmap::Pack::from_bytes(&rock_and_cube()).unwrap()
}
