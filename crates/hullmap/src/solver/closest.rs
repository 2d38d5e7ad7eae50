//! Distance phase: the point of the Minkowski difference nearest to the origin (GJK).
//!
//! # Reference
//! Gilbert, Johnson, Keerthi 1988, cited by Kenwright as [5]; the interval is that of their error bound.
//!
//! # Steps
//! 1. y = point nearest to the origin on the simplex; drop the vertices that have no part in it;
//! 2. w = support along −y; the plane through w bounds the distance from below by w · y / |y|, |y| bounds it from above;
//! 3. stop when the two are close enough; otherwise add w to the simplex; again.
//!
//! # Deviations
//! - The lower bound is the running maximum and the upper the running minimum: both hold at any time, whatever
//!   rounding does to a single step.
//! - The nearest point is sought only on what has the newest vertex in it; if that comes no nearer, on the whole simplex.
//! - Repeated vertices and steps that do not come nearer end the search as a status.
//! - The normal told is that of the plane which gave the lower bound, not of the last step: it is the proof.
//! - Weights of a sliver reproduce the nearest point badly; they are corrected where that is seen.

use super::barycentric::{
    Made, blend, corrected, on_segment, on_segment_to, on_simplex, on_tetrahedron_to, on_triangle, on_triangle_to,
};
use crate::SupportMap;
use crate::minkowski::{Minkowski, Point};
use glam::DVec3;

/// Most steps, whatever the settings. Polytopes need 5 to 30; smooth shapes at the tightest tolerance about 200.
const MAX_CLOSEST: u32 = 1000;

/// Most corrections of weights: each squares a relative error, of 1e-5 or so in a sliver at the limit of what counts as a triangle.
const MOST_CORRECTIONS: usize = 3;

/// At most four vertices, in slots that are not moved: what was just written and is read back in other pieces would stall the
/// processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simplex {
    /// Coordinates of the points of the difference, x, y and z apart.
    w: [[f64; SLOTS]; 3],
    a: [DVec3; SLOTS],
    features: [[u32; 2]; SLOTS],
    /// Slots that hold a vertex, one bit each.
    used: u8,
    /// Weights of the vertices in the nearest point, where the search came by them: it mostly needs none.
    weights: Option<[f64; SLOTS]>,
}

const SLOTS: usize = 4;

impl Simplex {
    /// Without a vertex.
    #[inline(always)]
    pub(super) fn empty() -> Self {
        Self { w: [[0.0; SLOTS]; 3], a: [DVec3::ZERO; SLOTS], features: [[0; 2]; SLOTS], used: 0, weights: None }
    }

    pub(super) fn new(vertex: Point) -> Self {
        let mut simplex = Self::empty();
        simplex.push(vertex);
        simplex
    }

    /// Adds a vertex; there must be room. Tells its slot.
    #[inline(always)]
    pub(super) fn push(&mut self, vertex: Point) -> usize {
        let slot = self.used.trailing_ones() as usize % SLOTS;
        let Point { w, a, features } = vertex;
        (self.w[0][slot], self.w[1][slot], self.w[2][slot]) = (w.x, w.y, w.z);
        self.a[slot] = a;
        self.features[slot] = features;
        self.used |= 1 << slot;
        slot
    }

    fn slots(&self) -> impl Iterator<Item = usize> {
        let used = self.used;
        (0..SLOTS).filter(move |slot| used >> slot & 1 == 1)
    }

    /// The features that make the vertices.
    pub(super) fn features(&self) -> impl Iterator<Item = [u32; 2]> {
        self.slots().map(|slot| self.features[slot])
    }

    #[inline(always)]
    fn corner(&self, slot: usize) -> DVec3 {
        let slot = slot % SLOTS;
        DVec3::new(self.w[0][slot], self.w[1][slot], self.w[2][slot])
    }

    /// The slot of the only vertex; nothing where there are more.
    fn single(&self) -> Option<usize> {
        self.used.is_power_of_two().then_some(self.used.trailing_zeros() as usize)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.used == 0
    }

    /// Whether a vertex is at this point.
    pub(super) fn contains(&self, w: DVec3) -> bool {
        self.slots().any(|slot| self.corner(slot) == w)
    }

