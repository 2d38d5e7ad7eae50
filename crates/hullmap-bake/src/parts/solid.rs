//! The solid that a mesh bounds, for any set of triangles: where its winding number is not zero,
//! and its surface.
//!
//! # Steps
//! 1. Merge vertices of equal position, and drop triangles that repeat others. If the mesh is not
//!    closed, merge vertices of its boundary that are closer than 1e-6 of the diagonal.
//! 2. Close holes by cones ([`closing`]). Every point off the surface has an integer winding
//!    number then.
//! 3. A ray counts crossings of triangles by their orientation. If it passes too close to an edge
//!    to be certain, another ray is cast. If all do, the solid angles of all triangles are added.
//!
//! The sign of the winding number is ignored, so that a mesh turned inside out bounds the same
//! solid.
//!
//! # Reference
//! - Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized
//!   winding numbers", 2013.
//! - Van Oosterom, Strackee, "The solid angle of a plane triangle", 1983.
//!
//! # Deviations
//! - Jacobson thresholds a fractional winding number. Closing the holes first makes it an integer,
//!   which can be certified and is constant between the triangles.

use std::{collections::HashMap, ops::ControlFlow};

use glam::DVec3;
pub use hullmap_format::SolidKind;
use rayon::prelude::*;

use super::{
    closing,
    planes::HalfSpace,
    sides,
    triangle::{self, Triangle},
    triangle_tree::{Bounds, TriangleTree},
};
use crate::PointSet;

/// Distance below which vertices of an open boundary are merged, relative to the diagonal.
const WELD: f64 = 1e-6;

/// Bound on rounding errors of lengths, relative to the greatest coordinate. A point this close to
/// a triangle is on it.
const ROUNDING: f64 = 1e-12;

/// Distance from a closing triangle at which either side is tested, relative to the diagonal.
const BESIDE: f64 = 1e-9;

/// Number of triangles beside which the inside of a mesh without volume is looked for.
const SHEET_SAMPLE: usize = 256;

/// Relative error up to which the side of an edge on which a ray passes is uncertain.
const UNCERTAIN: f64 = 1e-13;

/// Number of rays cast before the solid angles are added.
const RAYS: usize = 12;

/// Volume of a mesh without inside, relative to its area times its diagonal.
const SHEET: f64 = 1e-9;

/// The solid that a mesh bounds. Its frame is the frame of the mesh's positions.
pub struct Solid {
    /// Triangles of the mesh, then those that close it.
    triangles: Vec<Triangle>,
    /// Whether the triangle counts for the winding number: others repeat a triangle, or have no
    /// area.
    counts: Vec<bool>,
    mesh_count: usize,
    /// For each closing triangle, whether all of it is in the solid.
    is_whole: Vec<bool>,
    tree: TriangleTree,
    kind: SolidKind,
    diagonal: f64,
    bounds: [DVec3; 2],
    /// Maximum distance by which a vertex was moved.
    moved: f64,
    /// Bound on the rounding error of a distance.
    rounding: f64,
    /// Bound on the error of a distance from a needle.
    needles: f64,
}

/// Why a ray does not decide whether a point is inside.
enum Doubt {
    /// It passes too close to an edge.
    Edge,
    /// The point is on this triangle.
    On(u32),
}

/// Neighbourhood of a point.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Lower bound on the distance of the nearest triangle. Between triangles, all points are on
    /// the same side.
    pub gap: f64,
    /// Upper bound on the distance from the solid.
    pub distance: f64,
    /// A triangle that is near.
    pub triangle: Triangle,
    /// Whether all of the triangle is known to be in the solid. Part of a closing triangle may be
    /// outside.
    pub is_whole: bool,
}

