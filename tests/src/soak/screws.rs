//! Times of impact of small hulls that move and turn, in exact arithmetic.
//!
//! The soak of motions samples times, and relies on the distance query. Here integers decide, for
//! all times at once:
//!
//! | claim | proof |
//! |---|---|
//! | the hulls do not meet before `t_lower`, or at all | a separating plane for each interval of time |
//! | they meet by `t_upper`, or at the start | no axis of the separating axis test is free |
//!
//! # The motion
//! The hulls have 4 to 8 vertices with integer coordinates. Each rests, or turns about an axis k of
//! integers, both by the same angle θ; linear displacements and centres are dyadic. The rotation by
//! the quaternion (c, s k) is a matrix of quadratic polynomials of c and s, over
//! w = c² + s² k · k. Along a chord from one (c, s) to the next, the angle rises, so these two are
//! linear in a parameter u from 0 to 1.
//!
//! # The proof
//! A plane is fixed in space, to A, or to B. The height of a vertex over it, times powers of w, is
//! a polynomial of u whose coefficients are integers. If all coefficients in Bernstein's basis are
//! positive, so is the polynomial. If not, the chord is divided.
//!
//! Time is no polynomial of u: t = (2 / θ) atan2(s |k|, c). Heights are linear in t, so it is
//! enough that they are positive at both ends of an interval that contains t. From one end of a
//! chord to the other, t differs from its linear interpolation by less than 0.13 tan³(Δ/2) 2/θ,
//! where Δ is the difference of the half angles: with x = 2 u − 1 and T = tan(Δ/2), the difference
//! of the half angle is f(x) = atan(x T) − x atan T, with f'' ≥ −2 x T³ for x ≥ 0 and f(0) = f(1) =
//! 0. Hence 0 ≤ f ≤ (T³/3)(x − x³) ≤ 0.1284 T³.
//!
//! # Reference
//! Farouki, "The Bernstein polynomial basis: a centennial retrospective", 2012, for the basis. Here
//! coefficients are multiplied by their binomials, so that a product is a convolution.

use std::cmp::Ordering;
use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use hullmap::{Cache, Hull, MotionSettings, Pose, RigidMotion, Settings, Status, TimeOfImpact, cast_motion, distance};
use hullmap_testkit::{dyadic::Dyadic, exact_depth::depth_of_points, packs::tree_pack, random::RandomPoses};
use num_bigint::{BigInt, Sign};
use shapes::rng::SplitMix64;

use super::bodies::BodyPair;
use super::claims::Claims;
use super::tally::Tally;

/// Maximum number of chords for one motion.
const CHORDS: u32 = 3_000;

/// Relative error of a time that is computed from half angles in f64, with room.
const TIME_ERROR: f64 = 1e-14;

/// Binary digits after the point of c and s, of times, and of lengths.
const ROTATION_DIGITS: i32 = 90;
const TIME_DIGITS: i32 = 80;
const LENGTH_DIGITS: i32 = 44;

/// Binary digits of the components of a plane's normal.
const NORMAL_DIGITS: i32 = 40;

/// Greatest coordinate of a vertex.
const GREATEST: i64 = 12;

/// Axes that are turned about; B's has the same length as A's.
const AXES: [[i64; 3]; 6] = [[0, 0, 1], [1, 0, 0], [0, 3, 4], [1, 2, 2], [1, -1, 1], [2, -3, 6]];

/// A polynomial of u, by its coefficients in Bernstein's basis times their binomials.
#[derive(Clone)]
struct Polynomial(Vec<BigInt>);

impl Polynomial {
    fn constant(value: impl Into<BigInt>) -> Self {
        Self(vec![value.into()])
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = vec![BigInt::ZERO; self.0.len() + other.0.len() - 1];
        for (i, p) in self.0.iter().enumerate().filter(|(_, p)| p.sign() != Sign::NoSign) {
            for (j, q) in other.0.iter().enumerate() {
                product[i + j] += p * q;
            }
        }
        Self(product)
    }

    fn scaled(&self, factor: &BigInt) -> Self {
        Self(self.0.iter().map(|p| p * factor).collect())
    }

    /// The same polynomial with one degree more.
    fn raised(&self) -> Self {
        self.times(&Self(vec![1.into(), 1.into()]))
    }

    fn add(&mut self, other: &Self) {
        assert_eq!(self.0.len(), other.0.len(), "polynomials of one degree");
        self.0.iter_mut().zip(&other.0).for_each(|(p, q)| *p += q);
    }

    fn minus(&self, other: &Self) -> Self {
        assert_eq!(self.0.len(), other.0.len(), "polynomials of one degree");
        Self(self.0.iter().zip(&other.0).map(|(p, q)| p - q).collect())
    }

