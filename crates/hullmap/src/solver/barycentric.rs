//! Closest point of a segment, triangle or tetrahedron to the origin, in barycentric coordinates.
//!
//! Barycentric coordinates (weights) map a point of the Minkowski difference back to the shapes:
//! the same weights applied to the points of A and of B give the witness points.
//!
//! # Reference
//! Kenwright, Algorithm 1 line 10 and `MapPointOrigin` of Listing 2.
//!
//! # Deviations
//! - Weights are clamped: never negative, with sum 1. The paper's are wrong if the origin projects
//!   outside the portal (libccd#71), and it divides by zero if the portal has no area.
//! - Edges are compared by their distances and not by Voronoi regions. So there is no chain of sign
//!   tests that rounding error could make contradictory.

use glam::DVec3;

/// Minimum sine of the angle between two edges of a triangle. Thinner triangles count as segments.
///
/// The normal of a thinner sliver would have at most five correct digits.
const MIN_SINE: f64 = 1e-10;

/// The point of a segment, triangle or tetrahedron closest to the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest<const N: usize> {
    /// Weights of the vertices: not negative, with sum 1.
    pub(crate) weights: [f64; N],
    pub(crate) point: DVec3,
}

/// The closest point on the segment from `p` to `q`.
pub(crate) fn on_segment(p: DVec3, q: DVec3) -> Nearest<2> {
    let edge = q - p;
    let along = -p.dot(edge);
    let length_sq = edge.length_squared();
    // NaN, and a segment without length, takes the branch of `p`.
    if !(along > 0.0 && length_sq > 0.0) {
        return Nearest { weights: [1.0, 0.0], point: p };
    }
    if along >= length_sq {
        return Nearest { weights: [0.0, 1.0], point: q };
    }
    let t = along / length_sq;
    Nearest { weights: [1.0 - t, t], point: p + edge * t }
}

/// The closest point on the triangle `p`, `q`, `r`. A triangle without area counts as its three
/// edges.
pub(crate) fn on_triangle(p: DVec3, q: DVec3, r: DVec3) -> Nearest<3> {
    let (pq, pr) = (q - p, r - p);
    let n = pq.cross(pr);
    let n_sq = n.length_squared();
    let at_q = -n.dot(p.cross(pr));
    let at_r = n.dot(p.cross(pq));
    let at_p = n_sq - at_q - at_r;
    // NaN takes the failing branch.
    let is_inside = at_p >= 0.0
        && at_q >= 0.0
        && at_r >= 0.0
        && n_sq > MIN_SINE * MIN_SINE * pq.length_squared() * pr.length_squared();
    if is_inside {
        let scale = 1.0 / (at_p + at_q + at_r);
        // The plane gives more accurate digits for a direction than the weights do.
        return Nearest { weights: [at_p * scale, at_q * scale, at_r * scale], point: n * (n.dot(p) / n_sq) };
    }
    let (on_pq, on_qr, on_rp) = (on_segment(p, q), on_segment(q, r), on_segment(r, p));
    let mut best = Nearest { weights: [0.0, on_qr.weights[0], on_qr.weights[1]], point: on_qr.point };
    let on_rp = Nearest { weights: [on_rp.weights[1], 0.0, on_rp.weights[0]], point: on_rp.point };
    let on_pq = Nearest { weights: [on_pq.weights[0], on_pq.weights[1], 0.0], point: on_pq.point };
    for other in [on_rp, on_pq] {
        if other.point.length_squared() < best.point.length_squared() {
            best = other;
        }
    }
    best
}

/// The closest point of the simplex of the first `count` points of `v`, and the clearance of the
/// origin. The clearance is 0 unless the origin is inside a tetrahedron. Then it is the minimum
/// over the faces of a distance times the sine of an angle of the face: the distance of the origin
/// or of the fourth corner from the face. If the clearance exceeds the rounding error `rounding`,
/// the origin is certainly inside.
pub(crate) fn on_simplex(v: [DVec3; 4], count: usize, rounding: f64) -> (Nearest<4>, f64) {
    let [p, q, r, _] = v;
    match count {
        4 => on_tetrahedron(v, rounding),
        3 => (padded(on_triangle(p, q, r)), 0.0),
        2 => (padded(on_segment(p, q)), 0.0),
        _ => (Nearest { weights: [1.0, 0.0, 0.0, 0.0], point: p }, 0.0),
    }
}

