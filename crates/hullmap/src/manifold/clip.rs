//! Clipping of two facing features: the points of the contact patch of an edge and a face, or of
//! two faces.
//!
//! Both features are projected along the contact normal. The *reference* feature gives the side
//! planes and the height from which depths are measured. The *incident* feature is clipped against
//! the side planes.
//!
//! # Reference
//! Sutherland, Hodgman, "Reentrant polygon clipping", 1974. Feature ids: Gregorius, "Robust contact
//! creation for physics simulations", GDC 2015.
//!
//! # Steps
//! 1. Project both features onto the plane perpendicular to the normal.
//! 2. Take the polygon with the larger area as the reference. Two parallel edges meet along their
//!    common length; two other edges meet only at the contact point.
//!    If a feature is reduced, and the incident one does not lie inside the reference, repeat with
//!    the whole feature.
//! 3. Clip the incident feature by each side of the reference. Every corner records the corners or
//!    sides of both features that it lies on.
//! 4. The depth of a corner is the height of A's surface above B's there, along the normal.
//!
//! # Deviations
//! - Corners within a slack outside of a side are kept, so that coincident features do not flicker.
//!   It is relative to the smaller shape: a body is beside a triangle of 20 km as soon as it is
//!   beside a small one.

#![forbid(unsafe_code)]

use super::select::Spot;
use crate::shapes::{Corner, Feature, MAX_CORNERS};
use crate::vector::perpendicular;
use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

/// Maximum number of points of a patch: each side adds at most one corner.
pub(super) const MAX_POINTS: usize = 2 * MAX_CORNERS;

/// Distance outside a side up to which a corner counts as on it, relative to the reference's extent
/// or the smaller shape's outer radius, whichever is smaller. Above the rounding error of f32
/// (6e-8) and invisibly small.
const SIDE_SLACK: f64 = 1e-6;

/// A feature whose area is at most this multiple of its squared extent is an edge.
const FLAT_AREA: f64 = 1e-6;

/// Maximum slope of a plane whose heights count as heights of the surface.
const STEEPEST: f64 = 1.0;

/// Sine of the angle within which two edges count as parallel: the tilt within which faces count as
/// one.
const PARALLEL: f64 = crate::shapes::feature::TILT;

/// The feature of one shape that a point lies on: a vertex twice, the two ends of an edge, or
/// [`FACE`].
pub(super) type Part = [u32; 2];

/// The interior of a face.
pub(super) const FACE: Part = [u32::MAX; 2];

/// One point of a patch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PatchPoint {
    /// Position in the plane perpendicular to the normal.
    pub(super) at: DVec2,
    /// Heights of A's and of B's surface along the normal.
    pub(super) heights: [f64; 2],
    /// Whether these are exact. Otherwise they belong to features that are not flat.
    pub(super) exact: [bool; 2],
    /// Whether it was moved, and may be beside the incident feature.
    pub(super) is_moved: bool,
    /// The features of A and of B that it lies on.
    pub(super) parts: [Part; 2],
}

impl PatchPoint {
    pub(super) fn depth(&self) -> f64 {
        self.heights[0] - self.heights[1]
    }

    /// The same point with A and B exchanged.
    fn swapped(mut self) -> Self {
        self.heights.reverse();
        self.exact.reverse();
        self.parts.reverse();
        self
    }
}

/// Points of a patch.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    points: ArrayVec<PatchPoint, { MAX_POINTS + 1 }>,
}

impl Patch {
    pub(super) fn points(&self) -> &[PatchPoint] {
        &self.points
    }

    /// Adds a point unless the patch is full or has a point on the same features.
    pub(super) fn push(&mut self, point: PatchPoint) {
        if self.points.iter().all(|p| p.parts != point.parts) {
            let _ = self.points.try_push(point);
        }
    }

