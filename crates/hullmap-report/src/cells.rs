//! The cells of a direction index, as lines on the faces of the cube (the paper's Figures 4 and 5).
//!
//! On a face of the cube, with coordinates (u, v), a plane through the origin and a step of a fan
//! are straight lines. So every cell is a convex polygon, and its borders are exact:
//!
//! 1. Start with the six whole faces. A cube map is a grid.
//! 2. A branch cuts its square into squares. Neighbours with the same slot are one cell.
//! 3. A plane cuts a polygon in two, a bundle in eight, a fan at each step with another slot.
//! 4. Cells are processed breadth first, so that the limit on lines drops the deepest ones.

use std::collections::VecDeque;

use hullmap_format::{
    IndexKind,
    cube::{self, GRID_BITS},
    fan,
    node::{Node, Words},
    slot::{BUNDLE_PLANES, Slot},
};

use crate::index_reader::IndexReader;

/// Maximum lines of one hull on a page: 9 bytes each, and more than a screen can show.
pub const MAX_LINES: usize = 30_000;

/// Cells narrower than this, in units of u and v, are not divided further in the drawing: a
/// sixty-fourth of a pixel if a face is 500 pixels wide, below what zooming shows.
const NARROWEST: f64 = 2.0 / 32_000.0;

/// A fan's cell is cut into sectors of at most a quarter turn, which are convex.
const MAX_SECTOR: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub face: u32,
    /// The ends, at (u, v) ∈ [−1, 1]².
    pub ends: [[f64; 2]; 2],
    /// Number of nodes above the node that draws it.
    pub depth: u32,
}

#[derive(Clone, Debug, Default)]
pub struct Cells {
    pub lines: Vec<Line>,
    /// Whether lines were dropped.
    pub is_cut: bool,
}

/// Complexity: O(words · squares of one branch that share a node), bounded by [`MAX_LINES`].
pub fn cells(index: &IndexReader) -> Cells {
    let mut drawing = Drawing { index, cells: Cells::default(), pending: VecDeque::new() };
    match index.kind {
        IndexKind::None => {}
        IndexKind::CubeMap { resolution } => drawing.grid(resolution),
        IndexKind::Binary | IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => drawing.tree(),
    }
    drawing.cells
}

fn is_leaf(slot: Slot) -> bool {
    matches!(slot, Slot::Block(_) | Slot::List(_))
}

struct Pending {
    slot: Slot,
    face: u32,
    depth: u32,
    /// Its corners: a convex polygon, counter-clockwise or clockwise.
    outline: Vec<[f64; 2]>,
    /// Lower grid coordinates, and the number of bits left in each; unused below planes.
    corner: [u32; 2],
    bits_left: [u32; 2],
}

struct Drawing<'a> {
    index: &'a IndexReader,
    cells: Cells,
    pending: VecDeque<Pending>,
}

