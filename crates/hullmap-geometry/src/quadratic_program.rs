//! Quadratic program (dual active set): the point nearest to the origin outside of half-spaces.
//!
//! # Steps
//! 1. Start at the origin, with an empty set of active planes.
//! 2. Take the plane that is violated most. The new active set is the at most three of it and the
//!    active planes that determine the nearest point outside of all their half-spaces.
//! 3. Repeat until no plane is violated. The distance grows, so no active set occurs twice.
//!
//! # Reference
//! Sharir, Welzl, "A combinatorial bound for linear programming and related problems", 1992 (the
//! nearest point is a problem of its type, of dimension 3); Goldfarb, Idnani, "A numerically stable
//! dual method for solving strictly convex quadratic programs", 1983.

use glam::{DMat3, DVec3};

use crate::planes::HalfSpace;

/// Maximum number of steps. Five to ten are common.
const MAX_STEPS: usize = 100;

/// Distance inside a half-space up to which a point counts as outside, relative to the sum of the
/// point's distance from the origin and the plane's offset.
const SLACK: f64 = 1e-13;

/// Rounding error of a point that is computed from planes at small angles.
const AMPLIFIED: f64 = 1e-11;

/// Violation after a search that nearly parallel planes stop: a thousandth of f32's rounding.
const LIMIT: f64 = 1e-10;

/// Squared sine below which planes count as parallel: their intersection is rounding error.
const PARALLEL: f64 = 1e-20;

/// The point nearest to the origin outside of all `half_spaces`, or on their planes; `None` if
/// there is none within `reach`, or if the search does not converge.
///
/// # Complexity
/// O(number of half-spaces) per step.
pub fn nearest_to_origin(half_spaces: &[HalfSpace], reach: f64) -> Option<DVec3> {
    nearest_with_planes(half_spaces, reach).map(|nearest| nearest.point)
}

/// The nearest point outside of half-spaces, and the planes that determine it.
pub struct NearestPoint {
    /// The point.
    pub point: DVec3,
    planes: [HalfSpace; 3],
    count: usize,
}

impl NearestPoint {
    /// The planes, of which there are at most three, each with its weight: the point is the sum of
    /// their normals times their weights, which are not negative.
    pub fn weighted(&self) -> impl Iterator<Item = (HalfSpace, f64)> {
        let planes = self.planes;
        let weights = match planes[..self.count] {
            [a] => [a.offset, 0.0, 0.0],
            [a, b] => {
                let c = a.normal.dot(b.normal);
                let sine_sq = a.normal.cross(b.normal).length_squared();
                [(a.offset - c * b.offset) / sine_sq, (b.offset - c * a.offset) / sine_sq, 0.0]
            }
            [a, b, c] => {
                let [bc, ca, ab] = [b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal)];
                let determinant = a.normal.dot(bc);
                [bc, ca, ab].map(|cross| cross.dot(self.point) / determinant)
            }
            _ => [0.0; 3],
        };
        planes.into_iter().zip(weights.map(|weight| weight.max(0.0))).take(self.count)
    }
}

/// [`nearest_to_origin`] with the planes that determine the point.
pub fn nearest_with_planes(half_spaces: &[HalfSpace], reach: f64) -> Option<NearestPoint> {
    let mut held: [HalfSpace; 3] = [HalfSpace { normal: DVec3::X, offset: 0.0 }; 3];
    let mut count = 0;
    let mut x = DVec3::ZERO;
    for _ in 0..MAX_STEPS {
        let mut worst = (0.0, None);
        for half_space in half_spaces {
            let missing = half_space.offset - half_space.normal.dot(x);
            if missing > worst.0 + SLACK * (half_space.offset.abs() + x.length()) {
                worst = (missing, Some(*half_space));
            }
        }
        let Some(violated) = worst.1 else { return Some(NearestPoint { point: x, planes: held, count }) };
        let step = with(&held[..count], violated);
        let progress = step.filter(|(nearest, ..)| nearest.length_squared() > x.length_squared());
        let Some((nearest, kept, kept_count)) = progress else {
            // Accept rounding error; otherwise, the planes have no common point.
            let is_rounding = worst.0 <= LIMIT * (violated.offset.abs() + x.length());
            return is_rounding.then_some(NearestPoint { point: x, planes: held, count });
        };
        // Written so that NaN fails.
        if !(nearest.length() < reach) {
            return None;
        }
        (x, held, count) = (nearest, kept, kept_count);
    }
    None
}

