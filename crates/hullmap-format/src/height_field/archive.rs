//! The rkyv archive of a height field: vectors of plain numbers, for which every bit pattern is
//! valid, as in packs.

use bytemuck::{Pod, Zeroable};
use rkyv::{Archive, Serialize};

/// Everything in the file of a height field. Lengths are in source units.
#[derive(Archive, Serialize, Clone, Debug, Default)]
pub struct HeightField {
    /// One record.
    pub records: Vec<Record>,
    /// Path of the source relative to the file's folder, UTF-8, with `/`; empty if not recorded.
    pub source_path: Vec<u8>,
    /// The options that shaped the bake, then a line for each warning; UTF-8.
    pub options: Vec<u8>,
    /// Heights of the vertices along +z, row by row, in the order of x within a row and of y
    /// between rows. −0 is stored as +0. A vertex of holes alone has the height 0.
    pub heights: Vec<f32>,
    /// Least and greatest height below each node of the tree, on a scale of 16 bits: see
    /// [`ranges`](super::ranges).
    pub ranges: Vec<[u16; 2]>,
    /// For each cell, the material that the source states; empty if it states none.
    pub materials: Vec<u16>,
    /// For each cell a bit, the lowest first, that is 1 for a hole; empty if there are no holes.
    pub holes: Vec<u8>,
}

/// The grid.
#[derive(Archive, Serialize, Clone, Copy, Debug, Default, PartialEq)]
#[rkyv(derive(Clone, Copy, Debug, Pod, Zeroable))]
pub struct Record {
    /// x and y of the first vertex.
    pub origin: [f64; 2],
    /// Distance of neighbouring vertices along x and along y.
    pub spacing: [f64; 2],
    /// Number of vertices along x.
    pub columns: u32,
    /// Number of vertices along y.
    pub rows: u32,
    /// Least height of a cell that is not a hole.
    pub low: f32,
    /// Greatest height of a cell that is not a hole.
    pub high: f32,
    /// Code of the [`Diagonal`](super::layout::Diagonal) that divides each cell.
    pub diagonal: u32,
    /// Number of holes.
    pub holes: u32,
}
