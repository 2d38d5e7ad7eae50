//! Triangles along a ray, nearer boxes first: a descent of the tree of boxes.
//!
//! # Steps
//! 1. Express the ray in the numbers of the mesh's grid: for each axis, the length along the ray at
//!    which it reaches the plane of a number is a linear function of the number. So boxes are
//!    clipped without decoding them.
//! 2. Clip the ray by the boxes of two children. Go on with the nearer one, and keep the other one.
//! 3. Below the stored boxes, clip the ray by the box of each of the two or three triangles of a
//!    node, and visit those that it meets.
//!
//! # Deviations
//! Planes are moved outwards by a margin, which is more than the rounding error of all steps. So no
//! triangle is missed. Along an axis in which the ray does not move, numbers are compared with
//! those around the ray.
//!
//! # Reference
//! Kay, Kajiya, "Ray Tracing Complex Scenes", 1986 (slabs); Mahovsky, "Ray Tracing with
//! Reduced-Precision Bounding Volume Hierarchies", 2005 (boxes of small integers).

#![forbid(unsafe_code)]

use arrayvec::ArrayVec;
use glam::DVec3;
use hullmap_format::triangle_mesh::tree;
use rkyv::rend::u16_le;

use super::TriangleMesh;
use crate::ray_box::{BoxedRay, LENGTH_ERROR};

/// A stack of nodes: one more than the levels of a tree of 2²⁸ triangles.
const MAX_STACK: usize = 32;

/// A length for each number by which a box is beside a ray that does not move along an axis: more
/// than any other length, so that the ray misses the box. A power of two: no product is rounded.
const BESIDE: f64 = f64::from_bits(2023 << 52);

/// Lengths along a ray at which it reaches the planes of numbers along an axis.
#[derive(Clone, Copy)]
struct Slab {
    /// Which of a box's six numbers is the plane that the ray reaches first, and which the last.
    first: usize,
    last: usize,
    /// Length at the number 0 for the first plane, and for the last one.
    offsets: [f64; 2],
    /// Length from a number to the next.
    step: f64,
}

impl Slab {
    /// Slab of an axis along which a ray moves. `low` is the coordinate of the number 0,
    /// relative to the origin of the ray, `step` the distance of two numbers.
    fn moving(axis: usize, low: f64, step: f64, margin: f64, inverse: f64) -> Self {
        let (first, last, margin) = if inverse < 0.0 { (axis + 3, axis, -margin) } else { (axis, axis + 3, margin) };
        Self { first, last, offsets: [(low - margin) * inverse, (low + margin) * inverse], step: step * inverse }
    }

    /// Slab of an axis along which it does not move. Boxes from the number `below` to the number
    /// `above` may meet it.
    fn still(axis: usize, below: u16, above: u16) -> Self {
        let offsets = [-f64::from(above) * BESIDE, (1.0 - f64::from(below)) * BESIDE];
        Self { first: axis, last: axis + 3, offsets, step: BESIDE }
    }
}

/// A ray in the numbers of a mesh's grid.
struct Line([Slab; 3]);

impl Line {
    /// The lengths at which the ray enters and leaves a box; `None` if it misses it.
    #[inline]
    fn clip(&self, stored: &[u16_le; 6]) -> Option<[f64; 2]> {
        let (mut enter, mut leave) = (0.0, f64::INFINITY);
        for slab in &self.0 {
            let number = |index: usize| f64::from(stored.get(index).map_or(0, |number| number.to_native()));
            let first = slab.offsets[0] + number(slab.first) * slab.step;
            let last = slab.offsets[1] + number(slab.last) * slab.step;
            // A NaN is passed over.
            enter = if first > enter { first } else { enter };
            leave = if last < leave { last } else { leave };
        }
        (enter * (1.0 - LENGTH_ERROR) <= leave * (1.0 + LENGTH_ERROR)).then_some([enter * (1.0 - LENGTH_ERROR), leave])
    }
}