impl Drawing<'_> {
    fn grid(&mut self, resolution: u32) {
        // With too many lines, only every nth is drawn.
        let skip = (12 * resolution as usize).div_ceil(MAX_LINES).max(1);
        self.cells.is_cut = skip > 1;
        for face in 0..6 {
            for step in (0..=resolution).step_by(skip) {
                let at = edge(cube::uniform_step_start(step, resolution));
                self.line(face, [[at, -1.0], [at, 1.0]], 0);
                self.line(face, [[-1.0, at], [1.0, at]], 0);
            }
        }
    }

    fn tree(&mut self) {
        for face in 0..6 {
            let outline = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            for i in 0..4 {
                self.line(face, [outline[i], outline[(i + 1) % 4]], 0);
            }
            let slot = self.index.slot(face as usize);
            let bits_left = [GRID_BITS; 2];
            self.pending.push_back(Pending { slot, face, depth: 0, outline, corner: [0; 2], bits_left });
        }
        while let Some(cell) = self.pending.pop_front() {
            if self.cells.lines.len() >= MAX_LINES {
                self.cells.is_cut |= !is_leaf(cell.slot);
                continue;
            }
            let Some(node) = self.index.node(cell.slot) else { continue };
            let slots = self.index.slots(node);
            match node {
                Node::Halves { .. } => self.halves(&cell, slots),
                Node::Squares { bits, .. } => self.squares(&cell, bits, slots),
                Node::Plane { at } => self.plane(&cell, at, slots),
                Node::Bundle { at } => self.bundle(&cell, at, slots),
                Node::Fan { at, .. } => self.fan(&cell, at, slots),
                Node::List { .. } => {}
            }
        }
    }

    fn halves(&mut self, cell: &Pending, slots: &[u32]) {
        let axis = cell.depth as usize % 2;
        let left = cell.bits_left[axis] - 1;
        let mut bits_left = cell.bits_left;
        bits_left[axis] = left;
        for (half, &slot) in slots.iter().enumerate() {
            let mut corner = cell.corner;
            corner[axis] += (half as u32) << left;
            let outline = rectangle(corner, bits_left.map(|bits| 1 << bits));
            if half == 1 {
                let ends = if axis == 0 { [outline[0], outline[3]] } else { [outline[0], outline[1]] };
                self.line(cell.face, ends, cell.depth);
            }
            let slot = Slot::decode(slot);
            self.push(Pending { slot, face: cell.face, depth: cell.depth + 1, outline, corner, bits_left });
        }
    }

    fn squares(&mut self, cell: &Pending, bits: u32, slots: &[u32]) {
        let (row, side) = (1_u32 << bits, cell.bits_left[0] - bits);
        let word = |u: u32, v: u32| slots[(v * row + u) as usize];
        let place = |u: u32, v: u32| [cell.corner[0] + (u << side), cell.corner[1] + (v << side)];
        // Borders between columns, then between rows, each run as one line.
        for across in 1..row {
            for axis in 0..2 {
                let differ = |along: u32| match axis {
                    0 => word(across - 1, along) != word(across, along),
                    _ => word(along, across - 1) != word(along, across),
                };
                let mut from = None;
                for along in 0..=row {
                    let differs = along < row && differ(along);
                    match (from, differs) {
                        (None, true) => from = Some(along),
                        (Some(start), false) => {
                            let end = |along| if axis == 0 { place(across, along) } else { place(along, across) };
                            self.line(cell.face, [end(start), end(along)].map(|[u, v]| [edge(u), edge(v)]), cell.depth);
                            from = None;
                        }
                        _ => {}
                    }
                }
            }
        }
        for v in 0..row {
            let mut u = 0;
            while u < row {
                let same = (u..row).take_while(|&next| word(next, v) == word(u, v)).count() as u32;
                let corner = place(u, v);
                self.push(Pending {
                    slot: Slot::decode(word(u, v)),
                    face: cell.face,
                    depth: cell.depth + 1,
                    outline: rectangle(corner, [same << side, 1 << side]),
                    corner,
                    bits_left: [side; 2],
                });
                u += same;
            }
        }
    }

    /// Cuts a cell by the plane at `at`, whose slots are behind and in front.
    fn plane(&mut self, cell: &Pending, at: usize, slots: &[u32]) {
        let height = on_face(cell.face, self.index.words[..].normal(at, 1, 0));
        let sides = cut(&cell.outline, height);
        if slots.first() != slots.last() {
            self.chord(cell.face, &sides[0], height, cell.depth);
        }
        for (outline, &slot) in sides.into_iter().zip(slots) {
            self.below_planes(Slot::decode(slot), cell.face, cell.depth + 1, outline);
        }
    }

    fn bundle(&mut self, cell: &Pending, at: usize, slots: &[u32]) {
        let mut parts = vec![cell.outline.clone()];
        for level in 0..3 {
            let (first, share) = ((1 << level) - 1, 8 >> level);
            let mut halves = Vec::new();
            for (i, outline) in parts.iter().enumerate() {
                let height = on_face(cell.face, self.index.words[..].normal(at, BUNDLE_PLANES, first + i));
                let sides = cut(outline, height);
                let below = &slots[i * share..(i + 1) * share];
                if below[..share / 2] != below[share / 2..] {
                    self.chord(cell.face, &sides[0], height, cell.depth);
                }
                halves.extend(sides);
            }
            parts = halves;
        }
        for (outline, &slot) in parts.into_iter().zip(slots) {
            self.below_planes(Slot::decode(slot), cell.face, cell.depth + 1, outline);
        }
    }

    fn fan(&mut self, cell: &Pending, at: usize, slots: &[u32]) {
        let step_count = slots.len();
        let [x, y] =
            [fan::X_AXIS, fan::Y_AXIS].map(|axis| on_face(cell.face, self.index.words[..].node_vector(at, axis)));
        let [start, rate] = [fan::START, fan::RATE].map(|index| self.index.words[..].node_number(at, index));
        let word = |step: usize| slots[step];
        // The first step starts at the minimum angle, the last ends at the maximum: a full turn.
        let (first_angle, last_angle) = (-1.0, fan::TURN - 1.0);
        if slots.first() != slots.last() {
            self.ray(cell, x, y, first_angle);
        }
        let mut step = 0;
        let mut from = first_angle;
        while step < step_count {
            let same = (step..step_count).take_while(|&next| word(next) == word(step)).count();
            let slot = Slot::decode(word(step));
            step += same;
            let to = if step < step_count { start + step as f64 / rate } else { last_angle };
            let to = to.clamp(from, last_angle);
            if step < step_count && to > first_angle && to < last_angle {
                self.ray(cell, x, y, to);
            }
            if !is_leaf(slot) {
                let pieces = ((to - from) / MAX_SECTOR).ceil().max(1.0);
                for piece in 0..pieces as u32 {
                    let end = |piece: f64| from + (to - from) * piece / pieces;
                    let (low, high) = (beside(x, y, end(f64::from(piece))), beside(x, y, end(f64::from(piece) + 1.0)));
                    let [_, left] = cut(&cell.outline, low);
                    let [outline, _] = cut(&left, high);
                    self.below_planes(slot, cell.face, cell.depth + 1, outline);
                }
            }
            from = to;
        }
    }

    fn ray(&mut self, cell: &Pending, x: Linear, y: Linear, angle: f64) {
        let [along_x, along_y] = square_point(angle);
        let ahead = Linear::blend(x, along_x, y, along_y);
        let [_, front] = cut(&cell.outline, ahead);
        let side = beside(x, y, angle);
        let [left, _] = cut(&front, side);
        self.chord(cell.face, &left, side, cell.depth);
    }

    fn below_planes(&mut self, slot: Slot, face: u32, depth: u32, outline: Vec<[f64; 2]>) {
        self.push(Pending { slot, face, depth, outline, corner: [0; 2], bits_left: [0; 2] });
    }

    fn push(&mut self, cell: Pending) {
        let extent = |axis: usize| {
            let of = cell.outline.iter().map(|corner| corner[axis]);
            of.clone().fold(f64::NEG_INFINITY, f64::max) - of.fold(f64::INFINITY, f64::min)
        };
        // NaN, of an outline without corners, takes the failing branch.
        if !is_leaf(cell.slot) && cell.outline.len() > 2 && extent(0).max(extent(1)) > NARROWEST {
            self.pending.push_back(cell);
        }
    }

    /// Draws the edge of an outline that lies where `height` is zero.
    fn chord(&mut self, face: u32, outline: &[[f64; 2]], height: Linear, depth: u32) {
        let size = height.c.abs() + height.u.abs() + height.v.abs();
        let is_on = |point: [f64; 2]| height.value(point).abs() <= ON_LINE * size;
        let on: Vec<[f64; 2]> = outline.iter().copied().filter(|&point| is_on(point)).collect();
        if let (Some(&from), Some(&to)) = (on.first(), on.last()) {
            // If corners coincide there are more than two: the ends are the two farthest apart.
            let far =
                on.iter().copied().fold(to, |far, point| if gap(from, point) > gap(from, far) { point } else { far });
            self.line(face, [from, far], depth);
        }
    }

    fn line(&mut self, face: u32, ends: [[f64; 2]; 2], depth: u32) {
        let ends = ends.map(|end| end.map(|x| x.clamp(-1.0, 1.0)));
        if gap(ends[0], ends[1]) <= NARROWEST * NARROWEST {
            return;
        }
        if self.cells.lines.len() < MAX_LINES {
            self.cells.lines.push(Line { face, ends, depth });
        } else {
            self.cells.is_cut = true;
        }
    }
}

