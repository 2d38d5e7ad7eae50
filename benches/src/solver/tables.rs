//! Rows of `contact-table`.

use super::race::Record;
use crate::rows::Rows;

/// Times and work: a row for each vertex count, query and mix.
pub fn times(records: &[Record]) -> Rows {
    let mut rows = Rows::new(&[
        "n",
        "query",
        "poses",
        "hullmap_ns",
        "parry_ns",
        "support_calls",
        "max_support_calls",
        "iterations",
        "path_cold_ns",
        "path_warm_ns",
        "path_cold_support_calls",
        "path_warm_support_calls",
    ]);
    for (record, cell) in records.iter().flat_map(|record| record.cells.iter().map(move |cell| (record, cell))) {
        let [hullmap, parry, cold, warm] = cell.ns.map(|ns| format!("{ns:.1}"));
        let mean = |value: f64| format!("{value:.3}");
        rows.push(vec![
            record.n.to_string(),
            cell.query.name().to_owned(),
            cell.mix.name().to_owned(),
            hullmap,
            parry,
            mean(cell.cold.support_calls),
            cell.cold.max_support_calls.to_string(),
            mean(cell.cold.iterations),
            cold,
            warm,
            mean(cell.paths[0].support_calls),
            mean(cell.paths[1].support_calls),
        ]);
    }
    rows
}

/// The sample and the differences of the answers: a row for each vertex count and measure.
pub fn answers(records: &[Record]) -> Rows {
    let mut rows = Rows::new(&["n", "measure", "value"]);
    for record in records {
        let mut row = |measure: &str, value: String| rows.push(vec![record.n.to_string(), measure.to_owned(), value]);
        row("vertices of a hull", record.vertices.to_string());
        row("families that parry rejects", record.rejected.join(" "));
        row("overlapping poses on paths", format!("{:.4}", record.path_hit_share));
        record.differences.measures().into_iter().for_each(|(measure, value)| row(&measure, value));
    }
    rows
}
