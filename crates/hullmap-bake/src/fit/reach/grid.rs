//! Cells around a mesh: where a ball's centre may come from outside, and what such a ball reaches.

use glam::DVec3;
use rayon::prelude::*;

use super::distance::squared_distances;
use crate::fit::solid::Solid;

/// Cells along the side of a block, in which cells are settled together where possible.
const BLOCK: usize = 16;

/// Cells added on each side of the mesh's box and the radius, so that the border is passable.
const MARGIN: usize = 2;

/// Room for rounding errors, in cells.
const ROUNDING: f64 = 1e-3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Label {
    /// The centre of a ball may be there.
    Passable,
    /// All points are closer to the solid than the radius.
    Blocked,
    /// All points are inside the solid.
    Inside,
}

pub struct Grid {
    pub size: [usize; 3],
    low: DVec3,
    step: f64,
    radius: f64,
}

/// A box of cells: its first ones, and the ones after its last ones.
type Range = [[usize; 3]; 2];

impl Grid {
    /// A grid around a solid, of at most `count` cells along its longest side. `None` for a solid
    /// or a radius without size.
    pub fn new(solid: &Solid, radius: f64, count: usize) -> Option<Self> {
        let [low, high] = solid.bounds();
        let longest = (high - low).max_element() + 2.0 * radius;
        let step = longest / (count - 2 * MARGIN - 1) as f64;
        // Written so that NaN and infinity give none.
        if !(step > 0.0 && step < f64::from(f32::MAX) && radius > 0.0) {
            return None;
        }
        let cells = ((high - low + 2.0 * radius) / step).ceil();
        let size = cells.to_array().map(|cells| cells as usize + 2 * MARGIN);
        // The middle of the grid is the middle of the box, so that both are symmetric.
        let half = DVec3::from_array(size.map(|cells| 0.5 * step * cells as f64));
        Some(Self { size, low: 0.5 * (low + high) - half, step, radius })
    }

    pub fn position(&self, place: [f64; 3]) -> DVec3 {
        self.low + DVec3::from_array(place) * self.step
    }

    /// For each cell, whether no ball can reach it, and it is not all inside the solid. Cells have
    /// the same indices as in [`squared_distances`].
    pub fn unreachable(&self, solid: &Solid) -> Vec<bool> {
        let labels = self.labels(solid);
        let squares = squared_distances(&self.flooded(&labels), self.size);
        // Between the centres of two cells there are two half diagonals.
        let reach = self.radius / self.step + 3.0_f64.sqrt() + ROUNDING;
        let is_far = |square: &u32| f64::from(*square) > reach * reach;
        squares.iter().zip(labels).map(|(square, label)| is_far(square) && label != Label::Inside).collect()
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    fn labels(&self, solid: &Solid) -> Vec<Label> {
        let blocks = self.size.map(|cells| cells.div_ceil(BLOCK));
        let all = (0..blocks[0] * blocks[1] * blocks[2]).into_par_iter().map(|i| {
            let block = [i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])];
            let from = block.map(|k| k * BLOCK);
            let to = [0, 1, 2].map(|axis| (from[axis] + BLOCK).min(self.size[axis]));
            let mut found = Vec::new();
            self.settle(solid, [from, to], f64::INFINITY, &mut found);
            found
        });
        let mut labels = vec![Label::Passable; self.size.iter().product()];
        for (range, label) in all.collect::<Vec<Vec<(Range, Label)>>>().into_iter().flatten() {
            self.cells(range).for_each(|cell| labels[self.index(cell)] = label);
        }
        labels
    }

    /// Labels the impassable cells of a range whose points are all within `within` of the solid.
    fn settle(&self, solid: &Solid, range: Range, within: f64, found: &mut Vec<(Range, Label)>) {
        let [low, high] = range.map(|corner| self.position(corner.map(|k| k as f64)));
        let (centre, radius) = (0.5 * (low + high), 0.5 * low.distance(high));
        let Some(near) = solid.near_beside(centre, within, None) else { return };
        let is_one_sided = near.gap > radius;
        if is_one_sided && solid.is_inside(centre) {
            return found.push((range, Label::Inside));
        }
        if is_one_sided && near.gap - radius >= self.radius {
            return;
        }
        let [from, to] = range;
        let sides = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let is_blocked = near.distance + radius < self.radius * (1.0 - 1e-9);
        // Cells beside the surface are divided further, since some are inside.
        if is_blocked && (is_one_sided || sides == [1; 3]) {
            return found.push((range, Label::Blocked));
        }
        if sides == [1; 3] {
            return;
        }
        let axis = (0..3).fold(0, |longest, axis| if sides[axis] > sides[longest] { axis } else { longest });
        let middle = from[axis] + sides[axis] / 2;
        let [mut lower, mut upper] = [range; 2];
        lower[1][axis] = middle;
        upper[0][axis] = middle;
        for half in [lower, upper] {
            self.settle(solid, half, near.distance + radius, found);
        }
    }

    fn cells(&self, [from, to]: Range) -> impl Iterator<Item = [usize; 3]> {
        let along = move |axis: usize| from[axis]..to[axis];
        along(2).flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z])))
    }

    /// The passable cells that are connected to the border of the grid by their faces. A path of
    /// the centre that passes an edge or a corner has all cells there passable.
    fn flooded(&self, labels: &[Label]) -> Vec<bool> {
        let mut is_flooded = vec![false; labels.len()];
        let mut stack: Vec<[usize; 3]> = Vec::new();
        let is_border = |cell: &[usize; 3]| (0..3).any(|axis| cell[axis] == 0 || cell[axis] + 1 == self.size[axis]);
        let enter = |cell: [usize; 3], is_flooded: &mut Vec<bool>, stack: &mut Vec<[usize; 3]>| {
            let at = self.index(cell);
            if labels[at] == Label::Passable && !is_flooded[at] {
                is_flooded[at] = true;
                stack.push(cell);
            }
        };
        for cell in self.cells([[0; 3], self.size]).filter(is_border) {
            enter(cell, &mut is_flooded, &mut stack);
        }
        while let Some(cell) = stack.pop() {
            for axis in 0..3 {
                for k in [cell[axis].wrapping_sub(1), cell[axis] + 1] {
                    if k < self.size[axis] {
                        let mut next = cell;
                        next[axis] = k;
                        enter(next, &mut is_flooded, &mut stack);
                    }
                }
            }
        }
        is_flooded
    }
}
