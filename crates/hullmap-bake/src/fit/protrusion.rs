//! Protrusion: the greatest distance of a point of a convex part from the solid of a mesh.
//!
//! # Steps
//! 1. Subtract from each face the triangles of the mesh that lie in its plane.
//! 2. Surface: branch and bound over triangles of what is left. A triangle is bounded by the
//!    distance of its centroid plus its radius; by 0 if it is inside, which needs an inside
//!    centroid and either no triangle of the mesh within the radius, or only points inside beside
//!    those that cross it ([`sides`](super::sides)); and by the distances of its corners from one
//!    triangle of the mesh.
//! 3. Inside: a part may also hide a cavity of the mesh. Step 2 bounds points close to the part's
//!    surface. Branch and bound over boxes covers the others. A box is all inside or all outside if
//!    no triangle of the mesh enters it, and inside if all points beside those that enter it are.
//!
//! # Why the bounds hold
//! - The distance from a set changes by at most the distance between two points.
//! - The distance from a convex set, such as one triangle, is a convex function, so it is greatest
//!   at a corner. The distance from the solid is at most that.
//! - The winding number is constant between the triangles.
//! - If a point inside is farther from the solid than the part's whole surface, the distance has a
//!   local maximum inside. Boxes proven to contain none are left out ([`peaks`]).
//!
//! # Complexity
//! One nearest-triangle search per cell. The number of cells is bounded by the [`Accuracy`].

use glam::DVec3;

use super::{
    branch::{Accuracy, Maximum, Measured, maximum},
    peaks::{self, Peaks},
    sides::{Polygon, are_sides_inside},
    solid::Solid,
};
use crate::hull::Hull;
use hullmap_geometry::{
    bounds,
    planes::{self, HalfSpace},
    triangle::{self, Triangle},
};

/// How far a part protrudes from a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protrusion {
    /// Upper bound, proven.
    pub bound: f64,
    /// Distance from the solid at [`at`](Self::at), less rounding errors; the protrusion is at
    /// least this unless closing triangles are near.
    pub reached: f64,
    /// A point of the part.
    pub at: DVec3,
}

/// Depth by which a cavity must exceed the protrusion of the surface, relative to the latter.
const CAVITY_RELATIVE: f64 = 0.1;

/// Accuracy to which cavities are measured, as a share of that depth. At a half or more, the bound
/// over the inside could exceed the depth although no point does.
const CAVITY_ACCURACY: f64 = 0.4;

/// Depth by which a cavity must exceed the protrusion of the surface, relative to the diagonal.
const CAVITY_ABSOLUTE: f64 = 1e-3;

/// Relative depth if a limit is given.
const CAVITY_LIMITED: f64 = 1e-6;

/// Distance from a face's plane up to which a triangle of the mesh counts as in it, relative to the
/// diagonal. It only selects what is subtracted; what is subtracted is measured.
const IN_PLANE: f64 = 1e-6;

/// Distance beyond a triangle of the mesh up to which a piece of a face counts as on it, relative
/// to the diagonal. Slivers along the triangles' edges would be slow to bound.
const BESIDE: f64 = 5e-7;

/// Widths of the rim of a facet that is bounded by its width, relative to the accuracy.
const RIMS: [f64; 2] = [0.01, 0.5];

/// How far above and beside a triangle of the mesh the region around it reaches, relative to the
/// distance that all its points should have.
const ABOVE: f64 = 0.9;
const BESIDE_EDGES: f64 = 0.28;

/// Maximum number of triangles of the mesh that are tested against a facet.
const MAX_TESTED: usize = 64;

const MAX_PIECES: usize = 4096;

/// Number of failures less successes, in one search, after which facets are no longer cut into
/// pieces. Where many shells cross within a facet of any size, each attempt fails.
const MAX_FAILURES: usize = 2048;

const DEEP_STEPS: usize = 16;

