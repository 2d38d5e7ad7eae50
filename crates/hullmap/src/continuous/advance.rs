//! Conservative advancement: how far two moving shapes certainly stay apart along a direction.
//!
//! # Reference
//! Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, for the principle.
//! The bounds below are our own; docs/contributors/intervals.md, section 15, proves them.
//!
//! # The bounds
//! The *separation* along a unit direction n is the gap between the planes perpendicular to n
//! through the support points of both shapes. It is computed at the two ends of an interval of
//! time. In between it is at least the lower of the two minus a *bulge*, which falls with the
//! square of the interval.
//!
//! - n is fixed in space: each shape that turns adds a bulge. For an angle φ it is (1/cos(φ/2) − 1)
//!   times the extent of the shape, from the point about which it turns, in the direction of n in
//!   the plane of rotation. So translations add nothing, and neither does the length of a shape
//!   along its axis.
//! - n turns with one of the shapes, as the normal of its face does. Then the extent is the extent
//!   of the other shape on the far side of the point about which the first one turns. It is usually
//!   zero. Motion of the other shape adds a *drift*.

use glam::{DMat3, DVec3};

use super::rigid_motion::RigidMotion;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Maximum angle in radians of one interval of time.
const MAX_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Angle of the longest step: less than [`MAX_TURN`] by more than rounding errors.
const LONGEST_TURN: f64 = 0.999 * MAX_TURN;

/// Rounding error of a separation and of the bulge, in units of `f64::EPSILON` times the lengths
/// from which they are computed: docs/contributors/intervals.md, section 15, derives 137. Each
/// radian of the motion adds [`TURN_ROUNDINGS`].
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
/// one along the same direction would not end much later.
const ENOUGH: f64 = 0.05;

/// Share of the way to the meeting that a step leaves, for each radian until then: shapes that
/// barely turn meet when their closest points would.
const REST: f64 = 0.25;

/// Least and greatest of these shares.
const LEAST_REST: f64 = 1e-4;
const GREATEST_REST: f64 = 0.05;

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

    /// The maximum height of the core along `local`, in its own frame, over the origin.
    fn own_height(&self, local: DVec3) -> f64 {
        self.shape.core_support_point(local).point.dot(local)
    }

    /// The maximum height of the core along `dir`, in the common frame, over its point `from`.
    fn height(&self, place: &Place, dir: DVec3, from: DVec3) -> f64 {
        self.own_height(place.rotation.mul_transpose_vec3(dir)) + (place.origin - from).dot(dir)
    }

    /// The part of `dir` in the plane of rotation; `None` if the shape does not turn, or only about
    /// `dir`.
    fn in_plane(&self, dir: DVec3) -> Option<DVec3> {
        let axis = self.motion.axis();
        let part = dir - axis * axis.dot(dir);
        (self.turns() && part.length_squared() > SMALLEST_PART * SMALLEST_PART).then_some(part)
    }

    fn place(&self, t: f64) -> Place {
        let pose = self.motion.pose_at(t);
        Place { rotation: pose.rotation_matrix(), origin: pose.translation(), center: self.motion.center_at(t), pose }
    }

    fn inside(&self, place: &Place) -> DVec3 {
        place.rotation * self.shape.interior_point() + place.origin
    }

    /// Radius of a ball about the point about which the shape turns that contains the core.
    fn radius(&self, place: &Place) -> f64 {
        self.inside(place).distance(place.center) + self.shape.core_radii()[1]
    }

    /// Upper bound of the height of the core along `dir` over the point about which it turns, by
    /// whatever angle it has turned.
    fn reach(&self, dir: DVec3, place: &Place) -> f64 {
        if self.turns() { self.radius(place) } else { self.height(place, dir, place.center) }
    }

    /// The maximum height of the core along `dir` over a point `from` of the other shape, or 0 if
    /// its ball is below that point.
    fn height_above(&self, place: &Place, dir: DVec3, from: DVec3) -> f64 {
        let by_ball = (self.inside(place) - from).dot(dir) + self.shape.core_radii()[1] * dir.length();
        // NaN takes the support query.
        if by_ball <= 0.0 { 0.0 } else { self.height(place, dir, from) }
    }

    /// Upper bound of the second derivative, by time, of the heights of points of `other` along
    /// `dir`, without the part due to its extent, if `dir` turns with this shape.
    fn drift<T: SupportMap + ?Sized>(&self, other: &Moving<'_, T>, dir: DVec3, of_other: &Place) -> f64 {
        let part = self.in_plane(dir).map_or(0.0, DVec3::length);
        let past = other.motion.velocity() - self.motion.velocity();
        let (angle, radius) = (other.motion.angle(), if other.turns() { other.radius(of_other) } else { 0.0 });
        let speed = past.cross(self.motion.axis()).length() + angle * radius;
        2.0 * self.motion.angle() * part * speed + std::f64::consts::SQRT_2 * angle * angle * radius
    }
}