/// The nearest point outside of `held` and `new`, and its planes, with `new`.
fn with(held: &[HalfSpace], new: HalfSpace) -> Option<(DVec3, [HalfSpace; 3], usize)> {
    let mut best: Option<(DVec3, [HalfSpace; 3], usize)> = None;
    // Every choice of at most two active planes.
    for choice in 0..1_u32 << held.len() {
        if choice.count_ones() > 2 {
            continue;
        }
        let mut planes = [new; 3];
        let mut count = 1;
        for (index, half_space) in held.iter().enumerate() {
            if choice >> index & 1 == 1 {
                planes[count] = *half_space;
                count += 1;
            }
        }
        let Some(x) = on_planes(&planes[..count]) else { continue };
        // The chosen planes hold except for rounding error. The others are tested with a tolerance,
        // because small angles between planes amplify the error.
        let is_inside = |(index, h): (usize, &HalfSpace)| {
            choice >> index & 1 == 1 || h.normal.dot(x) >= h.offset - AMPLIFIED * (x.length() + h.offset.abs())
        };
        let inside = held.iter().enumerate().all(is_inside);
        // If rounding error leaves several candidates, take the nearest.
        if inside && best.is_none_or(|(other, ..)| x.length_squared() < other.length_squared()) {
            best = Some((x, planes, count));
        }
    }
    best
}

/// The point nearest to the origin on one to three `planes`; `None` if a nearer point is outside of
/// their half-spaces, or if they are parallel.
fn on_planes(planes: &[HalfSpace]) -> Option<DVec3> {
    match planes {
        [a] => (a.offset >= 0.0).then(|| a.normal * a.offset),
        [a, b] => {
            let c = a.normal.dot(b.normal);
            let sine_sq = a.normal.cross(b.normal).length_squared();
            let (s, t) = (a.offset - c * b.offset, b.offset - c * a.offset);
            (sine_sq > PARALLEL && s >= 0.0 && t >= 0.0).then(|| (a.normal * s + b.normal * t) / sine_sq)
        }
        [a, b, c] => {
            let normals = DMat3::from_cols(a.normal, b.normal, c.normal);
            let determinant = normals.determinant();
            if !(determinant * determinant > PARALLEL * PARALLEL) {
                return None;
            }
            let [bc, ca, ab] = [b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal)];
            let x = (bc * a.offset + ca * b.offset + ab * c.offset) / determinant;
            // The point's weights of the normals. No weight may be negative.
            let weights = DVec3::new(bc.dot(x), ca.dot(x), ab.dot(x)) / determinant;
            (weights.min_element() >= 0.0).then_some(x)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    fn slow(half_spaces: &[HalfSpace]) -> Option<DVec3> {
        let mut best: Option<DVec3> = None;
        let all = half_spaces.len();
        let mut consider = |x: Option<DVec3>| {
            let Some(x) = x else { return };
            let inside = half_spaces.iter().all(|h| h.normal.dot(x) >= h.offset - 1e-9);
            if inside && best.is_none_or(|other| x.length() < other.length()) {
                best = Some(x);
            }
        };
        consider(Some(DVec3::ZERO));
        for i in 0..all {
            consider(on_planes(&[half_spaces[i]]));
            for j in 0..i {
                consider(on_planes(&[half_spaces[i], half_spaces[j]]));
                for k in 0..j {
                    consider(on_planes(&[half_spaces[i], half_spaces[j], half_spaces[k]]));
                }
            }
        }
        best
    }

    #[test]
    fn agrees_with_all_sets_of_planes() {
        let mut rng = SplitMix64::new(11);
        let (mut none, mut some) = (0, 0);
        for round in 0..3_000 {
            let spread = [0.02, 0.1, 1.0, 3.0][round % 4];
            let half_spaces: Vec<HalfSpace> = (0..2 + round % 12)
                .map(|_| {
                    let normal = (DVec3::Z + DVec3::from_array(rng.direction()) * spread).normalize();
                    HalfSpace { normal, offset: rng.between(-0.5, 1.0) }
                })
                .collect();
            match (nearest_to_origin(&half_spaces, 1e6), slow(&half_spaces)) {
                (Some(fast), Some(slow)) => {
                    some += 1;
                    assert!(fast.distance(slow) < 1e-7 * (1.0 + slow.length()), "round {round}: {fast} {slow}");
                }
                (None, Some(slow)) => assert!(slow.length() > 1e3, "round {round}: {slow}"),
                (None, None) => none += 1,
                (Some(fast), None) => panic!("round {round}: {fast} is in no common part"),
            }
        }
        assert!(some > 1_000 && none > 100, "{some} {none}");
    }
}
