//! Principal axes of an inertia tensor: the Jacobi eigenvalue algorithm.
//!
//! Rotations make the tensor's element for one pair of axes after the other 0, and converge
//! quadratically to a diagonal. The power iteration of the decomposition gives only a few digits.
//!
//! # Reference
//! Golub and Van Loan, "Matrix Computations", section 8.5.

use glam::{DMat3, DQuat, DVec3};

/// Maximum number of sweeps over the three pairs of axes. Five are usual.
const SWEEPS: usize = 40;

/// Moments about the principal axes, and the rotation from those to the axes of the symmetric
/// `tensor`.
pub fn principal_axes(tensor: DMat3) -> (DVec3, DQuat) {
    let (mut diagonal, mut axes) = (tensor, DMat3::IDENTITY);
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let between = diagonal.col(p)[q];
            if between == 0.0 {
                continue;
            }
            // The tangent of the smaller of the two angles.
            let theta = (diagonal.col(q)[q] - diagonal.col(p)[p]) / (2.0 * between);
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = cosine;
            rotation.col_mut(q)[q] = cosine;
            rotation.col_mut(q)[p] = sine;
            rotation.col_mut(p)[q] = -sine;
            diagonal = rotation.transpose() * diagonal * rotation;
            // Exactly, so that rounding errors do not keep the loop going.
            diagonal.col_mut(p)[q] = 0.0;
            diagonal.col_mut(q)[p] = 0.0;
            axes *= rotation;
        }
    }
    let moments = DVec3::new(diagonal.x_axis.x, diagonal.y_axis.y, diagonal.z_axis.z);
    (moments, DQuat::from_mat3(&axes).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rebuilt(moments: DVec3, rotation: DQuat) -> DMat3 {
        let axes = DMat3::from_quat(rotation);
        axes * DMat3::from_diagonal(moments) * axes.transpose()
    }

    #[test]
    fn a_diagonal_tensor_needs_no_rotation() {
        let (moments, rotation) = principal_axes(DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)));
        assert_eq!((moments, rotation), (DVec3::new(3.0, 1.0, 2.0), DQuat::IDENTITY));
    }

    #[test]
    fn the_axes_rebuild_degenerate_and_random_tensors() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let mut tensors = vec![DMat3::IDENTITY, DMat3::ZERO, DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0))];
        // Two moments are equal.
        for (diagonal, axis) in [([5.0, 5.0, 1.0], [0.0, 1.0, 1.0]), ([1e6, 1e6, 1.0], [3.0, -1.0, 0.5])] {
            let turn = DQuat::from_axis_angle(DVec3::from_array(axis).normalize(), 2.0);
            tensors.push(rebuilt(DVec3::from_array(diagonal), turn));
        }
        for size in [1e-12, 1.0, 1e12] {
            for _ in 0..1000 {
                let [a, b, c] = [0; 3].map(|_| DVec3::new(random(), random(), random()));
                let half = DMat3::from_cols(a, b, c);
                tensors.push(half * half.transpose() * size);
            }
        }
        for tensor in tensors {
            let (moments, axes) = principal_axes(tensor);
            let again = rebuilt(moments, axes);
            let size = tensor.to_cols_array().iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
            let error = (again - tensor).to_cols_array().iter().fold(0.0_f64, |error, entry| error.max(entry.abs()));
            assert!(error <= 1e-14 * size, "{tensor} {moments:?} {axes}: {error}");
        }
    }
}
