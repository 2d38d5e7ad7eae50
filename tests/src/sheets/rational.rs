//! Where a ray meets a triangle or a polytope, in rational numbers without rounding.
//!
//! Coordinates become integers: multiples of a power of two that divides all of them.

use std::cmp::Ordering;

use glam::DVec3;
use num_bigint::BigInt;

type Whole = [BigInt; 3];

/// A fraction; the denominator is positive.
#[derive(Clone, Debug)]
pub struct Fraction(BigInt, BigInt);

impl Fraction {
    fn new(numerator: BigInt, denominator: BigInt) -> Self {
        if denominator < BigInt::ZERO { Self(-numerator, -denominator) } else { Self(numerator, denominator) }
    }

    fn cmp(&self, other: &Self) -> Ordering {
        (&self.0 * &other.1).cmp(&(&other.0 * &self.1))
    }

    /// The greater one.
    fn max(self, other: Self) -> Self {
        if self.cmp(&other) == Ordering::Less { other } else { self }
    }

    /// The smaller one.
    pub fn min(self, other: Self) -> Self {
        if self.cmp(&other) == Ordering::Greater { other } else { self }
    }

    /// Whether both are equal.
    pub fn is(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

/// The mantissa and the exponent of a number.
fn decoded(number: f64) -> (i64, i32) {
    let (bits, sign) = (number.to_bits(), if number < 0.0 { -1 } else { 1 });
    let (exponent, mantissa) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (mantissa, exponent) = if exponent == 0 { (mantissa, -1074) } else { (mantissa | 1 << 52, exponent - 1075) };
    let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() as i32 };
    (sign * (mantissa >> zeros), if mantissa == 0 { 0 } else { exponent + zeros })
}

fn shifted(number: f64, power: i32) -> BigInt {
    let (mantissa, exponent) = decoded(number);
    BigInt::from(mantissa) << (exponent - power)
}

/// The least exponent of the coordinates, at most 0.
fn power(points: impl IntoIterator<Item = DVec3>) -> i32 {
    points.into_iter().flat_map(|point| point.to_array()).map(|c| decoded(c).1).fold(0, i32::min)
}

fn minus(a: &Whole, b: &Whole) -> Whole {
    std::array::from_fn(|i| &a[i] - &b[i])
}

fn dot(a: &Whole, b: &Whole) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Whole, b: &Whole) -> Whole {
    std::array::from_fn(|i| {
        let (y, z) = ((i + 1) % 3, (i + 2) % 3);
        &a[y] * &b[z] - &a[z] * &b[y]
    })
}

fn is_zero(a: &Whole) -> bool {
    a.iter().all(|c| *c == BigInt::ZERO)
}

/// Three points of each facet of the convex hull of points, which has a volume: clockwise seen from
/// outside.
pub fn facets(points: &[DVec3]) -> Vec<[DVec3; 3]> {
    let line = Line::new(DVec3::ZERO, DVec3::X, 0.0, points.iter().copied());
    let whole: Vec<Whole> = points.iter().map(|point| line.whole(*point)).collect();
    let (mut facets, mut known): (Vec<[DVec3; 3]>, Vec<Vec<bool>>) = Default::default();
    for (i, p) in whole.iter().enumerate() {
        for (j, q) in whole.iter().enumerate().take(i) {
            for (k, r) in whole.iter().enumerate().take(j) {
                let normal = cross(&minus(q, p), &minus(r, p));
                let heights: Vec<BigInt> = whole.iter().map(|x| dot(&normal, &minus(x, p))).collect();
                let is_inward = heights.iter().all(|height| *height >= BigInt::ZERO);
                let is_facet = is_inward || heights.iter().all(|height| *height <= BigInt::ZERO);
                if is_zero(&normal) || !is_facet || known.iter().any(|on| on[i] && on[j] && on[k]) {
                    continue;
                }
                known.push(heights.iter().map(|height| *height == BigInt::ZERO).collect());
                facets.push(if is_inward {
                    [points[i], points[j], points[k]]
                } else {
                    [points[i], points[k], points[j]]
                });
            }
        }
    }
    facets
}

/// A ray, and the powers of two of its numbers.
pub struct Line {
    origin: Whole,
    direction: Whole,
    /// Of points, and of the direction.
    powers: [i32; 2],
    limit: Fraction,
}

impl Line {
    /// The ray up to `limit`, among some points.
    pub fn new(origin: DVec3, direction: DVec3, limit: f64, points: impl IntoIterator<Item = DVec3>) -> Self {
        let powers = [power(points.into_iter().chain([origin])), power([direction])];
        let whole = |v: DVec3, power: i32| v.to_array().map(|c| shifted(c, power));
        let mut line = Self {
            origin: whole(origin, powers[0]),
            direction: whole(direction, powers[1]),
            powers,
            limit: Fraction(BigInt::ZERO, BigInt::from(1)),
        };
        line.limit = line.time(limit.min(f64::MAX));
        line
    }

    fn whole(&self, point: DVec3) -> Whole {
        point.to_array().map(|c| shifted(c, self.powers[0]))
    }

