//! Grid traversal: the triangles of a height field that a ray may meet, nearer ones first.
//!
//! A *patch* is a cell, or all cells of a node of the tree of height ranges. A *strip* is a column
//! or a row of patches.
//!
//! # Steps
//! 1. Clip the ray by the box around the field.
//! 2. Choose the patches to cross: the finest patches of which the ray crosses only a few.
//! 3. Go from strip to strip, along the axis along which the ray crosses more of them. In a strip,
//!    take the patches that the ray may meet there.
//! 4. Clip the ray by the box of each. If it meets the box of a node, cross the patches inside in
//!    the same way. If it meets the box of a cell, visit its triangles.
//!
//! # Deviations
//! The traversals below step from cell to cell, where rounding may skip a cell that the ray only
//! touches. Here a strip takes all patches within a margin of the ray, so none is missed. Patches
//! of one level need not have equally many cells.
//!
//! # Reference
//! Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987; Tevs, Ihrke, Seidel,
//! "Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering", 2008.

#![forbid(unsafe_code)]

use glam::DVec3;
use hullmap_format::height_field::pyramid::{Cells, position_of, share};

use super::HeightField;
use crate::ray_box::{BoxedRay, LENGTH_ERROR};

/// Number of patches that the ray crosses in a row at most, if there are coarser ones. A patch
/// costs less than a level of patches does.
const FEW: f64 = 16.0;

/// Levels of the tree from patches to the next finer ones: eight along each axis.
const LEVELS: u32 = 6;

/// Number of a node that the tree does not have.
const NO_NODE: u32 = u32::MAX;

pub(crate) struct Walk<'f, V> {
    field: &'f HeightField,
    ray: BoxedRay,
    /// Unit vector.
    direction: DVec3,
    /// Length up to which the ray is followed.
    reach: f64,
    boxes: u32,
    visit: V,
}

/// An axis of the plane of the grid.
#[derive(Clone, Copy)]
struct Axis {
    is_y: bool,
    /// How many levels of the tree divide it into patches; `None` for cells.
    divisions: Option<u32>,
}

impl<'f, V: FnMut(usize) -> f64> Walk<'f, V> {
    /// Visits the triangles of the cells that a ray may meet up to the length `reach`, holes left
    /// out. `visit` returns the length up to which the ray is followed from then on.
    ///
    /// `direction` is of unit length. Boxes are grown by `margin`, which bounds the rounding error
    /// of coordinates of the field and of the ray. Returns the number of boxes compared.
    ///
    /// # Complexity
    /// Visits each cell, and each node of a few levels of the tree, at most once.
    pub(crate) fn run(
        field: &'f HeightField,
        [origin, direction]: [DVec3; 2],
        margin: f64,
        reach: f64,
        visit: V,
    ) -> u32 {
        let ray = BoxedRay { origin, inverse: direction.recip(), margin };
        let mut walk = Self { field, ray, direction, reach, boxes: 1, visit };
        let [across, along] = field.layout.cells();
        if let Some(span) = walk.ray.clip(field.bounds(), [0.0, f64::INFINITY])
            && span[0] <= reach
        {
            walk.cross(Cells { columns: [0, across], rows: [0, along] }, span, None);
        }
        walk.boxes
    }

    /// The level of the finest patches of which the ray crosses few, and the axis along which it
    /// crosses more of them, then the other one. `above` is the level of the node that is crossed.
    #[inline]
    fn choose(&self, [enter, leave]: [f64; 2], above: Option<u32>) -> (Option<u32>, [Axis; 2]) {
        let (layout, pyramid) = (&self.field.layout, &self.field.pyramid);
        let ([across, along], [dx, dy]) = (layout.cells(), layout.spacing);
        let length = leave.min(self.reach) - enter;
        let crossed = [length * self.direction.x.abs() / dx, length * self.direction.y.abs() / dy];
        let mut level = None;
        let mut next = Some(pyramid.stored_level());
        let mut divisions = [None; 2];
        let [mut x, mut y] = crossed;
        // NaN takes the branch of the cells.
        while x.max(y) > FEW
            && let Some(coarser) = next.filter(|next| above.is_none_or(|above| *next > above))
        {
            let [x_levels, y_levels] = pyramid.divisions(coarser);
            level = Some(coarser);
            divisions = [Some(x_levels), Some(y_levels)];
            x = crossed[0] / across as f64 * (1_u64 << x_levels) as f64;
            y = crossed[1] / along as f64 * (1_u64 << y_levels) as f64;
            next = coarser.checked_sub(LEVELS);
        }
        let axes = [Axis { is_y: false, divisions: divisions[0] }, Axis { is_y: true, divisions: divisions[1] }];
        let [first, second] = axes;
        (level, if y > x { [second, first] } else { axes })
    }

