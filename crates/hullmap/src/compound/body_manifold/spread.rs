//! Choice of a few points of a plane that span a large area.
//!
//! # Steps
//! 1. Compute the convex hull of the points (monotone chain).
//! 2. While it has too many corners, drop the corner with the smallest ear: the triangle of the
//!    corner and its two neighbours. This is the area that is lost with it.
//!
//! # What is left
//! The smallest ear of a polygon of m corners has at most the share 4 sin²(π / m) / m of its area,
//! as in the regular polygon. From any number of corners down to seven, at least 70 % of the area
//! is left, the product of 1 − 4 sin²(π / m) / m over all m from eight on.
//!
//! # Reference
//! Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979. Ears of
//! polygons: Rényi, Sulanke, "Zufällige konvexe Polygone in einem Ringgebiet", 1968.

#![forbid(unsafe_code)]

use glam::DVec2;

/// An ear of at most this share of the polygon's area counts as nothing, so that points that are on
/// a side but for rounding are no corners. It is the share for a regular polygon of 34 corners.
const SLIGHT_EAR: f64 = 1e-3;

/// A polygon whose area is at most this share of the square of its length counts as a line.
const LINE: f64 = 1e-4;

/// Writes the corners of the convex hull of `points` to `corners`, counter-clockwise. `points` has
/// indices, which are sorted, and `at` returns the place of an index.
///
/// Points on an edge of the hull are no corners, and one of several equal points is.
///
/// # Complexity
/// O(n log n) for n points.
pub(super) fn hull(points: &mut [usize], at: impl Fn(usize) -> DVec2, corners: &mut Vec<usize>) {
    let order = |p: &usize, q: &usize| {
        let (a, b) = (at(*p), at(*q));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(p.cmp(q))
    };
    points.sort_unstable_by(order);
    corners.clear();
    let is_left = |p: usize, q: usize, r: usize| (at(q) - at(p)).perp_dot(at(r) - at(p)) > 0.0;
    let append = |chain: &mut Vec<usize>, start: usize, next: usize| {
        // The first of equal points stays.
        if chain.last().is_some_and(|last| at(*last) == at(next)) {
            return;
        }
        while let [.., p, q] = chain.get(start..).unwrap_or_default()
            && !is_left(*p, *q, next)
        {
            chain.pop();
        }
        chain.push(next);
    };
    points.iter().for_each(|next| append(corners, 0, *next));
    let lower = corners.len().saturating_sub(1);
    points.iter().rev().skip(1).for_each(|next| append(corners, lower, *next));
    // The chain ends where it began.
    if let [first, .., last] = corners.as_slice()
        && at(*first) == at(*last)
    {
        corners.pop();
    }
}

/// Drops corners of a convex polygon until at most `most` are left, and those that add almost no
/// area. Corners that are among `kept` are not dropped.
///
/// # Complexity
/// O(n²) for n corners.
pub(super) fn reduce(corners: &mut Vec<usize>, most: usize, kept: &[usize], at: impl Fn(usize) -> DVec2) {
    let all = span(corners, &at);
    let slight = (SLIGHT_EAR * all.area).max(LINE * all.length * all.length);
    while corners.len() > 1 {
        let count = corners.len();
        let corner = |rank: usize| corners.get(rank % count).map_or(DVec2::ZERO, |index| at(*index));
        let around = |rank: usize| [corner(rank + count - 1), corner(rank), corner(rank + 1)];
        let ear = |rank: usize| {
            let [before, own, after] = around(rank);
            0.5 * (own - before).perp_dot(after - before)
        };
        let loss = |rank: usize| {
            let [before, own, after] = around(rank);
            match count {
                // Two points: keep the one that is far from a kept one.
                2 => kept.first().map_or(0.0, |kept| own.distance(at(*kept))),
                // Three points: keep the two that are farthest apart.
                3 => -before.distance(after),
                _ => ear(rank),
            }
        };
        let may_go = |rank: &usize| corners.get(*rank).is_some_and(|corner| !kept.contains(corner));
        let Some(least) = (0..count).filter(may_go).min_by(|p, q| loss(*p).total_cmp(&loss(*q))) else { break };
        let is_slight = count > 2 && ear(least) <= slight;
        if count <= most.max(1) && !is_slight {
            break;
        }
        corners.remove(least);
    }
}

