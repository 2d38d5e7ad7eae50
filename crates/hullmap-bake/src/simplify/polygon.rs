//! Simplified flat hulls: removes edges of a convex polygon, and extends their neighbours until
//! they meet.
//!
//! # Steps
//! 1. Replace an edge by the intersection of its neighbours' lines, which contains the old polygon.
//!    The edge with the new vertex nearest to the hull goes first.
//! 2. Push the vertices outward in the plane by more than rounding to f32, and round them.
//!
//! Rounding also moves vertices out of the plane, by the containment error of any flat hull.

use std::{cmp::Reverse, collections::BinaryHeap};

use glam::DVec3;

use super::rounding::{MAX_TRIES, PUSH, ROUNDING, Simplified};
use crate::hull::{self, Hull, area::area_vector, certify::distance_to_segment};
use crate::limit::Limit;

const MIN_VERTICES: usize = 3;

/// A flat hull with fewer vertices, within the limit, if one is found. O(n log n) on typical
/// polygons, plus O(n) for each vertex of the result.
pub fn simplify(hull: &Hull, limit: Limit) -> Option<Simplified> {
    let positions = hull.positions();
    let ring: Vec<DVec3> = hull.faces[0].iter().map(|v| positions[*v as usize]).collect();
    let scale = positions.iter().fold(0.0, |scale: f64, p| scale.max(p.abs().max_element()));
    let normal = area_vector(&hull.faces[0], &positions).normalize();
    (0..MAX_TRIES).find_map(|tried| {
        let push = PUSH * scale * 2_f64.powi(tried);
        let (max_vertices, reach) = match limit {
            Limit::Vertices(max_vertices) => (max_vertices, f64::INFINITY),
            Limit::Distance(distance) => (MIN_VERTICES, distance - 2.0 * push),
        };
        let outline = outline(&ring, normal, max_vertices, reach);
        if outline.len() >= ring.len() {
            return None;
        }
        let rounded = (0..outline.len()).map(|i| {
            let at = |step: usize| outline[(i + step) % outline.len()];
            let (before, here, after) = (at(outline.len() - 1), at(0), at(1));
            let out = [here - before, after - here].map(|side| side.cross(normal).normalize());
            // The intersection of both adjacent lines, pushed outward by the same distance.
            let step = (out[0] + out[1]) / (1.0 + out[0].dot(out[1]));
            (here + step * push).to_array().map(|c| c as f32 + 0.0)
        });
        let mut outer = hull::of_positions(rounded.collect())?;
        outer.containment_error = crate::hull::certify::certify(&outer, &positions).ok()?;
        let distance = |p: DVec3| distance_to_polygon(p, &ring, normal);
        let farthest = outer.positions().into_iter().map(distance).fold(0.0, f64::max);
        let outer_error = farthest + ROUNDING * hull.diameter;
        let fits = match limit {
            Limit::Vertices(max_vertices) => outer.vertices.len() <= max_vertices,
            Limit::Distance(distance) => outer_error <= distance,
        };
        (fits && outer.rank == 2).then_some(Simplified { hull: outer, outer_error })
    })
}

/// Corners of the polygon that remains after edges are removed, while it has more than
/// `max_vertices` corners and the next vertex lies within `reach` of the hull.
fn outline(ring: &[DVec3], normal: DVec3, max_vertices: usize, reach: f64) -> Vec<DVec3> {
    let count = ring.len();
    // The remaining lines, as a ring. Line i runs from corner i of the hull to the next corner.
    let mut next: Vec<usize> = (0..count).map(|i| (i + 1) % count).collect();
    let mut last: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let mut is_left = vec![true; count];
    let mut changes = vec![0_u32; count];
    let along = |line: usize| ring[(line + 1) % count] - ring[line];
    let meet = |a: usize, b: usize| {
        let turn = along(a).cross(along(b)).dot(normal);
        let t = (ring[b] - ring[a]).cross(along(b)).dot(normal) / turn;
        (turn > 0.0 && t.is_finite()).then(|| ring[a] + along(a) * t)
    };
    // Distance from the hull of the corner that replaces all edges between two lines. The nearest
    // edge of the hull is one of these.
    let distance = |a: usize, b: usize| {
        let corner = meet(a, b)?;
        let mut least = f64::INFINITY;
        let mut line = a;
        loop {
            least = least.min(distance_to_segment(corner, ring[line], ring[(line + 1) % count]));
            if line == b {
                return Some(least);
            }
            line = (line + 1) % count;
        }
    };
    let mut queue = BinaryHeap::new();
    let look = |line: usize, next: &[usize], last: &[usize], changes: &[u32], queue: &mut BinaryHeap<_>| {
        if let Some(distance) = distance(last[line], next[line]) {
            queue.push(Reverse((distance.to_bits(), line, changes[line])));
        }
    };
    (0..count).for_each(|line| look(line, &next, &last, &changes, &mut queue));
    let mut left = count;
    while left > max_vertices.max(MIN_VERTICES) {
        let Some(Reverse((distance, line, change))) = queue.pop() else { break };
        if !is_left[line] || change != changes[line] {
            continue;
        }
        if f64::from_bits(distance) > reach {
            break;
        }
        let (before, after) = (last[line], next[line]);
        (next[before], last[after], is_left[line]) = (after, before, false);
        left -= 1;
        for neighbour in [before, after] {
            changes[neighbour] += 1;
            look(neighbour, &next, &last, &changes, &mut queue);
        }
    }
    (0..count).filter(|line| is_left[*line]).filter_map(|line| meet(last[line], line)).collect()
}

fn distance_to_polygon(p: DVec3, ring: &[DVec3], normal: DVec3) -> f64 {
    let sides = || ring.iter().zip(ring.iter().cycle().skip(1));
    let is_inside = sides().all(|(a, b)| (*b - *a).cross(p - *a).dot(normal) >= 0.0);
    let height = normal.dot(p - ring[0]).abs();
    if is_inside { height } else { sides().map(|(a, b)| distance_to_segment(p, *a, *b)).fold(f64::INFINITY, f64::min) }
}
