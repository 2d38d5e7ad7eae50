//! Conservative advancement: how far two moving shapes surely stay apart along a direction.
//!
//! # Reference
//! Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, for the principle.
//! The bounds below are our own; docs/intervals.md, section 15, proves them.
//!
//! # The bounds
//! The *separation* along a unit direction n is the gap between the planes perpendicular to n
//! through the support points of both shapes. It is computed at the two ends of an interval of
//! time. In between it is at least the lower of the two, less a *bulge*, which falls with the
//! square of the interval.
//!
//! - n is fixed in space: each shape that turns adds a bulge. For an angle φ it is (1/cos(φ/2) − 1)
//!   times the extent of the shape, from the point about which it turns, in the direction of n in
//!   the plane of rotation. So translations cost nothing, and neither does the length of a shape
//!   along its axis.
//! - n turns with one of the shapes, as the normal of its face does. Then the extent is that of the
//!   other shape on the far side of the point about which the first one turns, and mostly 0. Motion
//!   of the other shape adds a *drift*.

use glam::DVec3;

use super::rigid_motion::RigidMotion;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Maximum angle in radians of one interval of time.
const MAX_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Angle of the longest step: less than [`MAX_TURN`] by more than rounding errors.
const LONGEST_TURN: f64 = 0.999 * MAX_TURN;

/// Rounding error of a separation and of the bulge, in units of `f64::EPSILON` times the lengths
/// from which they are computed: docs/intervals.md, section 15, derives 137. Each radian of the
/// motion adds [`TURN_ROUNDINGS`].
const ROUNDINGS: f64 = 160.0;

/// Rounding error for each radian of the motion, in the same unit. The section derives 0.71.
const TURN_ROUNDINGS: f64 = 1.0;

/// The same beyond that along a direction that turns, for the lengths of both shapes. The section
/// derives 100.
const TURNING: f64 = 120.0;

/// Support errors of a shape in a separation and in the bulge, whose factor is below 0.42.
const SHORTFALLS: f64 = 1.5;

/// A direction has no part in the plane of rotation if that part is shorter. It is less than a
/// rounding error, and support mappings take no direction of length 0.
const SMALLEST_PART: f64 = 1e-15;

/// Maximum number of intervals that are tried for one step.
const MAX_TRIES: u32 = 8;

/// A step ends where the bound is at most this fraction of the separation at its start: a longer
/// one along the same direction would hardly end later.
const ENOUGH: f64 = 0.05;

/// A shape and its motion.
#[derive(Debug)]
pub(super) struct Moving<'s, S: ?Sized> {
    pub(super) shape: &'s S,
    pub(super) motion: RigidMotion,
}

impl<S: SupportMap + ?Sized> Moving<'_, S> {
    fn turns(&self) -> bool {
        self.motion.angle() > 0.0
    }

    /// Greatest length from which heights of the shape are computed.
    fn length(&self) -> f64 {
        self.motion.extent() + self.shape.interior_point().length() + self.shape.outer_radius()
    }

    /// Upper bound of the rounding error of a height of the shape: a length.
    fn noise(&self) -> f64 {
        let units = ROUNDINGS + TURN_ROUNDINGS * self.motion.angle();
        units * f64::EPSILON * self.length() + SHORTFALLS * self.shape.support_error()
    }

    /// The maximum height of the core along `dir`, in the common frame, over its point `from`.
    fn height(&self, pose: &Pose, dir: DVec3, from: DVec3) -> f64 {
        let support = self.shape.core_support_point(pose.inverse_transform_vector(dir));
        (pose.transform_point(support.point) - from).dot(dir)
    }

    /// The part of `dir` in the plane of rotation; `None` if the shape does not turn, or only about
    /// `dir`.
    fn in_plane(&self, dir: DVec3) -> Option<DVec3> {
        let axis = self.motion.axis();
        let part = dir - axis * axis.dot(dir);
        (self.turns() && part.length_squared() > SMALLEST_PART * SMALLEST_PART).then_some(part)
    }

    /// Radius of a ball about the point about which the shape turns that contains the core.
    fn radius(&self, t: f64) -> f64 {
        let inside = self.motion.at(t).transform_point(self.shape.interior_point());
        inside.distance(self.motion.center_at(t)) + self.shape.core_radii()[1]
    }

    /// Upper bound of the height of the core along `dir` over the point about which it turns, by
    /// whatever angle it has turned.
    fn reach(&self, dir: DVec3, t: f64) -> f64 {
        if self.turns() { self.radius(t) } else { self.height(&self.motion.at(t), dir, self.motion.center_at(t)) }
    }

    /// Upper bound of the second derivative, by time, of the heights of points of `other` along
    /// `dir`, apart from that of its extent, if `dir` turns with this shape.
    fn drift<T: SupportMap + ?Sized>(&self, other: &Moving<'_, T>, dir: DVec3, t: f64) -> f64 {
        let part = self.in_plane(dir).map_or(0.0, DVec3::length);
        let past = other.motion.velocity() - self.motion.velocity();
        let (angle, radius) = (other.motion.angle(), if other.turns() { other.radius(t) } else { 0.0 });
        let speed = past.cross(self.motion.axis()).length() + angle * radius;
        2.0 * self.motion.angle() * part * speed + std::f64::consts::SQRT_2 * angle * angle * radius
    }
}

