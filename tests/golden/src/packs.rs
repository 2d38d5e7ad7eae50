//! The packs whose bytes are hashed, and on which the queries run.

use hullmap::Pack;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::families::Family;
use twox_hash::XxHash3_64;

/// Seed of all points.
const SEED: u64 = 17;

/// A pack of the set: name, family, points, index.
type Recipe = (&'static str, Family, usize, IndexKind);

/// The large set, which runs in a second: ranks, indices, fans.
const LARGE: [Recipe; 12] = [
    ("rock-tree", Family::Rock, 2_000, IndexKind::Tree),
    ("rock-compact", Family::Rock, 2_000, IndexKind::Compact),
    ("rock-binary", Family::Rock, 500, IndexKind::Binary),
    ("rock-cubemap", Family::Rock, 500, IndexKind::CubeMap { resolution: 16 }),
    ("rock-none", Family::Rock, 500, IndexKind::None),
    ("prism-tree", Family::RotatedPrism, 1_000, IndexKind::Tree),
    ("cone-tree", Family::Cone, 300, IndexKind::Tree),
    ("lens-tree", Family::Lens, 800, IndexKind::Tree),
    ("grid-tree", Family::CubeGrid, 27, IndexKind::Tree),
    ("needle-tree", Family::Needle, 60, IndexKind::Tree),
    ("sheet-tree", Family::FlatSheet, 40, IndexKind::Tree),
    ("sphere-tree", Family::Sphere, 700, IndexKind::Tree),
];

/// The small set, which an interpreter can bake: a scanned hull, a hull with a tree, a polygon.
const SMALL: [Recipe; 3] = [
    ("small-prism", Family::Prism, 10, IndexKind::Tree),
    ("small-rock", Family::Rock, 40, IndexKind::Tree),
    ("small-sheet", Family::FlatSheet, 12, IndexKind::CubeMap { resolution: 2 }),
];

/// Size of the set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// For an interpreter.
    Small,
    /// For a processor.
    Large,
}

/// The files of a set, by name.
pub fn files(set: Set) -> Vec<(&'static str, Vec<u8>)> {
    let recipes = match set {
        Set::Small => &SMALL[..],
        Set::Large => &LARGE[..],
    };
    let bake = |&(name, family, count, index): &Recipe| {
        let positions = family.points(count, SEED);
        let source_vertices = (0..positions.len() as u32).collect();
        let points = PointSet { name: name.to_owned(), positions, source_vertices, ..PointSet::default() };
        let baked = bake_hull(&points, index).unwrap_or_else(|error| panic!("{name}: {error}"));
        let file = write_pack(&[baked], &SourceRecord::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        (name, file)
    };
    recipes.iter().map(bake).collect()
}

/// The hashes of the files, with names as in the golden file.
pub fn hashes(files: &[(&'static str, Vec<u8>)]) -> Vec<(String, u64)> {
    files.iter().map(|(name, file)| (format!("pack {name}"), XxHash3_64::oneshot(file))).collect()
}

/// The files, opened.
pub fn opened(files: &[(&'static str, Vec<u8>)]) -> Vec<Pack> {
    let open =
        |(name, file): &(&str, Vec<u8>)| Pack::from_bytes(file).unwrap_or_else(|error| panic!("{name}: {error}"));
    files.iter().map(open).collect()
}
