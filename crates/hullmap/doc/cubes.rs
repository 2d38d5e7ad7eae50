// Included by the examples in the documentation of compounds.

/// A pack of two hulls: unit cubes, with their lowest corners at x = 0 and x = 3.
fn two_cubes() -> hullmap::Pack {
    let cube = |x: f32| {
        let corner = |i: u8| [x + f32::from(i & 1), f32::from(i >> 1 & 1), f32::from(i >> 2)];
        let set = hullmap_bake::PointSet {
            positions: (0..8).map(corner).collect(),
            source_vertices: (0..8).collect(),
            ..Default::default()
        };
        hullmap_bake::bake_hull(&set, hullmap_bake::IndexKind::Tree).unwrap()
    };
    let source = hullmap_bake::SourceRecord::default();
    let bytes = hullmap_bake::write_pack(&[cube(0.0), cube(3.0)], &source).unwrap();
    hullmap::Pack::from_bytes(&bytes).unwrap()
}
