//! The least and the greatest height below each node of the tree of a height field.
//!
//! A stored range is two numbers of 16 bits on the [`Scale`] between the least and the greatest
//! height of the field: the greatest number that is not above the heights below the node, and the
//! smallest one that is not below them. A node that has only holes has the range [`EMPTY`].

use super::{
    layout::Layout,
    pyramid::{Cells, Extent, Pyramid},
};
use crate::scale::Scale;

/// Range of a node without triangles.
pub const EMPTY: [u16; 2] = [u16::MAX, 0];

/// Heights of the vertices of a field, and its holes.
pub trait Heights {
    /// Height of a vertex; 0 if there is no such vertex.
    fn height(&self, vertex: usize) -> f32;

    /// Whether there is any hole.
    fn has_holes(&self) -> bool;

    /// Whether a cell is a hole.
    fn is_hole(&self, cell: usize) -> bool;
}

/// Whether the bit of a cell is set.
#[inline]
pub fn is_marked(holes: &[u8], cell: usize) -> bool {
    holes.get(cell / 8).is_some_and(|byte| byte >> (cell % 8) & 1 == 1)
}

/// Least and greatest height of the cells of a rectangle; `None` if all of them are holes.
#[inline]
pub fn range(field: &impl Heights, layout: &Layout, cells: Cells) -> Option<[f32; 2]> {
    let Cells { columns: [left, right], rows: [bottom, top] } = cells;
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    let mut add = |column: usize, row: usize| {
        let height = field.height(layout.vertex(column, row));
        (low, high) = (low.min(height), high.max(height));
    };
    if field.has_holes() {
        for row in bottom..top {
            for column in left..right {
                if !field.is_hole(layout.cell(column, row)) {
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        add(column + dx, row + dy);
                    }
                }
            }
        }
    } else {
        for row in bottom..=top {
            (left..=right).for_each(|column| add(column, row));
        }
    }
    (low <= high).then_some([low, high])
}

/// The ranges of all nodes with a stored range, in O(cells).
pub fn ranges(field: &impl Heights, layout: &Layout, pyramid: &Pyramid, scale: &Scale) -> Vec<[u16; 2]> {
    let mut ranges = vec![EMPTY; pyramid.stored_count()];
    let last_level = pyramid.last_stored_level();
    for node in (0..ranges.len()).rev() {
        let own = if node >= last_level {
            let of_cells = |extent: Extent| match extent {
                Extent::Cells(cells) => range(field, layout, cells),
                Extent::Triangle(_) => None,
            };
            let exact = pyramid.extent(node as u32).and_then(of_cells);
            exact.map_or(EMPTY, |[low, high]| [scale.below(low.into()), scale.above(high.into())])
        } else {
            let child = Pyramid::first_child(node as u32) as usize;
            let of = |child: usize| ranges.get(child).copied().unwrap_or(EMPTY);
            let ([low, high], [low_2, high_2]) = (of(child), of(child + 1));
            [low.min(low_2), high.max(high_2)]
        };
        if let Some(node) = ranges.get_mut(node) {
            *node = own;
        }
    }
    ranges
}
