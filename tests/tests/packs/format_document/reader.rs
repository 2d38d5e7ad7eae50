//! A reader of `.hullmap` files, written from `docs/contributors/FORMAT.md` without code of the
//! project. It is simple, not fast.
//!
//! Numbers in comments are sections of the document. The reader panics on damaged files, which
//! fails the test.

use std::ops::Range;

/// Sections in the order of the root's entries (4): name, bytes per element, alignment.
pub const SECTIONS: [(&str, usize, usize); 19] = [
    ("blocks", 128, 64),
    ("source_path", 1, 1),
    ("options", 1, 1),
    ("names", 1, 1),
    ("spans", 44, 4),
    ("hulls", 288, 8),
    ("masses", 80, 8),
    ("nodes", 32, 4),
    ("vertices", 12, 4),
    ("source_vertices", 4, 4),
    ("face_starts", 4, 4),
    ("face_vertices", 4, 4),
    ("quads", 24, 4),
    ("neighbour_starts", 4, 4),
    ("neighbours", 4, 4),
    ("neighbour_faces", 4, 4),
    ("outer_vertices", 12, 4),
    ("slots", 4, 4),
    ("edges", 2, 2),
];

const HEADER: usize = 64;
pub const ROOT: usize = 152;

/// Further sections, as in [`SECTIONS`] (15). Their entries are in front of the root.
const FURTHER: [(&str, usize, usize); 2] = [("voids", 12, 4), ("primitives", 96, 8)];

/// Indices of the sections in [`SECTIONS`].
pub mod section {
    pub const BLOCKS: usize = 0;
    pub const SOURCE_PATH: usize = 1;
    pub const OPTIONS: usize = 2;
    pub const NAMES: usize = 3;
    pub const SPANS: usize = 4;
    pub const HULLS: usize = 5;
    pub const MASSES: usize = 6;
    pub const NODES: usize = 7;
    pub const VERTICES: usize = 8;
    pub const SOURCE_VERTICES: usize = 9;
    pub const FACE_STARTS: usize = 10;
    pub const FACE_VERTICES: usize = 11;
    pub const QUADS: usize = 12;
    pub const NEIGHBOUR_STARTS: usize = 13;
    pub const NEIGHBOURS: usize = 14;
    pub const NEIGHBOUR_FACES: usize = 15;
    pub const OUTER_VERTICES: usize = 16;
    pub const SLOTS: usize = 17;
    pub const EDGES: usize = 18;
}

/// A whole file.
pub struct File<'a> {
    bytes: &'a [u8],
    /// File offsets of each section's bytes.
    pub sections: [Range<usize>; 19],
    /// File offsets of the bytes of further sections; none in version 7.
    pub further: Vec<Range<usize>>,
}

/// 15.
#[derive(Debug, PartialEq)]
pub struct Voids {
    pub hull: u32,
    pub share: f32,
    pub error: f32,
}

/// The runs of one hull.
pub struct Hull<'a> {
    pub name: &'a [u8],
    pub record: Record,
    pub vertices: Vec<[f32; 3]>,
    pub source_vertices: Vec<u32>,
    pub face_starts: Vec<u32>,
    pub face_vertices: Vec<u32>,
    pub quads: Vec<Quad>,
    pub neighbour_starts: Vec<u32>,
    pub neighbours: Vec<u32>,
    pub neighbour_faces: Vec<u32>,
    pub outer_vertices: Vec<[f32; 3]>,
    pub slots: Vec<u32>,
    pub edges: Vec<i16>,
    pub blocks: Vec<Block>,
    pub masses: Vec<Mass>,
}

/// 15.
#[derive(Debug, PartialEq)]
pub struct Primitive {
    pub hull: u32,
    pub kind: u32,
    pub center: [f64; 3],
    pub rotation: [f64; 4],
    pub sizes: [f64; 3],
    pub protrusion: f64,
}

/// 6.6.
#[derive(Debug, PartialEq)]
pub struct Mass {
    pub volume: f64,
    pub centroid: [f64; 3],
    pub second_moments: [f64; 6],
}

