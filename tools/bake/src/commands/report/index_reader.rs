//! A hull's direction index as numbers, and the leaf of a direction: what the runtime does, written slowly and plainly.
//!
//! The runtime keeps the index to itself; this reads the same words from the file's bytes, after the file has passed all
//! of the runtime's checks. Directions are located as `docs/FORMAT.md` says.

use std::path::Path;

use hullmap::{Hull, Pack};
use hullmap_format::{
    archive::{LANES, index_kind},
    check,
    cube::{self, GRID_BITS},
    fan,
    header::HEADER_LEN,
    slot::{BUNDLE_PLANES, Branch, Slot, decode_f64},
    walk::MAX_NODES,
};
use rkyv::util::AlignedVec;

use super::sizes::{Section, sections};
use crate::outcome::Failure;

/// What the report reads from a pack's bytes beside what the runtime tells.
#[derive(Debug)]
pub struct Contents {
    /// The direction index of each hull.
    pub indices: Vec<IndexReader>,
    /// The sections, in the file's order.
    pub sections: Vec<Section>,
}

impl Contents {
    /// Reads a pack that has been opened before, and so has passed all checks.
    ///
    /// # Errors
    /// The file cannot be read, or is no longer what it was.
    pub fn read(path: &Path, pack: &Pack) -> Result<Self, Failure> {
        let failure = |error: String| Failure::usage(format!("{}: cannot read: {error}", path.display()));
        let mut bytes = AlignedVec::<HEADER_LEN>::new();
        let mut file = std::fs::File::open(path).map_err(|error| failure(error.to_string()))?;
        bytes.extend_from_reader(&mut file).map_err(|error| failure(error.to_string()))?;
        let payload = bytes.get(HEADER_LEN..).unwrap_or_default();
        let archive = check::structure(payload).map_err(|error| failure(error.to_string()))?;
        let index = |(hull, ends): (usize, Vec<End>)| {
            let (start, end) = (&archive.spans[hull], &archive.spans[hull + 1]);
            let words = start.slot.to_native() as usize..end.slot.to_native() as usize;
            let blocks = start.block.to_native() as usize..end.block.to_native() as usize;
            let record = &archive.hulls[hull];
            IndexReader {
                kind: match record.index_kind.to_native() {
                    index_kind::CUBE_MAP => Kind::CubeMap { resolution: record.resolution.to_native() },
                    index_kind::BINARY => Kind::Binary,
                    index_kind::TREE => Kind::Tree,
                    _ => Kind::Scan,
                },
                leaf_blocks: record.leaf_blocks.to_native(),
                words: archive.slots[words].iter().map(|word| word.to_native()).collect(),
                blocks: archive.blocks[blocks].iter().map(|block| block.vertex.map(|v| v.to_native())).collect(),
                ends,
            }
        };
        if archive.hulls.len() != pack.hull_count() {
            return Err(failure("it has changed since it was opened".to_owned()));
        }
        let indices = pack.hulls().map(|hull| ends(&hull)).enumerate().map(index).collect();
        Ok(Self { indices, sections: sections(archive, bytes.len()) })
    }
}

/// A direction index.
#[derive(Clone, Debug)]
pub struct IndexReader {
    /// How it is read.
    pub kind: Kind,
    /// Blocks of a plain leaf.
    pub leaf_blocks: u32,
    /// Its words.
    pub words: Vec<u32>,
    /// The vertex in each lane of each block.
    pub blocks: Vec<[u32; LANES]>,
    /// What unused lanes may hold.
    ends: Vec<End>,
}

/// A vertex at the end of an axis.
#[derive(Clone, Debug)]
struct End {
    vertex: u32,
    /// The vertices that share an edge with it, ascending.
    neighbours: Vec<u32>,
}

/// The kinds of index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// None: all blocks are scanned.
    Scan,
    /// A uniform cube map.
    CubeMap {
        /// Cells along a face's edge.
        resolution: u32,
    },
    /// The paper's binary tree.
    Binary,
    /// The level-compressed tree.
    Tree,
}

/// Where a direction leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Leaf {
    /// First of its blocks.
    pub first: u32,
    /// How many blocks it has.
    pub count: u32,
    /// Nodes read on the way.
    pub nodes: u32,
}

impl Leaf {
    /// Dot products that a query takes in it.
    pub fn dots(self) -> u32 {
        self.count * LANES as u32
    }
}

