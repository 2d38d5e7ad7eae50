//! Triangles near a box. The box is rounded outward to the grid of the mesh's tree once. Then boxes
//! are compared as integers, without decoding them.

use arrayvec::ArrayVec;
use glam::DVec3;
use hullmap_format::triangle_mesh::tree;
use rkyv::rend::u16_le;

use super::TriangleMesh;
use crate::shapes::triangle::{VisitTriangle, is_beside_box};

/// A stack of nodes: one more than the levels of a tree of 2²⁸ triangles.
const MAX_STACK: usize = 32;

impl TriangleMesh {
    /// Visits all triangles whose boxes overlap a box, until a visit says `true`. Returns whether
    /// one did, and the number of boxes compared. Other triangles near the box may be visited, too.
    pub(crate) fn any_in_box(&self, [low, high]: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> (bool, u32) {
        let sections = self.sections();
        let count = sections.triangle_count();
        if count == 0 {
            return (false, 0);
        }
        let [low_numbers, high_numbers] = self.grid.around(low.to_array(), high.to_array());
        let touches = |stored: &[u16_le; 6]| {
            let [x, y, z, x1, y1, z1] = stored.map(u16_le::to_native);
            x <= high_numbers[0]
                && y <= high_numbers[1]
                && z <= high_numbers[2]
                && x1 >= low_numbers[0]
                && y1 >= low_numbers[1]
                && z1 >= low_numbers[2]
        };
        let mut stack: ArrayVec<u32, MAX_STACK> = [0].into_iter().collect();
        let mut boxes = 0_u32;
        while let Some(node) = stack.pop() {
            boxes += 1;
            let has_children = match sections.boxes.get(node as usize) {
                Some(stored) if !touches(stored) => continue,
                Some(_) => true,
                None => false,
            };
            if has_children {
                let first = tree::first_child(node);
                for child in [first + 1, first] {
                    let _ = stack.try_push(child);
                }
                continue;
            }
            let [start, end] = tree::triangles(node, count);
            for triangle in start..end {
                let Some([a, b, c]) = sections.corners(triangle) else { return (false, boxes) };
                let corners = [a, b, c].map(|corner| DVec3::from_array(corner.map(f64::from)));
                if !is_beside_box(corners, [low, high]) && visit(triangle, corners) {
                    return (true, boxes);
                }
            }
        }
        (false, boxes)
    }
}
