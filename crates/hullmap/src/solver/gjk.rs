//! GJK: the point of the Minkowski difference closest to the origin, and thus the distance.
//!
//! # Reference
//! Gilbert, Johnson, Keerthi 1988, cited by Kenwright as [5]. The interval is their error bound.
//!
//! # Steps
//! 1. Find the point y of the simplex closest to the origin. Drop the vertices that y does not
//!    need.
//! 2. Query the support point w along −y. The plane through w bounds the distance from below by
//!    w · y / |y|, and |y| bounds it from above.
//! 3. Stop if the bounds are close enough. Otherwise add w to the simplex and continue with step 1.
//!
//! # Deviations
//! - The lower bound is the running maximum and the upper bound the running minimum. So both hold
//!   at any time, whatever rounding error does to a single step.
//! - Step 1 first considers only the faces of the simplex with the newest vertex. If they come no
//!   closer, it considers the whole simplex.
//! - The normal in the answer belongs to the plane of the best lower bound, which is the proof.
//! - The weights of a sliver reproduce the closest point badly. They are corrected if that shows.

use super::barycentric::{
    SubSimplex, blend, corrected_weights, on_segment, on_segment_to, on_simplex, on_tetrahedron_to, on_triangle_to,
};
use super::minkowski::{Minkowski, Point, Step};
use crate::support::SupportMap;
use glam::DVec3;

/// Maximum number of steps, whatever the settings are. Polytopes need 5 to 30, smooth shapes at
/// zero tolerance about 200.
const MAX_STEPS: u32 = 1000;

/// Maximum number of corrections of the weights. Each squares their relative error, which is about
/// 1e-5 in the thinnest triangle.
const MAX_CORRECTIONS: usize = 3;

/// A simplex of up to four vertices, in fixed places.
///
/// Vertices never move: reading data back in other pieces than it was just written in would stall
/// the processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simplex {
    /// Coordinates of the points of the Minkowski difference: all x, all y, all z.
    w: [[f64; PLACES]; 3],
    a: [DVec3; PLACES],
    features: [[u32; 2]; PLACES],
    /// The places in use, one bit each.
    used: u8,
    /// Weights of the vertices in the closest point, if the search has needed them.
    weights: Option<[f64; PLACES]>,
}

const PLACES: usize = 4;

impl Simplex {
    #[inline(always)]
    pub(super) fn empty() -> Self {
        Self { w: [[0.0; PLACES]; 3], a: [DVec3::ZERO; PLACES], features: [[0; 2]; PLACES], used: 0, weights: None }
    }

    pub(super) fn new(vertex: Point) -> Self {
        let mut simplex = Self::empty();
        simplex.push(vertex);
        simplex
    }

    /// Adds a vertex and returns its place. There must be a free place.
    #[inline(always)]
    pub(super) fn push(&mut self, vertex: Point) -> usize {
        let place = self.used.trailing_ones() as usize % PLACES;
        let Point { w, a, features } = vertex;
        (self.w[0][place], self.w[1][place], self.w[2][place]) = (w.x, w.y, w.z);
        self.a[place] = a;
        self.features[place] = features;
        self.used |= 1 << place;
        place
    }

    fn places(&self) -> impl Iterator<Item = usize> {
        let used = self.used;
        (0..PLACES).filter(move |place| used >> place & 1 == 1)
    }

    pub(super) fn features(&self) -> impl Iterator<Item = [u32; 2]> {
        self.places().map(|place| self.features[place])
    }

    #[inline(always)]
    fn corner(&self, place: usize) -> DVec3 {
        let place = place % PLACES;
        DVec3::new(self.w[0][place], self.w[1][place], self.w[2][place])
    }

    pub(super) fn is_empty(&self) -> bool {
        self.used == 0
    }

    pub(super) fn contains(&self, w: DVec3) -> bool {
        self.places().any(|place| self.corner(place) == w)
    }

    /// The places in use and their number. If there are fewer than four, the first one is repeated.
    #[inline]
    fn packed(&self) -> ([usize; PLACES], usize) {
        let first = self.used.trailing_zeros() as usize % PLACES;
        let (mut at, mut count) = ([first; PLACES], 0);
        for place in self.places() {
            at[count] = place;
            count += 1;
        }
        (at, count)
    }