impl TriangleMesh {
    /// Visits the triangles that a ray may meet up to the length `reach`, those in nearer boxes
    /// first. `visit` returns the length up to which the ray is followed from then on. Returns the
    /// number of boxes compared.
    ///
    /// `direction` is of unit length. Boxes are grown by `margin`, which bounds the rounding error
    /// of coordinates of the mesh and of the ray.
    ///
    /// # Complexity
    /// Visits each node and each triangle at most once.
    pub(crate) fn along(
        &self,
        [origin, direction]: [DVec3; 2],
        margin: f64,
        mut reach: f64,
        mut visit: impl FnMut(usize) -> f64,
    ) -> u32 {
        let sections = self.sections();
        let count = sections.triangle_count();
        let Some(line) = self.line([origin, direction], margin) else { return 1 };
        let ray = BoxedRay { origin, inverse: direction.recip(), margin };
        let mut stack: ArrayVec<(u32, f64), MAX_STACK> = [(0, 0.0)].into_iter().collect();
        let mut boxes = 1_u32;
        while let Some((mut node, enter)) = stack.pop() {
            // NaN takes the branch that goes on.
            if enter > reach {
                continue;
            }
            // Down to a node whose children have no stored boxes.
            loop {
                let child = tree::first_child(node);
                let Some([first, second]) = sections.boxes.get(child as usize..child as usize + 2) else {
                    let [start, end] = tree::triangles(node, count);
                    for triangle in start..end {
                        let Some(bounds) = self.corner_bounds(triangle, triangle + 1) else { continue };
                        // A ray that misses the box must not seem to graze the triangle.
                        if ray.clip(bounds, [0.0, f64::INFINITY]).is_some_and(|span| span[0] <= reach) {
                            reach = visit(triangle);
                        }
                        boxes += 1;
                    }
                    break;
                };
                boxes += 2;
                let within = |span: &[f64; 2]| !(span[0] > reach);
                let spans = [first, second].map(|stored| line.clip(stored).filter(within));
                match spans {
                    [None, None] => break,
                    [Some(_), None] => node = child,
                    [None, Some(_)] => node = child + 1,
                    [Some(first), Some(second)] => {
                        // If both boxes are entered at once, take the one that is left first.
                        let is_nearer = (first[0], first[1]) <= (second[0], second[1]);
                        let other = if is_nearer { (child + 1, second[0]) } else { (child, first[0]) };
                        node = if is_nearer { child } else { child + 1 };
                        let _ = stack.try_push(other);
                    }
                }
            }
        }
        boxes
    }

    /// A ray in the numbers of the grid; `None` if it is beside the whole mesh, along an axis in
    /// which it does not move.
    fn line(&self, [origin, direction]: [DVec3; 2], margin: f64) -> Option<Line> {
        let [low, high] = self.bounds().map(|corner| corner.as_dvec3());
        let grown = DVec3::splat(margin);
        let [[x, y, z], [x1, y1, z1]] = self.grid.around((origin - grown).to_array(), (origin + grown).to_array());
        let [step_x, step_y, step_z] = self.grid.steps();
        let slab = |axis: usize, [low, high]: [f64; 2], step: f64, [from, by]: [f64; 2], [below, above]: [u16; 2]| {
            if by != 0.0 {
                return Some(Slab::moving(axis, low - from, step, margin, by.recip()));
            }
            // NaN takes the branch that goes on.
            let is_beside = from + margin < low || from - margin > high;
            (!is_beside).then(|| Slab::still(axis, below, above))
        };
        Some(Line([
            slab(0, [low.x, high.x], step_x, [origin.x, direction.x], [x, x1])?,
            slab(1, [low.y, high.y], step_y, [origin.y, direction.y], [y, y1])?,
            slab(2, [low.z, high.z], step_z, [origin.z, direction.z], [z, z1])?,
        ]))
    }
}