/// What a direction is fixed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    Space,
    /// To A, with which it turns.
    A,
    /// To B.
    B,
}

/// A direction from A to B, of unit length. It may turn with a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    frame: Frame,
    /// In its frame.
    local: DVec3,
}

impl Direction {
    /// A direction that is fixed in space.
    pub(super) fn fixed(dir: DVec3) -> Self {
        Self { frame: Frame::Space, local: dir }
    }

    fn at(&self, [a, b]: &[Pose; 2]) -> DVec3 {
        match self.frame {
            Frame::Space => self.local,
            Frame::A => a.transform_vector(self.local),
            Frame::B => b.transform_vector(self.local),
        }
    }
}

/// Two moving shapes.
#[derive(Debug)]
pub(super) struct Approach<'s, A: ?Sized, B: ?Sized> {
    pub(super) a: Moving<'s, A>,
    pub(super) b: Moving<'s, B>,
    /// A is a point of the plane of a half-space. The only direction is the normal, which turns
    /// with A.
    pub(super) is_plane: bool,
}

/// Separation along a direction at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    pub(super) t: f64,
    /// The gap between the support planes; negative if they overlap.
    pub(super) gap: f64,
    /// The extents in planes of rotation that decide the bulge: of A and of B.
    extents: [f64; 2],
}

/// How far a step leads, and a length that the separation surely exceeds during the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// The shapes are surely apart up to this time.
    To(f64, f64),
    /// They are surely apart until the end.
    Apart(f64),
    /// Nothing is sure.
    Nowhere,
}

