//! The tables in benches/README.md match the committed result.

use std::{fs, path::Path};

use hullmap_bench::rows::{Row, Rows, three_digits};

/// The result behind them.
const RESULT: &str = "benches/results/2026-11-27-contact-zen4.csv";

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).expect(path)
}

#[test]
fn tables_are_up_to_date() {
    let (result, page) = (Rows::from_csv(&read(RESULT)), read("benches/README.md"));
    for query in ["contact", "intersects", "distance"] {
        let rows: Vec<Row<'_>> =
            result.iter().filter(|row| (row.text("query"), row.text("poses")) == (query, "all")).collect();
        assert!(!rows.is_empty(), "{query}");
        let line = |name: &str, cell: &dyn Fn(&Row<'_>) -> String| {
            format!("| {name} | {} |\n", rows.iter().map(cell).collect::<Vec<_>>().join(" | "))
        };
        let table = [
            line("vertices of each hull", &|row| row.text("n").to_owned()),
            format!("|---|{}\n", "---:|".repeat(rows.len())),
            line("hullmap, µs", &|row| three_digits(row.number("hullmap_ns") / 1e3)),
            line("parry3d, µs", &|row| three_digits(row.number("parry_ns") / 1e3)),
            line("parry3d / hullmap", &|row| row.ratio("parry_ns", "hullmap_ns")),
        ];
        let table = format!("### {query}\n\n{}", table.concat());
        assert!(page.contains(&table), "benches/README.md lacks:\n{table}");
    }
}
