//! Seams between the parts of a compound: the correction of contact normals at internal edges.
//!
//! Each part of a compound is a convex shape of its own, with edges and faces where it meets its
//! neighbours. They are not on the surface of the union, but a query of the part alone finds them:
//! a box that slides over a floor of tiles hits the side of the next tile, because that is the
//! shortest way out of the tile. [`weld`] finds such normals and replaces them by normals of
//! exposed faces.
//!
//! # What is a normal of the union
//! Let x be a contact point on part i, and n the normal there, outward. The normal is kept if, for
//! one of the points,
//! - no part that contains x extends beyond the plane through x with normal n. Then n is a proximal
//!   normal of the union at x: a ball that touches the plane at x from outside touches the union
//!   there only;
//! - or n is the normal of a face of i, and a point slightly above that face, near x, is outside
//!   all other parts. Then the face is exposed there, and x may be in a concave corner.
//!
//! Triangles have no inside: for them, in both cases, a point above x must also be visible from the
//! other body. If the body is on the floor above a slab's wall, no point of the wall is visible. On
//! a slanted wall, the point x nearest to the body is below the floor, where no triangle contains
//! it.
//!
//! # Steps
//! 1. Test the normal. In most cases the first point passes, with one descent of the BVH.
//! 2. Otherwise collect the faces of the part near the contact, ordered by the depth to which the
//!    other body penetrates below them.
//! 3. Take the face of least depth that is exposed, either at the place of the other body or at the
//!    contact.
//! 4. Compute the manifold along its normal. If it has no points, but no other part holds the body,
//!    try the place of the face nearest to the body. If the body is not above it, the part does not
//!    support the body; the neighbouring part does, with its own manifold.
//!
//! # Reference
//! Rouwe, "Architecting Jolt Physics for Horizon Forbidden West", GDC 2022 (enhanced internal edge
//! removal). Proximal normals: Clarke, Ledyaev, Stern, Wolenski, "Nonsmooth Analysis and Control
//! Theory", 1998, section 1.1.
//!
//! # Deviations
//! - Jolt drops contacts on features of triangles that another contact has used. That requires
//!   neighbours that share edges and vertices. Convex parts overlap, and meet in parts of faces, so
//!   here points are tested against the neighbours themselves.
//! - Contacts are corrected, not dropped. The tip of a needle that stands on a seam is nearest to
//!   the two internal faces, and no other contact would hold it.

#![forbid(unsafe_code)]

use super::bvh::Child;
use super::parts::Parts;
use crate::hull::Hull;
use crate::manifold::{Body, Manifold, ManifoldPoint, ManifoldSettings};
use crate::pose::Pose;
use crate::shapes::triangle::closest_of_triangle;
use crate::shapes::{Feature, Shape, Triangle};
use crate::solver::signed_distance::is_near;
use crate::support::SupportMap;
use crate::vector::unit;
use arrayvec::ArrayVec;
use glam::DVec3;
use hullmap_format::bvh::MAX_LEVELS;

/// Gaps and steps between parts up to this fraction of the prediction are ignored. In Rapier this
/// is 0.1 mm: a tenth of the penetration that it allows, and far above the rounding of f32.
const SEAM: f64 = 0.005;

/// A seam is at least as wide as this fraction of the smaller outer radius, whatever the
/// prediction.
const LEAST_SEAM: f64 = 1e-5;

/// A seam is at least as wide as the rounding of the parts' coordinates to f32, relative to a
/// coordinate: half a unit for each of two parts, and as much for the planes through them.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// Height above a face at which a point is tested, in units of the seam's width.
const ABOVE: f64 = 2.0;

/// How far a point is moved towards the middle of its face before that, in units of the seam's
/// width: contact points are often on an edge of the face, and the point above an edge of an
/// inclined internal face can be outside the union.
const INTO_FACE: f64 = 16.0;

/// How far a face must be visible to the other body, in units of the seam's width. Behind a sheet
/// to which it extends, it is not, if the body is at most 32 times farther along the sheet than
/// above it.
const SIGHT: f64 = 32.0 * INTO_FACE;

/// How far from the body other triangles may hide a point of it, in units of the prediction: half
/// the way on which this is tested, and a little more.
pub(super) const SIGHT_REACH: f64 = 0.52 * SIGHT * SEAM;

