//! A reader of `.hullmap` files that follows `docs/FORMAT.md` and knows no code of the project. Plain, not fast.
//!
//! Section numbers in comments are the document's. Damage makes it panic, which fails the test.

use std::ops::Range;

/// Sections in the order of the root's entries (4): name, bytes of an element, multiple on which it starts.
pub const SECTIONS: [(&str, usize, usize); 11] = [
    ("blocks", 128, 64),
    ("source_path", 1, 1),
    ("options", 1, 1),
    ("names", 1, 1),
    ("spans", 24, 4),
    ("hulls", 192, 8),
    ("vertices", 12, 4),
    ("source_vertices", 4, 4),
    ("face_starts", 4, 4),
    ("face_vertices", 4, 4),
    ("slots", 4, 4),
];

const HEADER: usize = 64;
const ROOT: usize = 88;

/// Numbers of sections in [`SECTIONS`].
pub mod section {
    pub const BLOCKS: usize = 0;
    pub const SOURCE_PATH: usize = 1;
    pub const OPTIONS: usize = 2;
    pub const NAMES: usize = 3;
    pub const SPANS: usize = 4;
    pub const HULLS: usize = 5;
    pub const VERTICES: usize = 6;
    pub const SOURCE_VERTICES: usize = 7;
    pub const FACE_STARTS: usize = 8;
    pub const FACE_VERTICES: usize = 9;
    pub const SLOTS: usize = 10;
}

/// A whole file.
pub struct File<'a> {
    bytes: &'a [u8],
    /// File offsets of each section's bytes.
    pub sections: [Range<usize>; 11],
}

/// One hull's runs.
pub struct Hull<'a> {
    pub name: &'a [u8],
    pub record: Record,
    pub vertices: Vec<[f32; 3]>,
    pub source_vertices: Vec<u32>,
    pub face_starts: Vec<u32>,
    pub face_vertices: Vec<u32>,
    pub slots: Vec<u32>,
    pub blocks: Vec<Block>,
}

/// 6.2.
pub struct Record {
    pub diameter: f64,
    pub centroid: [f64; 3],
    pub interior_point: [f64; 3],
    pub inner_radius: f64,
    pub outer_radius: f64,
    pub volume: f64,
    pub surface_area: f64,
    pub second_moments: [f64; 6],
    pub containment_error: f64,
    pub bounds_min: [f32; 3],
    pub bounds_max: [f32; 3],
    pub rank: u32,
    pub index_kind: u32,
    pub resolution: u32,
    pub max_nodes: u32,
    pub max_dots: u32,
    pub source_points: u32,
}

/// 6.3.
pub struct Block {
    pub position: [[f32; 8]; 3],
    pub vertex: [u32; 8],
}

/// Which blocks a direction leads to, and how many nodes were passed.
pub struct Leaf {
    pub blocks: Range<usize>,
    pub nodes: u32,
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array(bytes, at))
}

pub fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(array(bytes, at))
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(array(bytes, at))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(array(bytes, at))
}

impl<'a> File<'a> {
    /// 3 and 4: header, but for the hashes, and places of the sections.
    pub fn new(bytes: &'a [u8]) -> Self {
        assert_eq!(&bytes[..8], b"hullmap\n");
        assert_eq!(u32_at(bytes, 8), 1, "format version");
        assert_eq!(u32_at(bytes, 12), 64, "header length");
        assert_eq!(u64_at(bytes, 16), bytes.len() as u64 - 64, "payload length");
        assert_eq!(u64_at(bytes, 48), 0, "reserved");
        let root = bytes.len() - ROOT;
        let sections = std::array::from_fn(|number| {
            let entry = root + 8 * number;
            let offset = i32::from_le_bytes(array(bytes, entry));
            let start = entry.checked_add_signed(offset as isize).unwrap();
            start..start + u32_at(bytes, entry + 4) as usize * SECTIONS[number].1
        });
        Self { bytes, sections }
    }

