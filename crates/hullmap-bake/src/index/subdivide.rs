//! Adaptive binary subdivision of the cube's faces (Kenwright 4.9), with exact leaves.
//!
//! 1. A cell that at most [`LEAF`] normal cones meet is a leaf, and lists them all.
//! 2. Any other cell is halved: across u, across v, and so on in turn.
//! 3. Where halving hardly parts the cones, the cell is cut by a plane between two of them instead, and so is all below it.
//!
//! Deviations from the paper: it stops where a cell's corners share their support vertex, or at a depth limit, where it
//! then answers wrongly; here the leaf lists every vertex that can be the answer, and a cell whose corners agree is
//! just a leaf of one. Step 3 is new: the cones of a fan (around a facet of many corners, or along a prism's side) are
//! long and thin, and squares small enough to part them are too many, n² of them instead of n.

use hullmap_format::cube::{GRID_BITS, grid_to_uv};

use super::cones::{Cones, Line};
use crate::gauss_map::GaussMap;

/// Most vertices of a plain leaf: the lanes of one block.
pub const LEAF: usize = hullmap_format::archive::LANES;

/// Halving parts the cones well if it lists at most this many times as many as there were.
///
/// A square cell cut from compact cones gains about √k of k, a fan all of them.
const GOOD_HALVING: f64 = 1.6;

/// A plane is worth leaving the grid for if it lists at most this many times as many cones as there were.
const GOOD_PLANE: f64 = 1.25;

/// Cells of fewer cones are never cut by planes while they can be halved: one more halving makes them leaves.
const PLANES_FROM: usize = 2 * LEAF;

/// Vertices from which planes are tried.
const PLANE_SAMPLES: usize = 16;

/// A plane cut must leave at most this share of the cones on its fuller side.
const PROGRESS: f64 = 0.9;

/// Cells of more cones are subdivided in parallel.
const PARALLEL_FROM: usize = 512;

/// A subdivided cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree {
    /// Every vertex whose cone meets the cell, ascending.
    Leaf(Vec<u32>),
    /// Lower and upper half.
    Axis(Box<[Tree; 2]>),
    /// Behind and in front of a plane through the origin.
    Plane([f64; 3], Box<[Tree; 2]>),
}

/// Subdivides one face of the cube.
///
/// # Complexity
/// O(n log n) for n vertices on all families tried; the result does not depend on the number of threads.
pub fn subdivide(map: &GaussMap, face: u32) -> Tree {
    Subdivision { map, face }.cell(Cones::on_face(map, face), [0, 0], 0)
}

struct Subdivision<'a> {
    map: &'a GaussMap,
    face: u32,
}

impl Subdivision<'_> {
    /// Subdivides the cell at grid place `at`, halved `depth` times.
    fn cell(&self, cones: Cones, at: [u32; 2], depth: u32) -> Tree {
        if cones.len() <= LEAF {
            return Tree::Leaf(cones.vertices);
        }
        if depth == 2 * GRID_BITS {
            return self.planes(cones);
        }
        let axis = (depth % 2) as usize;
        let half = 1 << (GRID_BITS - 1 - depth / 2);
        let mut upper = at;
        upper[axis] += half;
        let line = Line::axis(axis, grid_to_uv(upper[axis]));
        let count = cones.len() as f64;
        if cones.len() > PLANES_FROM && cones.count(line).iter().sum::<usize>() as f64 > GOOD_HALVING * count {
            if let Some((_, listed)) = self.best_plane(&cones) {
                if listed as f64 <= GOOD_PLANE * count {
                    return self.planes(cones);
                }
            }
        }
        let (parallel, [behind, front]) = (cones.len() > PARALLEL_FROM, cones.split(line));
        drop(cones);
        let lower = || self.cell(behind, at, depth + 1);
        let upper = || self.cell(front, upper, depth + 1);
        let halves = if parallel { rayon::join(lower, upper) } else { (lower(), upper()) };
        Tree::Axis(Box::new(halves.into()))
    }

    /// Cuts a cell by planes alone.
    fn planes(&self, cones: Cones) -> Tree {
        if cones.len() <= LEAF {
            return Tree::Leaf(cones.vertices);
        }
        let Some((normal, _)) = self.best_plane(&cones) else {
            return Tree::Leaf(cones.vertices);
        };
        let (parallel, [behind, front]) = (cones.len() > PARALLEL_FROM, cones.split(Line::plane(self.face, normal)));
        drop(cones);
        let behind = || self.planes(behind);
        let front = || self.planes(front);
        let halves = if parallel { rayon::join(behind, front) } else { (behind(), front()) };
        Tree::Plane(normal.to_array(), Box::new(halves.into()))
    }

    /// Of some planes between cones of this cell, the one whose fuller side has the fewest, and the sum of both sides.
    fn best_plane(&self, cones: &Cones) -> Option<(glam::DVec3, usize)> {
        let mut best = None;
        let mut fullest = (PROGRESS * cones.len() as f64) as usize;
        for vertex in sample(&cones.vertices) {
            let within =
                self.map.neighbours(vertex).iter().filter(|w| cones.vertices.binary_search(w).is_ok()).copied();
            for neighbour in sample(&within.collect::<Vec<_>>()).take(3) {
                let normal = self.map.plane_between(vertex, neighbour);
                let [behind, front] = cones.count(Line::plane(self.face, normal));
                if behind.max(front) < fullest {
                    fullest = behind.max(front);
                    best = Some((normal, behind + front));
                }
            }
        }
        best
    }
}

/// Up to [`PLANE_SAMPLES`] of `all`, evenly spread.
fn sample(all: &[u32]) -> impl Iterator<Item = u32> + '_ {
    let count = all.len().min(PLANE_SAMPLES);
    (0..count).map(move |i| all[(2 * i + 1) * all.len() / (2 * count)])
}
