//! Yes or no by levels of detail: balls, then boxes, then coarse outer hulls, then the hulls.
//!
//! Each level holds the next, so that what one proves apart is apart. A level never says yes but for the balls inside the
//! hulls, so the answer is always that of [`intersects`](crate::intersects()).
//!
//! # Reference
//! Kenwright, section 5.0.0.1 ("a basic sphere-sphere check, followed by a cube-cube, then a low-poly and finally the higher
//! poly-mesh"). Boxes: Gottschalk, Lin, Manocha, "OBBTree", 1996.
//!
//! # Steps
//! 1. balls around and inside the hulls, from their records: no vertex is read;
//! 2. a pair that was apart last time goes on to step 5, which begins with the axis that separated it;
//! 3. bounding boxes in the hulls' own frames, by the 15 axes on which boxes can be separated: from the records too;
//! 4. outer hulls of at most 64 vertices (a hull of up to 32 vertices is its own), where they are cheaper than the hulls;
//! 5. the hulls.
//!
//! # Deviations
//! - Levels save reading the index and the vertices, not counting them: a support query of a large hull costs hardly more than
//!   that of a coarse one. What they are worth is told in `docs/ARCHITECTURE.md`.

#![forbid(unsafe_code)]

use crate::minkowski::{Minkowski, unit};
use crate::{Cache, Hull, Intersection, Overlap, Pose, Support, SupportMap, intersects as intersects_full};
use glam::{DMat3, DVec3, Vec3};

/// Gaps of boxes up to this many units of rounding of the greatest length are none: two products with a matrix and the sums
/// of six terms come to about 20.
const ROUNDING_UNITS: f64 = 64.0;

/// Which level gave the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// The balls around the hulls are apart, or those inside them overlap.
    Balls,
    /// The bounding boxes are apart.
    Boxes,
    /// The coarse outer hulls are apart.
    Outer,
    /// The hulls themselves were asked.
    Full,
}

/// Answer of [`intersects`](intersects()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leveled {
    /// As [`intersects`](crate::intersects()) gives it. Support calls are those of the hulls alone, iterations those of outer hulls
    /// and hulls.
    pub intersection: Intersection,
    /// Which level gave it.
    pub level: Level,
}

/// Which levels are asked between balls and hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Bounding boxes.
    pub boxes: bool,
    /// Coarse outer hulls.
    pub outer: OuterHulls,
}

/// When coarse outer hulls are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OuterHulls {
    /// Not at all.
    Never,
    /// Where support queries of the hulls take a thousand times as many dot products: on hulls of some 25,000 vertices without
    /// an index.
    WhereCheaper,
    /// Wherever there are any.
    Always,
}

impl Default for Levels {
    /// Boxes, and outer hulls where they are cheaper.
    fn default() -> Self {
        Self { boxes: true, outer: OuterHulls::WhereCheaper }
    }
}

/// Outer hulls are cheaper where the hulls' queries take this many times as many dot products, by measurement: hulls of some
/// 25,000 vertices without an index. They separate one pair in eight of those that come to them, and only such as cost the hulls
/// one or two queries; their own search is lost on the others.
const CHEAPER: usize = 1000;

/// Whether outer hulls are asked of this pair.
fn asks_outer(a: &Hull<'_>, b: &Hull<'_>, outer: OuterHulls) -> bool {
    let coarse = a.outer_vertices().len() + b.outer_vertices().len();
    let dots = a.worst_cost().dots as usize + b.worst_cost().dots as usize;
    coarse > 0
        && match outer {
            OuterHulls::Never => false,
            OuterHulls::WhereCheaper => dots > CHEAPER * coarse,
            OuterHulls::Always => true,
        }
}