/// The greatest distance of a point of `part` from `solid`. Both are in the same frame.
///
/// Points inside the part count only in cavities that are farther from the solid than the part's
/// surface, by more than a tenth and a thousandth of the diagonal. Under a limit, the bound holds
/// for all points of the part, except for 1e-6 of the diagonal.
pub fn protrusion(solid: &Solid, part: &Hull, accuracy: &Accuracy) -> Protrusion {
    protrusion_beside(solid, part, accuracy, None)
}

/// As [`protrusion()`], with known local maxima of the distance from the solid.
pub fn protrusion_beside(solid: &Solid, part: &Hull, accuracy: &Accuracy, peaks: Option<&Peaks>) -> Protrusion {
    let surface = on_surface(solid, part, accuracy);
    let is_refuted = accuracy.limit.is_some_and(|limit| surface.bound > limit);
    let found = if is_refuted || part.rank < 3 { surface } else { inside(solid, part, accuracy, surface, peaks) };
    let slack = solid.tolerance();
    Protrusion { bound: found.bound + slack, reached: (found.reached - 2.0 * slack).max(0.0), at: found.at }
}

/// A triangle of the part's surface, and an upper bound on the distance of its centroid.
struct Facet {
    corners: Triangle,
    within: f64,
    hint: Option<Triangle>,
}

fn on_surface(solid: &Solid, part: &Hull, accuracy: &Accuracy) -> Maximum {
    // Widths of the rim of a facet that the mesh may cross.
    let rims = RIMS.map(|rim| rim * accuracy.absolute.max(accuracy.limit.unwrap_or(0.0)));
    let mut failures = 0_usize;
    let measure = |facet: &mut Facet, best: f64| {
        let (centre, radius) = triangle::ball(&facet.corners);
        let Some(near) = solid.near_beside(centre, facet.within, facet.hint.as_ref()) else {
            return Measured { bound: facet.within + radius, reached: 0.0, at: centre };
        };
        facet.hint = Some(near.triangle);
        facet.within = near.distance + 2.0 * radius;
        let to_corners = triangle::farthest(&facet.corners, &near.triangle);
        let mut bound = near.distance + radius;
        if near.is_whole {
            bound = bound.min(to_corners.max(near.distance));
        }
        // Points inside lower the bound, and the value that is reached.
        let mut reached = near.distance;
        let matters = |bound: f64| bound > best && !accuracy.limit.is_some_and(|limit| bound <= limit);
        if (matters(bound) || reached > best) && solid.is_inside(centre) {
            reached = 0.0;
            bound = bound.min(radius);
            let is_inside = |rim: &f64| is_inside_within(solid, &facet.corners, rim / radius);
            if near.gap > radius {
                bound = 0.0;
            } else if let Some(rim) = rims.into_iter().filter(|rim| *rim < bound).find(is_inside) {
                bound = rim;
            }
        }
        let enough = accuracy.limit.unwrap_or(best + 0.9 * accuracy.absolute);
        let is_worth_cutting = accuracy.limit.is_none() && failures < MAX_FAILURES;
        if matters(bound) && bound > enough && reached <= enough && is_worth_cutting {
            match in_pieces(solid, &facet.corners, enough) {
                Some(smaller) => (bound, failures) = (smaller, failures.saturating_sub(1)),
                None => failures += 1,
            }
        }
        Measured { bound, reached, at: centre }
    };
    let split = |facet: &Facet| {
        triangle::halves(&facet.corners).map(|corners| Facet { corners, within: facet.within, hint: facet.hint })
    };
    let (facets, on_mesh) = facets(solid, part);
    let found = maximum(facets, accuracy, measure, split);
    Maximum { bound: found.bound.max(on_mesh), ..found }
}

