//! Derivatives of the normal and of the witness points, in closed form.
//!
//! The cores face each other with a vertex, an edge or a face each, and the line between the points
//! of the cores is perpendicular to both.
//!
//! # Steps
//! 1. Two directions perpendicular to the normal: along edges, or in the plane of a face. They
//!    belong to the shape whose feature they are on. The remaining ones belong to the gap.
//! 2. A direction of a feature stays perpendicular to the normal, so along it, the normal turns
//!    with that shape. Along a direction of the gap, the normal turns as one point moves against
//!    the other, divided by the gap.
//! 3. Along the directions of its feature, a point slides until the line is perpendicular again.
//! 4. Points of the shapes are one convex radius away from the points of the cores, along the
//!    normal.
//!
//! docs/contributors/intervals.md, section 16.

use glam::DVec3;

use super::pose_derivative::{Derivatives, Differentiability};
use super::witness::{Facing, facing_features, normal_error};
use crate::pose::Pose;
use crate::solver::ray::Dot;
use crate::solver::{Cache, Contact, Distance, Settings, SignedDistance};
use crate::support::SupportMap;
use crate::vector::perpendicular;

/// Derivatives of the normal and the witness points by one pose: a row for each coordinate, and in
/// it a column for each number of the twist, as in [`PoseDerivative`](crate::PoseDerivative).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WitnessJacobian {
    /// Rows of the normal: per unit of length, and per radian.
    pub normal: [[f64; 6]; 3],
    /// Rows of the point of A: lengths per unit of length, and per radian.
    pub point_a: [[f64; 6]; 3],
    /// Rows of the point of B.
    pub point_b: [[f64; 6]; 3],
}

/// Derivatives of the normal and the witness points of an answer, in its frame, by the poses of A
/// and of B.
///
/// All numbers are 0 unless the status is [`Unique`](Differentiability::Unique).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WitnessDerivatives {
    /// Whether these are derivatives, or why there are none.
    pub status: Differentiability,
    /// By the pose of A.
    pub by_a: WitnessJacobian,
    /// By the pose of B, or of the point.
    pub by_b: WitnessJacobian,
}

impl WitnessDerivatives {
    fn none(status: Differentiability) -> Self {
        Self { status, by_a: WitnessJacobian::default(), by_b: WitnessJacobian::default() }
    }
}

/// Owner of a direction across the normal.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    A,
    B,
    Gap,
}

/// How normal and points move.
struct Moved {
    normal: DVec3,
    point_a: DVec3,
    point_b: DVec3,
}

/// An answer about two cores that face each other.
struct Facings {
    normal: DVec3,
    /// Points of the cores.
    points: [DVec3; 2],
    radii: [f64; 2],
    /// From the point of A's core to the point of B's core, along the normal; negative if they
    /// overlap.
    gap: f64,
    /// Two directions across the normal, and two that have a product of 1 with one of them and 0
    /// with the other.
    directions: [(DVec3, Owner, DVec3); 2],
}

impl Facings {
    fn new(normal: DVec3, points: [DVec3; 2], radii: [f64; 2], facing: [Facing; 2]) -> Option<Self> {
        let x = perpendicular(normal);
        let [(p, of_p), (q, of_q)] = match facing {
            [Facing::Face, Facing::Vertex] => [(x, Owner::A), (normal.cross(x), Owner::A)],
            [Facing::Vertex, Facing::Face] => [(x, Owner::B), (normal.cross(x), Owner::B)],
            [Facing::Vertex, Facing::Vertex] => [(x, Owner::Gap), (normal.cross(x), Owner::Gap)],
            [Facing::Edge(a), Facing::Edge(b)] => [(a, Owner::A), (b, Owner::B)],
            [Facing::Edge(a), Facing::Vertex] => [(a, Owner::A), (normal.cross(a), Owner::Gap)],
            [Facing::Vertex, Facing::Edge(b)] => [(b, Owner::B), (normal.cross(b), Owner::Gap)],
            _ => return None,
        };
        let dual = |p: DVec3, q: DVec3| {
            let across = q.cross(normal);
            across / p.dot(across)
        };
        let gap = normal.dot(points[1] - points[0]);
        // The depth of two cores is along the normal of a face of their difference.
        // NaN takes the failing branch.
        let is_possible = gap > 0.0 || (gap < 0.0 && of_p != Owner::Gap && of_q != Owner::Gap);
        is_possible.then(|| Self {
            normal,
            points,
            radii,
            gap,
            directions: [(p, of_p, dual(p, q)), (q, of_q, dual(q, p))],
        })
    }

    /// How normal and points move, where the shapes turn by these rotation vectors, and their
    /// points of the cores have these velocities.
    fn moved(&self, turns: [DVec3; 2], velocities: [DVec3; 2]) -> Moved {
        let apart = velocities[1] - velocities[0];
        let turned = self.directions.into_iter().map(|(along, owner, dual)| match owner {
            Owner::A => dual * along.dot(turns[0].cross(self.normal)),
            Owner::B => dual * along.dot(turns[1].cross(self.normal)),
            Owner::Gap => dual * (along.dot(apart) / self.gap),
        });
        let normal: DVec3 = turned.sum();
        // The points of the features move by this more than with their shapes.
        let rest = self.normal * self.normal.dot(apart) + normal * self.gap - apart;
        let [mut point_a, mut point_b] = velocities;
        for (along, owner, dual) in self.directions {
            match owner {
                Owner::A => point_a -= along * dual.dot(rest),
                Owner::B => point_b += along * dual.dot(rest),
                Owner::Gap => {}
            }
        }
        Moved { normal, point_a: point_a + normal * self.radii[0], point_b: point_b - normal * self.radii[1] }
    }