    fn is_positive(&self) -> bool {
        self.0.iter().all(|p| p.sign() == Sign::Plus)
    }
}

type Vector = [Polynomial; 3];

fn dot(a: &Vector, b: &Vector) -> Polynomial {
    let mut sum = a[0].times(&b[0]);
    sum.add(&a[1].times(&b[1]));
    sum.add(&a[2].times(&b[2]));
    sum
}

/// `value` times 2^`digits`, rounded.
fn integer(value: f64, digits: i32) -> BigInt {
    Dyadic::new(value).integer(digits)
}

/// A length that [`integer`] converts exactly.
fn dyadic(value: DVec3) -> DVec3 {
    let unit = 2_f64.powi(LENGTH_DIGITS);
    (value * unit).round() / unit
}

fn lengths(value: DVec3) -> [BigInt; 3] {
    value.to_array().map(|c| integer(c, LENGTH_DIGITS))
}

/// A hull and its motion.
struct Mover {
    vertices: Vec<[i64; 3]>,
    /// Where its frame is at the start. The rotation is the identity.
    start: DVec3,
    center: DVec3,
    linear: DVec3,
    /// The zero vector if it does not turn.
    axis: [i64; 3],
}

/// Both movers, and their common angle.
struct Case {
    movers: [Mover; 2],
    /// θ, in radians; 0 if neither turns.
    angle: f64,
    /// |k| of the axes that are not zero.
    axis_length: f64,
}

/// Greatest difference of the half angles at the ends of a chord.
const LONGEST: f64 = 0.7;

/// Shortest interval of time that is divided.
const SHORTEST: f64 = 1e-13;

/// A chord of c and s, and the times at its ends.
#[derive(Clone, Copy)]
struct Chord {
    half: [f64; 2],
    times: [f64; 2],
}

/// Frame that a plane is fixed to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Frame {
    Space,
    A,
    B,
}

const FRAMES: [Frame; 3] = [Frame::A, Frame::B, Frame::Space];

/// Decision of the integers about a time until which the hulls may not meet.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Separated {
    /// They do not meet.
    Surely,
    /// They share a point at this time.
    MeetAt(f64),
    /// Not decided at this time.
    Open(f64),
}

impl Case {
    fn half_angle(&self, t: f64) -> f64 {
        0.5 * self.angle * t
    }

    /// c and s at a half angle.
    fn rotation(&self, half: f64) -> [BigInt; 2] {
        [half.cos(), half.sin() / self.axis_length].map(|value| integer(value, ROTATION_DIGITS))
    }

    /// The pose of a mover in f64.
    fn pose(&self, which: usize, t: f64) -> Pose {
        let mover = &self.movers[which];
        let turn = DQuat::from_scaled_axis(mover.unit_axis() * (self.angle * t));
        let place = mover.center + mover.linear * t + turn * (mover.start - mover.center);
        Pose::new(place, turn).expect("finite")
    }

    fn motion(&self, which: usize) -> RigidMotion {
        let mover = &self.movers[which];
        let angular = mover.unit_axis() * self.angle;
        let start = Pose::from_translation(mover.start).expect("finite");
        RigidMotion::screw(start, mover.linear, angular, mover.center).expect("finite")
    }