impl Solid {
    /// The solid of a mesh. The positions must be finite.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn new(mesh: &PointSet) -> Self {
        let source: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let used = || mesh.triangles.iter().flatten().map(|v| source[*v as usize]);
        let bounds = [used().fold(DVec3::INFINITY, DVec3::min), used().fold(DVec3::NEG_INFINITY, DVec3::max)];
        let diagonal = if mesh.triangles.is_empty() { 0.0 } else { bounds[0].distance(bounds[1]) };
        let (mut positions, mut indices) = merged(mesh, &source);
        let mut distinct = distinct(&indices);
        let mut cones = closing::cones(&positions, &chosen(&indices, &distinct));
        let mut moved = 0.0;
        if !cones.is_empty() {
            let open = &cones.iter().flat_map(|[to, from, _]| [*to, *from]).collect::<Vec<_>>();
            let welded = weld(&positions, open, WELD * diagonal);
            if let Some(welded) = welded {
                let welded_indices: Vec<[u32; 3]> = indices.iter().map(|t| t.map(|v| welded[v as usize])).collect();
                let welded_distinct = self::distinct(&welded_indices);
                let welded_cones = closing::cones(&positions, &chosen(&welded_indices, &welded_distinct));
                if welded_cones.len() < cones.len() {
                    moved = WELD * diagonal;
                    (indices, distinct, cones) = (welded_indices, welded_distinct, welded_cones);
                }
            }
        }
        let mut triangles: Vec<Triangle> = indices.iter().map(|t| t.map(|v| positions[v as usize])).collect();
        positions.clear();
        let mesh_count = triangles.len();
        let mut counts = distinct;
        counts.resize(mesh_count + cones.len(), true);
        let is_closed = cones.is_empty();
        triangles.append(&mut cones);
        let kind = if is_sheet(&triangles, &counts, diagonal) {
            SolidKind::Sheet
        } else if is_closed {
            SolidKind::Watertight
        } else {
            SolidKind::Closed
        };
        let tree = TriangleTree::new(&triangles);
        let rounding = ROUNDING * bounds[0].abs().max(bounds[1].abs()).max_element().max(0.0);
        let needles = triangles.iter().map(triangle::needle).fold(0.0, f64::max);
        let is_whole = Vec::new();
        let mut solid =
            Self { triangles, counts, mesh_count, is_whole, tree, kind, diagonal, bounds, moved, rounding, needles };
        // Volumes of opposite orientation may have cancelled.
        if kind == SolidKind::Sheet && solid.has_inside() {
            solid.kind = if is_closed { SolidKind::Watertight } else { SolidKind::Closed };
        }
        let closing = mesh_count as u32..solid.triangles.len() as u32;
        solid.is_whole = closing.into_par_iter().map(|index| sides::is_beside_inside(&solid, index)).collect();
        solid
    }

    /// Whether there is an inside next to any of a sample of the triangles.
    fn has_inside(&self) -> bool {
        let step = (self.triangles.len() / SHEET_SAMPLE).max(1);
        self.triangles
            .iter()
            .step_by(step)
            .any(|triangle| self.is_beside_inside(triangle, triangle::centroid(triangle)))
    }

    /// How the solid is known.
    pub fn kind(&self) -> SolidKind {
        self.kind
    }

    /// Diagonal of the box around the mesh.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// The corners of the box around the mesh.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// All triangles that bound or may bound the solid: the mesh's, then those that close it.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Indices of the mesh's own triangles whose boxes touch a box.
    pub fn surface_in(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = self.triangles_in(low, high);
        found.retain(|index| (*index as usize) < self.mesh_count);
        found
    }

    /// Indices of the triangles whose boxes touch a box.
    pub fn triangles_in(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        let touches = |own: &Bounds| own.low.cmple(high).all() && own.high.cmpge(low).all();
        let take = |index| {
            found.push(index);
            ControlFlow::<()>::Continue(())
        };
        let _ = self.tree.visit(touches, take);
        found
    }

    /// A triangle with a corner in or above a plane, within `radius` of a point; `None` if there is
    /// none. Triangles a little farther away may be found, too.
    pub fn triangle_above(&self, plane: &HalfSpace, p: DVec3, radius: f64) -> Option<Triangle> {
        let is_high = plane.normal.cmpge(DVec3::ZERO);
        let is_near = |&Bounds { low, high }: &Bounds| {
            // Written so that NaN is near.
            !((low - p).max(p - high).max(DVec3::ZERO).length_squared() > radius * radius)
                && !(plane.height(DVec3::select(is_high, high, low)) < 0.0)
        };
        let is_found = |corners: &Triangle| {
            corners.iter().any(|corner| !(plane.height(*corner) < 0.0))
                && !(triangle::nearest(corners, p).distance(p) > radius)
        };
        let take = |index| {
            let corners = self.triangles[index as usize];
            if is_found(&corners) { ControlFlow::Break(corners) } else { ControlFlow::Continue(()) }
        };
        self.tree.visit(is_near, take).break_value()
    }

    /// Maximum error of distances: vertices that were moved together, needles, and rounding.
    pub fn tolerance(&self) -> f64 {
        self.moved + self.needles + self.rounding
    }

    /// Whether a point is in the solid. A point within [`tolerance`](Self::tolerance) of its
    /// surface may be either.
    pub fn is_inside(&self, p: DVec3) -> bool {
        if self.kind == SolidKind::Sheet || self.is_outside_bounds(p) {
            return false;
        }
        for ray in 0..RAYS {
            match self.crossings(p, ray_direction(ray)) {
                Ok(winding) => return winding != 0,
                Err(Doubt::Edge) => {}
                Err(Doubt::On(index)) if (index as usize) < self.mesh_count => return true,
                Err(Doubt::On(index)) => return self.is_beside_inside(&self.triangles[index as usize], p),
            }
        }
        self.solid_angles(p) != 0
    }

    /// Winding number of the surface about a point, with its sign; `None` if the point is so close
    /// to triangles that no ray is certain.
    pub fn winding_number(&self, p: DVec3) -> Option<i32> {
        if self.is_outside_bounds(p) {
            return Some(0);
        }
        (0..RAYS).find_map(|ray| self.crossings(p, ray_direction(ray)).ok())
    }

    /// Distance of a point from the nearest triangle that does not lie in `plane`; at most the
    /// diagonal.
    pub fn clearance(&self, p: DVec3, plane: &HalfSpace) -> f64 {
        let is_in_plane = |corner: &DVec3| plane.height(*corner).abs() <= self.tolerance();
        let counts = |index: usize| !self.triangles[index].iter().all(is_in_plane);
        self.nearest(p, self.diagonal, counts).map_or(self.diagonal, |(distance, _)| distance)
    }

    fn is_outside_bounds(&self, p: DVec3) -> bool {
        (self.bounds[0] - p).max(p - self.bounds[1]).max_element() > 0.0
    }

    /// Upper bound on the distance of a point from the solid; 0 inside. It is the distance itself,
    /// except for rounding, near the mesh's own triangles.
    pub fn distance(&self, p: DVec3) -> f64 {
        if self.is_inside(p) {
            return 0.0;
        }
        self.near(p, f64::INFINITY).map_or(f64::INFINITY, |near| near.distance)
    }

    /// Neighbourhood of a point; `None` if nothing is closer than `within`, which must exceed the
    /// distance from the solid to make `distance` an upper bound.
    pub fn near(&self, p: DVec3, within: f64) -> Option<Near> {
        let (gap, index) = self.nearest(p, within, |_| true)?;
        let triangle = self.triangles[index];
        let is_whole =
            index < self.mesh_count || self.is_whole.get(index - self.mesh_count).is_some_and(|whole| *whole);
        let gap_least = (gap - self.tolerance()).max(0.0);
        let mut near = Near { gap: gap_least, distance: gap + self.tolerance(), triangle, is_whole };
        if !is_whole {
            if self.is_beside_inside(&triangle, p) {
                near.distance += BESIDE * self.diagonal;
            } else {
                let (distance, index) = self.nearest(p, f64::INFINITY, |index| index < self.mesh_count)?;
                (near.distance, near.triangle) = (distance + self.tolerance(), self.triangles[index]);
                near.is_whole = true;
            }
        }
        Some(near)
    }

    /// Neighbourhood of a point, given a triangle that is probably close, and a length that exceeds
    /// the distance from the solid.
    pub fn near_beside(&self, p: DVec3, within: f64, hint: Option<&Triangle>) -> Option<Near> {
        let to_hint = hint.map_or(f64::INFINITY, |hint| triangle::nearest(hint, p).distance(p));
        // Room for the rounding error of both lengths.
        self.near(p, within.min(to_hint) * (1.0 + 1e-9) + self.tolerance())
    }

    /// The nearest of the triangles that `counts`, with its distance.
    fn nearest(&self, p: DVec3, within: f64, counts: impl Fn(usize) -> bool) -> Option<(f64, usize)> {
        // Squares, because roots take time.
        let to_box = |own: &Bounds| (own.low - p).max(p - own.high).max(DVec3::ZERO).length_squared();
        let to_triangle = |index: u32| {
            let index = index as usize;
            counts(index).then(|| triangle::nearest(&self.triangles[index], p).distance_squared(p))
        };
        let (square, index) = self.tree.lowest((within * within).min(f64::MAX), to_box, to_triangle)?;
        Some((square.sqrt(), index as usize))
    }

    /// Whether the point of a closing triangle nearest to `p` is next to the inside.
    fn is_beside_inside(&self, closing: &Triangle, p: DVec3) -> bool {
        let [a, b, c] = *closing;
        let foot = triangle::nearest(closing, p);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
        let step = normal * BESIDE * self.diagonal;
        [foot + step, foot - step]
            .into_iter()
            .any(|beside| self.winding_number(beside).is_some_and(|winding| winding != 0))
    }

    /// Winding number, as the signed number of triangles that a ray crosses.
    fn crossings(&self, p: DVec3, direction: DVec3) -> Result<i32, Doubt> {
        let inverse = direction.recip();
        let margin = self.rounding;
        let is_hit = |own: &Bounds| {
            let (s, t) = ((own.low - p - margin) * inverse, (own.high - p + margin) * inverse);
            let (enter, leave) = (s.min(t).max_element(), s.max(t).min_element());
            leave >= 0.0 && enter <= leave
        };
        let mut winding = 0;
        let count = |index: u32| {
            if !self.counts[index as usize] {
                return ControlFlow::Continue(());
            }
            let triangle = &self.triangles[index as usize];
            match crossing(triangle, p, direction) {
                Some(crossed) => winding += crossed,
                None if triangle::nearest(triangle, p).distance(p) <= self.rounding => {
                    return ControlFlow::Break(Doubt::On(index));
                }
                None => return ControlFlow::Break(Doubt::Edge),
            }
            ControlFlow::Continue(())
        };
        match self.tree.visit(is_hit, count) {
            ControlFlow::Break(doubt) => Err(doubt),
            ControlFlow::Continue(()) => Ok(winding),
        }
    }

    /// Winding number as the sum of all solid angles, which is slow and always certain enough: its
    /// error is far below a half.
    pub(super) fn solid_angles(&self, p: DVec3) -> i32 {
        let mut sum = 0.0;
        for ([a, b, c], counts) in self.triangles.iter().zip(&self.counts) {
            if *counts {
                let [a, b, c] = [*a - p, *b - p, *c - p];
                let [la, lb, lc] = [a.length(), b.length(), c.length()];
                let volume = a.dot(b.cross(c));
                let scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
                sum += 2.0 * libm::atan2(volume, scale);
            }
        }
        let turns = sum / (4.0 * std::f64::consts::PI);
        turns.round() as i32
    }
}