/// Area that the corners of a convex polygon span, in order.
pub(super) fn span(corners: &[usize], at: impl Fn(usize) -> DVec2) -> Span {
    let Some(first) = corners.first().map(|corner| at(*corner)) else { return Span::default() };
    let pairs = corners.iter().zip(corners.iter().skip(1));
    let area = pairs.map(|(p, q)| 0.5 * (at(*p) - first).perp_dot(at(*q) - first)).sum();
    let length = corners.iter().map(|corner| at(*corner).distance(first)).fold(0.0, f64::max);
    Span { area, length }
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    area: f64,
    /// Largest distance from the first point.
    length: f64,
}

impl Span {
    /// Whether this is at least the share `share` of another span.
    pub(super) fn is_at_least(&self, share: f64, other: &Self) -> bool {
        self.area >= share * other.area && (other.area > 0.0 || self.length >= share * other.length)
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    fn corners(places: &[DVec2]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..places.len()).collect();
        let mut corners = Vec::new();
        hull(&mut order, |i| places[i], &mut corners);
        corners
    }

    /// A point is a corner if and only if it is the only one of all points in some closed
    /// half-plane: by brute force over all lines through two points.
    #[test]
    fn corners_are_those_of_brute_force() {
        let mut rng = SplitMix64::new(7);
        for round in 0..500 {
            let count = 1 + round % 12;
            // Few places, so that many points are equal or on a line.
            let mut place = || (rng.unit() * 5.0).floor();
            let places: Vec<DVec2> = (0..count).map(|_| DVec2::new(place(), place())).collect();
            let found = corners(&places);
            let inside = |p: DVec2| {
                // In a segment or a triangle of other places.
                let others: Vec<DVec2> = places.iter().copied().filter(|q| *q != p).collect();
                others.iter().any(|a| {
                    others.iter().any(|b| {
                        let on_line = (*b - *a).perp_dot(p - *a) == 0.0 && (p - *a).dot(p - *b) <= 0.0;
                        on_line
                            || others.iter().any(|c| {
                                let sides = [(a, b), (b, c), (c, a)].map(|(u, v)| (*v - *u).perp_dot(p - *u));
                                (*b - *a).perp_dot(*c - *a) != 0.0
                                    && (sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0))
                            })
                    })
                })
            };
            let mut expected: Vec<[f64; 2]> = places.iter().filter(|p| !inside(**p)).map(|p| p.to_array()).collect();
            let mut got: Vec<[f64; 2]> = found.iter().map(|i| places[*i].to_array()).collect();
            expected.sort_by(|p, q| p.partial_cmp(q).unwrap());
            expected.dedup();
            got.sort_by(|p, q| p.partial_cmp(q).unwrap());
            assert_eq!(got, expected, "round {round}: {places:?}");
            let turns = |i: usize| {
                let at = |k: usize| places[found[(i + k) % found.len()]];
                (at(1) - at(0)).perp_dot(at(2) - at(0))
            };
            assert!(found.len() < 3 || (0..found.len()).all(|i| turns(i) > 0.0), "round {round}");
        }
    }

    /// Regular polygons are the worst known, and random ones lose less.
    #[test]
    fn seven_corners_keep_seven_tenths_of_the_area() {
        let (mut rng, mut worst) = (SplitMix64::new(3), f64::INFINITY);
        for count in 8..200 {
            for regular in [true, false] {
                let mut share = |i: usize| if regular { f64::from(i as u32) / f64::from(count) } else { rng.unit() };
                let places: Vec<DVec2> =
                    (0..count as usize).map(|i| DVec2::from_angle(std::f64::consts::TAU * share(i))).collect();
                let mut left = corners(&places);
                let all = span(&left, |i| places[i]);
                let kept = left[left.len() / 2];
                reduce(&mut left, 7, &[], |i| places[i]);
                worst = f64::min(worst, span(&left, |i| places[i]).area / all.area);
                let mut with = corners(&places);
                reduce(&mut with, 8, &[kept], |i| places[i]);
                assert!(with.contains(&kept) && (7..=8).contains(&with.len()), "{count} points");
                assert!(span(&with, |i| places[i]).is_at_least(0.7, &all), "{count} points");
            }
        }
        println!("the least share is {worst}");
        assert!((0.7..0.95).contains(&worst), "{worst}");
    }
}
