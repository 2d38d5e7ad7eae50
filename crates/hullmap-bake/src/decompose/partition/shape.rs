//! Hulls of pieces: any proven hull during the search, and a tight one in the end.
//!
//! # Steps
//! 1. Take the hull of the piece's surface. Simplify it by a small share of the limit.
//! 2. If it has too many vertices, bound it by few planes, or simplify it to the allowed number.
//!    Where that gives a much larger hull, which extends into the solid, cut it as in step 4. A
//!    piece whose hull is still too large is divided further.
//! 3. Cut it by planes that keep faces flat and pieces apart: of large flat faces, of the cuts
//!    between pieces, and of large faces of the mesh's hull.
//! 4. With too many vertices, cut the hull of step 2 by planes of the piece's faces as far as the
//!    number of vertices allows; also cut it further, and simplify the result. Take the smallest
//!    proven hull of these and the simplified one.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{
    body::Body,
    few,
    field::Field,
    piece::Piece,
    wrap::{self, HullLimits},
};
use crate::{
    hull::{self, Hull},
    simplify::{self, Limit},
};
use hullmap_geometry::planes::HalfSpace;

/// Distance by which a simplified hull may exceed the tight one, relative to the limit.
const LOOSE: f64 = 0.002;

/// Maximum number of measurements to find a point of a hull that is too far from the solid.
const REFUTING: usize = 20_000;

/// Numbers of vertices up to which a hull is cut before it is simplified to the allowed number,
/// relative to the latter. Many cuts remove much volume, and simplification takes some of it back.
const CUT: [f64; 3] = [1.25, 1.5, 2.0];

const MAX_CUTS: usize = 48;

/// Number of cuts with too many vertices after which no more are tried.
const MAX_MISSES: usize = 6;

/// Height above a piece up to which a vertex is not cut off, relative to the limit.
const NEAR: f64 = 0.05;

/// Share of the area of a hull from which a face counts as large, and stays flat.
const LARGE: f64 = 0.02;

/// Distance from a plane up to which a hull is not cut, relative to the diagonal.
const FLAT: f64 = 2e-6;

/// Distance by which cutting planes are moved outward, relative to the diagonal: more than rounding
/// to f32 moves a vertex.
const ROOM: f64 = 5e-7;

/// Additional distance, relative to the greatest coordinate.
const ROUNDING: f64 = 2.2e-7;

/// A part of a partition.
#[derive(Clone, Debug)]
pub struct Part {
    /// The surface that it must contain.
    pub piece: Piece,
    /// A hull that contains it.
    pub hull: Hull,
    /// Proven bound on the hull's protrusion; infinite if it is not known.
    pub bound: f64,
    /// The component that it belongs to.
    pub component: Component,
}

/// Shells that touch or cross, apart from all others: no part holds several such components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Component {
    /// Index of the component.
    pub index: u32,
    /// 1 for the image of a component that does not reach the mirror plane, or else 0.
    pub image: u32,
}

/// A hull, and the proven bound on its protrusion, or why there is none: a point of the tight hull
/// that is too far from the solid; `None` if hulls have too many vertices, or proofs take too long.
pub type Outcome = Result<(Hull, f64), Option<DVec3>>;

/// A hull of a body's points that is proven to be within the limit.
pub fn shaped(field: &Field, body: &Body, bounds: &HullLimits) -> Outcome {
    let Some(tight) = wrap::tight(&body.points, bounds.diagonal, bounds.thickness) else { return Err(None) };
    if bounds.is_over() {
        return Ok((few::quickly_within_vertices(tight, bounds.max_vertices), f64::INFINITY));
    }
    let proof = |hull: &Hull| wrap::prove(field, hull, bounds, wrap::MEASUREMENTS);
    if tight.vertices.len() <= bounds.max_vertices {
        return proof(&tight).map(|bound| (tight, bound));
    }
    let mut found = wrap::wrap(field, body, bounds);
    if let Err(None) = found {
        found = wrap::simplified(field, &tight, bounds, bounds.max_vertices);
    }
    if let Ok((hull, _)) = &found
        && is_swollen(hull, body, bounds)
        && !bounds.is_over()
    {
        let trimmed = Cuts { body, flat: &[], bounds }.trimmed(field, &tight, hull);
        found = trimmed.filter(|(hull, _)| !is_swollen(hull, body, bounds)).ok_or(None);
    }
    if let (Err(None), true) = (&found, body.diagonal() < bounds.limit) {
        // A small piece. A flat hull has no simpler one that is near it, a thick one has.
        let thick = wrap::tight(&body.points, bounds.diagonal, 0.5 * body.diagonal());
        let hull = thick.map(|hull| few::within_vertices(hull, bounds.max_vertices));
        let hull = hull.filter(|hull| hull.vertices.len() <= bounds.max_vertices);
        found = hull.and_then(|hull| proof(&hull).ok().map(|bound| (hull, bound))).ok_or(None);
    }
    match found {
        Err(None) => Err(wrap::prove(field, &tight, bounds, REFUTING).err().flatten()),
        found => found,
    }
}

