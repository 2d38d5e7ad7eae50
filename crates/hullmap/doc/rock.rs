// Included by the examples in the documentation: packs to try things on.

/// The bytes of a pack with one hull for each of these sets of points.
fn bake(sets: &[(&str, Vec<[f32; 3]>)]) -> Vec<u8> {
    let bake = |(name, positions): &(&str, Vec<[f32; 3]>)| {
        let set = hullmap_bake::PointSet {
            name: (*name).into(),
            source_vertices: (0..positions.len() as u32).collect(),
            positions: positions.clone(),
            ..Default::default()
        };
        hullmap_bake::bake_hull(&set, hullmap_bake::IndexKind::Tree).unwrap()
    };
    let hulls: Vec<_> = sets.iter().map(bake).collect();
    hullmap_bake::write_pack(&hulls, &hullmap_bake::SourceRecord::default()).unwrap()
}

/// The corners of a cube of edge length 2 around a point on the x axis.
fn cube(x: f32) -> Vec<[f32; 3]> {
    let sign = |i: u8, bit: u8| if i & bit == 0 { -1.0 } else { 1.0 };
    (0..8).map(|i| [x + sign(i, 1), sign(i, 2), sign(i, 4)]).collect()
}

/// A pack file of two hulls: "rock", of 40 points, and "cube", of edge length 2 around the origin.
#[allow(dead_code)]
fn rock_and_cube() -> Vec<u8> {
    bake(&[("rock", shapes::families::rock(40, 1)), ("cube", cube(0.0))])
}

/// The same pack, opened.
#[allow(dead_code)]
fn pack() -> hullmap::Pack {
    hullmap::Pack::from_bytes(&rock_and_cube()).unwrap()
}

/// Enters a folder with packs as `bake build` makes them of `assets`.
#[allow(dead_code)]
fn folder_of_packs() -> std::io::Result<tempfile::TempDir> {
    let folder = tempfile::tempdir()?;
    std::env::set_current_dir(&folder)?;
    let octahedron = [[3, 0, 0], [1, 0, 0], [2, 1, 0], [2, -1, 0], [2, 0, 1], [2, 0, -1]];
    let octahedron = octahedron.map(|p: [i8; 3]| p.map(f32::from)).to_vec();
    for (file, hulls) in [
        ("baked/rock.hullmap", &[("rock", shapes::families::rock(40, 1))][..]),
        ("baked/cube.hullmap", &[("cube", cube(0.0))]),
        ("parts/two_objects.hullmap", &[("left_cube", cube(-2.0)), ("right_octahedron", octahedron)]),
    ] {
        std::fs::create_dir_all(std::path::Path::new(file).parent().unwrap())?;
        std::fs::write(file, bake(hulls))?;
    }
    Ok(folder)
}
