//! Queries of a convex body of a link and anything that it may touch: another body, or an obstacle.

use glam::{DQuat, DVec3};
use hullmap::geometry::{Geometry, Visitor};
use hullmap::shapes::{Cuboid, HalfSpace};
use hullmap::{Cache, Contact, Derivatives, Distance, Overlap, Pose, Settings, SharedGeometry, Status};

use crate::convex::{AnyShape, Convex};

const MAX_PARTS: usize = 16;

const MAX_PAIRS: usize = 32;

/// The other side of a query of a body.
#[derive(Clone, Copy)]
pub(crate) enum Other<'o> {
    Body(&'o Convex),
    Obstacle(&'o SharedGeometry),
}

impl Geometry for Other<'_> {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Body(body) => body.visit(visitor),
            Self::Obstacle(obstacle) => obstacle.visit(visitor),
        }
    }
}

impl<'o> Other<'o> {
    fn half_space(self) -> Option<&'o HalfSpace> {
        match self {
            Self::Obstacle(SharedGeometry::HalfSpace(half_space)) => Some(half_space),
            _ => None,
        }
    }

    /// The convex part that decided an answer.
    fn with_part<T>(self, part: u32, run: impl FnOnce(&dyn hullmap::Shape) -> T) -> Option<T> {
        match self {
            Self::Body(body) => Some(run(body.shape())),
            Self::Obstacle(obstacle) => obstacle.with_part(part, run),
        }
    }
}

pub(crate) struct Caches {
    /// Caches of pairs of convex shapes.
    shapes: Vec<(usize, Cache)>,
    parts: Vec<(usize, Cache)>,
}

impl Caches {
    pub(crate) fn new(pairs: usize) -> Self {
        Self { shapes: vec![(usize::MAX, Cache::new()); pairs.max(1)], parts: Vec::new() }
    }

    fn of(&mut self, pair: &Pairing<'_>) -> &mut Cache {
        let place = if matches!(pair.a, Other::Obstacle(obstacle) if obstacle.has_parts()) {
            let place = pair.index % MAX_PAIRS;
            while self.parts.len() <= place {
                self.parts.push((usize::MAX, Cache::with_pairs(MAX_PARTS)));
            }
            &mut self.parts[place]
        } else {
            let place = pair.index % self.shapes.len();
            &mut self.shapes[place]
        };
        if place.0 != pair.index {
            place.0 = pair.index;
            place.1.clear();
        }
        &mut place.1
    }
}

pub(crate) struct Pairing<'q> {
    pub(crate) index: usize,
    pub(crate) a: Other<'q>,
    pub(crate) b: &'q Convex,
    /// `None` if the bodies are so far from each other that no pose is in range.
    pub(crate) b_in_a: Option<Pose>,
}

impl Pairing<'_> {
    pub(crate) fn overlap(&self, caches: &mut Caches) -> Overlap {
        let Some(b_in_a) = self.b_in_a else { return Overlap::Undecided };
        hullmap::intersects(&self.a, self.b, b_in_a, caches.of(self)).status
    }

    pub(crate) fn distance(&self, settings: &Settings, caches: &mut Caches) -> Distance {
        // A distance without information.
        let Some(b_in_a) = self.b_in_a else { return Distance { status: Status::Stalled, ..Distance::default() } };
        hullmap::distance(&self.a, self.b, b_in_a, settings, caches.of(self))
    }

    pub(crate) fn contact(&self, settings: &Settings, caches: &mut Caches) -> Contact {
        // A contact without information.
        let Some(b_in_a) = self.b_in_a else { return Contact::default() };
        hullmap::contact(&self.a, self.b, b_in_a, settings, caches.of(self))
    }

    /// Derivatives of a distance in A's frame. `None` if there is no such pair.
    pub(crate) fn distance_derivatives(&self, found: &Distance) -> Option<Derivatives> {
        let (b_in_a, b) = (self.b_in_a?, self.b.shape());
        if self.a.half_space().is_some() {
            return on_face(found.normal, found.point_a, b, b_in_a, |a, b, b_in_a| {
                let local =
                    Distance { normal: DVec3::Z, point_a: DVec3::ZERO, point_b: DVec3::Z * found.distance, ..*found };
                local.derivatives(a, b, b_in_a)
            });
        }
        self.a.with_part(found.parts[0], |a| found.derivatives(a, b, b_in_a))
    }

    pub(crate) fn contact_derivatives(
        &self,
        found: &Contact,
        settings: &Settings,
        caches: &mut Caches,
    ) -> Option<Derivatives> {
        let (b_in_a, b) = (self.b_in_a?, self.b.shape());
        if self.a.half_space().is_some() {
            // The depth in a half-space is smooth across the plane: the negative distance of the
            // lowest point, as for a plane that is just below it.
            let below = Distance {
                status: Status::Exact,
                distance: 1.0,
                lower: 1.0,
                upper: 1.0,
                normal: DVec3::Z,
                point_b: DVec3::Z,
                ..Distance::default()
            };
            let found = on_face(found.normal, found.point_b - found.normal, b, b_in_a, |a, b, pose| {
                below.derivatives(a, b, pose)
            })?;
            return Some(Derivatives { by_a: negative(found.by_a), by_b: negative(found.by_b), ..found });
        }
        let cache = caches.of(self);
        self.a.with_part(found.parts[0], |a| found.derivatives(a, b, b_in_a, settings, cache))
    }
}

fn negative(derivative: hullmap::PoseDerivative) -> hullmap::PoseDerivative {
    hullmap::PoseDerivative { linear: -derivative.linear, angular: -derivative.angular }
}

/// Derivatives for a plane with this normal through `foot`, the foot of the lowest point of `b`, by
/// the face of a box there: a half-space has no support mapping. Derivatives by the pose of A are
/// about the foot; obstacles do not move.
fn on_face(
    normal: DVec3,
    foot: DVec3,
    b: &AnyShape,
    b_in_a: Pose,
    derivatives: impl FnOnce(&Cuboid, &AnyShape, Pose) -> Derivatives,
) -> Option<Derivatives> {
    let size = b.outer_radius().max(f64::MIN_POSITIVE);
    let cuboid = Cuboid::new(DVec3::splat(size)).ok()?;
    // The origin of this frame is the foot, and z is the normal. The box is below.
    let face = Pose::new(foot, DQuat::from_rotation_arc(DVec3::Z, normal)).ok()?;
    let b_in_face = Pose::relative(face, b_in_a).ok()?;
    Some(derivatives(&cuboid, b, b_in_face).in_world(face))
}
