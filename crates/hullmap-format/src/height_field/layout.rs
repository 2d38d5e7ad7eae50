//! Where the vertices of a height field are, and which triangles its cells have.
//!
//! Vertex (column, row) is at x = origin + column · spacing, rounded to f64, and y likewise. A cell
//! is named by its vertex with the least x and y. Its diagonal divides it into two triangles,
//! counter-clockwise seen from +z, the first with the edge along x of the lesser y.

use std::fmt;

/// Corners of a triangle: steps in column and row from the first vertex of the cell.
type Corners = [[u32; 2]; 3];

/// The diagonal that divides each cell.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Diagonal {
    /// From the vertex with the least x and y to that with the greatest.
    #[default]
    Rising = 0,
    /// From the greatest x and least y to the least x and greatest y.
    Falling = 1,
}

impl Diagonal {
    /// All diagonals, in order of their codes.
    pub const ALL: [Self; 2] = [Self::Rising, Self::Falling];

    /// Name of the diagonal.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Rising => "rising",
            Self::Falling => "falling",
        }
    }

    /// Code of the diagonal in a file.
    pub const fn code(self) -> u32 {
        match self {
            Self::Rising => 0,
            Self::Falling => 1,
        }
    }

    /// The diagonal with this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|diagonal| diagonal.code() == code)
    }

    const fn corners(self, is_second: bool) -> Corners {
        match (self, is_second) {
            (Self::Rising, false) => [[0, 0], [1, 0], [1, 1]],
            (Self::Rising, true) => [[0, 0], [1, 1], [0, 1]],
            (Self::Falling, false) => [[0, 0], [1, 0], [0, 1]],
            (Self::Falling, true) => [[1, 0], [1, 1], [0, 1]],
        }
    }

    /// Steps in column and row to the cell beyond each edge of a triangle, from corner i to the
    /// next one. The neighbour of a first triangle is a second one, and the other way round.
    const fn steps(self, is_second: bool) -> [[i32; 2]; 3] {
        match (self, is_second) {
            (Self::Rising, false) => [[0, -1], [1, 0], [0, 0]],
            (Self::Rising, true) => [[0, 0], [0, 1], [-1, 0]],
            (Self::Falling, false) => [[0, -1], [0, 0], [-1, 0]],
            (Self::Falling, true) => [[1, 0], [0, 1], [0, 0]],
        }
    }
}

impl fmt::Display for Diagonal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The grid of a height field, of 1 to [`MAX_CELLS`](super::MAX_CELLS) cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Number of vertices along x, at least 2.
    pub columns: usize,
    /// Number of vertices along y, at least 2.
    pub rows: usize,
    /// x and y of the first vertex.
    pub origin: [f64; 2],
    /// Distance of neighbouring vertices along x and along y.
    pub spacing: [f64; 2],
    /// The diagonal of each cell.
    pub diagonal: Diagonal,
}

impl Layout {
    /// Number of cells along x and along y.
    #[inline]
    pub fn cells(&self) -> [usize; 2] {
        [self.columns.saturating_sub(1), self.rows.saturating_sub(1)]
    }

    /// Number of cells, holes included.
    #[inline]
    pub fn cell_count(&self) -> usize {
        let [across, along] = self.cells();
        across * along
    }

    /// Number of triangles, including the triangles of holes: two for each cell.
    #[inline]
    pub fn triangle_count(&self) -> usize {
        2 * self.cell_count()
    }

    /// Index of a vertex.
    #[inline]
    pub fn vertex(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }

    /// Index of a cell.
    #[inline]
    pub fn cell(&self, column: usize, row: usize) -> usize {
        row * self.cells()[0] + column
    }

    /// Column and row of a cell.
    #[inline]
    pub fn place_of_cell(&self, cell: usize) -> [usize; 2] {
        let across = self.cells()[0].max(1);
        [cell % across, cell / across]
    }

    /// x of a column.
    #[inline]
    pub fn x(&self, column: usize) -> f64 {
        let ([origin, _], [spacing, _]) = (self.origin, self.spacing);
        origin + column as f64 * spacing
    }

    /// y of a row.
    #[inline]
    pub fn y(&self, row: usize) -> f64 {
        let ([_, origin], [_, spacing]) = (self.origin, self.spacing);
        origin + row as f64 * spacing
    }

    /// Column and row of each corner of a triangle, counter-clockwise seen from +z.
    ///
    /// # Examples
    /// ```
    /// use hullmap_format::height_field::layout::{Diagonal, Layout};
    ///
    /// let diagonal = Diagonal::Rising;
    /// let layout = Layout { columns: 3, rows: 2, origin: [0.0; 2], spacing: [1.0; 2], diagonal };
    /// assert_eq!(layout.corners(2), [[1, 0], [2, 0], [2, 1]]);
    /// assert_eq!(layout.neighbours(2), [None, None, Some(3)]);
    /// assert_eq!(layout.neighbours(1), [Some(0), None, None]);
    /// ```
    #[inline]
    pub fn corners(&self, triangle: usize) -> [[usize; 2]; 3] {
        let [column, row] = self.place_of_cell(triangle / 2);
        self.diagonal.corners(triangle % 2 == 1).map(|[dx, dy]| [column + dx as usize, row + dy as usize])
    }

    /// The triangle beyond each edge of a triangle, from corner i to the next one; `None` at the
    /// border of the grid. It may be in a hole.
    pub fn neighbours(&self, triangle: usize) -> [Option<usize>; 3] {
        let [column, row] = self.place_of_cell(triangle / 2);
        let [across, along] = self.cells();
        let is_second = triangle % 2 == 1;
        self.diagonal.steps(is_second).map(|[dx, dy]| {
            let column = column.checked_add_signed(dx as isize).filter(|column| *column < across)?;
            let row = row.checked_add_signed(dy as isize).filter(|row| *row < along)?;
            Some(2 * self.cell(column, row) + usize::from(!is_second))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_share_the_edge_and_name_each_other() {
        for diagonal in Diagonal::ALL {
            let layout = Layout { columns: 5, rows: 4, origin: [0.0; 2], spacing: [1.0; 2], diagonal };
            let mut borders = 0;
            for triangle in 0..layout.triangle_count() {
                let corners = layout.corners(triangle);
                let [[ax, ay], [bx, by], [cx, cy]] = corners.map(|corner| corner.map(|c| c as i64));
                assert_eq!((bx - ax) * (cy - ay) - (by - ay) * (cx - ax), 1, "counter-clockwise");
                for (edge, neighbour) in layout.neighbours(triangle).into_iter().enumerate() {
                    let Some(neighbour) = neighbour else {
                        borders += 1;
                        continue;
                    };
                    let back = layout.neighbours(neighbour).iter().position(|n| *n == Some(triangle)).unwrap();
                    let other = layout.corners(neighbour);
                    let ends = [corners[edge], corners[(edge + 1) % 3]];
                    assert_eq!([other[(back + 1) % 3], other[back]], ends, "{diagonal} {triangle} {neighbour}");
                }
            }
            assert_eq!(borders, 2 * (4 + 3));
        }
    }
}
