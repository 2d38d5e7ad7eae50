//! Vectors of f32, computed as the kernels do: with or without fused operations.

/// Twice the largest possible f32 would be infinite; every dot product is above this.
pub(super) const LOWEST: f32 = -3.0e38;

/// 2⁻²³: bound on the relative error of one operation.
pub(super) const EPSILON: f32 = f32::EPSILON;

/// A volume above this many times the product of the lengths of two edges and a corner is positive.
pub(super) const CERTAIN: f32 = 16.0 * EPSILON;

pub(super) type Vector = [f32; 3];

pub(super) fn mad<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { libm::fmaf(a, b, c) } else { a * b + c }
}

pub(super) fn dot<const FUSED: bool>(a: Vector, b: Vector) -> f32 {
    mad::<FUSED>(a[2], b[2], mad::<FUSED>(a[1], b[1], a[0] * b[0]))
}

pub(super) fn cross<const FUSED: bool>(a: Vector, b: Vector) -> Vector {
    [
        mad::<FUSED>(a[1], b[2], -(a[2] * b[1])),
        mad::<FUSED>(a[2], b[0], -(a[0] * b[2])),
        mad::<FUSED>(a[0], b[1], -(a[1] * b[0])),
    ]
}

pub(super) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, by: f32) -> Vector {
    [a[0] * by, a[1] * by, a[2] * by]
}

pub(super) fn l1(a: Vector) -> f32 {
    a[0].abs() + a[1].abs() + a[2].abs()
}