    pub fn section(&self, number: usize) -> &'a [u8] {
        &self.bytes[self.sections[number].clone()]
    }

    pub fn count(&self, number: usize) -> usize {
        self.sections[number].len() / SECTIONS[number].1
    }

    /// Asserts that each section stands on the first multiple of its alignment behind the one before it, that the bytes
    /// skipped are zero, and the same of the root: then no byte is left open. Returns how many bytes were skipped.
    pub fn check_layout(&self) -> usize {
        let mut end = HEADER;
        let mut padding = 0;
        let root = self.bytes.len() - ROOT..self.bytes.len();
        let parts = self.sections.iter().zip(SECTIONS).map(|(range, (name, _, align))| (range, name, align));
        for (range, name, align) in parts.chain([(&root, "root", 4)]) {
            assert_eq!(range.start, HEADER + (end - HEADER).next_multiple_of(align), "start of {name}");
            assert!(self.bytes[end..range.start].iter().all(|b| *b == 0), "padding in front of {name}");
            assert!(range.start == end || matches!(name, "spans" | "hulls"), "no padding in front of {name}");
            padding += range.start - end;
            end = range.end;
        }
        padding
    }

    /// The six numbers of span `hull` (6.1).
    pub fn span(&self, hull: usize) -> [usize; 6] {
        std::array::from_fn(|i| u32_at(self.section(section::SPANS), 24 * hull + 4 * i) as usize)
    }

    fn run(&self, number: usize, start: usize, end: usize) -> &'a [u8] {
        let size = SECTIONS[number].1;
        &self.section(number)[start * size..end * size]
    }

    /// One hull, by its spans.
    pub fn hull(&self, hull: usize) -> Hull<'a> {
        let (start, end) = (self.span(hull), self.span(hull + 1));
        let run = |number: usize, field: usize| self.run(number, start[field], end[field]);
        Hull {
            name: run(section::NAMES, 0),
            record: Record::new(self.run(section::HULLS, hull, hull + 1)),
            vertices: run(section::VERTICES, 1).chunks(12).map(|v| floats(v, 0)).collect(),
            source_vertices: words(run(section::SOURCE_VERTICES, 1)),
            face_starts: words(run(section::FACE_STARTS, 2)),
            face_vertices: words(run(section::FACE_VERTICES, 3)),
            slots: words(run(section::SLOTS, 4)),
            blocks: run(section::BLOCKS, 5).chunks(128).map(Block::new).collect(),
        }
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    (0..bytes.len()).step_by(4).map(|at| u32_at(bytes, at)).collect()
}

fn floats<const N: usize>(bytes: &[u8], at: usize) -> [f32; N] {
    std::array::from_fn(|i| f32_at(bytes, at + 4 * i))
}

fn doubles<const N: usize>(bytes: &[u8], at: usize) -> [f64; N] {
    std::array::from_fn(|i| f64_at(bytes, at + 8 * i))
}

impl Record {
    fn new(bytes: &[u8]) -> Self {
        assert_eq!(bytes.len(), 192);
        Self {
            diameter: f64_at(bytes, 0),
            centroid: doubles(bytes, 8),
            interior_point: doubles(bytes, 32),
            inner_radius: f64_at(bytes, 56),
            outer_radius: f64_at(bytes, 64),
            volume: f64_at(bytes, 72),
            surface_area: f64_at(bytes, 80),
            second_moments: doubles(bytes, 88),
            containment_error: f64_at(bytes, 136),
            bounds_min: floats(bytes, 144),
            bounds_max: floats(bytes, 156),
            rank: u32_at(bytes, 168),
            index_kind: u32_at(bytes, 172),
            resolution: u32_at(bytes, 176),
            max_nodes: u32_at(bytes, 180),
            max_dots: u32_at(bytes, 184),
            source_points: u32_at(bytes, 188),
        }
    }
}

impl Block {
    fn new(bytes: &[u8]) -> Self {
        Self {
            position: std::array::from_fn(|i| floats(bytes, 32 * i)),
            vertex: std::array::from_fn(|lane| u32_at(bytes, 96 + 4 * lane)),
        }
    }
}

/// 7.1: face, and the grid numbers of u and v.
pub fn locate(d: [f64; 3]) -> (u32, [u32; 2]) {
    let [x, y, z] = d.map(f64::abs);
    let axis = if z > x && z > y {
        2
    } else if y > x {
        1
    } else {
        0
    };
    let grid = |t: f64| {
        let g = (t * 8_388_607.0).round_ties_even() + 8_388_608.0;
        if (0.0..16_777_216.0).contains(&g) { g as u32 } else { 0 }
    };
    let size = d[axis].abs();
    let face = 2 * axis as u32 + u32::from(d[axis].is_sign_negative());
    (face, [grid(d[(axis + 1) % 3] / size), grid(d[(axis + 2) % 3] / size)])
}