/// Directions of rays, none of which is parallel to common edges.
fn ray_direction(index: usize) -> DVec3 {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    let z = 1.0 - (2 * index + 1) as f64 / RAYS as f64;
    let radius = (1.0 - z * z).sqrt();
    // The first angle is arbitrary.
    let angle = GOLDEN * index as f64 + 0.381;
    DVec3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
}

/// −1, 0 or 1: how a ray from `p` crosses a triangle; `None` if that is uncertain.
fn crossing(triangle: &Triangle, p: DVec3, direction: DVec3) -> Option<i32> {
    let [a, b, c] = triangle.map(|corner| corner - p);
    let ahead = [a, b, c].map(|corner| corner.dot(direction));
    let size = a.abs().max(b.abs()).max(c.abs()).max_element();
    if ahead.iter().all(|along| *along < -UNCERTAIN * size) {
        return Some(0);
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let volume = direction.dot(from.cross(to));
        let error = UNCERTAIN * from.length() * to.length();
        if volume > error {
            1
        } else if volume < -error {
            -1
        } else {
            0
        }
    });
    if sides.contains(&1) && sides.contains(&-1) {
        return Some(0);
    }
    if sides.contains(&0) {
        return None;
    }
    // The line crosses the triangle. The ray does if the plane lies ahead.
    let is_ahead = if ahead.iter().all(|along| *along > UNCERTAIN * size) {
        true
    } else {
        let normal = (b - a).cross(c - a);
        let height = a.dot(normal);
        // Edges may be much shorter than their distance, so the normal's error is that of the
        // edges.
        let error = UNCERTAIN * size * (b - a).length() * (c - a).length();
        if height.abs() <= error {
            return None;
        }
        (height > 0.0) == (direction.dot(normal) > 0.0)
    };
    Some(if is_ahead { sides[0] } else { 0 })
}

