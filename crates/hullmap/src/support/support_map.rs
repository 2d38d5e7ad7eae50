//! Trait of support mappings: the only interface between the solver and a shape. Hulls implement it
//! in `hull/support_mapping.rs`; `support/index.rs` chooses the path of a query.

use super::bounds::Bounds;
use super::paused_lookup::Lookup;
use crate::facets::view::Facets;
use crate::pose::Pose;
use glam::{DMat3, DVec3};

/// Rounding error of a bound, in units of `f64::EPSILON` times the length of the interior point,
/// the outer radius and the length of the translation.
///
/// As in Lemma 4 of docs/contributors/intervals.md: the rotated direction costs 38 of the radius,
/// the rotated point 19, comparing dot products 3, and the two sums half a unit each. The excess
/// covers terms of second order.
const BOUND_UNITS: [f64; 3] = [25.0, 64.0, 2.0];

/// Support point of a shape: a point of the shape with the maximum dot product with the query
/// direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportPoint {
    /// The point, in the shape's local frame.
    pub point: DVec3,
    /// Identifies the point among the shape's features: on a hull, the vertex index. Shapes with
    /// vertices return equal points for equal features, and other features for other points: a
    /// manifold merges points on the same features. A shape without vertices returns 0.
    pub feature: u32,
}

/// Edges at a vertex that are perpendicular to a direction, nearly.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelEdges {
    /// Their number.
    pub count: usize,
    /// The longest one, from the vertex on.
    pub longest: DVec3,
    /// Length of the shortest one.
    pub shortest: f64,
}

/// The point of a feature that is farthest along a direction, and its derivative by that direction.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeaturePoint {
    pub point: DVec3,
    pub derivative: DMat3,
}

impl FeaturePoint {
    /// A vertex is the farthest point along every direction.
    pub(crate) fn vertex(point: DVec3) -> Self {
        Self { point, derivative: DMat3::ZERO }
    }

    /// The point of the Minkowski sum of the feature and a ball. `dir` is not 0.
    pub(crate) fn rounded(self, dir: DVec3, radius: f64) -> Self {
        let (length, n) = (dir.length(), dir.normalize());
        let across = DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        Self { point: self.point + n * radius, derivative: self.derivative + across * (radius / length) }
    }
}

