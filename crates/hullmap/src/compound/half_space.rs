//! Queries of a half-space and a compound, by descent of one BVH.
//!
//! The lowest part of a compound decides all queries except casts: a cast along a translation tries
//! each part, and a cast with rotation searches the parts like two compounds.

use super::CompoundAnswer;
use super::bvh::{Child, Nodes};
use super::cast_motion::{PlaneAndParts, first_meeting};
use super::clear::judge_bodies;
use super::motion::First;
use super::parts::Parts;
use crate::continuous::{ClearSettings, Clearance, MotionSettings, RigidMotion, TimeOfImpact};
use crate::pose::Pose;
use crate::shapes::HalfSpace;
use crate::shapes::half_space::Lowest;
use crate::solver::{CastSettings, Contact, Distance, Impact, Intersection, Motion};
use arrayvec::ArrayVec;
use glam::DVec3;
use hullmap_format::bvh::MAX_LEVELS;

/// Maximum number of nodes on the stack: one for each level, plus one.
const MAX_STACK: usize = MAX_LEVELS as usize + 1;

/// Rounding error of the depth of a box, relative to the largest length, in units of
/// [`f64::EPSILON`]. The same as for a distance between boxes.
const ROUNDING_UNITS: f64 = 128.0;

/// Iterates over the parts whose boxes reach below a plane by some depth, deepest boxes first.
pub(super) struct Descent<'q> {
    nodes: Nodes<'q>,
    /// The plane in the frame of the compound: its normal and its offset.
    normal: DVec3,
    offset: f64,
    rounding_error: f64,
    stack: ArrayVec<(u32, f64), MAX_STACK>,
    boxes: u32,
}

impl<'q> Descent<'q> {
    pub(super) fn new(a: &HalfSpace, nodes: Nodes<'q>, b_in_a: Pose) -> Self {
        let normal = b_in_a.inverse_transform_vector(a.normal());
        let offset = a.offset() - a.normal().dot(b_in_a.translation());
        let farthest = nodes.get(0).map_or(0.0, |root| {
            DVec3::AXES.map(|axis| root.extent(axis)).into_iter().flatten().map(f64::abs).sum::<f64>()
        });
        let largest = farthest + a.offset().abs() + b_in_a.translation().length();
        let rounding_error = ROUNDING_UNITS * f64::EPSILON * largest;
        let stack = [(0, f64::INFINITY)].into_iter().collect();
        Self { nodes, normal, offset, rounding_error, stack, boxes: 0 }
    }

    /// Number of boxes compared so far.
    pub(super) fn boxes(&self) -> u32 {
        self.boxes
    }

    /// The next part whose box reaches at least `depth` below the plane, by index. Negative depths
    /// are above it.
    pub(super) fn next(&mut self, depth: f64) -> Option<usize> {
        while let Some((index, upper_bound)) = self.stack.pop() {
            // Written so that a NaN would not skip the node.
            if upper_bound < depth {
                continue;
            }
            let first = match self.nodes.get(index)?.child {
                Child::Hull(hull) => return Some(hull),
                Child::Nothing => continue,
                // Children follow their parents, except in a damaged pack that was opened
                // unchecked. The descent must end there as well.
                Child::Nodes(first) if first > index => first,
                Child::Nodes(_) => return None,
            };
            let second = first.saturating_add(1);
            let bounds = [self.upper_bound(first)?, self.upper_bound(second)?];
            let children = [(first, bounds[0]), (second, bounds[1])];
            for child in if bounds[0] < bounds[1] { children } else { [children[1], children[0]] } {
                if !(child.1 < depth) {
                    let _ = self.stack.try_push(child);
                }
            }
        }
        None
    }

    /// Upper bound on the depth of the parts below a node. `None` if the node is missing, or if all
    /// nodes have been compared: a longer descent is in a cycle.
    fn upper_bound(&mut self, index: u32) -> Option<f64> {
        let node = self.nodes.get(index).filter(|_| (self.boxes as usize) < self.nodes.count())?;
        self.boxes += 1;
        let depth = self.offset - node.extent(self.normal)[0] + self.rounding_error;
        Some(if node.child == Child::Nothing { f64::NEG_INFINITY } else { depth })
    }
}

