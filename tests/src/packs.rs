//! Packs made in process, without the command.

use std::hash::Hasher;

use hullmap::Pack;
use hullmap_bake::{BakeError, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use twox_hash::XxHash3_64;

/// Bytes of the header, of which the last eight are the checksum.
const HEADER_LEN: usize = 64;
const CHECKSUM_AT: usize = 56;

/// All kinds of index that a hull may have.
pub const ALL_INDICES: [IndexKind; 6] = [
    IndexKind::TREE,
    IndexKind::COMPACT,
    IndexKind::Binary,
    IndexKind::CubeMap { resolution: 1 },
    IndexKind::CubeMap { resolution: 24 },
    IndexKind::None,
];

/// A set of points, all of which count.
pub fn point_set(name: &str, positions: &[[f32; 3]]) -> PointSet {
    let source_vertices = (0..positions.len() as u32).collect();
    PointSet { name: name.to_owned(), positions: positions.to_vec(), source_vertices, ..PointSet::default() }
}

/// The bytes of a pack with a hull of each of `sets`.
///
/// # Errors
/// As the baker.
pub fn bytes(sets: &[PointSet], index: IndexKind, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    let baked = sets.iter().map(|set| bake_hull(set, index)).collect::<Result<Vec<_>, _>>()?;
    write_pack(&baked, source)
}

/// An opened pack with one hull.
///
/// # Panics
/// If the points cannot be baked, or the pack does not open.
pub fn pack(name: &str, positions: &[[f32; 3]], index: IndexKind) -> Pack {
    let bytes = bytes(&[point_set(name, positions)], index, &SourceRecord::default());
    let bytes = bytes.unwrap_or_else(|error| panic!("{name}: {error}"));
    Pack::from_bytes(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Makes the checksum of a changed file right again: XXH3-64 of every byte but its own eight. Files without room for a
/// header stay as they are.
pub fn reseal(file: &mut [u8]) {
    if file.len() >= HEADER_LEN {
        let mut hasher = XxHash3_64::with_seed(0);
        hasher.write(&file[..CHECKSUM_AT]);
        hasher.write(&file[HEADER_LEN..]);
        file[CHECKSUM_AT..HEADER_LEN].copy_from_slice(&hasher.finish().to_le_bytes());
    }
}
