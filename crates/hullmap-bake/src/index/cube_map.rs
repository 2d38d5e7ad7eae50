//! Uniform cube map of support candidates (Kenwright 4.8), with exact cells.
//!
//! Deviation from the paper: a cell lists every vertex whose normal cone meets it. The paper's cell
//! holds only the support vertex of its centre, which is wrong for many directions in the cell.

use hullmap_format::cube::{CELL_SLACK, grid_to_uv, uniform_step_start};
use rayon::prelude::*;

use super::cones::{Cones, Line, cut};
use crate::gauss_map::GaussMap;

/// Ascending candidates of each cell, by face, then by row, with `resolution`² cells per face. O(n
/// + cells), multiplied by the average number of cells that a cone meets.
pub fn cells(map: &GaussMap, resolution: u32) -> Vec<Vec<u32>> {
    let faces: Vec<Vec<Vec<u32>>> = (0..6).into_par_iter().map(|face| face_cells(map, face, resolution)).collect();
    faces.into_iter().flatten().collect()
}

fn face_cells(map: &GaussMap, face: u32, resolution: u32) -> Vec<Vec<u32>> {
    let edges: Vec<f64> = (0..=resolution).map(|step| grid_to_uv(uniform_step_start(step, resolution))).collect();
    let side = resolution as usize;
    let mut cells = vec![Vec::new(); side * side];
    let (mut row_part, mut cell_part) = (Vec::new(), Vec::new());
    for (vertex, polygon) in Cones::on_face(map, face).iter() {
        for row in steps(&edges, polygon, 1) {
            band(polygon, 1, &edges[row..], &mut row_part);
            for column in steps(&edges, &row_part, 0) {
                band(&row_part, 0, &edges[column..], &mut cell_part);
                let cell = &mut cells[row * side + column];
                if !cell_part.is_empty() && cell.last() != Some(&vertex) {
                    cell.push(vertex);
                }
            }
        }
    }
    cells
}

fn steps(edges: &[f64], polygon: &[[f64; 2]], axis: usize) -> std::ops::Range<usize> {
    let low = polygon.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - CELL_SLACK;
    let high = polygon.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + CELL_SLACK;
    let first = edges.partition_point(|e| *e < low).saturating_sub(1);
    let end = edges.partition_point(|e| *e <= high).min(edges.len() - 1);
    first..end
}

/// The part of a polygon between the first two of `edges` along an axis, and the overlap, so that
/// rounding cannot put a direction into a cell that does not list its vertex.
fn band(polygon: &[[f64; 2]], axis: usize, edges: &[f64], out: &mut Vec<[f64; 2]>) {
    let mut upper = Vec::with_capacity(polygon.len() + 1);
    cut(polygon, Line::axis(axis, edges[0]), 1.0, &mut upper);
    out.clear();
    cut(&upper, Line::axis(axis, edges[1]), -1.0, out);
}
