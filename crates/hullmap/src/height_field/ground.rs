//! The ground of a height field below a point.

use glam::{DVec2, DVec3};
use hullmap_format::height_field::layout::{Diagonal, Layout};

/// Height and normal of a height field at a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// z of the surface, on the plane of the triangle. Its rounding error is at most a few units
    /// in the last place of the greatest height of the cell.
    pub height: f64,
    /// Upward unit normal of the triangle.
    pub normal: DVec3,
    /// The triangle.
    pub triangle: usize,
}

/// The columns and the rows of the cells that contain a point of the plane; `None` beyond the
/// field.
pub(super) fn cells(layout: &Layout, point: DVec2) -> Option<[[usize; 2]; 2]> {
    let ([x0, y0], [dx, dy], [across, along]) = (layout.origin, layout.spacing, layout.cells());
    let columns = cells_at((point.x - x0) / dx, point.x, across, |column| layout.x(column))?;
    let rows = cells_at((point.y - y0) / dy, point.y, along, |row| layout.y(row))?;
    Some([columns, rows])
}

/// The columns and the rows of the cells that a box of the plane, given by two corners, overlaps:
/// the first and the last; `None` beyond the field.
pub(super) fn cells_between(layout: &Layout, [low, high]: [DVec2; 2]) -> Option<[[usize; 2]; 2]> {
    let ([x0, y0], [dx, dy], [across, along]) = (layout.origin, layout.spacing, layout.cells());
    let between = |bounds: [f64; 2], count: usize, guess: &dyn Fn(f64) -> f64, at: &dyn Fn(usize) -> f64| {
        let (least, most) = (at(0), at(count));
        // NaN takes the failing branch.
        if !(bounds[0] <= most && bounds[1] >= least) {
            return None;
        }
        let cells = |coordinate: f64| cells_at(guess(coordinate), coordinate, count, at);
        let [[first, _], [_, last]] = [cells(bounds[0].max(least))?, cells(bounds[1].min(most))?];
        Some([first, last])
    };
    let columns = between([low.x, high.x], across, &|x| (x - x0) / dx, &|column| layout.x(column))?;
    let rows = between([low.y, high.y], along, &|y| (y - y0) / dy, &|row| layout.y(row))?;
    Some([columns, rows])
}

/// The lowest and the highest cell along an axis that contain a coordinate; `None` if no cell does.
/// `guess` is the approximate number of the cell.
fn cells_at(guess: f64, coordinate: f64, count: usize, at: impl Fn(usize) -> f64) -> Option<[usize; 2]> {
    // NaN takes the failing branch.
    if !(at(0) <= coordinate && coordinate <= at(count)) {
        return None;
    }
    // A cast saturates. Coordinates rise, so the search ends; the guess is off by one, or by
    // a few if the spacing is near the rounding error of the coordinates.
    let mut cell = (guess as usize).min(count - 1);
    while cell > 0 && at(cell) > coordinate {
        cell -= 1;
    }
    while cell + 1 < count && at(cell + 1) <= coordinate {
        cell += 1;
    }
    let low = if at(cell) == coordinate { cell.saturating_sub(1) } else { cell };
    Some([low, cell])
}

/// Height of a cell at a point in it, and whether that is in its second triangle. The cell's
/// vertices are those with the least x and y, the least y, the least x, and neither.
pub(super) fn in_cell([near, right, top, far]: [DVec3; 4], diagonal: Diagonal, point: DVec2) -> (f64, bool) {
    // The position in the cell, from 0 to 1.
    let DVec2 { x: u, y: v } = (point - near.truncate()) / (far - near).truncate();
    match diagonal {
        Diagonal::Rising if v <= u => (near.z + u * (right.z - near.z) + v * (far.z - right.z), false),
        Diagonal::Rising => (near.z + v * (top.z - near.z) + u * (far.z - top.z), true),
        Diagonal::Falling if u + v <= 1.0 => (near.z + u * (right.z - near.z) + v * (top.z - near.z), false),
        Diagonal::Falling => (far.z + (1.0 - u) * (top.z - far.z) + (1.0 - v) * (right.z - far.z), true),
    }
}