/// Whether hulls `a` and `b`, placed at `b_in_a`, share a point: the answer of [`intersects`](crate::intersects()), by way of
/// `levels`.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date.
///
/// # Complexity
/// No support call where balls or boxes decide, at most some hundred floating-point operations; else that of
/// [`intersects`](crate::intersects()), and with outer hulls once more on at most 64 vertices each. No allocation.
///
/// # Reference
/// Kenwright, section 5.0.0.1.
pub fn intersects(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose, levels: Levels, cache: &mut Cache) -> Leveled {
    let decided =
        |status, level| Leveled { intersection: Intersection { status, iterations: 0, support_calls: 0 }, level };
    let m = Minkowski::new(a, b, b_in_a);
    if m.outer_balls_apart() {
        if let Some(axis) = unit(-m.center().w) {
            cache.set_axis(axis);
        }
        return decided(Overlap::Separated, Level::Balls);
    }
    if m.inner_balls_overlap() {
        cache.forget_axis();
        return decided(Overlap::Overlapping, Level::Balls);
    }
    let mut iterations = 0;
    if cache.axis().is_none() {
        if levels.boxes
            && let Some(axis) = separating_axis(&Bounds::new(a), &Bounds::new(b), b_in_a)
        {
            cache.set_axis(axis);
            return decided(Overlap::Separated, Level::Boxes);
        }
        if asks_outer(a, b, levels.outer) {
            // An axis that separates the outer hulls separates the hulls, and a portal is a place to start from.
            let found = intersects_full(&Outer::new(a), &Outer::new(b), b_in_a, cache);
            iterations = found.iterations;
            if found.status == Overlap::Separated {
                let support_calls = 0;
                return Leveled { intersection: Intersection { support_calls, ..found }, level: Level::Outer };
            }
        }
    }
    let mut intersection = intersects_full(a, b, b_in_a, cache);
    intersection.iterations += iterations;
    Leveled { intersection, level: Level::Full }
}

/// A hull's bounding box in its own frame.
struct Bounds {
    center: DVec3,
    half: DVec3,
}

impl Bounds {
    fn new(hull: &Hull<'_>) -> Self {
        // Exact in f64, but for the last digit of a half.
        let [low, high] = hull.bounds().map(Vec3::as_dvec3);
        Self { center: (low + high) * 0.5, half: (high - low) * 0.5 }
    }
}

/// An axis, of unit length in A's frame from A to B, on which the boxes are apart by more than rounding.
fn separating_axis(a: &Bounds, b: &Bounds, b_in_a: Pose) -> Option<DVec3> {
    let turn = b_in_a.rotation_matrix();
    let between = b_in_a.transform_point(b.center) - a.center;
    let greatest =
        a.center.length() + b.center.length() + b_in_a.translation().length() + a.half.length() + b.half.length();
    let rounding = ROUNDING_UNITS * f64::EPSILON * greatest;
    let size = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
    let directed = |axis: DVec3| if axis.dot(between) < 0.0 { -axis } else { axis };
    // A's faces, then B's.
    let gaps = between.abs() - a.half - size * b.half;
    if gaps.max_element() > rounding {
        let axis = DVec3::AXES.into_iter().zip(gaps.to_array()).find(|(_, gap)| *gap > rounding)?.0;
        return Some(directed(axis));
    }
    let gaps = (turn.transpose() * between).abs() - b.half - size.transpose() * a.half;
    if gaps.max_element() > rounding {
        let axes = [turn.x_axis, turn.y_axis, turn.z_axis];
        let axis = axes.into_iter().zip(gaps.to_array()).find(|(_, gap)| *gap > rounding)?.0;
        return Some(directed(axis));
    }
    // Edges: cross products of length up to 1, whose gaps shrink with them and their rounding does not.
    for u in DVec3::AXES {
        for v in [turn.x_axis, turn.y_axis, turn.z_axis] {
            let axis = u.cross(v);
            let reach = a.half.dot(axis.abs()) + b.half.dot((turn.transpose() * axis).abs());
            if between.dot(axis).abs() - reach > rounding {
                return unit(directed(axis));
            }
        }
    }
    None
}

/// The coarse polytope around a hull, as a shape; the hull's own vertices where it has none.
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
    fn support(&self, dir: DVec3) -> Support {
        let mut best = (f64::NEG_INFINITY, None);
        for (number, vertex) in self.hull.outer_vertices().enumerate() {
            let height = vertex.as_dvec3().dot(dir);
            if height > best.0 {
                best = (height, Some(Support { point: vertex.as_dvec3(), feature: number as u32 }));
            }
        }
        best.1.unwrap_or_else(|| SupportMap::support(self.hull, dir))
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
