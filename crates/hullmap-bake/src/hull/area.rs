//! Area vectors of triangles and polygons: vectors along the normal, of twice the area in length.
//! They are accurate to a few units in the last place for any shape.
//!
//! 1. Take the two shorter sides of a triangle. Each is accurate to a unit in the last place of its
//!    own length. Two long sides of a needle would lose the difference between their ends.
//! 2. Compute their cross product in f64. Each component is a difference of products with a single
//!    rounding (Kahan).
//! 3. If the cross product is so short that rounding error matters, the corners are nearly
//!    collinear. Compute it exactly, with expansions.
//!
//! The fused multiply-add is libm's: MinGW's `f64::mul_add` rounds twice, and gave packs other
//! bytes on Windows.
//!
//! # Reference
//! Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
//! 1997: expansions; Kahan's difference of products.

use glam::DVec3;
use libm::fma;

/// Sine of the angle between two sides above which rounding turns a normal by less than 1e-9.
const SHARP: f64 = 1e-6;

/// Area vector of a polygon. It points to the side from which the corners appear counter-clockwise.
pub fn area_vector(face: &[u32], positions: &[DVec3]) -> DVec3 {
    let at = |v: u32| positions[v as usize];
    let root = at(face[0]);
    face[1..].windows(2).map(|side| triangle_area_vector([root, at(side[0]), at(side[1])])).sum()
}

/// Area vector of a triangle.
pub fn triangle_area_vector(corners: [DVec3; 3]) -> DVec3 {
    area_vector_from(corners).0
}

/// Area vector of a triangle, and whether its last digits may depend on which corner comes first:
/// not if one side is the longest, since the two others are multiplied in a fixed order.
pub fn area_vector_from([a, b, c]: [DVec3; 3]) -> (DVec3, bool) {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let [ab_sq, bc_sq, ca_sq] = [ab, bc, ca].map(DVec3::length_squared);
    let has_longest = ca_sq > ab_sq.max(bc_sq) || ab_sq > bc_sq.max(ca_sq) || bc_sq > ca_sq.max(ab_sq);
    let (product, sides_sq) = if ca_sq >= ab_sq && ca_sq >= bc_sq {
        (accurate_cross(ab, bc), ab_sq * bc_sq)
    } else if ab_sq >= bc_sq {
        (accurate_cross(bc, ca), bc_sq * ca_sq)
    } else {
        (accurate_cross(ca, ab), ca_sq * ab_sq)
    };
    // NaN, and squares that underflow, take the exact path.
    if product.length_squared() > SHARP * SHARP * sides_sq {
        (product, !has_longest)
    } else {
        (exact_area_vector([a, b, c]), true)
    }
}

/// Cross product with components accurate to two units in the last place despite cancellation.
pub fn accurate_cross(a: DVec3, b: DVec3) -> DVec3 {
    // Kahan's difference of products.
    let minor = |a: f64, b: f64, c: f64, d: f64| {
        let bc = b * c;
        fma(a, d, -bc) - fma(b, c, -bc)
    };
    DVec3::new(minor(a.y, a.z, b.y, b.z), minor(a.z, a.x, b.z, b.x), minor(a.x, a.y, b.x, b.y))
}

/// [`triangle_area_vector`] with exact components, rounded once. F32 positions cannot underflow.
fn exact_area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    let minor = |i: usize, j: usize| {
        let ([p, q], [r, s]) = ([(b[i], a[i]), (c[j], a[j])], [(b[j], a[j]), (c[i], a[i])]);
        let mut sum = Expansion::default();
        sum.add_product(two_difference(p.0, p.1), two_difference(q.0, q.1), 1.0);
        sum.add_product(two_difference(r.0, r.1), two_difference(s.0, s.1), -1.0);
        sum.value()
    };
    DVec3::new(minor(1, 2), minor(2, 0), minor(0, 1))
}

/// `a` + `b` as the rounded sum and its rounding error.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_in_sum = sum - a;
    [sum, (a - (sum - b_in_sum)) + (b - b_in_sum)]
}

/// `a` − `b` as the rounded difference and its rounding error.
fn two_difference(a: f64, b: f64) -> [f64; 2] {
    two_sum(a, -b)
}

/// An exact sum of at most [`TERMS`] non-overlapping numbers in ascending order of magnitude.
#[derive(Default)]
struct Expansion {
    terms: [f64; TERMS],
    count: usize,
}

/// Two products of two sums of two terms each: sixteen terms.
const TERMS: usize = 16;

impl Expansion {
    fn add(&mut self, number: f64) {
        let mut carry = number;
        for term in &mut self.terms[..self.count] {
            [carry, *term] = two_sum(carry, *term);
        }
        self.terms[self.count] = carry;
        self.count += 1;
    }

    /// Adds the product of two sums of two terms each, times `sign`.
    fn add_product(&mut self, a: [f64; 2], b: [f64; 2], sign: f64) {
        for x in a {
            for y in b {
                let product = x * y;
                self.add(sign * fma(x, y, -product));
                self.add(sign * product);
            }
        }
    }

    /// The sum, rounded to f64.
    fn value(&self) -> f64 {
        self.terms[..self.count].iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shapes::rng::SplitMix64;

    /// Triangles of small integers times powers of two, whose area vectors i128 computes exactly.
    #[test]
    fn area_vectors_agree_with_integer_arithmetic() {
        const SEED: u64 = 4;
        let mut rng = SplitMix64::new(SEED);
        let (mut sharp, mut worst) = (0, 0.0_f64);
        for _ in 0..20_000 {
            // The sizes differ by up to 2^40, so that sides and products need more than 53 bits.
            let mut whole = || (rng.between(-9.0, 9.0) as i128) << [0, 0, 20, 40][rng.below(4)];
            let [a, b, c]: [[i128; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| whole()));
            let minor = |i: usize, j: usize| (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
            let truth = [minor(1, 2), minor(2, 0), minor(0, 1)];
            let real = |p: [i128; 3]| DVec3::from_array(p.map(|x| x as f64));
            let corners = [a, b, c].map(real);
            assert_eq!(exact_area_vector(corners), real(truth), "{corners:?}, seed {SEED}");
            let found = triangle_area_vector(corners);
            if truth == [0; 3] {
                assert_eq!(found, DVec3::ZERO, "{corners:?}, seed {SEED}");
                continue;
            }
            worst = worst.max(found.normalize().distance(real(truth).normalize()));
            let sides = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]].map(DVec3::length);
            let shorter = sides[0] * sides[1] * sides[2] / sides.into_iter().fold(0.0, f64::max);
            sharp += usize::from(real(truth).length() < 1e-7 * shorter);
        }
        println!("{sharp} without a wide angle, worst turn of a normal {worst:e}");
        assert!(worst < 1e-9 && sharp > 200, "{worst:e}, {sharp}");
    }

    #[test]
    fn a_polygon_is_the_sum_of_its_triangles() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        assert_eq!(area_vector(&[0, 1, 2, 3], &square), DVec3::Z * 2.0);
        assert_eq!(area_vector(&[3, 2, 1, 0], &square), DVec3::Z * -2.0);
    }
}