/// Distinct positions, and the mesh's triangles as their indices.
fn merged(mesh: &PointSet, source: &[DVec3]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut order: Vec<u32> = (0..source.len() as u32).collect();
    let key = |v: u32| (source[v as usize] + 0.0).to_array().map(f64::to_bits);
    order.sort_unstable_by_key(|v| (key(*v), *v));
    let mut first = vec![0; source.len()];
    for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
        for v in same {
            first[*v as usize] = same[0];
        }
    }
    (source.to_vec(), mesh.triangles.iter().map(|t| t.map(|v| first[v as usize])).collect())
}

/// Whether each triangle is the first with its corners, in any order, and has three of them.
fn distinct(triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut keys: Vec<([u32; 3], usize)> = triangles
        .iter()
        .enumerate()
        .map(|(index, t)| {
            let mut key = *t;
            key.sort_unstable();
            (key, index)
        })
        .collect();
    keys.sort_unstable();
    let mut distinct = vec![false; triangles.len()];
    for same in keys.chunk_by(|a, b| a.0 == b.0) {
        let ([a, b, c], index) = same[0];
        distinct[index] = a != b && b != c;
    }
    distinct
}

/// The distinct triangles.
fn chosen(triangles: &[[u32; 3]], distinct: &[bool]) -> Vec<[u32; 3]> {
    triangles.iter().zip(distinct).filter(|(_, distinct)| **distinct).map(|(t, _)| *t).collect()
}