fn padded<const N: usize>(nearest: Nearest<N>) -> Nearest<4> {
    let mut weights = [0.0; 4];
    weights[..N].copy_from_slice(&nearest.weights);
    Nearest { weights, point: nearest.point }
}

/// A closest point, and the vertices that span it: one bit for each, in the order of the arguments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SubSimplex {
    pub(crate) point: DVec3,
    pub(crate) mask: u8,
}

/// The closest point on the segment from `p` to the newest vertex `s`, provided that it needs `s`,
/// as it does if `s` was added because it is closer than the rest of the simplex. So the `…_to`
/// functions do half the work of [`on_simplex`].
#[inline(always)]
pub(crate) fn on_segment_to(p: DVec3, s: DVec3) -> SubSimplex {
    let (point, t) = along(s, p - s);
    SubSimplex { point, mask: u8::from(t > 0.0) | u8::from(t < 1.0) << 1 }
}

/// The closest point on the triangle `p`, `q`, `s`, provided that it needs `s`.
#[inline(always)]
pub(crate) fn on_triangle_to(p: DVec3, q: DVec3, s: DVec3) -> SubSimplex {
    let (sp, sq) = (p - s, q - s);
    on_triangle_at(s, sp, sq, sp.cross(sq))
}

/// The closest point on the tetrahedron `p`, `q`, `r`, `s`, provided that it needs `s`. `None` if
/// the origin is inside, or may be.
#[inline(always)]
pub(crate) fn on_tetrahedron_to(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> Option<SubSimplex> {
    let (sp, sq, sr) = (p - s, q - s, r - s);
    // All outward or all inward: the sign of the volume decides.
    let (across_r, across_p, across_q) = (sp.cross(sq), sq.cross(sr), sr.cross(sp));
    let volume = across_r.dot(sr);
    let mut best = None::<SubSimplex>;
    let mut best_sq = f64::INFINITY;
    let mut take = |found: SubSimplex, mask: u8| {
        let found_sq = found.point.length_squared();
        if found_sq < best_sq {
            (best, best_sq) = (Some(SubSimplex { mask, ..found }), found_sq);
        }
    };
    // NaN and a tetrahedron without volume are outside.
    let is_inside = |n: DVec3| n.dot(s) * volume < 0.0;
    if !is_inside(across_r) {
        let found = on_triangle_at(s, sp, sq, across_r);
        take(found, found.mask & 3 | (found.mask & 4) << 1);
    }
    if !is_inside(across_q) {
        let found = on_triangle_at(s, sr, sp, across_q);
        take(found, (found.mask & 1) << 2 | (found.mask & 2) >> 1 | (found.mask & 4) << 1);
    }
    if !is_inside(across_p) {
        let found = on_triangle_at(s, sq, sr, across_p);
        take(found, found.mask << 1);
    }
    best
}

/// The closest point on the segment from `s` to `s + edge`, and its parameter from 0 to 1.
#[inline(always)]
fn along(s: DVec3, edge: DVec3) -> (DVec3, f64) {
    let t = -s.dot(edge) / edge.length_squared();
    // NaN, from a segment without length, takes the branch of `s`.
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < 1.0 { t } else { 1.0 };
    (s + edge * t, t)
}

/// The closest point on the triangle of `s + e`, `s + f` and `s` with the normal `n` = e × f,
/// provided that it needs `s`.
#[inline(always)]
fn on_triangle_at(s: DVec3, e: DVec3, f: DVec3, n: DVec3) -> SubSimplex {
    let n_sq = n.length_squared();
    let (at_e, at_f) = (n.dot(f.cross(s)), n.dot(s.cross(e)));
    let at_s = n_sq - at_e - at_f;
    // One branch instead of four. NaN takes the failing branch.
    let inside = (at_e >= 0.0)
        & (at_f >= 0.0)
        & (at_s >= 0.0)
        & (n_sq > MIN_SINE * MIN_SINE * e.length_squared() * f.length_squared());
    if inside {
        let mask = u8::from(at_e > 0.0) | u8::from(at_f > 0.0) << 1 | u8::from(at_s > 0.0) << 2;
        // The plane gives more accurate digits for a direction than weights do.
        return SubSimplex { point: n * (n.dot(s) / n_sq), mask };
    }
    let ((on_e, at_e), (on_f, at_f)) = (along(s, e), along(s, f));
    if on_e.length_squared() < on_f.length_squared() {
        SubSimplex { point: on_e, mask: u8::from(at_e > 0.0) | u8::from(at_e < 1.0) << 2 }
    } else {
        SubSimplex { point: on_f, mask: u8::from(at_f > 0.0) << 1 | u8::from(at_f < 1.0) << 2 }
    }
}

/// [`on_simplex`] for a solid tetrahedron. A flat one counts as its four faces.
pub(crate) fn on_tetrahedron(v: [DVec3; 4], rounding: f64) -> (Nearest<4>, f64) {
    const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]];
    let mut clearance = f64::INFINITY;
    let mut weights = [0.0; 4];
    let mut best: Option<Nearest<4>> = None;
    for [i, j, k, across] in FACES {
        let n = (v[j] - v[i]).cross(v[k] - v[i]);
        let height_of_corner = n.dot(v[across] - v[i]);
        let height_of_origin = -n.dot(v[i]);
        // The error of a sliver's normal grows as the sine shrinks, so a height counts times the
        // sine.
        let spread = ((v[j] - v[i]).length_squared() * (v[k] - v[i]).length_squared()).sqrt();
        // Strictly on the corner's side of this face, and no higher than the corner: if the four
        // corners are nearly in one plane, their sides are rounding error. A flat tetrahedron and
        // NaN take the failing branch.
        let (corner, origin) = (height_of_corner.abs(), height_of_origin.abs());
        if height_of_corner * height_of_origin > 0.0 && origin <= corner + rounding * spread {
            weights[across] = height_of_origin / height_of_corner;
            clearance = clearance.min(origin.min(corner) / spread);
            continue;
        }
        let on_face = on_triangle(v[i], v[j], v[k]);
        if best.is_none_or(|b| on_face.point.length_squared() < b.point.length_squared()) {
            let mut w = [0.0; 4];
            (w[i], w[j], w[k]) = (on_face.weights[0], on_face.weights[1], on_face.weights[2]);
            best = Some(Nearest { weights: w, point: on_face.point });
        }
    }
    match best {
        Some(nearest) => (nearest, 0.0),
        None => {
            let sum: f64 = weights.iter().sum();
            (Nearest { weights: weights.map(|w| w / sum), point: DVec3::ZERO }, clearance)
        }
    }
}

