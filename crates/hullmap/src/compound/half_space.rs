//! Queries of a half-space and parts, by descent of one BVH. A single shape needs no BVH.
//!
//! The lowest part decides all queries except casts: a cast along a translation tries
//! each part, and a cast with rotation searches the parts like two compounds.

use super::ContactCounts;
use super::bvh::{Child, Nodes};
use super::cast_motion::{PlaneAndParts, first_meeting};
use super::motion::First;
use super::parts::Parts;
use crate::continuous::clear::judge;
use crate::continuous::{ClearSettings, Clearance, MotionSettings, RigidMotion, TimeOfImpact};
use crate::pose::Pose;
use crate::shapes::HalfSpace;
use crate::shapes::half_space::Lowest;
use crate::solver::{CastSettings, Contact, Impact, Motion};
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

#[inline]
fn only_part<B: Parts + ?Sized>(b: &B) -> Option<B::Part<'_>> {
    if b.part_count() == 1 { b.part(0) } else { None }
}

/// Finds the part of `b` that reaches farthest below the plane, by branch and bound.
///
/// # Complexity
/// One support query for each part whose box reaches deeper than the deepest part so far. Usually
/// these are one or two parts.
#[inline]
pub(crate) fn lowest<B: Parts + ?Sized>(a: &HalfSpace, b: &B, b_in_a: Pose) -> Lowest {
    if let Some(part) = only_part(b) {
        return a.lowest(&part, b_in_a);
    }
    let mut best = Lowest::NONE;
    let mut descent = Descent::new(a, b.nodes(), b_in_a);
    while let Some(index) = descent.next(best.depth) {
        let Some(part) = b.part(index) else { continue };
        let found = a.lowest(&part, b_in_a).of_part(index);
        let queried = best.support_calls + 1;
        // Ties go to the lowest index, so that the answer does not depend on the shape of the BVH.
        // NaN is deeper than everything, because then nothing is known.
        let is_lower = !(found.depth <= best.depth) || found.depth == best.depth && found.part < best.part;
        best = if is_lower { best.wider(found) } else { found.wider(best) };
        best.support_calls = queried;
        if best.depth.is_nan() {
            break;
        }
    }
    best
}

/// Calls `visit` with the contact of every part of `b` that is not proved separated.
pub(crate) fn contacts<B: Parts + ?Sized>(
    a: &HalfSpace,
    b: &B,
    b_in_a: Pose,
    visit: &mut dyn FnMut(&Contact),
) -> ContactCounts {
    let (mut counts, mut descent) = (ContactCounts::default(), Descent::new(a, b.nodes(), b_in_a));
    while let Some(index) = descent.next(0.0) {
        let Some(part) = b.part(index) else { continue };
        counts.visit(a.lowest(&part, b_in_a).of_part(index).contact(), visit);
    }
    counts.boxes = descent.boxes();
    counts
}

/// When `b`, which starts at `b_in_a` and translates by `motion`, first meets the half-space.
///
/// # Complexity
/// One closed form and one support query for each part.
#[inline]
pub(crate) fn cast<B: Parts + ?Sized>(
    a: &HalfSpace,
    b: &B,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
) -> Impact {
    if let Some(part) = only_part(b) {
        return a.lowest(&part, b_in_a).impact(motion, settings);
    }
    let mut first = First::default();
    for index in 0..b.part_count() {
        if let Some(part) = b.part(index) {
            first.add(&a.lowest(&part, b_in_a).impact(motion, settings), [0, index]);
        }
    }
    if first.pairs > 0 { first.answer() } else { Impact::default() }
}

/// When `b`, which moves by `motion_b`, first meets the half-space, which moves by `motion_a`.
///
/// # Complexity
/// Branch and bound: a search for each part that may reach the plane first.
pub(crate) fn cast_motion<B: Parts + ?Sized>(
    a: &HalfSpace,
    b: &B,
    [motion_a, motion_b]: [&RigidMotion; 2],
    settings: &MotionSettings,
) -> TimeOfImpact {
    let origin = motion_b.start();
    let motions = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let (tolerance, goal) = (settings.tolerance, &mut settings.goal(motions));
    let found = match only_part(b) {
        Some(part) => a.search(&part, motions, tolerance, goal, [0.0, 1.0]),
        None => first_meeting(&mut PlaneAndParts { plane: a, b, motions, tolerance }, goal),
    };
    found.relative_to(origin)
}

/// Whether `b`, which moves by `motion_b`, stays farther than a margin from the half-space, which
/// moves by `motion_a`, and the least distance that is proven.
pub(crate) fn clear<B: Parts + ?Sized>(
    a: &HalfSpace,
    b: &B,
    [motion_a, motion_b]: [&RigidMotion; 2],
    settings: &ClearSettings,
) -> Clearance {
    let origin = motion_b.start();
    let motions = [motion_a, motion_b].map(|motion| motion.relative_to(origin));
    let tolerance = settings.motion.tolerance;
    judge(settings, motions, |goal| match only_part(b) {
        Some(part) => a.search(&part, motions, tolerance, goal, [0.0, 1.0]),
        None => first_meeting(&mut PlaneAndParts { plane: a, b, motions, tolerance }, goal),
    })
}