    /// Depth of the deepest point; negative infinity without any.
    pub(super) fn deepest(&self) -> f64 {
        self.points().iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The points in the form that the choice of four needs.
    pub(super) fn spots(&self) -> ArrayVec<Spot, { MAX_POINTS + 1 }> {
        self.points.iter().map(|point| Spot { at: point.at, depth: point.depth() }).collect()
    }

    pub(super) fn points_mut(&mut self) -> &mut [PatchPoint] {
        &mut self.points
    }

    /// Adds a point in place of the one on the same features, or of the last one if the patch is
    /// full. Returns its index.
    pub(super) fn put(&mut self, point: PatchPoint) -> usize {
        let known = self.points.iter().position(|p| p.parts == point.parts);
        let at = known.unwrap_or(self.points.len().min(MAX_POINTS));
        match self.points.get_mut(at) {
            Some(place) => *place = point,
            None => self.points.push(point),
        }
        at
    }

    pub(super) fn retain(&mut self, keep: impl Fn(&PatchPoint) -> bool) {
        self.points.retain(|point| keep(point));
    }
}

/// A corner, projected along the normal.
#[derive(Clone, Copy, Debug, Default)]
struct Flat {
    at: DVec2,
    height: f64,
    vertex: u32,
}

/// A feature, projected along the normal.
#[derive(Clone)]
struct Outline {
    corners: ArrayVec<Flat, MAX_CORNERS>,
    is_flat: bool,
    has_exact_corners: bool,
    /// Positive if counter-clockwise; 0 for an edge or a vertex.
    area: f64,
    extent: f64,
}

impl Outline {
    fn new(feature: &Feature, frame: &Frame) -> Self {
        // Filled in place, since it is large.
        let mut out = Self {
            corners: ArrayVec::new(),
            is_flat: feature.is_flat(),
            has_exact_corners: feature.has_exact_corners(),
            area: 0.0,
            extent: 0.0,
        };
        out.corners.extend(feature.corners().iter().map(|c| frame.flattened(c)));
        let first = out.corners.first().copied().unwrap_or_default();
        let mut start = first;
        for (i, c) in out.corners.iter().enumerate() {
            let next = &out.corners[(i + 1) % out.corners.len()];
            out.area += 0.5 * (c.at - first.at).perp_dot(next.at - first.at);
            if c.at.distance(first.at) > out.extent {
                (out.extent, start) = (c.at.distance(first.at), *c);
            }
        }
        if out.area.abs() <= FLAT_AREA * out.extent * out.extent {
            // An edge from one end to the other, or a vertex.
            let is_farther = |c: &Flat, end: &Flat| c.at.distance(start.at) > end.at.distance(start.at);
            let end = out.corners.iter().fold(start, |end, c| if is_farther(c, &end) { *c } else { end });
            // The line between two corners of a steep face is on it, but may be below its top.
            out.is_flat &= out.corners.len() <= 2;
            out.corners.clear();
            out.corners.extend([start, end].into_iter().take(if out.extent > 0.0 { 2 } else { 1 }));
            out.area = 0.0;
        } else if out.area < 0.0 {
            out.corners.reverse();
            out.area = -out.area;
        }
        out
    }

    fn corners(&self) -> &[Flat] {
        &self.corners
    }

    /// Distance outside a side up to which a corner counts as on it, where `reach` is the smaller
    /// outer radius.
    fn slack(&self, reach: f64) -> f64 {
        SIDE_SLACK * self.extent.min(reach)
    }

    /// Its point nearest to `at`.
    fn nearest(&self, at: DVec2) -> DVec2 {
        let corners = self.corners();
        let sides = corners.iter().enumerate().map(|(i, start)| (start.at, corners[(i + 1) % corners.len()].at));
        if sides.clone().all(|(start, end)| (end - start).perp_dot(at - start) >= 0.0) {
            return at;
        }
        let on_sides = sides.map(|(start, end)| {
            let along = end - start;
            // NaN, of a side without length, becomes 0.
            let t = ((at - start).dot(along) / along.length_squared()).max(0.0);
            start + along * if t < 1.0 { t } else { 1.0 }
        });
        on_sides.min_by(|p, q| p.distance_squared(at).total_cmp(&q.distance_squared(at))).unwrap_or(at)
    }

