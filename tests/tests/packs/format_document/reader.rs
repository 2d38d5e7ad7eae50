//! A reader of `.hullmap` files, written from `docs/contributors/FORMAT.md` without code of the
//! project. It is simple, not fast.
//!
//! Numbers in comments are sections of the document. The reader panics on damaged files, which
//! fails the test.

use std::ops::Range;

/// Sections in the order of the root's entries (4): name, bytes per element, alignment. Also their
/// indices by their names.
macro_rules! sections {
    ($count:literal; $($index:literal $constant:ident $name:literal $size:literal $align:literal,)+) => {
        pub const SECTIONS: [(&str, usize, usize); $count] = [$(($name, $size, $align)),+];

        /// Indices of the sections in [`SECTIONS`].
        pub mod section {
            $(pub const $constant: usize = $index;)+
        }
    };
}

sections! { 19;
    0 BLOCKS "blocks" 128 64,
    1 SOURCE_PATH "source_path" 1 1,
    2 OPTIONS "options" 1 1,
    3 NAMES "names" 1 1,
    4 SPANS "spans" 44 4,
    5 HULLS "hulls" 288 8,
    6 MASSES "masses" 80 8,
    7 NODES "nodes" 32 4,
    8 VERTICES "vertices" 12 4,
    9 SOURCE_VERTICES "source_vertices" 4 4,
    10 FACE_STARTS "face_starts" 4 4,
    11 FACE_VERTICES "face_vertices" 4 4,
    12 QUADS "quads" 24 4,
    13 NEIGHBOUR_STARTS "neighbour_starts" 4 4,
    14 NEIGHBOURS "neighbours" 4 4,
    15 NEIGHBOUR_FACES "neighbour_faces" 4 4,
    16 OUTER_VERTICES "outer_vertices" 12 4,
    17 SLOTS "slots" 4 4,
    18 EDGES "edges" 2 2,
}

const HEADER: usize = 64;
pub const ROOT: usize = 152;

/// Further sections, as in [`SECTIONS`] (15). Their entries are in front of the root.
const FURTHER: [(&str, usize, usize); 2] = [("voids", 12, 4), ("primitives", 96, 8)];

/// Something that is stored in a number of bytes.
pub trait Stored: Sized {
    const SIZE: usize;

    fn at(bytes: &[u8], at: usize) -> Self;

    /// Elements without gaps.
    fn all(bytes: &[u8]) -> Vec<Self> {
        bytes.chunks(Self::SIZE).map(|bytes| Self::at(bytes, 0)).collect()
    }
}

macro_rules! numbers {
    ($($number:ty)+) => {
        $(impl Stored for $number {
            const SIZE: usize = size_of::<$number>();

            fn at(bytes: &[u8], at: usize) -> Self {
                Self::from_le_bytes(bytes[at..at + Self::SIZE].try_into().unwrap())
            }
        })+
    };
}

numbers! { i16 i32 u32 u64 f32 f64 }

impl<T: Stored, const N: usize> Stored for [T; N] {
    const SIZE: usize = N * T::SIZE;

    fn at(bytes: &[u8], at: usize) -> Self {
        std::array::from_fn(|i| T::at(bytes, at + i * T::SIZE))
    }
}

/// Records: their bytes, and fields at their offsets.
macro_rules! records {
    ($($section:literal $name:ident $size:literal { $($at:literal $field:ident: $kind:ty,)+ })+) => {
        $(#[doc = $section]
        #[derive(Debug, PartialEq)]
        pub struct $name {
            $(pub $field: $kind,)+
        }

        impl Stored for $name {
            const SIZE: usize = $size;

            fn at(bytes: &[u8], at: usize) -> Self {
                Self { $($field: <$kind>::at(bytes, at + $at),)+ }
            }
        })+
    };
}

records! {
    "6.2" Record 288 {
        0 diameter: f64,
        8 centroid: [f64; 3],
        32 interior_point: [f64; 3],
        56 inner_radius: f64,
        64 outer_radius: f64,
        72 volume: f64,
        80 surface_area: f64,
        88 second_moments: [f64; 6],
        136 containment_error: f64,
        144 outer_error: f64,
        152 uncovered: f64,
        160 protrusion: f64,
        168 protrusion_at: [f64; 3],
        192 origin: [f64; 3],
        216 bounds_min: [f32; 3],
        228 bounds_max: [f32; 3],
        240 rank: u32,
        244 index_kind: u32,
        248 resolution: u32,
        252 leaf_blocks: u32,
        256 max_neighbours: u32,
        260 max_nodes: u32,
        264 max_dots: u32,
        268 source_points: u32,
        272 leaf: u32,
        276 part: u32,
        280 part_count: u32,
        284 solid: u32,
    }
    "6.3" Block 128 {
        0 position: [[f32; 8]; 3],
        96 vertex: [u32; 8],
    }
    "6.4" BoxNode 32 {
        0 bounds_min: [f32; 3],
        12 target: u32,
        16 bounds_max: [f32; 3],
        28 hull_count: u32,
    }
    "6.5" Quad 24 {
        0 face: u32,
        4 corners: [u32; 4],
        20 fall: f32,
    }
    "6.6" Mass 80 {
        0 volume: f64,
        8 centroid: [f64; 3],
        32 second_moments: [f64; 6],
    }
    "15" Voids 12 {
        0 hull: u32,
        4 share: f32,
        8 error: f32,
    }
    "15" Primitive 96 {
        0 hull: u32,
        4 kind: u32,
        8 center: [f64; 3],
        32 rotation: [f64; 4],
        64 sizes: [f64; 3],
        88 protrusion: f64,
    }
}