    /// A unit vector from A to B that separates them best at time `t`, in f64: a guess.
    fn guess(&self, hulls: [&Hull<'_>; 2], t: f64) -> DVec3 {
        let [a, b] = [0, 1].map(|which| self.pose(which, t));
        let b_in_a = Pose::relative(a, b).expect("in range");
        let settings = Settings { tolerance: 1e-9, ..Settings::default() };
        a.rotation() * distance(hulls[0], hulls[1], b_in_a, &settings, &mut Cache::new()).normal
    }

    /// Whether planes perpendicular to `normal` at time `t` certainly separate the hulls during a
    /// chord, if they are fixed to `frame`.
    fn is_apart(&self, placed: &[Placed; 2], normal: DVec3, frame: Frame, t: f64) -> bool {
        let own = match frame {
            Frame::Space => None,
            Frame::A => Some(0),
            Frame::B => Some(1),
        };
        let local = own.map_or(normal, |which| self.pose(which, t).rotation().conjugate() * normal);
        let local = local.to_array().map(|c| integer(c, NORMAL_DIGITS));
        let normal = own.map_or_else(|| local.clone().map(Polynomial::constant), |which| placed[which].turned(&local));
        // Along a normal that turns with it, the farthest vertex stays the farthest.
        let farthest = own.map(|which| {
            let height = |v: &[i64; 3]| local.iter().zip(v).map(|(n, c)| n * c).sum::<BigInt>();
            let heights = self.movers[which].vertices.iter().map(|v| if which == 0 { height(v) } else { -height(v) });
            heights.enumerate().max_by(|p, q| p.1.cmp(&q.1)).map_or(0, |(index, _)| index)
        });
        (0..2).all(|end| {
            let [of_a, of_b] = [0, 1].map(|which| -> Vec<Polynomial> {
                let points = placed[which].at[end].iter().enumerate();
                let counts = points.filter(|(index, _)| own != Some(which) || farthest == Some(*index));
                counts.map(|(_, point)| dot(&normal, point)).collect()
            });
            of_a.iter().all(|a| of_b.iter().all(|b| b.minus(a).is_positive()))
        })
    }

    /// Proves that the hulls do not meet before `until`, in at most [`CHORDS`] chords.
    fn separate(&self, hulls: [&Hull<'_>; 2], until: f64, chords: &mut u32) -> Separated {
        let parts = (0.5 * self.angle * until / LONGEST).ceil().max(1.0) as u32;
        let end = |part: u32| until * f64::from(part) / f64::from(parts);
        let mut open: Vec<[f64; 2]> = (0..parts).rev().map(|part| [end(part), end(part + 1)]).collect();
        let mut frame = Frame::A;
        while let Some(times) = open.pop() {
            *chords += 1;
            let middle = 0.5 * (times[0] + times[1]);
            let placed = self.placed(&Chord { half: times.map(|t| self.half_angle(t)), times });
            let normal = self.guess(hulls, middle);
            let mut frames = [frame].into_iter().chain(FRAMES.into_iter().filter(|other| *other != frame));
            if let Some(found) = frames.find(|frame| self.is_apart(&placed, normal, *frame, middle)) {
                frame = found;
            } else if self.meets(middle) {
                return Separated::MeetAt(middle);
            } else if *chords > CHORDS || times[1] - times[0] < SHORTEST {
                return Separated::Open(middle);
            } else {
                open.extend([[middle, times[1]], [times[0], middle]]);
            }
        }
        Separated::Surely
    }

    /// Whether the hulls share a point at time `t`, where the rotation is by its half angle in
    /// f64: by their exact depth.
    fn meets(&self, t: f64) -> bool {
        let half = self.half_angle(t);
        let placed = self.placed(&Chord { half: [half; 2], times: [t; 2] });
        // Scaled to about 1.
        let bits = placed.iter().flat_map(|placed| placed.at[0].iter().flatten()).map(|c| c.0[0].bits()).max();
        let exponent = -(bits.unwrap_or(0) as i32);
        let [a, b] = placed.map(|placed| {
            let point = |p: &Vector| p.each_ref().map(|c| Dyadic::scaled(c.0[0].clone(), exponent));
            placed.at[0].iter().map(point).collect()
        });
        depth_of_points(a, b).sign() != Ordering::Less
    }

    /// The vertices during a chord, at the least and at the greatest time that belongs to u.
    fn placed(&self, chord: &Chord) -> [Placed; 2] {
        let [[c0, s0], [c1, s1]] = chord.half.map(|half| self.rotation(half));
        let (c, s) = (Polynomial(vec![c0, c1]), Polynomial(vec![s0, s1]));
        let (cc, cs, ss) = (c.times(&c), c.times(&s), s.times(&s));
        let square = self.movers.iter().map(|mover| mover.axis.iter().map(|c| c * c).sum::<i64>()).max();
        let mut w = ss.scaled(&square.unwrap_or(0).into());
        w.add(&cc);
        let half_tangent = (0.5 * (chord.half[1] - chord.half[0])).tan();
        let bend = if self.angle > 0.0 { 0.27 * half_tangent.powi(3) / self.angle } else { 0.0 };
        let time = |sign: f64| {
            let end = |t: f64| integer(t + sign * (bend + TIME_ERROR * t), TIME_DIGITS);
            let is_moment = chord.times[0] == chord.times[1];
            Polynomial(chord.times.map(|t| if is_moment { integer(t, TIME_DIGITS) } else { end(t) }).to_vec())
        };
        let times = [time(-1.0), time(1.0)];
        self.movers.each_ref().map(|mover| mover.placed([&cc, &cs, &ss, &w], &times))
    }
}

/// The vertices of a mover during a chord: polynomials, times a common power of w and of 2.
struct Placed {
    /// The rotation times w.
    rows: [Vector; 3],
    /// At the least and at the greatest time.
    at: [Vec<Vector>; 2],
}

impl Placed {
    fn turned(&self, v: &[BigInt; 3]) -> Vector {
        self.rows.each_ref().map(|row| {
            let mut sum = row[0].scaled(&v[0]);
            sum.add(&row[1].scaled(&v[1]));
            sum.add(&row[2].scaled(&v[2]));
            sum
        })
    }
}

impl Mover {
    /// The zero vector if it does not turn.
    fn unit_axis(&self) -> DVec3 {
        DVec3::from_array(self.axis.map(|c| c as f64)).normalize_or_zero()
    }

    fn placed(&self, [cc, cs, ss, w]: [&Polynomial; 4], times: &[Polynomial; 2]) -> Placed {
        let k = self.axis.map(BigInt::from);
        let square: BigInt = k.iter().map(|c| c * c).sum();
        // (c² − s² k · k) I + 2 s² k kᵀ + 2 c s [k]ₓ.
        let entry = |i: usize, j: usize| {
            let mut sum = ss.scaled(&(2 * &k[i] * &k[j]));
            if i == j {
                sum.add(cc);
                sum.add(&ss.scaled(&-&square));
            } else {
                // The first row of [k]ₓ is 0, −k_z, k_y.
                let sign = if (j + 3 - i) % 3 == 1 { -2 } else { 2 };
                sum.add(&cs.scaled(&(sign * &k[3 - i - j])));
            }
            sum
        };
        let is_resting = square.sign() == Sign::NoSign;
        let still = |i: usize, j: usize| if i == j { w.clone() } else { w.scaled(&BigInt::ZERO) };
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if is_resting { still(i, j) } else { entry(i, j) }));
        let mut placed = Placed { rows, at: [Vec::new(), Vec::new()] };
        let (start, center, linear) = (lengths(self.start), lengths(self.center), lengths(self.linear));
        for vertex in &self.vertices {
            let arm =
                [0, 1, 2].map(|axis| (BigInt::from(vertex[axis]) << LENGTH_DIGITS) + &start[axis] - &center[axis]);
            let turned = placed.turned(&arm);
            for (points, time) in placed.at.iter_mut().zip(times) {
                points.push([0, 1, 2].map(|axis| {
                    let mut sum = turned[axis].clone();
                    sum.add(&w.scaled(&center[axis]));
                    let mut sum = sum.raised().scaled(&(BigInt::from(1) << TIME_DIGITS));
                    sum.add(&w.scaled(&linear[axis]).times(time));
                    sum
                }));
            }
        }
        placed
    }
}