/// A tight hull of a part, or the hull that the part has, for instance when the time is over.
/// `sides` are planes of large faces of the mesh's hull.
pub fn tightened(field: &Field, part: &Part, sides: &[HalfSpace], bounds: &HullLimits) -> Hull {
    let body = &part.piece.body;
    let tight = wrap::tight(&body.points, bounds.diagonal, bounds.thickness);
    let Some(tight) = tight.filter(|_| !bounds.is_over()) else { return part.hull.clone() };
    let flat: Vec<HalfSpace> =
        large_faces(body).chain(part.piece.planes.iter().copied()).chain(sides.iter().copied()).collect();
    let cuts = Cuts { body, flat: &flat, bounds };
    let is_few = |hull: &Hull| hull.vertices.len() <= bounds.max_vertices;
    let is_proven = |hull: &Hull| wrap::prove(field, hull, bounds, wrap::MEASUREMENTS).is_ok();
    if part.bound == f64::INFINITY {
        // The time is nearly over, and nothing can be proven.
        let simple = cuts.allowed(&tight).map(|hull| cuts.flattened(hull));
        return simple.filter(|hull| volume(hull) < volume(&part.hull)).unwrap_or_else(|| part.hull.clone());
    }
    let loose = simplified(&tight, Limit::Distance(LOOSE * bounds.limit)).unwrap_or_else(|| tight.clone());
    if is_few(&loose) {
        let flattened = cuts.flattened(loose.clone());
        if is_proven(&flattened) {
            return flattened;
        }
        if is_few(&tight) {
            return part.hull.clone();
        }
    }
    if bounds.is_over() {
        return part.hull.clone();
    }
    cuts.trimmed(field, &tight, &part.hull).map_or_else(|| part.hull.clone(), |(hull, _)| hull)
}

fn simplified(hull: &Hull, limit: Limit) -> Option<Hull> {
    Some(simplify::simplify(hull, limit).ok().flatten()?.hull)
}

fn volume(hull: &Hull) -> f64 {
    Body::new(&hull.positions(), 0.0).volume()
}

/// Whether a hull is larger than its body moved outward by the limit, by Steiner's formula. It then
/// extends into the solid, where it may overlap other parts.
fn is_swollen(hull: &Hull, body: &Body, HullLimits { limit, .. }: &HullLimits) -> bool {
    let area: f64 = body.areas.iter().sum();
    // The mean width is at most the diagonal.
    let around = limit * (area + TAU * limit * (body.diagonal() + 2.0 / 3.0 * limit));
    volume(hull) > body.volume() + around
}

/// The planes of a body's large faces.
pub fn large_faces(body: &Body) -> impl Iterator<Item = HalfSpace> {
    let total: f64 = body.areas.iter().sum();
    body.planes.iter().zip(&body.areas).filter(move |(_, area)| **area >= LARGE * total).map(|(plane, _)| *plane)
}

struct Cuts<'a> {
    body: &'a Body,
    /// Planes that no hull shall exceed.
    flat: &'a [HalfSpace],
    bounds: &'a HullLimits<'a>,
}

