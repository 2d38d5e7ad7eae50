//! Follows all arcs through the nodes of an index, down to its leaves.
//!
//! - A grid (the squares of a branch, two halves, or the cells of a cube map) hands each arc to the
//!   cells that it crosses. Neighbouring cells with the same slot are one cell.
//! - A plane clips the arcs and the region to each of its sides.
//! - A fan is halved between its steps until one slot is left. Steps with the same slot, side by
//!   side, are one step.

use glam::DVec3;
use hullmap_format::{
    IndexKind,
    cube::{self, GRID_BITS},
    fan,
    node::{Node, Words},
    slot::{BUNDLE_PLANES, Slot},
};

use super::arcs::Piece;
use super::certifier::Certifier;
use super::proof::Proof;
use super::region::{Cell, Line, Margin, Turn, cube_slack};
use crate::error::Unproven;

/// Range of squared lengths of unit vectors, which the margins of [`super::region`] allow.
const UNIT_SQ: std::ops::RangeInclusive<f64> = 0.999..=1.001;

/// Angles that a wedge of a fan may cover to be treated as convex: less than half a turn.
const CONVEX: f64 = 0.45 * fan::TURN;

/// Where a wedge that is too wide is cut: off the middle, where symmetric hulls have borders.
const CUT: f64 = 0.414;

#[derive(Clone, Copy)]
struct Square {
    face: u32,
    /// Lower grid indices.
    at: [u32; 2],
    /// Number of grid cells.
    size: [u32; 2],
    /// The axis that a binary tree halves next.
    axis: usize,
}

impl Square {
    /// Its division into 2ᵇ columns and 2ᵇ rows. The first cell's slot is the word `first`.
    fn grid(self, bits: [u32; 2], first: usize) -> Grid {
        let borders = [0, 1].map(|axis| {
            let step = self.size[axis] >> bits[axis];
            (0..=1 << bits[axis]).map(|index| self.at[axis] + step * index).collect()
        });
        Grid { face: self.face, borders, first, axis: 1 - self.axis }
    }
}

/// A division of a square into cells, row by row.
struct Grid {
    face: u32,
    borders: [Vec<u32>; 2],
    /// Word of the first cell's slot.
    first: usize,
    axis: usize,
}

struct Run {
    slot: usize,
    square: Square,
    cell: Cell,
    pieces: Vec<Piece>,
    /// Index of the arc handed to it last.
    last: u32,
}

/// Steps of a fan with the same slot, side by side: a range of angles.
#[derive(Clone, Copy)]
struct Wedge {
    slot: usize,
    from: f64,
    to: f64,
    /// Whether the same slot continues before it, and after it.
    continues: [bool; 2],
    /// The angles of all steps with this slot, of which this may be a part.
    whole: [f64; 2],
}

/// The axes of a fan's frame, on a face of the cube.
struct Frame {
    /// First word of the node.
    at: usize,
    x: DVec3,
    y: DVec3,
}

impl Frame {
    /// The plane through the axis at an angle. Greater angles lie in front, up to half a turn. A
    /// query computes [`fan::angle`], the baker its inverse; comparing both here finds mistakes in
    /// the inverse.
    fn line(&self, face: u32, angle: f64) -> Option<Line> {
        let [x, y] = fan::point(angle);
        let turns = (fan::angle(x, y) - angle) / fan::TURN;
        let is_inverse = (turns - turns.round()).abs() < 1e-15;
        is_inverse.then(|| Line::new(face, (self.y * x - self.x * y).normalize()))
    }
}

struct Pending {
    slot: usize,
    /// A square of the grid; `None` below planes and fans.
    square: Option<Square>,
    cell: Cell,
    pieces: Vec<Piece>,
}

#[derive(Default)]
pub(super) struct Visits {
    proof: Proof,
    pub work: usize,
    pending: Vec<Pending>,
}

