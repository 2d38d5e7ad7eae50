//! The solid that a mesh bounds, for any set of triangles: where its winding number is not zero,
//! and its surface. Walls ([`SolidRule`]) bound no inside: only their triangles count.
//!
//! # Steps
//! 1. Take the mesh in its [frame](Frame), so that another order of its triangles gives the same
//!    solid. Merge vertices of equal position, and drop triangles that repeat others. If the mesh
//!    is not closed, merge vertices of its boundary that are closer than 1e-6 of the diagonal.
//! 2. Turn round triangles that face the other way than their surface, and close holes by cones
//!    ([`closing`]). Every point off the surface has an integer winding number then.
//!    Where the two sides of a surface cancel, only the outer one counts.
//! 3. Cast rays that count crossings of triangles ([`winding`](super::winding)). If none is
//!    certain, add the solid angles of all triangles.
//!
//! The sign of the winding number is ignored: a mesh turned inside out bounds the same solid.
//!
//! # Reference
//! - Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized
//!   winding numbers", 2013.
//!
//! # Deviations
//! - Jacobson thresholds a fractional winding number. Closing the holes first makes it an integer,
//!   which can be certified and is constant between the triangles.

use std::{
    cell::Cell,
    collections::{HashMap, HashSet},
    ops::ControlFlow,
};

use glam::DVec3;
pub use hullmap_format::SolidKind;
use rayon::prelude::*;

use super::{
    closing,
    frame::Frame,
    sides,
    triangle_tree::{Bounds, TriangleTree},
    walls::SolidRule,
    winding::{ClosedSurface, Doubt, RAYS, ray_direction},
};
use hullmap_geometry::{
    PointSet, bits, bounds,
    planes::HalfSpace,
    triangle::{self, Triangle},
};

/// Distance below which vertices of an open boundary are merged, relative to the diagonal.
pub(super) const MERGE_DISTANCE: f64 = 1e-6;

/// Distance from a closing triangle at which either side is tested, relative to the diagonal.
const BESIDE: f64 = 1e-9;

/// Number of triangles at which the inside of a mesh without volume is searched for.
const SHEET_SAMPLE: usize = 256;

/// Volume of a mesh without inside, relative to its area times its diagonal.
pub(super) const SHEET: f64 = 1e-9;

/// The solid that a mesh bounds. Its frame is the frame of the mesh's positions.
pub struct Solid {
    surface: ClosedSurface,
    mesh_count: usize,
    /// For each closing triangle, whether all of it is in the solid.
    is_whole: Vec<bool>,
    /// Whether there is no inside.
    is_hollow: bool,
    kind: SolidKind,
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

impl Near {
    /// Upper bound on the distance from the solid of all points of a box around the point. The
    /// distance from a triangle is a convex function, so it is greatest at a corner.
    pub fn bound_in_box(&self, centre: DVec3, half: DVec3) -> f64 {
        let by_radius = self.distance + half.length();
        if !self.is_whole {
            return by_radius;
        }
        let corner = |i: usize| centre + half * DVec3::from_array([0, 1, 2].map(|axis| [-1.0, 1.0][i >> axis & 1]));
        let distance = |p: DVec3| triangle::nearest(&self.triangle, p).distance(p);
        (0..8).map(|i| distance(corner(i))).fold(self.distance, f64::max).min(by_radius)
    }
}

impl Solid {
    /// The solid of a mesh, by the rule [`Auto`](SolidRule::Auto). The positions must be finite.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn new(mesh: &PointSet) -> Self {
        Self::by(mesh, SolidRule::Auto)
    }

