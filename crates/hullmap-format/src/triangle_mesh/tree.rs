//! The tree of boxes over a triangle mesh, without pointers.
//!
//! Node 0 is the root; the children of node i are nodes 2 i + 1 and 2 i + 2. Node p of level d,
//! counted from the left, has the triangles from ⌊p n / 2ᵈ⌋ to ⌊(p + 1) n / 2ᵈ⌋ of n. A node with
//! one triangle is a leaf. Every level holds all triangles.
//!
//! Boxes are stored for the levels whose nodes have at least two triangles each, and computed from
//! the corners below. Each has six numbers of 16 bits, low x, y, z, then high x, y, z: positions
//! between the bounds of the mesh ([`Grid`]), the greatest not above the vertices and the smallest
//! not below. Along an axis without extent, both are 0.

use crate::scale::Scale;

/// First triangle of a node, and the one after its last, among `count` triangles. Empty for a node
/// beyond the tree.
#[inline]
pub fn triangles(node: u32, count: usize) -> [usize; 2] {
    let at = u64::from(node) + 1;
    let level = at.ilog2();
    let position = at - (1 << level);
    // At most 2³² nodes and 2²⁸ triangles: no overflow.
    [position, position + 1].map(|p| ((p * count as u64) >> level) as usize)
}

/// The first of two children of a node; the second is the next node.
#[inline]
pub fn first_child(node: u32) -> u32 {
    node.saturating_mul(2).saturating_add(1)
}

/// Number of nodes with a stored box, which come first, of a mesh of `count` triangles.
pub fn stored_boxes(count: usize) -> usize {
    // The last level whose nodes all have at least two triangles.
    (count / 2).checked_ilog2().map_or(0, |level| (2 << level) - 1)
}

/// Upper bound of the node numbers of a mesh of `count` triangles.
pub fn node_bound(count: usize) -> usize {
    2 * count.next_power_of_two() - 1
}

/// Positions between the bounds of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    x: Scale,
    y: Scale,
    z: Scale,
}

impl Grid {
    /// The positions between these bounds.
    pub fn new([x, y, z]: [f32; 3], [x1, y1, z1]: [f32; 3]) -> Self {
        Self { x: Scale::new(x, x1), y: Scale::new(y, y1), z: Scale::new(z, z1) }
    }

    /// The corners of a box.
    #[inline]
    pub fn corners(&self, [x, y, z, x1, y1, z1]: [u16; 6]) -> [[f64; 3]; 2] {
        let Self { x: along_x, y: along_y, z: along_z } = self;
        let at = |x: u16, y: u16, z: u16| [along_x.position(x), along_y.position(y), along_z.position(z)];
        [at(x, y, z), at(x1, y1, z1)]
    }

    /// The distances between the coordinates of consecutive numbers, along each axis.
    pub fn steps(&self) -> [f64; 3] {
        [self.x.step(), self.y.step(), self.z.step()]
    }

    /// The low and the high numbers of a box that holds another one, clamped to the bounds.
    pub fn around(&self, low: [f64; 3], high: [f64; 3]) -> [[u16; 3]; 2] {
        let Self { x, y, z } = self;
        let ([x0, y0, z0], [x1, y1, z1]) = (low, high);
        [[x.below(x0), y.below(y0), z.below(z0)], [x.above(x1), y.above(y1), z.above(z1)]]
    }

    /// The box of a vertex: its low and its high numbers.
    pub fn of_vertex(&self, vertex: [f32; 3]) -> [u16; 6] {
        let vertex = vertex.map(f64::from);
        let [[x, y, z], [x1, y1, z1]] = self.around(vertex, vertex);
        [x, y, z, x1, y1, z1]
    }
}

/// The box around two boxes.
pub fn around(a: [u16; 6], b: [u16; 6]) -> [u16; 6] {
    let ([a0, a1, a2, a3, a4, a5], [b0, b1, b2, b3, b4, b5]) = (a, b);
    [a0.min(b0), a1.min(b1), a2.min(b2), a3.max(b3), a4.max(b4), a5.max(b5)]
}

/// The boxes of all nodes with a stored box, of `count` triangles with the boxes `of_triangle`, in
/// O(`count`).
pub fn boxes(count: usize, of_triangle: impl Fn(usize) -> [u16; 6]) -> Vec<[u16; 6]> {
    let stored = stored_boxes(count);
    let mut boxes = vec![[u16::MAX, u16::MAX, u16::MAX, 0, 0, 0]; stored];
    for node in (0..stored).rev() {
        let child = first_child(node as u32) as usize;
        let own = match (boxes.get(child), boxes.get(child + 1)) {
            (Some(first), Some(second)) => around(*first, *second),
            _ => {
                let [start, end] = triangles(node as u32, count);
                (start..end).map(&of_triangle).reduce(around).unwrap_or_default()
            }
        };
        if let Some(node) = boxes.get_mut(node) {
            *node = own;
        }
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_inner_node_has_two_children_with_triangles() {
        for count in (1..300).chain([1023, 1024, 1025, 4099]) {
            let (mut leaves, mut open) = (vec![], vec![0_u32]);
            while let Some(node) = open.pop() {
                assert!((node as usize) < node_bound(count));
                let [start, end] = triangles(node, count);
                assert!(start < end && end <= count, "{count} triangles, node {node}");
                if end - start == 1 {
                    leaves.push(start);
                    assert!(node as usize >= stored_boxes(count));
                    continue;
                }
                let child = first_child(node);
                let ([a, middle], [again, b]) = (triangles(child, count), triangles(child + 1, count));
                assert_eq!((a, middle, b), (start, again, end));
                if node as usize >= stored_boxes(count) {
                    assert!(end - start <= 2);
                }
                open.extend([child + 1, child]);
            }
            assert_eq!(leaves, (0..count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn numbers_are_the_tightest_around_a_coordinate() {
        let bounds = [
            ([0.0, -3.0, 1e30], [1.0, 4e4, 1.000_001e30]),
            ([-1e-40, 5.0, f32::MIN], [1e-40, 5.0, f32::MAX]),
            ([1.0, 1.0, 1.0], [1.0 + f32::EPSILON, 1.0 + 3.0 * f32::EPSILON, 1e9]),
        ];
        for (low, high) in bounds {
            let grid = Grid::new(low, high);
            let between = |axis: usize, t: f32| (low[axis] + t * (high[axis] - low[axis])).clamp(low[axis], high[axis]);
            for step in 0..=1000_u16 {
                let t = f32::from(step) / 1000.0;
                let vertex = [between(0, t), between(1, t), between(2, t)].map(|c| if c.is_finite() { c } else { 0.0 });
                let numbers = grid.of_vertex(vertex);
                let [below, above] = grid.corners(numbers);
                for axis in (0..3).filter(|axis| low[*axis] < high[*axis]) {
                    let c = f64::from(vertex[axis]);
                    assert!(below[axis] <= c && c <= above[axis], "{vertex:?} {numbers:?}");
                    let (down, up) = (numbers[axis], numbers[axis + 3]);
                    let scale = [grid.x, grid.y, grid.z][axis];
                    assert!(down == u16::MAX || scale.position(down + 1) > c, "{vertex:?}");
                    assert!(up == 0 || scale.position(up - 1) < c, "{vertex:?}");
                }
            }
        }
    }
}