    /// Whether heights of its plane, which has this slope, count as heights of the surface. A point
    /// outside of a side by the slack is off a steep plane by a multiple of it.
    fn is_exact(&self, slope: DVec2) -> bool {
        self.is_flat && slope.length_squared() <= STEEPEST * STEEPEST
    }

    /// The feature's plane as an origin and a slope. Newell's method averages over corners that are
    /// not quite coplanar.
    fn plane(&self) -> (Flat, DVec2) {
        let corners = self.corners();
        let n = corners.len() as f64;
        let at = corners.iter().map(|c| c.at).sum::<DVec2>() / n;
        let height = corners.iter().map(|c| c.height).sum::<f64>() / n;
        let mut normal = DVec3::ZERO;
        for (i, c) in corners.iter().enumerate() {
            let next = &corners[(i + 1) % corners.len()];
            normal += (c.at - at).extend(c.height - height).cross((next.at - at).extend(next.height - height));
        }
        (Flat { at, height, vertex: 0 }, -normal.truncate() / normal.z)
    }
}

/// A frame whose third axis is the contact normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) origin: DVec3,
    pub(super) x: DVec3,
    pub(super) y: DVec3,
    pub(super) normal: DVec3,
}

impl Frame {
    /// A frame about `origin` with the unit normal `normal`.
    pub(super) fn new(origin: DVec3, normal: DVec3) -> Self {
        let x = perpendicular(normal);
        Self { origin, x, y: normal.cross(x), normal }
    }

    fn flattened(&self, corner: &Corner) -> Flat {
        let height = (corner.point - self.origin).dot(self.normal);
        Flat { at: self.projected(corner.point), height, vertex: corner.vertex }
    }

    /// Position of a point in the plane.
    pub(super) fn projected(&self, point: DVec3) -> DVec2 {
        let p = point - self.origin;
        DVec2::new(p.dot(self.x), p.dot(self.y))
    }

    /// The vector with these components in the plane.
    pub(super) fn vector(&self, along: DVec2) -> DVec3 {
        self.x * along.x + self.y * along.y
    }

    /// The point at a position in the plane and a height.
    pub(super) fn point(&self, at: DVec2, height: f64) -> DVec3 {
        self.origin + self.x * at.x + self.y * at.y + self.normal * height
    }
}

/// Origin of an edge of the polygon being clipped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Side {
    /// An edge of the incident feature.
    #[default]
    Incident,
    /// A side of the reference, by index.
    Reference(usize),
}

/// A corner of the polygon being clipped.
#[derive(Clone, Copy, Debug, Default)]
struct Clipped {
    at: DVec2,
    height: f64,
    /// The features of the incident and of the reference shape that it lies on.
    parts: [Part; 2],
    /// The edge to the next corner, and its ends if it belongs to the incident feature.
    side: Side,
    edge: Part,
}

/// One of the two shapes of a manifold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Body {
    A,
    B,
}

/// Adds the points where features `a` and `b` (in one frame) meet to `out`. Adds nothing if only
/// the contact point is common. `reach` is the smaller outer radius.
///
/// Returns a body whose feature is reduced if the whole one is needed, and then adds nothing.
///
/// If the corners of a reduced feature lie inside the other one, they are the points. The four of
/// a reduced face span more area than any other four, hence more than any four of a common part.
pub(super) fn meet([a, b]: [&Feature; 2], frame: &Frame, reach: f64, out: &mut Patch) -> Option<Body> {
    if a.corners().len() < 2 || b.corners().len() < 2 {
        return None;
    }
    let on_a = Outline::new(a, frame);
    let on_b = Outline::new(b, frame);
    let reference_is_a = on_a.area >= on_b.area;
    let bodies = if reference_is_a { [Body::A, Body::B] } else { [Body::B, Body::A] };
    let (reference, incident) = if reference_is_a { (&on_a, &on_b) } else { (&on_b, &on_a) };
    let is_reduced = |body: &Body| if *body == Body::A { a.is_reduced() } else { b.is_reduced() };
    // The reference first: often the reduced incident feature lies inside the whole reference.
    if let Some(wanted) = bodies.into_iter().find(is_reduced)
        && !(reference.area > 0.0 && is_inside(incident.corners(), reference, reach))
    {
        return Some(wanted);
    }
    if reference.area == 0.0 {
        edges(&on_a, &on_b, out);
    } else {
        clip([incident, reference], reference_is_a, reach, out);
    }
    None
}