    /// The solid of a mesh by a rule. The positions must be finite.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn by(mesh: &PointSet, rule: SolidRule) -> Self {
        let frame = Frame::new(mesh);
        Self::in_frame(&frame.of_mesh(mesh), rule).in_source(&frame)
    }

    /// The solid of a mesh that is in its frame. In the frame of the source, it is the same.
    pub fn in_frame(mesh: &PointSet, rule: SolidRule) -> Self {
        let bounds = bounds(mesh.triangles.iter().flatten().map(|v| mesh.at(*v)));
        let diagonal = if mesh.triangles.is_empty() { 0.0 } else { bounds[0].distance(bounds[1]) };
        let (positions, mut indices) = merged(mesh);
        let mut distinct = distinct(&indices);
        if let Some(outward) = outward_layers(&positions, &indices, &distinct, bounds) {
            distinct = outward;
        }
        let mut cones = close(&positions, &mut indices, &distinct);
        let mut moved = 0.0;
        if !cones.is_empty() {
            let open = &cones.iter().flatten().flat_map(|[to, from, _]| [*to, *from]).collect::<Vec<_>>();
            let merged = merge_open(&positions, open, MERGE_DISTANCE * diagonal);
            if let Some(merged) = merged {
                let mut merged_indices: Vec<[u32; 3]> = indices.iter().map(|t| t.map(|v| merged[v as usize])).collect();
                let merged_distinct = self::distinct(&merged_indices);
                let merged_cones = close(&positions, &mut merged_indices, &merged_distinct);
                let count = |cones: &[Vec<Triangle>]| cones.iter().map(Vec::len).sum::<usize>();
                if count(&merged_cones) < count(&cones) {
                    moved = MERGE_DISTANCE * diagonal;
                    (indices, distinct, cones) = (merged_indices, merged_distinct, merged_cones);
                }
            }
        }
        let mut triangles: Vec<Triangle> = indices.iter().map(|t| t.map(|v| positions[v as usize])).collect();
        let mesh_count = triangles.len();
        let is_closed = cones.is_empty();
        let walls = rule.walls(&positions, &indices, &distinct, is_closed);
        let is_walls = walls.is_some();
        let mut counts = distinct;
        if let Some(walls) = walls {
            counts.iter_mut().zip(walls).for_each(|(counts, is_wall)| *counts &= !is_wall);
            cones = closing::cones(&positions, &chosen(&indices, &counts));
        }
        triangles.extend(cones.into_iter().flatten());
        counts.resize(triangles.len(), true);
        let is_hollow = is_flat(&triangles, &counts, diagonal);
        let mut solid = Self { mesh_count, ..Self::of_triangles(triangles, counts, bounds, moved) };
        // Volumes of opposite orientation may have cancelled.
        solid.is_hollow = is_hollow && !solid.has_inside();
        if !is_walls && !solid.is_hollow {
            solid.kind = if is_closed { SolidKind::Watertight } else { SolidKind::Closed };
        }
        let closing = mesh_count as u32..solid.surface.triangles.len() as u32;
        solid.is_whole = closing.into_par_iter().map(|index| sides::is_beside_inside(&solid.surface, index)).collect();
        solid
    }

    fn of_triangles(triangles: Vec<Triangle>, counts: Vec<bool>, bounds: [DVec3; 2], moved: f64) -> Self {
        let mesh_count = triangles.len();
        let surface = ClosedSurface::new(triangles, counts, bounds, moved);
        Self { surface, mesh_count, is_whole: Vec::new(), is_hollow: false, kind: SolidKind::Walls }
    }

    fn in_source(mut self, frame: &Frame) -> Self {
        let ClosedSurface { triangles, tree, bounds, .. } = &mut self.surface;
        triangles.iter_mut().flatten().for_each(|p| *p = frame.to_source(*p));
        if frame.is_mirrored() {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        *tree = TriangleTree::new(triangles);
        let [p, q] = bounds.map(|p| frame.to_source(p));
        *bounds = [p.min(q), p.max(q)];
        self
    }

    fn has_inside(&self) -> bool {
        let step = (self.surface.triangles.len() / SHEET_SAMPLE).max(1);
        let counted = self.surface.triangles.iter().zip(&self.surface.counts).filter(|(_, counts)| **counts);
        let mut sample = counted.map(|(triangle, _)| triangle).step_by(step);
        sample.any(|triangle| self.is_beside_inside(triangle, triangle::centroid(triangle)))
    }

    /// Whether the solid has no inside.
    pub fn is_hollow(&self) -> bool {
        self.is_hollow
    }

    /// Whether a triangle bounds the inside. Walls do not, nor do triangles that repeat another.
    pub fn bounds_inside(&self, index: usize) -> bool {
        !self.is_hollow && self.surface.counts[index]
    }

    /// The first point after `p` along a unit vector at which a ray meets a triangle.
    pub fn first_hit(&self, p: DVec3, direction: DVec3) -> Option<DVec3> {
        let start = BESIDE * self.surface.diagonal;
        let inverse = direction.recip();
        let of_box = |own: &Bounds| {
            let (s, t) = ((own.low - p) * inverse, (own.high - p) * inverse);
            let (enter, leave) = (s.min(t).max_element(), s.max(t).min_element());
            if leave >= enter.max(0.0) { enter } else { f64::INFINITY }
        };
        let of_triangle = |index: u32| {
            let [a, b, c] = self.surface.triangles[index as usize];
            let (u, v) = (b - a, c - a);
            let cross = direction.cross(v);
            let inverse = u.dot(cross).recip();
            let from = p - a;
            let s = from.dot(cross) * inverse;
            let turned = from.cross(u);
            let t = direction.dot(turned) * inverse;
            let distance = v.dot(turned) * inverse;
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance > start).then_some(distance)
        };
        let (distance, _) = self.surface.tree.lowest(2.0 * self.surface.diagonal, of_box, of_triangle)?;
        Some(p + direction * distance)
    }

    /// How the solid is known.
    pub fn kind(&self) -> SolidKind {
        self.kind
    }

    /// Diagonal of the box around the mesh.
    pub fn diagonal(&self) -> f64 {
        self.surface.diagonal
    }

    /// The corners of the box around the mesh.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.surface.bounds
    }

    /// Area of the triangles that close holes, relative to the area of the mesh's own; 0 for a
    /// watertight mesh.
    ///
    /// # Complexity
    /// O(n) for n triangles.
    pub fn hole_share(&self) -> f64 {
        let (own, closing) = self.surface.triangles.split_at(self.mesh_count);
        let [own, closing] = [own, closing]
            .map(|triangles| triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length()).sum::<f64>());
        if closing > 0.0 { closing / own } else { 0.0 }
    }

    /// Number of the mesh's own triangles, which come first.
    pub fn mesh_count(&self) -> usize {
        self.mesh_count
    }

    /// All triangles that bound or may bound the solid: the mesh's, then the closing ones.
    pub fn triangles(&self) -> &[Triangle] {
        &self.surface.triangles
    }

    /// The closed surface around the solid.
    pub fn surface(&self) -> &ClosedSurface {
        &self.surface
    }

    /// Indices of the mesh's own triangles whose boxes touch a box.
    pub fn surface_in(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = self.surface.triangles_in(low, high);
        found.retain(|index| (*index as usize) < self.mesh_count);
        found
    }

    /// Indices of the triangles whose boxes touch a box.
    pub fn triangles_in(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        self.surface.triangles_in(low, high)
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
            let corners = self.surface.triangles[index as usize];
            if is_found(&corners) { ControlFlow::Break(corners) } else { ControlFlow::Continue(()) }
        };
        self.surface.tree.visit(is_near, take).break_value()
    }

    /// Least and greatest height along `normal` of all triangles within `radius` of a point; `None`
    /// without triangles, or if they are more than `most` apart. Parts beyond the radius may count.
    pub fn heights_near(&self, normal: DVec3, p: DVec3, radius: f64, most: f64) -> Option<[f64; 2]> {
        let heights = Cell::new([f64::INFINITY, f64::NEG_INFINITY]);
        let is_known = |low: f64, high: f64| {
            let [least, greatest] = heights.get();
            low >= least && high <= greatest
        };
        let is_high = normal.cmpge(DVec3::ZERO);
        let matters = |&Bounds { low, high }: &Bounds| {
            // Written so that NaN is near.
            !((low - p).max(p - high).max(DVec3::ZERO).length_squared() > radius * radius)
                && !is_known(
                    normal.dot(DVec3::select(is_high, low, high)),
                    normal.dot(DVec3::select(is_high, high, low)),
                )
        };
        let take = |index| {
            let corners = &self.surface.triangles[index as usize];
            let [low, high] = triangle::heights_in_ball(corners, normal, p, radius);
            if is_known(low, high) || triangle::nearest(corners, p).distance(p) > radius {
                return ControlFlow::Continue(());
            }
            let [least, greatest] = heights.get();
            let [least, greatest] = [least.min(low), greatest.max(high)];
            heights.set([least, greatest]);
            // Written so that NaN breaks.
            if greatest - least <= most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let is_too_far_apart = self.surface.tree.visit(matters, take).is_break();
        Some(heights.get()).filter(|[least, greatest]| !is_too_far_apart && least <= greatest)
    }

    /// Maximum error of distances: vertices that were moved together, needles, and rounding.
    pub fn tolerance(&self) -> f64 {
        self.surface.tolerance()
    }

    /// Whether a point is in the solid. A point within [`tolerance`](Self::tolerance) of its
    /// surface may be either.
    pub fn is_inside(&self, p: DVec3) -> bool {
        if self.is_hollow || self.surface.is_outside_bounds(p) {
            return false;
        }
        for ray in 0..RAYS {
            match self.surface.crossings(p, ray_direction(ray)) {
                Ok(winding) => return winding != 0,
                Err(Doubt::Edge) => {}
                Err(Doubt::On(index)) if (index as usize) < self.mesh_count => return true,
                Err(Doubt::On(index)) => return self.is_beside_inside(&self.surface.triangles[index as usize], p),
            }
        }
        self.surface.solid_angles(p) != 0
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
        let (gap, index) = self.surface.nearest(p, within, |_| true)?;
        let triangle = self.surface.triangles[index];
        let is_whole =
            index < self.mesh_count || self.is_whole.get(index - self.mesh_count).is_some_and(|whole| *whole);
        let gap_least = (gap - self.surface.tolerance()).max(0.0);
        let mut near = Near { gap: gap_least, distance: gap + self.surface.tolerance(), triangle, is_whole };
        if !is_whole {
            if self.is_beside_inside(&triangle, p) {
                near.distance += BESIDE * self.surface.diagonal;
            } else {
                let (distance, index) = self.surface.nearest(p, f64::INFINITY, |index| index < self.mesh_count)?;
                (near.distance, near.triangle) = (distance + self.surface.tolerance(), self.surface.triangles[index]);
                near.is_whole = true;
            }
        }
        Some(near)
    }

    /// Whether a point is within a distance of the solid, up to rounding error, as by
    /// [`near`](Self::near). Any of the mesh's own triangles that is near suffices.
    pub fn is_near(&self, p: DVec3, limit: f64) -> bool {
        self.surface.has_triangle_within(p, limit, |index| index < self.mesh_count)
            || self.surface.triangles.len() > self.mesh_count
                && self.near(p, limit).is_some_and(|near| near.distance <= limit)
    }

    /// Neighbourhood of a point, given a triangle that is probably close, and a length that exceeds
    /// the distance from the solid.
    pub fn near_beside(&self, p: DVec3, within: f64, hint: Option<&Triangle>) -> Option<Near> {
        let to_hint = hint.map_or(f64::INFINITY, |hint| triangle::nearest(hint, p).distance(p));
        // Room for the rounding error of both lengths.
        self.near(p, within.min(to_hint) * (1.0 + 1e-9) + self.surface.tolerance())
    }

    fn is_beside_inside(&self, closing: &Triangle, p: DVec3) -> bool {
        let [a, b, c] = *closing;
        let foot = triangle::nearest(closing, p);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
        let step = normal * BESIDE * self.surface.diagonal;
        [foot + step, foot - step]
            .into_iter()
            .any(|beside| self.surface.winding_number(beside).is_some_and(|winding| winding != 0))
    }
}