    /// Crosses a rectangle of cells: all cells, or the cells of a node of the level `above`.
    fn cross(&mut self, area: Cells, span: [f64; 2], above: Option<u32>) {
        let (level, [along, beside]) = self.choose(span, above);
        let strips = self.positions(along, area, span);
        for strip in self.in_order(along, strips) {
            let cells = self.cells(along, strip);
            let Some(part) = self.clip_strip(along, cells, span) else { continue };
            if !(part[0] <= self.reach) {
                return;
            }
            let patches = self.positions(beside, area, part);
            for patch in self.in_order(beside, patches) {
                let ([x, y], cells) = (self.cells(beside, patch), cells);
                let cells = if along.is_y {
                    Cells { columns: [x, y], rows: cells }
                } else {
                    Cells { columns: cells, rows: [x, y] }
                };
                let position = if along.is_y { [patch, strip] } else { [strip, patch] };
                self.enter(cells, level, position, part);
            }
        }
    }

    /// Enters a patch, given by its position in its level.
    #[inline]
    fn enter(&mut self, cells: Cells, level: Option<u32>, position: [u32; 2], span: [f64; 2]) {
        let field = self.field;
        self.boxes = self.boxes.saturating_add(1);
        let node = level.map_or(NO_NODE, |level| field.pyramid.node_at(level, position));
        let Some(own) = field.box_of(cells, node) else { return };
        let Some(span) = self.ray.clip(own, span) else { return };
        if !(span[0] <= self.reach) {
            return;
        }
        if level.is_some() {
            return self.cross(cells, span, level);
        }
        let cell = field.layout.cell(cells.columns[0], cells.rows[0]);
        for triangle in [2 * cell, 2 * cell + 1] {
            self.reach = (self.visit)(triangle);
        }
    }

    /// Positions of the first and the last patch along an axis that a part of the ray may meet, of
    /// those in an area.
    #[inline]
    fn positions(&self, axis: Axis, area: Cells, [enter, leave]: [f64; 2]) -> [u32; 2] {
        let layout = &self.field.layout;
        let (from, by, [first, spacing], [start, end], count) = if axis.is_y {
            (self.ray.origin.y, self.direction.y, [layout.origin[1], layout.spacing[1]], area.rows, layout.cells()[1])
        } else {
            (
                self.ray.origin.x,
                self.direction.x,
                [layout.origin[0], layout.spacing[0]],
                area.columns,
                layout.cells()[0],
            )
        };
        let (a, b) = (from + by * enter, from + by * leave);
        let cells = [a.min(b) - self.ray.margin, a.max(b) + self.ray.margin].map(|at| (at - first) / spacing);
        // The cast saturates, and turns NaN into 0.
        let cells = cells.map(|cell| (cell as usize).clamp(start, (end - 1).max(start)));
        cells.map(|cell| axis.divisions.map_or(cell as u32, |levels| position_of(cell, count, levels)))
    }

    /// Positions from the first to the last in the order in which the ray comes to them.
    #[inline]
    fn in_order(&self, axis: Axis, [first, last]: [u32; 2]) -> impl Iterator<Item = u32> + use<V> {
        let by = if axis.is_y { self.direction.y } else { self.direction.x };
        let is_falling = by < 0.0;
        (0..=last - first).map(move |step| if is_falling { last - step } else { first + step })
    }

    /// Columns or rows of a patch: the first, and the one after the last.
    #[inline]
    fn cells(&self, axis: Axis, position: u32) -> [usize; 2] {
        let [across, along] = self.field.layout.cells();
        let count = if axis.is_y { along } else { across };
        axis.divisions.map_or([position as usize, position as usize + 1], |levels| share(count, levels, position))
    }

    /// The part of the ray from `span` that is in a strip of columns or rows.
    #[inline]
    fn clip_strip(&self, axis: Axis, [start, end]: [usize; 2], [enter, leave]: [f64; 2]) -> Option<[f64; 2]> {
        let layout = &self.field.layout;
        let (low, high, from, inverse) = if axis.is_y {
            (layout.y(start), layout.y(end), self.ray.origin.y, self.ray.inverse.y)
        } else {
            (layout.x(start), layout.x(end), self.ray.origin.x, self.ray.inverse.x)
        };
        let (p, q) = ((low - self.ray.margin - from) * inverse, (high + self.ray.margin - from) * inverse);
        let span = [enter.max(p.min(q)) * (1.0 - LENGTH_ERROR), leave.min(p.max(q)) * (1.0 + LENGTH_ERROR)];
        (span[0] <= span[1]).then_some(span)
    }
}