/// 6.5.
pub struct Quad {
    pub face: u32,
    pub corners: [u32; 4],
    pub fall: f32,
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
    pub outer_error: f64,
    pub uncovered: f64,
    pub protrusion: f64,
    pub protrusion_at: [f64; 3],
    pub origin: [f64; 3],
    pub bounds_min: [f32; 3],
    pub bounds_max: [f32; 3],
    pub rank: u32,
    pub index_kind: u32,
    pub resolution: u32,
    pub leaf_blocks: u32,
    pub max_neighbours: u32,
    pub max_nodes: u32,
    pub max_dots: u32,
    pub source_points: u32,
    pub leaf: u32,
    pub part: u32,
    pub part_count: u32,
    pub solid: u32,
}

/// 6.4.
pub struct BoxNode {
    pub bounds: [[f32; 3]; 2],
    pub target: usize,
    pub hull_count: usize,
}

/// 6.3.
pub struct Block {
    pub position: [[f32; 8]; 3],
    pub vertex: [u32; 8],
}

/// The blocks to which a direction leads.
pub struct Leaf {
    pub blocks: Range<usize>,
    /// Number of nodes on the way.
    pub nodes: u32,
    /// Kinds of slots on the way: bit 0 for halves, then branches, plain leaves, planes, bundles,
    /// fans and lists.
    pub kinds: u8,
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
    /// 3 and 4: header, except for the hashes, and positions of the sections.
    pub fn new(bytes: &'a [u8]) -> Self {
        assert_eq!(&bytes[..8], b"hullmap\n");
        let version = u32_at(bytes, 8);
        assert!(version == 7 || version == 9, "format version {version}");
        assert_eq!(u32_at(bytes, 12), 64, "header length");
        assert_eq!(u64_at(bytes, 16), bytes.len() as u64 - 64, "payload length");
        assert_eq!(u64_at(bytes, 48), 0, "reserved");
        let root = bytes.len() - ROOT;
        let range = |entry: usize, size: usize| {
            let offset = i32::from_le_bytes(array(bytes, entry));
            let start = entry.checked_add_signed(offset as isize).unwrap();
            start..start + u32_at(bytes, entry + 4) as usize * size
        };
        let sections = std::array::from_fn(|index| range(root + 8 * index, SECTIONS[index].1));
        let first = root - 8 * FURTHER.len();
        let further = FURTHER.iter().enumerate().map(|(index, (_, size, _))| range(first + 8 * index, *size));
        let further = if version == 9 { further.collect() } else { Vec::new() };
        Self { bytes, sections, further }
    }

    /// The records of voids (15).
    pub fn voids(&self) -> Vec<Voids> {
        let bytes = self.further.first().map_or(&[][..], |range| &self.bytes[range.clone()]);
        let record = |b: &[u8]| Voids { hull: u32_at(b, 0), share: f32_at(b, 4), error: f32_at(b, 8) };
        bytes.chunks(12).map(record).collect()
    }

    /// The records of primitives (15).
    pub fn primitives(&self) -> Vec<Primitive> {
        let bytes = self.further.get(1).map_or(&[][..], |range| &self.bytes[range.clone()]);
        let record = |b: &[u8]| Primitive {
            hull: u32_at(b, 0),
            kind: u32_at(b, 4),
            center: doubles(b, 8),
            rotation: doubles(b, 32),
            sizes: doubles(b, 64),
            protrusion: f64_at(b, 88),
        };
        bytes.chunks(96).map(record).collect()
    }