/// A convex shape, described by its support mapping.
///
/// All points, directions and lengths are in the shape's local frame and units. Four methods are
/// required; the others make queries faster or account for an inexact mapping. Manifolds and
/// batches require a [`Shape`](crate::Shape): a support mapping with features.
///
/// # Examples
/// A shape of your own, here a square pyramid. Every vertex has a feature of its own:
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Manifold, ManifoldSettings, Pose, Settings, Shape, SupportMap, SupportPoint};
///
/// struct Pyramid;
///
/// impl Pyramid {
///     const VERTICES: [DVec3; 5] = [
///         DVec3::new(1.0, 1.0, 0.0),
///         DVec3::new(-1.0, 1.0, 0.0),
///         DVec3::new(-1.0, -1.0, 0.0),
///         DVec3::new(1.0, -1.0, 0.0),
///         DVec3::new(0.0, 0.0, 2.0),
///     ];
/// }
///
/// impl SupportMap for Pyramid {
///     fn support_point(&self, dir: DVec3) -> SupportPoint {
///         let mut best = 0;
///         for (i, vertex) in Self::VERTICES.iter().enumerate() {
///             if (*vertex - Self::VERTICES[best]).dot(dir) > 0.0 {
///                 best = i;
///             }
///         }
///         SupportPoint { point: Self::VERTICES[best], feature: best as u32 }
///     }
///     fn point(&self, feature: u32) -> Option<DVec3> {
///         Self::VERTICES.get(feature as usize).copied()
///     }
///     fn interior_point(&self) -> DVec3 {
///         DVec3::new(0.0, 0.0, 0.5)
///     }
///     fn inner_radius(&self) -> f64 {
///         0.5
///     }
///     fn outer_radius(&self) -> f64 {
///         1.5
///     }
/// }
///
/// let above = Pose::from_translation(DVec3::new(0.0, 0.0, 5.0))?;
/// let gap = hullmap::distance(&Pyramid, &Pyramid, above, &Settings::default(), &mut Cache::new());
/// assert!((gap.distance - 3.0).abs() < 1e-9);
///
/// // A manifold requires a `Shape`. It distinguishes points by their features: if all vertices had
/// // the same feature, it would merge the four corners of the base into one, and the pyramid would
/// // tip over.
/// impl Shape for Pyramid {}
/// let mut manifold = Manifold::new();
/// let floor = hullmap::shapes::Cuboid::new(DVec3::new(9.0, 9.0, 1.0))?;
/// let resting = Pose::from_translation(DVec3::Z)?;
/// manifold.update(&floor, &Pyramid, resting, &ManifoldSettings::default(), &mut Cache::new());
/// assert_eq!(manifold.points().len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
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

    /// The vertex with this index, from 0 on, if the shape is the convex hull of its vertices;
    /// `None` beyond the last one. Rays that graze are decided by them. The default is `None`: the
    /// shape is not known to be a polytope.
    #[doc(hidden)]
    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        let _ = index;
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

    /// Tells the processor to fetch what every look-up reads first. Batches call it some queries
    /// ahead.
    #[doc(hidden)]
    fn fetch_ahead(&self) {}

    /// Tells the processor to fetch a part, counted from 0, of what look-ups read. Returns whether
    /// there is another part.
    #[doc(hidden)]
    fn fetch_part(&self, part: usize) -> bool {
        let _ = part;
        false
    }

    /// Starts the look-up of [`support_point`](Self::support_point) in direction `dir`, and makes
    /// the processor fetch the memory that it reads next. Batches use it to keep several queries in
    /// flight.
    #[doc(hidden)]
    fn start_lookup(&self, dir: DVec3) -> Lookup {
        let _ = dir;
        Lookup::WHOLE
    }

    /// Continues a look-up up to the next memory that it reads.
    #[doc(hidden)]
    fn continue_lookup(&self, dir: DVec3, lookup: Lookup) -> Lookup {
        let _ = (dir, lookup);
        Lookup::WHOLE
    }

    /// The answer of [`support_point`](Self::support_point), from a look-up in the same direction
    /// that has come to a leaf, or that is whole. From any other look-up, some point of the shape.
    #[doc(hidden)]
    fn finish_lookup(&self, dir: DVec3, lookup: Lookup) -> SupportPoint {
        let _ = lookup;
        self.support_point(dir)
    }

    /// Number of bytes that support queries read over all directions; 0 if it is small.
    #[doc(hidden)]
    fn working_set_len(&self) -> usize {
        0
    }

    /// Convex radius: the shape is the Minkowski sum of its core and a ball of this radius. The
    /// default is 0: the shape is its own core.
    ///
    /// The core of a sphere is a point, and a capsule's core is a segment. Queries solve the cores,
    /// which takes a few exact steps where a curved shape would take many, and then add the radii.
    fn convex_radius(&self) -> f64 {
        0.0
    }

    /// Support point of the core in direction `dir`; by default the support point of the shape. The
    /// core has the same [`interior_point`](Self::interior_point) as the shape.
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        self.support_point(dir)
    }

    /// Radii of two balls around the interior point: one that the core contains, and one that
    /// contains the core. By default the shape's.
    fn core_radii(&self) -> [f64; 2] {
        [self.inner_radius(), self.outer_radius()]
    }

    /// The point of the core with this feature, as [`point`](Self::point) is for the shape; by
    /// default the shape's.
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        self.point(feature)
    }

    /// The point of the core with this feature that is farthest along `dir`, which is not 0, and
    /// its derivative. By default a vertex, the [`core_point`](Self::core_point). `None`: nothing
    /// is known about the feature.
    #[doc(hidden)]
    fn core_feature_point(&self, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
        let _ = dir;
        self.core_point(feature).map(FeaturePoint::vertex)
    }

    /// Whether the core is known to be a polytope: by default, whether it has a
    /// [`core_point`](Self::core_point).
    #[doc(hidden)]
    fn has_polytope_core(&self) -> bool {
        self.core_point(0).is_some()
    }

    /// The faces of a small hull or of a box, from which [`contact`](crate::contact()) computes
    /// depths faster. The default is `None`: depths come from support points.
    ///
    /// A wrapper may forward this method if it forwards all others.
    #[doc(hidden)]
    fn facets(&self) -> Option<Facets<'_>> {
        None
    }

    /// Corners of the box around the shape in its own frame, if the shape keeps it, as a hull does.
    /// The parts of compounds compare boxes before the solver runs. The default is `None`.
    #[doc(hidden)]
    fn stored_bounds(&self) -> Option<[DVec3; 2]> {
        None
    }

    /// The edges of a polytope that leave the vertex of a feature and are perpendicular to `dir`, a
    /// unit vector, up to an angle with this tangent. The default is `None`: edges are not known.
    ///
    /// A wrapper may forward this method if it forwards all others.
    #[doc(hidden)]
    fn level_edges(&self, _feature: u32, _dir: DVec3, _tangent: f64) -> Option<LevelEdges> {
        None
    }

    /// The only edge at the vertex of a feature that may be perpendicular to `dir`, as
    /// [`level_edges`](Self::level_edges) defines it, while all others certainly fall; zero if it
    /// falls, too. `None` if there are more, or if this is not known at once. The default is
    /// `None`.
    ///
    /// A wrapper may forward this method if it forwards all others.
    #[doc(hidden)]
    fn only_level_edge(&self, _feature: u32, _dir: DVec3, _tangent: f64) -> Option<DVec3> {
        None
    }

    /// Axis-aligned bounds of the shape, placed at `pose`, in the frame that the pose maps to.
    ///
    /// The box certainly contains the shape: it is larger than the tightest box by the rounding
    /// error, about 1e-14 of the shape's size and of its distance from the origin, and by
    /// [`support_error`](Self::support_error).
    ///
    /// # Complexity
    /// Six support queries. No allocation.
    fn bounds_under(&self, pose: Pose) -> Bounds {
        let (turn, shift) = (pose.rotation_matrix(), pose.translation());
        let unturn = turn.transpose();
        let extent = |axis: DVec3| (turn * self.support_point(unturn * axis).point + shift).dot(axis);
        let max = DVec3::new(extent(DVec3::X), extent(DVec3::Y), extent(DVec3::Z));
        let min = -DVec3::new(extent(DVec3::NEG_X), extent(DVec3::NEG_Y), extent(DVec3::NEG_Z));
        let l1_norm = |v: DVec3| v.abs().element_sum();
        let lengths = [l1_norm(self.interior_point()), self.outer_radius(), l1_norm(shift)];
        let rounding: f64 = BOUND_UNITS.iter().zip(lengths).map(|(units, length)| units * f64::EPSILON * length).sum();
        let margin = DVec3::splat(rounding + self.support_error());
        Bounds { min: min - margin, max: max + margin }
    }

    /// The shape that this stands for, if it stands for shapes of any kind: a program then has one
    /// instance of the solver for all of them.
    #[doc(hidden)]
    fn erased(&self) -> Option<&dyn SupportMap> {
        None
    }
}

