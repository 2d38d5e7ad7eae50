//! The tables in benches/README.md match the committed result.

use std::{fs, path::Path};

use hullmap_bench::{comparison, matrix::Matrix};

/// The result behind them.
const RESULT: &str = "benches/results/2026-11-27-contact-zen4.csv";

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).expect(path)
}

#[test]
fn tables_are_up_to_date() {
    let (result, page) = (read(RESULT), read("benches/README.md"));
    for query in ["contact", "intersects", "distance"] {
        let table: Matrix = comparison::table(&result, query).unwrap();
        assert!(page.contains(&table.to_markdown()), "benches/README.md lacks:\n{}", table.to_markdown());
    }
}
