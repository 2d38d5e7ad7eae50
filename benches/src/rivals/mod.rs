//! Methods of answering support queries: ours and other engines'.

pub mod cube_map;
pub mod hill_climb;
pub mod indexed;
pub mod parry;
pub mod scalar_scan;
pub mod simd_scan;

use hullmap_bake::IndexKind;

use crate::{
    query::{Contestant, Entry},
    subject::Subject,
};
use cube_map::{CubeMap, CubeMapClimb};
use hill_climb::{Graph, HillClimb, LastAnswer, ManyStarts, OneStart};
use indexed::{Hinted, Indexed};
use parry::Parry;
use scalar_scan::ScalarScan;
use simd_scan::{Avx2, Avx512, Portable, SimdScan};

/// Resolution of the cube maps: texels along the edge of a face.
pub const CUBE_MAP_RESOLUTION: u32 = 64;

/// Our index kinds, with their names in tables. A new one is one line.
pub const INDICES: [(&str, IndexKind); 5] = [
    ("hullmap none", IndexKind::None),
    ("hullmap binary", IndexKind::Binary),
    ("hullmap compact", IndexKind::Compact),
    ("hullmap cubemap 64", IndexKind::CubeMap { resolution: CUBE_MAP_RESOLUTION }),
    ("hullmap tree", IndexKind::Tree),
];

/// The index whose ratios to other rivals are listed.
pub const DEFAULT_INDEX: &str = "hullmap tree";

/// [`DEFAULT_INDEX`] with the last answer as a hint.
pub const HINTED: &str = "hullmap tree, hinted";

/// Whether the rival with this name is one of ours.
pub fn is_ours(name: &str) -> bool {
    name == HINTED || INDICES.iter().any(|(ours, _)| *ours == name)
}

/// All rivals that can answer for `subject` on this machine.
pub fn enter(subject: &Subject) -> Vec<Box<dyn Contestant>> {
    let graph = Graph::new(subject);
    let cube_map = CubeMap::new(subject, CUBE_MAP_RESOLUTION);
    let mut entries: Vec<Box<dyn Contestant>> = vec![Box::new(Entry::new(ScalarScan::new(subject)))];
    if let Some(parry) = Parry::new(subject) {
        entries.push(Box::new(Entry::new(parry)));
    }
    if let Some(scan) = SimdScan::<Portable>::new(subject) {
        entries.push(Box::new(Entry::new(scan)));
    }
    if let Some(scan) = SimdScan::<Avx2>::new(subject) {
        entries.push(Box::new(Entry::new(scan)));
    }
    if let Some(scan) = SimdScan::<Avx512>::new(subject) {
        entries.push(Box::new(Entry::new(scan)));
    }
    entries.push(Box::new(Entry::new(HillClimb::<OneStart>::new(graph.clone()))));
    entries.push(Box::new(Entry::new(HillClimb::<ManyStarts>::new(graph.clone()))));
    entries.push(Box::new(Entry::new(HillClimb::<LastAnswer>::new(graph.clone()))));
    if let Some(cube_map) = cube_map {
        entries.push(Box::new(Entry::new(CubeMapClimb::new(cube_map.clone(), graph))));
        entries.push(Box::new(Entry::new(cube_map)));
    }
    for (name, kind) in INDICES {
        let (rival, build_time) = Indexed::new(name, subject, kind);
        entries.push(Box::new(Entry::built_in(rival, build_time)));
    }
    entries.push(Box::new(Entry::new(Hinted(Indexed::new(HINTED, subject, IndexKind::Tree).0))));
    entries
}