impl IndexReader {
    /// The leaf of a direction, whose largest coordinate is about 1.
    pub fn leaf(&self, dir: [f32; 3]) -> Leaf {
        let cell = cube::locate(dir);
        let (mut nodes, mut bits_left) = (0, [GRID_BITS; 2]);
        let mut slot = match self.kind {
            Kind::Scan => return Leaf { first: 0, count: self.blocks.len() as u32, nodes: 0 },
            Kind::CubeMap { resolution } => Slot::decode(self.word(cube::uniform_cell(cell, resolution) as usize)),
            Kind::Binary | Kind::Tree => Slot::decode(self.word(cell.face as usize)),
        };
        while nodes < MAX_NODES {
            let word = match slot {
                Slot::Branch(at) if self.kind == Kind::Binary => {
                    let axis = nodes as usize % 2;
                    bits_left[axis] -= 1;
                    self.word(at as usize + ([cell.u, cell.v][axis] >> bits_left[axis] & 1) as usize)
                }
                Slot::Branch(payload) => {
                    let Branch { at, bits } = Branch::decode(payload);
                    bits_left = bits_left.map(|left| left - bits);
                    let step = |grid: u32| (grid >> bits_left[0]) & ((1 << bits) - 1);
                    self.word((at + (step(cell.v) << bits) + step(cell.u)) as usize)
                }
                Slot::Plane(at) => {
                    let at = at as usize;
                    self.word(at + 6 + usize::from(is_in_front(self.vector(at, 1), dir)))
                }
                Slot::Bundle(at) => {
                    let at = at as usize;
                    // The first plane, then the second or third, then one of the last four.
                    let mut plane = 0;
                    for _ in 0..3 {
                        plane = 2 * plane + 1 + usize::from(is_in_front(self.bundle_normal(at, plane), dir));
                    }
                    self.word(at + 6 * BUNDLE_PLANES + plane - BUNDLE_PLANES)
                }
                Slot::Fan(at) => {
                    let at = at as usize;
                    let number = |i: usize| self.number(at + 2 * i);
                    let step = fan::slot(number, self.word(at + fan::HEAD_WORDS as usize - 1), dir.map(f64::from));
                    self.word(at + fan::HEAD_WORDS as usize + step as usize)
                }
                Slot::Block(_) | Slot::List(_) => break,
            };
            slot = Slot::decode(word);
            nodes += 1;
        }
        let (first, count) = match slot {
            Slot::Block(first) => (first, self.leaf_blocks),
            Slot::List(at) => (self.word(at as usize), self.word(at as usize + 1)),
            _ => (0, self.blocks.len() as u32),
        };
        Leaf { first, count, nodes }
    }

    /// The vertices that a leaf lists, ascending: its lanes without those that only fill it up.
    ///
    /// What fills stands last, and is the end of an axis on the hull's far side. Where it stands there once, it could be a
    /// candidate: it counts as one where it shares an edge with another, as the cones of a cell's candidates do.
    pub fn candidates(&self, leaf: Leaf) -> Vec<u32> {
        let run = leaf.first as usize..(leaf.first + leaf.count) as usize;
        let mut lanes = self.blocks.get(run).unwrap_or_default().as_flattened().to_vec();
        let Some(&last) = lanes.last() else { return lanes };
        let filled = lanes.iter().rev().take_while(|&&lane| lane == last).count();
        lanes.truncate(lanes.len() - filled);
        let end = self.ends.iter().find(|end| end.vertex == last);
        let fills = match end {
            // Candidates ascend, and the last one fills only where all ends are candidates themselves.
            _ if lanes.last().is_some_and(|&before| before > last) => true,
            Some(_) if filled > 1 => self.ends.iter().any(|end| end.vertex != last && !lanes.contains(&end.vertex)),
            Some(end) => !lanes.iter().any(|lane| end.neighbours.binary_search(lane).is_ok()),
            None => false,
        };
        if lanes.is_empty() || !fills {
            lanes.push(last);
        }
        lanes
    }

    /// A word; 0 past the last, which does not happen in a pack that has been checked.
    pub fn word(&self, at: usize) -> u32 {
        self.words.get(at).copied().unwrap_or(0)
    }

    /// The number in the two words at `at`.
    pub fn number(&self, at: usize) -> f64 {
        decode_f64(self.word(at), self.word(at + 1))
    }

    /// Three numbers, `stride` numbers from one to the next.
    pub fn vector(&self, at: usize, stride: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.number(at + 2 * stride * axis))
    }

    /// Normal of plane number `plane` of the bundle at `at`.
    pub fn bundle_normal(&self, at: usize, plane: usize) -> [f64; 3] {
        self.vector(at + 2 * plane, BUNDLE_PLANES)
    }
}

fn is_in_front(normal: [f64; 3], dir: [f32; 3]) -> bool {
    let dir = dir.map(f64::from);
    normal[0] * dir[0] + normal[1] * dir[1] + normal[2] * dir[2] > 0.0
}