/// Upper bound, at most `enough`, on the distance of a facet whose part outside the solid is that
/// close to triangles of the mesh. `None` if not, or unknown.
fn in_pieces(solid: &Solid, corners: &Triangle, enough: f64) -> Option<f64> {
    let low = corners[0].min(corners[1]).min(corners[2]) - enough;
    let high = corners[0].max(corners[1]).max(corners[2]) + enough;
    let near = solid.surface_in(low, high);
    if near.len() > MAX_TESTED {
        return None;
    }
    let mut pieces = vec![corners.to_vec()];
    let mut bound = 0.0_f64;
    for triangle in near.iter().map(|index| &solid.triangles()[*index as usize]) {
        let around = planes_around(triangle, enough);
        let mut left = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let (close, rest) = planes::divide(&piece, &around, 0.0);
            let distance = triangle::farthest(&close, triangle);
            if close.is_empty() || distance > enough {
                left.push(piece);
            } else {
                bound = bound.max(distance);
                left.extend(rest);
            }
        }
        pieces = left;
        if pieces.len() > MAX_TESTED {
            return None;
        }
    }
    let is_inside = |piece: &Vec<DVec3>| {
        let centre = piece.iter().sum::<DVec3>() / piece.len() as f64;
        solid.is_inside(centre) && is_inside_around(solid, piece, centre)
    };
    pieces.iter().all(is_inside).then_some(bound + solid.tolerance())
}

/// Half-spaces whose common points are within `distance` of a triangle, unless it is very thin.
fn planes_around(triangle: &Triangle, distance: f64) -> Vec<HalfSpace> {
    let Some(Polygon { plane, .. }) = Polygon::new(triangle) else {
        return vec![HalfSpace { normal: DVec3::X, offset: f64::NEG_INFINITY }];
    };
    let edges = edge_planes(triangle);
    // Without these, acute corners reach far.
    let corner = |(index, a): (usize, &HalfSpace)| {
        let normal = (a.normal + edges[(index + 1) % edges.len()].normal).try_normalize()?;
        let offset = triangle.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        Some(HalfSpace { normal, offset })
    };
    let corners: Vec<HalfSpace> = edges.iter().enumerate().filter_map(corner).collect();
    let beside = edges.into_iter().chain(corners);
    let slab = [plane, plane.opposite()];
    let slab = slab.map(|plane| plane.moved(ABOVE * distance));
    slab.into_iter().chain(beside.map(|plane| plane.moved(BESIDE_EDGES * distance))).collect()
}

/// Whether a facet with an inside centroid is inside, except for a rim of `rim` times its radius.
/// `false` may mean unknown.
fn is_inside_within(solid: &Solid, corners: &Triangle, rim: f64) -> bool {
    let centre = triangle::centroid(corners);
    is_inside_around(solid, &corners.map(|corner| corner + (centre - corner) * rim), centre)
}

/// Whether a convex polygon around the inside point `centre` is inside. `false` may mean unknown.
fn is_inside_around(solid: &Solid, polygon: &[DVec3], centre: DVec3) -> bool {
    let thickness = solid.tolerance();
    let area: DVec3 = polygon.windows(2).map(|edge| (edge[0] - polygon[0]).cross(edge[1] - polygon[0])).sum();
    let Some(normal) = area.try_normalize() else { return false };
    let offset = normal.dot(centre);
    let mut region = vec![
        HalfSpace { normal, offset: offset + thickness },
        HalfSpace { normal: -normal, offset: thickness - offset },
    ];
    region.append(&mut planes::around(polygon, normal));
    let [low, high] = bounds(polygon.iter().copied());
    let near = solid.triangles_in(low - thickness, high + thickness);
    if near.len() > MAX_TESTED {
        return false;
    }
    let polygon = |index: &u32| Polygon::new(&solid.triangles()[*index as usize])?.clipped(&region);
    let polygons: Vec<Polygon> = near.iter().filter_map(polygon).collect();
    polygons.is_empty() || are_sides_inside(solid.surface(), &polygons)
}

