//! Fans: normal cones that lie side by side around a common axis, like the pages of an open book.
//!
//! The cones around a face with many corners, along a prism's side or along the rim of a lens are
//! long and thin. Their sides lie in planes through one line. Seen along that line, each cone is an
//! interval of angles, and a row of equal steps separates all of them at once. Squares would have
//! to be as small as a cone is thin, and a tree of planes would be logarithmically deep.
//!
//! 1. [`axis`] intersects planes between neighbouring cones, and takes the line that the most of
//!    these planes contain.
//! 2. [`Fan::new`] computes the interval of angles ([`fan::angle`]) that each cone covers, as
//!    positions from 0 to 1.
//! 3. The cones are a fan if few of the intervals overlap.

use glam::DVec3;
use hullmap_format::{cube, fan};

use super::cones::{Cones, TOUCH, touch_of};

/// Maximum sine of the angle between the axis and a plane that counts as containing it. Rounding to
/// f32 tilts the plane between two vertices by 6e-8 times the hull's size over their distance:
/// about this for a face with 10,000 corners.
const NEAR_AXIS: f64 = 1e-3;

/// Minimum sine of the angle between two planes that determine the axis.
const LEAST_ANGLE: f64 = 1e-4;

/// Minimum number of planes that contain the axis.
const MIN_PLANES: usize = 6;

/// Maximum average number of overlapping intervals: one fan on either side of a prism's equator,
/// and a little more. Squares or planes cut across more layers.
const LAYERS: f64 = 2.7;

/// Number of cones sampled before a fan is built, and the factor by which the layers that they
/// predict may exceed [`LAYERS`].
const SAMPLES: usize = 32;
const LIKELY: f64 = 3.0;

/// A full turn, and half of one, in the unit of [`fan::angle`].
const TURN: f64 = fan::TURN;
const HALF_TURN: f64 = 0.5 * TURN;

/// An edge of a polygon goes through the axis if it spans half a turn, to within this tolerance.
const THROUGH_AXIS: f64 = 1e-6;

/// Maps the angles that a fan covers to positions from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Direction of angle 0: a unit vector at right angles to the axis.
    pub x: DVec3,
    /// The direction a quarter turn further.
    pub y: DVec3,
    /// Minimum angle.
    pub start: f64,
    /// Range of angles.
    pub span: f64,
}

impl Frame {
    /// Part `part` of 2^`bits` equal parts.
    pub fn part(self, part: usize, bits: u32) -> Self {
        let span = self.span / f64::from(1 << bits);
        Self { start: self.start + span * part as f64, span, ..self }
    }

    /// Normal of the plane through the axis at `position`. Greater positions lie in front of it, up
    /// to half a turn.
    pub fn plane(self, position: f64) -> DVec3 {
        let [x, y] = fan::point(self.start + self.span * position);
        (self.y * x - self.x * y).normalize()
    }
}

/// The interval of positions that one polygon covers, from `low` to `high`.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Index of the polygon.
    pub polygon: u32,
    /// Vertex of the polygon.
    pub vertex: u32,
    low: f64,
    high: f64,
}

impl Interval {
    /// Whether the interval reaches into the range from `start` to `end`.
    pub fn meets(&self, start: f64, end: f64) -> bool {
        if self.low < self.high {
            self.low < end && self.high > start
        } else {
            // Too small to reach across a boundary: it belongs to the range that contains it.
            (start..end).contains(&self.low)
        }
    }
}

/// A cell's cones, arranged side by side around an axis.
pub struct Fan {
    /// Maps angles to positions.
    pub frame: Frame,
    /// The intervals, in the order of the polygons. A polygon across the end of the turn has two.
    pub intervals: Vec<Interval>,
    /// Average number of intervals over the middle of an interval, with itself.
    pub layers: f64,
}