impl<W: Words + Sync + ?Sized> Certifier<'_, W> {
    /// Follows the arcs on a face of the cube from its roots. Slots wait in a list: a recursion
    /// would be as deep as the file allows.
    pub(super) fn descend(&self, face: u32, pieces: Vec<Piece>) -> Result<Proof, Unproven> {
        let visits = &mut Visits::default();
        if let IndexKind::CubeMap { resolution } = self.kind {
            let borders: Vec<u32> = (0..=resolution).map(|step| cube::uniform_step_start(step, resolution)).collect();
            let first = face as usize * (resolution as usize).pow(2);
            self.grid(&Grid { face, borders: [borders.clone(), borders], first, axis: 0 }, &pieces, visits);
        } else {
            let square = Square { face, at: [0; 2], size: [1 << GRID_BITS; 2], axis: 0 };
            let cell = Cell { face, square: widened(square), part: None, turn: None };
            visits.pending.push(Pending { slot: face as usize, square: Some(square), cell, pieces });
        }
        while let Some(next) = visits.pending.pop() {
            visits.work += 1 + next.pieces.len();
            if visits.work > self.work {
                return Err(Unproven::Work);
            }
            self.visit(next, visits)?;
        }
        Ok(visits.proof)
    }

    fn visit(&self, Pending { slot, square, cell, pieces }: Pending, visits: &mut Visits) -> Result<(), Unproven> {
        let run = |first: u32, count: u32| first as usize..first as usize + count as usize;
        match (self.node(slot), square) {
            (None, _) => {
                let Slot::Block(first) = Slot::decode(self.words.word(slot)) else { return Err(Unproven::Work) };
                self.leaf(slot, run(first, self.kind.leaf_blocks()), &cell, &pieces, &mut visits.proof)
            }
            (Some(Node::List { at }), _) => {
                let [first, count] = [0, 1].map(|word| self.words.word(at + word));
                self.leaf(slot, run(first, count), &cell, &pieces, &mut visits.proof)
            }
            (Some(Node::Squares { at, bits }), Some(square)) => {
                self.grid(&square.grid([bits; 2], at), &pieces, visits);
                Ok(())
            }
            (Some(Node::Halves { at }), Some(square)) => {
                let bits = if square.axis == 0 { [1, 0] } else { [0, 1] };
                self.grid(&square.grid(bits, at), &pieces, visits);
                Ok(())
            }
            (Some(node @ Node::Plane { at }), _) => self.planes(node, at, 1, [0, 0], &cell, pieces, visits),
            (Some(node @ Node::Bundle { at }), _) => {
                self.planes(node, at, BUNDLE_PLANES, [0, 0], &cell, pieces, visits)
            }
            (Some(node @ Node::Fan { at, bits }), _) => self.fan(node, at, bits, &cell, pieces, visits),
            // Checked words have no branches below planes and fans.
            (Some(Node::Halves { .. } | Node::Squares { .. }), None) => Err(Unproven::Work),
        }
    }

    fn node(&self, slot: usize) -> Option<Node> {
        Node::below(Slot::decode(self.words.word(slot)), self.kind.branches(), self.words)
    }

    fn grid(&self, grid: &Grid, pieces: &[Piece], visits: &mut Visits) {
        let (mut runs, run_of) = self.runs(grid);
        visits.work += run_of.len();
        hand_out(grid, pieces, &mut runs, &run_of);
        let pending = |Run { slot, square, cell, pieces, .. }| Pending { slot, square: Some(square), cell, pieces };
        visits.pending.extend(runs.into_iter().rev().map(pending));
    }

    /// Rectangles of cells with the same slot, and for each cell its rectangle. A branch divides
    /// one cell only.
    fn runs(&self, grid: &Grid) -> (Vec<Run>, Vec<u32>) {
        const NONE: u32 = u32::MAX;
        let [columns, rows] = grid.borders.each_ref().map(|borders| borders.len() - 1);
        let word = |cell: usize| self.words.word(grid.first + cell);
        let mut runs = Vec::new();
        let mut run_of = vec![NONE; rows * columns];
        for first in 0..rows * columns {
            if run_of[first] != NONE {
                continue;
            }
            let (row, column) = (first / columns, first % columns);
            let (mut right, mut end) = (column + 1, row + 1);
            if Slot::branch(word(first)).is_none() {
                let is_same = |cell: usize| run_of[cell] == NONE && word(cell) == word(first);
                while right < columns && is_same(row * columns + right) {
                    right += 1;
                }
                while end < rows && (column..right).all(|column| is_same(end * columns + column)) {
                    end += 1;
                }
            }
            (row..end).for_each(|row| run_of[row * columns + column..row * columns + right].fill(runs.len() as u32));
            let [at, to] = [[column, row], [right, end]].map(|[u, v]| [grid.borders[0][u], grid.borders[1][v]]);
            let square = Square { face: grid.face, at, size: [to[0] - at[0], to[1] - at[1]], axis: grid.axis };
            let cell = Cell { face: grid.face, square: widened(square), part: None, turn: None };
            runs.push(Run { slot: grid.first + first, square, cell, pieces: Vec::new(), last: NONE });
        }
        (runs, run_of)
    }

    /// Follows the arcs through a node's planes by levels, next the one at `index` of its `level`.
    #[expect(clippy::too_many_arguments, reason = "the node, the place in it, and what is there")]
    fn planes(
        &self,
        node: Node,
        at: usize,
        count: usize,
        [level, index]: [usize; 2],
        cell: &Cell,
        pieces: Vec<Piece>,
        visits: &mut Visits,
    ) -> Result<(), Unproven> {
        let plane = (1 << level) - 1 + index;
        if plane >= count {
            let slot = node.slots().start + index;
            visits.pending.push(Pending { slot, square: None, cell: cell.clone(), pieces });
            return Ok(());
        }
        let normal = DVec3::from_array(self.words.normal(at, count, plane));
        if normal == DVec3::ZERO {
            // An unused plane: every direction is behind it.
            return self.planes(node, at, count, [level + 1, 2 * index], cell, pieces, visits);
        }
        if !UNIT_SQ.contains(&normal.length_squared()) {
            return Err(Unproven::Node { at });
        }
        let front = Line::new(cell.face, normal);
        for (side, line) in [front.reversed(), front].into_iter().enumerate() {
            if let Some((cell, pieces)) = clip(cell, &pieces, line, Margin::PLANE) {
                self.planes(node, at, count, [level + 1, 2 * index + side], &cell, pieces, visits)?;
            }
        }
        Ok(())
    }

    fn fan(
        &self,
        node: Node,
        at: usize,
        bits: u32,
        cell: &Cell,
        pieces: Vec<Piece>,
        visits: &mut Visits,
    ) -> Result<(), Unproven> {
        let [x, y] = [fan::X_AXIS, fan::Y_AXIS].map(|axis| DVec3::from_array(self.words.node_vector(at, axis)));
        let [start, scale] = [fan::START, fan::RATE].map(|index| self.words.node_number(at, index));
        let is_unit = [x, y].iter().all(|axis| UNIT_SQ.contains(&axis.length_squared()));
        if !(is_unit && x.dot(y).abs() < 1e-3 && scale > 0.0) {
            return Err(Unproven::Node { at });
        }
        let frame = Frame { at, x, y };
        // Below a step of a fan with the same axes, a query's angle is one of that step's angles.
        let known = cell.turn.filter(|turn| turn.axes == [x, y]).map(|turn| turn.angles);
        let [low, high] = known.unwrap_or([-1.0, fan::TURN - 1.0]);
        // Directions before the first step or after the last one are located in these.
        let steps = 1 << bits;
        let border = |step: usize| match step {
            0 => low,
            _ if step == steps => high,
            _ => (start + step as f64 / scale).clamp(low, high),
        };
        let mut wedges: Vec<Wedge> = Vec::new();
        for (step, slot) in node.slots().enumerate() {
            let [from, to] = [border(step), border(step + 1)];
            match wedges.last_mut() {
                Some(last) if self.words.word(last.slot) == self.words.word(slot) => {
                    last.to = to;
                    last.whole[1] = to;
                }
                _ => wedges.push(Wedge { slot, from, to, continues: [false; 2], whole: [from, to] }),
            }
        }
        visits.work += steps;
        self.wedges(&frame, &wedges, known.is_some(), cell, pieces, visits)
    }

    /// Follows the arcs through some steps of a fan. `is_clipped` states whether the region has
    /// been clipped to them.
    fn wedges(
        &self,
        frame: &Frame,
        wedges: &[Wedge],
        is_clipped: bool,
        cell: &Cell,
        pieces: Vec<Piece>,
        visits: &mut Visits,
    ) -> Result<(), Unproven> {
        let cut;
        let (left, right) = match wedges {
            [wedge] if is_clipped || wedge.to - wedge.from == fan::TURN => {
                let turn = is_clipped.then_some(Turn { axes: [frame.x, frame.y], angles: wedge.whole });
                let cell = Cell { turn, ..cell.clone() };
                visits.pending.push(Pending { slot: wedge.slot, square: None, cell, pieces });
                return Ok(());
            }
            // Too wide to be convex.
            [wedge] => {
                let middle = wedge.from + CUT * (wedge.to - wedge.from);
                cut = [
                    Wedge { to: middle, continues: [wedge.continues[0], true], ..*wedge },
                    Wedge { from: middle, continues: [true, wedge.continues[1]], ..*wedge },
                ];
                cut.split_at(1)
            }
            _ => wedges.split_at(wedges.len() / 2),
        };
        for (half, side) in [left, right].into_iter().zip([1, 0]) {
            let [Some(first), Some(last)] = [half.first(), half.last()] else { continue };
            let line = |angle: f64| frame.line(cell.face, angle).ok_or(Unproven::Node { at: frame.at });
            let borders = [line(first.from)?, line(last.to)?.reversed()];
            let margin = |continues: bool| if continues { Margin::NONE } else { Margin::STEP };
            let margins = [margin(first.continues[0]), margin(last.continues[1])];
            let is_convex = last.to - first.from < CONVEX;
            let clipped = if is_clipped {
                clip(cell, &pieces, borders[side], margins[side])
            } else if is_convex {
                clip(cell, &pieces, borders[0], margins[0])
                    .and_then(|(cell, pieces)| clip(&cell, &pieces, borders[1], margins[1]))
            } else {
                Some((cell.clone(), pieces.clone()))
            };
            if let Some((cell, pieces)) = clipped {
                self.wedges(frame, half, is_clipped || is_convex, &cell, pieces, visits)?;
            }
        }
        Ok(())
    }
}