    /// The slots in use, the first one again where there are fewer than four, and their count.
    #[inline]
    fn packed(&self) -> ([usize; SLOTS], usize) {
        let first = self.used.trailing_zeros() as usize % SLOTS;
        let (mut at, mut count) = ([first; SLOTS], 0);
        for slot in self.slots() {
            at[count] = slot;
            count += 1;
        }
        (at, count)
    }

    /// The points of A and of B that make the point nearest to the origin, and their difference. `length` is that of the nearest point
    /// where the search ended, `noise` by how much their difference may be longer.
    pub(super) fn witnesses(&self, length: f64, noise: f64) -> (DVec3, DVec3, DVec3) {
        let ([i, j, k, l], count) = self.packed();
        let w = [self.corner(i), self.corner(j), self.corner(k), self.corner(l)];
        let mut weights = self.packed_weights([i, j, k, l], w, count);
        let mut between = blend(&weights, w);
        for _ in 0..MOST_CORRECTIONS {
            if between.length() <= length + noise {
                break;
            }
            let better = corrected(&weights, w, count);
            let nearer = blend(&better, w);
            // NaN counts as no progress.
            if !(nearer.length() < between.length()) {
                break;
            }
            (weights, between) = (better, nearer);
        }
        if !(between.length() <= length + noise) {
            // Of a sliver's edges one is as near as the sliver is thin, and has exact weights.
            for (p, q) in (1..count).flat_map(|q| (0..q).map(move |p| (p, q))) {
                let on_edge = on_segment(w[p], w[q]);
                if on_edge.point.length() < between.length() {
                    weights = [0.0; SLOTS];
                    (weights[p], weights[q]) = (on_edge.weights[0], on_edge.weights[1]);
                    between = blend(&weights, w);
                }
            }
        }
        let point_a = blend(&weights, [self.a[i], self.a[j], self.a[k], self.a[l]]);
        (point_a, point_a - between, between)
    }

    /// Weights of the vertices in the nearest point, in packed order.
    #[inline(always)]
    fn packed_weights(&self, [i, j, k, l]: [usize; SLOTS], w: [DVec3; SLOTS], count: usize) -> [f64; SLOTS] {
        match self.weights {
            Some(weights) => {
                // Slots beyond the count repeat the first, which must count once.
                let weight = |at: usize, slot: usize| if at < count { weights[slot] } else { 0.0 };
                [weight(0, i), weight(1, j), weight(2, k), weight(3, l)]
            }
            None => match count {
                2 => {
                    let [p, q] = on_segment(w[0], w[1]).weights;
                    [p, q, 0.0, 0.0]
                }
                3 => {
                    let [p, q, r] = on_triangle(w[0], w[1], w[2]).weights;
                    [p, q, r, 0.0]
                }
                _ => on_simplex(w, count).0.weights,
            },
        }
    }

    /// The nearest point, the slots of the vertices that it is made of, and the origin's distance from the surface if it is
    /// inside. Keeps the weights.
    #[inline(never)]
    fn nearest(&mut self) -> (DVec3, u8, f64) {
        let ([i, j, k, l], count) = self.packed();
        let w = [self.corner(i), self.corner(j), self.corner(k), self.corner(l)];
        let (nearest, clearance) = on_simplex(w, count);
        let (mut kept, mut weights) = (0, [0.0; SLOTS]);
        for (slot, weight) in [i, j, k, l].into_iter().zip(nearest.weights).take(count) {
            kept |= u8::from(weight > 0.0) << slot;
            weights[slot] = weight;
        }
        // NaN weights keep nothing: stay with the first vertex.
        if kept == 0 {
            (kept, weights[i]) = (1 << i, 1.0);
        }
        self.weights = Some(weights);
        (nearest.point, kept, clearance)
    }

