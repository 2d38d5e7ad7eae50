//! Casts of shapes that move and turn, by hullmap's [`cast_motion`](hullmap::cast_motion()).
//!
//! # Steps
//! 1. Search each pair of pieces, and the pieces on each tile of a surface, for the first meeting.
//!    The time is the lower end of the proven interval.
//! 2. A pair that meets at the start is a hit if the caller stops at penetrations. Otherwise,
//!    parry's rule decides whether the shapes would pass through each other, and when. In any case,
//!    the cast ends when the core of one, the shape scaled about its middle, meets the other: so no
//!    body gets to the other side. On a surface, this is done for each triangle near the path.
//!
//! # Deviations
//! parry advances along one direction until the separation there is zero, and ends at a miss if a
//! bisection converges to the end: it misses grazing contacts, and contacts of shapes that turn
//! far.

use hullmap::glam::DVec3;
use hullmap::shapes::{HalfSpace, Scaled};
use hullmap::{Cache, MotionSettings, RigidMotion, Settings, Shape as Convex, Status, TimeOfImpact};

use super::super::convert::{double, narrow, narrow_pose, real, wide, wide_pose};
use super::super::parry;
use super::super::parry::math::Real;
use super::super::parry::query::details as default;
use super::super::parry::query::details::NonlinearShapeCastMode;
use super::super::parry::query::{NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastStatus};
use super::super::parry::shape::Shape;
use super::super::surface::{BakedSurface, SurfaceTile};
use super::nearby::{Ball, first_hit};
use super::pieces::{Piece, pieces};

/// A meeting before this time counts as one at the start, as in parry. In the unit of the motions.
const AT_START: f64 = 1e-5;

/// Scales of the cores of a body. The first that does not meet the other body at the start counts.
const CORES: [f64; 2] = [0.9, 0.5];

/// Maximum number of distance queries of a tile and a piece, for all triangles and boxes together.
const SURFACE_QUERIES: u32 = 4_000;

/// Number of balls that cover the path of a body on a surface.
const BALLS: u32 = 16;

/// Allowance for rounding when the path lengths of two pieces are compared, relative to them.
const SLACK: f64 = 1e-9;