/// Sine of the angle up to which a normal counts as the normal of a face. Normals of small gaps are
/// less exact than normals of depths; a body on a face whose normal is off by 1e-3 loses a
/// thousandth of its speed.
const FACE_ANGLE: f64 = 1e-3;

/// Maximum number of faces of a part among which the replacement is searched for.
const MAX_FACES: usize = 128;

/// Maximum number of faces for which a manifold is computed. The first one nearly always decides.
const MAX_TRIALS: usize = 8;

/// A part of a [`Union`] near a point.
pub struct Neighbour<'n> {
    /// Index of the part.
    pub index: usize,
    /// The part.
    pub shape: &'n dyn Shape,
    /// Pose of the part in the frame of the union.
    pub place: Pose,
}

/// A union of convex parts, as [`weld`] queries it. Points and directions are in its frame.
///
/// Implemented for every compound of this crate, by [`union_of`]. Implement it for the compounds of
/// an engine.
pub trait Union {
    /// Whether `test` returns true for a part whose box is within `reach` of `point`. Calls it for
    /// these parts, in any order, until one call returns true. Calling it for more parts does no
    /// harm.
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool;

    /// Unit normal of the face of part `part` that is closest to `dir`; `None` if it has no faces.
    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3>;

    /// Calls `visit` with the outward unit normals of faces of part `part` and a point of each: all
    /// faces if there are few, or those around the vertex `vertex`.
    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3));
}

/// One of two touching shapes, and the union that it is a part of.
pub struct Side<'s, S: ?Sized> {
    /// The shape.
    pub shape: &'s S,
    /// The union, the index of the shape in it, and the shape's pose in the frame of the union.
    /// `None` for a single shape.
    pub union: Option<(&'s dyn Union, usize, Pose)>,
}

/// Replaces the normal of `manifold` if it is not a normal of the union that A or B is a part of,
/// and returns whether it was replaced. The new points are computed along the new normal; there may
/// be none.
///
/// `manifold` has just been updated for the two shapes. `before` is the same manifold before that
/// update: points that it had keep their impulses, user data and ages.
///
/// # Complexity
/// One descent of the union's BVH for the first point, and a support query for each part whose box
/// is near it. A replacement costs at most 128 support queries and 8 manifolds. No allocation.
pub fn weld<A: Shape + ?Sized, B: Shape + ?Sized>(
    manifold: &mut Manifold,
    before: &Manifold,
    a: &Side<'_, A>,
    b: &Side<'_, B>,
    b_in_a: Pose,
    settings: &ManifoldSettings,
) -> bool {
    match correct(manifold, before, a, b, b_in_a, settings) {
        Correction::Kept => return false,
        Correction::Replaced => {}
        Correction::Unsupported => manifold.clear(),
    }
    true
}

/// Result of the correction of a manifold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Correction {
    Kept,
    Replaced,
    /// The part does not support the body. The manifold has not changed.
    Unsupported,
}

/// [`weld`], but a manifold of a part that does not support the body stays.
pub(super) fn correct<A: Shape + ?Sized, B: Shape + ?Sized>(
    manifold: &mut Manifold,
    before: &Manifold,
    a: &Side<'_, A>,
    b: &Side<'_, B>,
    b_in_a: Pose,
    settings: &ManifoldSettings,
) -> Correction {
    if manifold.points().is_empty() || a.union.is_none() && b.union.is_none() {
        return Correction::Kept;
    }
    let reach = a.shape.outer_radius().min(b.shape.outer_radius());
    let rounding = a.farthest(manifold, |p| p.point_a).max(b.farthest(manifold, |p| p.local_b)) * ROUNDING;
    let seam = (SEAM * settings.prediction.length(reach)).max(LEAST_SEAM * reach).max(rounding);
    let pair = PartPair { a, b, b_in_a, seam };
    let a_allows = pair.a_allows(manifold);
    if a_allows && pair.b_allows(manifold) {
        return Correction::Kept;
    }
    pair.replace(a_allows, manifold, before, settings)
}

/// A compound or a shape of this crate as a [`Union`].
pub fn union_of<P: Parts + ?Sized>(parts: &P) -> impl Union + '_ {
    OfParts(parts)
}