/// A whole file.
pub struct File<'a> {
    bytes: &'a [u8],
    /// File offsets of each section's bytes.
    pub sections: [Range<usize>; 19],
    /// File offsets of the bytes of further sections; none in version 7.
    pub further: Vec<Range<usize>>,
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

/// The blocks to which a direction leads.
pub struct Leaf {
    pub blocks: Range<usize>,
    /// Number of nodes on the way.
    pub nodes: u32,
    /// Kinds of slots on the way: bit 0 for halves, then branches, plain leaves, planes, bundles,
    /// fans and lists.
    pub kinds: u8,
}

impl<'a> File<'a> {
    /// 3 and 4: header, except for the hashes, and positions of the sections.
    pub fn new(bytes: &'a [u8]) -> Self {
        assert_eq!(&bytes[..8], b"hullmap\n");
        let version = u32::at(bytes, 8);
        assert!(version == 7 || version == 9, "format version {version}");
        assert_eq!(u32::at(bytes, 12), 64, "header length");
        assert_eq!(u64::at(bytes, 16), bytes.len() as u64 - 64, "payload length");
        assert_eq!(u64::at(bytes, 48), 0, "reserved");
        let root = bytes.len() - ROOT;
        let range = |entry: usize, size: usize| {
            let start = entry.checked_add_signed(i32::at(bytes, entry) as isize).unwrap();
            start..start + u32::at(bytes, entry + 4) as usize * size
        };
        let sections = std::array::from_fn(|index| range(root + 8 * index, SECTIONS[index].1));
        let first = root - 8 * FURTHER.len();
        let further = FURTHER.iter().enumerate().map(|(index, (_, size, _))| range(first + 8 * index, *size));
        let further = if version == 9 { further.collect() } else { Vec::new() };
        Self { bytes, sections, further }
    }

    /// The records of voids (15).
    pub fn voids(&self) -> Vec<Voids> {
        self.further.first().map_or(Vec::new(), |range| Stored::all(&self.bytes[range.clone()]))
    }

    /// The records of primitives (15).
    pub fn primitives(&self) -> Vec<Primitive> {
        self.further.get(1).map_or(Vec::new(), |range| Stored::all(&self.bytes[range.clone()]))
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
        <[u32; 11]>::at(self.section(section::SPANS), 44 * hull).map(|number| number as usize)
    }

    fn run(&self, section: usize, start: usize, end: usize) -> &'a [u8] {
        let size = SECTIONS[section].1;
        &self.section(section)[start * size..end * size]
    }

    /// The BVH (6.4).
    pub fn nodes(&self) -> Vec<BoxNode> {
        Stored::all(self.section(section::NODES))
    }

    /// One hull, by its spans.
    pub fn hull(&self, hull: usize) -> Hull<'a> {
        let (start, end) = (self.span(hull), self.span(hull + 1));
        let run = |section: usize, field: usize| self.run(section, start[field], end[field]);
        Hull {
            name: run(section::NAMES, 0),
            record: Record::at(self.section(section::HULLS), Record::SIZE * hull),
            vertices: Stored::all(run(section::VERTICES, 1)),
            source_vertices: Stored::all(run(section::SOURCE_VERTICES, 1)),
            face_starts: Stored::all(run(section::FACE_STARTS, 2)),
            face_vertices: Stored::all(run(section::FACE_VERTICES, 3)),
            quads: Stored::all(run(section::QUADS, 9)),
            neighbour_starts: Stored::all(run(section::NEIGHBOUR_STARTS, 1)),
            neighbours: Stored::all(run(section::NEIGHBOURS, 4)),
            neighbour_faces: Stored::all(run(section::NEIGHBOUR_FACES, 4)),
            outer_vertices: Stored::all(run(section::OUTER_VERTICES, 7)),
            slots: Stored::all(run(section::SLOTS, 5)),
            edges: Stored::all(run(section::EDGES, 8)),
            blocks: Stored::all(run(section::BLOCKS, 6)),
            masses: Stored::all(run(section::MASSES, 10)),
        }
    }
}

/// The runs of `all` that start at `starts`. Each ends where the next one starts.
fn parts<'a>(starts: &[u32], all: &'a [u32]) -> Vec<&'a [u32]> {
    let ends = starts.iter().skip(1).copied().chain([all.len() as u32]);
    starts.iter().zip(ends).map(|(start, end)| &all[*start as usize..end as usize]).collect()
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
