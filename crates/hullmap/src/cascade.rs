//! Cascade of overlap tests for two parts: bounding balls, oriented bounding boxes (SAT), hulls.
//!
//! Balls and boxes contain their hulls, so hulls that they separate are separated. Only the inner
//! balls and the hulls themselves prove an overlap. So the status is always the status
//! of [`intersects`](crate::intersects()).
//!
//! # Reference
//! Kenwright, section 5.0.0.1 ("a basic sphere-sphere check, followed by a cube-cube, then a
//! low-poly and finally the higher poly-mesh"). Boxes: Gottschalk, Lin, Manocha, "OBBTree", 1996.
//!
//! # Steps
//! 1. Test the balls around and inside the hulls, read from their records. No vertex is read.
//! 2. If the previous query left a separating axis in the cache, go to step 4, which tests that
//!    axis first.
//! 3. Test the bounding boxes, also read from the records, on the 15 axes that can separate two
//!    boxes (SAT).
//! 4. Test the hulls.
//!
//! # Deviations
//! - There is no low-poly stage: the pairs that it could decide take one or two support queries,
//!   which take the same time on the hull. Decision 15 in `docs/contributors/decisions` has the
//!   measurements.

#![forbid(unsafe_code)]

use crate::pose::Pose;
use crate::solver::{Cache, Intersection, Minkowski, Overlap, queries};
use crate::support::SupportMap;
use crate::vector::unit;
use glam::{DMat3, DVec3};

/// Minimum gap between separated boxes, relative to the largest length, in units of
/// [`f64::EPSILON`]. Two products with a matrix and sums of six terms have a rounding error of
/// about 20 units.
const ROUNDING_UNITS: f64 = 64.0;

/// Tests whether `a` and `b`, placed at `b_in_a`, share a point, in stages if both have stored
/// boxes.
///
/// # Complexity
/// If balls or boxes decide: no support query and a few hundred floating-point operations at most.
pub(crate) fn intersects<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    let (Some(box_a), Some(box_b)) = (a.stored_bounds(), b.stored_bounds()) else {
        return queries::intersects(a, b, b_in_a, cache);
    };
    let decided = |status| Intersection { status, ..Intersection::default() };
    let m = Minkowski::new(a, b, b_in_a);
    if m.outer_balls_separated() {
        if let Some(axis) = unit(-m.center().w) {
            cache.set_axis(axis);
        }
        return decided(Overlap::Separated);
    }
    if m.inner_balls_overlap() {
        cache.forget_axis();
        return decided(Overlap::Overlapping);
    }
    if cache.axis().is_none()
        && let Some(axis) = separating_axis(&CenteredBox::new(box_a), &CenteredBox::new(box_b), b_in_a)
    {
        cache.set_axis(axis);
        return decided(Overlap::Separated);
    }
    queries::intersects(a, b, b_in_a, cache)
}

/// A hull's bounding box in its own frame.
struct CenteredBox {
    center: DVec3,
    half: DVec3,
}

impl CenteredBox {
    fn new([low, high]: [DVec3; 2]) -> Self {
        // Exact in f64 up to rounding in the last digit.
        Self { center: (low + high) * 0.5, half: (high - low) * 0.5 }
    }
}

/// Separating axis theorem (SAT) for two oriented boxes: a unit axis in A's frame, from A to B, on
/// which the gap between the boxes exceeds the rounding error.
fn separating_axis(a: &CenteredBox, b: &CenteredBox, b_in_a: Pose) -> Option<DVec3> {
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