/// Allowance for the rounding error of a box, relative to its coordinates.
const BOX_ROUNDING: f64 = 4.0 * f64::EPSILON;

struct OfParts<'p, P: ?Sized>(&'p P);

impl<P: Parts + ?Sized> Union for OfParts<'_, P> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        // More than the rounding error of the corners.
        let side = DVec3::splat(reach) + BOX_ROUNDING * (point.abs() + DVec3::splat(reach));
        let triangles = self.0.any_in_box([point - side, point + side], &mut |index, corners| {
            test(Neighbour { index, shape: &Triangle::of_finite(corners), place: Pose::IDENTITY })
        });
        if let Some((found, _)) = triangles {
            return found;
        }
        let mut visit = |index: usize| {
            let part = self.0.part(index);
            part.is_some_and(|part| test(Neighbour { index, shape: &part, place: Pose::IDENTITY }))
        };
        let nodes = self.0.nodes();
        let mut stack: ArrayVec<u32, { MAX_LEVELS as usize + 1 }> = [0].into_iter().collect();
        let mut visited = 0_usize;
        while let Some(index) = stack.pop() {
            // Also ends in a cycle, which only a pack opened unchecked can have.
            visited += 1;
            let Some(node) = nodes.get(index).filter(|_| visited <= nodes.count()) else { return false };
            // Written so that a NaN would not skip the node.
            if node.distance(point) > reach {
                continue;
            }
            match node.child {
                Child::Nothing => {}
                Child::Hull(index) if visit(index) => return true,
                Child::Hull(_) => {}
                Child::Nodes(first) => {
                    for child in [first, first.saturating_add(1)] {
                        let _ = stack.try_push(child);
                    }
                }
            }
        }
        false
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        if let Some(hull) = self.0.part_as_hull(part) {
            hull.face_normal(hull.face_towards(dir)?)
        } else if let Some(normal) = self.0.sheet_normal(part) {
            Some(if normal.dot(dir) < 0.0 && !self.0.is_one_sided() { -normal } else { normal })
        } else {
            face_of(&self.0.part(part)?, dir).map(|(normal, _)| normal)
        }
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        if let Some(hull) = self.0.part_as_hull(part) {
            return faces_of_hull(&hull, vertex, visit);
        }
        let Some(shape) = self.0.part(part) else { return };
        if let Some(normal) = self.0.sheet_normal(part) {
            visit(normal, shape.support_point(normal).point);
            if !self.0.is_one_sided() {
                visit(-normal, shape.support_point(-normal).point);
            }
        } else {
            faces_of_shape(&shape, visit);
        }
    }
}

/// [`Union::faces_near`] of a hull.
pub fn faces_of_hull(hull: &Hull<'_>, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
    let mut give = |face: u32| {
        if let (Some(normal), Some(corner)) = (hull.face_normal(face), hull.face(face).next()) {
            visit(normal, hull.vertex(corner).unwrap_or_default().as_dvec3());
        }
    };
    if hull.face_count() <= MAX_FACES {
        (0..hull.face_count() as u32).for_each(give);
    } else {
        hull.faces_at(vertex).for_each(&mut give);
        hull.neighbours(vertex).flat_map(|near| hull.faces_at(near)).for_each(give);
    }
}

/// [`Union::faces_near`] of a shape whose faces cannot be listed: those closest to the axes.
pub fn faces_of_shape<S: Shape + ?Sized>(shape: &S, visit: &mut dyn FnMut(DVec3, DVec3)) {
    for axis in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
        if let Some((normal, point)) = face_of(shape, axis) {
            visit(normal, point);
        }
    }
}

/// Unit normal and a point of the face of `shape` towards `dir`; `None` if the shape has only an
/// edge or a vertex there.
pub fn face_of<S: Shape + ?Sized>(shape: &S, dir: DVec3) -> Option<(DVec3, DVec3)> {
    let mut feature = Feature::new();
    shape.feature(dir, &mut feature);
    let [first, .., last] = feature.corners() else { return None };
    let (corners, next) = (feature.corners().iter(), feature.corners().iter().skip(1));
    let areas = corners.zip(next).map(|(p, q)| (p.point - first.point).cross(q.point - first.point));
    let normal = unit(areas.sum::<DVec3>())?;
    let outward = if normal.dot(dir) < 0.0 { -normal } else { normal };
    (feature.corners().len() > 2).then_some((outward, last.point))
}

