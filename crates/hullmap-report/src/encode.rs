//! Arrays of numbers as text in a page: little-endian bytes in base64.

use base64::{Engine, engine::general_purpose::STANDARD};

pub fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

pub fn words(numbers: impl IntoIterator<Item = u16>) -> String {
    base64(&numbers.into_iter().flat_map(u16::to_le_bytes).collect::<Vec<_>>())
}

/// Run-length encoding: pairs of a count and the difference from the previous value, in seven bits
/// per byte, the lowest first; the top bit is set in all but a number's last byte. Differences are
/// zigzag-encoded: d ≥ 0 as 2d, d < 0 as −2d − 1.
pub fn runs(numbers: &[u32]) -> String {
    joined_runs(numbers.iter().map(|number| (1, *number)))
}

/// [`runs`] of pairs of a count and a number. Equal numbers in a row are joined.
pub fn joined_runs(counted: impl IntoIterator<Item = (u64, u32)>) -> String {
    let mut bytes = Vec::new();
    let mut before = 0_i64;
    let mut add = |(count, number): (u64, u32)| {
        let change = i64::from(number) - before;
        before = i64::from(number);
        push(&mut bytes, count);
        push(&mut bytes, ((change << 1) ^ (change >> 63)) as u64);
    };
    let mut last: Option<(u64, u32)> = None;
    for (count, number) in counted {
        match &mut last {
            Some(run) if run.1 == number => run.0 += count,
            _ => last.replace((count, number)).into_iter().for_each(&mut add),
        }
    }
    last.into_iter().for_each(add);
    base64(&bytes)
}

fn push(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 128 {
        bytes.push(number as u8 | 128);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// A coordinate between `low` and `low + size` as a 16-bit fraction. NaN becomes 0.
pub fn fraction(x: f64, low: f64, size: f64) -> u16 {
    ((x - low) / size * f64::from(u16::MAX)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_short() {
        // One run: 5 times +3; then once −203 (2·203 − 1 = 405 = 0b11·128 + 21).
        assert_eq!(runs(&[3; 5]), base64(&[5, 6]));
        assert_eq!(runs(&[203, 0]), base64(&[1, 0x96, 3, 1, 0x95, 3]));
        assert_eq!(runs(&[]), "");
        assert_eq!(joined_runs([(2, 3), (3, 3), (1, 203)]), runs(&[3, 3, 3, 3, 3, 203]));
    }

    #[test]
    fn fractions_stay_in_range() {
        assert_eq!([0.0, 0.5, 1.0, -1.0, 2.0].map(|x| fraction(x, 0.0, 1.0)), [0, 32768, 65535, 0, 65535]);
        assert_eq!(fraction(1.0, 1.0, 0.0), 0);
        assert_eq!(words([1, 0xff00]), base64(&[1, 0, 0, 0xff]));
    }
}