/// For each vertex, the vertex with which it is merged: those at `open` positions that are closer
/// than `distance` to an earlier one. `None` if no vertices are merged.
fn weld(positions: &[DVec3], open: &[DVec3], distance: f64) -> Option<Vec<u32>> {
    let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let open: std::collections::HashSet<[u64; 3]> = open.iter().map(|p| bits(*p)).collect();
    let mut welded: Vec<u32> = (0..positions.len() as u32).collect();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut is_changed = false;
    if !(distance > 0.0) {
        return None;
    }
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    for (v, &p) in positions.iter().enumerate() {
        if !open.contains(&bits(p)) {
            continue;
        }
        let cell = ((p - low) / distance).to_array().map(|c| c as i64);
        let around = (0..27).map(|i| [cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1]);
        let near = around
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .filter(|w| positions[**w as usize].distance(p) <= distance)
            .min();
        match near {
            Some(&w) => {
                is_changed |= positions[w as usize] != p;
                welded[v] = w;
            }
            None => cells.entry(cell).or_default().push(v as u32),
        }
    }
    is_changed.then_some(welded)
}

/// Whether triangles enclose next to no volume.
fn is_sheet(triangles: &[Triangle], counts: &[bool], diagonal: f64) -> bool {
    let Some(&[origin, ..]) = triangles.first() else { return true };
    let (mut volume, mut area) = (0.0, 0.0);
    for ([a, b, c], _) in triangles.iter().zip(counts).filter(|(_, counts)| **counts) {
        let normal = (*b - *a).cross(*c - *a);
        volume += (*a - origin).dot(normal) / 6.0;
        area += normal.length() / 2.0;
    }
    // NaN counts as a sheet.
    !(volume.abs() > SHEET * area * diagonal)
}
