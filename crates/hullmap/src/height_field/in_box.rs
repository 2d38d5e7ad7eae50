//! Triangles near a box: the triangles of the cells below and above it, found without the tree.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::{HeightField, ground};
use crate::shapes::triangle::{VisitTriangle, is_beside_box};

/// Maximum number of cells that are visited one by one. Above it, the tree rules out many by their
/// heights.
const MAX_CELLS: usize = 64;

impl HeightField {
    /// Visits all triangles whose boxes overlap a box, given by two corners, until a visit says
    /// `true`. Returns whether one did, and the number of cells; `None` if there are too many.
    pub(crate) fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        let Some([columns, rows]) = ground::cells_between(&self.layout, bounds.map(DVec3::truncate)) else {
            return Some((false, 0));
        };
        let count = |[first, last]: [usize; 2]| last - first + 1;
        count(columns).checked_mul(count(rows)).filter(|cells| *cells <= MAX_CELLS)?;
        let mut cells = 0;
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                cells += 1;
                let cell = self.layout.cell(column, row);
                for triangle in [2 * cell, 2 * cell + 1] {
                    let Some(corners) = self.corners(triangle) else { continue };
                    if !is_beside_box(corners, bounds) && visit(triangle, corners) {
                        return Some((true, cells));
                    }
                }
            }
        }
        Some((false, cells))
    }
}
