//! Conservative advancement: how far two moving shapes surely stay apart along a direction.
//!
//! # Reference
//! Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, for the principle.
//! The bound below is our own; docs/intervals.md, section 15, proves it.
//!
//! # The bound
//! The *separation* along a fixed unit direction n is the gap between the planes perpendicular to n
//! through the support points of both shapes. It is computed at the two ends of an interval of
//! time. In between it is at least the lower of the two, less a *bulge* for each shape that turns.
//! For an angle φ the bulge is (1/cos(φ/2) − 1) times the extent of the shape, from the point about
//! which it turns, in the direction of n in the plane of rotation. So translations cost nothing,
//! and neither does the length of a shape along its axis. The bulge falls with the square of the
//! interval.

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
pub(super) struct Moving<'s, S: ?Sized> {
    pub(super) shape: &'s S,
    pub(super) motion: RigidMotion,
}

impl<S: SupportMap + ?Sized> Moving<'_, S> {
    /// Upper bound of the rounding error of a height of the shape: a length.
    fn noise(&self) -> f64 {
        let lengths = self.motion.extent() + self.shape.interior_point().length() + self.shape.outer_radius();
        let units = ROUNDINGS + TURN_ROUNDINGS * self.motion.angle();
        units * f64::EPSILON * lengths + SHORTFALLS * self.shape.support_error()
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
        (self.motion.angle() > 0.0 && part.length_squared() > SMALLEST_PART * SMALLEST_PART).then_some(part)
    }

    /// Upper bound of the height of the core along `dir` over the point about which it turns, by
    /// whatever angle it has turned.
    fn reach(&self, dir: DVec3, t: f64) -> f64 {
        let (pose, center) = (self.motion.at(t), self.motion.center_at(t));
        if self.motion.angle() > 0.0 {
            pose.transform_point(self.shape.interior_point()).distance(center) + self.shape.core_radii()[1]
        } else {
            self.height(&pose, dir, center)
        }
    }
}

/// Two moving shapes.
pub(super) struct MovingPair<'s, A: ?Sized, B: ?Sized> {
    pub(super) a: Moving<'s, A>,
    pub(super) b: Moving<'s, B>,
}

/// Separation along a direction at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    pub(super) t: f64,
    /// The gap between the support planes; negative if they overlap.
    pub(super) gap: f64,
    /// For each shape that turns, its extent in the plane of rotation.
    extents: [f64; 2],
}

