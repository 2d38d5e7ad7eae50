//! A pair of parts, at least one of which may be a triangle of a sheet: tests that rule the pair
//! out before the solver runs, and the contact of one-sided triangles.
//!
//! # Steps
//! 1. Separating axes of the triangle, for the ball around the other part: the normal, and the
//!    normals of the edges in the triangle's plane. No support query.
//! 2. The same axes that separate the ball's centre from the triangle, for the part itself: at most
//!    one support query each.
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, section 5.2 (separating axes).

#![forbid(unsafe_code)]

use glam::DVec3;

use super::parts::Parts;
use crate::manifold::{Manifold, ManifoldSettings};
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{Cache, Contact, Settings, queries};
use crate::support::SupportMap;

/// Rounding error of a height above a plane, relative to the largest length, in units of
/// [`f64::EPSILON`]: of a rotated support query (60 of the radius, as for a box), of a rotated and
/// moved point, and of a dot product with a computed normal.
const ROUNDING_UNITS: f64 = 128.0;

/// Squared lengths of a triangle's normal whose cubes neither overflow nor underflow.
const SQUARES: std::ops::Range<f64> = 1e-80..1e80;

/// Cosine of the angle between a contact normal and the normal of the back, up to which the contact
/// counts as a contact with the back.
const BACK: f64 = 0.99;

pub(super) struct CandidatePair<'p, A: Parts + ?Sized + 'p, B: Parts + ?Sized + 'p> {
    pub(super) a: A::Part<'p>,
    pub(super) b: B::Part<'p>,
    b_in_a: Pose,
    /// Fronts of both, in their frames.
    fronts: [Option<DVec3>; 2],
}

impl<'p, A: Parts + ?Sized, B: Parts + ?Sized> CandidatePair<'p, A, B> {
    /// The parts with these indices; `None` if one does not exist.
    #[inline]
    pub(super) fn new(a: &'p A, b: &'p B, pair: [usize; 2], b_in_a: Pose) -> Option<Self> {
        let fronts = [a.front(pair[0]), b.front(pair[1])];
        Some(Self { a: a.part(pair[0])?, b: b.part(pair[1])?, b_in_a, fronts })
    }

    /// Whether one part is behind the front of the other, so that they do not collide.
    #[inline]
    pub(super) fn is_behind(&self) -> bool {
        if self.fronts == [None; 2] {
            return false;
        }
        let (center_a, center_b) = (self.a.interior_point(), self.b.interior_point());
        let (in_a, in_b) = (self.b_in_a.transform_point(center_b), self.b_in_a.inverse().transform_point(center_a));
        is_behind(self.fronts[0], center_a, in_a) || is_behind(self.fronts[1], center_b, in_b)
    }

    /// Whether a motion of B by `velocity` does not meet the front of a part, or starts behind it.
    pub(super) fn is_passed(&self, velocity: DVec3) -> bool {
        let [front_a, front_b] = self.fronts;
        if velocity == DVec3::ZERO || self.fronts == [None; 2] {
            return self.is_behind();
        }
        let along = |front: DVec3, velocity: DVec3| !(front.dot(velocity) < 0.0);
        front_a.is_some_and(|front| along(front, velocity))
            || front_b.is_some_and(|front| along(front, self.b_in_a.inverse_transform_vector(-velocity)))
            || self.is_behind()
    }

    /// Whether an axis of a triangle proves that the parts are farther apart than `margin`.
    #[inline]
    pub(super) fn is_apart(&self, margin: f64) -> bool {
        match (self.a.triangle(), self.b.triangle()) {
            (Some(corners), _) => BesideSheet::new(&self.b, self.b_in_a).is_apart(corners, margin),
            (None, Some(corners)) => BesideSheet::new(&self.a, self.b_in_a.inverse()).is_apart(corners, margin),
            (None, None) => false,
        }
    }

    /// Their contact. A contact with the back of a one-sided triangle becomes the contact with the
    /// half-space behind it.
    pub(super) fn contact(&self, settings: &Settings, cache: &mut Cache) -> Contact {
        let found = queries::contact(&self.a, &self.b, self.b_in_a, settings, cache);
        let Some(front) = self.front_of_back(&found).filter(|_| found.hit) else { return found };
        let iterations = found.iterations;
        let found = if let Some(front) = self.fronts[0].filter(|own| *own == front) {
            let Ok(behind) = HalfSpace::through(self.a.interior_point(), front) else { return found };
            behind.lowest(&self.b, self.b_in_a).contact()
        } else {
            let Some(own) = self.fronts[1] else { return found };
            let Ok(behind) = HalfSpace::through(self.b.interior_point(), own) else { return found };
            behind.lowest(&self.a, self.b_in_a.inverse()).contact().exchanged(self.b_in_a)
        };
        Contact { iterations: found.iterations + iterations, ..found }
    }