    /// The nearest point, known to need the vertex in slot `newest`, which is `s`; and the slots of the vertices that it is
    /// made of. Nothing where the origin is inside.
    #[inline(always)]
    fn nearest_to(&self, newest: usize, s: DVec3) -> Option<(DVec3, u8)> {
        let others = self.used & !(1 << newest);
        if others == 0 {
            return Some((s, self.used));
        }
        let i = others.trailing_zeros() as usize;
        let others = others & (others - 1);
        if others == 0 {
            let Made { point, of } = on_segment_to(self.corner(i), s);
            return Some((point, (of & 1) << i | (of >> 1) << newest));
        }
        let j = others.trailing_zeros() as usize;
        let others = others & (others - 1);
        if others == 0 {
            let Made { point, of } = on_triangle_to(self.corner(i), self.corner(j), s);
            return Some((point, (of & 1) << i | (of >> 1 & 1) << j | (of >> 2) << newest));
        }
        let k = others.trailing_zeros() as usize;
        let Made { point, of } = on_tetrahedron_to(self.corner(i), self.corner(j), self.corner(k), s)?;
        Some((point, (of & 1) << i | (of >> 1 & 1) << j | (of >> 2 & 1) << k | (of >> 3) << newest))
    }
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The interval is narrow enough.
    Converged,
    /// The origin is inside the simplex, clear of its faces by more than rounding.
    Inside,
    /// The nearest point is the origin, within rounding, on the simplex or a hair inside.
    AtOrigin,
    /// The cap was reached.
    Limit,
    /// Rounding stopped all progress.
    Stalled,
}

/// The nearest point and its bounds; the simplex is left where the search began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub(super) end: End,
    /// Greatest distance known to be free, without allowance for rounding; can be negative.
    pub(super) lower: f64,
    /// Length of the nearest point found, without allowance for rounding.
    pub(super) upper: f64,
    /// Unit direction from A to B, of the planes that gave the lower bound; zero when there were none.
    pub(super) normal: DVec3,
    pub(super) iterations: u32,
}

/// Searches from `simplex`, in place, until upper − lower ≤ `tolerance` · upper + rounding.
pub(super) fn closest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    simplex: &mut Simplex,
    tolerance: f64,
    max_iterations: u32,
) -> Closest {
    let rounding = m.rounding();
    let mut lower = f64::NEG_INFINITY;
    let mut upper = f64::INFINITY;
    let mut normal = DVec3::ZERO;
    // A single vertex needs no search.
    let mut newest = simplex.single().map(|slot| (slot, simplex.corner(slot)));
    // At least once: without a step there is no bound at all.
    let most = max_iterations.clamp(1, MAX_CLOSEST);
    for iterations in 1..=most {
        let quick = newest.and_then(|(slot, w)| simplex.nearest_to(slot, w));
        let (mut y, mut kept) = quick.unwrap_or_default();
        let mut length = y.length();
        simplex.weights = None;
        // NaN counts as no progress, here and below.
        if quick.is_none() || !(length < upper) {
            let clearance;
            (y, kept, clearance) = simplex.nearest();
            length = y.length();
            if clearance > 0.0 {
                simplex.used = kept;
                // A hair inside may be a hair outside.
                let end = if clearance > rounding { End::Inside } else { End::AtOrigin };
                return Closest { end, lower, upper: 0.0, normal, iterations };
            }
            let nearer = length < upper;
            if !nearer {
                // Without the last vertex it is what it was.
                if let Some((slot, _)) = newest {
                    simplex.used &= !(1 << slot);
                    simplex.weights = None;
                }
                return Closest { end: End::Stalled, lower, upper, normal, iterations };
            }
        }
        simplex.used = kept;
        upper = length;
        if length <= rounding {
            return Closest { end: End::AtOrigin, lower, upper, normal, iterations };
        }
        let vertex = m.point(-y);
        let scale = 1.0 / length;
        let height = vertex.w.dot(y) * scale;
        // NaN is no bound, and any normal better than none.
        if height > lower || normal == DVec3::ZERO {
            normal = y * -scale;
        }
        lower = lower.max(height);
        if upper - lower <= tolerance * upper + rounding {
            return Closest { end: End::Converged, lower, upper, normal, iterations };
        }
        // A vertex that is there already brings nothing nearer, which the next step sees.
        if iterations < most {
            newest = Some((simplex.push(vertex), vertex.w));
        }
    }
    Closest { end: End::Limit, lower, upper, normal, iterations: most }
}
