//! Finds the slot of a fan to which a direction belongs.
//!
//! A fan divides the directions around an axis into equal steps of an angle, measured along the
//! outline of a square of side 2, so a full turn is 8. That takes one division and no trigonometric
//! function, whose last digits would differ between machines.

/// A full turn.
pub const TURN: f64 = 8.0;

/// The angle of the point: 0 along x, 2 along y, from −1 to 7. NaN at the origin. One division, no
/// branch.
#[inline]
pub fn angle(x: f64, y: f64) -> f64 {
    let steep = y.abs() > x.abs();
    let (rise, run) = if steep { (-x, y) } else { (y, x) };
    let quarter = f64::from(u8::from(steep) + 2 * u8::from(run < 0.0));
    rise / run + 2.0 * quarter
}

/// The point at any `angle` on the outline of the square: the inverse of [`angle()`].
#[inline]
pub fn point(angle: f64) -> [f64; 2] {
    let quarter = ((angle + 1.0) / 2.0).floor();
    let along = angle - 2.0 * quarter;
    match (quarter as i64).rem_euclid(4) {
        0 => [1.0, along],
        1 => [-along, 1.0],
        2 => [-1.0, -along],
        _ => [along, -1.0],
    }
}

/// Number of words before a fan's slots: the x and the y axis of the frame (three f64 each, low
/// word first), the angle at which the first slot starts (f64), the number of slots per unit of the
/// angle (f64), and the number of bits of a slot's index (one word).
pub const HEAD_WORDS: u32 = 17;

/// Index of the frame's x axis among the f64 values before a fan's slots: of its first coordinate.
pub const X_AXIS: usize = 0;

/// Index of the frame's y axis, likewise.
pub const Y_AXIS: usize = 3;

/// Index of the angle at which the first slot starts, likewise.
pub const START: usize = 6;

/// Index of the number of slots per unit of the angle, likewise.
pub const RATE: usize = 7;

/// Position of the word that states the bits of a fan.
pub const BITS_WORD: u32 = HEAD_WORDS - 1;

/// Maximum number of bits of a fan, which has 2ᵇ slots.
pub const MAX_BITS: u32 = 20;

/// Index of the slot that contains `dir`, in a fan of 2ᵇ slots with b = `bits`. `number` reads the
/// f64 values before the slots, by index. Rounding shifts a unit direction by a few 1e-16. For any
/// input, the result is below 2ᵇ.
#[inline]
pub fn slot(number: impl Fn(usize) -> f64, bits: u32, dir: [f64; 3]) -> u32 {
    let dot = |from: usize| number(from) * dir[0] + number(from + 1) * dir[1] + number(from + 2) * dir[2];
    // The cast saturates, and turns NaN into 0.
    let slot = ((angle(dot(X_AXIS), dot(Y_AXIS)) - number(START)) * number(RATE)) as u32;
    slot.min((1 << (bits & 31)) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_increase_over_a_full_turn() {
        let mut before = -1.0 - 1e-9;
        for step in 0..1000 {
            let turned = std::f64::consts::TAU * (f64::from(step) / 1000.0 - 0.125);
            let angle = angle(turned.cos() * 3e-7, turned.sin() * 3e-7);
            assert!(angle > before && angle < 7.0, "{angle} after {before}");
            before = angle;
        }
        for (point, expected) in [([1.0, 0.0], 0.0), ([0.0, 1.0], 2.0), ([-1.0, 0.0], 4.0), ([0.0, -1.0], 6.0)] {
            assert_eq!(angle(point[0], point[1]), expected);
        }
    }

    /// Regression: past a full turn, `point` was off by a quarter, and a leaf lost its vertices.
    #[test]
    fn points_and_angles_agree_beyond_a_full_turn() {
        for step in -30..90 {
            let turned = f64::from(step) * 0.1 + 1e-15;
            let [x, y] = point(turned);
            let off = (angle(x, y) - turned) / TURN;
            assert!((off - off.round()).abs() < 1e-15, "{turned}");
            assert_eq!(x.abs().max(y.abs()), 1.0);
        }
        for end in [7.0 - 1e-15, 7.0, 7.0 + 4e-15] {
            let [x, y] = point(end);
            assert!((x - 1.0).abs() < 1e-14 && (y + 1.0).abs() < 1e-14, "{x} {y}");
        }
    }

    #[test]
    fn every_direction_gets_a_slot() {
        let numbers = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 2.0];
        let slot = |dir| slot(|i| numbers[i], 4, dir);
        assert_eq!(slot([1.0, 0.0, 9.0]), 2);
        assert_eq!(slot([0.0, -1.0, 9.0]), 14);
        assert_eq!(slot([1.0, -0.9999, 9.0]), 0);
        for odd in [[0.0; 3], [f64::NAN; 3], [f64::INFINITY, 1.0, 0.0], [1e300; 3], [-1e-300; 3]] {
            assert!(slot(odd) < 16);
        }
    }
}
