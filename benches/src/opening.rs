//! How long a pack takes to open, each of the three ways, on warm memory.

use std::{fs, hint::black_box, io, path::Path, time::Instant};

use hullmap::{OpenError, Pack};
use hullmap_bake::{BakeError, IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::families::Family;

use crate::measure::Timing;

/// Hulls baked of each family; a pack of more repeats them.
const DIFFERENT: usize = 4;

/// What a pack is of.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Family of its hulls' points.
    pub family: Family,
    /// Points of a hull.
    pub points: usize,
    /// Hulls.
    pub hulls: usize,
}

/// A way to open a pack.
pub type Way = (&'static str, fn(&Path) -> Result<Pack, OpenError>);

/// The three ways, from the most careful on.
pub const WAYS: [Way; 3] = [
    ("open", |path| Pack::open(path)),
    ("open_skipping_contents", |path| Pack::open_skipping_contents(path)),
    ("open_skipping_checks", |path| Pack::open_skipping_checks(path)),
];

impl Sample {
    /// The file.
    ///
    /// # Errors
    /// The points cannot be baked.
    pub fn bake(self) -> Result<Vec<u8>, BakeError> {
        let hulls = (0..self.hulls.min(DIFFERENT)).map(|seed| {
            let positions = self.family.points(self.points, seed as u64);
            let source_vertices = (0..positions.len() as u32).collect();
            let origin = [0.0; 3];
            let set = PointSet { name: "hull".to_owned(), positions, source_vertices, origin, triangles: Vec::new() };
            bake_hull(&set, IndexKind::TREE)
        });
        let hulls: Vec<_> = hulls.collect::<Result<_, _>>()?;
        let all: Vec<_> = (0..self.hulls).map(|hull| hulls[hull % hulls.len()].clone()).collect();
        write_pack(&all, &SourceRecord::default())
    }
}

/// Times the three ways in turn, `rounds` times after a first; one timing each.
///
/// # Errors
/// The file cannot be written or opened.
pub fn time(file: &[u8], folder: &Path, rounds: usize) -> io::Result<[Timing; 3]> {
    let path = folder.join("timed.hullmap");
    fs::write(&path, file)?;
    let mut samples = WAYS.map(|_| Vec::with_capacity(rounds));
    for round in 0..=rounds {
        for ((_, open), samples) in WAYS.iter().zip(&mut samples) {
            let start = Instant::now();
            let pack = open(&path).map_err(io::Error::other)?;
            black_box(pack.hull_count());
            let nanoseconds = start.elapsed().as_secs_f64() * 1e9;
            // The first is for the pages to be there.
            if round > 0 {
                samples.push(nanoseconds);
            }
        }
    }
    Ok(samples.map(Timing::new))
}
