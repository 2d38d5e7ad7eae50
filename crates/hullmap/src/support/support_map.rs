//! Support mapping: the only interface between the solver and a shape.

use glam::DVec3;

/// Support point of a shape: a point of the shape with the maximum dot product with the query
/// direction.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{SupportMap, SupportPoint};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let SupportPoint { point, feature } = cube.support_point(DVec3::new(1.0, 2.0, -3.0));
/// assert_eq!(point, DVec3::new(1.0, 1.0, -1.0));
/// // A cuboid numbers its vertices by the signs of their coordinates.
/// assert_eq!(feature, 0b100);
/// # Ok::<(), hullmap::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportPoint {
    /// The point, in the shape's local frame.
    pub point: DVec3,
    /// Identifies the point among the shape's features: on a hull, the vertex index. Shapes with
    /// vertices return equal points for equal features.
    pub feature: u32,
}

/// A convex shape, described by its support mapping.
///
/// All points, directions and lengths are in the shape's local frame and units. Four methods are
/// required; the others make queries faster or account for an inexact mapping. Manifolds and
/// batches require a [`Shape`](crate::Shape): a support mapping with features.
///
/// # Examples
/// A shape of your own, here an ellipsoid about the origin:
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Pose, Settings, SupportMap, SupportPoint};
///
/// struct Ellipsoid(DVec3);
///
/// impl SupportMap for Ellipsoid {
///     fn support_point(&self, dir: DVec3) -> SupportPoint {
///         let unit = (dir * self.0).try_normalize().unwrap_or(DVec3::X);
///         SupportPoint { point: unit * self.0, feature: 0 }
///     }
///     fn interior_point(&self) -> DVec3 {
///         DVec3::ZERO
///     }
///     fn inner_radius(&self) -> f64 {
///         self.0.min_element()
///     }
///     fn outer_radius(&self) -> f64 {
///         self.0.max_element()
///     }
/// }
///
/// let egg = Ellipsoid(DVec3::new(1.0, 1.0, 2.0));
/// let b_in_a = Pose::from_translation(DVec3::new(0.0, 0.0, 5.0))?;
/// let gap = hullmap::distance(&egg, &egg, b_in_a, &Settings::default(), &mut Cache::new());
/// assert!((gap.distance - 1.0).abs() < 1e-9);
/// # Ok::<(), hullmap::PoseError>(())
/// ```
pub trait SupportMap {
    /// Support point in direction `dir`.
    ///
    /// `dir` need not be of unit length. For a zero or non-finite direction the result is any point
    /// of the shape. Must not panic.
    fn support_point(&self, dir: DVec3) -> SupportPoint;

    /// A point inside the shape, preferably far from its surface. The solver starts there. For a
    /// flat shape, a point on it.
    fn interior_point(&self) -> DVec3;

    /// Radius of a ball around [`interior_point`](Self::interior_point) that the shape contains; 0
    /// for a flat shape.
    fn inner_radius(&self) -> f64;

    /// Radius of a ball around [`interior_point`](Self::interior_point) that contains the shape.
    fn outer_radius(&self) -> f64;

    /// Maximum error of a support point: the length by which the shape may extend beyond it along
    /// the query direction, in addition to the rounding error of one dot product.
    ///
    /// [`contact`](crate::contact()) and [`distance`](crate::distance()) widen their intervals by
    /// it. The default is 0, for mappings that are exact up to rounding error.
    fn support_error(&self) -> f64 {
        0.0
    }

    /// The point of the [`SupportPoint`] with this `feature`; `None` if there is no such feature,
    /// or if features do not identify points.
    ///
    /// It lets the solver start from the support points of the previous query without repeating the
    /// support queries. `feature` may be any value; a returned point must belong to the shape. The
    /// default is `None`.
    fn point(&self, feature: u32) -> Option<DVec3> {
        let _ = feature;
        None
    }

    /// [`support_point`](Self::support_point) with a hint: the feature that a recent query in a
    /// similar direction returned. The hint may save time. The answer is as exact with it as
    /// without, and may be another of several points with the same dot product. The default ignores
    /// it.
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        let _ = hint;
        self.support_point(dir)
    }

    /// Convex radius: the shape is the Minkowski sum of its core and a ball of this radius. The
    /// default is 0: the shape is its own core.
    ///
    /// The core of a sphere is a point, that of a capsule a segment. Queries solve the cores, which
    /// takes a few exact steps where a curved shape would take many, and then add the radii.
    fn convex_radius(&self) -> f64 {
        0.0
    }

    /// Support point of the core in direction `dir`; by default that of the shape. The core has the
    /// same [`interior_point`](Self::interior_point) as the shape.
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        self.support_point(dir)
    }

    /// Radii of two balls around the interior point: one that the core contains, and one that
    /// contains the core. By default those of the shape.
    fn core_radii(&self) -> [f64; 2] {
        [self.inner_radius(), self.outer_radius()]
    }

    /// The point of the core with this feature, as [`point`](Self::point) is for the shape; by
    /// default that of the shape.
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        self.point(feature)
    }
}