/// Unit direction of the line that the most planes with these normals contain; `None` if too few
/// share a line. In a tie, the line where two planes meet at the greatest angle, which is the most
/// accurate.
pub fn axis(normals: &[DVec3]) -> Option<DVec3> {
    let mut best = (MIN_PLANES - 1, 1.0, None);
    for stride in [normals.len() / 2, normals.len() / 3, normals.len() / 5 + 1] {
        for (i, &a) in normals.iter().enumerate() {
            let axis = a.cross(normals[(i + stride) % normals.len()]);
            let sine = axis.length();
            if sine < LEAST_ANGLE {
                continue;
            }
            let axis = axis / sine;
            let holds = normals.iter().filter(|n| n.dot(axis).abs() < NEAR_AXIS).count();
            if (holds, sine) > (best.0, best.1) {
                best = (holds, sine, Some(axis));
            }
        }
    }
    best.2
}

impl Fan {
    /// The cones of a cell on `face` as a fan around `axis`; `None` if they do not form a fan.
    pub fn new(face: u32, cones: &Cones, axis: DVec3) -> Option<Self> {
        let middle = cones.iter().flat_map(|(_, polygon)| polygon).map(|&p| direction(face, p)).sum::<DVec3>();
        // Place the end of the turn outside the cell, unless the cell surrounds the axis.
        let x = -(middle - axis * middle.dot(axis)).try_normalize()?;
        // If the middle lies on the axis, rounding error may have a component along it.
        let x = (x - axis * x.dot(axis)).try_normalize()?;
        let y = axis.cross(x);
        if !Self::is_likely(face, cones, x, y) {
            return None;
        }
        let mut intervals = Vec::with_capacity(cones.len());
        for (index, (vertex, polygon)) in cones.iter().enumerate() {
            let [low, high] = angles(face, polygon, x, y)?;
            let mut push = |low, high| intervals.push(Interval { polygon: index as u32, vertex, low, high });
            if high > TURN - 1.0 {
                push(low, TURN - 1.0);
                push(-1.0, high - TURN);
            } else {
                push(low, high);
            }
        }
        let start = intervals.iter().map(|i| i.low).fold(f64::INFINITY, f64::min);
        let end = intervals.iter().map(|i| i.high).fold(f64::NEG_INFINITY, f64::max);
        let frame = Frame { x, y, start: start - TOUCH, span: end - start + 2.0 * TOUCH };
        for interval in &mut intervals {
            interval.low = (interval.low - frame.start) / frame.span;
            interval.high = (interval.high - frame.start) / frame.span;
        }
        let layers = layers(&intervals);
        (frame.span.is_finite() && layers <= LAYERS).then_some(Self { frame, intervals, layers })
    }
}

impl Fan {
    /// Whether a sample of the cones is narrow enough for all cones to lie side by side. This
    /// cheap test rejects cells of compact cones.
    fn is_likely(face: u32, cones: &Cones, x: DVec3, y: DVec3) -> bool {
        let step = cones.len().div_ceil(SAMPLES);
        let (mut count, mut total) = (0, 0.0);
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for (_, polygon) in cones.iter().step_by(step) {
            let Some([low, high]) = angles(face, polygon, x, y) else { return false };
            count += 1;
            total += high - low;
            start = start.min(low);
            end = end.max(high);
        }
        total / f64::from(count) * cones.len() as f64 <= LIKELY * LAYERS * (end - start)
    }
}

/// Minimum and maximum angle over which a polygon reaches by more than [`TOUCH`] (or at all if
/// small: [`touch_of`]). The minimum is at least −1. A polygon around the axis covers the full
/// turn. `None` if an edge goes through the axis.
fn angles(face: u32, polygon: &[[f64; 2]], x: DVec3, y: DVec3) -> Option<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    // Angles along the outline, without a jump at the end of the turn.
    let (mut first, mut last) = (None, 0.0);
    let beside = |corner: &[f64; 2]| {
        let d = direction(face, *corner);
        let (x, y) = (d.dot(x), d.dot(y));
        (x, y, x.abs().max(y.abs()))
    };
    let touch = touch_of(polygon.iter().map(|corner| beside(corner).2).fold(0.0, f64::max));
    for corner in polygon {
        let (x, y, distance) = beside(corner);
        // Skip a corner so close to the axis that it reaches across no plane through it.
        if distance <= TOUCH {
            continue;
        }
        let angle = fan::angle(x, y);
        last = if first.is_none() { angle } else { last + turn(last, angle)? };
        first = first.or(Some(angle));
        low = low.min(last + touch / distance);
        high = high.max(last - touch / distance);
    }
    let Some(first) = first else { return Some([0.0; 2]) };
    if (last + turn(last, first)? - first).abs() > HALF_TURN {
        return Some([-1.0, TURN - 1.0]);
    }
    if low > high {
        // The polygon reaches across no plane: use a point.
        low = 0.5 * (low + high);
        high = low;
    }
    let turns = ((low + 1.0) / TURN).floor() * TURN;
    Some([low - turns, high - turns])
}

