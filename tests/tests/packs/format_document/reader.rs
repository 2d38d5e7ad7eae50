//! The root and the look-up of `.hullmap` files, written from `docs/contributors/FORMAT.md` without
//! code of the project. Records are read by their types, whose layout is the document's.
//!
//! Numbers in comments are sections of the document. The reader panics on damaged files, which
//! fails the test.

use std::ops::Range;

use hullmap_format::archive::{ArchivedBlock, ArchivedHullRecord, ArchivedSpan};
use hullmap_format::sections::Sections;

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

/// The number in these bytes (1): little-endian.
pub fn number(bytes: &[u8], at: usize, size: usize) -> u64 {
    bytes[at..at + size].iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// A whole file.
pub struct File<'a> {
    bytes: &'a [u8],
    /// File offsets of each section's bytes.
    pub sections: [Range<usize>; 19],
    /// File offsets of the bytes of further sections; none in versions 7 and 8.
    pub further: Vec<Range<usize>>,
}

/// The direction index of one hull.
pub struct Hull<'a> {
    pub record: &'a ArchivedHullRecord,
    pub slots: Vec<u32>,
    pub blocks: &'a [ArchivedBlock],
    /// 5: the stored edges of each vertex, in its neighbours' order; empty if no edges are stored.
    pub edges: Vec<Vec<[i16; 3]>>,
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
        let version = number(bytes, 8, 4);
        assert!((7..=10).contains(&version), "format version {version}");
        assert_eq!(number(bytes, 12, 4), 64, "header length");
        assert_eq!(number(bytes, 16, 8), bytes.len() as u64 - 64, "payload length");
        assert_eq!(number(bytes, 48, 8), 0, "reserved");
        let root = bytes.len() - ROOT;
        let range = |entry: usize, size: usize| {
            let start = entry.checked_add_signed(number(bytes, entry, 4) as i32 as isize).unwrap();
            start..start + number(bytes, entry + 4, 4) as usize * size
        };
        let sections = std::array::from_fn(|index| range(root + 8 * index, SECTIONS[index].1));
        let first = root - 8 * FURTHER.len();
        let further = FURTHER.iter().enumerate().map(|(index, (_, size, _))| range(first + 8 * index, *size));
        let further = if version >= 9 { further.collect() } else { Vec::new() };
        Self { bytes, sections, further }
    }

    pub fn section(&self, name: &str) -> &'a [u8] {
        let index = SECTIONS.iter().position(|(own, ..)| *own == name).expect(name);
        &self.bytes[self.sections[index].clone()]
    }

    /// File offset of an element of a section or of a further section.
    pub fn element(&self, name: &str, index: usize) -> usize {
        let mut all = SECTIONS.iter().chain(&FURTHER).zip(self.sections.iter().chain(&self.further));
        let ((_, size, _), range) = all.find(|((own, ..), _)| *own == name).expect(name);
        range.clone().step_by(*size).nth(index).expect("the section has this element")
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

impl<'a> Hull<'a> {
    /// A hull by its spans (6.1).
    pub fn new(pack: &Sections<'a>, hull: usize) -> Self {
        let [start, end] = [&pack.spans[hull], &pack.spans[hull + 1]];
        let run = |number: fn(&ArchivedSpan) -> u32| number(start) as usize..number(end) as usize;
        let slots = pack.slots[run(|span| span.slot.to_native())].iter().map(|word| word.to_native()).collect();
        let edges = &pack.edges[run(|span| span.edge.to_native())];
        let starts = &pack.neighbour_starts[run(|span| span.vertex.to_native())];
        let all = run(|span| span.neighbour.to_native()).len();
        let ends = starts.iter().skip(1).map(|start| start.to_native() as usize).chain([all]);
        let of = |(start, end): (usize, usize)| {
            let edge = |i: usize| -> [i16; 3] {
                std::array::from_fn(|axis| edges[3 * start + axis * (end - start) + i].to_native())
            };
            (0..end - start).map(edge).collect()
        };
        let runs = starts.iter().map(|start| start.to_native() as usize).zip(ends);
        Self {
            record: &pack.hulls[hull],
            slots,
            blocks: &pack.blocks[run(|span| span.block.to_native())],
            edges: if edges.is_empty() { Vec::new() } else { runs.map(of).collect() },
        }
    }

    fn kind(&self) -> u32 {
        self.record.index_kind.to_native()
    }

    /// 7.3: the leaf of a direction in range.
    pub fn leaf(&self, d: [f64; 3]) -> Leaf {
        if self.kind() == 0 {
            return Leaf { blocks: 0..self.blocks.len(), nodes: 0, kinds: 0 };
        }
        let (face, [mut u, mut v]) = locate(d.map(|c| c as f32));
        let root = if self.kind() == 1 {
            let r = u64::from(self.record.resolution.to_native());
            let [column, row] = [u, v].map(|g| (u64::from(g) * r) >> 23);
            ((u64::from(face) * r + row) * r + column) as usize
        } else {
            face as usize
        };
        let (mut slot, mut nodes, mut kinds) = (self.slots[root], 0, 0);
        loop {
            let rest = slot & 0x3fff_ffff;
            match slot >> 30 {
                0 if self.kind() == 2 => {
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
                    return Leaf {
                        blocks: first..first + self.record.leaf_blocks.to_native() as usize,
                        nodes,
                        kinds: kinds | 4,
                    };
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
        let mut found = blocks[0].vertex[0].to_native();
        let mut greatest = f64::NEG_INFINITY;
        for block in blocks {
            for lane in 0..8 {
                let height = dot([&block.x, &block.y, &block.z].map(|c| f64::from(c[lane].to_native())), d);
                if height > greatest {
                    (greatest, found) = (height, block.vertex[lane].to_native());
                }
            }
        }
        found
    }

    /// 7.7: whether these edges certify that the vertex where they start is the support vertex.
    pub fn is_certain(edges: &[[i16; 3]], d: [f32; 3]) -> bool {
        let least = -0.52 * (d[0].abs() + d[1].abs() + d[2].abs());
        edges.iter().map(|q| q.map(f32::from)).all(|q| q[0] * d[0] + q[1] * d[1] + q[2] * d[2] < least)
    }
}