/// How far a step leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// The shapes are surely apart up to this time.
    To(f64),
    /// They are surely apart until the end.
    Apart,
    /// Nothing is sure.
    Nowhere,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> MovingPair<'_, A, B> {
    /// Upper bound of the rounding error of a separation: a length.
    pub(super) fn noise(&self) -> f64 {
        self.a.noise() + self.b.noise()
    }

    /// The poses at time `t`.
    pub(super) fn poses(&self, t: f64) -> [Pose; 2] {
        [self.a.motion.at(t), self.b.motion.at(t)]
    }

    /// The separation along the unit vector `normal`, from A to B, at time `t`.
    ///
    /// # Complexity
    /// One support query of each shape, and another one of each that turns.
    pub(super) fn separation(&self, normal: DVec3, t: f64, support_calls: &mut u32) -> Separation {
        let Self { a, b } = self;
        let [pose_a, pose_b] = self.poses(t);
        let radii = a.shape.convex_radius() + b.shape.convex_radius();
        let gap = -a.height(&pose_a, normal, DVec3::ZERO) - b.height(&pose_b, -normal, DVec3::ZERO) - radii;
        let extent_a = a.in_plane(normal).map_or(0.0, |dir| a.height(&pose_a, dir, a.motion.center_at(t)));
        let extent_b = b.in_plane(-normal).map_or(0.0, |dir| b.height(&pose_b, dir, b.motion.center_at(t)));
        *support_calls += 1 + u32::from(a.motion.angle() > 0.0 || b.motion.angle() > 0.0);
        Separation { t, gap, extents: [extent_a, extent_b] }
    }

    /// Lower bound of the separation between two times, along the direction of both separations.
    /// Negative infinity if a shape turns by more than [`MAX_TURN`].
    fn least(&self, from: &Separation, to: &Separation) -> f64 {
        let angles = [self.a.motion.angle(), self.b.motion.angle()];
        let bulges = [0, 1].map(|i| {
            let half = 0.5 * angles[i] * (to.t - from.t);
            // 1/cos − 1 is at most this up to 45 degrees. NaN takes the failing branch.
            if !(half <= 0.5 * MAX_TURN) {
                return f64::INFINITY;
            }
            let square = half * half;
            0.5 * square * (1.0 + 0.56 * square) * from.extents[i].max(to.extents[i]).max(0.0)
        });
        from.gap.min(to.gap) - bulges[0] - bulges[1] - self.noise()
    }

    /// Time from `t` on until which the separation along `normal` surely stays above `target`, by
    /// whatever angles the shapes turn: then a body that spins fast needs no step for each quarter
    /// of a turn. It is `t` if nothing is sure.
    fn clear_until(&self, normal: DVec3, t: f64, target: f64, support_calls: &mut u32) -> f64 {
        let Self { a, b } = self;
        let radii = a.shape.convex_radius() + b.shape.convex_radius();
        let needed = a.reach(normal, t) + b.reach(-normal, t) + radii + self.noise() + target;
        *support_calls += 1;
        // It is linear in time.
        let above = |t: f64| (b.motion.center_at(t) - a.motion.center_at(t)).dot(normal) - needed;
        let (start, end) = (above(t), above(1.0));
        // NaN takes the last branch.
        if start > 0.0 && end > 0.0 {
            1.0
        } else if start > 0.0 && end < start {
            // Not as far as the bound allows, since the time has a rounding error, too.
            t + (1.0 - t) * (0.95 * start / (start - end))
        } else {
            t
        }
    }

    /// The longest step from the time of `from`, along `normal`, in which the separation surely
    /// stays above `target`. `from` is the separation along `normal`.
    ///
    /// # Complexity
    /// At most [`MAX_TRIES`] separations.
    pub(super) fn step(&self, normal: DVec3, from: &Separation, target: f64, support_calls: &mut u32) -> Step {
        let above = |to: &Separation| self.least(from, to) - target;
        let start = above(from);
        let fastest = self.a.motion.angle().max(self.b.motion.angle());
        let (mut early, mut late) = ((from.t, start), (1.0_f64.min(from.t + LONGEST_TURN / fastest), f64::NAN));
        // NaN takes the failing branch.
        if !(start > 0.0) {
            return Step::Nowhere;
        }
        if late.0 < 1.0 {
            let clear = self.clear_until(normal, from.t, target, support_calls);
            if clear > late.0 {
                return if clear == 1.0 { Step::Apart } else { Step::To(clear) };
            }
        }
        late.1 = above(&self.separation(normal, late.0, support_calls));
        if late.1 > 0.0 {
            return if late.0 == 1.0 { Step::Apart } else { Step::To(late.0) };
        }
        // Regula falsi. A try that is too late halves the next share. After one that is much too
        // early, as for shapes that graze each other, the next share is the geometric mean with 1.
        let (mut caution, mut is_early) = (0.95, false);
        for _ in 0..MAX_TRIES {
            let share = early.1 / (early.1 - late.1) * caution;
            let share = if is_early { share.sqrt() } else { share };
            let t = early.0 + (late.0 - early.0) * share.min(0.9);
            let value = above(&self.separation(normal, t, support_calls));
            if value > 0.0 {
                (early, caution, is_early) = ((t, value), 0.95, true);
                if value <= ENOUGH * start {
                    break;
                }
            } else {
                (late, caution, is_early) = ((t, value), 0.5 * caution, false);
            }
        }
        if early.0 > from.t { Step::To(early.0) } else { Step::Nowhere }
    }
}
