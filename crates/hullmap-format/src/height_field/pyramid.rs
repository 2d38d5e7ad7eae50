//! The tree over the cells of a height field, without pointers.
//!
//! Node 0 is the root; the children of node i are nodes 2 i + 1 and 2 i + 2. Each level divides one
//! axis in two: the one along which nodes have more cells, or x if both are equal. So first the
//! longer axis is divided, then x and y take turns. The binary digits of a node's position in its
//! level give its positions p along x and q along y. If d levels divide x, its columns are ⌊p n /
//! 2ᵈ⌋ to ⌊(p + 1) n / 2ᵈ⌋ of n columns.
//!
//! *Blocks* are the nodes of the first level of at most 2 × 2 cells. Below, a block is divided into
//! rows, a row into cells, and a cell into its two triangles.
//!
//! Height ranges are stored down to the first level in which no node has more than 4 × 4 cells: see
//! [`ranges`](super::ranges). That is at most two levels above the blocks.

/// Cells along x or y that a stored node has at most.
const STORED: usize = 4;

/// Cells along x or y that a block has at most.
const BLOCK: usize = 2;

/// The divisions of a grid of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pyramid {
    cells: [usize; 2],
    blocks: u32,
    /// Last level with stored ranges.
    stored: u32,
    /// Number of levels, from the first, that divide the same axis.
    lead: u32,
    /// Whether that axis is y.
    is_tall: bool,
}

/// Cells or triangle below a node of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// At least one cell: a rectangle of them.
    Cells(Cells),
    /// A triangle, by its index.
    Triangle(usize),
}

/// A rectangle of cells: the first column and the one after the last, and likewise for rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Columns.
    pub columns: [usize; 2],
    /// Rows.
    pub rows: [usize; 2],
}

impl Pyramid {
    /// The tree over a grid with these numbers of cells along x and y.
    pub fn new(cells: [usize; 2]) -> Self {
        let [across, along] = cells.map(|count| count.max(1));
        let (mut x, mut y) = (0_u32, 0_u32);
        let mut this = Self { cells: [across, along], blocks: 0, stored: 0, lead: 0, is_tall: across < along };
        let is_within = |limit: usize, x: u32, y: u32| across <= limit << x && along <= limit << y;
        while !is_within(BLOCK, x, y) {
            if !is_within(STORED, x, y) {
                this.stored += 1;
            }
            // Cells along x and y of a node, multiplied by the same number.
            let is_y = across << y < along << x;
            if is_y == this.is_tall && this.lead == this.blocks {
                this.lead += 1;
            }
            if is_y {
                y += 1;
            } else {
                x += 1;
            }
            this.blocks += 1;
        }
        this
    }

    /// Number of nodes with a stored range, which come first.
    pub fn stored_count(&self) -> usize {
        (2_usize << self.stored) - 1
    }

    /// Number of the first node of the last level with stored ranges.
    pub fn last_stored_level(&self) -> usize {
        (1_usize << self.stored) - 1
    }

    /// Upper bound of the node numbers.
    pub fn node_bound(&self) -> usize {
        // Three levels below the blocks.
        (2_usize << (self.blocks + 3)) - 1
    }

    /// The first of two children of a node; the second is the next node.
    #[inline]
    pub fn first_child(node: u32) -> u32 {
        node.saturating_mul(2).saturating_add(1)
    }

    /// Extent of a node; `None` if the tree has no such node.
    #[inline]
    pub fn extent(&self, node: u32) -> Option<Extent> {
        let at = node.checked_add(1)?;
        let level = at.ilog2();
        let position = at - (1 << level);
        match level.checked_sub(self.blocks) {
            None | Some(0) => Some(Extent::Cells(self.cells(level, position))),
            Some(below) => self.within_block(self.cells(self.blocks, position >> below), below, position),
        }
    }

    /// The last level with stored ranges.
    pub fn stored_level(&self) -> u32 {
        self.stored
    }

    /// Numbers of levels that divide x and y, down to a level that is not below the blocks.
    #[inline]
    pub fn divisions(&self, level: u32) -> [u32; 2] {
        let lead = self.lead.min(level);
        let [x, y] = self.turns(level - lead);
        if self.is_tall { [x, y + lead] } else { [x + lead, y] }
    }

