//! Volume, centre of mass and second moments of the solid that a closed mesh bounds.
//!
//! # Steps
//! 1. Merge vertices of equal position. Triangles of the same corners become one, or none if they
//!    face opposite ways. If the mesh is open, merge vertices of its boundary that are closer than
//!    1e-6 of the diagonal.
//! 2. If it is still open, or not consistently oriented, nothing is known.
//! 3. Add the tetrahedra between the centre of the mesh's box and each triangle, with signs and
//!    compensated sums. That is the integral of the winding number. If it is negative, the mesh is
//!    inside out, and counts as turned.
//! 4. The solid is where the winding number is not 0. Where shells overlap, it is 2 or more, and
//!    the sum counts the place as often. The excess is estimated from one point in each cell of a
//!    grid. If a coarser grid finds no overlap, the result is the sum, exact except for rounding.
//!
//! # Reference
//! - Mirtich, "Fast and accurate computation of polyhedral mass properties", 1996.
//! - Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen", 1974: sums
//!   with compensation.
//!
//! # Deviations
//! - Mirtich integrates over projections of faces. Tetrahedra have a closed form that the hulls'
//!   [`mass`](crate::mass) needs, too.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{
    closing,
    solid::{MERGE_DISTANCE, SHEET, merge_open, merged},
    winding::ClosedSurface,
};
use crate::{
    mass::{Mass, Simplices, entries, outer},
    spread::spread,
};
use hullmap_geometry::{
    PointSet, bounds,
    triangle::{Triangle, from_least},
};

/// Grid cells along each edge of the mesh's box to find overlaps: smaller ones may be missed.
const SEARCHED_CELLS: usize = 16;

/// Cells along each edge of the mesh's box, when overlaps are measured.
const MEASURED_CELLS: usize = 32;

/// Mass properties of the solid that `mesh` bounds, in the frame of its positions. `None` if the
/// mesh has no triangles, is open or inconsistently oriented, or encloses next to no volume.
///
/// The positions must be finite. Where parts of the surface overlap, the error is about a hundredth
/// of the overlap; elsewhere it is rounding error.
///
/// # Complexity
/// O((n + p) log n) for n triangles and p points, on all threads of the pool; p is constant.
pub fn mesh_mass(mesh: &PointSet) -> Option<Mass> {
    let triangles = closed(mesh)?;
    let bounds = bounds(triangles.iter().flatten().copied());
    let origin = (bounds[0] + bounds[1]) / 2.0;
    let (mut sum, mut area) = (Compensated::default(), 0.0);
    for [a, b, c] in &triangles {
        let [a, b, c] = [*a - origin, *b - origin, *c - origin];
        let cross = (b - a).cross(c - a);
        sum.add(Simplices::from_simplex(a.dot(cross) / 6.0, &[DVec3::ZERO, a, b, c]));
        area += cross.length() / 2.0;
    }
    let mut total = sum.total();
    let sign = if total.measure < 0.0 { -1.0 } else { 1.0 };
    let counts = vec![true; triangles.len()];
    let surface = ClosedSurface::new(triangles, counts, bounds, 0.0);
    let excess = excess(&surface, sign as i32, origin);
    total.measure = total.measure * sign - excess.measure;
    total.first = total.first * sign - excess.first;
    total.second = total.second * sign - excess.second;
    // NaN takes the failing branch.
    if !(total.measure > SHEET * area * surface.diagonal) {
        return None;
    }
    let (centroid, moments) = total.centroid_and_moments();
    let centroid = (centroid + origin).to_array();
    Some(Mass { volume: total.measure, surface_area: area, centroid, second_moments: entries(moments) })
}

