//! Checks of a height field: whether it meets the requirements that the runtime relies on.
//!
//! The grid has all its heights, finite, at rising coordinates, and the ranges of the tree are the
//! tightest ones. So a query visits each node at most once, and misses no triangle.

use rkyv::rend::u16_le;

use super::{
    MAX_CELLS,
    layout::{Diagonal, Layout},
    pyramid::{Cells, Pyramid},
    ranges,
    sections::Sections,
};
use crate::{check_error::CheckError, cutter::ROOT_ALIGNMENT, scale::Scale};

/// Why a grid cannot be the grid of a height field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum LayoutError {
    /// The grid has no cells, or more than node numbers can address.
    #[error(
        "a height field has at least 2 columns and 2 rows, and at most {MAX_CELLS} cells (found {columns} columns and \
         {rows} rows): use another part of the grid"
    )]
    Size { columns: usize, rows: usize },
    /// Coordinates do not rise from vertex to vertex, or are not finite in f32.
    #[error(
        "the coordinates along {axis} do not rise from vertex to vertex within the range of f32: choose another spacing \
         or origin"
    )]
    Coordinates { axis: char },
}

/// Why the archive of a height field is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum FieldError {
    /// The archive's sections.
    #[error(transparent)]
    Archive(#[from] CheckError),
    /// The grid.
    #[error("{0}; bake the source again")]
    Layout(#[from] LayoutError),
    /// The code of the diagonal is unknown.
    #[error("the height field has the diagonal {found} (expected 0 or 1); bake the source again")]
    Diagonal { found: u32 },
    /// A height is NaN or infinite.
    #[error("the height of vertex {vertex} is not finite; bake the source again")]
    NotFinite { vertex: usize },
    /// The stated number of holes differs from the bits, or all cells are holes.
    #[error("the height field states {found} holes, but has {expected} of {cells} cells; bake the source again")]
    Holes { found: usize, expected: usize, cells: usize },
    /// The bounds do not match the heights.
    #[error("the bounds of the height field do not match its heights; bake the source again")]
    Bounds,
    /// A range is not the tightest one around the heights below its node.
    #[error("the range of node {node} is not the tightest one around its heights; bake the source again")]
    Range { node: usize },
}

/// Checks that a grid has cells, and not too many, and that its coordinates rise, in O(columns +
/// rows).
///
/// # Errors
/// See [`LayoutError`].
pub fn check_layout(layout: &Layout) -> Result<(), LayoutError> {
    let Layout { columns, rows, .. } = *layout;
    let cells = columns.saturating_sub(1).saturating_mul(rows.saturating_sub(1));
    if !(1..=MAX_CELLS).contains(&cells) {
        return Err(LayoutError::Size { columns, rows });
    }
    let limit = f64::from(f32::MAX);
    // NaN takes the failing branch.
    let rises = |count: usize, at: &dyn Fn(usize) -> f64| {
        (1..count).all(|i| at(i - 1) < at(i)) && at(0) >= -limit && at(count - 1) <= limit
    };
    if !rises(columns, &|column| layout.x(column)) {
        return Err(LayoutError::Coordinates { axis: 'x' });
    }
    if !rises(rows, &|row| layout.y(row)) {
        return Err(LayoutError::Coordinates { axis: 'y' });
    }
    Ok(())
}

/// Checks everything in a height field that a query could follow or return, in O(file), and returns
/// its grid.
///
/// # Errors
/// The first requirement that is violated: see [`FieldError`].
pub fn check(field: &Sections<'_>, payload: &[u8]) -> Result<Layout, FieldError> {
    gaps(field, payload)?;
    let layout = grid(field)?;
    counts(field, &layout)?;
    if let Some(vertex) = field.heights.iter().position(|height| !height.to_native().is_finite()) {
        return Err(FieldError::NotFinite { vertex });
    }
    holes(field, &layout)?;
    heights(field, &layout)?;
    Ok(layout)
}

fn gaps(field: &Sections<'_>, payload: &[u8]) -> Result<(), FieldError> {
    fn extent<T>(name: &'static str, section: &[T]) -> (&'static str, usize, usize) {
        (name, size_of_val(section), align_of::<T>())
    }
    crate::check::zeros_between(
        payload,
        [
            extent("records", field.records),
            extent("source_path", field.source_path),
            extent("options", field.options),
            extent("heights", field.heights),
            extent("ranges", field.ranges),
            extent("materials", field.materials),
            extent("holes", field.holes),
            ("root", 0, ROOT_ALIGNMENT),
        ],
    )?;
    Ok(())
}

fn grid(field: &Sections<'_>) -> Result<Layout, FieldError> {
    let [record] = field.records else {
        let found = field.records.len();
        return Err(CheckError::SectionCount { section: "records", found, expected: 1 }.into());
    };
    let found = record.diagonal.to_native();
    let layout = field.layout().filter(|_| Diagonal::from_code(found).is_some());
    let layout = layout.ok_or(FieldError::Diagonal { found })?;
    check_layout(&layout)?;
    Ok(layout)
}

fn counts(field: &Sections<'_>, layout: &Layout) -> Result<(), FieldError> {
    let cells = layout.cell_count();
    let optional = |found: usize, count: usize| if found == 0 { 0 } else { count };
    let counts = [
        ("heights", field.heights.len(), layout.columns * layout.rows),
        ("ranges", field.ranges.len(), Pyramid::new(layout.cells()).stored_count()),
        ("materials", field.materials.len(), optional(field.materials.len(), cells)),
        ("holes", field.holes.len(), optional(field.holes.len(), cells.div_ceil(8))),
    ];
    for (section, found, expected) in counts {
        if found != expected {
            return Err(CheckError::SectionCount { section, found, expected }.into());
        }
    }
    for (section, text) in [("source_path", field.source_path), ("options", field.options)] {
        if let Err(error) = std::str::from_utf8(text) {
            return Err(CheckError::Text { section, at: error.valid_up_to() }.into());
        }
    }
    Ok(())
}

/// Checks the number of holes, which proves that there is a triangle.
fn holes(field: &Sections<'_>, layout: &Layout) -> Result<(), FieldError> {
    let cells = layout.cell_count();
    let found = field.records.first().map_or(0, |record| record.holes.to_native() as usize);
    let expected = field.holes.iter().map(|byte| byte.count_ones() as usize).sum();
    let beyond = field.holes.last().map_or(0, |last| if cells.is_multiple_of(8) { 0 } else { last >> (cells % 8) });
    let is_empty = field.holes.is_empty();
    if found != expected || found >= cells || (found == 0) != is_empty || beyond != 0 {
        return Err(FieldError::Holes { found, expected, cells });
    }
    Ok(())
}

fn heights(field: &Sections<'_>, layout: &Layout) -> Result<(), FieldError> {
    let [across, along] = layout.cells();
    let stated = field.height_range();
    if ranges::range(field, layout, Cells { columns: [0, across], rows: [0, along] }) != stated {
        return Err(FieldError::Bounds);
    }
    let [low, high] = stated.unwrap_or_default();
    let expected = ranges::ranges(field, layout, &Pyramid::new(layout.cells()), &Scale::new(low, high));
    let is_equal = |(found, expected): (&[u16_le; 2], &[u16; 2])| found.map(u16_le::to_native) == *expected;
    match field.ranges.iter().zip(&expected).position(|pair| !is_equal(pair)) {
        Some(node) => Err(FieldError::Range { node }),
        None => Ok(()),
    }
}