/// The shorter way from one angle to another; `None` if both ways are equally long.
fn turn(from: f64, to: f64) -> Option<f64> {
    let way = (to - from) - TURN * ((to - from) / TURN).round();
    (way.abs() < HALF_TURN - THROUGH_AXIS).then_some(way)
}

fn layers(intervals: &[Interval]) -> f64 {
    let sorted = |of: fn(&Interval) -> f64| {
        let mut all: Vec<f64> = intervals.iter().map(of).collect();
        all.sort_unstable_by(f64::total_cmp);
        all
    };
    let (starts, ends) = (sorted(|i| i.low), sorted(|i| i.high));
    let over = |i: &Interval| {
        let middle = 0.5 * (i.low + i.high);
        starts.partition_point(|start| *start <= middle) - ends.partition_point(|end| *end < middle)
    };
    intervals.iter().map(over).sum::<usize>() as f64 / intervals.len() as f64
}

fn direction(face: u32, p: [f64; 2]) -> DVec3 {
    DVec3::from_array(cube::direction(face, p[0], p[1]))
}

#[cfg(test)]
mod tests {
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::{
        gauss_map::GaussMap,
        index::subdivide::{Cuts, Tree, subdivide},
        test_meshes::hull_of,
    };

    /// Angles of a polygon in the face z = 1 around the z axis, which meets the face at its centre.
    fn around_z(polygon: &[[f64; 2]]) -> Option<[f64; 2]> {
        angles(4, polygon, DVec3::X, DVec3::Y)
    }

