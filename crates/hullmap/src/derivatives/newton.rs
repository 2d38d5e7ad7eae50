//! Newton's method for the normal and the witness points of an answer.
//!
//! A query ends as soon as its interval is narrow. A normal is only as accurate as the square root
//! of that width, unless it belongs to faces, edges and vertices. On the rims, sides and tips that
//! the answer shows, normal and points solve equations that are smooth: a few steps of Newton's
//! method make them as accurate as rounding error allows.
//!
//! # Steps
//! 1. Support points in slightly tilted directions show the features of each core that face the
//!    normal: one, two with a line between them, or three that span a plane. A vertex is a feature,
//!    and so is a rim: its farthest point depends on the direction.
//! 2. Solve for the normal, and for the places on these lines and planes: the difference of the
//!    points is along the normal, or on the line of a cast. The features of a shape are equally far
//!    along the normal.
//! 3. Accept the solution if no support point is farther along its normal, and if the places are on
//!    the features. For distances, that proves it. Otherwise try wider tilts.
//!
//! docs/contributors/intervals.md, section 16.

use arrayvec::ArrayVec;
use glam::{DMat3, DMat4, DVec3, DVec4};

use super::pose_derivative::Differentiability;
use super::witness::{GREATEST_TILT, Placed, THIRDS, is_inside_face, tilt};
use crate::pose::Pose;
use crate::solver::Status;
use crate::support::{FeaturePoint, SupportMap};
use crate::vector::{perpendicular, unit};

/// Maximum number of steps. From the answers of a query, 2 to 5 suffice.
const MAX_STEPS: usize = 12;

/// A solution whose last step was longer, in radians, is none: Newton's method doubles the digits
/// in each step, so the next one would be rounding error.
const LAST_STEP: f64 = 1e-9;

/// Factor from one tilt to the next, and their number.
const WIDER: f64 = 64.0;
const TILTS: usize = 4;

/// Error of heights and places, in units of `f64::EPSILON` times the lengths of the pair: rotated
/// points (Lemma 2 of docs/contributors/intervals.md derives 25 for each shape) and the solution of
/// the equations.
const ROUNDINGS: f64 = 256.0;

/// Places may be beyond the ends of a line by this share of it: there, the next feature is as good.
const BEYOND: f64 = 1e-9;

/// Points of one feature that are this share of the outer radius apart, for directions that differ
/// by a tilt, are the rim of a face.
const FLAT: f64 = 0.1;

/// A feature of a shape, in A's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Corner {
    /// A vertex, or a point of a face.
    At(DVec3),
    /// A curved feature.
    Curved(u32),
}

/// The features of a shape that face a direction.
type Corners = ArrayVec<Corner, 3>;

/// Features that were found, and a point of each.
#[derive(Default)]
struct FacingFeatures {
    corners: Corners,
    points: ArrayVec<DVec3, 3>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Refined {
    pub(super) normal: DVec3,
    /// Points of the shapes, one convex radius away from the points of the cores.
    pub(super) points: [DVec3; 2],
}

/// The equation that the points of an answer satisfy.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition {
    /// Their difference is along the normal, and its length is in this interval. It is negative for
    /// depths.
    Along([f64; 2]),
    /// The points meet when B moves in this direction, a unit vector.
    Meeting(DVec3),
}

/// Whether an answer with this status is as accurate as its settings require.
pub(super) fn is_accurate(status: Status) -> bool {
    matches!(status, Status::Exact | Status::Within)
}

/// The status of derivatives whose normal may be less accurate than rounding error allows.
pub(super) fn if_accurate(status: Differentiability, is_refined: bool) -> Differentiability {
    if status == Differentiability::Unique && !is_refined { Differentiability::Inaccurate } else { status }
}

/// Whether both cores are polytopes, so that an exact answer has an exact normal.
pub(super) fn are_polytopes<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(a: &A, b: &B) -> bool {
    a.has_polytope_core() && b.has_polytope_core()
}

/// Whether both shapes describe the features that face this normal.
pub(super) fn are_described<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    normal: DVec3,
) -> bool {
    fn is_described<S: SupportMap + ?Sized>(shape: &S, local: DVec3) -> bool {
        shape.core_feature_point(shape.core_support_point(local).feature, local).is_some()
    }
    is_described(a, normal) && is_described(b, b_in_a.inverse_transform_vector(-normal))
}

/// The accurate normal and points, near an answer's, whose normal has at most this error.
/// `None` if there are none, or if a shape has no description of its features.
#[cold]
#[inline(never)]
pub(super) fn refined<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    near: Refined,
    error: f64,
    condition: Condition,
) -> Option<Refined> {
    let mut tilt = tilt(error).min(GREATEST_TILT);
    for _ in 0..TILTS {
        let sides = (Placed::new(a, Pose::IDENTITY, tilt), Placed::new(b, b_in_a, tilt));
        let corners = (sides.0.corners(near.normal)?, sides.1.corners(-near.normal)?);
        let system = System { a: &sides.0, b: &sides.1, corners, condition };
        if let Some(found) = system.solve(near) {
            return Some(found);
        }
        if tilt == GREATEST_TILT {
            break;
        }
        tilt = (tilt * WIDER).min(GREATEST_TILT);
    }
    None
}

