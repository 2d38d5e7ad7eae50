//! Tables and numbers as text for people.

use std::io;

use crate::terminal::{Escaped, Output};

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Rows of cells under a heading.
#[derive(Debug)]
pub struct Table {
    columns: Vec<(&'static str, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(columns: &[(&'static str, Align)]) -> Self {
        Self { columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Adds a row with a cell for each column.
    pub fn push(&mut self, row: Vec<String>) {
        debug_assert_eq!(row.len(), self.columns.len());
        // Before widths are measured.
        self.rows.push(row.into_iter().map(|cell| Escaped(cell).to_string()).collect());
    }

    /// Writes heading and rows, two spaces between columns.
    pub fn write(&self, out: &mut Output) -> io::Result<()> {
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count());
            cells.chain([self.columns[column].0.len()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let heading: Vec<String> = self.columns.iter().map(|(title, _)| (*title).to_owned()).collect();
        for row in [&heading].into_iter().chain(&self.rows) {
            let mut line = String::new();
            for ((cell, &width), &(_, align)) in row.iter().zip(&widths).zip(&self.columns) {
                if !line.is_empty() {
                    line.push_str("  ");
                }
                match align {
                    Align::Left => line.push_str(&format!("{cell:<width$}")),
                    Align::Right => line.push_str(&format!("{cell:>width$}")),
                }
            }
            out.line(line.trim_end())?;
        }
        Ok(())
    }
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

/// Significant digits: an f32, the type of all geometry, has between 7 and 8.
const DIGITS: usize = 7;

/// Numbers below this, and above the square of its inverse, are written with an exponent: `1e-5`,
/// not `0.00001`.
const LEAST_PLAIN: f64 = 1e-4;

/// A number with at most [`DIGITS`] significant digits and no trailing zeros, for any magnitude.
pub fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    // Rounded first: 9.99999999e-5 is 1e-4.
    let text = format!("{value:.*e}", DIGITS - 1);
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    let size = value.abs();
    if (LEAST_PLAIN..1.0 / (LEAST_PLAIN * LEAST_PLAIN)).contains(&size) {
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let decimals = (DIGITS as i32 - 1 - exponent).max(0) as usize;
        let plain = format!("{value:.decimals$}");
        if plain.contains('.') { plain.trim_end_matches('0').trim_end_matches('.').to_owned() } else { plain }
    } else {
        format!("{digits}e{exponent}")
    }
}

/// A coordinate with the fewest digits that distinguish it from every other f32.
pub fn shortest(x: f32) -> String {
    let size = f64::from(x).abs();
    if x == 0.0 {
        "0".to_owned()
    } else if (LEAST_PLAIN..1.0 / (LEAST_PLAIN * LEAST_PLAIN)).contains(&size) || !x.is_finite() {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// The value, or a dash for `None`.
pub fn or_dash<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), show)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(&[("file", Align::Left), ("bytes", Align::Right)]);
        table.push(vec!["é".to_owned(), grouped(1_234_567)]);
        table.push(vec!["longer".to_owned(), or_dash(None::<u64>, grouped)]);
        let mut out = Vec::new();
        table.write(&mut Output::new(&mut out)).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "file        bytes\né       1 234 567\nlonger          -\n");
    }

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
            (12_345_678.9, "12345679"),
            (100.0, "100"),
            (1e20, "1e20"),
            (f64::INFINITY, "inf"),
            (f64::from(0.1_f32), "0.1"),
        ] {
            assert_eq!(rounded(value), expected, "{value:e}");
            let back: f64 = rounded(value).parse().unwrap();
            assert!(back == value || (back - value).abs() <= 5e-7 * value.abs(), "{value:e}");
        }
        assert_eq!(rounded(f64::NAN), "NaN");
    }

    #[test]
    fn neighbours_among_coordinates_differ() {
        for (x, expected) in
            [(-0.0, "0"), (0.1, "0.1"), (999_999.56, "999999.56"), (2e6, "2000000"), (1.5e20, "1.5e20")]
        {
            assert_eq!(shortest(x), expected);
        }
        for x in [1e6_f32, 2_000_000.0, 0.1, 1e-30, 3.4e38, -16_777_216.0, 5e-5] {
            assert_ne!(shortest(x), shortest(x.next_up()));
            assert_eq!(shortest(x).parse(), Ok(x));
        }
    }

    #[test]
    fn digits_group_by_three() {
        assert_eq!([0, 999, 1000, 100_000].map(grouped), ["0", "999", "1 000", "100 000"]);
    }
}
