//! Height fields: a static ground whose heights are known on a regular grid.
//!
//! # Steps
//! 1. Find the holes: cells that the caller names, and those with a vertex whose height is NaN.
//! 2. Store the heights, 0 at vertices of holes alone. −0 becomes +0.
//! 3. Find the ranges of the tree ([`ranges`]).
//!
//! Triangles, neighbours and classes of edges follow from the grid, and are not stored.

use hullmap_format::{
    header::{Header, options_hash},
    height_field::{
        archive::{HeightField, Record},
        check::check_layout,
        layout::Layout,
        pyramid::{Cells, Pyramid},
        ranges::{self, Heights, is_marked},
    },
    scale::Scale,
};

use crate::{baked_hull::SourceRecord, error::BakeError, file, pack::options_text};

/// Heights on a grid.
#[derive(Clone, Copy, Debug)]
pub struct HeightGrid<'a> {
    /// Where the vertices are, and the diagonal of the cells.
    pub layout: Layout,
    /// Height of each vertex along +z, row by row, in the order of x within a row and of y between
    /// rows. NaN: there is no ground at the vertex, and the cells around it are holes.
    pub heights: &'a [f32],
    /// Whether each cell is a hole; empty if no other cells are.
    pub holes: &'a [bool],
    /// Material of each cell; empty if the source has none.
    pub materials: &'a [u16],
}

/// A height field, ready to be written.
#[derive(Clone, Debug)]
pub struct BakedHeightField {
    field: HeightField,
}

/// The contents of a height field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldCounts {
    /// Number of vertices along x.
    pub columns: usize,
    /// Number of vertices along y.
    pub rows: usize,
    /// Number of cells that are holes.
    pub holes: usize,
    /// Least and greatest height of the other cells.
    pub heights: [f32; 2],
}

/// Bakes heights on a grid as a static ground: a pure function of the arguments.
///
/// # Errors
/// A malformed grid; numbers of heights, holes or materials that do not fit it; an infinite height;
/// only holes.
///
/// # Complexity
/// O(n) for n vertices.
///
/// # Examples
/// ```
/// use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
/// use hullmap_format::height_field::layout::{Diagonal, Layout};
///
/// // Three cells along x, one along y; the second one is a hole.
/// let diagonal = Diagonal::Rising;
/// let layout = Layout { columns: 4, rows: 2, origin: [0.0; 2], spacing: [1.0, 1.0], diagonal };
/// let heights = [0.0, 1.0, 1.0, 0.5, 0.0, 1.0, 1.0, 0.5];
/// let holes = [false, true, false];
/// let field = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &holes, materials: &[] })?;
/// let counts = field.counts();
/// assert_eq!((counts.columns, counts.rows, counts.holes, counts.heights), (4, 2, 1, [0.0, 1.0]));
/// let file = write_height_field(field, &Default::default())?;
/// assert!(file.starts_with(b"hullfld\n"));
/// # Ok::<(), hullmap_bake::BakeError>(())
/// ```
pub fn bake_height_field(source: &HeightGrid<'_>) -> Result<BakedHeightField, BakeError> {
    let HeightGrid { layout, heights, materials, .. } = source;
    check(source)?;
    let (holes, hole_count) = holes(source);
    let cells = layout.cell_count();
    if hole_count == cells {
        return Err(BakeError::OnlyHoles);
    }
    let mut field = HeightField { holes, materials: materials.to_vec(), ..HeightField::default() };
    field.heights = heights.iter().map(|height| height + 0.0).collect();
    if hole_count > 0 {
        clear_unused(layout, &field.holes, &mut field.heights);
    }
    let pyramid = Pyramid::new(layout.cells());
    let [across, along] = layout.cells();
    let all = Cells { columns: [0, across], rows: [0, along] };
    let [low, high] = ranges::range(&Field(&field), layout, all).ok_or(BakeError::OnlyHoles)?;
    field.ranges = ranges::ranges(&Field(&field), layout, &pyramid, &Scale::new(low, high));
    field.records = vec![Record {
        origin: layout.origin,
        spacing: layout.spacing,
        columns: layout.columns as u32,
        rows: layout.rows as u32,
        low,
        high,
        diagonal: layout.diagonal.code(),
        holes: hole_count as u32,
    }];
    Ok(BakedHeightField { field })
}

