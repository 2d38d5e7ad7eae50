//! Packs for the tests of this crate.

use hullmap::Pack;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::rng::SplitMix64;

use crate::index_reader::Contents;

/// Every kind of index.
pub const KINDS: [IndexKind; 5] =
    [IndexKind::Tree, IndexKind::Compact, IndexKind::Binary, IndexKind::CubeMap { resolution: 9 }, IndexKind::None];

/// A sphere above a disc with many corners: its index has branches, planes, fans and lists.
pub fn cloud(count: usize) -> Vec<[f32; 3]> {
    let mut random = SplitMix64::new(9);
    let sphere = (0..count / 2).map(|_| random.direction()).map(|[x, y, z]| [x, y, z + 1.0].map(|c| c as f32));
    let mut points: Vec<[f32; 3]> = sphere.collect();
    points.extend((0..count / 2).map(|step| {
        let angle = std::f64::consts::TAU * step as f64 / (count / 2) as f64;
        [2.0 * angle.cos() as f32, 2.0 * angle.sin() as f32, 0.0]
    }));
    points
}

pub fn baked(positions: Vec<[f32; 3]>, kind: IndexKind) -> (Pack, Contents) {
    let set = PointSet { name: "cloud".to_owned(), ..PointSet::of_positions(positions) };
    let bytes = write_pack(&[bake_hull(&set, kind).unwrap()], &SourceRecord::default()).unwrap();
    let pack = Pack::from_bytes(&bytes).unwrap();
    let contents = Contents::of_pack(&pack).unwrap();
    (pack, contents)
}