/// One step of correction for the weights of the first `count` of `points`.
///
/// The blend of the points should be perpendicular to the simplex. The step moves the weights by
/// the component within the simplex, so the remaining error is about the square of the first.
pub(crate) fn corrected_weights(weights: &[f64; 4], points: [DVec3; 4], count: usize) -> [f64; 4] {
    let off = -blend(weights, points);
    let [e, f, g] = [1, 2, 3].map(|i| points[i] - points[0]);
    let by = match count {
        4 => {
            let volume = e.dot(f.cross(g));
            [off.dot(f.cross(g)), e.dot(off.cross(g)), e.dot(f.cross(off))].map(|part| part / volume)
        }
        3 => {
            let n = e.cross(f);
            let n_sq = n.length_squared();
            [off.cross(f).dot(n) / n_sq, e.cross(off).dot(n) / n_sq, 0.0]
        }
        2 => [off.dot(e) / e.length_squared(), 0.0, 0.0],
        _ => [0.0; 3],
    };
    let [p, q, r, s] = *weights;
    // NaN, from a simplex without volume, becomes 0.
    let moved = [p - (by[0] + by[1] + by[2]), q + by[0], r + by[1], s + by[2]].map(|weight| weight.max(0.0));
    let sum: f64 = moved.iter().sum();
    moved.map(|weight| weight / sum)
}