impl<S: Shape + ?Sized> Side<'_, S> {
    /// Greatest coordinate of the points `on` the shape, in the frame of the union; 0 without one.
    fn farthest(&self, manifold: &Manifold, on: impl Fn(&ManifoldPoint) -> DVec3) -> f64 {
        let Some((_, _, place)) = self.union else { return 0.0 };
        let coordinate = |p: &ManifoldPoint| place.transform_point(on(p)).abs().max_element();
        manifold.points().iter().map(coordinate).fold(0.0, f64::max)
    }

    /// Whether `normal` is a normal of the union at one of the points `on`. All are in the shape's
    /// frame; `normal` is outward, and `body` is a point inside the other body. See the
    /// [module](self).
    fn allows(
        &self,
        normal: DVec3,
        points: &[ManifoldPoint],
        on: impl Fn(&ManifoldPoint) -> DVec3,
        body: DVec3,
        seam: f64,
    ) -> bool {
        let Some((union, part, place)) = self.union else { return true };
        // If a face is not quite perpendicular to the normal, only its highest points count.
        let height = |p: &&ManifoldPoint| on(p).dot(normal);
        let top = points.iter().map(|p| height(&p)).fold(f64::NEG_INFINITY, f64::max);
        let highest = || points.iter().filter(|p| height(p) >= top - seam).map(|p| place.transform_point(on(p)));
        let outward = place.transform_vector(normal);
        let body_in_union = place.transform_point(body);
        let is_seen = |point: DVec3| self.is_seen(union, part, point + outward * seam, body_in_union, seam);
        if highest().any(|point| !self.is_topped(union, part, point, outward, seam) && is_seen(point)) {
            return true;
        }
        let closest = union.face_towards(part, outward);
        let is_face = closest.is_some_and(|face| face.cross(outward).length() <= FACE_ANGLE && face.dot(outward) > 0.0);
        is_face && points.iter().any(|p| self.is_exposed(normal, on(p), body, seam))
    }

    /// Whether another part contains `point` and extends beyond the plane there. All are in the
    /// frame of the union.
    fn is_topped(&self, union: &dyn Union, part: usize, point: DVec3, outward: DVec3, seam: f64) -> bool {
        union.any_near(point, seam, &mut |near| {
            if near.index == part {
                return false;
            }
            let height = match corners(&near) {
                Some(corners) => highest(corners, outward, point),
                None => {
                    let dir = near.place.inverse_transform_vector(outward);
                    (near.place.transform_point(near.shape.support_point(dir).point) - point).dot(outward)
                }
            };
            height > seam && contains(&near, point, seam)
        })
    }

    /// Whether the face with this normal is exposed near a point, to the other body. `body` is a
    /// point of that body. All are in the shape's frame.
    fn is_exposed(&self, normal: DVec3, point: DVec3, body: DVec3, seam: f64) -> bool {
        let Some((union, part, place)) = self.union else { return true };
        let mut face = Feature::new();
        self.shape.reduced_feature_within(normal, seam, &mut face);
        let middle = face.corners().iter().map(|c| c.point).sum::<DVec3>() / face.corners().len().max(1) as f64;
        let across = middle - point;
        let above = point + (across * 0.5).clamp_length_max(INTO_FACE * seam) + normal * (ABOVE * seam);
        let [above, body] = [above, body].map(|point| place.transform_point(point));
        !union.any_near(above, seam, &mut |near| near.index != part && contains(&near, above, seam))
            && self.is_seen(union, part, above, body, seam)
    }

    /// Whether no other triangle hides a point near the shape from the other body. `body` is a
    /// point of that body. Only a sheet hides what is behind it: it has no inside. All are in the
    /// frame of the union.
    fn is_seen(&self, union: &dyn Union, part: usize, point: DVec3, body: DVec3, seam: f64) -> bool {
        let way = (body - point).clamp_length_max(SIGHT * seam);
        self.shape.triangle().is_none()
            || !union.any_near(point + way * 0.5, 0.5 * way.length(), &mut |near| {
                near.index != part && hides(&near, [point, point + way])
            })
    }

    /// Calls `visit` with the normals of faces near the vertex that is farthest along `normal`, and
    /// a point of each. All are in the shape's frame.
    fn faces(&self, normal: DVec3, visit: &mut dyn FnMut(DVec3, DVec3)) {
        let Some((union, part, place)) = self.union else { return };
        let back = place.inverse();
        let vertex = self.shape.support_point(normal).feature;
        union.faces_near(part, vertex, &mut |face, point| {
            visit(place.inverse_transform_vector(face), back.transform_point(point));
        });
    }
}