    /// The derivatives by the pose of A, or of B, whose frame has its origin at `origin`.
    fn jacobian(&self, is_a: bool, origin: DVec3) -> WitnessJacobian {
        let alone = |v: DVec3| if is_a { [v, DVec3::ZERO] } else { [DVec3::ZERO, v] };
        let point = if is_a { self.points[0] } else { self.points[1] };
        let translated = |v: DVec3| self.moved([DVec3::ZERO; 2], alone(v));
        let turned = |w: DVec3| self.moved(alone(w), alone(w.cross(point - origin)));
        let ([a, b, c], [d, e, f]) = (DVec3::AXES.map(translated), DVec3::AXES.map(turned));
        let columns = [a, b, c, d, e, f];
        let rows = |of: fn(&Moved) -> DVec3| {
            let vectors = columns.each_ref().map(of);
            [vectors.map(|v| v.x), vectors.map(|v| v.y), vectors.map(|v| v.z)]
        };
        WitnessJacobian {
            normal: rows(|moved| moved.normal),
            point_a: rows(|moved| moved.point_a),
            point_b: rows(|moved| moved.point_b),
        }
    }
}

/// Derivatives of the normal and of these points of A and of B, for a pair whose distance or depth
/// has these `derivatives`. The distance of the shapes is within `distance`; it is negative if they
/// overlap.
fn of_points<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    (normal, [point_a, point_b]): (DVec3, [DVec3; 2]),
    distance: [f64; 2],
    derivatives: Derivatives,
) -> WitnessDerivatives {
    if derivatives.status != Differentiability::Unique {
        return WitnessDerivatives::none(derivatives.status);
    }
    let radii = [a.convex_radius(), b.convex_radius()];
    let between_cores = distance.map(|bound| bound + radii[0] + radii[1]);
    let error = match between_cores {
        [lower, _] if lower > 0.0 => normal_error(between_cores),
        [_, upper] if upper < 0.0 => 0.0,
        _ => return WitnessDerivatives::none(Differentiability::Touching),
    };
    let points = [point_a - normal * radii[0], point_b + normal * radii[1]];
    let facing = match facing_features((a, b, b_in_a), normal, points, error) {
        Ok(facing) => facing,
        Err(reason) => return WitnessDerivatives::none(reason),
    };
    let Some(found) = Facings::new(normal, points, radii, facing) else {
        return WitnessDerivatives::none(Differentiability::Feature);
    };
    WitnessDerivatives {
        status: Differentiability::Unique,
        by_a: found.jacobian(true, DVec3::ZERO),
        by_b: found.jacobian(false, b_in_a.translation()),
    }
}

impl Distance {
    /// Derivatives of the normal and of both points by the poses of `a` and of `b`, which is at
    /// `b_in_a`: of the shapes of this answer. In A's frame.
    ///
    /// They exist where the distance has a derivative, and the same vertices, edges or faces are
    /// nearest for all poses nearby: [`Feature`](Differentiability::Feature) says where they
    /// change, and [`Curved`](Differentiability::Curved) where there are none.
    ///
    /// # Complexity
    /// The cost of [`derivatives`](Self::derivatives), and up to 22 support queries. No allocation.
    pub fn witness_derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
    ) -> WitnessDerivatives {
        let points = (self.normal, [self.point_a, self.point_b]);
        of_points((a, b, b_in_a), points, [self.lower, self.upper], self.derivatives(a, b, b_in_a))
    }
}

impl Contact {
    /// Derivatives of the normal and of both points by the poses of `a` and of `b`, which is at
    /// `b_in_a`: of the shapes of this answer. In A's frame. As for
    /// [`Distance::witness_derivatives`]; the other arguments are the same as for
    /// [`derivatives`](Self::derivatives).
    ///
    /// # Complexity
    /// The cost of [`derivatives`](Self::derivatives), and up to 22 support queries. No allocation.
    pub fn witness_derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> WitnessDerivatives {
        let points = (self.normal, [self.point_a, self.point_b]);
        let of_depth = self.derivatives(a, b, b_in_a, settings, cache);
        of_points((a, b, b_in_a), points, [-self.depth_upper, -self.depth_lower], of_depth)
    }
}

impl SignedDistance {
    /// Derivatives of the normal and of the closest point by the pose of `shape`, and by the
    /// position of `point`: of the shape and the point of this answer. In the shape's frame.
    /// `point_b` is `point` itself. As for [`Distance::witness_derivatives`].
    ///
    /// # Complexity
    /// The cost of [`derivatives`](Self::derivatives), and up to 15 support queries. No allocation.
    pub fn witness_derivatives<S: SupportMap + ?Sized>(
        &self,
        shape: &S,
        point: DVec3,
        settings: &Settings,
        cache: &mut Cache,
    ) -> WitnessDerivatives {
        let by = self.derivatives(shape, point, settings, cache);
        let points = (self.normal, [self.point, point]);
        of_points((shape, &Dot, Pose::from_checked(point)), points, [self.lower, self.upper], by)
    }
}
