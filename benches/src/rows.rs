//! Measurements as rows of named fields: tables for terminals, and a CSV file.

use std::{fmt::Write, fs, path::PathBuf, process::Command, process::ExitCode};

/// Rows with the same columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// One row.
#[derive(Clone, Copy, Debug)]
pub struct Row<'r> {
    columns: &'r [String],
    fields: &'r [String],
}

impl<'r> Row<'r> {
    /// A field. Panics if there is no such column.
    pub fn text(self, column: &str) -> &'r str {
        let at = self.columns.iter().position(|name| name == column);
        &self.fields[at.unwrap_or_else(|| panic!("column {column:?} is missing"))]
    }

    /// A field as a number; NaN if it is empty. Panics if it is neither.
    pub fn number(self, column: &str) -> f64 {
        let text = self.text(column);
        if text.is_empty() { f64::NAN } else { text.parse().unwrap_or_else(|_| panic!("{column}: {text:?}")) }
    }

    /// The quotient of two numbers, with three significant digits.
    pub fn ratio(self, column: &str, to: &str) -> String {
        three_digits(self.number(column) / self.number(to))
    }
}

impl Rows {
    /// No rows yet.
    pub fn new(columns: &[&str]) -> Self {
        Self { columns: columns.iter().map(|&name| name.to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row. Panics if a field cannot be written without quotes, or if there are more or
    /// fewer fields than columns.
    pub fn push(&mut self, fields: Vec<String>) {
        assert_eq!(fields.len(), self.columns.len(), "{fields:?}");
        assert!(!fields.iter().any(|field| field.contains(['"', ',', '\n'])), "{fields:?}");
        self.rows.push(fields);
    }

    /// All rows.
    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|fields| Row { columns: &self.columns, fields })
    }

    /// A CSV file.
    pub fn to_csv(&self) -> String {
        std::iter::once(&self.columns).chain(&self.rows).map(|fields| fields.join(",") + "\n").collect()
    }

    /// Reads a CSV file of [`to_csv`](Self::to_csv). Panics if it is malformed.
    pub fn from_csv(text: &str) -> Self {
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let mut rows = Self::new(&lines.next().expect("a header line"));
        lines.for_each(|fields| rows.push(fields.into_iter().map(str::to_owned).collect()));
        rows
    }

    /// A table: a line for each combination of the fields `labels`, and a column for each value of
    /// the field `across`, in the order of the rows. Rows without a `cell` do not count.
    pub fn table(
        &self,
        title: &str,
        labels: &[&str],
        across: &str,
        cell: impl Fn(Row<'_>) -> Option<String>,
    ) -> String {
        let mut heads = vec![format!("{} by {across}", labels.join(", "))];
        let mut lines: Vec<Vec<String>> = Vec::new();
        for row in self.iter() {
            let Some(cell) = cell(row) else { continue };
            let label = labels.iter().map(|label| row.text(label)).collect::<Vec<_>>().join(", ");
            let head = row.text(across);
            let column = heads.iter().skip(1).position(|other| other == head).map_or(heads.len(), |at| at + 1);
            heads.resize(heads.len().max(column + 1), head.to_owned());
            let line = lines.iter().position(|line| line[0] == label).unwrap_or_else(|| {
                lines.push(vec![label]);
                lines.len() - 1
            });
            let line = &mut lines[line];
            line.resize(line.len().max(column + 1), "-".to_owned());
            line[column] = cell;
        }
        let mut text = format!("{title}\n");
        let width = |column: usize| {
            let cells = lines.iter().chain([&heads]).filter_map(|line| line.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        for line in std::iter::once(&heads).chain(&lines) {
            let cells = line.iter().enumerate().skip(1);
            let cells: String =
                cells.map(|(column, cell)| format!("  {cell:>width$}", width = width(column))).collect();
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {:<width$}{cells}", line[0], width = width(0));
        }
        text
    }
}

/// Three significant digits, at most two decimals.
pub fn three_digits(value: f64) -> String {
    // NaN takes the last branch.
    let decimals = if value < 9.995 {
        2
    } else if value < 99.95 {
        1
    } else {
        0
    };
    format!("{value:.decimals$}")
}

/// Ends a program: prints what the measurement ran on, and writes CSV files.
pub fn finish(files: &[(PathBuf, &Rows)]) -> ExitCode {
    eprint!("{}", machine());
    for (path, rows) in files {
        if let Err(error) = fs::write(path, rows.to_csv()) {
            eprintln!("error: cannot write {}: {error}", path.display());
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

/// Processor, last-level cache, compiler and commit, one line for each.
pub fn machine() -> String {
    let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let cache = fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size").unwrap_or_default();
    let output_of = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output();
        output.map_or(String::new(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    format!(
        "processor: {}, {} cores, last-level cache {}\ncompiler: {}\ncommit: {}\n",
        processor.map_or("unknown", |(_, model)| model),
        std::thread::available_parallelism().map_or(1, usize::from),
        cache.trim(),
        output_of("rustc", &["--version"]),
        output_of("git", &["describe", "--always", "--dirty", "--exclude=*"])
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Rows {
        Rows::from_csv("n,query,ns\n8,contact,10\n8,distance,\n32,contact,300\n")
    }

    #[test]
    fn files_are_read_back() {
        assert_eq!(Rows::from_csv(&rows().to_csv()), rows());
        let numbers: Vec<f64> = rows().iter().map(|row| row.number("ns")).collect();
        assert!(numbers[0] == 10.0 && numbers[1].is_nan() && numbers[2] == 300.0, "{numbers:?}");
    }

    #[test]
    #[should_panic(expected = "n,query")]
    fn quotes_are_not_written() {
        rows().push(["n,query", "a", "b"].map(str::to_owned).to_vec());
    }

    #[test]
    fn gaps_are_marked() {
        let all = rows().table("title", &["query"], "n", |row| Some(row.text("ns").to_owned()));
        assert_eq!(all, "title\n  query by n   8   32\n  contact     10  300\n  distance      \n");
        let large = rows().table("title", &["query", "n"], "query", |row| (row.number("ns") > 99.0).then(String::new));
        assert_eq!(large, "title\n  query, n by query  contact\n  contact, 32               \n");
    }

    #[test]
    fn three_digits_count() {
        assert_eq!([0.034, 1.234, 34.56, 345.6].map(three_digits), ["0.03", "1.23", "34.6", "346"]);
    }
}