/// Finds the part of `b` that reaches farthest below the plane, by branch and bound.
fn lowest<B: Parts + ?Sized>(a: &HalfSpace, b: &B, b_in_a: Pose) -> CompoundAnswer<Lowest> {
    let mut best = CompoundAnswer { answer: Lowest::NONE, hulls: [0, 0], pairs: 0, boxes: 0 };
    let mut descent = Descent::new(a, b.nodes(), b_in_a);
    while let Some(index) = descent.next(best.answer.depth) {
        let Some(part) = b.part(index) else { continue };
        let found = a.lowest(&part, b_in_a);
        best.pairs += 1;
        let (depth, deepest) = (found.depth, best.answer.depth);
        // Ties go to the lowest index, so that the answer does not depend on the shape of the BVH.
        // NaN is deeper than everything, because then nothing is known.
        if !(depth <= deepest) || depth == deepest && index < best.hulls[1] {
            best.hulls = [0, index];
            best.answer = best.answer.wider(found);
        } else {
            best.answer = found.wider(best.answer);
        }
        if best.answer.depth.is_nan() {
            break;
        }
    }
    best.answer.support_calls = best.pairs;
    best.boxes = descent.boxes();
    best
}

/// Contact of the half-space with the part of `b`, placed at `b_in_a`, that reaches farthest into
/// it. If no part reaches into it, `hit` is false.
///
/// Points and normal are in the frame of the half-space. Moving B by the depth along the normal
/// separates all parts.
///
/// # Complexity
/// Branch and bound: one support query for each part whose box reaches deeper than the deepest part
/// so far. Usually these are one or two parts; at most, all parts. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{Compound, Pose};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. The wall is at x = 5.
/// let wall = HalfSpace::new(DVec3::NEG_X, -5.0)?;
/// let cubes = Compound::new(&pack);
/// let found = half_space::contact(&wall, &cubes, Pose::from_translation(DVec3::X * 1.5)?);
/// assert_eq!((found.answer.depth, found.hulls), (0.5, [0, 1]));
/// # Ok(())
/// # }
/// ```
pub fn contact<B: Parts + ?Sized>(a: &HalfSpace, b: &B, b_in_a: Pose) -> CompoundAnswer<Contact> {
    let CompoundAnswer { answer, hulls, pairs, boxes } = lowest(a, b, b_in_a);
    CompoundAnswer { answer: answer.contact(), hulls, pairs, boxes }
}

/// Distance between the half-space and `b`, placed at `b_in_a`; 0 if they overlap or touch.
///
/// # Complexity
/// As [`contact`](contact()).
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{Compound, Pose};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. The wall is at x = -2.
/// let wall = HalfSpace::new(DVec3::X, -2.0)?;
/// let gap = half_space::distance(&wall, &Compound::new(&pack), Pose::IDENTITY);
/// assert_eq!((gap.answer.distance, gap.hulls), (2.0, [0, 0]));
/// # Ok(())
/// # }
/// ```
pub fn distance<B: Parts + ?Sized>(a: &HalfSpace, b: &B, b_in_a: Pose) -> CompoundAnswer<Distance> {
    let CompoundAnswer { answer, hulls, pairs, boxes } = lowest(a, b, b_in_a);
    CompoundAnswer { answer: answer.distance(), hulls, pairs, boxes }
}

/// Whether the half-space and `b`, placed at `b_in_a`, share a point.
///
/// # Complexity
/// As [`contact`](contact()).
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{Compound, Pose};
///
/// let floor = HalfSpace::new(DVec3::Z, 0.0)?;
/// let above = Pose::from_translation(DVec3::Z)?;
/// assert!(!half_space::intersects(&floor, &Compound::new(&pack), above).answer.is_hit());
/// # Ok(())
/// # }
/// ```
pub fn intersects<B: Parts + ?Sized>(a: &HalfSpace, b: &B, b_in_a: Pose) -> CompoundAnswer<Intersection> {
    let CompoundAnswer { answer, hulls, pairs, boxes } = lowest(a, b, b_in_a);
    CompoundAnswer { answer: answer.intersection(), hulls, pairs, boxes }
}

