//! The tables of a run, one column for each vertex count, and their CSV.

use super::{
    engines::PairQuery,
    errors::p99_and_worst,
    race::{Coherent, Cold, Mix, Record},
    targets,
};
use crate::{csv::Csv, matrix::Matrix};

/// All tables, fractions of parry's time first.
pub fn all(records: &[Record]) -> Vec<Matrix> {
    vec![
        fractions(records),
        fractions_by_class(records),
        nanoseconds(records),
        costs(records),
        coherent(records),
        coherent_by_class(records),
        errors(records),
        facts(records),
    ]
}

/// Number of goals reached in a run, and number of goals, cold and warm.
pub fn reached(records: &[Record]) -> [usize; 2] {
    let cold = records.iter().flat_map(|record| {
        let cells = record.cold.iter().filter(|cell| cell.mix == Mix::All);
        cells.filter_map(|cell| Some(fraction(cell) <= targets::cold(cell.query, record.n)?))
    });
    let warm = records.iter().flat_map(|record| {
        let cells = record.coherent.iter().filter(|cell| cell.mix == Mix::All);
        cells.filter_map(|cell| Some(warm_ratio(cell) <= targets::warm(cell.query, record.n)?))
    });
    let verdicts: Vec<bool> = cold.chain(warm).collect();
    [verdicts.iter().filter(|reached| **reached).count(), verdicts.len()]
}

fn fraction(cell: &Cold) -> f64 {
    cell.hullmap_ns / cell.parry_ns
}

fn warm_ratio(cell: &Coherent) -> f64 {
    cell.warm_ns / cell.cold_ns
}

fn column(record: &Record) -> String {
    record.n.to_string()
}

fn verdict(reached: bool) -> String {
    if reached { "reached" } else { "missed" }.to_owned()
}

fn fractions(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Time as a fraction of parry3d's, cold", "n");
    for query in PairQuery::ALL {
        for record in records {
            for cell in record.cold.iter().filter(|cell| cell.query == query && cell.mix == Mix::All) {
                table.set(query.name(), &column(record), significant(fraction(cell)));
            }
        }
    }
    table
}

fn fractions_by_class(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Time as a fraction of parry3d's, by class of poses", "n");
    each_cold(records, &mut table, |cell| (cell.mix != Mix::All).then(|| significant(fraction(cell))));
    table
}

fn nanoseconds(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("ns per query, hullmap / parry3d", "n");
    each_cold(records, &mut table, |cell| Some(format!("{:.0} / {:.0}", cell.hullmap_ns, cell.parry_ns)));
    table
}

fn costs(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Support calls (maximum) / iterations per query, hullmap, cold", "n");
    each_cold(records, &mut table, |cell| {
        Some(format!("{:.1} ({}) / {:.1}", cell.support_calls, cell.max_support_calls, cell.iterations))
    });
    table
}

fn each_cold(records: &[Record], table: &mut Matrix, text: impl Fn(&Cold) -> Option<String>) {
    for query in PairQuery::ALL {
        for mix in Mix::ALL {
            for record in records {
                for cell in record.cold.iter().filter(|cell| cell.query == query && cell.mix == mix) {
                    if let Some(text) = text(cell) {
                        table.set(&format!("{}, {}", query.name(), mix.name()), &column(record), text);
                    }
                }
            }
        }
    }
}

fn coherent(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Frame-coherent: warm over cold", "n");
    for query in PairQuery::ALL {
        for record in records {
            for cell in record.coherent.iter().filter(|cell| cell.query == query && cell.mix == Mix::All) {
                table.set(query.name(), &column(record), significant(warm_ratio(cell)));
            }
        }
    }
    table
}

fn coherent_by_class(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Frame-coherent: ns cold / warm; support calls cold / warm", "n");
    for query in PairQuery::ALL {
        for mix in Mix::ALL {
            for record in records {
                for cell in record.coherent.iter().filter(|cell| cell.query == query && cell.mix == mix) {
                    let [cold, warm] = cell.support_calls;
                    let text = format!("{:.0} / {:.0}; {cold:.1} / {warm:.1}", cell.cold_ns, cell.warm_ns);
                    table.set(&format!("{}, {}", query.name(), mix.name()), &column(record), text);
                }
            }
        }
    }
    table
}

/// Goals of the project and what a run reached, cold (fraction of parry's time) and warm (fraction
/// of the cold time).
pub fn goals(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Goals: measured, goal", "n");
    let mut set = |row: String, record: &Record, measured: f64, goal: Option<f64>| {
        if let Some(goal) = goal {
            let cell = format!("{} {}, {}", significant(measured), verdict(measured <= goal), significant(goal));
            table.set(&row, &column(record), cell);
        }
    };
    for record in records {
        for cell in record.cold.iter().filter(|cell| cell.mix == Mix::All) {
            set(format!("{}, cold", cell.query.name()), record, fraction(cell), targets::cold(cell.query, record.n));
        }
        for cell in record.coherent.iter().filter(|cell| cell.mix == Mix::All) {
            set(format!("{}, warm", cell.query.name()), record, warm_ratio(cell), targets::warm(cell.query, record.n));
        }
    }
    table
}