    /// The result depends neither on the first corner nor on the orientation.
    #[test]
    fn polygons_have_the_angles_that_they_reach_across() {
        let tiny = 0.1 * TOUCH;
        let bend = vec![[0.25, -0.5], [0.5, -0.25], [0.6, 0.1], [0.2, 0.0]];
        let end_of_bend = around_z(&bend).unwrap();
        for (name, polygon, expected) in [
            ("beside the axis", vec![[0.5, 0.0], [0.5, 0.25], [0.25, 0.25]], [0.0, 1.0]),
            ("a corner on the axis", vec![[0.0, 0.0], [0.5, 0.0], [0.25, 0.25]], [0.0, 1.0]),
            ("a wide angle", vec![[-0.5, 0.5], [-0.5, -0.5], [-0.25, -0.5]], [3.0, 5.5]),
            // At -45 degrees, the angles continue without a jump.
            ("across the end of the turn", vec![[0.25, -0.5], [0.5, -0.25], [0.6, 0.0]], [6.5, 8.0]),
            ("four corners across the end", bend, end_of_bend),
            ("around the axis", vec![[0.5, 0.1], [-0.3, 0.4], [-0.2, -0.6]], [-1.0, TURN - 1.0]),
            ("tiny, on the axis", vec![[tiny, 0.0], [0.0, tiny], [-tiny, -tiny]], [0.0; 2]),
            ("tiny, off the axis", vec![[0.5, 0.25], [0.5, 0.25 + tiny], [0.5 + tiny, 0.25]], [0.5; 2]),
            ("small, near the axis", vec![[1e-10, 0.0], [1e-10, 1e-10], [2e-10, 1e-10]], [0.0, 1.0]),
        ] {
            let mut polygon = polygon;
            for _ in 0..polygon.len() {
                polygon.rotate_left(1);
                let reversed: Vec<[f64; 2]> = polygon.iter().rev().copied().collect();
                for polygon in [&polygon, &reversed] {
                    let found = around_z(polygon).unwrap_or_else(|| panic!("{name}: no angles"));
                    assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-12), "{name}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn an_edge_through_the_axis_has_no_interval() {
        assert_eq!(around_z(&[[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]]), None);
        assert!(around_z(&[[0.5, 0.0], [0.0, 0.5], [-0.5, 1e-3]]).is_some());
    }

    #[test]
    fn frames_and_angles_agree() {
        let mut rng = SplitMix64::new(3);
        for _ in 0..1_000 {
            let x = DVec3::from_array(rng.direction());
            let y = x.cross(DVec3::from_array(rng.direction())).normalize();
            // A full turn starts at −1 and ends at 7, to within a tolerance on either side.
            let full = Frame { x, y, start: -1.0 - TOUCH, span: TURN + 2.0 * TOUCH };
            let some = Frame { x, y, start: rng.between(-1.0, 3.0), span: rng.between(0.1, 3.9) };
            let (frame, position) = match rng.below(4) {
                0 => (full, [0.0, 1.0, rng.unit()][rng.below(3)]),
                _ => (some, rng.unit()),
            };
            let distance = rng.unit();
            let normal = frame.plane(position);
            assert!((normal.length() - 1.0).abs() < 1e-15 && normal.dot(x.cross(y)).abs() < 1e-15);
            let on = x.cross(y) * rng.between(-1.0, 1.0) + normal.cross(x.cross(y)) * distance;
            let angle = fan::angle(on.dot(x), on.dot(y));
            let turned = angle - frame.start - frame.span * position;
            let off = turned - TURN * (turned / TURN).round();
            assert!(off.abs() < 1e-12 / distance, "{frame:?} {position}");
            let beyond = on + normal * 0.1 * distance;
            assert!(fan::angle(beyond.dot(x), beyond.dot(y)) > angle || angle > 6.0);
            let part = frame.part(3, 2);
            assert_eq!((part.start, part.span), (frame.start + frame.span * 0.75, frame.span / 4.0));
        }
    }

    #[test]
    fn steps_list_the_intervals_that_meet_them() {
        let interval = |low, high| Interval { polygon: 0, vertex: 0, low, high };
        let i = interval(0.25, 0.5);
        assert!(i.meets(0.0, 0.3) && i.meets(0.3, 0.4) && i.meets(0.45, 1.0));
        assert!(!i.meets(0.0, 0.25) && !i.meets(0.5, 1.0), "touching is not reaching");
        let point = interval(0.5, 0.5);
        assert!(point.meets(0.5, 1.0) && !point.meets(0.0, 0.5));
    }

    fn trees(positions: Vec<[f32; 3]>) -> Vec<Tree> {
        let map = GaussMap::new(&hull_of(positions));
        (0..6).map(|face| subdivide(&map, face, 6, Cuts::FansAndPlanes)).collect()
    }

    fn count(tree: &Tree, is_one: &impl Fn(&Tree) -> bool) -> usize {
        let below = match tree {
            Tree::Leaf(_) => 0,
            Tree::Axis(halves) | Tree::Plane(_, halves) | Tree::Wedges(halves) => {
                halves.iter().map(|half| count(half, is_one)).sum()
            }
            Tree::Fan(_, root) => count(root, is_one),
        };
        below + usize::from(is_one(tree))
    }

    #[test]
    fn a_prism_is_one_fan_per_face() {
        for (face, tree) in trees(families::prism(2_000, 0)).iter().enumerate() {
            assert!(matches!(tree, Tree::Fan(..)), "face {face}");
            assert_eq!(count(tree, &|tree| matches!(tree, Tree::Plane(..) | Tree::Axis(_))), 0, "face {face}");
            let Tree::Fan(frame, _) = tree else { continue };
            assert!(frame.x.cross(frame.y).z.abs() > 1.0 - 1e-12, "around z");
            // A full turn on the caps, a quarter turn on the sides.
            let expected = if face >= 4 { TURN } else { 2.0 };
            assert!((frame.span - expected).abs() < 1e-2, "face {face}: {}", frame.span);
        }
    }

    #[test]
    fn a_sphere_has_no_fans() {
        let trees = trees(families::sphere(2_000, 1));
        let fans: usize = trees.iter().map(|tree| count(tree, &|tree| matches!(tree, Tree::Fan(..)))).sum();
        assert_eq!(fans, 0);
    }
}
