//! T-junctions: vertices that lie on a border edge of a triangle, between its ends.
//!
//! There the surface looks closed, but the triangles on both sides are not neighbours: rounding may
//! open a crack, and the edge has the contact normals of a border.
//!
//! # Steps
//! 1. Build a tree of boxes over the border edges, which both sides of a T-junction are.
//! 2. Compare each end of a border edge with the edges whose boxes contain it.
//!
//! # Complexity
//! O(n log n) for n border edges: a vertex visits at most [`VISITS_A_LEVEL`] boxes for each level
//! of a balanced tree. Beyond, the count is a lower bound, as the result states.

use std::cell::Cell;

use glam::DVec3;
use hullmap_format::triangle_mesh::class::EdgeClass;
use rayon::prelude::*;

use crate::{
    fit::triangle_tree::{Bounds, TriangleTree},
    hull::bounds,
};

/// Maximum distance of a vertex on an edge, relative to the mesh's diagonal. Editors place such
/// vertices in f32, with errors of a few times 6e-8 of the coordinates.
pub const TOLERANCE: f64 = 1e-6;

/// Maximum number of boxes that a vertex visits, for each level of a balanced tree.
const VISITS_A_LEVEL: usize = 64;

/// The T-junctions of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TJunctions {
    /// Number of vertices.
    pub count: usize,
    /// Whether these are all; otherwise there may be more.
    pub is_complete: bool,
}

struct Edge {
    from: DVec3,
    to: DVec3,
    corners: [u32; 3],
}

/// Counts a mesh's T-junctions, from sections of its file; the same for any number of threads.
///
/// # Panics
/// If a corner is not a vertex.
pub fn t_junctions(vertices: &[[f32; 3]], triangles: &[[u32; 3]], edge_classes: &[u16]) -> TJunctions {
    let at = |corner: u32| DVec3::from_array(vertices[corner as usize].map(f64::from));
    let (mut edges, mut is_end) = (Vec::new(), vec![false; vertices.len()]);
    for (corners, classes) in triangles.iter().zip(edge_classes) {
        for edge in (0..3).filter(|edge| EdgeClass::unpack(*classes, *edge) == Some(EdgeClass::Border)) {
            let ends = [corners[edge], corners[(edge + 1) % 3]];
            edges.push(Edge { from: at(ends[0]), to: at(ends[1]), corners: *corners });
            ends.iter().for_each(|end| is_end[*end as usize] = true);
        }
    }
    let [low, high] = bounds(vertices).map(|p| DVec3::from_array(p.map(f64::from)));
    let tolerance = TOLERANCE * (high - low).length();
    let around = |edge: &Edge| Bounds::around(&[edge.from, edge.to]).grown(tolerance);
    let tree = TriangleTree::of_boxes(edges.iter().map(around));
    let limit = VISITS_A_LEVEL * (edges.len().checked_ilog2().unwrap_or_default() as usize + 1);
    let ends: Vec<u32> = (0_u32..).zip(&is_end).filter(|(_, is_end)| **is_end).map(|(vertex, _)| vertex).collect();
    let judge = |vertex: &u32| {
        let (p, visits) = (at(*vertex), Cell::new(0));
        let accepts = |bounds: &Bounds| {
            visits.set(visits.get() + 1);
            visits.get() <= limit && bounds.contains(p)
        };
        let found = tree.visit(accepts, |edge| {
            let edge = &edges[edge as usize];
            let is_own = edge.corners.contains(vertex);
            if !is_own && is_between(p, edge, tolerance) {
                std::ops::ControlFlow::Break(())
            } else {
                std::ops::ControlFlow::Continue(())
            }
        });
        (usize::from(found.is_break()), found.is_break() || visits.get() <= limit)
    };
    let sum = |a: (usize, bool), b: (usize, bool)| (a.0 + b.0, a.1 && b.1);
    let (count, is_complete) = ends.par_iter().map(judge).reduce(|| (0, true), sum);
    TJunctions { count, is_complete }
}

fn is_between(p: DVec3, edge: &Edge, tolerance: f64) -> bool {
    let (along, to_p) = (edge.to - edge.from, p - edge.from);
    let length = along.length();
    let place = to_p.dot(along) / length;
    // NaN, of an edge without length, takes the failing branch.
    place > tolerance && length - place > tolerance && (to_p - along * (place / length)).length() <= tolerance
}