/// A try to end a step at a time, and by how much the bound exceeds the target.
type Try = (f64, f64);

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Approach<'_, A, B> {
    /// Upper bound of the rounding error of the poses, and of a separation along a direction that
    /// is fixed in space or is the only one: a length.
    pub(super) fn noise(&self) -> f64 {
        self.noise_in(if self.is_plane && self.a.turns() { Frame::A } else { Frame::Space })
    }

    /// Upper bound of the rounding error of a separation along a direction that is fixed to
    /// `frame`.
    fn noise_in(&self, frame: Frame) -> f64 {
        let own = self.a.noise() + self.b.noise();
        let angle = match frame {
            Frame::Space => return own,
            Frame::A => self.a.motion.angle(),
            Frame::B => self.b.motion.angle(),
        };
        own + (TURNING + TURN_ROUNDINGS * angle) * f64::EPSILON * (self.a.length() + self.b.length())
    }

    /// The poses at time `t`.
    pub(super) fn poses(&self, t: f64) -> [Pose; 2] {
        [self.a.motion.at(t), self.b.motion.at(t)]
    }

    /// What directions can be fixed to.
    fn frames(&self) -> impl Iterator<Item = Frame> {
        let (a, b, is_plane) = (self.a.turns(), self.b.turns(), self.is_plane);
        let candidates = [(!(is_plane && a), Frame::Space), (a, Frame::A), (b && !is_plane, Frame::B)];
        candidates.into_iter().filter(|(is_possible, _)| *is_possible).map(|(_, frame)| frame)
    }

    /// The direction that is `normal` at time `t`, fixed to `frame`.
    fn direction(&self, frame: Frame, normal: DVec3, t: f64) -> Direction {
        let local = match frame {
            Frame::Space => normal,
            Frame::A => self.a.motion.at(t).inverse_transform_vector(normal),
            Frame::B => self.b.motion.at(t).inverse_transform_vector(normal),
        };
        Direction { frame, local }
    }

    /// The separation along `direction` at time `t`.
    ///
    /// # Complexity
    /// One support query of each shape, and another one of each whose extent counts.
    pub(super) fn separation(&self, direction: &Direction, t: f64, support_calls: &mut u32) -> Separation {
        let Self { a, b, .. } = self;
        let poses = self.poses(t);
        let normal = direction.at(&poses);
        let [pose_a, pose_b] = &poses;
        let radii = a.shape.convex_radius() + b.shape.convex_radius();
        let gap = -a.height(pose_a, normal, DVec3::ZERO) - b.height(pose_b, -normal, DVec3::ZERO) - radii;
        // About its own point in space, or about that of the shape with which the direction turns.
        let [center_a, center_b] = match direction.frame {
            Frame::Space => [a.motion.center_at(t), b.motion.center_at(t)],
            Frame::A => [a.motion.center_at(t); 2],
            Frame::B => [b.motion.center_at(t); 2],
        };
        let [part_a, part_b] = match direction.frame {
            Frame::Space => [a.in_plane(normal), b.in_plane(-normal)],
            Frame::A => [None, a.in_plane(-normal)],
            Frame::B => [b.in_plane(normal), None],
        };
        let extent_a = part_a.map_or(0.0, |dir| a.height(pose_a, dir, center_a));
        let extent_b = part_b.map_or(0.0, |dir| b.height(pose_b, dir, center_b));
        *support_calls += 1 + u32::from(part_a.is_some() || part_b.is_some());
        Separation { t, gap, extents: [extent_a, extent_b] }
    }

    /// Lower bound of the separation between two times, along `direction`, which both separations
    /// are along. Negative infinity if a shape turns by more than [`MAX_TURN`].
    fn least(&self, direction: &Direction, from: &Separation, to: &Separation) -> f64 {
        let Self { a, b, .. } = self;
        let time = to.t - from.t;
        let [angle_a, angle_b] = [a.motion.angle(), b.motion.angle()];
        // NaN takes the failing branch.
        if !(angle_a.max(angle_b) * time <= MAX_TURN) {
            return f64::NEG_INFINITY;
        }
        // 1/cos − 1 of half the angle is at most this, times the square of the angle, up to 45
        // degrees.
        let curve = |angle: f64| {
            let half = 0.5 * angle * time;
            0.125 * time * time * (1.0 + 0.56 * half * half)
        };
        let ([from_a, from_b], [to_a, to_b]) = (from.extents, to.extents);
        let (extent_a, extent_b) = (from_a.max(to_a).max(0.0), from_b.max(to_b).max(0.0));
        let by = |angle: f64, extent: f64| curve(angle) * angle * angle * extent;
        let normal = || direction.at(&self.poses(from.t));
        let bulge = match direction.frame {
            Frame::Space => by(angle_a, extent_a) + by(angle_b, extent_b),
            Frame::A => by(angle_a, extent_b) + curve(angle_a) * a.drift(b, normal(), from.t),
            Frame::B => by(angle_b, extent_a) + curve(angle_b) * b.drift(a, normal(), from.t),
        };
        from.gap.min(to.gap) - bulge - self.noise_in(direction.frame)
    }

    /// Time from `t` on until which the separation along `normal` surely stays above `target`, by
    /// whatever angles the shapes turn: then a body that spins fast needs no step for each quarter
    /// of a turn. It is `t` if nothing is sure.
    fn clear_until(&self, normal: DVec3, [t, until]: [f64; 2], target: f64, support_calls: &mut u32) -> f64 {
        let Self { a, b, is_plane } = self;
        // A half-space that turns reaches everywhere.
        if *is_plane && a.turns() {
            return t;
        }
        let radii = a.shape.convex_radius() + b.shape.convex_radius();
        let needed = a.reach(normal, t) + b.reach(-normal, t) + radii + self.noise() + target;
        *support_calls += 1;
        // It is linear in time.
        let above = |t: f64| (b.motion.center_at(t) - a.motion.center_at(t)).dot(normal) - needed;
        let (start, end) = (above(t), above(until));
        // NaN takes the last branch.
        if start > 0.0 && end > 0.0 {
            until
        } else if start > 0.0 && end < start {
            // Not as far as the bound allows, since the time has a rounding error, too.
            t + (until - t) * (0.95 * start / (start - end))
        } else {
            t
        }
    }

    /// The longest step from time `t`, at most to `until`, in which the separation surely stays
    /// above `target`. It is along `normal`, in space or with one of the shapes. `meeting` is a
    /// guess of the time at which the shapes meet.
    ///
    /// # Complexity
    /// At most [`MAX_TRIES`] separations, and six more.
    pub(super) fn step(
        &self,
        normal: DVec3,
        [t, until]: [f64; 2],
        meeting: f64,
        target: f64,
        support_calls: &mut u32,
    ) -> Step {
        let fastest = self.a.motion.angle().max(self.b.motion.angle());
        let end = until.min(t + LONGEST_TURN / fastest);
        if end < until {
            let clear = self.clear_until(normal, [t, until], target, support_calls);
            if clear > end {
                return if clear == until { Step::Apart(target) } else { Step::To(clear, target) };
            }
        }
        // The frame in which the bound is the highest where the shapes may meet.
        let probe = if meeting > t && meeting < end { meeting } else { end };
        let mut best: Option<(Direction, Separation, f64, Try)> = None;
        for frame in self.frames() {
            let direction = self.direction(frame, normal, t);
            let from = self.separation(&direction, t, support_calls);
            let start = self.least(&direction, &from, &from) - target;
            // NaN takes the failing branch.
            if !(start > 0.0) {
                continue;
            }
            let to = self.separation(&direction, probe, support_calls);
            let above = self.least(&direction, &from, &to) - target;
            if best.as_ref().is_none_or(|(.., found)| above > found.1) {
                best = Some((direction, from, start, (probe, above)));
            }
        }
        let Some((direction, from, start, tried)) = best else { return Step::Nowhere };
        let above = |to: &Separation| self.least(&direction, &from, to) - target;
        let found = longest((t, start), tried, end, |t| above(&self.separation(&direction, t, support_calls)));
        match found {
            (later, above) if later == until => Step::Apart(target + above),
            (later, above) if later > t => Step::To(later, target + above),
            _ => Step::Nowhere,
        }
    }
}