/// Passes every method of [`SupportMap`] on to `$inner`.
macro_rules! forward_support_map {
    ($this:ident => $inner:expr) => {
        #[inline(always)]
        fn support_point(&$this, dir: DVec3) -> SupportPoint {
            $inner.support_point(dir)
        }
        #[inline(always)]
        fn interior_point(&$this) -> DVec3 {
            $inner.interior_point()
        }
        #[inline(always)]
        fn inner_radius(&$this) -> f64 {
            $inner.inner_radius()
        }
        #[inline(always)]
        fn outer_radius(&$this) -> f64 {
            $inner.outer_radius()
        }
        #[inline(always)]
        fn support_error(&$this) -> f64 {
            $inner.support_error()
        }
        #[inline(always)]
        fn point(&$this, feature: u32) -> Option<DVec3> {
            $inner.point(feature)
        }
        fn polytope_vertex(&$this, index: u32) -> Option<DVec3> {
            $inner.polytope_vertex(index)
        }
        #[inline(always)]
        fn support_point_from(&$this, dir: DVec3, hint: u32) -> SupportPoint {
            $inner.support_point_from(dir, hint)
        }
        #[inline(always)]
        fn fetch_ahead(&$this) {
            $inner.fetch_ahead();
        }
        #[inline(always)]
        fn fetch_part(&$this, part: usize) -> bool {
            $inner.fetch_part(part)
        }
        #[inline(always)]
        fn start_lookup(&$this, dir: DVec3) -> Lookup {
            $inner.start_lookup(dir)
        }
        #[inline(always)]
        fn continue_lookup(&$this, dir: DVec3, lookup: Lookup) -> Lookup {
            $inner.continue_lookup(dir, lookup)
        }
        #[inline(always)]
        fn finish_lookup(&$this, dir: DVec3, lookup: Lookup) -> SupportPoint {
            $inner.finish_lookup(dir, lookup)
        }
        #[inline(always)]
        fn working_set_len(&$this) -> usize {
            $inner.working_set_len()
        }
        #[inline(always)]
        fn convex_radius(&$this) -> f64 {
            $inner.convex_radius()
        }
        #[inline(always)]
        fn core_support_point(&$this, dir: DVec3) -> SupportPoint {
            $inner.core_support_point(dir)
        }
        #[inline(always)]
        fn core_radii(&$this) -> [f64; 2] {
            $inner.core_radii()
        }
        #[inline(always)]
        fn core_point(&$this, feature: u32) -> Option<DVec3> {
            $inner.core_point(feature)
        }
        fn core_feature_point(&$this, feature: u32, dir: DVec3) -> Option<FeaturePoint> {
            $inner.core_feature_point(feature, dir)
        }
        fn has_polytope_core(&$this) -> bool {
            $inner.has_polytope_core()
        }
        #[inline(always)]
        fn facets(&$this) -> Option<Facets<'_>> {
            $inner.facets()
        }
        fn stored_bounds(&$this) -> Option<[DVec3; 2]> {
            $inner.stored_bounds()
        }
        #[inline(always)]
        fn level_edges(&$this, feature: u32, dir: DVec3, tangent: f64) -> Option<LevelEdges> {
            $inner.level_edges(feature, dir, tangent)
        }
        fn only_level_edge(&$this, feature: u32, dir: DVec3, tangent: f64) -> Option<DVec3> {
            $inner.only_level_edge(feature, dir, tangent)
        }
        fn bounds_under(&$this, pose: Pose) -> Bounds {
            $inner.bounds_under(pose)
        }
    };
}
pub(crate) use forward_support_map;

/// A reference to a shape is the same shape.
impl<S: SupportMap + ?Sized> SupportMap for &S {
    forward_support_map!(self => (**self));

    #[inline(always)]
    fn erased(&self) -> Option<&dyn SupportMap> {
        (**self).erased()
    }
}