/// Distinct positions in an order that does not depend on the mesh's, and the mesh's triangles as
/// their indices.
pub(super) fn merged(mesh: &PointSet) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let source = mesh.points();
    let mut order: Vec<u32> = (0..source.len() as u32).collect();
    let key = |v: u32| bits(source[v as usize]);
    order.sort_unstable_by_key(|v| key(*v));
    let (mut index, mut positions) = (vec![0; source.len()], Vec::new());
    for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
        same.iter().for_each(|v| index[*v as usize] = positions.len() as u32);
        positions.push(source[same[0] as usize] + 0.0);
    }
    (positions, mesh.triangles.iter().map(|t| t.map(|v| index[v as usize])).collect())
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

/// The triangles that face outward, where all surfaces are closed and have faces on both sides.
/// Those on the other side may repeat them, or be divided along other diagonals. `None` if the two
/// sides do not cancel everywhere.
fn outward_layers(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    distinct: &[bool],
    bounds: [DVec3; 2],
) -> Option<Vec<bool>> {
    let mut seen = HashSet::new();
    let is_new = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && seen.insert(triangle::from_least(*t));
    let sides: Vec<bool> = triangles.iter().map(is_new).collect();
    let corners: Vec<Triangle> = triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect();
    let diagonal = bounds[0].distance(bounds[1]);
    let may_cancel = is_flat(&corners, &sides, diagonal) && closing::boundary(&chosen(triangles, &sides)).is_empty();
    if !may_cancel || closing::are_open(triangles, distinct).contains(&true) {
        return None;
    }
    let both = Solid::of_triangles(corners, sides.clone(), bounds, 0.0);
    if both.has_inside() { None } else { closing::outward(positions, triangles, &sides, SHEET * diagonal) }
}

