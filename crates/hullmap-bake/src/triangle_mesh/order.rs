//! The order of the triangles: the order of the leaves of the tree of boxes.
//!
//! The tree has no pointers, so each node's number of triangles is fixed. They are split along the
//! axis in which their middles extend most. Unlike with the surface area heuristic, only the axis
//! is free; the tree takes 6 to 12 bytes a triangle instead of 32 or more, at the least possible
//! depth.

use hullmap_format::triangle_mesh::tree;

const LARGE: usize = 1 << 12;

/// Indices of `triangles`, in the order of the leaves.
///
/// # Complexity
/// O(n log n).
pub fn order(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    // Three times the middle: the sum of the corners.
    let middle = |corners: &[u32; 3]| -> [f64; 3] {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize].map(f64::from));
        std::array::from_fn(|axis| a[axis] + b[axis] + c[axis])
    };
    let middles: Vec<[f64; 3]> = triangles.iter().map(middle).collect();
    split(&mut order, &middles, 0);
    order
}

fn split(order: &mut [u32], middles: &[[f64; 3]], node: u32) {
    if order.len() < 2 {
        return;
    }
    let child = tree::first_child(node);
    let [start, middle] = tree::triangles(child, middles.len());
    let axis = widest(order, middles);
    let key = |triangle: &u32| middles[*triangle as usize][axis];
    // Equal keys are ordered by index, so that the result is determined.
    order.select_nth_unstable_by(middle - start, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let is_large = order.len() >= LARGE;
    let (low, high) = order.split_at_mut(middle - start);
    if is_large {
        rayon::join(|| split(low, middles, child), || split(high, middles, child + 1));
    } else {
        split(low, middles, child);
        split(high, middles, child + 1);
    }
}

fn widest(order: &[u32], middles: &[[f64; 3]]) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for triangle in order {
        for (axis, c) in middles[*triangle as usize].into_iter().enumerate() {
            low[axis] = low[axis].min(c);
            high[axis] = high[axis].max(c);
        }
    }
    let extent = |axis: usize| high[axis] - low[axis];
    (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best })
}