/// The region in front of a plane, with the arcs in it; `None` if no direction leads there.
fn clip(cell: &Cell, pieces: &[Piece], line: Line, margin: Margin) -> Option<(Cell, Vec<Piece>)> {
    let part = cell.to_part().clip(line, margin)?;
    let pieces = pieces.iter().filter_map(|piece| piece.clip(|p| line.height(p) - margin.core())).collect();
    Some((Cell { part: Some(part), ..*cell }, pieces))
}

/// The corners of a square, widened so that it contains every direction located in it.
fn widened(square: Square) -> [[f64; 2]; 2] {
    let border = 1.0 + cube_slack();
    let low = square.at.map(|at| (cube::grid_to_uv(at) - cube_slack()).max(-border));
    let high = [0, 1].map(|axis| (cube::grid_to_uv(square.at[axis] + square.size[axis]) + cube_slack()).min(border));
    [low, high]
}

fn hand_out(grid: &Grid, pieces: &[Piece], runs: &mut [Run], run_of: &[u32]) {
    let lines = grid.borders.each_ref().map(|all| all.iter().map(|&at| cube::grid_to_uv(at)).collect::<Vec<_>>());
    let columns = lines[0].len() - 1;
    for (index, piece) in (0..).zip(pieces) {
        for row in steps(&lines[1], piece, 1) {
            let (low, high) = (lines[1][row] - cube_slack(), lines[1][row + 1] + cube_slack());
            let Some(part) = piece.clip(|p| p[1] - low).and_then(|part| part.clip(|p| high - p[1])) else { continue };
            for column in steps(&lines[0], &part, 0) {
                let run = &mut runs[run_of[row * columns + column] as usize];
                if run.last != index {
                    run.last = index;
                    run.pieces.extend(clipped_to(run.cell.square, *piece));
                }
            }
        }
    }
}

fn clipped_to([low, high]: [[f64; 2]; 2], piece: Piece) -> Option<Piece> {
    let piece = piece.clip(|p| p[0] - low[0])?.clip(|p| high[0] - p[0])?;
    piece.clip(|p| p[1] - low[1])?.clip(|p| high[1] - p[1])
}

/// Steps between these lines that a piece may cross along an axis, widened by the slack.
fn steps(lines: &[f64], piece: &Piece, axis: usize) -> std::ops::Range<usize> {
    let [p, q] = piece.ends.map(|end| end[axis]);
    let (low, high) = (p.min(q) - cube_slack(), p.max(q) + cube_slack());
    let first = lines.partition_point(|line| *line < low).saturating_sub(1);
    first..lines.partition_point(|line| *line <= high).min(lines.len() - 1)
}