/// The bytes of the file of a height field: a pure function of the arguments.
///
/// # Errors
/// [`BakeError::PackTooLarge`] if the file exceeds 2 GiB.
pub fn write_height_field(baked: BakedHeightField, source: &SourceRecord) -> Result<Vec<u8>, BakeError> {
    let options = options_text(source);
    let options_hash = options_hash(&options);
    let source_path = source.path.clone().into_bytes();
    let field = HeightField { source_path, options: options.into_bytes(), ..baked.field };
    file::bytes(&field, |payload| Header::for_height_field(source.hash, options_hash, payload))
}

impl BakedHeightField {
    /// The contents of the height field.
    pub fn counts(&self) -> FieldCounts {
        let record = self.field.records.first().copied().unwrap_or_default();
        FieldCounts {
            columns: record.columns as usize,
            rows: record.rows as usize,
            holes: record.holes as usize,
            heights: [record.low, record.high],
        }
    }
}

fn check(source: &HeightGrid<'_>) -> Result<(), BakeError> {
    let HeightGrid { layout, heights, holes, materials } = source;
    check_layout(layout)?;
    let cells = layout.cell_count();
    let optional = |count: usize| if count == 0 { 0 } else { cells };
    for (what, found, expected) in [
        ("heights", heights.len(), layout.columns * layout.rows),
        ("holes", holes.len(), optional(holes.len())),
        ("materials", materials.len(), optional(materials.len())),
    ] {
        if found != expected {
            return Err(BakeError::GridCount { what, found, expected });
        }
    }
    match heights.iter().position(|height| height.is_infinite()) {
        Some(vertex) => {
            Err(BakeError::InfiniteHeight { column: vertex % layout.columns, row: vertex / layout.columns })
        }
        None => Ok(()),
    }
}

/// Step 1: a bit for each cell, and the number of holes. Without holes there are no bits.
fn holes(source: &HeightGrid<'_>) -> (Vec<u8>, usize) {
    let HeightGrid { layout, heights, holes, .. } = source;
    let [across, along] = layout.cells();
    let mut bits = vec![0_u8; layout.cell_count().div_ceil(8)];
    let mut count = 0;
    for row in 0..along {
        for column in 0..across {
            let cell = layout.cell(column, row);
            let is_named = holes.get(cell).copied().unwrap_or_default();
            let is_missing = |(column, row): (usize, usize)| heights[layout.vertex(column, row)].is_nan();
            if is_named || corners(column, row).into_iter().any(is_missing) {
                bits[cell / 8] |= 1 << (cell % 8);
                count += 1;
            }
        }
    }
    if count == 0 {
        bits.clear();
    }
    (bits, count)
}

fn corners(column: usize, row: usize) -> [(usize, usize); 4] {
    [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)]
}

/// Sets the heights of vertices without a cell that is no hole to 0: nothing depends on them, and
/// equal surfaces get equal bytes.
fn clear_unused(layout: &Layout, holes: &[u8], heights: &mut [f32]) {
    let [across, along] = layout.cells();
    for row in 0..layout.rows {
        for column in 0..layout.columns {
            let mut columns = column.saturating_sub(1)..(column + 1).min(across);
            let rows = row.saturating_sub(1)..(row + 1).min(along);
            let is_used = columns.any(|column| rows.clone().any(|row| !is_marked(holes, layout.cell(column, row))));
            if !is_used {
                heights[layout.vertex(column, row)] = 0.0;
            }
        }
    }
}

struct Field<'a>(&'a HeightField);

impl Heights for Field<'_> {
    fn height(&self, vertex: usize) -> f32 {
        self.0.heights.get(vertex).copied().unwrap_or_default()
    }

    fn has_holes(&self) -> bool {
        !self.0.holes.is_empty()
    }

    fn is_hole(&self, cell: usize) -> bool {
        is_marked(&self.0.holes, cell)
    }
}

#[cfg(test)]
mod tests;