enum MovingBody<'s> {
    Pieces(Vec<Piece<'s>>),
    Surface(&'s BakedSurface),
    Plane(HalfSpace),
}

impl<'s> MovingBody<'s> {
    /// `None` for a shape that hullmap does not solve.
    fn from_shape(shape: &'s dyn Shape) -> Option<Self> {
        if let Some(surface) = shape.as_shape::<BakedSurface>() {
            return Some(Self::Surface(surface));
        }
        if let Some(plane) = shape.as_shape::<parry::shape::HalfSpace>() {
            return Some(Self::Plane(HalfSpace::new(wide(plane.normal), 0.0).ok()?));
        }
        pieces(shape).map(Self::Pieces)
    }
}

/// The first meeting of two bodies in a window of parry's time. The outer `None` is for unsolved
/// pairs and invalid numbers, the inner one for a miss. parry's rule queries `dispatcher`.
pub(super) fn cast(
    dispatcher: &dyn QueryDispatcher,
    [(shape1, motion1), (shape2, motion2)]: [(&dyn Shape, &NonlinearRigidMotion); 2],
    window: [Real; 2],
    stop_at_penetration: bool,
) -> Option<Option<ShapeCastHit>> {
    let new = |motions| Cast::new(dispatcher, motions, window, stop_at_penetration);
    let swapped = |found: Option<ShapeCastHit>| found.map(ShapeCastHit::swapped);
    let (in_order, flipped) = ([motion1, motion2], [motion2, motion1]);
    match (MovingBody::from_shape(shape1)?, MovingBody::from_shape(shape2)?) {
        (MovingBody::Pieces(a), MovingBody::Pieces(b)) => new(in_order)?.of_pieces(&a, &b),
        (MovingBody::Surface(a), MovingBody::Pieces(b)) => new(in_order)?.of_surface(a, &b),
        (MovingBody::Plane(a), MovingBody::Pieces(b)) => new(in_order)?.of_plane(&a, &b),
        (MovingBody::Pieces(b), MovingBody::Surface(a)) => new(flipped)?.of_surface(a, &b).map(swapped),
        (MovingBody::Pieces(b), MovingBody::Plane(a)) => new(flipped)?.of_plane(&a, &b).map(swapped),
        _ => None,
    }
}

struct Cast<'m> {
    dispatcher: &'m dyn QueryDispatcher,
    of_parry: [&'m NonlinearRigidMotion; 2],
    /// The motions in the window, over the times 0 to 1.
    motions: [Windowed; 2],
    window: [f64; 2],
    stop_at_penetration: bool,
}

#[derive(Clone, Copy)]
struct Windowed {
    /// The pose at the start of the window.
    start: hullmap::Pose,
    linear: DVec3,
    angular: DVec3,
    /// The point about which the body turns, at the start.
    center: DVec3,
}

impl Windowed {
    fn new(motion: &NonlinearRigidMotion, [start_time, end_time]: [f64; 2]) -> Option<Self> {
        let start = wide_pose(&motion.start)?;
        let center = start.transform_point(wide(motion.local_center));
        let (linear, angular) = (wide(motion.linvel), wide(motion.angvel));
        let (at, length) = (start_time, end_time - start_time);
        let before = RigidMotion::screw(start, linear * at, angular * at, center).ok()?;
        let start = if at == 0.0 { start } else { before.pose_at(1.0) };
        Some(Self { start, linear: linear * length, angular: angular * length, center: center + linear * at })
    }

    /// The motion of a piece of the body, which is at `place` in it.
    fn piece_motion(&self, place: hullmap::Pose) -> Option<RigidMotion> {
        RigidMotion::screw(self.start.compose(place).ok()?, self.linear, self.angular, self.center).ok()
    }

    /// Upper bound of the path length of a point, from positions of it and the rotation's centre.
    fn way(&self, point: DVec3, center: DVec3) -> f64 {
        self.linear.length() + self.angular.length() * point.distance(center)
    }

    /// A ball that contains a ball of the body around `point` during a share of the motion around
    /// the time `t`: its centre, and by how much it is larger.
    fn ball(&self, motion: &RigidMotion, point: DVec3, [start, end]: [f64; 2]) -> (DVec3, f64) {
        let middle = 0.5 * (start + end);
        let place = motion.pose_at(middle).transform_point(point);
        (place, 0.5 * (end - start) * self.way(place, self.center + self.linear * middle))
    }
}

struct Mover<'p> {
    shape: &'p dyn Convex,
    of_parry: &'p dyn Shape,
    /// parry's motion of the shape, and its pose in the body.
    motion_of_parry: NonlinearRigidMotion,
    pose: parry::math::Pose,
    /// The pose and the motion in f64.
    place: hullmap::Pose,
    motion: RigidMotion,
    subshape: u32,
}

