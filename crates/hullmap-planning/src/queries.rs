//! Queries of a convex body of a link and anything that it may touch: another body, or an obstacle.

use glam::{DQuat, DVec3};
use hullmap::cascade::{self, Stages};
use hullmap::compound::{self, SharedSheet};
use hullmap::shapes::{Cuboid, HalfSpace};
use hullmap::{Cache, Compound, CompoundCache, Contact, Derivatives, Distance, Overlap, Pack, Pose, Settings, Status};

use crate::convex::{AnyShape, Convex};
use crate::obstacle::ObstacleShape;

const MAX_PARTS: usize = 16;

const MAX_PAIRS: usize = 32;

/// The other side of a query of a body.
#[derive(Clone, Copy)]
pub(crate) enum Other<'o> {
    Convex(&'o Convex),
    Compound(&'o Pack),
    Sheet(&'o SharedSheet),
    HalfSpace(&'o HalfSpace),
}

impl<'o> From<&'o ObstacleShape> for Other<'o> {
    fn from(shape: &'o ObstacleShape) -> Self {
        match shape {
            ObstacleShape::Convex(convex) => Self::Convex(convex),
            ObstacleShape::Compound(pack) => Self::Compound(pack),
            ObstacleShape::Sheet(sheet) => Self::Sheet(sheet),
            ObstacleShape::HalfSpace(plane) => Self::HalfSpace(plane),
        }
    }
}

pub(crate) struct Caches {
    convex: CompoundCache,
    parts: Vec<(usize, CompoundCache)>,
}

impl Caches {
    pub(crate) fn new(pairs: usize) -> Self {
        Self { convex: CompoundCache::new(pairs), parts: Vec::new() }
    }

    fn convex(&mut self, pair: usize) -> &mut Cache {
        self.convex.pair([0, pair])
    }

    fn parts(&mut self, pair: usize) -> &mut CompoundCache {
        let place = pair % MAX_PAIRS;
        while self.parts.len() <= place {
            self.parts.push((usize::MAX, CompoundCache::new(MAX_PARTS)));
        }
        let (own, cache) = &mut self.parts[place];
        if *own != pair {
            *own = pair;
            cache.clear();
        }
        cache
    }
}

pub(crate) struct Pairing<'q> {
    pub(crate) index: usize,
    pub(crate) a: Other<'q>,
    pub(crate) b: &'q Convex,
    /// `None` if the bodies are so far from each other that no pose is in range.
    pub(crate) b_in_a: Option<Pose>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Found<T> {
    pub(crate) answer: T,
    pub(crate) part: usize,
}

impl<T> From<compound::CompoundAnswer<T>> for Found<T> {
    fn from(found: compound::CompoundAnswer<T>) -> Self {
        Self { answer: found.answer, part: found.hulls[0] }
    }
}

const UNKNOWN: Distance = Distance {
    status: Status::Stalled,
    distance: 0.0,
    lower: 0.0,
    upper: f64::INFINITY,
    normal: DVec3::X,
    point_a: DVec3::ZERO,
    point_b: DVec3::ZERO,
    iterations: 0,
    support_calls: 0,
    features: [u32::MAX; 2],
};

impl Pairing<'_> {
    pub(crate) fn overlap(&self, caches: &mut Caches) -> Overlap {
        let Some(b_in_a) = self.b_in_a else { return Overlap::Undecided };
        let found = match (self.a, self.b) {
            (Other::Convex(Convex::Hull(a)), Convex::Hull(b)) => {
                let cache = caches.convex(self.index);
                cascade::intersects(a.hull(), b.hull(), b_in_a, Stages::default(), cache).intersection
            }
            (Other::Convex(a), b) => hullmap::intersects(a.shape(), b.shape(), b_in_a, caches.convex(self.index)),
            (Other::Compound(a), b) => {
                compound::intersects(&Compound::new(a), b.shape(), b_in_a, caches.parts(self.index)).answer
            }
            (Other::Sheet(a), b) => compound::intersects(a, b.shape(), b_in_a, caches.parts(self.index)).answer,
            (Other::HalfSpace(a), b) => a.intersects(b.shape(), b_in_a),
        };
        found.status
    }

    pub(crate) fn distance(&self, settings: &Settings, caches: &mut Caches) -> Found<Distance> {
        let Some(b_in_a) = self.b_in_a else { return Found { answer: UNKNOWN, part: 0 } };
        let alone = |answer| Found { answer, part: 0 };
        match (self.a, self.b) {
            (Other::Convex(Convex::Hull(a)), Convex::Hull(b)) => {
                alone(hullmap::distance(a.hull(), b.hull(), b_in_a, settings, caches.convex(self.index)))
            }
            (Other::Convex(a), b) => {
                alone(hullmap::distance(a.shape(), b.shape(), b_in_a, settings, caches.convex(self.index)))
            }
            (Other::Compound(a), b) => {
                compound::distance(&Compound::new(a), b.shape(), b_in_a, settings, caches.parts(self.index)).into()
            }
            (Other::Sheet(a), b) => compound::distance(a, b.shape(), b_in_a, settings, caches.parts(self.index)).into(),
            (Other::HalfSpace(a), b) => alone(a.distance(b.shape(), b_in_a)),
        }
    }

    pub(crate) fn contact(&self, settings: &Settings, caches: &mut Caches) -> Found<Contact> {
        let alone = |answer| Found { answer, part: 0 };
        let Some(b_in_a) = self.b_in_a else { return alone(Contact::default()) };
        let apart = alone(Contact { hit: false, status: Status::Separated, depth_upper: 0.0, ..Contact::default() });
        match (self.a, self.b) {
            (Other::Convex(Convex::Hull(a)), Convex::Hull(b)) => {
                alone(hullmap::contact(a.hull(), b.hull(), b_in_a, settings, caches.convex(self.index)))
            }
            (Other::Convex(a), b) => {
                alone(hullmap::contact(a.shape(), b.shape(), b_in_a, settings, caches.convex(self.index)))
            }
            (Other::Compound(a), b) => {
                let found = compound::contact(&Compound::new(a), b.shape(), b_in_a, settings, caches.parts(self.index));
                found.map_or(apart, Found::from)
            }
            (Other::Sheet(a), b) => {
                let found = compound::contact(a, b.shape(), b_in_a, settings, caches.parts(self.index));
                found.map_or(apart, Found::from)
            }
            (Other::HalfSpace(a), b) => alone(a.contact(b.shape(), b_in_a)),
        }
    }

    pub(crate) fn distance_derivatives(&self, found: &Found<Distance>) -> Option<Derivatives> {
        let b_in_a = self.b_in_a?;
        let (own, b) = (&found.answer, self.b.shape());
        Some(match self.a {
            Other::Convex(a) => own.derivatives(a.shape(), b, b_in_a),
            Other::Compound(a) => own.derivatives(&a.hull(found.part).ok()?, b, b_in_a),
            Other::Sheet(a) => own.derivatives(&a.triangle(found.part)?, b, b_in_a),
            Other::HalfSpace(_) => on_face(own.normal, own.point_a, b, b_in_a, |a, b, b_in_a| {
                let local =
                    Distance { normal: DVec3::Z, point_a: DVec3::ZERO, point_b: DVec3::Z * own.distance, ..*own };
                local.derivatives(a, b, b_in_a)
            })?,
        })
    }

    pub(crate) fn contact_derivatives(
        &self,
        found: &Found<Contact>,
        settings: &Settings,
        caches: &mut Caches,
    ) -> Option<Derivatives> {
        let b_in_a = self.b_in_a?;
        let (own, b, mut cache) = (&found.answer, self.b.shape(), Cache::new());
        Some(match self.a {
            Other::Convex(a) => own.derivatives(a.shape(), b, b_in_a, settings, caches.convex(self.index)),
            Other::Compound(a) => own.derivatives(&a.hull(found.part).ok()?, b, b_in_a, settings, &mut cache),
            Other::Sheet(a) => own.derivatives(&a.triangle(found.part)?, b, b_in_a, settings, &mut cache),
            Other::HalfSpace(_) => {
                // The depth in a half-space is smooth across the plane: the negative distance of
                // the lowest point, as for a plane that is just below it.
                let below = Distance {
                    status: Status::Exact,
                    distance: 1.0,
                    lower: 1.0,
                    upper: 1.0,
                    normal: DVec3::Z,
                    point_a: DVec3::ZERO,
                    point_b: DVec3::Z,
                    ..UNKNOWN
                };
                let found = on_face(own.normal, own.point_b - own.normal, b, b_in_a, |a, b, pose| {
                    below.derivatives(a, b, pose)
                })?;
                Derivatives { of_a: negative(found.of_a), of_b: negative(found.of_b), ..found }
            }
        })
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
