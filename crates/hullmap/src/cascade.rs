//! Cascade of overlap tests: bounding balls, oriented bounding boxes (SAT), coarse outer hulls,
//! hulls.
//!
//! Balls, boxes and outer hulls contain their hulls, so hulls that they separate are separated.
//! Only the inner balls and the hulls themselves prove an overlap. So the answer is always the same
//! as the answer of [`intersects`](crate::intersects()).
//!
//! # Reference
//! Kenwright, section 5.0.0.1 ("a basic sphere-sphere check, followed by a cube-cube, then a
//! low-poly and finally the higher poly-mesh"). Boxes: Gottschalk, Lin, Manocha, "OBBTree", 1996.
//!
//! # Steps
//! 1. Test the balls around and inside the hulls, read from their records. No vertex is read.
//! 2. If the previous query left a separating axis in the cache, go to step 5, which tests that
//!    axis first.
//! 3. Test the bounding boxes, also read from the records, on the 15 axes that can separate two
//!    boxes (SAT).
//! 4. Test the outer hulls if they are cheaper than the hulls. An outer hull has at most 64
//!    vertices; a hull of up to 32 vertices has none and is used itself.
//! 5. Test the hulls.
//!
//! # Deviations
//! - The stages save cache misses on the index and the vertices rather than arithmetic: a support
//!   query on a large hull costs little more than on a coarse one. Decision 15 in
//!   `docs/contributors/decisions` has the measurements.

#![forbid(unsafe_code)]

use crate::hull::Hull;
use crate::pose::Pose;
use crate::solver::{Cache, Intersection, Minkowski, Overlap, queries};
use crate::support::{SupportMap, SupportPoint};
use crate::vector::unit;
use glam::{DMat3, DVec3, Vec3};

/// Minimum gap between separated boxes, relative to the largest length, in units of
/// [`f64::EPSILON`]. Two products with a matrix and sums of six terms have a rounding error of
/// about 20 units.
const ROUNDING_UNITS: f64 = 64.0;

/// Stage of the cascade that decided the query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// The bounding balls are separated, or the inner balls overlap.
    Balls,
    /// The bounding boxes are separated.
    Boxes,
    /// The coarse outer hulls are separated.
    Outer,
    /// The hulls themselves decided.
    Full,
}

/// Answer of [`intersects`](intersects()); see the example there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CascadeIntersection {
    /// The answer, with the status that [`intersects`](crate::intersects()) returns. Support calls
    /// count queries on the hulls only; iterations count those on outer hulls too.
    pub intersection: Intersection,
    /// The stage that decided.
    pub stage: Stage,
}

/// Optional stages, between the balls and the hulls. They change the cost of a query, never its
/// answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages {
    /// Test bounding boxes.
    pub boxes: bool,
    /// When to test coarse outer hulls.
    pub outer: OuterHulls,
}

/// When the cascade tests coarse outer hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OuterHulls {
    /// Never.
    Never,
    /// If support queries on the hulls take more than a thousand times as many dot products: on
    /// hulls of about 25,000 vertices or more without an index.
    WhereCheaper,
    /// If either hull has an outer hull.
    Always,
}

impl Default for Stages {
    /// Boxes, and outer hulls if they are cheaper.
    fn default() -> Self {
        Self { boxes: true, outer: OuterHulls::WhereCheaper }
    }
}

/// Minimum ratio of the dot products of a support query, hulls to outer hulls, at which outer hulls
/// pay off. Measured: hulls of about 25,000 vertices without an index reach it. Outer hulls
/// separate one in eight of the pairs that get to them, and those pairs would have cost the hulls
/// only one or two queries. For the other pairs the search is wasted.
const CHEAPER: usize = 1000;

/// Whether to test the outer hulls of this pair.
fn tests_outer(a: &Hull<'_>, b: &Hull<'_>, outer: OuterHulls) -> bool {
    let coarse = a.outer_vertices().len() + b.outer_vertices().len();
    let dots = a.worst_cost().dots as usize + b.worst_cost().dots as usize;
    coarse > 0
        && match outer {
            OuterHulls::Never => false,
            OuterHulls::WhereCheaper => dots > CHEAPER * coarse,
            OuterHulls::Always => true,
        }
}