/// The corners of a part in the frame of the union, if it is a triangle.
fn corners(near: &Neighbour<'_>) -> Option<[DVec3; 3]> {
    let corners = near.shape.triangle()?;
    // Every mesh that is not one of several tiles is in place.
    let is_in_place = near.place == Pose::IDENTITY;
    Some(if is_in_place { corners } else { corners.map(|corner| near.place.transform_point(corner)) })
}

/// Height of the highest corner above `point`, along the unit vector `outward`.
fn highest(corners: [DVec3; 3], outward: DVec3, point: DVec3) -> f64 {
    // NaN takes the failing branch.
    corners.into_iter().map(|corner| (corner - point).dot(outward)).fold(f64::NEG_INFINITY, f64::max)
}

/// Whether a part is within `seam` of `point`.
fn contains(near: &Neighbour<'_>, point: DVec3, seam: f64) -> bool {
    if let Some(corners) = corners(near) {
        // NaN takes the failing branch.
        return closest_of_triangle(corners, point).distance_squared(point) <= seam * seam;
    }
    is_near(near.shape, near.place.inverse().transform_point(point), seam)
}

/// Whether a triangle is between two points.
fn hides(near: &Neighbour<'_>, between: [DVec3; 2]) -> bool {
    let Some([a, b, c]) = corners(near) else { return false };
    let [start, end] = between;
    let normal = (b - a).cross(c - a);
    let [from, to] = [start, end].map(|point| (point - a).dot(normal));
    let along = end - start;
    let side = |p: DVec3, q: DVec3| along.dot((q - start).cross(p - start));
    let sides = [side(a, b), side(b, c), side(c, a)];
    // NaN takes the failing branch.
    from * to < 0.0 && (sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0))
}

#[derive(Default)]
struct Faces {
    found: ArrayVec<Face, MAX_FACES>,
}

/// A face of a part, in the frame of the part.
#[derive(Clone, Copy)]
struct Face {
    /// Depth of the other body below the face, a length.
    depth: f64,
    /// Outward unit normal.
    normal: DVec3,
    height: f64,
}

impl Faces {
    fn push(&mut self, face: Face) {
        // NaN takes the failing branch.
        if face.depth > f64::NEG_INFINITY {
            let _ = self.found.try_push(face);
        }
    }

    /// Removes the face with the least depth.
    fn pop(&mut self) -> Option<Face> {
        let least = self.found.iter().enumerate().min_by(|(_, p), (_, q)| p.depth.total_cmp(&q.depth))?.0;
        self.found.swap_pop(least)
    }
}

struct PartPair<'p, A: ?Sized, B: ?Sized> {
    a: &'p Side<'p, A>,
    b: &'p Side<'p, B>,
    b_in_a: Pose,
    seam: f64,
}

