// Included by the examples in the documentation of seams.

/// A pack of two hulls: unit cubes below z = 0, at x from −1 to 0 and from 0 to 1.
fn two_tiles() -> hullmap::Pack {
    let cube = |x: f32| {
        let corner = |i: u8| [x + f32::from(i & 1), f32::from(i >> 1 & 1) - 0.5, f32::from(i >> 2) - 1.0];
        let set = hullmap_bake::PointSet {
            positions: (0..8).map(corner).collect(),
            source_vertices: (0..8).collect(),
            ..Default::default()
        };
        hullmap_bake::bake_hull(&set, hullmap_bake::IndexKind::Tree).unwrap()
    };
    let source = hullmap_bake::SourceRecord::default();
    let bytes = hullmap_bake::write_pack(&[cube(-1.0), cube(0.0)], &source).unwrap();
    hullmap::Pack::from_bytes(&bytes).unwrap()
}