/// The frame in which a direction is fixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Frame {
    #[default]
    Space,
    /// To A, with which it turns.
    A,
    B,
}

/// A direction from A to B, of unit length. It may turn with a shape.
#[derive(Clone, Copy, Debug)]
struct Direction {
    frame: Frame,
    local: DVec3,
    /// The maximum height along it, over the origin of its frame, of the shape with which it turns:
    /// that does not change.
    own_height: f64,
    /// Upper bound of the second derivative of the heights along it, without the part due to the
    /// extents.
    drift: f64,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    pose: Pose,
    rotation: DMat3,
    origin: DVec3,
    /// The point about which the shape turns.
    center: DVec3,
}

#[derive(Debug)]
pub(super) struct Approach<'s, A: ?Sized, B: ?Sized> {
    pub(super) a: Moving<'s, A>,
    pub(super) b: Moving<'s, B>,
    /// A is a point of the plane of a half-space. The only direction is the normal, which turns
    /// with A.
    is_plane: bool,
    /// Upper bounds of the rounding error of a separation along a direction that is fixed in space,
    /// to A, and to B.
    noises: [f64; 3],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) t: f64,
    /// Places of A and of B.
    places: [Place; 2],
}

impl Moment {
    pub(super) fn poses(&self) -> [Pose; 2] {
        self.places.map(|place| place.pose)
    }
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

/// How far a step leads, and a length that the separation certainly exceeds during the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// The shapes are certainly apart up to this time.
    To(f64, f64),
    /// They are certainly apart until the end.
    Apart(f64),
    /// Nothing is sure.
    Nowhere,
}

