//! Where a ray meets a triangle or a polytope, in rational numbers without rounding.

use std::cmp::Ordering;

use glam::DVec3;

use crate::dyadic::{Dyadic, Vector, cross, dot, exact, is_zero, minus};

/// A fraction; the denominator is positive.
#[derive(Clone, Debug)]
pub struct Fraction(Dyadic, Dyadic);

impl Fraction {
    fn new(numerator: Dyadic, denominator: Dyadic) -> Self {
        let opposite = |x: &Dyadic| Dyadic::zero().minus(x);
        if denominator.sign() == Ordering::Less {
            Self(opposite(&numerator), opposite(&denominator))
        } else {
            Self(numerator, denominator)
        }
    }

    /// The exact value of `t`.
    fn of(t: f64) -> Self {
        Self(Dyadic::new(t), Dyadic::new(1.0))
    }

    fn cmp(&self, other: &Self) -> Ordering {
        self.0.times(&other.1).compare(&other.0.times(&self.1))
    }

    /// The order of the fraction and `t`.
    pub fn compare(&self, t: f64) -> Ordering {
        if t == f64::INFINITY { Ordering::Less } else { self.cmp(&Self::of(t)) }
    }

    /// Whether the fraction differs from `t` by at most `error`, up to a rounding.
    pub fn is_within(&self, t: f64, error: f64) -> bool {
        self.compare(t - error).is_ge() && self.compare(t + error).is_le()
    }

    /// The nearest number, up to a few roundings.
    pub fn rounded(&self) -> f64 {
        self.0.rounded() / self.1.rounded()
    }

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

/// Three points of each facet of the convex hull of points, which has a volume: clockwise seen from
/// outside.
pub fn facets(points: &[DVec3]) -> Vec<[DVec3; 3]> {
    let all: Vec<Vector> = points.iter().map(|p| exact(*p)).collect();
    let (mut facets, mut known): (Vec<[DVec3; 3]>, Vec<Vec<bool>>) = Default::default();
    for (i, p) in all.iter().enumerate() {
        for (j, q) in all.iter().enumerate().take(i) {
            for (k, r) in all.iter().enumerate().take(j) {
                let normal = cross(&minus(q, p), &minus(r, p));
                let heights: Vec<Ordering> = all.iter().map(|x| dot(&normal, &minus(x, p)).sign()).collect();
                let is_inward = heights.iter().all(|height| height.is_ge());
                let is_facet = is_inward || heights.iter().all(|height| height.is_le());
                if is_zero(&normal) || !is_facet || known.iter().any(|on| on[i] && on[j] && on[k]) {
                    continue;
                }
                known.push(heights.iter().map(|height| height.is_eq()).collect());
                facets.push([i, if is_inward { j } else { k }, if is_inward { k } else { j }].map(|i| points[i]));
            }
        }
    }
    facets
}

/// A ray up to a limit.
pub struct Line {
    origin: Vector,
    direction: Vector,
    limit: Fraction,
    rounded: [DVec3; 2],
}

impl Line {
    /// The ray up to `limit`.
    pub fn new(origin: DVec3, direction: DVec3, limit: f64) -> Self {
        let limit = Fraction::of(limit.min(f64::MAX));
        Self { origin: exact(origin), direction: exact(direction), limit, rounded: [origin, direction] }
    }

    /// The part of the ray in half-spaces: each is a normal and a point of its plane, and the
    /// normal points inwards. Returns where it enters them.
    fn clip(&self, planes: impl IntoIterator<Item = (Vector, Vector)>) -> Option<Fraction> {
        let (mut enter, mut leave) = (Fraction::of(0.0), self.limit.clone());
        for (normal, point) in planes {
            let (height, speed) = (dot(&normal, &minus(&point, &self.origin)), dot(&normal, &self.direction));
            match speed.sign() {
                Ordering::Equal if height.sign().is_gt() => return None,
                Ordering::Equal => {}
                Ordering::Greater => enter = enter.max(Fraction::new(height, speed)),
                Ordering::Less => leave = leave.min(Fraction::new(height, speed)),
            }
        }
        enter.cmp(&leave).is_le().then_some(enter)
    }