/// The vertices with the least and greatest coordinates.
fn ends(hull: &Hull) -> Vec<End> {
    let coordinates = |axis: usize| hull.vertices().map(move |vertex| vertex[axis]).enumerate();
    let mut ends = Vec::new();
    for axis in 0..3 {
        ends.extend(coordinates(axis).min_by(|a, b| a.1.total_cmp(&b.1)));
        ends.extend(coordinates(axis).max_by(|a, b| a.1.total_cmp(&b.1)));
    }
    let mut ends: Vec<u32> = ends.into_iter().map(|(vertex, _)| vertex as u32).collect();
    ends.sort_unstable();
    ends.dedup();
    ends.into_iter().map(|vertex| End { vertex, neighbours: hull.neighbours(vertex).collect() }).collect()
}

#[cfg(test)]
pub mod tests {
    use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};

    use super::*;
    use crate::verification::random::SplitMix;

    /// A cloud in a shape that makes an index use planes, fans and lists: a ball above a disc of many corners.
    pub fn cloud(count: usize) -> Vec<[f32; 3]> {
        let mut random = SplitMix::new(9);
        let ball = (0..count / 2).map(|_| (random.in_ball_f64().normalize() + glam::DVec3::Z).as_vec3().to_array());
        let mut points: Vec<[f32; 3]> = ball.collect();
        points.extend((0..count / 2).map(|step| {
            let angle = std::f64::consts::TAU * step as f64 / (count / 2) as f64;
            [2.0 * angle.cos() as f32, 2.0 * angle.sin() as f32, 0.0]
        }));
        points
    }

    /// A pack of the cloud, on disk, and what is read from it.
    pub fn baked(positions: Vec<[f32; 3]>, kind: IndexKind) -> (Pack, Contents) {
        let source_vertices = (0..positions.len() as u32).collect();
        let set = PointSet { name: "cloud".to_owned(), positions, source_vertices, ..PointSet::default() };
        let bytes = write_pack(&[bake_hull(&set, kind).unwrap()], &SourceRecord::default()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cloud.hullmap");
        std::fs::write(&path, &bytes).unwrap();
        let pack = Pack::from_bytes(&bytes).unwrap();
        let contents = Contents::read(&path, &pack).unwrap();
        (pack, contents)
    }

    pub const KINDS: [IndexKind; 5] =
        [IndexKind::TREE, IndexKind::COMPACT, IndexKind::Binary, IndexKind::CubeMap { resolution: 9 }, IndexKind::None];

    #[test]
    fn leaves_are_those_of_the_runtime_and_list_its_answer() {
        for kind in KINDS {
            let (pack, contents) = baked(cloud(600), kind);
            let (hull, index) = (pack.hull(0).unwrap(), &contents.indices[0]);
            let mut random = SplitMix::new(2);
            let mut deepest = 0;
            for _ in 0..20_000 {
                let dir = random.in_ball();
                let leaf = index.leaf(dir.to_array());
                let cost = hull.support_cost(dir);
                assert_eq!((leaf.nodes, leaf.dots()), (cost.nodes, cost.dots), "{kind:?} {dir}");
                let candidates = index.candidates(leaf);
                assert!(candidates.is_sorted() && candidates.contains(&hull.support(dir).index), "{kind:?} {dir}");
                deepest = deepest.max(leaf.nodes);
            }
            let is_flat = matches!(kind, IndexKind::CubeMap { .. } | IndexKind::None);
            assert_eq!(deepest == 0, is_flat, "{kind:?}");
        }
    }

    #[test]
    fn fill_is_no_candidate() {
        let index = |lanes: [u32; LANES]| IndexReader {
            kind: Kind::Scan,
            leaf_blocks: 1,
            words: Vec::new(),
            blocks: vec![lanes],
            ends: vec![End { vertex: 1, neighbours: vec![2] }, End { vertex: 9, neighbours: vec![8] }],
        };
        let leaf = Leaf { first: 0, count: 1, nodes: 0 };
        let candidates = |lanes| index(lanes).candidates(leaf);
        assert_eq!(candidates([2, 3, 9, 9, 9, 9, 9, 9]), [2, 3]);
        assert_eq!(candidates([2, 3, 4, 5, 6, 7, 8, 1]), [2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(candidates([0, 1, 9, 9, 9, 9, 9, 9]), [0, 1, 9], "all ends are candidates");
        assert_eq!(candidates([5; LANES]), [5]);
        assert_eq!(candidates([1, 2, 3, 4, 5, 6, 7, 8]), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(candidates([0, 2, 3, 4, 5, 6, 7, 9]), [0, 2, 3, 4, 5, 6, 7], "far from all others");
        assert_eq!(candidates([0, 2, 3, 4, 5, 6, 8, 9]), [0, 2, 3, 4, 5, 6, 8, 9], "beside 8");
    }
}