    /// Numbers of the `turns` levels after the lead that divide x and y. x comes first, unless the
    /// lead was along x and y is now the longer axis.
    #[inline]
    fn turns(&self, turns: u32) -> [u32; 2] {
        let x = if self.is_tall { turns.div_ceil(2) } else { turns / 2 };
        [x, turns - x]
    }

    /// Number of the node of a level at these positions along x and y, each of which is below 2 to
    /// the power of its [divisions](Self::divisions). The level is not below the blocks.
    #[inline]
    pub fn node_at(&self, level: u32, [x, y]: [u32; 2]) -> u32 {
        let lead = self.lead.min(level);
        let turns = level - lead;
        let [x_turns, y_turns] = self.turns(turns);
        let first = if self.is_tall { y >> y_turns } else { x >> x_turns };
        let [x, y] = [(x, x_turns), (y, y_turns)].map(|(at, turns)| spread(at & ((1 << turns) - 1)));
        let rest = if self.x_is_odd(turns) { x << 1 | y } else { y << 1 | x };
        (1 << level) - 1 + (first << turns | rest)
    }

    /// Whether the odd digits of a position are its digits for x.
    #[inline]
    fn x_is_odd(&self, turns: u32) -> bool {
        turns.is_multiple_of(2) == self.is_tall
    }

    #[inline]
    fn cells(&self, level: u32, position: u32) -> Cells {
        let lead = self.lead.min(level);
        let turns = level - lead;
        let (first, rest) = (position >> turns, position & ((1 << turns) - 1));
        let (odd, even) = (every_second(rest >> 1), every_second(rest));
        let (x, y) = if self.x_is_odd(turns) { (odd, even) } else { (even, odd) };
        let [x_turns, y_turns] = self.turns(turns);
        let [x, y] = if self.is_tall { [x, first << y_turns | y] } else { [first << x_turns | x, y] };
        let ([across, along], [x_levels, y_levels]) = (self.cells, self.divisions(level));
        Cells { columns: share(across, x_levels, x), rows: share(along, y_levels, y) }
    }

    /// Extent of a node, `below` levels below a block. The last digits of its position are its
    /// path.
    #[inline]
    fn within_block(&self, block: Cells, below: u32, position: u32) -> Option<Extent> {
        let Cells { columns: [left, right], rows: [bottom, top] } = block;
        let (across, along) = (right - left, top - bottom);
        let triangles = 2 * across * along;
        // The number of triangles is 2, 4 or 8.
        let own = triangles >> below;
        let start = (position as usize & ((1 << below) - 1)) * own;
        if own == 0 || own << below != triangles {
            return None;
        }
        let cell = start / 2;
        let (column, row) = (left + cell % across, bottom + cell / across);
        Some(match own {
            1 => {
                let [width, _] = self.cells;
                Extent::Triangle(2 * (row * width + column) + start % 2)
            }
            2 => Extent::Cells(Cells { columns: [column, column + 1], rows: [row, row + 1] }),
            _ => Extent::Cells(Cells { columns: [left, right], rows: [row, row + 1] }),
        })
    }
}

/// The part `position` of `count` cells that are divided in two `levels` times: the first cell, and
/// the one after the last.
#[inline]
pub fn share(count: usize, levels: u32, position: u32) -> [usize; 2] {
    // At most 2²⁷ cells and positions: no overflow.
    [0, 1].map(|next| (((u64::from(position) + next) * count as u64) >> levels) as usize)
}

/// The position of a cell among the parts of `count` cells, at least one, that are divided in two
/// `levels` times: the inverse of [`share`].
#[inline]
pub fn position_of(cell: usize, count: usize, levels: u32) -> u32 {
    // The greatest p for which ⌊p n / 2ᵈ⌋ is at most the cell.
    ((((cell as u64 + 1) << levels) - 1) / count.max(1) as u64) as u32
}

/// Every second binary digit of a number, from the lowest on.
#[inline]
fn every_second(number: u32) -> u32 {
    let mut n = number & 0x5555_5555;
    n = (n | n >> 1) & 0x3333_3333;
    n = (n | n >> 2) & 0x0f0f_0f0f;
    n = (n | n >> 4) & 0x00ff_00ff;
    (n | n >> 8) & 0x0000_ffff
}

