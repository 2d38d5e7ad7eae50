//! Methods of answering support queries: our index kinds, and parry3d.

pub mod indexed;
pub mod parry;

use hullmap_bake::IndexKind;

use crate::{
    query::{Contestant, Entry},
    subject::Subject,
};
use indexed::{Hinted, Indexed};
use parry::Parry;

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
    let mut entries: Vec<Box<dyn Contestant>> = Vec::new();
    if let Some(parry) = Parry::new(subject) {
        entries.push(Box::new(Entry::new(parry)));
    }
    for (name, kind) in INDICES {
        let (rival, build_time) = Indexed::new(name, subject, kind);
        entries.push(Box::new(Entry::built_in(rival, build_time)));
    }
    entries.push(Box::new(Entry::new(Hinted(Indexed::new(HINTED, subject, IndexKind::Tree).0))));
    entries
}