/// Rows of the table of errors: name, 99th percentile and maximum.
fn error_rows(record: &Record) -> [(&'static str, [f64; 2]); 6] {
    let d = &record.differences;
    let (above, below, width) = (|v: f64| v.max(0.0), |v: f64| (-v).max(0.0), |v: f64| v);
    [
        ("parry's depth above the interval", p99_and_worst(&d.depth, above)),
        ("parry's depth below the interval", p99_and_worst(&d.depth, below)),
        ("parry's distance above the interval", p99_and_worst(&d.distance, above)),
        ("parry's distance below the interval", p99_and_worst(&d.distance, below)),
        ("relative width of hullmap's depth interval", p99_and_worst(&d.depth_width, width)),
        ("relative width of hullmap's distance interval", p99_and_worst(&d.distance_width, width)),
    ]
}

fn errors(records: &[Record]) -> Matrix {
    let mut table =
        Matrix::new("parry3d's answers against hullmap's intervals, p99 / worst, relative to the diameter", "n");
    for record in records {
        for (row, [p99, worst]) in error_rows(record) {
            table.set(row, &column(record), format!("{p99:.0e} / {worst:.0e}"));
        }
    }
    table
}

/// Rows of the table of facts with counts.
fn counts(record: &Record) -> [(&'static str, usize); 6] {
    let d = &record.differences;
    [
        ("pairs", d.pairs),
        ("parry's yes/no differs", d.parry_yes_no),
        ("parry finds no contact for an overlapping pair", d.parry_no_contact),
        ("hullmap's depths disproved by parry's normal", d.disproved),
        ("hullmap's contacts that reached a limit", d.limited),
        ("hullmap's contacts stopped by rounding error", d.stalled),
    ]
}

fn facts(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("The sample, and how often answers fail or differ", "n");
    for record in records {
        let column = column(record);
        let percent = |ratio: f64| format!("{:.0} %", 100.0 * ratio);
        table.set("vertices of a hull", &column, format!("{:.1}", record.vertices));
        let rejected = if record.rejected.is_empty() { "none".to_owned() } else { record.rejected.join(", ") };
        table.set("families that parry rejects", &column, rejected);
        table.set("overlapping", &column, percent(record.hit_share));
        table.set("overlapping poses on paths", &column, percent(record.coherent_hit_share));
        for (row, count) in counts(record) {
            table.set(row, &column, count.to_string());
        }
    }
    table
}

/// Times and costs: one line for each vertex count, query and selection of poses.
pub fn to_csv(records: &[Record]) -> Csv {
    let mut csv = Csv::new(&[
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
    for record in records {
        for (cold, coherent) in record.cold.iter().zip(&record.coherent) {
            csv.line(&[
                record.n.to_string(),
                cold.query.name().to_owned(),
                cold.mix.name().to_owned(),
                format!("{:.1}", cold.hullmap_ns),
                format!("{:.1}", cold.parry_ns),
                format!("{:.3}", cold.support_calls),
                cold.max_support_calls.to_string(),
                format!("{:.3}", cold.iterations),
                format!("{:.1}", coherent.cold_ns),
                format!("{:.1}", coherent.warm_ns),
                format!("{:.3}", coherent.support_calls[0]),
                format!("{:.3}", coherent.support_calls[1]),
            ]);
        }
    }
    csv
}

/// The sample and the differences of the answers: one line for each vertex count and measure.
pub fn answers_to_csv(records: &[Record]) -> Csv {
    let mut csv = Csv::new(&["n", "measure", "value"]);
    for record in records {
        let mut line = |measure: &str, value: String| csv.line(&[record.n.to_string(), measure.to_owned(), value]);
        for (row, [p99, worst]) in error_rows(record) {
            line(&format!("{row}: p99"), format!("{p99:.2e}"));
            line(&format!("{row}: worst"), format!("{worst:.2e}"));
        }
        line("vertices of a hull", record.vertices.to_string());
        line("families that parry rejects", record.rejected.join(" "));
        line("overlapping", format!("{:.4}", record.hit_share));
        line("overlapping poses on paths", format!("{:.4}", record.coherent_hit_share));
        for (row, count) in counts(record) {
            line(row, count.to_string());
        }
    }
    csv
}

/// Two significant digits.
fn significant(value: f64) -> String {
    // NaN takes the last branch.
    let digits = if value < 0.0095 {
        4
    } else if value < 0.0995 {
        3
    } else {
        2
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_count() {
        assert_eq!(
            [1.234, 0.304, 0.0954, 0.0342, 0.0042].map(significant),
            ["1.23", "0.30", "0.095", "0.034", "0.0042"]
        );
    }
}