/// Triangles that cover the part's surface off the mesh, and the greatest distance of the rest.
fn facets(solid: &Solid, part: &Hull) -> (Vec<Facet>, f64) {
    let positions = part.positions();
    let tolerance = BESIDE * solid.diagonal();
    let mut facets = Vec::new();
    let mut on_mesh = 0.0_f64;
    let mut add = |polygon: &[DVec3]| {
        facets.extend(planes::fan(polygon).into_iter().map(|corners| Facet {
            corners,
            within: f64::INFINITY,
            hint: None,
        }));
    };
    if part.rank < 2 {
        add(&positions);
    }
    for face in &part.faces {
        let mut pieces = vec![face.iter().map(|v| positions[*v as usize]).collect::<Vec<_>>()];
        for triangle in in_plane(solid, &pieces[0]) {
            let edges = edge_planes(&triangle);
            let mut left = Vec::with_capacity(pieces.len());
            for piece in pieces {
                let (inside, outside) = planes::divide(&piece, &edges, tolerance);
                left.extend(outside);
                for p in inside {
                    on_mesh = on_mesh.max(triangle::nearest(&triangle, p).distance(p));
                }
            }
            pieces = left;
            if pieces.len() > MAX_PIECES {
                break;
            }
        }
        for piece in &pieces {
            add(piece);
        }
    }
    (facets, on_mesh)
}

fn in_plane(solid: &Solid, face: &[DVec3]) -> Vec<Triangle> {
    let area: DVec3 = face.windows(2).map(|edge| (edge[0] - face[0]).cross(edge[1] - face[0])).sum();
    let Some(normal) = area.try_normalize() else { return Vec::new() };
    let margin = IN_PLANE * solid.diagonal();
    let [low, high] = bounds(face.iter().copied());
    let mut indices = solid.surface_in(low - margin, high + margin);
    indices.sort_unstable();
    let triangles = indices.into_iter().map(|index| solid.triangles()[index as usize]);
    triangles.filter(|corners| corners.iter().all(|p| normal.dot(*p - face[0]).abs() <= margin)).collect()
}

/// Half-spaces at the edges of a triangle, at right angles to it; empty ones without area.
fn edge_planes(triangle: &Triangle) -> Vec<HalfSpace> {
    let [a, b, c] = *triangle;
    let planes = planes::around(triangle, (b - a).cross(c - a));
    // Without its edges, a triangle would contain everything.
    if planes.len() == 3 { planes } else { vec![HalfSpace { normal: DVec3::X, offset: f64::NEG_INFINITY }] }
}

/// A box inside or across the part, and the polygons of the mesh that may enter it.
struct PartBox {
    centre: DVec3,
    half: DVec3,
    /// Indices of polygons; the halves of a box have subsets of its polygons.
    deep: Vec<u32>,
    within: f64,
    hint: Option<Triangle>,
}

fn inside(solid: &Solid, part: &Hull, accuracy: &Accuracy, surface: Maximum, peaks: Option<&Peaks>) -> Maximum {
    let diagonal = solid.diagonal();
    let enough = match accuracy.limit {
        Some(limit) => limit.max(surface.bound + CAVITY_LIMITED * diagonal),
        None => surface.bound + (CAVITY_RELATIVE * surface.bound).max(CAVITY_ABSOLUTE * diagonal),
    };
    let [low, high] = bounds(part.positions());
    let boxes = peak_boxes(peaks, [low, high], enough);
    if boxes.is_empty() {
        return surface;
    }
    let planes = part.half_spaces();
    let depth = enough - surface.bound;
    let deep = deep_polygons(solid, &planes, [low, high], depth);
    let search = CavitySearch { solid, surface: &surface, enough, depth, planes, deep };
    let cells = boxes.into_iter().map(|bounds| search.cell(bounds));
    let accuracy = cavity_accuracy(accuracy, enough, diagonal);
    let cavity = maximum(cells, &accuracy, |cell: &mut PartBox, _: f64| search.measure(cell), halves);
    let measurements = surface.measurements + cavity.measurements;
    if cavity.bound <= enough {
        return Maximum { measurements, ..surface };
    }
    Maximum {
        bound: cavity.bound.max(surface.bound),
        measurements,
        ..if cavity.reached > surface.reached { cavity } else { surface }
    }
}