    /// Where the ray first meets a closed segment.
    fn meet_segment(&self, p: &Vector, q: &Vector) -> Option<Fraction> {
        let (edge, from) = (minus(q, p), minus(p, &self.origin));
        let across = cross(&self.direction, &edge);
        if is_zero(&across) {
            let is_ahead = dot(&edge, &self.direction).sign().is_ge();
            let [near, far] = if is_ahead { [p, q] } else { [q, p] }.map(Clone::clone);
            let is_on = is_zero(&cross(&self.direction, &from));
            return is_on
                .then(|| self.clip([(self.direction.clone(), near), (opposite(&self.direction), far)]))
                .flatten();
        }
        let (square, share) = (dot(&across, &across), dot(&cross(&from, &self.direction), &across));
        let is_within = share.sign().is_ge() && share.compare(&square).is_le() && dot(&from, &across).sign().is_eq();
        let t = Fraction::new(dot(&cross(&from, &edge), &across), square);
        (is_within && t.0.sign().is_ge() && t.cmp(&self.limit).is_le()).then_some(t)
    }

    /// Where the ray first meets a closed triangle.
    pub fn meet(&self, corners: [DVec3; 3]) -> Option<Fraction> {
        if self.certainly_misses(corners) {
            return None;
        }
        let corners = corners.map(exact);
        let [a, b, c] = &corners;
        let normal = cross(&minus(b, a), &minus(c, a));
        let edges = [(a, b), (b, c), (c, a)];
        if is_zero(&normal) {
            return edges.into_iter().filter_map(|(p, q)| self.meet_segment(p, q)).reduce(Fraction::min);
        }
        let sides = edges.map(|(p, q)| (cross(&normal, &minus(q, p)), p.clone()));
        self.clip(sides.into_iter().chain([(opposite(&normal), a.clone()), (normal, a.clone())]))
    }

    /// Whether the ray moves towards the front of a triangle (`Less`), its back, or neither.
    pub fn facing(&self, corners: [DVec3; 3]) -> Ordering {
        let [a, b, c] = corners.map(exact);
        dot(&cross(&minus(&b, &a), &minus(&c, &a)), &self.direction).sign()
    }

    /// The origin.
    pub fn origin(&self) -> DVec3 {
        self.rounded[0]
    }

    /// The length of the direction, also where its square underflows.
    pub fn speed(&self) -> f64 {
        let greatest = self.rounded[1].abs().max_element();
        greatest * (self.rounded[1] / greatest).length()
    }

    /// The direction, of unit length.
    pub fn way(&self) -> DVec3 {
        let direction = self.rounded[1];
        (direction / direction.abs().max_element()).normalize()
    }

    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.rounded[0] + self.way() * (self.speed() * t)
    }

    /// Where the ray first meets the polytope with these [`facets`].
    pub fn meet_hull(&self, facets: &[[DVec3; 3]]) -> Option<Fraction> {
        self.clip(facets.iter().map(|corners| {
            let [p, q, r] = corners.map(exact);
            (cross(&minus(&q, &p), &minus(&r, &p)), p)
        }))
    }

    /// A quick test in f64, far beyond rounding: most triangles are nowhere near the line.
    fn certainly_misses(&self, corners: [DVec3; 3]) -> bool {
        let [origin, direction] = self.rounded;
        // Whatever its length is, also one whose square underflows.
        let direction = direction / direction.abs().max_element();
        let [a, b, c] = corners.map(|corner| corner - origin);
        let turns = [(b, c), (c, a), (a, b)].map(|(p, q)| {
            let share = direction.dot(p.cross(q)) / (direction.length() * p.length() * q.length());
            if share.abs() > 1e-9 { share.signum() } else { 0.0 }
        });
        turns.contains(&1.0) && turns.contains(&-1.0)
    }
}

fn opposite(a: &Vector) -> Vector {
    a.each_ref().map(|c| Dyadic::zero().minus(c))
}
