//! Packs baked in process, without the command.

use std::hash::Hasher;

use glam::DVec3;
use hullmap::height_field::Layout;
use hullmap::{HeightField, Pack, TriangleMesh};
use hullmap_bake::{
    BakeError, IndexKind, PointSet, SourceRecord, bake_hull,
    height_field::{HeightGrid, bake_height_field, write_height_field},
    triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh},
    write_pack,
};
use twox_hash::XxHash3_64;

/// Length of the header in bytes; its last eight bytes are the checksum.
const HEADER_LEN: usize = 64;
const CHECKSUM_AT: usize = 56;

/// Length of the root that every pack has.
const ROOT_LEN: usize = 152;

/// Every index kind; the cube map at two resolutions.
pub const ALL_INDICES: [IndexKind; 6] = [
    IndexKind::Tree,
    IndexKind::Compact,
    IndexKind::Binary,
    IndexKind::CubeMap { resolution: 1 },
    IndexKind::CubeMap { resolution: 24 },
    IndexKind::None,
];

/// The corners of the unit cube, numbered by their signs.
pub fn cube() -> Vec<[f32; 3]> {
    (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect()
}

/// A point set in which every point is used.
pub fn point_set(name: &str, positions: &[[f32; 3]]) -> PointSet {
    let source_vertices = (0..positions.len() as u32).collect();
    PointSet { name: name.to_owned(), positions: positions.to_vec(), source_vertices, ..PointSet::default() }
}

/// The bytes of a pack with one hull for each of `sets`. Fails if the baker rejects a point set.
pub fn bytes(sets: &[PointSet], index: IndexKind, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    let baked = sets.iter().map(|set| bake_hull(set, index)).collect::<Result<Vec<_>, _>>()?;
    write_pack(&baked, source)
}

/// An opened pack of one hull. Panics if the points cannot be baked, or the pack does not open.
pub fn pack(name: &str, positions: &[[f32; 3]], index: IndexKind) -> Pack {
    let bytes = bytes(&[point_set(name, positions)], index, &SourceRecord::default());
    let bytes = bytes.unwrap_or_else(|error| panic!("{name}: {error}"));
    Pack::from_bytes(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// As [`pack`], with a tree as index. Panics as [`pack`] does.
pub fn tree_pack(positions: &[[f32; 3]]) -> Pack {
    pack("hull", positions, IndexKind::Tree)
}

/// The bytes of [`tree_pack`], for unit tests of `hullmap`: their `Pack` is another type than this
/// crate's. Panics if the points cannot be baked.
pub fn tree_bytes(positions: &[[f32; 3]]) -> Vec<u8> {
    let bytes = bytes(&[point_set("hull", positions)], IndexKind::Tree, &SourceRecord::default());
    bytes.unwrap_or_else(|error| panic!("{error}"))
}

/// An opened pack of several hulls. Panics if the points cannot be baked, or the pack does not
/// open.
pub fn parts(sets: &[PointSet]) -> Pack {
    let bytes = bytes(sets, IndexKind::Tree, &SourceRecord::default()).unwrap_or_else(|error| panic!("{error}"));
    Pack::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// The corners of a box.
pub fn corners(low: [f32; 3], high: [f32; 3]) -> Vec<[f32; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect()
}

/// A triangle mesh. The material of a triangle is its index here. Panics if it cannot be baked.
pub fn triangle_mesh(positions: &[[f32; 3]], corners: &[[u32; 3]]) -> TriangleMesh {
    let materials: Vec<u16> = (0..corners.len()).map(|index| index as u16).collect();
    let baked = bake_triangle_mesh(&Triangles { positions, corners, materials: &materials });
    let file = baked.and_then(|baked| write_triangle_mesh(baked, &SourceRecord::default()));
    TriangleMesh::from_bytes(&file.expect("a mesh can be baked")).expect("the file is valid")
}

/// A mesh of triangles that share no vertex. Panics if it cannot be baked.
pub fn loose_mesh(triangles: &[[DVec3; 3]]) -> TriangleMesh {
    let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|corner| corner.as_vec3().to_array()).collect();
    let corners: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    triangle_mesh(&positions, &corners)
}

/// A height field without materials. Panics if it cannot be baked.
pub fn height_field(layout: Layout, heights: &[f32], holes: &[bool]) -> HeightField {
    let baked = bake_height_field(&HeightGrid { layout, heights, holes, materials: &[] });
    let file = baked.and_then(|baked| write_height_field(baked, &SourceRecord::default()));
    HeightField::from_bytes(&file.expect("a field can be baked")).expect("the file is valid")
}

/// Further sections of extended packs.
#[derive(Clone, Copy, Debug)]
pub enum Further {
    /// Records of voids.
    Voids,
    /// Records of primitives.
    Primitives,
}

/// The file of an extended pack, with `bytes` at an offset in a record of a further section, and a
/// correct checksum. Panics if the record does not exist.
pub fn with_record(file: &[u8], section: Further, record: usize, offset: usize, bytes: &[u8]) -> Vec<u8> {
    let (entry, size) = match section {
        Further::Voids => (file.len() - ROOT_LEN - 16, 12),
        Further::Primitives => (file.len() - ROOT_LEN - 8, 96),
    };
    let word = |at: usize| i32::from_le_bytes(std::array::from_fn(|i| file[at + i]));
    assert!(record < word(entry + 4) as usize, "the pack has no such record");
    let at = entry.strict_add_signed(word(entry) as isize) + record * size + offset;
    let mut changed = file.to_vec();
    changed[at..at + bytes.len()].copy_from_slice(bytes);
    reseal(&mut changed);
    changed
}

/// Writes the correct checksum into a changed file: XXH3-64 of all bytes except its own eight.
/// Files shorter than a header are left unchanged.
pub fn reseal(file: &mut [u8]) {
    if file.len() >= HEADER_LEN {
        let mut hasher = XxHash3_64::with_seed(0);
        hasher.write(&file[..CHECKSUM_AT]);
        hasher.write(&file[HEADER_LEN..]);
        file[CHECKSUM_AT..HEADER_LEN].copy_from_slice(&hasher.finish().to_le_bytes());
    }
}