/// A try to end a step at a time, and by how much the bound exceeds the target.
type Try = (f64, f64);

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized> Approach<'s, A, B> {
    pub(super) fn new(a: Moving<'s, A>, b: Moving<'s, B>, is_plane: bool) -> Self {
        let (own, lengths) = (a.noise() + b.noise(), a.length() + b.length());
        let turning = |angle: f64| own + (TURNING + TURN_ROUNDINGS * angle) * f64::EPSILON * lengths;
        let noises = [own, turning(a.motion.angle()), turning(b.motion.angle())];
        Self { a, b, is_plane, noises }
    }

    /// Upper bound of the rounding error of the poses, and of a separation along a direction that
    /// is fixed in space or is the only one: a length.
    pub(super) fn noise(&self) -> f64 {
        self.noise_in(if self.is_plane && self.a.turns() { Frame::A } else { Frame::Space })
    }

    /// Upper bound of the rounding error of a separation along a direction that is fixed to
    /// `frame`.
    fn noise_in(&self, frame: Frame) -> f64 {
        let [space, a, b] = self.noises;
        match frame {
            Frame::Space => space,
            Frame::A => a,
            Frame::B => b,
        }
    }

    pub(super) fn moment_at(&self, t: f64) -> Moment {
        Moment { t, places: [self.a.place(t), self.b.place(t)] }
    }

    /// The frames in which directions can be fixed, starting with `first`.
    fn frames(&self, first: Frame) -> impl Iterator<Item = Frame> {
        let others = [Frame::Space, Frame::A, Frame::B].into_iter().filter(move |frame| *frame != first);
        std::iter::once(first).chain(others).filter(|frame| match frame {
            Frame::Space => !(self.is_plane && self.a.turns()),
            Frame::A => self.a.turns(),
            Frame::B => self.b.turns() && !self.is_plane,
        })
    }

    /// The direction that is `normal` at one time, fixed to `frame`.
    fn direction(&self, frame: Frame, normal: DVec3, at: &Moment) -> Direction {
        let ([place_a, place_b], Self { a, b, .. }) = (&at.places, self);
        match frame {
            Frame::Space => Direction { frame, local: normal, own_height: 0.0, drift: 0.0 },
            Frame::A => {
                let local = place_a.rotation.mul_transpose_vec3(normal);
                Direction { frame, local, own_height: a.own_height(local), drift: a.drift(b, normal, place_b) }
            }
            Frame::B => {
                let local = place_b.rotation.mul_transpose_vec3(normal);
                Direction { frame, local, own_height: b.own_height(-local), drift: b.drift(a, normal, place_a) }
            }
        }
    }

    /// The extents in planes of rotation that decide the bulge along `normal`, which is fixed to
    /// `frame`: of A and of B.
    ///
    /// # Complexity
    /// One support query of each shape whose extent counts.
    fn extents(&self, frame: Frame, normal: DVec3, at: &Moment, support_calls: &mut u32) -> [f64; 2] {
        let (Self { a, b, .. }, [place_a, place_b]) = (self, &at.places);
        // About its own centre in space, or about the centre of the shape with which the direction
        // turns.
        let extents = match frame {
            Frame::Space => [
                a.in_plane(normal).map(|dir| a.height(place_a, dir, place_a.center)),
                b.in_plane(-normal).map(|dir| b.height(place_b, dir, place_b.center)),
            ],
            Frame::A => [None, a.in_plane(-normal).map(|dir| b.height_above(place_b, dir, place_a.center))],
            Frame::B => [b.in_plane(normal).map(|dir| a.height_above(place_a, dir, place_b.center)), None],
        };
        *support_calls += u32::from(extents != [None; 2]);
        extents.map(Option::unwrap_or_default)
    }

    /// The separation along `direction` at one time.
    ///
    /// # Complexity
    /// One support query of each shape that does not turn with the direction, and
    /// [`extents`](Self::extents).
    fn separation(&self, direction: &Direction, at: &Moment, support_calls: &mut u32) -> Separation {
        let (Self { a, b, .. }, [place_a, place_b]) = (self, &at.places);
        let (local, own) = (direction.local, direction.own_height);
        let normal = match direction.frame {
            Frame::Space => local,
            Frame::A => place_a.rotation * local,
            Frame::B => place_b.rotation * local,
        };
        let of_a = || a.height(place_a, normal, DVec3::ZERO);
        let of_b = || b.height(place_b, -normal, DVec3::ZERO);
        let heights = match direction.frame {
            Frame::Space => of_a() + of_b(),
            Frame::A => own + place_a.origin.dot(normal) + of_b(),
            Frame::B => of_a() + own - place_b.origin.dot(normal),
        };
        *support_calls += 1;
        let gap = -heights - a.shape.convex_radius() - b.shape.convex_radius();
        Separation { t: at.t, gap, extents: self.extents(direction.frame, normal, at, support_calls) }
    }

    /// Lower bound of the separation between two times, along `direction`, which both separations
    /// are along. Negative infinity if a shape turns by more than [`MAX_TURN`].
    fn least(&self, direction: &Direction, from: &Separation, to: &Separation) -> f64 {
        let time = to.t - from.t;
        let [angle_a, angle_b] = [self.a.motion.angle(), self.b.motion.angle()];
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
        let bulge = match direction.frame {
            Frame::Space => by(angle_a, extent_a) + by(angle_b, extent_b),
            Frame::A => by(angle_a, extent_b) + curve(angle_a) * direction.drift,
            Frame::B => by(angle_b, extent_a) + curve(angle_b) * direction.drift,
        };
        from.gap.min(to.gap) - bulge - self.noise_in(direction.frame)
    }

    /// Time from `t` on until which the separation along `normal` certainly stays above `target`,
    /// by whatever angles the shapes turn: then a body that spins fast needs no step for each
    /// quarter of a turn. It is `t` if nothing is sure.
    fn clear_until(&self, here: &Moment, normal: DVec3, until: f64, target: f64, support_calls: &mut u32) -> f64 {
        let (Self { a, b, is_plane, .. }, Moment { t, places: [place_a, place_b] }) = (self, *here);
        // A half-space that turns reaches everywhere.
        if *is_plane && a.turns() {
            return t;
        }
        let radii = a.shape.convex_radius() + b.shape.convex_radius();
        let needed = a.reach(normal, &place_a) + b.reach(-normal, &place_b) + radii + self.noise() + target;
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

    /// The longest step from a time on, at most to `until`, in which the separation certainly stays
    /// above `target`. It is along `normal`, in space or with one of the shapes. There, `gap` is a
    /// lower bound of the separation. `meeting` is a guess of the time at which the shapes meet,
    /// and `frame` one of what the direction is to be fixed to. `here` becomes the end of the step,
    /// unless that is the end of the motion.
    ///
    /// # Complexity
    /// At most [`MAX_TRIES`] separations, and four more.
    pub(super) fn step(
        &self,
        here: &mut Moment,
        (normal, gap): (DVec3, f64),
        until: f64,
        meeting: f64,
        target: f64,
        (frame, support_calls): (&mut Frame, &mut u32),
    ) -> Step {
        let t = here.t;
        let fastest = self.a.motion.angle().max(self.b.motion.angle());
        let end = until.min(t + LONGEST_TURN / fastest);
        if end < until {
            let clear = self.clear_until(here, normal, until, target, support_calls);
            if clear == until {
                return Step::Apart(target);
            } else if clear > end {
                *here = self.moment_at(clear);
                return Step::To(clear, target);
            }
        }
        // The frame in which the bound is the highest just before the shapes may meet, or the first
        // one that leads there.
        let rest = (REST * fastest * (meeting - t)).clamp(LEAST_REST, GREATEST_REST);
        let before = t + (meeting - t) * (1.0 - rest);
        let mut probe = self.moment_at(if before > t && before < end { before } else { end });
        let mut best: Option<(Direction, Separation, f64, Try)> = None;
        let last = *frame;
        for frame in self.frames(last) {
            let start = gap - self.noise_in(frame) - target;
            // NaN takes the failing branch.
            if !(start > 0.0) {
                continue;
            }
            let direction = self.direction(frame, normal, here);
            let from = Separation { t, gap, extents: self.extents(frame, normal, here, support_calls) };
            let to = self.separation(&direction, &probe, support_calls);
            let above = self.least(&direction, &from, &to) - target;
            if best.as_ref().is_none_or(|(.., found)| above > found.1) {
                best = Some((direction, from, start, (probe.t, above)));
            }
            if above > 0.0 {
                break;
            }
        }
        let Some((direction, from, start, tried)) = best else { return Step::Nowhere };
        *frame = direction.frame;
        // The latest time with a positive bound is where the step ends.
        let above = |t| {
            let at = self.moment_at(t);
            let above = self.least(&direction, &from, &self.separation(&direction, &at, support_calls)) - target;
            if above > 0.0 {
                probe = at;
            }
            above
        };
        match longest((t, start), tried, end, rest, above) {
            (later, above) if later == until => Step::Apart(target + above),
            (later, above) if later > t => {
                *here = probe;
                Step::To(later, target + above)
            }
            _ => Step::Nowhere,
        }
    }
}