    pub fn section(&self, index: usize) -> &'a [u8] {
        &self.bytes[self.sections[index].clone()]
    }

    pub fn count(&self, index: usize) -> usize {
        self.sections[index].len() / SECTIONS[index].1
    }

    /// Asserts that each section starts at the first multiple of its alignment after the section
    /// before it, that the padding is zero, and the same for the root. Every byte is then defined.
    /// Returns the number of padding bytes.
    pub fn check_layout(&self) -> usize {
        let mut end = HEADER;
        let mut padding = 0;
        let root = self.bytes.len() - ROOT..self.bytes.len();
        let root = root.start - 8 * self.further.len()..root.end;
        let all = self.sections.iter().zip(SECTIONS).chain(self.further.iter().zip(FURTHER));
        let parts = all.map(|(range, (name, _, align))| (range, name, align));
        for (range, name, align) in parts.chain([(&root, "root", 4)]) {
            assert_eq!(range.start, HEADER + (end - HEADER).next_multiple_of(align), "start of {name}");
            assert!(self.bytes[end..range.start].iter().all(|b| *b == 0), "padding before {name}");
            assert!(range.start == end || matches!(name, "spans" | "hulls" | "primitives"), "no padding before {name}");
            padding += range.start - end;
            end = range.end;
        }
        padding
    }

    /// The eleven numbers of span `hull` (6.1).
    pub fn span(&self, hull: usize) -> [usize; 11] {
        std::array::from_fn(|i| u32_at(self.section(section::SPANS), 44 * hull + 4 * i) as usize)
    }

    fn run(&self, section: usize, start: usize, end: usize) -> &'a [u8] {
        let size = SECTIONS[section].1;
        &self.section(section)[start * size..end * size]
    }

    /// The BVH (6.4).
    pub fn nodes(&self) -> Vec<BoxNode> {
        let node = |bytes: &[u8]| BoxNode {
            bounds: [floats(bytes, 0), floats(bytes, 16)],
            target: u32_at(bytes, 12) as usize,
            hull_count: u32_at(bytes, 28) as usize,
        };
        self.section(section::NODES).chunks(32).map(node).collect()
    }

    /// One hull, by its spans.
    pub fn hull(&self, hull: usize) -> Hull<'a> {
        let (start, end) = (self.span(hull), self.span(hull + 1));
        let run = |section: usize, field: usize| self.run(section, start[field], end[field]);
        Hull {
            name: run(section::NAMES, 0),
            record: Record::new(self.run(section::HULLS, hull, hull + 1)),
            vertices: run(section::VERTICES, 1).chunks(12).map(|v| floats(v, 0)).collect(),
            source_vertices: words(run(section::SOURCE_VERTICES, 1)),
            face_starts: words(run(section::FACE_STARTS, 2)),
            face_vertices: words(run(section::FACE_VERTICES, 3)),
            quads: run(section::QUADS, 9).chunks(24).map(Quad::new).collect(),
            neighbour_starts: words(run(section::NEIGHBOUR_STARTS, 1)),
            neighbours: words(run(section::NEIGHBOURS, 4)),
            neighbour_faces: words(run(section::NEIGHBOUR_FACES, 4)),
            outer_vertices: run(section::OUTER_VERTICES, 7).chunks(12).map(|v| floats(v, 0)).collect(),
            slots: words(run(section::SLOTS, 5)),
            edges: run(section::EDGES, 8).chunks(2).map(|edge| i16::from_le_bytes(array(edge, 0))).collect(),
            blocks: run(section::BLOCKS, 6).chunks(128).map(Block::new).collect(),
            masses: run(section::MASSES, 10).chunks(80).map(Mass::new).collect(),
        }
    }
}

/// The runs of `all` that start at `starts`. Each ends where the next one starts.
fn parts<'a>(starts: &[u32], all: &'a [u32]) -> Vec<&'a [u32]> {
    let ends = starts.iter().skip(1).copied().chain([all.len() as u32]);
    starts.iter().zip(ends).map(|(start, end)| &all[*start as usize..end as usize]).collect()
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
        assert_eq!(bytes.len(), 288);
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
            outer_error: f64_at(bytes, 144),
            uncovered: f64_at(bytes, 152),
            protrusion: f64_at(bytes, 160),
            protrusion_at: doubles(bytes, 168),
            origin: doubles(bytes, 192),
            bounds_min: floats(bytes, 216),
            bounds_max: floats(bytes, 228),
            rank: u32_at(bytes, 240),
            index_kind: u32_at(bytes, 244),
            resolution: u32_at(bytes, 248),
            leaf_blocks: u32_at(bytes, 252),
            max_neighbours: u32_at(bytes, 256),
            max_nodes: u32_at(bytes, 260),
            max_dots: u32_at(bytes, 264),
            source_points: u32_at(bytes, 268),
            leaf: u32_at(bytes, 272),
            part: u32_at(bytes, 276),
            part_count: u32_at(bytes, 280),
            solid: u32_at(bytes, 284),
        }
    }
}

