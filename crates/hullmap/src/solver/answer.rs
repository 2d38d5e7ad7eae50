//! Answer of a contact query, and how it is made for shapes that an axis separates.

use glam::DVec3;

use super::cache::Cache;
use super::minkowski::Minkowski;
use super::status::Status;
use crate::fields::fields;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::unit;

/// Answer of [`contact`](crate::contact()): penetration depth, normal and witness points of a pair.
///
/// Lengths are in the shapes' unit, points and directions in A's frame. If rounding error or a
/// limit stopped the search, `status` says so; the interval from `depth_lower` to `depth_upper`
/// always contains the depth.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// False only if a separating plane proves the shapes separated.
    pub hit: bool,
    /// Whether it is certain that no other normal has nearly the same depth. For the derivatives.
    #[doc(hidden)]
    pub is_only_normal: bool,
    /// How the query ended, and thus how narrow the interval is.
    pub status: Status,
    /// Penetration depth: moving B by this length along `normal` makes the shapes touch. 0 if they
    /// are separated or touch.
    pub depth: f64,
    /// Lower bound of the penetration depth, at least 0, with allowance for rounding error.
    pub depth_lower: f64,
    /// Upper bound of the penetration depth, with allowance for rounding error.
    pub depth_upper: f64,
    /// Unit vector from A to B. If two convex shapes are separated, a separating axis. If parts are
    /// separated, the normal and the points are NaN: one axis may not separate them all.
    pub normal: DVec3,
    /// Witness point: the point of A that is deepest in B. If the shapes are separated, some point
    /// of A; [`distance`](crate::distance()) computes the closest one.
    ///
    /// Both witness points are in their shapes and on their support planes along `normal`, and
    /// `point_a` − `point_b` is `depth` times `normal`: all to within the width of the interval and
    /// rounding error. With the statuses [`IterationLimit`](Status::IterationLimit) and
    /// [`Stalled`](Status::Stalled), `point_a` − `point_b` may differ from that across the normal,
    /// and if the lower bound is 0, along it as well.
    pub point_a: DVec3,
    /// Witness point: the point of B that is deepest in A. If the shapes are separated, some point
    /// of B.
    pub point_b: DVec3,
    /// Number of steps of all phases together.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    /// mesh or a field. 0 for a shape without parts.
    pub parts: [u32; 2],
    /// Features of a point of A and of a point of B in their support planes along the normal; the
    /// greatest number if they are not known. For the derivatives.
    #[doc(hidden)]
    pub features: [u32; 2],
}

fields!(
    Contact { hit status depth depth_lower depth_upper normal point_a point_b iterations support_calls parts }
    but { features is_only_normal }
);

/// How much deeper B is moved to find other normals of the same depth, as a fraction of the sum of
/// the outer radii. Along another normal n′, the depth grows by n · n′ of that.
const DEEPER: f64 = 1e-6;

/// Multiples of the width of the interval by which B is moved at least.
const WIDTHS: f64 = 64.0;

impl Contact {
    /// The contact of two geometries that are separated, though no single plane separates them.
    pub(crate) const SEPARATED_PARTS: Self = Self {
        hit: false,
        status: Status::Separated,
        depth: 0.0,
        depth_lower: 0.0,
        depth_upper: 0.0,
        normal: DVec3::NAN,
        point_a: DVec3::NAN,
        point_b: DVec3::NAN,
        iterations: 0,
        support_calls: 0,
        parts: [0; 2],
        features: [u32::MAX; 2],
        is_only_normal: false,
    };

    /// The same contact with A and B exchanged.
    pub(crate) fn exchanged(self, b_in_a: Pose) -> Self {
        let ([of_a, of_b], [vertex_a, vertex_b]) = (self.parts, self.features);
        Self {
            normal: b_in_a.transform_vector(-self.normal),
            point_a: b_in_a.transform_point(self.point_b),
            point_b: b_in_a.transform_point(self.point_a),
            parts: [of_b, of_a],
            features: [vertex_b, vertex_a],
            ..self
        }
    }

    /// How much deeper B is moved to find other normals of the same depth, for these outer radii of
    /// both shapes together.
    pub(crate) fn deeper(&self, outer_radii: f64) -> f64 {
        deeper([self.depth_lower, self.depth_upper], outer_radii)
    }

    /// The same contact, with what follows from `others`, a lower bound of the depth along other
    /// normals. docs/contributors/intervals.md, section 16, says along which, and proves that these
    /// are enough.
    pub(super) fn with_others(self, others: f64, outer_radii: f64) -> Self {
        // NaN takes the failing branch.
        Self { is_only_normal: others >= beside([self.depth_lower, self.depth_upper], outer_radii), ..self }
    }
}

/// [`Contact::deeper`] for this interval of the depth.
pub(super) fn deeper([lower, upper]: [f64; 2], outer_radii: f64) -> f64 {
    (DEEPER * outer_radii).max(WIDTHS * (upper - lower))
}

/// The depth along other normals from which on they do not matter, for this interval of the depth.
pub(super) fn beside([lower, upper]: [f64; 2], outer_radii: f64) -> f64 {
    upper + 2.0 * deeper([lower, upper], outer_radii)
}

impl Default for Contact {
    /// A contact that claims nothing: the interval [0, ∞) contains every depth. It initialises the
    /// slices of a batch.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::IterationLimit,
            depth: 0.0,
            depth_lower: 0.0,
            depth_upper: f64::INFINITY,
            normal: DVec3::X,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            iterations: 0,
            support_calls: 0,
            parts: [0; 2],
            features: [u32::MAX; 2],
            is_only_normal: false,
        }
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'_, A, B> {
    /// No contact: `axis` separates the shapes. Stores the axis in the cache.
    pub(super) fn separated_contact(&self, cache: &mut Cache, axis: DVec3, iterations: u32) -> Contact {
        let axis = unit(axis).unwrap_or(DVec3::X);
        cache.set_axis(axis);
        let center = self.center_point();
        Contact {
            hit: false,
            status: Status::Separated,
            depth_upper: 0.0,
            normal: axis,
            point_a: center.a,
            point_b: center.b(),
            iterations,
            support_calls: self.support_calls(),
            ..Contact::default()
        }
    }
}
