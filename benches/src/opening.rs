//! Time to open a pack in the page cache: as a copy and as a map, with each degree of checking.

use std::{fs, hint::black_box, io, path::Path, time::Instant};

use hullmap::{OpenError, Pack};
use hullmap_bake::{BakeError, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::families::Family;

use crate::measure::Timing;

/// Number of different hulls baked for each family. Larger packs repeat them.
const DIFFERENT: usize = 4;

/// Contents of a pack.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Family of the hulls.
    pub family: Family,
    /// Points of each hull.
    pub points: usize,
    /// Number of hulls.
    pub hulls: usize,
}

/// Name of a function that opens a pack, and the function.
pub type Way = (&'static str, fn(&Path) -> Result<Pack, OpenError>);

/// All functions that open a pack: copies and maps, each from the most to the least checking.
#[allow(unsafe_code)]
pub const WAYS: [Way; 6] = [
    ("open", |path| Pack::open(path)),
    // SAFETY: `time` writes the file once, before it is mapped, in a folder that is its own.
    ("map", |path| unsafe { Pack::map(path) }),
    ("open_skipping_contents", |path| Pack::open_skipping_contents(path)),
    // SAFETY: `time` writes the file once, before it is mapped, in a folder that is its own.
    ("map_skipping_contents", |path| unsafe { Pack::map_skipping_contents(path) }),
    ("open_skipping_checks", |path| Pack::open_skipping_checks(path)),
    // SAFETY: `time` writes the file once, before it is mapped, in a folder that is its own.
    ("map_skipping_checks", |path| unsafe { Pack::map_skipping_checks(path) }),
];

impl Sample {
    /// The bytes of the pack. Fails if the points cannot be baked.
    pub fn bake(self) -> Result<Vec<u8>, BakeError> {
        let hulls = (0..self.hulls.min(DIFFERENT)).map(|seed| {
            let positions = self.family.points(self.points, seed as u64);
            let source_vertices = (0..positions.len() as u32).collect();
            let origin = [0.0; 3];
            let set = PointSet { name: "hull".to_owned(), positions, source_vertices, origin, ..PointSet::default() };
            bake_hull(&set, IndexKind::Tree)
        });
        let hulls: Vec<_> = hulls.collect::<Result<_, _>>()?;
        let all: Vec<_> = (0..self.hulls).map(|hull| hulls[hull % hulls.len()].clone()).collect();
        write_pack(&all, &SourceRecord::default())
    }
}

/// Times the functions in turn, `rounds` times after a warm-up; returns one timing each. Fails if
/// the file cannot be written or opened.
pub fn time(file: &[u8], folder: &Path, rounds: usize) -> io::Result<[Timing; WAYS.len()]> {
    let path = folder.join("timed.hullmap");
    fs::write(&path, file)?;
    let mut samples = WAYS.map(|_| Vec::with_capacity(rounds));
    for round in 0..=rounds {
        for ((_, open), samples) in WAYS.iter().zip(&mut samples) {
            let start = Instant::now();
            let pack = open(&path).map_err(io::Error::other)?;
            black_box(pack.hull_count());
            let nanoseconds = start.elapsed().as_secs_f64() * 1e9;
            // The first round brings the pages into memory.
            if round > 0 {
                samples.push(nanoseconds);
            }
        }
    }
    Ok(samples.map(Timing::new))
}
