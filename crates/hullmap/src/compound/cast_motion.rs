//! Time of impact of parts that move and turn: the first meeting over all pairs of parts.
//!
//! # Steps
//! 1. Visit the pairs of boxes of both trees, those that may meet first before the others. A search
//!    of few queries on the moving boxes gives a time until which they certainly do not meet. The
//!    boxes inside start at that time, and pairs that cannot meet before the first certain meeting
//!    are skipped.
//! 2. Search each pair of parts by itself, from the time of its boxes up to the first certain
//!    meeting so far.
//! 3. The first meeting has the minimum of all lower bounds and the minimum of all upper bounds.
//!
//! # Reference
//! Branch and bound, as for [`distance`](super::distance()).

use super::bvh::{BoxShape, Node, Nodes};
use super::motion::First;
use super::parts::Parts;
use super::traversal::{BoxPairs, Traversal};
use crate::continuous::cast_motion::search_pair;
use crate::continuous::search::{DIRECTIONS, Goal};
use crate::continuous::{MotionSettings, RigidMotion, TimeOfImpact};
use crate::shapes::HalfSpace;
use crate::solver::{Cache, Impact, Settings, Status};

/// Maximum number of distance queries of a pair of boxes. Boxes that take more are opened.
const BOX_QUERIES: u32 = 3;

/// Settings of these queries.
const ROUGH: Settings = Settings { tolerance: 1e-2, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

/// When `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, first meet.
///
/// # Complexity
/// Branch and bound: usually only searches for the few pairs that may meet first.
pub(crate) fn cast_motion<A: Parts + ?Sized, B: Parts + ?Sized>(
    a: &A,
    b: &B,
    motions: [&RigidMotion; 2],
    settings: &MotionSettings,
    cache: &mut Cache,
) -> TimeOfImpact {
    let origin = motions[0].start();
    let motions = motions.map(|motion| motion.relative_to(origin));
    let mut bodies = Compounds { a, b, motions, tolerance: settings.tolerance, cache, boxes: Cache::new() };
    first_meeting(&mut bodies, &mut settings.goal(motions)).relative_to(origin)
}

pub(super) trait Bodies {
    fn nodes(&self) -> [Nodes<'_>; 2];

    /// When two boxes first meet in a window of time.
    fn search_boxes(&mut self, boxes: [&Node; 2], goal: &mut Goal, window: [f64; 2]) -> TimeOfImpact;

    /// When two parts first meet in a window of time; `None` if there is no such pair.
    fn search_parts(&mut self, pair: [usize; 2], goal: &mut Goal, window: [f64; 2]) -> Option<TimeOfImpact>;
}

pub(super) struct Compounds<'q, A: ?Sized, B: ?Sized> {
    pub(super) a: &'q A,
    pub(super) b: &'q B,
    /// Relative to A's start.
    pub(super) motions: [RigidMotion; 2],
    pub(super) tolerance: f64,
    pub(super) cache: &'q mut Cache,
    pub(super) boxes: Cache,
}

impl<A: Parts + ?Sized, B: Parts + ?Sized> Bodies for Compounds<'_, A, B> {
    fn nodes(&self) -> [Nodes<'_>; 2] {
        [self.a.nodes(), self.b.nodes()]
    }

    fn search_boxes(&mut self, [a, b]: [&Node; 2], goal: &mut Goal, window: [f64; 2]) -> TimeOfImpact {
        let boxes = (&A::box_shape(*a), &B::box_shape(*b));
        search_pair(boxes, self.motions, &ROUGH, ROUGH.tolerance, goal, window, &mut self.boxes)
    }

    fn search_parts(&mut self, pair: [usize; 2], goal: &mut Goal, window: [f64; 2]) -> Option<TimeOfImpact> {
        let parts = (&self.a.part(pair[0])?, &self.b.part(pair[1])?);
        let cache = self.cache.pair(pair);
        Some(search_pair(parts, self.motions, &DIRECTIONS, self.tolerance, goal, window, cache))
    }
}

pub(super) struct PlaneAndParts<'q, B: ?Sized> {
    pub(super) plane: &'q HalfSpace,
    pub(super) b: &'q B,
    /// Relative to B's start.
    pub(super) motions: [RigidMotion; 2],
    pub(super) tolerance: f64,
}