    /// Witness points of A and B for the point closest to the origin, and their difference.
    ///
    /// `length` is the length of the closest point at the end of the search. The difference should
    /// be at most `noise` longer; if it is not, the weights are corrected.
    pub(super) fn witnesses(&self, length: f64, noise: f64) -> (DVec3, DVec3, DVec3) {
        let ([i, j, k, l], count) = self.packed();
        let w = [self.corner(i), self.corner(j), self.corner(k), self.corner(l)];
        // Places beyond the count repeat the first one, which must count once.
        let mut weights = match self.weights {
            Some(own) => {
                let weight = |at: usize, place: usize| if at < count { own[place] } else { 0.0 };
                [weight(0, i), weight(1, j), weight(2, k), weight(3, l)]
            }
            None => on_simplex(w, count, noise).0.weights,
        };
        let mut between = blend(&weights, w);
        for _ in 0..MAX_CORRECTIONS {
            if between.length() <= length + noise {
                break;
            }
            let better = corrected_weights(&weights, w, count);
            let nearer = blend(&better, w);
            // NaN counts as no progress.
            if !(nearer.length() < between.length()) {
                break;
            }
            (weights, between) = (better, nearer);
        }
        if !(between.length() <= length + noise) {
            // One edge of a sliver is about as close as the sliver itself, and its weights are
            // exact.
            for (p, q) in (1..count).flat_map(|q| (0..q).map(move |p| (p, q))) {
                let on_edge = on_segment(w[p], w[q]);
                if on_edge.point.length() < between.length() {
                    weights = [0.0; PLACES];
                    (weights[p], weights[q]) = (on_edge.weights[0], on_edge.weights[1]);
                    between = blend(&weights, w);
                }
            }
        }
        let point_a = blend(&weights, [self.a[i], self.a[j], self.a[k], self.a[l]]);
        (point_a, point_a - between, between)
    }

    /// The closest point of the whole simplex, the places of the vertices that span it, and the
    /// clearance of the origin if it is inside, as [`on_simplex`] returns them. Stores the weights.
    #[inline(never)]
    fn closest_point(&mut self, rounding: f64) -> (DVec3, u8, f64) {
        let ([i, j, k, l], count) = self.packed();
        let w = [self.corner(i), self.corner(j), self.corner(k), self.corner(l)];
        let (nearest, clearance) = on_simplex(w, count, rounding);
        let (mut kept, mut weights) = (0, [0.0; PLACES]);
        for (place, weight) in [i, j, k, l].into_iter().zip(nearest.weights).take(count) {
            kept |= u8::from(weight > 0.0) << place;
            weights[place] = weight;
        }
        // NaN weights keep no vertex. Then the first one stays.
        if kept == 0 {
            (kept, weights[i]) = (1 << i, 1.0);
        }
        self.weights = Some(weights);
        (nearest.point, kept, clearance)
    }

    /// The closest point, provided that it needs the vertex `s` in place `newest`, and the places
    /// of the vertices that span it. `None` if the origin is inside.
    #[inline(always)]
    fn closest_point_with(&self, newest: usize, s: DVec3) -> Option<(DVec3, u8)> {
        let others = self.used & !(1 << newest);
        if others == 0 {
            return Some((s, self.used));
        }
        let i = others.trailing_zeros() as usize;
        let others = others & (others - 1);
        if others == 0 {
            let SubSimplex { point, mask } = on_segment_to(self.corner(i), s);
            return Some((point, (mask & 1) << i | (mask >> 1) << newest));
        }
        let j = others.trailing_zeros() as usize;
        let others = others & (others - 1);
        if others == 0 {
            let SubSimplex { point, mask } = on_triangle_to(self.corner(i), self.corner(j), s);
            return Some((point, (mask & 1) << i | (mask >> 1 & 1) << j | (mask >> 2) << newest));
        }
        let k = others.trailing_zeros() as usize;
        let SubSimplex { point, mask } = on_tetrahedron_to(self.corner(i), self.corner(j), self.corner(k), s)?;
        Some((point, (mask & 1) << i | (mask >> 1 & 1) << j | (mask >> 2 & 1) << k | (mask >> 3) << newest))
    }
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The interval is within the tolerance.
    Converged,
    /// The origin is inside the simplex, and farther from its faces than rounding error.
    Inside,
    /// The closest point is the origin within rounding error: on the simplex, or barely inside.
    AtOrigin,
    Limit,
    Stalled,
}

