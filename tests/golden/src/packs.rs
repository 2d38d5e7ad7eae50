//! The packs whose bytes are hashed, and on which the queries run.

use hullmap::Pack;
use hullmap_bake::fit::mesh_mass;
use hullmap_bake::{BakedHull, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
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

/// The pack that records the mass of a mesh. An interpreter would take minutes for it.
const WITH_MASS: &str = "grid-tree";

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
        let mut baked = bake_hull(&points, index).unwrap_or_else(|error| panic!("{name}: {error}"));
        if name == WITH_MASS {
            baked.mesh_mass = mesh_mass(&nested(&baked));
            assert!(baked.mesh_mass.is_some());
        }
        let file = write_pack(&[baked], &SourceRecord::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        (name, file)
    };
    recipes.iter().map(bake).collect()
}

/// Two nested shells: the surface of a hull, and the same at half the size inside it.
fn nested(baked: &BakedHull) -> PointSet {
    let outer = &baked.hull.vertices;
    let positions: Vec<[f32; 3]> = outer.iter().copied().chain(outer.iter().map(|p| p.map(|c| c * 0.5))).collect();
    let count = outer.len() as u32;
    let mut triangles = Vec::new();
    for face in &baked.hull.faces {
        for pair in face[1..].windows(2) {
            triangles.extend([[face[0], pair[0], pair[1]], [face[0], pair[0], pair[1]].map(|corner| corner + count)]);
        }
    }
    let source_vertices = (0..positions.len() as u32).collect();
    PointSet { positions, source_vertices, triangles, ..PointSet::default() }
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
