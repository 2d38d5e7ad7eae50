//! CSV files: comma-separated values with a header line, quoted where necessary.

use std::fmt::Write;

/// Lines of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct Csv {
    columns: usize,
    text: String,
}

impl Csv {
    /// A file with a header line only.
    pub fn new(header: &[&str]) -> Self {
        let mut csv = Self { columns: header.len(), text: String::new() };
        csv.line(header);
        csv
    }

    /// Adds a line. Panics if it does not have as many fields as the header.
    pub fn line<S: AsRef<str>>(&mut self, fields: &[S]) {
        assert_eq!(fields.len(), self.columns, "fields of a line");
        for (at, field) in fields.iter().enumerate() {
            let separator = if at == 0 { "" } else { "," };
            // Writing to a string does not fail.
            let _ = write!(self.text, "{separator}{}", quoted(field.as_ref()));
        }
        self.text.push('\n');
    }

    /// The file.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}

/// The lines of a CSV file without quoted fields, each as its fields by column name. Fails if the
/// file has no header, a quote, or a line with another number of fields; the error names the line.
pub fn parse(text: &str) -> Result<Vec<Vec<(&str, &str)>>, String> {
    let mut lines = text.lines().enumerate();
    let (_, header) = lines.next().ok_or("the file is empty: a header line is missing")?;
    let header: Vec<&str> = header.split(',').collect();
    let fields = |(index, line): (usize, &'_ str)| -> Result<(), String> {
        let count = line.split(',').count();
        if line.contains('"') {
            return Err(format!("line {}: quoted fields are not supported", index + 1));
        }
        if count != header.len() {
            return Err(format!("line {}: {count} fields, but the header has {}", index + 1, header.len()));
        }
        Ok(())
    };
    lines
        .map(|(index, line)| {
            fields((index, line))?;
            Ok(header.iter().copied().zip(line.split(',')).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_necessary() {
        let mut csv = Csv::new(&["a", "b"]);
        csv.line(&["1,5", "say \"x\""]);
        assert_eq!(csv.as_str(), "a,b\n\"1,5\",\"say \"\"x\"\"\"\n");
    }

    #[test]
    fn lines_are_read_by_column() {
        let lines = parse("n,ns\n8,1.5\n32,2\n").unwrap();
        assert_eq!(lines, [[("n", "8"), ("ns", "1.5")], [("n", "32"), ("ns", "2")]]);
        assert_eq!(parse("").unwrap_err(), "the file is empty: a header line is missing");
        assert_eq!(parse("a,b\n1\n").unwrap_err(), "line 2: 1 fields, but the header has 2");
    }
}
