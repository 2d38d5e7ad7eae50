//! Depth of two small hulls in exact arithmetic.
//!
//! All numbers are dyadic, without rounding. Only the choice of the directions that matter is made
//! in f64, with a margin far above its rounding error.
//!
//! # Steps
//! 1. Both hulls in A's frame, times |q|² for the quaternion q of the pose: then the rotation has
//!    no quotient.
//! 2. Directions: the normals of all triples of corners of each face, and the cross products of all
//!    pairs of segments between corners of a face of A and of one of B. A face whose corners are
//!    not exactly in one plane is a cap of several facets. The normals of all of them are among
//!    these directions, whatever facets they are.
//! 3. The support value over the length of the direction, in f64, with its error. Directions that
//!    certainly exceed the minimum are dropped.
//! 4. The others are compared exactly. The minimum is the depth; it is negative if the hulls are
//!    separated.
//!
//! # Deviations
//! - Nothing is taken from the solver: no support query, no index, no matrix of the pose.

use std::cmp::Ordering;

use glam::DVec3;
use hullmap::{Hull, Pose};

use crate::dyadic::{Dyadic, Vector, cross, dot, exact, is_zero, minus};

/// A hull in A's frame, twice: exactly and times |q|², and in f64.
struct Body {
    exact: Vec<Vector>,
    rounded: Vec<DVec3>,
    faces: Vec<Face>,
}

/// Triples of corners that span its planes, and segments between corners.
struct Face {
    triples: Vec<[usize; 3]>,
    segments: Vec<[usize; 2]>,
}

impl Body {
    fn new(hull: &Hull<'_>, place: impl Fn(&Vector) -> Vector, round: impl Fn(DVec3) -> DVec3) -> Self {
        let vertices: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        let exact: Vec<Vector> = vertices.iter().map(|v| place(&exact(*v))).collect();
        let faces = hull.faces().map(|face| Face::new(&face.map(|v| v as usize).collect::<Vec<_>>(), &exact));
        Self { faces: faces.collect(), rounded: vertices.into_iter().map(round).collect(), exact }
    }

    /// The hull of points, of which no faces are known.
    fn of_points(exact: Vec<Vector>) -> Self {
        let rounded = exact.iter().map(|p| DVec3::from_array(p.each_ref().map(Dyadic::rounded))).collect();
        Self { faces: vec![Face::cap(&(0..exact.len()).collect::<Vec<_>>())], rounded, exact }
    }