/// Tolerance relative to a line's coefficients: some rounding errors of f64.
const ON_LINE: f64 = 1e-13;

/// A linear function on a face: c + u·x + v·y at the point (x, y).
#[derive(Clone, Copy, Debug)]
struct Linear {
    c: f64,
    u: f64,
    v: f64,
}

impl Linear {
    fn value(self, [x, y]: [f64; 2]) -> f64 {
        self.c + self.u * x + self.v * y
    }

    fn blend(a: Self, by: f64, b: Self, and: f64) -> Self {
        Self { c: a.c * by + b.c * and, u: a.u * by + b.u * and, v: a.v * by + b.v * and }
    }
}

fn on_face(face: u32, normal: [f64; 3]) -> Linear {
    let axis = (face / 2) as usize;
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    Linear { c: normal[axis] * sign, u: normal[(axis + 1) % 3], v: normal[(axis + 2) % 3] }
}

fn square_point(angle: f64) -> [f64; 2] {
    match angle {
        _ if angle < 1.0 => [1.0, angle],
        _ if angle < 3.0 => [2.0 - angle, 1.0],
        _ if angle < 5.0 => [-1.0, 4.0 - angle],
        _ => [angle - 6.0, -1.0],
    }
}

/// Positive on the left of the ray at this angle: towards larger angles, within half a turn.
fn beside(x: Linear, y: Linear, angle: f64) -> Linear {
    let [along_x, along_y] = square_point(angle);
    Linear::blend(y, along_x, x, -along_y)
}

