//! The ground of a height field below a point.

use glam::{DVec2, DVec3};

use super::{Diagonal, HeightField};

/// Height and normal of a height field at a point.
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

/// The ground at a point of the plane.
pub(super) fn at(field: &HeightField, point: DVec2) -> Option<Ground> {
    let layout = field.layout();
    let ([x0, y0], [dx, dy], [across, along]) = (layout.origin, layout.spacing, layout.cells());
    let columns = cells_at((point.x - x0) / dx, point.x, across, |column| layout.x(column))?;
    let rows = cells_at((point.y - y0) / dy, point.y, along, |row| layout.y(row))?;
    // A point on the edge of a cell is also one of the cell beyond, which may have ground where the
    // first one is a hole.
    for row in rows {
        for column in columns {
            if let Some(found) = in_cell(field, column, row, point) {
                return Some(found);
            }
        }
    }
    None
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

/// The ground of a cell, which contains the point.
fn in_cell(field: &HeightField, column: usize, row: usize, point: DVec2) -> Option<Ground> {
    if field.is_hole(column, row) {
        return None;
    }
    let layout = field.layout();
    let corner = |dx: usize, dy: usize| field.vertex(column + dx, row + dy);
    let (near, far) = (corner(0, 0)?, corner(1, 1)?);
    let (right, top) = (corner(1, 0)?.z, corner(0, 1)?.z);
    // The position in the cell, from 0 to 1.
    let DVec2 { x: u, y: v } = (point - near.truncate()) / (far - near).truncate();
    let (is_second, height) = match layout.diagonal {
        Diagonal::Rising if v <= u => (false, near.z + u * (right - near.z) + v * (far.z - right)),
        Diagonal::Rising => (true, near.z + v * (top - near.z) + u * (far.z - top)),
        Diagonal::Falling if u + v <= 1.0 => (false, near.z + u * (right - near.z) + v * (top - near.z)),
        Diagonal::Falling => (true, far.z + (1.0 - u) * (top - far.z) + (1.0 - v) * (right - far.z)),
    };
    let triangle = 2 * layout.cell(column, row) + usize::from(is_second);
    Some(Ground { height, normal: field.normal(triangle)?, triangle })
}
