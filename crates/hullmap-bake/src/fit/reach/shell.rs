//! The closed surface around cells of a grid, in few triangles.
//!
//! # Steps
//! 1. Faces between a cell and one that is not marked are merged to rectangles: along one axis
//!    first, then along the other.
//! 2. A corner of a rectangle that lies on the side of another divides that side, so that triangles
//!    share whole edges.

use std::collections::{HashMap, HashSet};

type Corner = [usize; 3];

struct Rectangle {
    axis: usize,
    /// Its place along the axis, and its first and last corner along the two next axes.
    at: usize,
    from: [usize; 2],
    to: [usize; 2],
    faces_up: bool,
}

impl Rectangle {
    fn corner(&self, [u, v]: [usize; 2]) -> Corner {
        let mut corner = [self.at; 3];
        corner[(self.axis + 1) % 3] = u;
        corner[(self.axis + 2) % 3] = v;
        corner
    }

    fn corners(&self) -> [Corner; 4] {
        let ([u, v], [s, t]) = (self.from, self.to);
        [[u, v], [s, v], [s, t], [u, t]].map(|place| self.corner(place))
    }

    /// The points of its border that are in a set, counter-clockwise seen from up the axis.
    fn border(&self, set: &HashSet<Corner>) -> Vec<Corner> {
        let ([u, v], [s, t]) = (self.from, self.to);
        let sides = (u..s).map(|k| [k, v]).chain((v..t).map(|k| [s, k]));
        let sides = sides.chain((u..s).rev().map(|k| [k + 1, t])).chain((v..t).rev().map(|k| [u, k + 1]));
        sides.map(|place| self.corner(place)).filter(|corner| set.contains(corner)).collect()
    }
}

/// The outward triangles around the marked cells of a grid, and their corners in cells. The index
/// of a cell is `(z * size[1] + y) * size[0] + x`. No cell at the border may be marked.
///
/// # Complexity
/// O(cells).
pub fn shell(is_marked: &[bool], size: [usize; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let rectangles: Vec<Rectangle> = (0..3).flat_map(|axis| rectangles(is_marked, size, axis)).collect();
    let corners: HashSet<Corner> = rectangles.iter().flat_map(Rectangle::corners).collect();
    let mut indices: HashMap<Corner, u32> = HashMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for rectangle in &rectangles {
        let border = rectangle.border(&corners);
        let mut ring: Vec<u32> = border
            .into_iter()
            .map(|corner| {
                *indices.entry(corner).or_insert_with(|| {
                    points.push(corner.map(|k| k as f64));
                    points.len() as u32 - 1
                })
            })
            .collect();
        if !rectangle.faces_up {
            ring.reverse();
        }
        if let [a, b, c, d] = ring[..] {
            triangles.extend([[a, b, c], [a, c, d]]);
            continue;
        }
        // A fan from a corner would have triangles without area.
        let [first, _, last, _] = rectangle.corners();
        points.push([0, 1, 2].map(|axis| 0.5 * (first[axis] + last[axis]) as f64));
        let middle = points.len() as u32 - 1;
        triangles.extend((0..ring.len()).map(|k| [middle, ring[k], ring[(k + 1) % ring.len()]]));
    }
    (points, triangles)
}

fn rectangles(is_marked: &[bool], size: [usize; 3], axis: usize) -> Vec<Rectangle> {
    let [u_axis, v_axis] = [(axis + 1) % 3, (axis + 2) % 3];
    let stride = [1, size[0], size[0] * size[1]];
    let is_in = |at: usize, u: usize, v: usize| {
        at < size[axis] && is_marked[at * stride[axis] + u * stride[u_axis] + v * stride[v_axis]]
    };
    let mut found = Vec::new();
    for at in 1..=size[axis] {
        for faces_up in [false, true] {
            let is_face = |u: usize, v: usize| {
                let [below, above] = [is_in(at - 1, u, v), is_in(at, u, v)];
                if faces_up { below && !above } else { above && !below }
            };
            let mut left: Vec<bool> = (0..size[v_axis])
                .flat_map(|v| (0..size[u_axis]).map(move |u| (u, v)))
                .map(|(u, v)| is_face(u, v))
                .collect();
            let width = size[u_axis];
            for start in 0..left.len() {
                if !left[start] {
                    continue;
                }
                let (u, v) = (start % width, start / width);
                let s = (u..width).find(|s| !left[v * width + s]).unwrap_or(width);
                let is_row = |t: usize, left: &[bool]| (u..s).all(|k| left[t * width + k]);
                let t = (v + 1..size[v_axis]).find(|t| !is_row(*t, &left)).unwrap_or(size[v_axis]);
                (v..t).for_each(|row| left[row * width + u..row * width + s].fill(false));
                found.push(Rectangle { axis, at, from: [u, v], to: [s, t], faces_up });
            }
        }
    }
    found
}
