//! The space around a mesh that no ball of a given radius can reach from outside. If it counts as
//! solid, inner walls and everything behind a narrow opening need no parts.
//!
//! # Steps
//! 1. The centre of a ball that does not penetrate the solid is at least the radius away from it. A
//!    cell of a grid is *passable* unless all of its points are certainly closer.
//! 2. Flood the passable cells from the border of the grid, which lies outside. The centre of a
//!    ball that comes from outside stays in flooded cells.
//! 3. Points of the ball are at most the radius away from its centre. A cell is *unreachable* if
//!    all of its points are farther than that from all flooded cells.
//! 4. The surface around the unreachable cells that are not deep inside the solid is added to the
//!    mesh. The solid of the result is the solid of the mesh plus these cells.
//!
//! # Why unreachable space is certainly unreachable
//! Each step errs towards reachable space: step 1 by at most one diagonal of a cell, and step 3 by
//! at most two. So a strip up to four cells wide at a separating wall stays reachable. The new
//! solid adds only unreachable points to the mesh's.
//!
//! # Complexity
//! At most 2²² cells and about 100 bytes for each; one search of the nearest triangle for each cell
//! near the surface.

mod distance;
mod grid;
mod shell;

use glam::DVec3;

use super::solid::{Solid, SolidKind};
use super::walls::SolidRule;
use grid::Grid;
use hullmap_geometry::PointSet;

/// Cells along the longest side of the grid, at first. A finer grid distinguishes narrower
/// openings.
const CELLS: usize = 160;

/// Cells along the longest side below which no coarser grid is tried.
const FEWEST_CELLS: usize = 40;

/// Maximum number of triangles of the surfaces.
const MAX_TRIANGLES: usize = 60_000;

/// The solid of `mesh`, which is `solid`, with the space that no ball of a radius can reach from
/// outside, as far as that is certain. All lengths are in the unit of the positions. Walls have no
/// inside, and stay as they are.
///
/// # Complexity
/// The cost of [`Solid::new`], plus the cost of the steps of this module.
pub fn with_unreachable(mesh: &PointSet, solid: Solid, radius: f64) -> Solid {
    if solid.kind() == SolidKind::Walls {
        return solid;
    }
    match filled(mesh, &solid, radius) {
        Some(filled) => Solid::by(&filled, SolidRule::Closed),
        None => solid,
    }
}

/// The mesh with surfaces around unreachable space; `None` if all space may be reachable.
fn filled(mesh: &PointSet, solid: &Solid, radius: f64) -> Option<PointSet> {
    let mut count = CELLS;
    while count >= FEWEST_CELLS {
        let grid = Grid::new(solid, radius, count)?;
        let cells = grid.unreachable(solid);
        let (corners, triangles) = shell::shell(&cells, grid.size);
        if triangles.is_empty() {
            return None;
        }
        if triangles.len() <= MAX_TRIANGLES {
            return Some(with_shell(mesh, corners.iter().map(|corner| grid.position(*corner)), triangles));
        }
        count = count * 3 / 4;
    }
    None
}

fn with_shell(mesh: &PointSet, corners: impl Iterator<Item = DVec3>, triangles: Vec<[u32; 3]>) -> PointSet {
    let at = |v: u32| DVec3::from_array(mesh.positions[v as usize].map(f64::from));
    let volume: f64 = mesh.triangles.iter().map(|t| t.map(at)).map(|[a, b, c]| a.cross(b).dot(c)).sum();
    let first = mesh.positions.len() as u32;
    let turned = |[a, b, c]: [u32; 3]| if volume < 0.0 { [a, c, b] } else { [a, b, c] }.map(|v| first + v);
    let mut filled =
        PointSet { triangles: mesh.triangles.clone(), positions: mesh.positions.clone(), ..PointSet::default() };
    filled.positions.extend(corners.map(|p| p.as_vec3().to_array()));
    filled.source_vertices = (0..filled.positions.len() as u32).collect();
    filled.triangles.extend(triangles.into_iter().map(turned));
    filled
}

#[cfg(test)]
mod tests;