/// Triangles that close each hole of the mesh of distinct triangles, after reversed ones are turned
/// round.
fn close(positions: &[DVec3], indices: &mut [[u32; 3]], distinct: &[bool]) -> Vec<Vec<Triangle>> {
    let mut chosen = chosen(indices, distinct);
    if !closing::turn(&mut chosen).is_empty() {
        let places = indices.iter_mut().zip(distinct).filter(|(_, distinct)| **distinct);
        places.zip(&chosen).for_each(|((place, _), triangle)| *place = *triangle);
    }
    closing::cones(positions, &chosen)
}

/// Ascending indices of triangles that face the other way than most others of their surface, and
/// whether turning them closes the mesh. Vertices of equal position count as one.
///
/// # Complexity
/// O(n log n) for n triangles.
pub fn reversed(mesh: &PointSet) -> (Vec<usize>, bool) {
    let indices = merged(mesh).1;
    let distinct = distinct(&indices);
    let places: Vec<usize> = (0..indices.len()).filter(|index| distinct[*index]).collect();
    let mut chosen = chosen(&indices, &distinct);
    let turned = closing::turn(&mut chosen).into_iter().map(|index| places[index]).collect();
    (turned, closing::boundary(&chosen).is_empty())
}

fn chosen(triangles: &[[u32; 3]], distinct: &[bool]) -> Vec<[u32; 3]> {
    triangles.iter().zip(distinct).filter(|(_, distinct)| **distinct).map(|(t, _)| *t).collect()
}

/// For each vertex, the vertex with which it is merged: those at `open` positions that are closer
/// than `distance` to an earlier one. `None` if no vertices are merged.
pub(super) fn merge_open(positions: &[DVec3], open: &[DVec3], distance: f64) -> Option<Vec<u32>> {
    let open: HashSet<[u64; 3]> = open.iter().map(|p| bits(*p)).collect();
    let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut is_changed = false;
    if !(distance > 0.0) {
        return None;
    }
    let [low, _] = bounds(positions.iter().copied());
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
                merged[v] = w;
            }
            None => cells.entry(cell).or_default().push(v as u32),
        }
    }
    is_changed.then_some(merged)
}

fn is_flat(triangles: &[Triangle], counts: &[bool], diagonal: f64) -> bool {
    let Some(&[origin, ..]) = triangles.first() else { return true };
    let (mut volume, mut area) = (0.0, 0.0);
    for ([a, b, c], _) in triangles.iter().zip(counts).filter(|(_, counts)| **counts) {
        let normal = (*b - *a).cross(*c - *a);
        volume += (*a - origin).dot(normal) / 6.0;
        area += normal.length() / 2.0;
    }
    // NaN counts as flat.
    !(volume.abs() > SHEET * area * diagonal)
}