impl<S: SupportMap + ?Sized> Placed<'_, S> {
    /// Step 1. `None` if the shape does not describe a curved feature.
    fn corners(&self, normal: DVec3) -> Option<Corners> {
        let mut found = FacingFeatures::default();
        let (x, y) = (perpendicular(normal), normal.cross(perpendicular(normal)));
        let [p, q, r] = THIRDS.map(|side| self.add(normal + (x * side.x + y * side.y) * self.tilt, &mut found));
        let rim = [p?, q?, r?];
        if let [p, q, ..] = found.points[..]
            && let Some(along) = unit(q - p)
        {
            let across = normal.cross(along) * self.tilt;
            self.add(normal + across, &mut found)?;
            self.add(normal - across, &mut found)?;
        }
        let spread = rim[0].distance(rim[1]).max(rim[1].distance(rim[2]));
        let is_flat = found.corners.len() == 1 && spread > FLAT * self.shape.core_radii()[1];
        Some(if is_flat { rim.map(Corner::At).into() } else { found.corners })
    }

    /// Adds the feature along a direction, unless it is known, and returns its farthest point.
    fn add(&self, dir: DVec3, found: &mut FacingFeatures) -> Option<DVec3> {
        let local = self.rotation.mul_transpose_vec3(dir);
        let support = self.shape.core_support_point(local);
        let point = self.place(support.point);
        let described = self.shape.core_feature_point(support.feature, local);
        let corner = match described {
            Some(at) if at.derivative != DMat3::ZERO => Corner::Curved(support.feature),
            _ => Corner::At(point),
        };
        // Points of an unknown feature that are near each other may be on a curved surface.
        let is_near = |other: &DVec3| *other != point && other.distance(point) <= self.same_place();
        if described.is_none() && found.points.iter().any(is_near) {
            return None;
        }
        if !found.corners.contains(&corner) {
            let _ = (found.corners.try_push(corner), found.points.try_push(point));
        }
        Some(point)
    }

    /// A point of the core in A's frame.
    fn place(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.pose.translation()
    }

    /// The point of a feature that is farthest along `dir`, and its derivative by `dir`.
    fn corner_point(&self, corner: Corner, dir: DVec3) -> Option<FeaturePoint> {
        match corner {
            Corner::At(point) => Some(FeaturePoint::vertex(point)),
            Corner::Curved(feature) => {
                let found = self.shape.core_feature_point(feature, self.rotation.mul_transpose_vec3(dir))?;
                let derivative = self.rotation * found.derivative * self.rotation.transpose();
                Some(FeaturePoint { point: self.place(found.point), derivative })
            }
        }
    }

    /// Step 1 for a direction: the points of the features.
    fn corner_points(&self, corners: &Corners, dir: DVec3) -> Option<ArrayVec<FeaturePoint, 3>> {
        corners.iter().map(|corner| self.corner_point(*corner, dir)).collect()
    }
}

struct System<'p, 's, A: ?Sized, B: ?Sized> {
    a: &'p Placed<'s, A>,
    b: &'p Placed<'s, B>,
    corners: (Corners, Corners),
    condition: Condition,
}

/// The features at one normal.
struct State {
    /// From the first feature of A to the first feature of B.
    base: DVec3,
    firsts: [DVec3; 2],
    /// How the difference of the points moves with the places: first places on A, then on B.
    directions: ArrayVec<DVec3, 4>,
    curvature: DMat3,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> System<'_, '_, A, B> {
    fn count_a(&self) -> usize {
        self.corners.0.len() - 1
    }

    /// The features along `normal`, with these weights of all but the first.
    fn state(&self, normal: DVec3, places: DVec4) -> Option<State> {
        let a = self.a.corner_points(&self.corners.0, normal)?;
        let b = self.b.corner_points(&self.corners.1, -normal)?;
        let mut directions = ArrayVec::new();
        let (mut curvature, mut at) = (DMat3::ZERO, 0);
        for (points, sign) in [(&a, -1.0), (&b, 1.0)] {
            let (first, others) = points.split_first()?;
            let mut rest = 1.0;
            for other in others {
                directions.push((other.point - first.point) * sign);
                curvature += other.derivative * places[at];
                rest -= places[at];
                at += 1;
            }
            curvature += first.derivative * rest;
        }
        let firsts = [a.first()?.point, b.first()?.point];
        Some(State { base: firsts[1] - firsts[0], firsts, directions, curvature })
    }

    /// Where the points of an answer are on lines of features.
    fn places(&self, near: &Refined, radii: [f64; 2]) -> Option<DVec4> {
        let state = self.state(near.normal, DVec4::ZERO)?;
        let mut places = DVec4::ZERO;
        if let [only] = state.directions[..] {
            let own = if self.count_a() == 1 { 0 } else { 1 };
            let sign = [-1.0, 1.0][own];
            let core = near.points[own] - near.normal * (-sign * radii[own]);
            places.x = ((core - state.firsts[own]).dot(only) * sign / only.length_squared()).clamp(0.0, 1.0);
        } else if let ([p, q], 1) = (&state.directions[..], self.count_a()) {
            for (at, own, along) in [(0, 0, p), (1, 1, q)] {
                let sign = [-1.0, 1.0][own];
                let core = near.points[own] - near.normal * (-sign * radii[own]);
                places[at] = ((core - state.firsts[own]).dot(*along) * sign / along.length_squared()).clamp(0.0, 1.0);
            }
        }
        Some(places)
    }

    /// Step 2.
    fn solve(&self, near: Refined) -> Option<Refined> {
        let radii = [self.a.shape.convex_radius(), self.b.shape.convex_radius()];
        // Three directions are dependent: there are many pairs of points.
        if self.count_a() + self.corners.1.len() - 1 > 2 {
            return None;
        }
        let (mut normal, mut places) = (near.normal, self.places(&near, radii)?);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let state = self.state(normal, places)?;
            let (turn, moved) = self.step(&state, normal, places, radii[0] + radii[1]);
            (normal, places) = (unit(normal + turn)?, places + moved);
            let step = turn.length();
            // NaN takes the failing branch.
            if !(step < GREATEST_TILT) {
                return None;
            }
            // From here on, steps are rounding error.
            if last <= LAST_STEP || step == 0.0 {
                return self.accept(normal, places, radii, &near);
            }
            last = step;
        }
        None
    }