/// Tests whether hulls `a` and `b`, placed at `b_in_a`, share a point, in stages.
///
/// The status is the same as from [`intersects`](crate::intersects()). `cache` belongs to this
/// ordered pair; the query reads and updates it.
///
/// # Complexity
/// If balls or boxes decide: no support query and a few hundred floating-point operations at most.
/// Otherwise the cost of [`intersects`](crate::intersects()), plus the same on the outer hulls, of
/// at most 64 vertices each, if they are tested. No allocation.
///
/// # Reference
/// Kenwright, section 5.0.0.1.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = pack();
/// use hullmap::cascade::{self, CascadeIntersection, OuterHulls, Stage, Stages};
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Overlap, Pose};
///
/// let rock = pack.hull(0)?;
/// let b_in_a = Pose::from_translation(DVec3::new(2.0 * rock.diameter(), 0.0, 0.0))?;
/// let stages = Stages { outer: OuterHulls::Never, ..Stages::default() };
/// let found: CascadeIntersection =
///     cascade::intersects(&rock, &rock, b_in_a, stages, &mut Cache::new());
/// assert_eq!((found.intersection.status, found.stage), (Overlap::Separated, Stage::Balls));
/// assert_eq!(found.intersection.support_calls, 0);
/// # Ok(())
/// # }
/// ```
pub fn intersects(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose, stages: Stages, cache: &mut Cache) -> CascadeIntersection {
    let decided = |status, stage| CascadeIntersection {
        intersection: Intersection { status, iterations: 0, support_calls: 0 },
        stage,
    };
    let m = Minkowski::new(a, b, b_in_a);
    if m.outer_balls_separated() {
        if let Some(axis) = unit(-m.center().w) {
            cache.set_axis(axis);
        }
        return decided(Overlap::Separated, Stage::Balls);
    }
    if m.inner_balls_overlap() {
        cache.forget_axis();
        return decided(Overlap::Overlapping, Stage::Balls);
    }
    let mut iterations = 0;
    if cache.axis().is_none() {
        if stages.boxes
            && let Some(axis) = separating_axis(&Bounds::new(a), &Bounds::new(b), b_in_a)
        {
            cache.set_axis(axis);
            return decided(Overlap::Separated, Stage::Boxes);
        }
        if tests_outer(a, b, stages.outer) {
            // The cache remains valid for the hulls: an axis that separates the outer hulls
            // separates them too, and a portal is a starting point for their search.
            let found = queries::intersects(&Outer::new(a), &Outer::new(b), b_in_a, cache);
            iterations = found.iterations;
            if found.status == Overlap::Separated {
                let support_calls = 0;
                return CascadeIntersection {
                    intersection: Intersection { support_calls, ..found },
                    stage: Stage::Outer,
                };
            }
        }
    }
    let mut intersection = queries::intersects(a, b, b_in_a, cache);
    intersection.iterations += iterations;
    CascadeIntersection { intersection, stage: Stage::Full }
}

/// A hull's bounding box in its own frame.
struct Bounds {
    center: DVec3,
    half: DVec3,
}

impl Bounds {
    fn new(hull: &Hull<'_>) -> Self {
        // Exact in f64 up to rounding in the last digit.
        let [low, high] = hull.bounds().map(Vec3::as_dvec3);
        Self { center: (low + high) * 0.5, half: (high - low) * 0.5 }
    }
}

/// Separating axis theorem (SAT) for two oriented boxes: a unit axis in A's frame, from A to B, on
/// which the gap between the boxes exceeds the rounding error.
fn separating_axis(a: &Bounds, b: &Bounds, b_in_a: Pose) -> Option<DVec3> {
    let rotation = b_in_a.rotation_matrix();
    let between = b_in_a.transform_point(b.center) - a.center;
    let largest =
        a.center.length() + b.center.length() + b_in_a.translation().length() + a.half.length() + b.half.length();
    let rounding_error = ROUNDING_UNITS * f64::EPSILON * largest;
    let abs_rotation = DMat3::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
    let directed = |axis: DVec3| if axis.dot(between) < 0.0 { -axis } else { axis };
    // Face normals of A, then of B.
    let gaps = between.abs() - a.half - abs_rotation * b.half;
    if gaps.max_element() > rounding_error {
        let axis = DVec3::AXES.into_iter().zip(gaps.to_array()).find(|(_, gap)| *gap > rounding_error)?.0;
        return Some(directed(axis));
    }
    let gaps = (rotation.transpose() * between).abs() - b.half - abs_rotation.transpose() * a.half;
    if gaps.max_element() > rounding_error {
        let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
        let axis = axes.into_iter().zip(gaps.to_array()).find(|(_, gap)| *gap > rounding_error)?.0;
        return Some(directed(axis));
    }
    // Cross products of edges. Their length is at most 1: the gap shrinks with it, the rounding
    // error does not.
    for u in DVec3::AXES {
        for v in [rotation.x_axis, rotation.y_axis, rotation.z_axis] {
            let axis = u.cross(v);
            let reach = a.half.dot(axis.abs()) + b.half.dot((rotation.transpose() * axis).abs());
            if between.dot(axis).abs() - reach > rounding_error {
                return unit(directed(axis));
            }
        }
    }
    None
}

/// The outer hull of a hull as a shape, or the hull itself if it has none.
struct Outer<'h, 'p> {
    hull: &'h Hull<'p>,
    radius: f64,
}

impl<'h, 'p> Outer<'h, 'p> {
    fn new(hull: &'h Hull<'p>) -> Self {
        let center = hull.interior_point();
        let farthest = hull.outer_vertices().map(|v| v.as_dvec3().distance_squared(center)).fold(0.0, f64::max);
        Self { hull, radius: farthest.sqrt().max(hull.outer_radius()) }
    }
}

impl SupportMap for Outer<'_, '_> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let mut best = (f64::NEG_INFINITY, None);
        for (index, vertex) in self.hull.outer_vertices().enumerate() {
            let dot = vertex.as_dvec3().dot(dir);
            if dot > best.0 {
                best = (dot, Some(SupportPoint { point: vertex.as_dvec3(), feature: index as u32 }));
            }
        }
        best.1.unwrap_or_else(|| SupportMap::support_point(self.hull, dir))
    }
    fn interior_point(&self) -> DVec3 {
        self.hull.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.hull.inner_radius()
    }
    fn outer_radius(&self) -> f64 {
        self.radius
    }
}
