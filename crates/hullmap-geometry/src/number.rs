//! Numbers in messages, as people write them: `0.05`, not `5.000e-2`.

/// Numbers below this, or above its inverse square, have an exponent: `1e-5`, not `0.00001`.
pub const LEAST_PLAIN: f64 = 1e-4;

/// Number of significant digits of a length or a ratio in a sentence.
const DIGITS: usize = 3;

/// Number of significant digits that distinguish f32 values: between 7 and 8.
const DIGITS_OF_F32: usize = 7;

/// A length or a ratio in a sentence: three significant digits, or all digits before the point.
pub fn short(value: f64) -> String {
    significant(value, DIGITS)
}

/// A number with at most seven significant digits and no trailing zeros, for any magnitude.
pub fn rounded(value: f64) -> String {
    significant(value, DIGITS_OF_F32)
}

/// A ratio as a percentage, with three significant digits: `2.5%`.
pub fn percent(ratio: f64) -> String {
    short(100.0 * ratio) + "%"
}

/// A number with its digits in groups of three.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A number with `digits` significant digits, or all before the point, without trailing zeros.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let decimals = digits.saturating_sub(1);
    // Rounded first: 9.99999999e-5 is 1e-4.
    let text = format!("{value:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let trimmed = |text: &str| {
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text.to_owned() }
    };
    let size = text.parse().map_or(value.abs(), f64::abs);
    if (LEAST_PLAIN..1.0 / (LEAST_PLAIN * LEAST_PLAIN)).contains(&size) {
        let exponent: i64 = exponent.parse().unwrap_or(0);
        let decimals = (decimals as i64 - exponent).max(0) as usize;
        trimmed(&format!("{value:.decimals$}"))
    } else {
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_digits_that_matter() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (0.1 + 0.2, "0.3"),
            (std::f64::consts::PI, "3.141593"),
            (1e-7, "1e-7"),
            (1.234_567_891e-7, "1.234568e-7"),
            (-1.5e-300, "-1.5e-300"),
            (0.000_123_456_789, "0.0001234568"),
            (0.000_099_999_999_9, "0.0001"),
            (12_345_678.9, "12345679"),
            (100.0, "100"),
            (1e20, "1e20"),
            (f64::INFINITY, "inf"),
            (f64::from(0.1_f32), "0.1"),
        ] {
            assert_eq!(significant(value, 7), expected, "{value:e}");
            let back: f64 = significant(value, 7).parse().unwrap();
            assert!(back == value || (back - value).abs() <= 5e-7 * value.abs(), "{value:e}");
        }
        assert_eq!(significant(f64::NAN, 7), "NaN");
    }

    #[test]
    fn numbers_in_sentences_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (0.05, "0.05"),
            (0.012_345, "0.0123"),
            (9.996, "10"),
            (99.96, "100"),
            (1234.5, "1234"),
            (123_456.0, "123456"),
            (2.0e-7, "2e-7"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(value), expected);
        }
        assert_eq!([0.0, 0.02, 0.123_45, 2.0, 1e-9].map(percent), ["0%", "2%", "12.3%", "200%", "1e-7%"]);
        assert_eq!([0, 999, 1000, 100_000].map(grouped), ["0", "999", "1 000", "100 000"]);
    }
}
