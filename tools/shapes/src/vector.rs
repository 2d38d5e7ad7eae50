//! Three-vectors in `f64`. Shapes are computed in double precision and rounded to `f32` once.

pub(crate) type Vec3 = [f64; 3];

pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scale(a: Vec3, s: f64) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: Vec3) -> f64 {
    libm::sqrt(dot(a, a))
}

/// `a` at unit length. `a` must not be zero.
pub(crate) fn normalized(a: Vec3) -> Vec3 {
    scale(a, 1.0 / length(a))
}

/// `a` rounded to single precision, with negative zero made zero.
pub(crate) fn to_f32(a: Vec3) -> [f32; 3] {
    // In round-to-nearest, -0 + 0 is +0, and x + 0 is x for every other x.
    a.map(|x| x as f32 + 0.0)
}

/// `a` in double precision, exactly.
pub(crate) fn to_f64(a: [f32; 3]) -> Vec3 {
    a.map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_to_single_drops_the_sign_of_zero() {
        let bits = to_f32([-0.0, -1e-60, -1.5]).map(f32::to_bits);
        assert_eq!(bits, [0.0_f32, 0.0, -1.5].map(f32::to_bits));
    }

    #[test]
    fn cross_product_is_right_handed() {
        assert_eq!(cross([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
    }
}