    /// One step of Newton's method: how the normal turns, and how the places move.
    fn step(&self, state: &State, normal: DVec3, places: DVec4, radius: f64) -> (DVec3, DVec4) {
        let pair = |n: DVec3| [perpendicular(n), n.cross(perpendicular(n))];
        let across = pair(normal);
        let between = state.directions.iter().zip(places.to_array()).fold(state.base, |sum, (d, s)| sum + *d * s);
        let (rows, along, rest) = match self.condition {
            Condition::Along(_) => (across, normal.dot(between), between),
            Condition::Meeting(direction) => (pair(direction), radius, between - normal * radius),
        };
        let direction = |at: usize| state.directions.get(at).copied();
        let (mut columns, mut right) = ([DVec4::ZERO; 4], DVec4::ZERO);
        for (row, axis) in rows.into_iter().enumerate() {
            right[row] = -axis.dot(rest);
            for (column, side) in across.into_iter().enumerate() {
                columns[column][row] = -axis.dot(state.curvature * side + side * along);
            }
            for at in 0..2 {
                columns[2 + at][row] = direction(at).map_or(0.0, |direction| axis.dot(direction));
            }
        }
        for at in 0..2 {
            let Some(direction) = direction(at) else {
                columns[2 + at][2 + at] = 1.0;
                continue;
            };
            right[2 + at] = -normal.dot(direction);
            for (column, side) in across.into_iter().enumerate() {
                columns[column][2 + at] = direction.dot(side);
            }
        }
        let found = DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]).inverse() * right;
        (across[0] * found.x + across[1] * found.y, DVec4::new(found.z, found.w, 0.0, 0.0))
    }

    /// Step 3.
    fn accept(&self, normal: DVec3, places: DVec4, radii: [f64; 2], near: &Refined) -> Option<Refined> {
        let state = self.state(normal, places)?;
        let mut cores = state.firsts;
        for (at, (direction, place)) in state.directions.iter().zip(places.to_array()).enumerate() {
            let own = usize::from(at >= self.count_a());
            cores[own] += *direction * (place * [-1.0, 1.0][own]);
            // A face has more corners than three.
            let is_line = [self.count_a(), self.corners.1.len() - 1][own] == 1;
            if is_line && !(-BEYOND..=1.0 + BEYOND).contains(&place) {
                return None;
            }
        }
        let (a, b) = (self.a, self.b);
        if self.count_a() == 2 || self.corners.1.len() == 3 {
            let tilt = tilt(0.0);
            let (a, b) = (Placed { tilt, ..*a }, Placed { tilt, ..*b });
            if !is_inside_face(&a, &b, normal, cores) {
                return None;
            }
        }
        let lengths = [cores[0].length(), cores[1].length(), a.shape.core_radii()[1], b.shape.core_radii()[1]];
        let shortfall = a.shape.support_error() + b.shape.support_error();
        let slack = ROUNDINGS * f64::EPSILON * lengths.iter().sum::<f64>() + shortfall;
        let is_farthest = (a.support(normal) - state.firsts[0]).dot(normal) <= slack
            && (state.firsts[1] - b.support(-normal)).dot(normal) <= slack;
        let between = cores[1] - cores[0];
        let is_met = match self.condition {
            Condition::Along([lower, upper]) => {
                let length = normal.dot(between);
                lower - slack <= length && length <= upper + slack
            }
            Condition::Meeting(_) => normal.distance(near.normal) <= GREATEST_TILT,
        };
        let points = [cores[0] + normal * radii[0], cores[1] - normal * radii[1]];
        (is_farthest && is_met).then_some(Refined { normal, points })
    }
}