    pub(super) fn update(&self, manifold: &mut Manifold, settings: &ManifoldSettings, cache: &mut Cache) -> Contact {
        let contact = manifold.update(&self.a, &self.b, self.b_in_a, settings, cache);
        if let Some(front) = self.front_of_back(&contact)
            && contact.hit
        {
            manifold.update_along((&self.a, &self.b, self.b_in_a), front, settings);
        }
        contact
    }

    /// The normal to the front, from A to B in A's frame, if a contact is one with the back.
    fn front_of_back(&self, contact: &Contact) -> Option<DVec3> {
        let [front_a, front_b] = self.fronts;
        let from_b = || front_b.map(|front| self.b_in_a.transform_vector(-front));
        [front_a, from_b()].into_iter().flatten().find(|front| contact.normal.dot(*front) < -BACK)
    }
}

/// Whether a point is behind a plane, or in it.
fn is_behind(front: Option<DVec3>, on_plane: DVec3, point: DVec3) -> bool {
    // NaN takes the branch that does not collide.
    front.is_some_and(|front| !((point - on_plane).dot(front) > 0.0))
}

/// A shape beside a sheet, with what the tests of all triangles have in common.
pub(super) struct BesideSheet<'s, S: ?Sized> {
    shape: &'s S,
    /// Pose of the shape in the frame of the sheet.
    pose: Pose,
    /// The middle of the ball around the shape, in the frame of the sheet, and its radius.
    middle: DVec3,
    radius: f64,
    /// Sum of the lengths that heights are computed from, without the lengths of the triangle.
    lengths: f64,
}

impl<'s, S: Shape + ?Sized> BesideSheet<'s, S> {
    pub(super) fn new(shape: &'s S, pose: Pose) -> Self {
        let (center, radius) = (shape.interior_point(), shape.outer_radius());
        let lengths = center.abs().element_sum() + pose.translation().abs().element_sum() + radius;
        Self { shape, pose, middle: pose.transform_point(center), radius, lengths }
    }

    /// Whether an axis of a triangle proves that the shape is farther away than `margin`.
    ///
    /// Whatever the axis is, the test is a proof: the axes of a sliver need not be accurate. Axes
    /// are not of unit length: heights are compared by their squares.
    pub(super) fn is_apart(&self, [a, b, c]: [DVec3; 3], margin: f64) -> bool {
        let normal = (b - a).cross(c - a);
        // The squares of heights along the edges' normals have about the cube of this. NaN takes
        // the failing branch.
        if !SQUARES.contains(&normal.length_squared()) {
            return false;
        }
        let lengths = self.lengths + [a, b, c].map(|corner| corner.abs().element_sum()).iter().sum::<f64>();
        let margin = margin + self.shape.support_error() + ROUNDING_UNITS * f64::EPSILON * lengths;
        let upward = if (self.middle - a).dot(normal) < 0.0 { -normal } else { normal };
        // The highest corners along these axes are those that the edge starts from.
        let axes = [(upward, a), ((b - a).cross(normal), a), ((c - b).cross(normal), b), ((a - c).cross(normal), c)];
        // Height of a point above the highest corner, in units of the axis.
        let above = |(axis, top): (DVec3, DVec3), point: DVec3| {
            let rise = [a, b, c].map(|corner| (corner - top).dot(axis)).into_iter().fold(0.0, f64::max);
            (point - top).dot(axis) - rise
        };
        let is_farther = |axis: (DVec3, DVec3), height: f64, length: f64| {
            height > 0.0 && height * height > length * length * axis.0.length_squared()
        };
        let mut heights = [0.0; 4];
        for (height, axis) in heights.iter_mut().zip(axes) {
            *height = above(axis, self.middle);
            if is_farther(axis, *height, self.radius + margin) {
                return true;
            }
        }
        axes.into_iter().zip(heights).any(|(axis, height)| {
            let lowest = || {
                let support = self.shape.support_point(self.pose.inverse_transform_vector(-axis.0));
                self.pose.transform_point(support.point)
            };
            is_farther(axis, height, margin) && is_farther(axis, above(axis, lowest()), margin)
        })
    }
}