/// Random vertices of a hull with an inside.
fn vertices(rng: &mut SplitMix64) -> Vec<[i64; 3]> {
    let mut coordinate = |least: i64| least + rng.below((GREATEST + 1 - least) as usize) as i64;
    if coordinate(0) < 3 {
        let half = [0, 1, 2].map(|_| coordinate(1));
        return (0..8)
            .map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { half[axis] } else { -half[axis] }))
            .collect();
    }
    loop {
        let count = 4 + coordinate(0) as usize % 5;
        let points: Vec<[i64; 3]> = (0..count).map(|_| [0, 1, 2].map(|_| coordinate(-GREATEST))).collect();
        let [p, q, r] = [1, 2, 3].map(|i| [0, 1, 2].map(|axis| points[i][axis] - points[0][axis]));
        let volume = p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
            + p[2] * (q[0] * r[1] - q[1] * r[0]);
        if volume != 0 {
            return points;
        }
    }
}

impl Case {
    /// Movers that nearly touch at a time, which is the first result. Some graze each other there.
    fn random(rng: &mut SplitMix64) -> (f64, Self) {
        let axis = AXES[rng.below(AXES.len())];
        let by = rng.below(3);
        let turned = [0, 1, 2].map(|i| axis[(i + by) % 3] * [-1, 1][rng.below(2)]);
        let axes = match rng.below(10) {
            0 => [[0; 3]; 2],
            1..=3 => [[0; 3], axis],
            4..=5 => [axis, [0; 3]],
            _ => [axis, turned],
        };
        let angle = [1e-3, 0.3, 0.25 * PI, 0.5 * PI, PI, 2.0 * PI][rng.below(6)] * rng.between(0.7, 1.1);
        let movers = axes.map(|axis| {
            let length = [0.0, 1.0, 10.0, 40.0][rng.below(4)];
            let screws_along = rng.below(3) == 0;
            let linear = if screws_along { DVec3::ZERO } else { dyadic(rng.unit_vector() * length) };
            let center = dyadic(rng.unit_vector() * [0.0, 5.0, 60.0][rng.below(3)] * rng.unit());
            let mover = Mover { vertices: vertices(rng), start: DVec3::ZERO, center, linear, axis };
            Mover { linear: if screws_along { dyadic(mover.unit_axis() * length) } else { linear }, ..mover }
        });
        // Both axes that are not zero have the same length.
        let square = axes.map(|axis| axis.iter().map(|c| c * c).sum::<i64>()).into_iter().max().unwrap_or(0);
        let (angle, axis_length) = if square > 0 { (angle, (square as f64).sqrt()) } else { (0.0, 1.0) };
        let mut case = Self { movers, angle, axis_length };
        case.shift(rng.unit_vector() * 80.0);
        let through = [0.0, 1.0, rng.unit(), rng.unit(), rng.unit()][rng.below(5)];
        (through, case)
    }