impl<A: Shape + ?Sized, B: Shape + ?Sized> PartPair<'_, A, B> {
    fn a_allows(&self, manifold: &Manifold) -> bool {
        let body = self.b_in_a.transform_point(self.b.shape.interior_point());
        self.a.allows(manifold.normal(), manifold.points(), |p| p.point_a, body, self.seam)
    }

    fn b_allows(&self, manifold: &Manifold) -> bool {
        let outward = self.b_in_a.inverse_transform_vector(-manifold.normal());
        let body = self.b_in_a.inverse().transform_point(self.a.shape.interior_point());
        self.b.allows(outward, manifold.points(), |p| p.local_b, body, self.seam)
    }

    /// Computes the manifold along the normal of the least deep exposed face: of B's part if
    /// `a_allows` the normal, otherwise of A's. A part without faces keeps its manifold.
    #[inline(never)]
    fn replace(
        &self,
        a_allows: bool,
        manifold: &mut Manifold,
        before: &Manifold,
        settings: &ManifoldSettings,
    ) -> Correction {
        let b_in_a = self.b_in_a;
        let update = |trial: &mut Manifold, along: DVec3| {
            trial.update_along((self.a.shape, self.b.shape, b_in_a), along, settings);
        };
        let prediction = settings.prediction.length(self.a.shape.outer_radius().min(self.b.shape.outer_radius()));
        if !a_allows {
            let to_a = |normal: DVec3| normal;
            let points = |p: &ManifoldPoint| [p.point_a, p.point_b];
            let part = Weld { own: self.a, other: self.b.shape, other_in_own: b_in_a, seam: self.seam, prediction };
            let choice = part.choose(manifold, before, points, to_a, update, |trial| self.b_allows(trial));
            self.take(choice, manifold, before, |point| (point, Body::B), to_a, settings)
        } else {
            let a_in_b = b_in_a.inverse();
            let to_a = |normal: DVec3| b_in_a.transform_vector(-normal);
            let points = |p: &ManifoldPoint| [p.local_b, a_in_b.transform_point(p.point_a)];
            let part = Weld { own: self.b, other: self.a.shape, other_in_own: a_in_b, seam: self.seam, prediction };
            let choice = part.choose(manifold, before, points, to_a, update, |trial| self.a_allows(trial));
            let of_other = |point: DVec3| (b_in_a.transform_point(point), Body::A);
            self.take(choice, manifold, before, of_other, to_a, settings)
        }
    }

    /// Applies a choice. `of_other` converts a point of the other body to one in A's frame.
    fn take(
        &self,
        choice: Choice,
        manifold: &mut Manifold,
        before: &Manifold,
        of_other: impl Fn(DVec3) -> (DVec3, Body),
        to_a: impl Fn(DVec3) -> DVec3,
        settings: &ManifoldSettings,
    ) -> Correction {
        match choice {
            Choice::NoFaces => return Correction::Kept,
            Choice::Nothing => return Correction::Unsupported,
            Choice::Manifold(chosen) => *manifold = chosen,
            Choice::Point(point, normal) => {
                *manifold = before.clone();
                let pair = (self.a.shape, self.b.shape, self.b_in_a);
                manifold.update_at(pair, to_a(normal), of_other(point), settings);
            }
        }
        // The other body may be beside the face.
        if manifold.points().is_empty() { Correction::Unsupported } else { Correction::Replaced }
    }
}

#[expect(clippy::large_enum_variant, reason = "returned once, never stored")]
enum Choice {
    /// The part has no faces: it keeps its manifold.
    NoFaces,
    /// The part does not hold the body.
    Nothing,
    Manifold(Manifold),
    /// A point of the other body near the part, and the normal of the face.
    Point(DVec3, DVec3),
}

/// A part whose normal is replaced, and the other body. All points and directions are in the
/// frame of the part.
struct Weld<'p, S: ?Sized, T: ?Sized> {
    own: &'p Side<'p, S>,
    other: &'p T,
    other_in_own: Pose,
    seam: f64,
    prediction: f64,
}

