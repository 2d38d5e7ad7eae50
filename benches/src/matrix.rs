//! A table of text cells with named rows and columns, for terminals and for markdown.

use std::fmt::Write;

/// Rows appear in the order in which they were first set, columns likewise.
#[derive(Clone, Debug, Default)]
pub struct Matrix {
    title: String,
    corner: String,
    columns: Vec<String>,
    rows: Vec<(String, Vec<String>)>,
}

/// Content of a cell that was never set.
const EMPTY: &str = "-";

impl Matrix {
    /// An empty table; `corner` is the heading of the row names.
    pub fn new(title: &str, corner: &str) -> Self {
        Self { title: title.to_owned(), corner: corner.to_owned(), ..Self::default() }
    }

    /// Sets a cell.
    pub fn set(&mut self, row: &str, column: &str, cell: String) {
        let column = match self.columns.iter().position(|c| c == column) {
            Some(index) => index,
            None => {
                self.columns.push(column.to_owned());
                self.columns.len() - 1
            }
        };
        let row = match self.rows.iter().position(|(name, _)| name == row) {
            Some(index) => index,
            None => {
                self.rows.push((row.to_owned(), Vec::new()));
                self.rows.len() - 1
            }
        };
        let cells = &mut self.rows[row].1;
        if cells.len() <= column {
            cells.resize(column + 1, EMPTY.to_owned());
        }
        cells[column] = cell;
    }

    /// All lines of cells, the header first.
    fn lines(&self) -> Vec<Vec<&str>> {
        let head = std::iter::once(self.corner.as_str()).chain(self.columns.iter().map(String::as_str)).collect();
        let body = self.rows.iter().map(|(name, cells)| {
            let cells = (0..self.columns.len()).map(|c| cells.get(c).map_or(EMPTY, String::as_str));
            std::iter::once(name.as_str()).chain(cells).collect()
        });
        std::iter::once(head).chain(body).collect()
    }

    /// Text with columns of equal width, names aligned to the left and cells to the right.
    pub fn to_text(&self) -> String {
        let lines = self.lines();
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let mut text = format!("{}\n", self.title);
        for line in &lines {
            for (column, cell) in line.iter().enumerate() {
                let width = width(column);
                // Writing to a string does not fail.
                let _ = match column {
                    0 => write!(text, "  {cell:<width$}"),
                    _ => write!(text, "  {cell:>width$}"),
                };
            }
            text.push('\n');
        }
        text
    }

    /// A markdown table under a heading.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("### {}\n\n", self.title);
        for (index, line) in self.lines().iter().enumerate() {
            let _ = writeln!(text, "| {} |", line.join(" | "));
            if index == 0 {
                let _ = writeln!(text, "|---|{}", "---:|".repeat(self.columns.len()));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_marked() {
        let mut matrix = Matrix::new("title", "who");
        matrix.set("a", "1", "x".into());
        matrix.set("long", "2", "yy".into());
        assert_eq!(matrix.to_text(), "title\n  who   1   2\n  a     x   -\n  long  -  yy\n");
        assert_eq!(
            matrix.to_markdown(),
            "### title\n\n| who | 1 | 2 |\n|---|---:|---:|\n| a | x | - |\n| long | - | yy |\n"
        );
    }
}