impl Mass {
    fn new(bytes: &[u8]) -> Self {
        Self { volume: f64_at(bytes, 0), centroid: doubles(bytes, 8), second_moments: doubles(bytes, 32) }
    }
}

impl Quad {
    fn new(bytes: &[u8]) -> Self {
        let corners = std::array::from_fn(|i| u32_at(bytes, 4 + 4 * i));
        Self { face: u32_at(bytes, 0), corners, fall: f32::from_le_bytes(array(bytes, 20)) }
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

/// 7.1: the direction, scaled to a largest coordinate of 1 if f32 cannot represent it well.
pub fn in_range(d: [f64; 3]) -> [f64; 3] {
    let size = d.map(|c| (c as f32).abs()).into_iter().fold(0.0, f32::max);
    if (1e-30..=1e30).contains(&size) { d } else { scaled(d) }
}

/// The direction divided by its largest coordinate; x for an invalid direction.
pub fn scaled(d: [f64; 3]) -> [f64; 3] {
    let size = d[0].abs().max(d[1].abs()).max(d[2].abs());
    if size > 0.0 && d.iter().all(|c| c.is_finite()) { d.map(|c| c / size) } else { [1.0, 0.0, 0.0] }
}

/// 7.1: face, and the grid coordinates of u and v.
pub fn locate(d: [f32; 3]) -> (u32, [u32; 2]) {
    let [x, y, z] = d.map(f32::abs);
    let axis = if z > x && z > y {
        2
    } else if y > x {
        1
    } else {
        0
    };
    let grid = |t: f32| {
        let g = (t * 4_194_303.0).round_ties_even() + 4_194_304.0;
        if (0.0..8_388_608.0).contains(&g) { g as u32 } else { 0 }
    };
    let size = d[axis].abs();
    let face = 2 * axis as u32 + u32::from(d[axis].is_sign_negative());
    (face, [grid(d[(axis + 1) % 3] / size), grid(d[(axis + 2) % 3] / size)])
}

/// The f64 in the two words from `at` on.
fn number_at(slots: &[u32], at: usize) -> f64 {
    f64::from_bits(u64::from(slots[at]) | u64::from(slots[at + 1]) << 32)
}

/// 7.2: the normals of one plane (`planes` 1) or of a bundle (7).
fn normals_at(slots: &[u32], at: usize, planes: usize) -> Vec<[f64; 3]> {
    let normal = |plane| std::array::from_fn(|axis| number_at(slots, at + 2 * (axis * planes + plane)));
    (0..planes).map(normal).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// 7.3: the step of the fan at `at` that contains the direction.
fn step(slots: &[u32], at: usize, d: [f64; 3]) -> usize {
    let [x, y] = [at, at + 6].map(|at| dot(normals_at(slots, at, 1)[0], d));
    // The four quarters around X, Y, −X and −Y.
    let angle = match (y.abs() > x.abs(), x < 0.0, y < 0.0) {
        (false, false, _) => y / x,
        (true, _, false) => 2.0 - x / y,
        (false, true, _) => 4.0 + y / x,
        (true, _, true) => 6.0 - x / y,
    };
    let step = ((angle - number_at(slots, at + 12)) * number_at(slots, at + 14)).floor();
    let last = (1 << slots[at + 16]) - 1;
    if step.is_nan() { 0 } else { step.clamp(0.0, f64::from(last)) as usize }
}

/// The top bits of a grid coordinate of 23 bits, and the other bits shifted to the top.
fn shift(g: u32, bits: u32) -> (u32, u32) {
    (g >> (23 - bits), g << bits & 0x7f_ffff)
}

impl Hull<'_> {
    /// 7.3: the leaf of a direction in range.
    pub fn leaf(&self, d: [f64; 3]) -> Leaf {
        if self.record.index_kind == 0 {
            return Leaf { blocks: 0..self.blocks.len(), nodes: 0, kinds: 0 };
        }
        let (face, [mut u, mut v]) = locate(d.map(|c| c as f32));
        let root = if self.record.index_kind == 1 {
            let r = u64::from(self.record.resolution);
            let [column, row] = [u, v].map(|g| (u64::from(g) * r) >> 23);
            ((u64::from(face) * r + row) * r + column) as usize
        } else {
            face as usize
        };
        let (mut slot, mut nodes, mut kinds) = (self.slots[root], 0, 0);
        loop {
            let rest = slot & 0x3fff_ffff;
            match slot >> 30 {
                0 if self.record.index_kind == 2 => {
                    kinds |= 1;
                    let (half, left) = shift(u, 1);
                    (u, v) = (v, left);
                    slot = self.slots[(rest + half) as usize];
                }
                0 => {
                    kinds |= 2;
                    let (at, bits) = (rest >> 4, rest & 15);
                    let (column, row);
                    (column, u) = shift(u, bits);
                    (row, v) = shift(v, bits);
                    slot = self.slots[(at + (row << bits) + column) as usize];
                }
                1 => {
                    let first = rest as usize;
                    return Leaf { blocks: first..first + self.record.leaf_blocks as usize, nodes, kinds: kinds | 4 };
                }
                2 if rest & 3 == 2 => {
                    kinds |= 32;
                    let at = (rest >> 2) as usize;
                    slot = self.slots[at + 17 + step(&self.slots, at, d)];
                }
                2 => {
                    let (at, planes) = ((rest >> 2) as usize, if rest & 3 == 0 { 1 } else { 7 });
                    kinds |= if planes == 1 { 8 } else { 16 };
                    let normals = normals_at(&self.slots, at, planes);
                    let front = |plane: usize| usize::from(dot(normals[plane], d) > 0.0);
                    // Heap order: the children of plane k are planes 2k + 1 and 2k + 2.
                    let mut plane = 0;
                    while plane < planes {
                        plane = 2 * plane + 1 + front(plane);
                    }
                    slot = self.slots[at + 6 * planes + plane - planes];
                }
                _ => {
                    let at = rest as usize;
                    let [first, count] = [self.slots[at] as usize, self.slots[at + 1] as usize];
                    return Leaf { blocks: first..first + count, nodes, kinds: kinds | 64 };
                }
            }
            nodes += 1;
        }
    }

    /// 7.4: index of the support vertex.
    pub fn support(&self, d: [f64; 3]) -> u32 {
        let d = in_range(d);
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
        parts(&self.face_starts, &self.face_vertices)
    }

    /// The neighbours of each vertex.
    pub fn neighbours(&self) -> Vec<&[u32]> {
        parts(&self.neighbour_starts, &self.neighbours)
    }

    /// 5: the stored edges of each vertex, in its neighbours' order; empty if no edges are stored.
    pub fn edges(&self) -> Vec<Vec<[i16; 3]>> {
        let counts = self.neighbours().into_iter().map(|list| list.len());
        let runs = self.neighbour_starts.iter().zip(counts).map(|(start, count)| (3 * *start as usize, count));
        let of = |(at, count): (usize, usize)| {
            (0..count).map(|i| std::array::from_fn(|axis| self.edges[at + axis * count + i])).collect()
        };
        if self.edges.is_empty() { Vec::new() } else { runs.map(of).collect() }
    }

    /// 7.7: whether these edges certify that the vertex where they start is the support vertex.
    pub fn is_certain(edges: &[[i16; 3]], d: [f32; 3]) -> bool {
        let least = -0.52 * (d[0].abs() + d[1].abs() + d[2].abs());
        edges.iter().map(|q| q.map(f32::from)).all(|q| q[0] * d[0] + q[1] * d[1] + q[2] * d[2] < least)
    }

    /// The faces to the left of each vertex's edges, in its neighbours' order.
    pub fn faces_beside(&self) -> Vec<&[u32]> {
        parts(&self.neighbour_starts, &self.neighbour_faces)
    }
}
