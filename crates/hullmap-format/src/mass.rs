//! Mass of a mesh: whether recorded numbers can be the mass properties of a solid.
//!
//! The second moments of a solid are a positive semidefinite matrix M. Its inertia tensor is tr(M)
//! − M, whose principal moments then are positive and satisfy the triangle inequality.

use rkyv::rend::f64_le;

use crate::archive::{ArchivedMassRecord, MassRecord};

/// Rounding error of second moments, relative to their trace. Negative eigenvalues of this size are
/// accepted. A slab that is 1e-5 times as thick as it is wide has an eigenvalue of 1e-10.
const MOMENT_ROUNDING: f64 = 1e-9;

/// Distance by which a centre may lie outside the box around its hulls, relative to the diagonal of
/// the box: hulls may miss source points by 1e-7 of their diameter.
const CENTRE_ROOM: f64 = 1e-6;

/// Why numbers are not the mass properties of a solid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum MassError {
    /// The volume is not positive and finite.
    #[error("the volume of its mesh is {found} (expected a finite number above 0)")]
    Volume { found: f64 },
    /// The centre of mass is outside the hulls, or not finite.
    #[error("coordinate {axis} of its mesh's centre of mass is {found} (its hulls extend from {low} to {high})")]
    Centre {
        axis: usize,
        found: f64,
        /// Lower bound, with room for what the hulls leave uncovered.
        low: f64,
        high: f64,
    },
    /// No solid has these second moments.
    #[error("the second moments of its mesh are {found:?} (expected a positive semidefinite matrix)")]
    Moments {
        /// The moments: xx, yy, zz, yz, zx, xy.
        found: [f64; 6],
    },
}

impl From<&ArchivedMassRecord> for MassRecord {
    fn from(archived: &ArchivedMassRecord) -> Self {
        Self {
            volume: archived.volume.to_native(),
            centroid: archived.centroid.map(f64_le::to_native),
            second_moments: archived.second_moments.map(f64_le::to_native),
        }
    }
}

/// Checks that a record may be the mass of a mesh whose hulls have the bounds `low` and `high`, and
/// leave at most the distance `uncovered` of its surface outside. The baker and the reader use this
/// check.
///
/// # Errors
/// The volume is not positive, the centre is outside the bounds, or no solid has the moments.
pub fn check(record: &MassRecord, low: [f32; 3], high: [f32; 3], uncovered: f64) -> Result<(), MassError> {
    let found = record.volume;
    // NaN takes the failing branch here and below.
    if !(found > 0.0 && found < f64::INFINITY) {
        return Err(MassError::Volume { found });
    }
    let [low, high] = [low, high].map(|corner| corner.map(f64::from));
    let diagonal = low.iter().zip(&high).map(|(low, high)| (high - low) * (high - low)).sum::<f64>().sqrt();
    let room = CENTRE_ROOM * diagonal + uncovered;
    for (axis, (found, (low, high))) in record.centroid.into_iter().zip(low.into_iter().zip(high)).enumerate() {
        let (low, high) = (low - room, high + room);
        if !(low <= found && found <= high) {
            return Err(MassError::Centre { axis, found, low, high });
        }
    }
    let found = record.second_moments;
    if is_positive_semidefinite(found) { Ok(()) } else { Err(MassError::Moments { found }) }
}

/// Uses a Cholesky decomposition, whose pivots are positive once [`MOMENT_ROUNDING`] is added.
fn is_positive_semidefinite(moments: [f64; 6]) -> bool {
    let [xx, yy, zz, ..] = moments;
    let trace = xx + yy + zz;
    if trace == 0.0 {
        return moments == [0.0; 6];
    }
    // Relative to the trace, nothing overflows: no entry of such a matrix exceeds its trace.
    let [xx, yy, zz, yz, zx, xy] = moments.map(|moment| moment / trace);
    let [xx, yy, zz] = [xx, yy, zz].map(|moment| moment + MOMENT_ROUNDING);
    let second = yy - xy * xy / xx;
    let mixed = yz - xy * zx / xx;
    let third = zz - zx * zx / xx - mixed * mixed / second;
    trace > 0.0 && trace < f64::INFINITY && xx > 0.0 && second > 0.0 && third > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: MassRecord =
        MassRecord { volume: 4.0, centroid: [1.0; 3], second_moments: [0.2, 0.2, 0.2, 0.0, 0.0, 0.0] };

    fn check_in_box(record: &MassRecord) -> Result<(), MassError> {
        check(record, [0.0; 3], [2.0; 3], 0.0)
    }

    #[test]
    fn a_ball_is_accepted_and_odd_numbers_are_not() {
        assert_eq!(check_in_box(&BALL), Ok(()));
        for volume in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(check_in_box(&MassRecord { volume, ..BALL }), Err(MassError::Volume { .. })));
        }
        for outside in [-0.1, 2.1, f64::NAN, f64::INFINITY] {
            let record = MassRecord { centroid: [1.0, outside, 1.0], ..BALL };
            assert!(matches!(check_in_box(&record), Err(MassError::Centre { axis: 1, .. })), "{outside}");
        }
        let record = MassRecord { centroid: [1.0, 2.1, 1.0], ..BALL };
        assert_eq!(check(&record, [0.0; 3], [2.0; 3], 0.2), Ok(()), "within the uncovered distance");
    }

    #[test]
    fn moments_that_no_solid_has_are_rejected() {
        let moments = |second_moments| check_in_box(&MassRecord { second_moments, ..BALL }).is_ok();
        assert!(moments([1.0, 2.0, 3.0, 0.5, -0.5, 0.5]));
        assert!(moments([1.0, 1.0, 1.0, 1.0, 1.0, 1.0]), "all mass on one line");
        assert!(moments([0.0; 6]), "underflow of a tiny solid");
        assert!(moments([1e-300, 2e-300, 3e-300, 0.0, 0.0, 0.0]) && moments([1e200, 1e200, 0.0, 0.0, 0.0, 0.0]));
        assert!(!moments([-1.0, 2.0, 2.0, 0.0, 0.0, 0.0]));
        assert!(!moments([1.0, 1.0, 1.0, 0.0, 0.0, 1.1]));
        assert!(!moments([1.0, 1.0, 1.0, -0.9, 0.9, 0.9]), "each pair is possible, all three are not");
        assert!(!moments([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]));
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            for place in 0..6 {
                let mut changed = BALL.second_moments;
                changed[place] = odd;
                let is_finite_trace = odd == f64::MAX && place < 3;
                assert!(!moments(changed) || is_finite_trace, "{odd} at {place}");
            }
        }
    }
}