/// The latest time found, up to `end`, at which `above` is positive, and its value. It is positive
/// at `start`. `tried` is a later time.
fn longest(start: Try, tried: Try, end: f64, mut above: impl FnMut(f64) -> f64) -> Try {
    let (mut early, mut late) = if tried.1 > 0.0 { (tried, (end, f64::NAN)) } else { (start, tried) };
    if early.0 == end {
        return early;
    }
    if late.0 == end && late.1.is_nan() {
        late.1 = above(end);
        if late.1 > 0.0 {
            return late;
        }
    }
    // Regula falsi. A try that is too late halves the next share. After one that is much too
    // early, as for shapes that graze each other, the next share is the geometric mean with 1.
    let (mut caution, mut is_early) = (0.95, false);
    for _ in 0..MAX_TRIES {
        if early.0 > start.0 && early.1 <= ENOUGH * start.1 {
            break;
        }
        let share = early.1 / (early.1 - late.1) * caution;
        let share = if is_early { share.sqrt() } else { share };
        let t = early.0 + (late.0 - early.0) * share.min(0.9);
        let value = above(t);
        if value > 0.0 {
            (early, caution, is_early) = ((t, value), 0.95, true);
        } else {
            (late, caution, is_early) = ((t, value), 0.5 * caution, false);
        }
    }
    early
}