/// When `b`, which starts at `b_in_a` and translates by `motion`, first meets the half-space.
///
/// Points and normal are in the frame of the half-space.
///
/// # Complexity
/// One closed form and one support query for each part. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{CastSettings, Compound, Motion, Pose};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. The wall is at x = 6.
/// let (wall, cubes) = (HalfSpace::new(DVec3::NEG_X, -6.0)?, Compound::new(&pack));
/// let right = Motion::new(DVec3::X)?;
/// let impact = half_space::cast(&wall, &cubes, Pose::IDENTITY, right, &CastSettings::default());
/// assert_eq!(impact.hulls, [0, 1]);
/// assert!(impact.answer.hit && (impact.answer.t - 2.0).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub fn cast<B: Parts + ?Sized>(
    a: &HalfSpace,
    b: &B,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
) -> CompoundAnswer<Impact> {
    let mut first = First::default();
    for index in 0..b.part_count() {
        if let Some(part) = b.part(index) {
            first.add(&a.cast(&part, b_in_a, motion, settings), [0, index]);
        }
    }
    let is_known = first.pairs > 0;
    let (answer, hulls) = first.answer();
    let answer = if is_known { answer } else { Impact::default() };
    CompoundAnswer { answer, hulls, pairs: first.pairs, boxes: 0 }
}

/// When `b`, which moves by `motion_b`, first meets the half-space, which moves by `motion_a`.
///
/// As [`compound::cast_motion`](super::cast_motion()). The normal is always the plane's, and points
/// and normal are in the common frame of the motions.
///
/// # Complexity
/// Branch and bound: a search for each part that may reach the plane first. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{Compound, MotionSettings, Pose, RigidMotion};
/// use std::f64::consts::FRAC_PI_2;
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4. They turn towards the wall at y = 3.
/// let (wall, cubes) = (HalfSpace::new(DVec3::NEG_Y, -3.0)?, Compound::new(&pack));
/// let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Z * FRAC_PI_2, DVec3::ZERO)?;
/// let resting = RigidMotion::still(Pose::IDENTITY);
/// let found = half_space::cast_motion(&wall, &resting, &cubes, &turning, &MotionSettings::default());
/// // The corner at (4, 1).
/// let angle = (3.0 / 17.0_f64.sqrt()).asin() - 0.25_f64.atan();
/// assert_eq!(found.hulls, [0, 1]);
/// assert!(found.answer.hit && (found.answer.t - angle / FRAC_PI_2).abs() < 1e-5);
/// # Ok(())
/// # }
/// ```
pub fn cast_motion<B: Parts + ?Sized>(
    a: &HalfSpace,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &MotionSettings,
) -> CompoundAnswer<TimeOfImpact> {
    let origin = motion_b.start();
    let motions = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let mut bodies = PlaneAndParts { plane: a, b, motions, tolerance: settings.tolerance };
    let found = first_meeting(&mut bodies, &mut settings.goal(motions));
    CompoundAnswer { answer: found.answer.relative_to(origin), ..found }
}

/// Whether `b`, which moves by `motion_b`, stays farther than a margin from the half-space, which
/// moves by `motion_a`, and the least distance that is proven.
///
/// As [`compound::clear`](super::clear()). If the motion hits, `hulls` is `[0, i]` for the part i
/// that meets the half-space first.
///
/// # Complexity
/// The same as for [`cast_motion`]; twice as much for a free motion if
/// [`share`](ClearSettings::share) is not 0. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::half_space;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::HalfSpace;
/// use hullmap::{ClearSettings, Compound, Pose, RigidMotion, Verdict};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4, that move along the wall at y = 3.
/// let (wall, cubes) = (HalfSpace::new(DVec3::NEG_Y, -3.0)?, Compound::new(&pack));
/// let along = RigidMotion::between(Pose::IDENTITY, Pose::from_translation(DVec3::X * 9.0)?)?;
/// let resting = RigidMotion::still(Pose::IDENTITY);
/// let found = half_space::clear(&wall, &resting, &cubes, &along, &ClearSettings::default()).answer;
/// assert_eq!(found.verdict, Verdict::Free);
/// assert!(1.0 <= found.clearance && found.clearance <= 2.0);
/// # Ok(())
/// # }
/// ```
pub fn clear<B: Parts + ?Sized>(
    a: &HalfSpace,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &ClearSettings,
) -> CompoundAnswer<Clearance> {
    let origin = motion_b.start();
    let motions = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let mut bodies = PlaneAndParts { plane: a, b, motions, tolerance: settings.motion.tolerance };
    judge_bodies(&mut bodies, motions, settings)
}