fn cut(outline: &[[f64; 2]], height: Linear) -> [Vec<[f64; 2]>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for (i, &from) in outline.iter().enumerate() {
        let to = outline[(i + 1) % outline.len()];
        let (a, b) = (height.value(from), height.value(to));
        if a <= 0.0 {
            parts[0].push(from);
        }
        if a >= 0.0 {
            parts[1].push(from);
        }
        if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
            let share = a / (a - b);
            let middle = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
            parts[0].push(middle);
            parts[1].push(middle);
        }
    }
    parts
}

fn gap(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// Lower edge of a grid cell on the face; for the index after the last cell, its upper edge.
fn edge(grid: u32) -> f64 {
    cube::grid_to_uv(grid).clamp(-1.0, 1.0)
}

fn rectangle(corner: [u32; 2], size: [u32; 2]) -> Vec<[f64; 2]> {
    let [low_u, low_v] = corner.map(edge);
    let [high_u, high_v] = [0, 1].map(|axis| edge(corner[axis] + size[axis]));
    vec![[low_u, low_v], [high_u, low_v], [high_u, high_v], [low_u, high_v]]
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::test_packs::{KINDS, baked, cloud};

    fn crosses(a: [f64; 2], b: [f64; 2], [c, d]: [[f64; 2]; 2]) -> bool {
        let side =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0;
        side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
    }

    /// The leaves of the directions are found without the drawing.
    #[test]
    fn lines_separate_leaves() {
        for kind in KINDS {
            let (_, contents) = baked(cloud(300), kind);
            let index = &contents.indices[0];
            let cells = cells(index);
            assert!(!cells.is_cut);
            let mut random = SplitMix64::new(3);
            let (mut separated, mut crossed) = (0, 0);
            for _ in 0..12_000 {
                let face = random.below(6) as u32;
                let from = [0, 1].map(|_| random.between(-0.97, 0.97));
                let to = from.map(|x| x + random.between(-0.03, 0.03));
                let leaf = |[u, v]: [f64; 2]| index.leaf(cube::direction(face, u, v).map(|c| c as f32));
                let on_face = cells.lines.iter().filter(|line| line.face == face);
                let is_crossed = on_face.clone().any(|line| crosses(from, to, line.ends));
                if leaf(from) != leaf(to) {
                    separated += 1;
                    assert!(is_crossed, "{kind:?}: {face} {from:?} {to:?}");
                }
                crossed += usize::from(is_crossed);
            }
            let is_indexed = kind != IndexKind::None;
            assert_eq!(separated > 100, is_indexed, "{kind:?}: {separated}");
            assert!(crossed <= 2 * separated, "{kind:?}: {crossed} crossed, {separated} separated");
        }
    }

    #[test]
    fn the_sample_has_every_kind_of_node() {
        let (_, contents) = baked(cloud(300), IndexKind::Tree);
        let index = &contents.indices[0];
        let mut kinds = [false; 4];
        let drawn = |word: &u32| match Slot::decode(*word) {
            Slot::Branch(_) => Some(0),
            Slot::Plane(_) => Some(1),
            Slot::Bundle(_) => Some(2),
            Slot::Fan(_) => Some(3),
            _ => None,
        };
        // Plane coordinates would be misread as slots, but roots and branches come first.
        for kind in index.words.iter().take(2000).filter_map(drawn) {
            kinds[kind] = true;
        }
        assert!(kinds[0] && (kinds[1] || kinds[2]) && kinds[3], "{kinds:?}");
    }

    #[test]
    fn too_many_lines_are_dropped_and_reported() {
        let (_, contents) = baked(cloud(300), IndexKind::CubeMap { resolution: 900 });
        assert!(!cells(&contents.indices[0]).is_cut);
        let (_, contents) = baked(cloud(40_000), IndexKind::Tree);
        let cells = cells(&contents.indices[0]);
        assert!(cells.lines.len() <= MAX_LINES);
        assert_eq!(cells.is_cut, cells.lines.len() == MAX_LINES);
    }

    #[test]
    fn angles_match_fans() {
        for step in -9..70 {
            let angle = f64::from(step) / 10.0;
            let [x, y] = square_point(angle);
            assert!((fan::angle(x, y) - angle).abs() < 1e-12, "{angle}");
        }
    }
}