fn normal_at(slots: &[u32], at: usize) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (low, high) = (slots[at + 2 * i], slots[at + 2 * i + 1]);
        f64::from_bits(u64::from(low) | u64::from(high) << 32)
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Hull<'_> {
    /// 7.3.
    pub fn leaf(&self, d: [f64; 3]) -> Leaf {
        if self.record.index_kind == 0 {
            return Leaf { blocks: 0..self.blocks.len(), nodes: 0 };
        }
        let (face, bits) = locate(d);
        let root = if self.record.index_kind == 1 {
            let r = u64::from(self.record.resolution);
            let [column, row] = bits.map(|g| (u64::from(g) * r) >> 24);
            ((u64::from(face) * r + row) * r + column) as usize
        } else {
            face as usize
        };
        let (mut slot, mut nodes, mut axis_nodes) = (self.slots[root], 0, 0);
        loop {
            let at = (slot & 0x3fff_ffff) as usize;
            match slot >> 30 {
                0 => {
                    let bit = bits[axis_nodes % 2] >> (23 - axis_nodes / 2) & 1;
                    slot = self.slots[at + bit as usize];
                    axis_nodes += 1;
                }
                1 => return Leaf { blocks: at..at + 1, nodes },
                2 => {
                    let front = dot(normal_at(&self.slots, at), d) > 0.0;
                    slot = self.slots[at + if front { 7 } else { 6 }];
                }
                _ => {
                    let [first, count] = [self.slots[at] as usize, self.slots[at + 1] as usize];
                    return Leaf { blocks: first..first + count, nodes };
                }
            }
            nodes += 1;
        }
    }

    /// 7.4: number of the vertex.
    pub fn support(&self, d: [f64; 3]) -> u32 {
        let blocks = &self.blocks[self.leaf(d).blocks];
        let mut found = blocks[0].vertex[0];
        let mut greatest = f64::NEG_INFINITY;
        for block in blocks {
            for lane in 0..8 {
                let height = dot(block.position.map(|p| f64::from(p[lane])), d);
                if height > greatest {
                    (greatest, found) = (height, block.vertex[lane]);
                }
            }
        }
        found
    }

    pub fn faces(&self) -> Vec<&[u32]> {
        let ends = self.face_starts.iter().skip(1).copied().chain([self.face_vertices.len() as u32]);
        self.face_starts.iter().zip(ends).map(|(s, e)| &self.face_vertices[*s as usize..e as usize]).collect()
    }
}

/// What was met on a walk over a hull's index.
#[derive(Default)]
pub struct Walk {
    pub max_nodes: u32,
    pub max_dots: u32,
    /// Slots by their top two bits.
    pub tags: [usize; 4],
}

impl Hull<'_> {
    /// 7.2 and 8: visits every word of the index once, front to back, and asserts what is promised of it.
    pub fn walk_index(&self) -> Walk {
        let mut walk = Walk::default();
        let r = self.record.resolution as usize;
        let roots = match self.record.index_kind {
            0 => {
                walk.max_dots = self.blocks.len() as u32 * 8;
                self.check_leaf(0..self.blocks.len());
                0
            }
            1 => 6 * r * r,
            _ => 6,
        };
        // Places of slots to visit, the nodes and axis nodes above each, and whether a plane is among them.
        let mut queue: std::collections::VecDeque<(usize, u32, u32, bool)> =
            (0..roots).map(|i| (i, 0, 0, false)).collect();
        let mut free = roots;
        while let Some((place, nodes, axis_nodes, plane)) = queue.pop_front() {
            let at = (self.slots[place] & 0x3fff_ffff) as usize;
            let tag = (self.slots[place] >> 30) as usize;
            walk.tags[tag] += 1;
            if tag != 1 {
                assert_eq!(at, free, "what slots name stands in their order");
                free += [2, 0, 8, 2][tag];
                assert!(free <= self.slots.len());
            }
            let leaf = match tag {
                0 => {
                    assert!(self.record.index_kind == 2 && axis_nodes < 48 && !plane);
                    queue.extend([at, at + 1].map(|child| (child, nodes + 1, axis_nodes + 1, false)));
                    continue;
                }
                2 => {
                    assert_eq!(self.record.index_kind, 2, "roots of a cube map are leaves");
                    let normal = normal_at(&self.slots, at);
                    assert!((dot(normal, normal) - 1.0).abs() < 1e-15, "{normal:?}");
                    queue.extend([at + 6, at + 7].map(|child| (child, nodes + 1, axis_nodes, true)));
                    continue;
                }
                1 => at..at + 1,
                _ => self.slots[at] as usize..(self.slots[at] + self.slots[at + 1]) as usize,
            };
            self.check_leaf(leaf.clone());
            assert!(nodes <= 112);
            walk.max_nodes = walk.max_nodes.max(nodes);
            walk.max_dots = walk.max_dots.max(leaf.len() as u32 * 8);
        }
        assert_eq!(free, self.slots.len(), "no word without a use");
        walk
    }

    /// 6.3: vertex numbers ascend, unused lanes repeat the block's lane 0, and only the last block has any.
    fn check_leaf(&self, range: Range<usize>) {
        assert!(!range.is_empty());
        let last = range.end - 1;
        let mut before = None;
        for number in range {
            let block = &self.blocks[number];
            let first_unused = (1..8).find(|lane| block.vertex[*lane] <= block.vertex[*lane - 1]).unwrap_or(8);
            assert!(number == last || first_unused == 8, "a block that is not full in the middle of a leaf");
            for lane in 0..8 {
                let vertex = block.vertex[lane];
                let position = block.position.map(|p| p[lane].to_bits());
                assert_eq!(position, self.vertices[vertex as usize].map(f32::to_bits));
                if lane < first_unused {
                    assert!(before.is_none_or(|before| before < vertex));
                    before = Some(vertex);
                } else {
                    assert_eq!(vertex, block.vertex[0]);
                }
            }
        }
    }
}
