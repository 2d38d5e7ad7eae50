//! Tables and numbers as text for people.

use std::io;

use hullmap_geometry::number::LEAST_PLAIN;

use clap::builder::styling::Style;

use crate::terminal::{self, Escaped, Output};

/// A longer cell, such as a long path, shifts the rest of its own row only.
const MAX_WIDTH: usize = 80;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Right,
}

#[derive(Debug)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub fn new(columns: &[(&str, Align)]) -> Self {
        let columns = columns.iter().map(|(title, align)| ((*title).to_owned(), *align)).collect();
        Self { columns, rows: Vec::new() }
    }

    /// A table of these columns, such as `file: | bytes`: a colon follows titles of texts.
    pub fn headed(heads: &str) -> Self {
        let column = |head| match str::strip_suffix(head, ":") {
            Some(title) => (title, Align::Left),
            None => (head, Align::Right),
        };
        Self::new(&heads.split(" | ").map(column).collect::<Vec<_>>())
    }

    pub fn push(&mut self, row: Vec<String>) {
        debug_assert_eq!(row.len(), self.columns.len());
        // Before widths are measured.
        self.rows.push(row.into_iter().map(|cell| Escaped(cell).to_string()).collect());
    }

    /// Separates columns by two spaces. Each is as wide as its widest cell of at most
    /// [`MAX_WIDTH`].
    pub fn write(&self, out: &mut Output) -> io::Result<()> {
        if terminal::is_quiet() {
            return Ok(());
        }
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count()).filter(|width| *width <= MAX_WIDTH);
            cells.chain([self.columns[column].0.len()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let heading: Vec<String> = self.columns.iter().map(|(title, _)| title.clone()).collect();
        for row in [&heading].into_iter().chain(&self.rows) {
            let mut line = String::new();
            for ((cell, &width), (title, align)) in row.iter().zip(&widths).zip(&self.columns) {
                if !line.is_empty() {
                    line.push_str("  ");
                }
                let space = " ".repeat(width.saturating_sub(cell.chars().count()));
                let style = style(cell).filter(|_| title == "status" || title == "result");
                let cell = style.map_or_else(|| cell.clone(), |style| out.painted(cell, style));
                match align {
                    Align::Left => line.extend([cell, space]),
                    Align::Right => line.extend([space, cell]),
                }
            }
            // The cells are escaped.
            out.verbatim(format!("{}\n", line.trim_end()).as_bytes())?;
        }
        Ok(())
    }
}

/// Style of a status or result, as tables name it.
fn style(status: &str) -> Option<Style> {
    match status {
        "FAILED" => Some(terminal::BAD),
        "stale" | "missing" | "orphaned" | "not read" | "passed with warnings" => Some(terminal::DOUBTFUL),
        "baked" | "fresh" | "exact" | "within its bounds" | "contains its source" => Some(terminal::GOOD),
        _ => None,
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

pub fn or_dash<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), show)
}

#[cfg(test)]
mod tests {
    use hullmap_geometry::number::grouped;

    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::headed("file: | bytes");
        table.push(vec!["é".to_owned(), grouped(1_234_567)]);
        table.push(vec!["longer".to_owned(), or_dash(None::<u64>, grouped)]);
        let mut out = Vec::new();
        table.write(&mut Output::new(&mut out)).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "file        bytes\né       1 234 567\nlonger          -\n");
    }

    #[test]
    fn a_long_path_widens_its_own_row_only() {
        let mut table = Table::headed("file: | bytes");
        let long = "x".repeat(1500);
        for name in ["short.obj", &long] {
            table.push(vec![name.to_owned(), "7".to_owned()]);
        }
        let mut out = Vec::new();
        table.write(&mut Output::new(&mut out)).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, format!("file       bytes\nshort.obj      7\n{long}      7\n"));
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
}
