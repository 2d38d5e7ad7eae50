//! Cosine and sine of an exact fraction of a full turn.
//!
//! 1. Reduce the fraction to at most an eighth of a turn, in integers and without error.
//! 2. Compute cosine and sine of the remainder, an angle in [0, π/4], with `libm`.
//! 3. Swap and negate the results to undo the reduction.
//!
//! Quarter turns are therefore exact (sin π is 0, not 1.2e-16), and regular polygons are exactly
//! symmetric.

use core::f64::consts::FRAC_PI_2;

/// `(cos, sin)` of `index / count` of a full turn, counter-clockwise.
///
/// `index` may be any integer; whole turns have no effect. Panics if `count` is zero.
pub(crate) fn cos_sin(index: usize, count: usize) -> (f64, f64) {
    assert!(count > 0, "a turn has at least one part");
    let quarters = 4 * (index % count);
    let quarter = quarters / count;
    let rest = quarters % count;
    let (c, s) = if 2 * rest <= count {
        within_eighth(rest, count)
    } else {
        let (c, s) = within_eighth(count - rest, count);
        (s, c)
    };
    match quarter {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}

/// `(cos, sin)` of `rest / count` of a quarter turn, which must be at most a half.
fn within_eighth(rest: usize, count: usize) -> (f64, f64) {
    let angle_rad = FRAC_PI_2 * (rest as f64 / count as f64);
    (libm::cos(angle_rad), libm::sin(angle_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn agrees_with_plain_angles() {
        for count in 1..40 {
            for index in 0..3 * count {
                let (c, s) = cos_sin(index, count);
                let angle_rad = TAU * index as f64 / count as f64;
                assert!((c - libm::cos(angle_rad)).abs() < 1e-14, "{index}/{count}");
                assert!((s - libm::sin(angle_rad)).abs() < 1e-14, "{index}/{count}");
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact_and_polygons_symmetric() {
        let quarters = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        assert_eq!([0, 125, 250, 375].map(|index| cos_sin(index, 500)), quarters);
        for index in 1..250 {
            let (c, s) = cos_sin(index, 500);
            assert_eq!(cos_sin(500 - index, 500), (c, -s));
        }
    }
}
