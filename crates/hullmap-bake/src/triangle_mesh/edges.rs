//! Neighbours of the triangles, and classes of edges and vertices.
//!
//! # Steps
//! 1. Set triangles aside that have a corner twice, or the same three corners as an earlier one:
//!    they are no part of the surface, and have no neighbours.
//! 2. Sort the edges of the others by their ends. Two equal edges are one between neighbours, more
//!    are not manifold.
//! 3. The class of a vertex follows from its edges.

use hullmap_format::triangle_mesh::{
    archive::NO_NEIGHBOUR,
    class::{EdgeClass, VertexClass},
};
use rayon::prelude::*;

/// Facts about edges and vertices, in the order of the triangles and of the vertices.
pub struct Edges {
    pub neighbours: Vec<[u32; 3]>,
    pub edge_classes: Vec<u16>,
    pub vertex_classes: Vec<u8>,
    pub degenerate: u32,
    pub duplicate: u32,
}

/// An edge of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    ends: u64,
    place: u32,
}

impl Side {
    fn triangle(self) -> usize {
        (self.place >> 2) as usize
    }

    fn edge(self) -> usize {
        (self.place & 3) as usize
    }
}

/// Finds neighbours and classes.
///
/// # Complexity
/// O(n log n) for n triangles.
pub fn find(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Edges {
    let (is_aside, duplicate) = set_aside(triangles);
    let degenerate = triangles.iter().filter(|corners| is_degenerate(vertices, corners)).count() as u32;
    let mut sides: Vec<Side> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate().filter(|(triangle, _)| !is_aside[*triangle]) {
        for edge in 0..3 {
            let [from, to] = [corners[edge], corners[(edge + 1) % 3]].map(u64::from);
            sides.push(Side { ends: from.min(to) << 32 | from.max(to), place: (triangle << 2 | edge) as u32 });
        }
    }
    sides.par_sort_unstable();
    let mut neighbours = vec![[NO_NEIGHBOUR; 3]; triangles.len()];
    let mut edge_classes = vec![0_u16; triangles.len()];
    let mut at_vertices = vec![None::<VertexClass>; vertices.len()];
    for run in sides.chunk_by(|a, b| a.ends == b.ends) {
        let class = match run {
            [_] => EdgeClass::Border,
            [first, second] => {
                neighbours[first.triangle()][first.edge()] = second.triangle() as u32;
                neighbours[second.triangle()][second.edge()] = first.triangle() as u32;
                class_between(vertices, triangles, *first, *second)
            }
            _ => EdgeClass::NonManifold,
        };
        for side in run {
            edge_classes[side.triangle()] |= class.code() << (4 * side.edge());
        }
        for end in [run[0].ends >> 32, run[0].ends & u64::from(u32::MAX)] {
            let at_vertex = &mut at_vertices[end as usize];
            *at_vertex = Some(at_vertex.unwrap_or(VertexClass::Flat).with(class));
        }
    }
    // A vertex of triangles that are set aside alone has an edge without neighbours.
    let vertex_classes = at_vertices.into_iter().map(|class| class.unwrap_or(VertexClass::Border).code()).collect();
    Edges { neighbours, edge_classes, vertex_classes, degenerate, duplicate }
}

fn set_aside(triangles: &[[u32; 3]]) -> (Vec<bool>, u32) {
    let mut is_aside: Vec<bool> = triangles.iter().map(|[a, b, c]| a == b || b == c || c == a).collect();
    let sorted = |corners: &[u32; 3]| {
        let mut corners = *corners;
        corners.sort_unstable();
        corners
    };
    let mut sets: Vec<([u32; 3], u32)> = triangles.iter().map(sorted).zip(0..).collect();
    sets.par_sort_unstable();
    let mut duplicate = 0;
    for run in sets.chunk_by(|a, b| a.0 == b.0) {
        for (_, later) in &run[1..] {
            is_aside[*later as usize] = true;
            duplicate += 1;
        }
    }
    (is_aside, duplicate)
}

fn is_degenerate(vertices: &[[f32; 3]], corners: &[u32; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| vertices[corner as usize].map(f64::from));
    // Differences of f32 are nearly exact in f64, but products round: exact predicates decide.
    let flat = |x: usize, y: usize| robust::orient2d(coord(a, x, y), coord(b, x, y), coord(c, x, y)) == 0.0;
    flat(0, 1) && flat(1, 2) && flat(2, 0)
}

fn coord(p: [f64; 3], x: usize, y: usize) -> robust::Coord<f64> {
    robust::Coord { x: p[x], y: p[y] }
}

fn class_between(vertices: &[[f32; 3]], triangles: &[[u32; 3]], first: Side, second: Side) -> EdgeClass {
    let corner = |side: Side, step: usize| triangles[side.triangle()][(side.edge() + step) % 3];
    if corner(first, 0) == corner(second, 0) {
        return EdgeClass::Reversed;
    }
    let at = |corner: u32| vertices[corner as usize].map(f64::from);
    EdgeClass::between([0, 1, 2].map(|step| at(corner(first, step))), at(corner(second, 2)))
}