    /// A t, in the units of the whole numbers.
    pub fn time(&self, t: f64) -> Fraction {
        let (mantissa, exponent) = decoded(t);
        let power = exponent + self.powers[1] - self.powers[0];
        let (up, down) = (power.max(0), (-power).max(0));
        Fraction(BigInt::from(mantissa) << up, BigInt::from(1) << down)
    }

    /// The order of a fraction and a t.
    pub fn compare(&self, fraction: &Fraction, t: f64) -> Ordering {
        if t == f64::INFINITY { Ordering::Less } else { fraction.cmp(&self.time(t)) }
    }

    /// The part of the ray in half-spaces: each is a normal and a point of its plane, and the
    /// normal points inwards. Returns where it enters them.
    fn clip(&self, planes: impl IntoIterator<Item = (Whole, Whole)>) -> Option<Fraction> {
        let mut enter = Fraction(BigInt::ZERO, BigInt::from(1));
        let mut leave = self.limit.clone();
        for (normal, point) in planes {
            let (height, speed) = (dot(&normal, &minus(&point, &self.origin)), dot(&normal, &self.direction));
            match speed.cmp(&BigInt::ZERO) {
                Ordering::Equal if height > BigInt::ZERO => return None,
                Ordering::Equal => {}
                Ordering::Greater => enter = enter.max(Fraction::new(height, speed)),
                Ordering::Less => leave = leave.min(Fraction::new(height, speed)),
            }
        }
        (enter.cmp(&leave) != Ordering::Greater).then_some(enter)
    }

    /// Where the ray first meets a closed segment.
    fn meet_segment(&self, p: &Whole, q: &Whole) -> Option<Fraction> {
        let (edge, from) = (minus(q, p), minus(p, &self.origin));
        let across = cross(&self.direction, &edge);
        if is_zero(&across) {
            let opposite: Whole = std::array::from_fn(|i| -&self.direction[i]);
            let is_ahead = dot(&edge, &self.direction) >= BigInt::ZERO;
            let (near, far) = if is_ahead { (p, q) } else { (q, p) };
            let is_on = is_zero(&cross(&self.direction, &from));
            return is_on
                .then(|| self.clip([(self.direction.clone(), near.clone()), (opposite, far.clone())]))
                .flatten();
        }
        let (square, share) = (dot(&across, &across), dot(&cross(&from, &self.direction), &across));
        let is_within = share >= BigInt::ZERO && share <= square && dot(&from, &across) == BigInt::ZERO;
        let t = Fraction::new(dot(&cross(&from, &edge), &across), square);
        let is_on_ray = t.0 >= BigInt::ZERO && t.cmp(&self.limit) != Ordering::Greater;
        (is_within && is_on_ray).then_some(t)
    }

    /// Where the ray first meets a closed triangle.
    pub fn meet(&self, corners: [DVec3; 3]) -> Option<Fraction> {
        if self.certainly_misses(corners) {
            return None;
        }
        let corners = corners.map(|corner| self.whole(corner));
        let [a, b, c] = &corners;
        let normal = cross(&minus(b, a), &minus(c, a));
        let edges = [(a, b), (b, c), (c, a)];
        if is_zero(&normal) {
            let hits = edges.into_iter().filter_map(|(p, q)| self.meet_segment(p, q));
            return hits.reduce(Fraction::min);
        }
        let opposite: Whole = std::array::from_fn(|i| -&normal[i]);
        let sides = edges.map(|(p, q)| (cross(&normal, &minus(q, p)), p.clone()));
        self.clip(sides.into_iter().chain([(normal, a.clone()), (opposite, a.clone())]))
    }

    /// Whether the ray moves towards the front of a triangle.
    pub fn is_towards_front(&self, corners: [DVec3; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| self.whole(corner));
        dot(&cross(&minus(&b, &a), &minus(&c, &a)), &self.direction) < BigInt::ZERO
    }

    /// Where the ray first meets the polytope with these [`facets`].
    pub fn meet_hull(&self, facets: &[[DVec3; 3]]) -> Option<Fraction> {
        self.clip(facets.iter().map(|corners| {
            let [p, q, r] = corners.map(|corner| self.whole(corner));
            (cross(&minus(&q, &p), &minus(&r, &p)), p)
        }))
    }

    /// A quick test in f64, far beyond rounding: most triangles are nowhere near the line.
    fn certainly_misses(&self, corners: [DVec3; 3]) -> bool {
        let float = |v: &Whole, power: i32| -> Option<DVec3> {
            let [x, y, z]: [Option<f64>; 3] = std::array::from_fn(|i| i128::try_from(&v[i]).ok().map(|c| c as f64));
            Some(DVec3::new(x?, y?, z?) * f64::from(power).exp2())
        };
        let (Some(origin), Some(direction)) = (float(&self.origin, self.powers[0]), float(&self.direction, 0)) else {
            return false;
        };
        let [a, b, c] = corners.map(|corner| corner - origin);
        let turns = [(b, c), (c, a), (a, b)].map(|(p, q)| {
            let share = direction.dot(p.cross(q)) / (direction.length() * p.length() * q.length());
            if share.abs() > 1e-9 { share.signum() } else { 0.0 }
        });
        turns.contains(&1.0) && turns.contains(&-1.0)
    }
}