/// Boxes that together hold all points within `bounds` that may be farther than `enough` from the
/// solid and than all points of the part's surface.
fn peak_boxes(peaks: Option<&Peaks>, [low, high]: [DVec3; 2], enough: f64) -> Vec<[DVec3; 2]> {
    match peaks {
        // Where the distance has no local maximum above `enough`, none is greater than at the
        // surface.
        Some(peaks) if peaks.above() <= enough => {
            peaks.boxes().iter().filter(|[l, h]| (*l - high).max(low - *h).max_element() <= 0.0).copied().collect()
        }
        _ => vec![[low, high]],
    }
}

fn cavity_accuracy(accuracy: &Accuracy, enough: f64, diagonal: f64) -> Accuracy {
    match accuracy.limit {
        Some(_) => Accuracy { limit: Some(enough), ..*accuracy },
        None => {
            let relative = CAVITY_ACCURACY * CAVITY_RELATIVE;
            let absolute = CAVITY_ACCURACY * CAVITY_ABSOLUTE * diagonal;
            Accuracy { floor: enough, relative, absolute, ..*accuracy }
        }
    }
}

fn halves(cell: &PartBox) -> [PartBox; 2] {
    let axis = cell.half.max_position();
    let mut half = cell.half;
    half[axis] *= 0.5;
    [-1.0, 1.0].map(|side| {
        let mut centre = cell.centre;
        centre[axis] += side * half[axis];
        PartBox { centre, half, deep: cell.deep.clone(), within: cell.within + half[axis], hint: cell.hint }
    })
}

struct CavitySearch<'a> {
    solid: &'a Solid,
    surface: &'a Maximum,
    /// Distance from the solid up to which nothing is a cavity.
    enough: f64,
    /// Depth inside the part up to which the surface bounds the distance by `enough`.
    depth: f64,
    planes: Vec<HalfSpace>,
    /// Polygons of the mesh that lie deeper than `depth`, and the boxes around them.
    deep: Vec<(Polygon, [DVec3; 2])>,
}

impl CavitySearch<'_> {
    fn cell(&self, [low, high]: [DVec3; 2]) -> PartBox {
        PartBox {
            centre: (low + high) * 0.5,
            half: (high - low) * 0.5,
            deep: (0..self.deep.len() as u32).collect(),
            within: f64::INFINITY,
            hint: None,
        }
    }

    fn measure(&self, cell: &mut PartBox) -> Measured {
        let nothing = Measured { bound: 0.0, reached: 0.0, at: cell.centre };
        let Some([below, centre_depth]) = self.depths(cell) else { return nothing };
        let from_surface = self.surface.bound + below;
        if from_surface <= self.enough {
            return Measured { bound: from_surface, ..nothing };
        }
        let (centre, half) = (cell.centre, cell.half);
        cell.deep.retain(|index| touches(self.deep[*index as usize].1, centre, half));
        // Everything not close to the part's surface is inside.
        let is_inside = Measured { bound: self.enough, ..nothing };
        if cell.deep.is_empty() && self.is_deep_part_inside(cell) {
            return is_inside;
        }
        let radius = half.length();
        let Some(near) = self.solid.near_beside(centre, cell.within, cell.hint.as_ref()) else {
            return Measured { bound: from_surface.min(cell.within + radius), ..nothing };
        };
        cell.hint = Some(near.triangle);
        cell.within = near.distance + radius;
        let mut bound = from_surface.min(near.distance + radius);
        if bound > self.enough {
            bound = bound.min(near.bound_in_box(centre, half));
        }
        if bound > self.enough && peaks::is_none_in_box(self.solid, centre, half, &near, self.enough) {
            return is_inside;
        }
        let mut reached = if centre_depth >= 0.0 { near.distance } else { 0.0 };
        if (bound > self.enough || reached > self.surface.reached) && self.solid.is_inside(centre) {
            reached = 0.0;
            bound = if near.gap > radius { 0.0 } else { bound.min(radius) };
            if bound > self.enough && self.are_polygons_inside(cell) {
                return is_inside;
            }
        }
        Measured { bound, reached, at: centre }
    }

    /// Maximum depth of a point of the cell inside the part, and its centre's; `None` outside.
    fn depths(&self, cell: &PartBox) -> Option<[f64; 2]> {
        let mut below = f64::INFINITY;
        let mut centre_depth = f64::INFINITY;
        for plane in &self.planes {
            let height = plane.height(cell.centre);
            let reach = plane.normal.abs().dot(cell.half);
            if height > reach {
                return None;
            }
            below = below.min(reach - height);
            centre_depth = centre_depth.min(-height);
        }
        Some([below, centre_depth])
    }

    /// Whether the deep part of a cell that no polygon enters is inside. `false` may mean unknown.
    fn is_deep_part_inside(&self, cell: &PartBox) -> bool {
        match deep_part(cell, &self.planes, self.depth) {
            DeepPart::Empty => true,
            DeepPart::Point(p) => self.solid.is_inside(p),
            DeepPart::Unknown => false,
        }
    }

    /// Whether the points of the cell beside all polygons that enter it are inside. `false` may
    /// mean unknown.
    fn are_polygons_inside(&self, cell: &PartBox) -> bool {
        let sides = box_sides(cell.centre, cell.half);
        let polygons = cell.deep.iter().filter_map(|index| self.deep[*index as usize].0.clipped(&sides));
        let polygons: Vec<Polygon> = polygons.take(MAX_TESTED).collect();
        polygons.is_empty() && self.is_deep_part_inside(cell) || are_sides_inside(self.solid.surface(), &polygons)
    }
}