/// The number whose [`every_second`] digit gives this one, which has at most 16 digits.
#[inline]
fn spread(number: u32) -> u32 {
    let mut n = number & 0x0000_ffff;
    n = (n | n << 8) & 0x00ff_00ff;
    n = (n | n << 4) & 0x0f0f_0f0f;
    n = (n | n << 2) & 0x3333_3333;
    (n | n << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    fn descend(pyramid: &Pyramid, node: u32, level: u32, seen: &mut [bool], depth: &mut u32) -> Option<Cells> {
        *depth = (*depth).max(level);
        assert!((node as usize) < pyramid.node_bound());
        match pyramid.extent(node).unwrap() {
            Extent::Triangle(triangle) => {
                assert!(!std::mem::replace(&mut seen[triangle], true), "triangle {triangle} twice");
                let (cell, [across, _]) = (triangle / 2, pyramid.cells);
                let (column, row) = (cell % across, cell / across);
                Some(Cells { columns: [column, column + 1], rows: [row, row + 1] })
            }
            Extent::Cells(cells) => {
                let child = Pyramid::first_child(node);
                let of = [child, child + 1].map(|child| descend(pyramid, child, level + 1, seen, depth).unwrap());
                let around = Cells {
                    columns: [of[0].columns[0].min(of[1].columns[0]), of[0].columns[1].max(of[1].columns[1])],
                    rows: [of[0].rows[0].min(of[1].rows[0]), of[0].rows[1].max(of[1].rows[1])],
                };
                assert_eq!(around, cells, "node {node}");
                let size = [cells.columns, cells.rows].map(|[start, end]| end - start);
                if (node as usize) >= pyramid.stored_count() {
                    assert!(size.iter().all(|size| *size <= STORED), "{size:?}");
                }
                Some(cells)
            }
        }
    }

    #[test]
    fn every_triangle_is_a_leaf_once() {
        let sizes = (1..20).flat_map(|x| (1..20).map(move |y| [x, y]));
        let more = [[1, 500], [500, 1], [3, 777], [1000, 7], [64, 64], [65, 63], [127, 129], [255, 16]];
        for cells in sizes.chain(more) {
            let pyramid = Pyramid::new(cells);
            let mut seen = vec![false; 2 * cells[0] * cells[1]];
            let mut depth = 0;
            let root = descend(&pyramid, 0, 0, &mut seen, &mut depth);
            assert_eq!(root, Some(Cells { columns: [0, cells[0]], rows: [0, cells[1]] }));
            assert!(seen.iter().all(|seen| *seen), "{cells:?}");
            assert!(depth <= (seen.len() as u32).next_power_of_two().ilog2() + 2, "{cells:?} {depth}");
        }
    }

    #[test]
    fn nodes_are_found_by_their_cells() {
        let sizes = (1..20).flat_map(|x| (1..20).map(move |y| [x, y]));
        for cells in sizes.chain([[3, 777], [1000, 7], [64, 64], [65, 63], [255, 16]]) {
            let pyramid = Pyramid::new(cells);
            for node in 0..pyramid.stored_count() as u32 {
                let level = (node + 1).ilog2();
                let Some(Extent::Cells(Cells { columns, rows })) = pyramid.extent(node) else { panic!("{node}") };
                let [x, y] = pyramid.divisions(level);
                for (column, row) in [(columns[0], rows[0]), (columns[1] - 1, rows[1] - 1)] {
                    let at = [position_of(column, cells[0], x), position_of(row, cells[1], y)];
                    assert_eq!(pyramid.node_at(level, at), node, "{cells:?}");
                    assert_eq!((share(cells[0], x, at[0]), share(cells[1], y, at[1])), (columns, rows));
                }
            }
        }
    }

    #[test]
    fn the_largest_trees_are_not_too_deep() {
        for cells in [[1 << 27, 1], [1, 1 << 27], [11585, 11585], [1 << 14, 1 << 13], [3, 44_739_242]] {
            let pyramid = Pyramid::new(cells);
            assert!(pyramid.node_bound() < 1 << 31 && pyramid.blocks + 4 <= crate::bvh::MAX_LEVELS, "{pyramid:?}");
            // At most half a node for each cell.
            assert!(pyramid.stored_count() < 5 + cells[0] * cells[1] * 2 / 3, "{pyramid:?}");
        }
    }
}