/// Whether all `points` lie inside `reference`, which is counter-clockwise.
fn is_inside(points: &[Flat], reference: &Outline, reach: f64) -> bool {
    let slack = reference.slack(reach);
    let corners = reference.corners();
    corners.iter().enumerate().all(|(i, start)| {
        let along = corners[(i + 1) % corners.len()].at - start.at;
        let least = -slack * along.length();
        points.iter().all(|c| along.perp_dot(c.at - start.at) >= least)
    })
}

/// The point of a face nearest to a `corner` of `body`, along the normal; `None` if the feature of
/// the other body is not a face. The point is moved if the corner is not over the face.
pub(super) fn nearest_on(
    face: &Feature,
    (corner, body): (&Corner, Body),
    frame: &Frame,
    reach: f64,
) -> Option<PatchPoint> {
    let (face, corner) = (Outline::new(face, frame), frame.flattened(corner));
    if !(face.area > 0.0) {
        return None;
    }
    let nearest = face.nearest(corner.at);
    // NaN takes the failing branch.
    let is_moved = !(nearest.distance(corner.at) <= face.slack(reach));
    let at = if is_moved { nearest } else { corner.at };
    let (origin, slope) = face.plane();
    let heights = [origin.height + slope.dot(at - origin.at), corner.height];
    let (exact, parts) = ([face.is_exact(slope), !is_moved], [FACE, pair(corner.vertex, corner.vertex)]);
    let point = PatchPoint { at, heights, exact, is_moved, parts };
    Some(if body == Body::A { point.swapped() } else { point })
}

/// Adds the ends of the common length of two parallel edges.
fn edges(a: &Outline, b: &Outline, out: &mut Patch) {
    let ([a0, a1], [b0, b1]) = (a.corners(), b.corners()) else { return };
    let (along, other) = (a1.at - a0.at, b1.at - b0.at);
    let size_sq = along.length_squared();
    if along.perp_dot(other).abs() > PARALLEL * along.length() * other.length() {
        return;
    }
    let position = |p: DVec2| (p - a0.at).dot(along) / size_sq;
    let (t0, t1) = (position(b0.at), position(b1.at));
    for (t, on_a, on_b) in [
        (0.0, pair(a0.vertex, a0.vertex), pair(b0.vertex, b1.vertex)),
        (1.0, pair(a1.vertex, a1.vertex), pair(b0.vertex, b1.vertex)),
        (t0, pair(a0.vertex, a1.vertex), pair(b0.vertex, b0.vertex)),
        (t1, pair(a0.vertex, a1.vertex), pair(b1.vertex, b1.vertex)),
    ] {
        let s = (t - t0) / (t1 - t0);
        // NaN takes the failing branch.
        if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s) {
            let heights = [a0.height + (a1.height - a0.height) * t, b0.height + (b1.height - b0.height) * s];
            // Edges that are not quite parallel are beside each other there.
            let at = a0.at + along * t;
            let meets = at.distance(b0.at + other * s) <= SIDE_SLACK * a.extent.min(b.extent);
            let exact = [a.is_flat, b.is_flat && meets];
            out.push(PatchPoint { at, heights, exact, is_moved: false, parts: [on_a, on_b] });
        }
    }
}