impl<'m> Cast<'m> {
    fn new(
        dispatcher: &'m dyn QueryDispatcher,
        of_parry: [&'m NonlinearRigidMotion; 2],
        window: [Real; 2],
        stop_at_penetration: bool,
    ) -> Option<Self> {
        let window = window.map(double);
        // NaN takes the failing branch.
        if !(window[0] <= window[1]) {
            return None;
        }
        let motions = [Windowed::new(of_parry[0], window)?, Windowed::new(of_parry[1], window)?];
        Some(Self { dispatcher, of_parry, motions, window, stop_at_penetration })
    }

    fn mover<'p>(&self, side: usize, piece: &'p Piece<'p>) -> Option<Mover<'p>> {
        let (windowed, of_parry) = (self.motions.get(side)?, self.of_parry.get(side)?);
        Some(Mover {
            shape: piece.shape(),
            of_parry: piece.of_parry,
            motion_of_parry: of_parry.prepend(piece.pose),
            pose: piece.pose,
            place: piece.place,
            motion: windowed.piece_motion(piece.place)?,
            subshape: piece.subshape,
        })
    }

    fn of_pieces(&self, a: &[Piece<'_>], b: &[Piece<'_>]) -> Option<Option<ShapeCastHit>> {
        let movers = |side: usize, pieces: &'_ [Piece<'_>]| -> Option<Vec<(DVec3, f64)>> {
            let ball = |piece: &Piece<'_>| {
                let (shape, windowed) = (piece.shape(), self.motions.get(side)?);
                let (center, way) =
                    windowed.ball(&windowed.piece_motion(piece.place)?, shape.interior_point(), [0.0, 1.0]);
                Some((center, way + shape.outer_radius()))
            };
            pieces.iter().map(ball).collect()
        };
        let (balls_a, balls_b) = (movers(0, a)?, movers(1, b)?);
        let mut first = None;
        for (piece_a, ball_a) in a.iter().zip(&balls_a) {
            for (piece_b, ball_b) in b.iter().zip(&balls_b) {
                let (apart, reach) = (ball_a.0.distance(ball_b.0), ball_a.1 + ball_b.1);
                // Written so that a NaN would not skip the pair.
                if apart > reach + SLACK * (reach + ball_a.0.length() + ball_b.0.length()) {
                    continue;
                }
                let (a, b) = (self.mover(0, piece_a)?, self.mover(1, piece_b)?);
                add(&mut first, self.of_convex(&a, &b));
            }
        }
        Some(first)
    }

    fn of_convex(&self, a: &Mover<'_>, b: &Mover<'_>) -> Option<ShapeCastHit> {
        let (settings, cache) = (MotionSettings::default(), &mut Cache::new());
        let found = hullmap::cast_motion(a.shape, &a.motion, b.shape, &b.motion, &settings, cache);
        if self.is_ignored(&found) { self.beyond_start(a, b) } else { self.hit(&found, [a.subshape, b.subshape]) }
    }

    fn of_surface(&self, surface: &BakedSurface, pieces: &[Piece<'_>]) -> Option<Option<ShapeCastHit>> {
        let mut first = None;
        let settings = MotionSettings { max_iterations: SURFACE_QUERIES, ..MotionSettings::default() };
        for tile in surface.tiles() {
            let motion = self.motions[0].piece_motion(tile.place())?;
            for piece in pieces {
                let (b, cache) = (self.mover(1, piece)?, &mut Cache::with_pairs(16));
                let found = hullmap::cast_motion(tile, &motion, b.shape, &b.motion, &settings, cache);
                if self.is_ignored(&found) {
                    add(&mut first, self.beyond_start_on(tile, &motion, &b));
                } else {
                    add(&mut first, self.hit(&found, [tile.subshape(found.parts[0] as usize), b.subshape]));
                }
            }
        }
        Some(first)
    }

    fn of_plane(&self, plane: &HalfSpace, pieces: &[Piece<'_>]) -> Option<Option<ShapeCastHit>> {
        let (mut first, motion) = (None, self.motions[0].piece_motion(hullmap::Pose::IDENTITY)?);
        let (settings, cache) = (MotionSettings::default(), || Cache::new());
        for piece in pieces {
            let b = self.mover(1, piece)?;
            let found = hullmap::cast_motion(plane, &motion, b.shape, &b.motion, &settings, &mut cache());
            if self.is_ignored(&found) {
                let core = self.core_of(&b, 1, |core, own| {
                    hullmap::cast_motion(plane, &motion, core, own, &settings, &mut cache())
                });
                let core = core.and_then(|found| self.hit(&found, [0, b.subshape]));
                add(&mut first, self.earlier(core, self.beyond_start_of_plane(plane, &motion, &b)));
            } else {
                add(&mut first, self.hit(&found, [0, b.subshape]));
            }
        }
        Some(first)
    }

    /// Whether shapes meet at the start, and the caller does not stop there.
    fn is_ignored(&self, found: &TimeOfImpact) -> bool {
        let [start, end] = self.window;
        !self.stop_at_penetration && found.hit && found.t_lower * (end - start) < AT_START
    }

    /// The first later hit: by parry's rule, or when the core of one shape meets the other.
    fn beyond_start(&self, a: &Mover<'_>, b: &Mover<'_>) -> Option<ShapeCastHit> {
        let mut core = self.of_core(b, 1, a);
        add(&mut core, self.of_core(a, 0, b).map(ShapeCastHit::swapped));
        self.earlier(core, self.by_rule(a, b))
    }

    /// The earlier one of the hits by a core and by parry's rule. Rapier ignores hits at the start,
    /// so such a hit by the rule counts only if there is no other.
    fn earlier(&self, mut core: Option<ShapeCastHit>, rule: Option<ShapeCastHit>) -> Option<ShapeCastHit> {
        let is_at_start = rule.as_ref().is_some_and(|hit| double(hit.time_of_impact) - self.window[0] < AT_START);
        if !(is_at_start && core.is_some()) {
            add(&mut core, rule);
        }
        core
    }

    /// When the core of `body`, on this side, meets `other`, which is the first shape of the hit.
    fn of_core(&self, body: &Mover<'_>, side: usize, other: &Mover<'_>) -> Option<ShapeCastHit> {
        let found = self.core_of(body, side, |core, motion| {
            let settings = MotionSettings::default();
            hullmap::cast_motion(other.shape, &other.motion, core, motion, &settings, &mut Cache::new())
        })?;
        let hit = self.hit_between([1 - side, side], &found)?;
        Some(ShapeCastHit { subshape1: other.subshape, subshape2: body.subshape, ..hit })
    }

    /// When the core of `body`, on this side, meets what `cast` tests: the largest of [`CORES`]
    /// that does not meet it at the start. `None` if all meet it there, or if the body is flat.
    fn core_of(
        &self,
        body: &Mover<'_>,
        side: usize,
        cast: impl Fn(&Scaled<&dyn Convex>, &RigidMotion) -> TimeOfImpact,
    ) -> Option<TimeOfImpact> {
        // NaN takes the failing branch.
        if !(body.shape.inner_radius() > 0.0) {
            return None;
        }
        let scaled = |scale: f64| {
            let core = Scaled::new(body.shape, DVec3::splat(scale)).ok()?;
            let place = hullmap::Pose::from_translation(body.shape.interior_point() * (1.0 - scale)).ok()?;
            let motion = self.motions.get(side)?.piece_motion(body.place.compose(place).ok()?)?;
            Some(cast(&core, &motion))
        };
        CORES.into_iter().filter_map(scaled).find(|found| !self.is_ignored(found))
    }

    fn by_rule(&self, a: &Mover<'_>, b: &Mover<'_>) -> Option<ShapeCastHit> {
        let [start, end] = self.window.map(real);
        let hit = default::cast_shapes_nonlinear_support_map_support_map(
            self.dispatcher,
            &a.motion_of_parry,
            a.of_parry.as_support_map()?,
            a.of_parry,
            &b.motion_of_parry,
            b.of_parry.as_support_map()?,
            b.of_parry,
            start,
            end,
            NonlinearShapeCastMode::directional_toi(a.of_parry, b.of_parry),
        )?;
        let hit = hit.transform1_by(&a.pose).swapped().transform1_by(&b.pose).swapped();
        Some(ShapeCastHit { subshape1: a.subshape, subshape2: b.subshape, ..hit })
    }

    fn beyond_start_on(&self, tile: &SurfaceTile, motion: &RigidMotion, b: &Mover<'_>) -> Option<ShapeCastHit> {
        let [of_a, of_b] = self.motions;
        let ball = |i: u32| {
            let window = [i, i + 1].map(|i| f64::from(i) / f64::from(BALLS));
            let (place, way) = of_b.ball(&b.motion, b.shape.interior_point(), window);
            // The tile moves, too.
            let middle = 0.5 * (window[0] + window[1]);
            let own = 0.5 * (window[1] - window[0]) * of_a.way(place, of_a.center + of_a.linear * middle);
            let turned = 1.0 + of_a.angular.length();
            let center = motion.pose_at(middle).inverse().transform_point(place);
            Ball { center, radius: (b.shape.outer_radius() + way) * turned + own, start: window[0] }
        };
        let [_, end] = self.window;
        let test = |index: usize, shape: &dyn Convex| {
            let of_parry = tile.parry_triangle(index)?;
            let pose = narrow_pose(&tile.place());
            let a = Mover {
                shape,
                of_parry: &of_parry,
                motion_of_parry: self.of_parry[0].prepend(pose),
                pose,
                place: tile.place(),
                motion: *motion,
                subshape: tile.subshape(index),
            };
            let hit = self.of_convex(&a, b)?;
            Some((self.share(double(hit.time_of_impact).min(end)), hit))
        };
        first_hit(tile, (0..BALLS).map(ball), test).map(|(_, hit)| hit)
    }

    /// The first meeting after the shapes have separated, or the time of passing through.
    fn beyond_start_of_plane(&self, plane: &HalfSpace, motion: &RigidMotion, b: &Mover<'_>) -> Option<ShapeCastHit> {
        let [of_a, of_b] = self.motions;
        for i in 0..BALLS {
            let t = f64::from(i) / f64::from(BALLS);
            let (place, placed) = (motion.pose_at(t), b.motion.pose_at(t));
            let b_in_a = hullmap::Pose::relative(place, placed).ok()?;
            let cache = &mut Cache::new();
            if !hullmap::intersects(plane, b.shape, b_in_a, cache).is_hit() {
                let [start, end] = self.window;
                let rest = |motion: &NonlinearRigidMotion| {
                    Windowed::new(motion, [start + (end - start) * t, end])?.piece_motion(hullmap::Pose::IDENTITY)
                };
                let (a, own) = (rest(self.of_parry[0])?, rest(&b.motion_of_parry)?);
                let found = hullmap::cast_motion(plane, &a, b.shape, &own, &MotionSettings::default(), cache);
                let later = |time: f64| t + (1.0 - t) * time;
                let found = TimeOfImpact { t: later(found.t), t_lower: later(found.t_lower), ..found };
                return self.hit(&found, [0, b.subshape]);
            }
            let contact = hullmap::contact(plane, b.shape, b_in_a, &Settings::default(), cache);
            let normal = place.transform_vector(contact.normal);
            let point = place.transform_point(contact.point_b);
            let speed = |of: &Windowed| of.linear + of.angular.cross(point - (of.center + of.linear * t));
            let approach = (speed(&of_a) - speed(&of_b)).dot(normal);
            // As in parry: a hit if the rest of the motion is longer than the shape is thick.
            if approach * (1.0 - t) > b.shape.inner_radius() {
                let (point_a, point_b) = (place.transform_point(contact.point_a), point);
                let found = TimeOfImpact {
                    status: Status::Overlapping,
                    t,
                    t_lower: t,
                    normal,
                    point_a,
                    point_b,
                    ..TimeOfImpact::default()
                };
                return self.hit(&found, [0, b.subshape]);
            }
        }
        None
    }

    fn share(&self, time: f64) -> f64 {
        let [start, end] = self.window;
        if end > start { (time - start) / (end - start) } else { 0.0 }
    }

    /// parry's hit; `None` for a miss.
    fn hit(&self, found: &TimeOfImpact, [subshape1, subshape2]: [u32; 2]) -> Option<ShapeCastHit> {
        Some(ShapeCastHit { subshape1, subshape2, ..self.hit_between([0, 1], found)? })
    }

    fn hit_between(&self, sides: [usize; 2], found: &TimeOfImpact) -> Option<ShapeCastHit> {
        if !found.hit {
            return None;
        }
        let [start, end] = self.window;
        let place =
            |side: usize| Some(self.motions.get(side)?.piece_motion(hullmap::Pose::IDENTITY)?.pose_at(found.t_lower));
        let (a, b) = (place(sides[0])?, place(sides[1])?);
        let status = match found.status {
            Status::Overlapping => ShapeCastStatus::PenetratingOrWithinTargetDist,
            Status::IterationLimit => ShapeCastStatus::OutOfIterations,
            Status::Stalled => ShapeCastStatus::Failed,
            _ => ShapeCastStatus::Converged,
        };
        Some(ShapeCastHit {
            time_of_impact: earlier(start + (end - start) * found.t_lower),
            witness1: narrow(a.inverse().transform_point(found.point_a)),
            witness2: narrow(b.inverse().transform_point(found.point_b)),
            normal1: narrow(a.inverse_transform_vector(found.normal)),
            normal2: narrow(b.inverse_transform_vector(-found.normal)),
            status,
            subshape1: 0,
            subshape2: 0,
        })
    }
}

/// A time in parry's precision, rounded down: at a later time, the shapes may have met.
fn earlier(time: f64) -> Real {
    let rounded = real(time);
    if double(rounded) > time { rounded.next_down() } else { rounded }
}

/// Keeps the first of two hits.
fn add(first: &mut Option<ShapeCastHit>, hit: Option<ShapeCastHit>) {
    let Some(hit) = hit else { return };
    if first.as_ref().is_none_or(|first| hit.time_of_impact < first.time_of_impact) {
        *first = Some(hit);
    }
}