/// The triangles of a mesh, if they are closed and consistently oriented: each edge is used as
/// often in one direction as in the other.
fn closed(mesh: &PointSet) -> Option<Vec<Triangle>> {
    if mesh.triangles.is_empty() {
        return None;
    }
    let (positions, indices) = merged(mesh);
    let mut net = net(&indices);
    let boundary = closing::boundary(&net);
    if !boundary.is_empty() {
        let [low, high] = bounds(indices.iter().flatten().map(|v| positions[*v as usize]));
        let ends = boundary.iter().flat_map(|(from, to)| std::iter::once(from).chain(to));
        let open: Vec<DVec3> = ends.map(|v| positions[*v as usize]).collect();
        let joined = merge_open(&positions, &open, MERGE_DISTANCE * low.distance(high))?;
        let indices: Vec<[u32; 3]> = indices.iter().map(|t| t.map(|v| joined[v as usize])).collect();
        net = self::net(&indices);
        if !closing::boundary(&net).is_empty() {
            return None;
        }
    }
    Some(net.iter().map(|t| t.map(|v| positions[v as usize])).collect())
}

/// Merges triangles of the same corners into one, oriented as most of them; none in a tie.
fn net(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut keys: Vec<([u32; 3], i32)> = Vec::with_capacity(triangles.len());
    for &[a, b, c] in triangles {
        if a == b || b == c || c == a {
            continue;
        }
        // The lowest corner first. The order of the others states the orientation.
        let [a, b, c] = from_least([a, b, c]);
        keys.push(if b < c { ([a, b, c], 1) } else { ([a, c, b], -1) });
    }
    keys.par_sort_unstable();
    let same = keys.chunk_by(|a, b| a.0 == b.0);
    same.filter_map(|same| match same.iter().map(|(_, sign)| sign).sum::<i32>().signum() {
        1 => Some(same[0].0),
        -1 => Some([same[0].0[0], same[0].0[2], same[0].0[1]]),
        _ => None,
    })
    .collect()
}

/// The integral of the winding number minus the integral over the solid, about `origin`.
fn excess(surface: &ClosedSurface, sign: i32, origin: DVec3) -> Simplices {
    let mut sum = Simplices::ZERO;
    if surplus(surface, sign, SEARCHED_CELLS).is_empty() {
        return sum;
    }
    let [low, high] = surface.bounds;
    let cell = (high - low).element_product() / (MEASURED_CELLS * MEASURED_CELLS * MEASURED_CELLS) as f64;
    for (p, surplus) in surplus(surface, sign, MEASURED_CELLS) {
        let (p, volume) = (p - origin, cell * f64::from(surplus));
        sum.measure += volume;
        sum.first += p * volume;
        sum.second += outer(p) * volume;
    }
    sum
}

/// A point in each cell of a grid, and what its winding number exceeds 0 or 1 by, where it does.
fn surplus(surface: &ClosedSurface, sign: i32, cells: usize) -> Vec<(DVec3, i32)> {
    let [low, high] = surface.bounds;
    let at = |k: usize| {
        let cell = [k % cells, k / cells % cells, k / (cells * cells)].map(|index| index as f64);
        let p = low + (high - low) * (DVec3::from_array(cell) + DVec3::from_array(spread(k))) / cells as f64;
        // A point on the surface decides nothing.
        let winding = surface.winding_number(p).map_or(0, |winding| winding * sign);
        (p, winding - i32::from(winding != 0))
    };
    (0..cells * cells * cells).into_par_iter().map(at).filter(|(_, surplus)| *surplus != 0).collect()
}

/// Compensated sums: tetrahedra of faces towards the origin count negatively, and cancel others.
#[derive(Default)]
struct Compensated {
    sum: [f64; 10],
    lost: [f64; 10],
}

impl Compensated {
    fn add(&mut self, terms: Simplices) {
        let second = entries(terms.second);
        let first = terms.first.to_array();
        let terms = std::iter::once(terms.measure).chain(first).chain(second);
        for ((sum, lost), term) in self.sum.iter_mut().zip(&mut self.lost).zip(terms) {
            let next = *sum + term;
            *lost += if sum.abs() >= term.abs() { (*sum - next) + term } else { (term - next) + *sum };
            *sum = next;
        }
    }

    fn total(&self) -> Simplices {
        let [measure, x, y, z, xx, yy, zz, yz, zx, xy] = std::array::from_fn(|k| self.sum[k] + self.lost[k]);
        Simplices {
            measure,
            first: DVec3::new(x, y, z),
            second: DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz)),
        }
    }
}

#[cfg(test)]
mod tests;