/// The point with barycentric coordinates `weights` among `points`.
pub(crate) fn blend<const N: usize>(weights: &[f64; N], points: [DVec3; N]) -> DVec3 {
    // Relative to the first point, so that shapes far from the origin keep their digits.
    let first = points[0];
    let mut offset = DVec3::ZERO;
    for (weight, point) in weights.iter().zip(points) {
        offset += (point - first) * *weight;
    }
    first + offset
}

#[cfg(test)]
mod tests {
    use ::shapes::rng::SplitMix64;

    use super::*;

    fn assert_weights<const N: usize>(nearest: &Nearest<N>, points: [DVec3; N], expected: DVec3) {
        let sum: f64 = nearest.weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-14 && nearest.weights.iter().all(|w| *w >= 0.0), "{nearest:?}");
        assert!((blend(&nearest.weights, points) - expected).length() < 1e-12, "{nearest:?}");
        assert!((nearest.point - expected).length() < 1e-12, "{nearest:?}");
    }

    #[test]
    fn segment_ends_and_middle() {
        let (p, q) = (DVec3::new(-1.0, 1.0, 0.0), DVec3::new(3.0, 1.0, 0.0));
        assert_weights(&on_segment(p, q), [p, q], DVec3::Y);
        let far = DVec3::new(5.0, 0.0, 0.0);
        assert_weights(&on_segment(p + far, q + far), [p + far, q + far], p + far);
        assert_weights(&on_segment(p - far, q - far), [p - far, q - far], q - far);
        assert_weights(&on_segment(p, p), [p, p], p);
    }

    #[test]
    fn triangle_inside_edge_and_corner() {
        let t = [DVec3::new(-1.0, -1.0, 2.0), DVec3::new(2.0, -1.0, 2.0), DVec3::new(-1.0, 2.0, 2.0)];
        assert_weights(&on_triangle(t[0], t[1], t[2]), t, DVec3::new(0.0, 0.0, 2.0));
        let moved = t.map(|p| p + DVec3::Y * 3.0);
        assert_weights(&on_triangle(moved[0], moved[1], moved[2]), moved, DVec3::new(0.0, 2.0, 2.0));
        let corner = t.map(|p| p + DVec3::new(4.0, 4.0, 0.0));
        assert_weights(&on_triangle(corner[0], corner[1], corner[2]), corner, DVec3::new(3.0, 3.0, 2.0));
    }

    /// Compares the fast path with the slow one, for vertices that GJK would add.
    #[test]
    fn fast_path_with_the_newest_vertex_agrees_with_the_full_simplex() {
        let mut rng = SplitMix64::new(8);
        let mut counts = [0; 5];
        for _ in 0..4000 {
            let at = |rng: &mut SplitMix64| DVec3::from_array(rng.direction()) * rng.between(0.2, 1.0) + DVec3::X * 0.8;
            let mut v = [DVec3::ZERO; 4].map(|_| at(&mut rng));
            for count in 1..4 {
                // As in the search, only the vertices that span the closest point stay.
                let (nearest, _) = on_simplex(v, count, 0.0);
                if nearest.weights[..count].contains(&0.0) {
                    break;
                }
                // A support point: farther towards the origin than the simplex.
                let y = nearest.point;
                while v[count].dot(y) >= y.length_squared() * 0.999 {
                    v[count] = at(&mut rng) * 1.5 - y * 0.1;
                }
                let (slow, within) = on_simplex(v, count + 1, 0.0);
                let [p, q, r, s] = v;
                let fast = match count {
                    1 => Some(on_segment_to(p, q)),
                    2 => Some(on_triangle_to(p, q, r)),
                    _ => on_tetrahedron_to(p, q, r, s),
                };
                assert_eq!(fast.is_none(), within > 0.0);
                if let Some(fast) = fast {
                    assert!((slow.point - fast.point).length() < 1e-12, "{v:?} {slow:?} {fast:?}");
                    let mask = slow.weights.iter().enumerate().fold(0, |mask, (i, w)| mask | u8::from(*w > 0.0) << i);
                    assert_eq!(mask, fast.mask, "{v:?} {slow:?} {fast:?}");
                }
                counts[count + 1] += 1;
            }
        }
        assert!(counts[2..].iter().all(|count| *count > 300), "{counts:?}");
    }

    #[test]
    fn correction_repairs_the_weights_of_slivers() {
        let mut rng = SplitMix64::new(5);
        let (mut worst, mut worst_corrected) = (0.0_f64, 0.0_f64);
        for round in 0..3000 {
            let thin = [1e-4, 1e-6, 1e-8][round % 3];
            let dir = |rng: &mut SplitMix64| DVec3::from_array(rng.direction());
            let (x, y) = (dir(&mut rng), dir(&mut rng));
            let around =
                [x * -1.1 + y * thin * 0.3, x * 0.9 + y * thin * 0.2, x * 0.3 - y * thin * rng.between(0.2, 0.9)];
            // The origin projects into the triangle, at a small height.
            let off = x.cross(y).normalize_or_zero() * 1e-9;
            let [p, q, r] = around.map(|v| v + off);
            let nearest = on_triangle(p, q, r);
            let points = [p, q, r, p];
            let [a, b, c] = nearest.weights;
            let before = blend(&[a, b, c, 0.0], points).length();
            let after = blend(&corrected_weights(&[a, b, c, 0.0], points, 3), points).length();
            (worst, worst_corrected) = (worst.max(before), worst_corrected.max(after));
        }
        assert!(worst > 1e-8, "not representative: no weights needed correction, {worst:e}");
        assert!(worst_corrected < 1.1e-9, "{worst:e} {worst_corrected:e}");
    }

    #[test]
    fn portal_without_area_gives_clamped_weights() {
        let (p, q) = (DVec3::new(-1.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
        for r in [p, q, p * 0.5 + q * 0.5] {
            assert_weights(&on_triangle(p, q, r), [p, q, r], DVec3::Y);
        }
        assert_weights(&on_triangle(p, p, p), [p, p, p], p);
    }

    /// Vertices of the Minkowski difference of a cone and a game hull: the origin is 2.9e-8 beside
    /// their plane, and the sides of three faces are rounding error that happens to agree.
    #[test]
    fn side_of_a_flat_tetrahedron_is_no_proof_that_the_origin_is_inside() {
        let v = [
            DVec3::new(-9.20027783459722, -7.064084524386055, 11.020598654522374),
            DVec3::new(0.0005850233428938978, -0.0019840008592870717, -0.0007831002416036625),
            DVec3::new(-0.0005070516119580759, 0.0017189076262642544, 0.0006787922907864896),
            DVec3::new(3.913897444540737e-5, -0.00013242905352317536, -5.233737762289081e-5),
        ];
        for rounding in [0.0, 2.3e-12] {
            let (nearest, clearance) = on_tetrahedron(v, rounding);
            assert_eq!(clearance, 0.0);
            let distance = nearest.point.length();
            assert!((2.91e-8..2.92e-8).contains(&distance), "{distance:e}");
        }
    }

    #[test]
    fn tetrahedron_inside_outside_and_flat() {
        let v = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::ONE];
        let (nearest, clearance) = on_tetrahedron(v, 0.0);
        assert!(clearance > 0.0);
        assert_weights(&nearest, v, DVec3::ZERO);
        let moved = v.map(|p| p + DVec3::ONE);
        let (nearest, clearance) = on_tetrahedron(moved, 0.0);
        assert_eq!(clearance, 0.0);
        assert!(nearest.point.length() < 1e-12, "one corner lies on the origin");
        let flat = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(-1.0, -1.0, 1.0),
        ];
        let (nearest, clearance) = on_tetrahedron(flat, 0.0);
        assert_eq!(clearance, 0.0);
        assert_weights(&nearest, flat, DVec3::Z);
    }
}