/// Bounds of the distance at the end of the search. The simplex itself is an in-out parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub(super) end: End,
    /// Lower bound of the distance, without allowance for rounding error. It may be negative.
    pub(super) lower: f64,
    /// Length of the closest point found, without allowance for rounding error.
    pub(super) upper: f64,
    /// Unit normal, from A to B, of the planes that gave the lower bound; zero if there were none.
    pub(super) normal: DVec3,
    pub(super) iterations: u32,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'_, A, B> {
    /// GJK: searches from `simplex`, in place, until upper − lower ≤ `tolerance` · upper + rounding
    /// error, or until the upper bound is at most `enough`.
    pub(super) fn closest_within(
        &mut self,
        simplex: &mut Simplex,
        enough: f64,
        tolerance: f64,
        max_iterations: u32,
    ) -> Closest {
        let mut search = GjkSearch::new(simplex, self.rounding_error(), enough, tolerance, max_iterations);
        let mut point = None;
        loop {
            match search.advance(simplex, point) {
                Step::Ask(dir) => point = Some(self.point(dir)),
                Step::Answer(found) => return found,
            }
        }
    }
}

/// GJK as a state machine. A batch keeps several in flight: while the memory that one of them needs
/// is on its way, the others compute.
#[derive(Clone, Copy, Debug)]
pub(super) struct GjkSearch {
    tolerance: f64,
    rounding: f64,
    enough: f64,
    lower: f64,
    upper: f64,
    normal: DVec3,
    /// The vertex added last, with its place. A single vertex counts as such.
    newest: Option<(usize, DVec3)>,
    y: DVec3,
    iterations: u32,
    limit: u32,
}

impl GjkSearch {
    #[inline(always)]
    pub(super) fn new(simplex: &Simplex, rounding: f64, enough: f64, tolerance: f64, max_iterations: u32) -> Self {
        let place = simplex.used.trailing_zeros() as usize;
        Self {
            tolerance,
            rounding,
            enough,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            normal: DVec3::ZERO,
            newest: simplex.used.is_power_of_two().then(|| (place, simplex.corner(place))),
            y: DVec3::ZERO,
            iterations: 0,
            // At least one step, since there is no bound without one.
            limit: max_iterations.clamp(1, MAX_STEPS),
        }
    }

    /// Continues up to the next support query, with the last support point, if any.
    #[inline(always)]
    pub(super) fn advance(&mut self, simplex: &mut Simplex, point: Option<Point>) -> Step<Closest> {
        // Steps 2 and 3. NaN is no bound, and no progress below. Any normal is better than none.
        if let Some(vertex) = point {
            let (y, length) = (self.y, self.upper);
            let scale = 1.0 / length;
            let height = vertex.w.dot(y) * scale;
            if height > self.lower || self.normal == DVec3::ZERO {
                self.normal = y * -scale;
            }
            self.lower = self.lower.max(height);
            if length - self.lower <= self.tolerance * length + self.rounding {
                return self.end(End::Converged);
            }
            if self.iterations == self.limit {
                return self.end(End::Limit);
            }
            // A vertex that the simplex has already comes no closer, which ends this step.
            self.newest = Some((simplex.push(vertex), vertex.w));
        }
        // Step 1.
        self.iterations += 1;
        let fast = self.newest.and_then(|(place, w)| simplex.closest_point_with(place, w));
        let (mut y, mut kept) = fast.unwrap_or_default();
        let mut length = y.length();
        simplex.weights = None;
        if fast.is_none() || !(length < self.upper) {
            let clearance;
            (y, kept, clearance) = simplex.closest_point(self.rounding);
            length = y.length();
            if clearance > 0.0 {
                simplex.used = kept;
                self.upper = 0.0;
                // A clearance within rounding error does not prove that the origin is inside.
                return self.end(if clearance > self.rounding { End::Inside } else { End::AtOrigin });
            }
            let nearer = length < self.upper;
            if !nearer {
                // Without the newest vertex the simplex is as it was before this step.
                if let Some((place, _)) = self.newest {
                    simplex.used &= !(1 << place);
                    simplex.weights = None;
                }
                return self.end(End::Stalled);
            }
        }
        simplex.used = kept;
        self.upper = length;
        if length <= self.enough {
            return self.end(End::AtOrigin);
        }
        self.y = y;
        Step::Ask(-y)
    }

    #[inline(always)]
    fn end(&self, end: End) -> Step<Closest> {
        let Self { lower, upper, normal, iterations, .. } = *self;
        Step::Answer(Closest { end, lower, upper, normal, iterations })
    }
}