    fn segments(&self) -> Vec<[usize; 2]> {
        let mut all: Vec<[usize; 2]> = self.faces.iter().flat_map(|face| &face.segments).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

impl Face {
    fn new(corners: &[usize], points: &[Vector]) -> Self {
        let first =
            cross(&minus(&points[corners[1]], &points[corners[0]]), &minus(&points[corners[2]], &points[corners[0]]));
        let height = |v: &usize| dot(&first, &minus(&points[*v], &points[corners[0]])).sign();
        let spans = first.iter().any(|c| c.sign() != Ordering::Equal);
        if spans && corners.iter().all(|v| height(v) == Ordering::Equal) {
            let next = corners.iter().cycle().skip(1);
            let segments = corners.iter().zip(next).map(|(v, w)| [*v.min(w), *v.max(w)]).collect();
            return Self { triples: vec![[corners[0], corners[1], corners[2]]], segments };
        }
        Self::cap(corners)
    }

    /// Several facets, whichever they are.
    fn cap(corners: &[usize]) -> Self {
        let (mut triples, mut segments) = (Vec::new(), Vec::new());
        for k in 0..corners.len() {
            for j in 0..k {
                segments.push([corners[j].min(corners[k]), corners[j].max(corners[k])]);
                triples.extend((0..j).map(|i| [corners[i], corners[j], corners[k]]));
            }
        }
        Self { triples, segments }
    }
}

/// Signed depth: a quotient h / (|n| s) with the square root in |n|, as exact numbers.
#[derive(Clone, Debug)]
pub struct Depth {
    /// h: the support value along n of the difference, times s.
    height: Dyadic,
    /// |n|² s².
    scale_sq: Dyadic,
}

impl Depth {
    /// Whether the hulls share a point: `Greater` if they penetrate, `Equal` if they touch, `Less`
    /// if they are separated.
    pub fn sign(&self) -> Ordering {
        self.height.sign()
    }

    /// Compares the depth with `length`, which must be finite.
    pub fn compare(&self, length: f64) -> Ordering {
        self.compare_with(&Dyadic::new(length), &Dyadic::new(1.0))
    }

    fn compare_with(&self, height: &Dyadic, scale_sq: &Dyadic) -> Ordering {
        let (own, other) = (self.sign(), height.sign());
        if own != other || own == Ordering::Equal {
            return own.cmp(&other);
        }
        let own_sq = self.height.times(&self.height).times(scale_sq);
        let other_sq = height.times(height).times(&self.scale_sq);
        if own == Ordering::Greater { own_sq.compare(&other_sq) } else { other_sq.compare(&own_sq) }
    }
}

/// Rounding error of a coordinate or a support value in f64, over the size of the pair, with a
/// margin of ten.
const ERROR: f64 = 1e-14;

/// Error of a direction from which it counts as unknown.
const UNKNOWN: f64 = 1e-2;

/// Where a direction comes from: three points of one hull, or two points of each.
#[derive(Clone, Copy)]
enum Source {
    OnA([usize; 3]),
    OnB([usize; 3]),
    Edges([usize; 2], [usize; 2]),
}

/// The exact depth of two hulls that have faces. Complexity: O(e² n) in f64 for e segments and n
/// vertices of each hull, and exact for the directions that are close to the minimum. Made for
/// hulls of up to 32 vertices. Panics if a hull has no faces, or if both are in one plane.
pub fn depth(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose) -> Depth {
    let [x, y, z, w] = b_in_a.rotation().to_array().map(Dyadic::new);
    let two = Dyadic::new(2.0);
    let scale = [&x, &y, &z, &w].iter().fold(Dyadic::zero(), |sum, c| sum.plus(&c.times(c)));
    let shift = b_in_a.translation().to_array().map(|c| Dyadic::new(c).times(&scale));
    let axis = [x, y, z];
    let place_a = |p: &Vector| p.each_ref().map(|c| c.times(&scale));
    // |q|² R p = (w² − |v|²) p + 2 (v·p) v + 2 w (v × p)
    let straight = w.times(&w).minus(&dot(&axis, &axis));
    let place_b = |p: &Vector| {
        let along = two.times(&dot(&axis, p));
        let side = cross(&axis, p);
        let turn = two.times(&w);
        std::array::from_fn(|i| {
            let turned = straight.times(&p[i]).plus(&along.times(&axis[i])).plus(&turn.times(&side[i]));
            turned.plus(&shift[i])
        })
    };
    let a = Body::new(a, place_a, |p| p);
    let b = Body::new(b, place_b, |p| b_in_a.transform_point(p));
    exact_minimum(&a, &b, &scale)
}

/// The exact depth of the hulls of a few points, which together span the space. A common power of
/// two scales all coordinates to about 1.
pub fn depth_of_points(a: Vec<Vector>, b: Vec<Vector>) -> Depth {
    exact_minimum(&Body::of_points(a), &Body::of_points(b), &Dyadic::new(1.0))
}

fn exact_minimum(a: &Body, b: &Body, scale: &Dyadic) -> Depth {
    let size = a.rounded.iter().chain(&b.rounded).map(|p| p.length()).fold(0.0, f64::max);
    let mut near: Vec<(f64, Source)> = Vec::new();
    let mut least_upper = f64::INFINITY;
    let mut consider = |e: DVec3, f: DVec3, source: Source| {
        let n = e.cross(f);
        let [e, f] = [e.length(), f.length()];
        // A difference of points has the error of both; the angle of the factors magnifies it.
        let direction_error = 4.0 * ERROR * size * (1.0 / e + 1.0 / f) * (e * f / n.length());
        // A direction that f64 cannot represent is kept. NaN takes the other branch.
        if direction_error < UNKNOWN {
            let error = 4.0 * size * (ERROR + direction_error);
            let n = n / n.length();
            let value = support(a, b, n).min(support(a, b, -n));
            least_upper = least_upper.min(value + error);
            near.push((value - error, source));
        } else {
            near.push((f64::NEG_INFINITY, source));
        }
    };
    for (body, is_a) in [(a, true), (b, false)] {
        let source = if is_a { Source::OnA } else { Source::OnB };
        for triple in body.faces.iter().flat_map(|face| &face.triples) {
            let [p, q, r] = triple.map(|v| body.rounded[v]);
            consider(q - p, r - p, source(*triple));
        }
    }
    let segments_b = b.segments();
    for on_a in a.segments() {
        let e = a.rounded[on_a[1]] - a.rounded[on_a[0]];
        for on_b in &segments_b {
            consider(e, b.rounded[on_b[1]] - b.rounded[on_b[0]], Source::Edges(on_a, *on_b));
        }
    }
    near.retain(|(lower, _)| *lower <= least_upper);
    let mut best: Option<Depth> = None;
    for (_, source) in near {
        let n = match source {
            Source::OnA([p, q, r]) => cross(&minus(&a.exact[q], &a.exact[p]), &minus(&a.exact[r], &a.exact[p])),
            Source::OnB([p, q, r]) => cross(&minus(&b.exact[q], &b.exact[p]), &minus(&b.exact[r], &b.exact[p])),
            Source::Edges([p, q], [r, s]) => cross(&minus(&a.exact[q], &a.exact[p]), &minus(&b.exact[s], &b.exact[r])),
        };
        if is_zero(&n) {
            continue;
        }
        let scale_sq = dot(&n, &n).times(&scale.times(scale));
        for n in [n.each_ref().map(Dyadic::clone), n.each_ref().map(|c| Dyadic::zero().minus(c))] {
            let height = exact_support(a, b, &n);
            if best.as_ref().is_none_or(|best| best.compare_with(&height, &scale_sq) == Ordering::Greater) {
                best = Some(Depth { height, scale_sq: scale_sq.clone() });
            }
        }
    }
    best.expect("two hulls with faces span the space")
}

fn support(a: &Body, b: &Body, n: DVec3) -> f64 {
    let most = |points: &[DVec3]| points.iter().map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max);
    most(&a.rounded) + b.rounded.iter().map(|p| -p.dot(n)).fold(f64::NEG_INFINITY, f64::max)
}

fn exact_support(a: &Body, b: &Body, n: &Vector) -> Dyadic {
    let best = |points: &[Vector], order: Ordering| {
        points
            .iter()
            .map(|p| dot(p, n))
            .reduce(|best, next| if next.compare(&best) == order { next } else { best })
            .expect("a hull has vertices")
    };
    best(&a.exact, Ordering::Greater).minus(&best(&b.exact, Ordering::Less))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::{depth::signed_depth, packs::tree_pack, polytope::Polytope, random::RandomPoses};

    #[test]
    fn cubes_have_their_depth() {
        let corners: Vec<[f32; 3]> = (0..8).map(|i| [0, 1, 2].map(|axis| (i >> axis & 1) as f32)).collect();
        let pack = tree_pack(&corners);
        let cube = pack.hull(0).unwrap();
        let at = |x: f64| depth(&cube, &cube, Pose::new(DVec3::new(x, 0.125, 0.0), DQuat::IDENTITY).unwrap());
        assert_eq!(at(0.75).compare(0.25), Ordering::Equal);
        assert_eq!(at(-0.5).compare(0.5), Ordering::Equal);
        assert_eq!(at(1.0).sign(), Ordering::Equal);
        assert_eq!(at(1.5).sign(), Ordering::Less);
        let ulp = 1.0 - f64::EPSILON;
        assert_eq!((at(ulp).sign(), at(ulp).compare(f64::EPSILON)), (Ordering::Greater, Ordering::Equal));
    }

    /// The depth by all facets in f64 is the twin, within its rounding error.
    #[test]
    fn f64_agrees_on_ordinary_poses() {
        let mut rng = SplitMix64::new(4);
        for seed in 0..20 {
            let packs = [seed, seed + 100].map(|seed| tree_pack(&families::rock(14, seed)));
            let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
            let b_in_a = rng.pose(1.0);
            let (truth, _) = signed_depth(&Polytope::new(&a), &Polytope::new(&b).placed(b_in_a), f64::NEG_INFINITY);
            let exact = depth(&a, &b, b_in_a);
            assert_eq!(exact.compare(truth + 1e-13), Ordering::Less, "seed {seed}: {truth}");
            assert_eq!(exact.compare(truth - 1e-13), Ordering::Greater, "seed {seed}: {truth}");
        }
    }
}