impl Cuts<'_> {
    fn room(&self) -> f64 {
        let greatest = self.body.low.abs().max(self.body.high.abs()).max_element();
        ROOM * self.bounds.diagonal + ROUNDING * greatest
    }

    /// The smallest proven hull of step 4, with its bound, if it is smaller than `proven`.
    fn trimmed(&self, field: &Field, tight: &Hull, proven: &Hull) -> Option<(Hull, f64)> {
        let simple = self.allowed(tight).map(|hull| self.flattened(hull));
        let cut_further = |share: &f64| {
            let max_vertices = (share * self.bounds.max_vertices as f64) as usize;
            let bounds = HullLimits { max_vertices, ..*self.bounds };
            self.allowed(&Cuts { bounds: &bounds, ..*self }.filled(proven.clone()))
        };
        let mut found: Vec<Hull> = simple.into_iter().chain(CUT.iter().filter_map(cut_further)).collect();
        found.push(self.filled(proven.clone()));
        let mut found: Vec<(f64, Hull)> = found.into_iter().map(|hull| (volume(&hull), hull)).collect();
        // Cuts only remove points, but rounding moves vertices.
        let most = volume(proven);
        found.retain(|(volume, _)| *volume < most);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let proof = |hull: &Hull| wrap::prove(field, hull, self.bounds, wrap::MEASUREMENTS);
        found.into_iter().find_map(|(_, hull)| proof(&hull).ok().map(|bound| (hull, bound)))
    }

    fn allowed(&self, hull: &Hull) -> Option<Hull> {
        let found = simplified(hull, Limit::Vertices(self.bounds.max_vertices));
        found.filter(|hull| hull.vertices.len() <= self.bounds.max_vertices)
    }

    fn excess(points: &[DVec3], plane: &HalfSpace) -> f64 {
        points.iter().map(|p| plane.height(*p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// A hull cut by the planes that it exceeds most, as far as the number of vertices allows.
    fn flattened(&self, hull: Hull) -> Hull {
        self.cut(hull, |points| {
            let excess = |plane: &HalfSpace| Self::excess(points, plane);
            let exceeded = self.flat.iter().map(|plane| (excess(plane), *plane));
            let exceeded = exceeded.filter(|(excess, _)| *excess > FLAT * self.bounds.diagonal + self.room());
            let mut found: Vec<(f64, HalfSpace)> = exceeded.collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            found.into_iter().map(|(_, plane)| plane).collect()
        })
    }

    /// A flattened hull, cut by planes of the body's faces below its highest vertices, as far as
    /// the number of vertices allows.
    fn filled(&self, hull: Hull) -> Hull {
        self.cut(self.flattened(hull), |points| {
            let least = NEAR * self.bounds.limit + 2.0 * self.room();
            let below = points.iter().filter_map(|p| self.body.face_below(*p));
            let high = below.filter(|(highest, _)| *highest > least);
            let mut found: Vec<(f64, HalfSpace)> =
                high.map(|(highest, face)| (highest, self.body.planes[face])).collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            found.into_iter().map(|(_, plane)| plane).collect()
        })
    }

    fn cut(&self, hull: Hull, wanted: impl Fn(&[DVec3]) -> Vec<HalfSpace>) -> Hull {
        let mut points = hull.positions();
        let mut planes = hull.half_spaces();
        let mut missed: Vec<HalfSpace> = Vec::new();
        let start = planes.len();
        let middle = self.body.points.iter().sum::<DVec3>() / self.body.points.len().max(1) as f64;
        let reach = 2.0 * self.bounds.diagonal + self.body.diagonal();
        while planes.len() < start + MAX_CUTS && missed.len() < MAX_MISSES && !self.bounds.is_over() {
            let Some(plane) = wanted(&points).into_iter().find(|plane| !missed.contains(plane)) else { break };
            planes.push(plane.moved(self.room()));
            match wrap::polytope(&planes, middle, reach, 0.4 * self.room()) {
                Some(vertices) if vertices.len() <= self.bounds.max_vertices => points = vertices,
                _ => {
                    planes.pop();
                    missed.push(plane);
                }
            }
        }
        if planes.len() == start {
            return hull;
        }
        let rounded = points.iter().map(|p| p.as_vec3().to_array().map(|c| c + 0.0)).collect();
        hull::of_positions(rounded).filter(|hull| hull.vertices.len() <= self.bounds.max_vertices).unwrap_or(hull)
    }
}