impl<B: Parts + ?Sized> Bodies for PlaneAndParts<'_, B> {
    fn nodes(&self) -> [Nodes<'_>; 2] {
        [Nodes::one(glam::DVec3::ZERO, glam::DVec3::ZERO), self.b.nodes()]
    }

    fn search_boxes(&mut self, [_, b]: [&Node; 2], goal: &mut Goal, window: [f64; 2]) -> TimeOfImpact {
        self.plane.search(&BoxShape(*b), self.motions, ROUGH.tolerance, goal, window)
    }

    fn search_parts(&mut self, pair: [usize; 2], goal: &mut Goal, window: [f64; 2]) -> Option<TimeOfImpact> {
        Some(self.plane.search(&self.b.part(pair[1])?, self.motions, self.tolerance, goal, window))
    }
}

/// Pairs of boxes, with the time until which they certainly do not meet as their bound.
struct MovingBoxes<'q, T> {
    bodies: &'q mut T,
    goal: &'q mut Goal,
    /// The first certain meeting so far, or the end.
    until: f64,
    /// Whether both bodies are single parts, whose boxes need no search.
    is_single: bool,
    iterations: u32,
    support_calls: u32,
}

impl<T: Bodies> BoxPairs for MovingBoxes<'_, T> {
    type Placed = Node;

    fn nodes(&self) -> [Nodes<'_>; 2] {
        self.bodies.nodes()
    }

    fn placed(&self, b: &Node) -> Node {
        *b
    }

    fn bound(&mut self, a: &Node, b: &Node, outer: f64, _: f64) -> [f64; 2] {
        if self.goal.budget == 0 || self.is_single || outer > self.until {
            return [outer, 0.0];
        }
        let mut goal = self.goal.rough(BOX_QUERIES);
        let found = self.bodies.search_boxes([a, b], &mut goal, [outer, self.until]);
        self.goal.add_rough(&goal, BOX_QUERIES);
        self.iterations += found.iterations;
        self.support_calls += found.support_calls;
        // Boxes that overlap at the same time are ordered by how near they are.
        [found.t_lower.max(outer), found.point_a.distance_squared(found.point_b)]
    }
}

/// The first meeting of the parts of two bodies.
pub(super) fn first_meeting<T: Bodies>(bodies: &mut T, goal: &mut Goal) -> TimeOfImpact {
    let is_single = bodies.nodes().iter().all(|nodes| nodes.count() == 1);
    let boxes = MovingBoxes { bodies, goal, until: 1.0, is_single, iterations: 0, support_calls: 0 };
    let (mut first, mut traversal) = (First::default(), Traversal::new(boxes));
    loop {
        let until = first.certain_upper.min(1.0);
        traversal.pairs().until = until;
        // Nothing is earlier than the start.
        let Some(pair) = (if until > 0.0 { traversal.next(until) } else { None }) else { break };
        let (start, least) = (traversal.lower_bound(), traversal.least_bound());
        let MovingBoxes { bodies, goal, .. } = traversal.pairs();
        if goal.budget == 0 && first.pairs > 0 {
            // Whatever is left may meet from here on.
            let t_lower = start.min(least);
            first.add_undecided(&impact(TimeOfImpact { t: t_lower, t_lower, ..TimeOfImpact::default() }), pair);
            break;
        }
        if let Some(found) = bodies.search_parts(pair, goal, [start, until]) {
            first.add(&impact(found), pair);
        }
    }
    let boxes = traversal.boxes();
    let MovingBoxes { iterations, support_calls, .. } = *traversal.pairs();
    let mut answer = time_of_impact(first.answer());
    if first.pairs == 0 && answer.status == Status::Separated && boxes == 0 {
        // Only in a pack that was opened without checks: nothing is known.
        answer = TimeOfImpact::default();
    }
    answer.iterations = answer.iterations.saturating_add(iterations);
    answer.support_calls = answer.support_calls.saturating_add(support_calls);
    answer
}

fn impact(found: TimeOfImpact) -> Impact {
    let TimeOfImpact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls, parts } =
        found;
    Impact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls, parts }
}

fn time_of_impact(found: Impact) -> TimeOfImpact {
    let Impact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls, parts } = found;
    TimeOfImpact { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls, parts }
}