/// The part of a cell that is deeper than some depth inside all planes.
enum DeepPart {
    Empty,
    Point(DVec3),
    Unknown,
}

/// Searches for a point deeper than `depth` by projection onto violated planes in turn. If there is
/// none, the steps balance: the mean of these planes, weighted by them, has no point of the cell at
/// that depth, but a point deep for all planes would be deep for it.
fn deep_part(cell: &PartBox, planes: &[HalfSpace], depth: f64) -> DeepPart {
    let mut p = cell.centre;
    let (mut normal, mut offset, mut weight) = (DVec3::ZERO, 0.0, 0.0);
    for _ in 0..DEEP_STEPS {
        let Some(worst) = planes.iter().max_by(|a, b| a.height(p).total_cmp(&b.height(p))) else { break };
        let excess = worst.height(p) + depth;
        if excess < 0.0 {
            return DeepPart::Point(p);
        }
        // A little farther than the plane, so that the next test succeeds.
        let step = excess * 1.001 + 1e-3 * depth;
        normal += step * worst.normal;
        offset += step * worst.offset;
        weight += step;
        if normal.dot(cell.centre) - normal.abs().dot(cell.half) - offset > -depth * weight {
            return DeepPart::Empty;
        }
        p = (p - worst.normal * step).clamp(cell.centre - cell.half, cell.centre + cell.half);
    }
    DeepPart::Unknown
}

/// Polygons of the mesh deeper than `depth` inside the part, and their boxes.
fn deep_polygons(
    solid: &Solid,
    planes: &[HalfSpace],
    [low, high]: [DVec3; 2],
    depth: f64,
) -> Vec<(Polygon, [DVec3; 2])> {
    let mut indices = solid.triangles_in(low, high);
    indices.sort_unstable();
    let deeper: Vec<HalfSpace> =
        planes.iter().map(|plane| HalfSpace { offset: plane.offset - depth, ..*plane }).collect();
    let clipped = |index: &u32| {
        let polygon = Polygon::new(&solid.triangles()[*index as usize])?.clipped(&deeper)?;
        let bounds = polygon.bounds();
        Some((polygon, bounds))
    };
    indices.iter().filter_map(clipped).collect()
}

fn box_sides(centre: DVec3, half: DVec3) -> [HalfSpace; 6] {
    let axes = DVec3::AXES;
    std::array::from_fn(|side| {
        let (axis, sign) = (side % 3, if side < 3 { 1.0 } else { -1.0 });
        HalfSpace { normal: sign * axes[axis], offset: sign * centre[axis] + half[axis] }
    })
}

fn touches([low, high]: [DVec3; 2], centre: DVec3, half: DVec3) -> bool {
    (low - centre - half).max(centre - half - high).max_element() <= 0.0
}
