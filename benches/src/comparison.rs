//! The comparison with parry3d in benches/README.md, from a committed result of `contact-table`.

use crate::{csv, matrix::Matrix};

/// The table of one query in benches/README.md: both times, and their ratio. Fails if the CSV is
/// malformed or has no times of the query.
pub fn table(text: &str, query: &str) -> Result<Matrix, String> {
    let mut table = Matrix::new(query, "vertices of each hull");
    let [hullmap, parry] = [times(text, query, "hullmap_ns")?, times(text, query, "parry_ns")?];
    for ([n, hullmap], [_, parry]) in hullmap.into_iter().zip(parry) {
        let column = n.to_string();
        table.set("hullmap, \u{b5}s", &column, three_digits(hullmap));
        table.set("parry3d, \u{b5}s", &column, three_digits(parry));
        table.set("parry3d / hullmap", &column, three_digits(parry / hullmap));
    }
    Ok(table)
}

/// Vertex counts and times of a query in microseconds, over all poses.
fn times(text: &str, query: &str, column: &str) -> Result<Vec<[f64; 2]>, String> {
    let mut times = Vec::new();
    for row in csv::parse(text)? {
        let field = |name: &str| row.iter().find(|(column, _)| *column == name).map(|(_, value)| *value);
        if (field("query"), field("poses")) == (Some(query), Some("all")) {
            let number = |name: &str| {
                let value = field(name).ok_or(format!("column {name:?} is missing"))?;
                value.parse::<f64>().map_err(|_| format!("column {name:?}: {value:?} is not a number"))
            };
            times.push([number("n")?, number(column)? / 1e3]);
        }
    }
    if times.is_empty() { Err(format!("no times of {query:?}")) } else { Ok(times) }
}

/// Three significant digits, at most two decimals.
fn three_digits(value: f64) -> String {
    let decimals = if value < 9.995 {
        2
    } else if value < 99.95 {
        1
    } else {
        0
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "n,query,poses,hullmap_ns,parry_ns\n8,contact,all,1,2\n32,contact,all,1000,2000\n\
                       32,contact,separated,5,6\n32,intersects,all,300,700\n";

    #[test]
    fn missing_values_are_errors() {
        assert!(table("n,query,poses\n32,contact,all\n", "contact").unwrap_err().contains("hullmap_ns"));
        assert!(table("n\n32\n", "contact").unwrap_err().contains("no times"));
    }

    #[test]
    fn tables_hold_times_and_their_ratio() {
        let markdown = table(CSV, "contact").unwrap().to_markdown();
        assert!(markdown.contains("| hullmap, \u{b5}s | 0.00 | 1.00 |"), "{markdown}");
        assert!(markdown.contains("| parry3d / hullmap | 2.00 | 2.00 |"), "{markdown}");
    }
}