    /// Moves B with its centre.
    fn shift(&mut self, by: DVec3) {
        let b = &mut self.movers[1];
        let by = dyadic(b.start + by) - b.start;
        (b.start, b.center) = (b.start + by, dyadic(b.center + by));
    }

    /// Moves B so that it nearly touches A at time `through`. If they are to graze, B's velocity
    /// becomes one that keeps the distance there.
    fn approach(&mut self, rng: &mut SplitMix64, hulls: [&Hull<'_>; 2], through: f64) {
        for round in 0..2 {
            let [a, b] = [0, 1].map(|which| self.pose(which, through));
            let b_in_a = Pose::relative(a, b).expect("in range");
            let gap = distance(hulls[0], hulls[1], b_in_a, &Settings::default(), &mut Cache::new());
            let normal = a.rotation() * gap.normal;
            let near = [0.0, 1e-11, 1e-9, 1e-6, 1e-3, 1.0][rng.below(6)] * rng.between(-1.0, 1.0) * GREATEST as f64;
            if round == 0 && rng.below(3) == 0 {
                let point = a.transform_point(gap.point_a);
                let [velocity_a, velocity_b] = [0, 1].map(|which| self.motion(which)).map(|motion| {
                    // A difference quotient is good enough.
                    let (here, step) = (motion.pose_at(through), if through < 0.5 { 1e-6 } else { -1e-6 });
                    let local = here.inverse_transform_vector(point - here.translation());
                    (motion.pose_at(through + step).transform_point(local) - point) / step
                });
                let b = &mut self.movers[1];
                let change = dyadic(-normal * (velocity_b - velocity_a).dot(normal));
                b.linear = dyadic(b.linear + change);
                self.shift(-change * through);
            }
            self.shift(normal * (if round == 1 { near } else { 0.0 } - gap.distance));
        }
    }
}

/// Judges one motion of two small hulls. The bodies of the pair do not take part.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let (through, mut case) = Case::random(rng);
    let packs = case
        .movers
        .each_ref()
        .map(|mover| tree_pack(&mover.vertices.iter().map(|v| v.map(|c| c as f32)).collect::<Vec<_>>()));
    let hulls = packs.each_ref().map(|pack| pack.hull(0).expect("one hull"));
    let hulls = [&hulls[0], &hulls[1]];
    case.approach(rng, hulls, through);
    let motions = [case.motion(0), case.motion(1)];
    let settings = MotionSettings::default();
    let found = cast_motion(hulls[0], &motions[0], hulls[1], &motions[1], &settings, &mut Cache::new());
    let TimeOfImpact { hit, status, t_lower, t_upper, iterations, .. } = found;
    let mut judge = Claims::new("screws", tally);
    if status == Status::Overlapping {
        judge.demand("they do not meet at the start", case.meets(0.0));
    } else if t_upper <= 1.0 {
        judge.demand("they do not meet by the upper bound", case.meets(t_upper));
    }
    let until = if hit { t_lower } else { 1.0 } * (1.0 - 10.0 * TIME_ERROR);
    let mut chords = 0;
    let separated = if until > 0.0 { case.separate(hulls, until, &mut chords) } else { Separated::Surely };
    let is_early = matches!(separated, Separated::MeetAt(_));
    judge.demand(if hit { "they meet before" } else { "they meet" }, !is_early);
    judge.tally.note(status.as_str());
    let decided = match (separated, chords) {
        (Separated::Open(_), _) => "not decided",
        (_, 0..=20) => "at most 20 chords",
        (_, 21..=200) => "at most 200 chords",
        _ => "more chords",
    };
    judge.tally.note(decided);
    judge.tally.iterations[0] = judge.tally.iterations[0].max(iterations);
    judge.finish(pair, || {
        let vertices = case.movers.each_ref().map(|mover| &mover.vertices);
        format!("{separated:?} {found:?}\n  {vertices:?}\n  {:?}\n  {:?}", motions[0], motions[1])
    });
}