/// Clips `incident` by the sides of `reference` (Sutherland-Hodgman).
fn clip([incident, reference]: [&Outline; 2], reference_is_a: bool, reach: f64, out: &mut Patch) {
    let sides = reference.corners();
    // Two variables: an array of both would be filled with zeros.
    let (mut from, mut to) = (ArrayVec::<Clipped, MAX_POINTS>::new(), ArrayVec::new());
    // Exchanged after each side, as references: the arrays are large.
    let (mut polygon, mut kept) = (&mut from, &mut to);
    for (i, c) in incident.corners().iter().enumerate() {
        let next = &incident.corners()[(i + 1) % incident.corners().len()];
        let edge = pair(c.vertex, next.vertex);
        let parts = [pair(c.vertex, c.vertex), FACE];
        polygon.push(Clipped { at: c.at, height: c.height, parts, side: Side::Incident, edge });
    }
    let slack = reference.slack(reach);
    // Whether any corner was outside of a side.
    let mut crosses = false;
    for (index, start) in sides.iter().enumerate() {
        let end = &sides[(index + 1) % sides.len()];
        let along = end.at - start.at;
        let length = along.length();
        if !(length > 0.0) {
            continue;
        }
        // Positive inside: the reference is counter-clockwise. A multiple of the distance.
        let inside = |c: &Clipped| along.perp_dot(c.at - start.at);
        let slack = slack * length;
        // Most sides of a large face cut nothing off.
        let least = polygon.iter().map(inside).fold(f64::INFINITY, f64::min);
        crosses |= least < 0.0;
        if least >= -slack {
            continue;
        }
        let side_part = pair(start.vertex, end.vertex);
        kept.clear();
        for (i, p) in polygon.iter().enumerate() {
            let q = &polygon[(i + 1) % polygon.len()];
            let (dp, dq) = (inside(p), inside(q));
            let (keep, keep_next) = (dp >= -slack, dq >= -slack);
            if keep {
                push(kept, *p);
            }
            if keep != keep_next {
                let t = (dp / (dp - dq)).clamp(0.0, 1.0);
                let parts = match p.side {
                    Side::Incident => [p.edge, side_part],
                    // Two sides of the reference meet at one of its corners.
                    Side::Reference(other) => {
                        let corner = if (index + 1) % sides.len() == other { end.vertex } else { start.vertex };
                        [FACE, pair(corner, corner)]
                    }
                };
                let (at, height) = (p.at.lerp(q.at, t), p.height + (q.height - p.height) * t);
                // A leaving edge continues along the side, an entering edge along itself.
                let (side, edge) = if keep { (Side::Reference(index), FACE) } else { (p.side, p.edge) };
                push(kept, Clipped { at, height, parts, side, edge });
            }
        }
        std::mem::swap(&mut polygon, &mut kept);
    }
    let (origin, slope) = reference.plane();
    for c in polygon {
        // Beyond a sharp corner, a point may be farther from the reference than from its sides.
        let nearest = if crosses { reference.nearest(c.at) } else { c.at };
        let is_moved = nearest.distance(c.at) > slack;
        c.at = if is_moved { nearest } else { c.at };
        let height = origin.height + slope.dot(c.at - origin.at);
        // A corner of the incident feature is on the surface unless it is rounded.
        let is_corner = incident.has_exact_corners && c.parts[0] != FACE && c.parts[0][0] == c.parts[0][1];
        let exact = [(incident.is_flat || is_corner) && !is_moved, reference.is_exact(slope)];
        let point = PatchPoint { at: c.at, heights: [c.height, height], exact, is_moved, parts: c.parts };
        out.push(if reference_is_a { point.swapped() } else { point });
    }
}

/// Adds a corner, if there is room. Only rounding errors can produce too many.
fn push(polygon: &mut ArrayVec<Clipped, MAX_POINTS>, corner: Clipped) {
    let _ = polygon.try_push(corner);
}

/// Two vertices in ascending order.
fn pair(a: u32, b: u32) -> Part {
    [a.min(b), a.max(b)]
}