/// The latest time found, up to `end`, at which `above` is positive, and its value. It is positive
/// at `start`. `tried` is a later time. Where `above` is nearly linear, the share `rest` of its
/// value is left.
fn longest(start: Try, tried: Try, end: f64, rest: f64, mut above: impl FnMut(f64) -> f64) -> Try {
    let (mut early, mut late) = if tried.1 > 0.0 { (tried, (end, f64::NAN)) } else { (start, tried) };
    let is_enough = |early: Try| early.0 == end || (early.0 > start.0 && early.1 <= ENOUGH * start.1);
    if is_enough(early) {
        return early;
    }
    if late.1.is_nan() {
        late.1 = above(end);
        if late.1 > 0.0 {
            return late;
        }
    }
    // Regula falsi. After a try that is too late, the next one leaves a twentieth, and then its
    // share is halved each time. After one that is much too early, as for shapes that graze each
    // other, the next share is the geometric mean with 1.
    let (mut caution, mut is_early) = (1.0 - rest, false);
    for _ in 0..MAX_TRIES {
        if is_enough(early) {
            break;
        }
        let share = early.1 / (early.1 - late.1) * caution;
        let share = if is_early { share.sqrt() } else { share };
        let t = early.0 + (late.0 - early.0) * share.min(1.0 - LEAST_REST);
        let value = above(t);
        if value > 0.0 {
            (early, caution, is_early) = ((t, value), 0.95, true);
        } else {
            (late, caution, is_early) = ((t, value), if caution > 0.95 { 0.95 } else { 0.5 * caution }, false);
        }
    }
    early
}