impl<S: Shape + ?Sized, T: Shape + ?Sized> Weld<'_, S, T> {
    /// The replacement of `manifold`. `points` returns a manifold point on the part and on the
    /// other body, `to_a` converts an outward normal to one from A to B in A's frame, and
    /// `other_allows` is the test of the other body's union.
    fn choose(
        &self,
        manifold: &Manifold,
        before: &Manifold,
        points: impl Fn(&ManifoldPoint) -> [DVec3; 2],
        to_a: impl Fn(DVec3) -> DVec3,
        update: impl Fn(&mut Manifold, DVec3),
        other_allows: impl Fn(&Manifold) -> bool,
    ) -> Choice {
        let Some(contact) = manifold.points().iter().max_by(|p, q| p.depth.total_cmp(&q.depth)) else {
            return Choice::NoFaces;
        };
        let [point, witness] = points(contact);
        let mut faces = Faces::default();
        let outward = if contact.depth > 0.0 { point - witness } else { witness - point };
        self.own.faces(outward, &mut |normal, corner| {
            let height = corner.dot(normal);
            faces.push(Face { depth: height - self.lowest(normal).dot(normal), normal, height });
        });
        if faces.found.is_empty() {
            return Choice::NoFaces;
        }
        let mut beside: Option<(Face, f64)> = None;
        // A flat part has no inside. A body is in front of the face that is less deep, and through
        // the other one it would be pushed out on the side that it has not come from.
        let is_flat = self.own.shape.inner_radius() == 0.0;
        for _ in 0..if is_flat { 1 } else { MAX_TRIALS } {
            let Some(face) = faces.pop() else { break };
            if !self.is_plausible(&face, contact.depth) {
                break;
            }
            let mut trial = before.clone();
            update(&mut trial, to_a(face.normal));
            if trial.points().is_empty() {
                if beside.is_none() {
                    let lift = face.height - point.dot(face.normal);
                    beside = self.is_on(&face, point).then_some((face, lift));
                }
                // If the contact is on this face, no other one is less deep there.
                if beside.is_some_and(|(_, lift)| lift <= self.seam) {
                    break;
                }
            } else {
                let is_exposed =
                    |p: &ManifoldPoint| self.own.is_exposed(face.normal, points(p)[0], self.body(), self.seam);
                // A body that reaches over a peak may have its middle below the plane of a triangle
                // beyond it. Then the back is less deep, but the body has not come through it.
                let is_against = is_flat && to_a(face.normal).dot(manifold.normal()) < 0.0;
                let has_come = |p: &ManifoldPoint| !is_against || self.has_come_through(points(p)[1]);
                if trial.points().iter().any(|p| is_exposed(p) && has_come(p)) && other_allows(&trial) {
                    return Choice::Manifold(trial);
                }
            }
        }
        // The body entered through an exposed face, but its lowest point is beside the part. If
        // that point is in another part, that part holds the body. Otherwise the point is outside
        // the union, beyond one of its edges, and the nearest place of this part may hold it.
        match beside {
            Some((face, _)) if contact.depth > self.seam && !self.is_held(self.lowest(face.normal)) => {
                Choice::Point(witness, face.normal)
            }
            _ => Choice::Nothing,
        }
    }

    /// A point inside the other body.
    fn body(&self) -> DVec3 {
        self.other_in_own.transform_point(self.other.interior_point())
    }

    /// Whether a triangle, this one or another, is between a point of the other body and its
    /// middle.
    fn has_come_through(&self, point: DVec3) -> bool {
        let Some((union, _, place)) = self.own.union else { return true };
        let [point, body] = [point, self.body()].map(|point| place.transform_point(point));
        let way = body - point;
        union.any_near(point + way * 0.5, 0.5 * way.length(), &mut |near| hides(&near, [point, body]))
    }

    /// The point of the other body that is lowest along `normal`.
    fn lowest(&self, normal: DVec3) -> DVec3 {
        let dir = self.other_in_own.inverse_transform_vector(-normal);
        self.other_in_own.transform_point(self.other.support_point(dir).point)
    }

    /// Whether the other body may have come through this face: it is not below the middle of the
    /// part, nor below the face by more than the prediction if the part is only near it. A flat
    /// part has no middle: the face that is less deep counts.
    fn is_plausible(&self, face: &Face, depth: f64) -> bool {
        if depth > 0.0 && self.own.shape.inner_radius() == 0.0 {
            return true;
        }
        let thickness = face.height - self.own.shape.support_point(-face.normal).point.dot(face.normal);
        // NaN takes the failing branch.
        face.depth <= if depth > 0.0 { 0.5 * thickness } else { self.prediction }
    }

    /// Whether the point of this exposed face above `point` is on the part.
    fn is_on(&self, face: &Face, point: DVec3) -> bool {
        let lift = face.height - point.dot(face.normal);
        let above = point + face.normal * lift;
        let near = Neighbour { index: 0, shape: &self.own.shape, place: Pose::IDENTITY };
        contains(&near, above, self.seam + 0.25 * lift.max(0.0))
            && self.own.is_exposed(face.normal, above, self.body(), self.seam)
    }

    fn is_held(&self, point: DVec3) -> bool {
        let Some((union, part, place)) = self.own.union else { return false };
        let point = place.transform_point(point);
        union.any_near(point, self.seam, &mut |near| near.index != part && contains(&near, point, self.seam))
    }
}
