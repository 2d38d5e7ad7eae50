//! The tables of a run, one column a vertex count.

use super::{
    engines::Query,
    errors::p99_and_worst,
    race::{Coherent, Cold, Mix, Record},
    targets,
};
use crate::matrix::Matrix;

/// All tables, the fractions of parry's time first.
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

/// How many targets of a run are reached, and of how many, cold and warm.
pub fn reached(records: &[Record]) -> [usize; 2] {
    let cold = records.iter().flat_map(|record| {
        let cells = record.cold.iter().filter(|cell| cell.mix == Mix::All);
        cells.filter_map(|cell| Some(fraction(cell) <= targets::cold(cell.query, record.n)?))
    });
    let warm = records.iter().flat_map(|record| {
        let cells = record.coherent.iter().filter(|cell| cell.mix == Mix::All);
        cells.filter_map(|cell| Some(warm_share(cell) <= targets::warm(cell.query, record.n)?))
    });
    let verdicts: Vec<bool> = cold.chain(warm).collect();
    [verdicts.iter().filter(|reached| **reached).count(), verdicts.len()]
}

fn fraction(cell: &Cold) -> f64 {
    cell.ours_ns / cell.parry_ns
}

fn warm_share(cell: &Coherent) -> f64 {
    cell.warm_ns / cell.cold_ns
}

fn column(record: &Record) -> String {
    record.n.to_string()
}

fn verdict(reached: bool) -> String {
    if reached { "reached" } else { "MISSED" }.to_owned()
}

fn fractions(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Time as a fraction of parry3d's, cold", "n");
    for query in Query::ALL {
        for record in records {
            for cell in record.cold.iter().filter(|cell| cell.query == query && cell.mix == Mix::All) {
                let (measured, column) = (fraction(cell), column(record));
                table.set(query.name(), &column, significant(measured));
                if let Some(target) = targets::cold(query, record.n) {
                    table.set(&format!("{}, target", query.name()), &column, significant(target));
                    table.set(&format!("{}, verdict", query.name()), &column, verdict(measured <= target));
                }
            }
        }
    }
    table
}

fn fractions_by_class(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Time as a fraction of parry3d's, by class", "n");
    each_cold(records, &mut table, |cell| (cell.mix != Mix::All).then(|| significant(fraction(cell))));
    table
}

fn nanoseconds(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("ns a query, ours / parry3d's", "n");
    each_cold(records, &mut table, |cell| Some(format!("{:.0} / {:.0}", cell.ours_ns, cell.parry_ns)));
    table
}

fn costs(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Support calls (most) / iterations a query, ours, cold", "n");
    each_cold(records, &mut table, |cell| {
        Some(format!("{:.1} ({}) / {:.1}", cell.support_calls, cell.most_support_calls, cell.iterations))
    });
    table
}

fn each_cold(records: &[Record], table: &mut Matrix, text: impl Fn(&Cold) -> Option<String>) {
    for query in Query::ALL {
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
    for query in Query::ALL {
        for record in records {
            for cell in record.coherent.iter().filter(|cell| cell.query == query && cell.mix == Mix::All) {
                let (measured, column) = (warm_share(cell), column(record));
                table.set(query.name(), &column, significant(measured));
                if let Some(target) = targets::warm(query, record.n) {
                    table.set(&format!("{}, target", query.name()), &column, significant(target));
                    table.set(&format!("{}, verdict", query.name()), &column, verdict(measured <= target));
                }
            }
        }
    }
    table
}

fn coherent_by_class(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("Frame-coherent: ns cold / warm; support calls cold / warm", "n");
    for query in Query::ALL {
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

fn errors(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("parry3d's answers against our intervals, p99 / worst, relative to the diameter", "n");
    for record in records {
        let (d, column) = (&record.differences, column(record));
        let pair = |[p99, worst]: [f64; 2]| format!("{p99:.0e} / {worst:.0e}");
        table.set("parry's depth above ours", &column, pair(p99_and_worst(&d.depth, |v| v.max(0.0))));
        table.set("parry's depth below ours", &column, pair(p99_and_worst(&d.depth, |v| (-v).max(0.0))));
        table.set("parry's distance above ours", &column, pair(p99_and_worst(&d.distance, |v| v.max(0.0))));
        table.set("parry's distance below ours", &column, pair(p99_and_worst(&d.distance, |v| (-v).max(0.0))));
        table.set("our depth interval, relative width", &column, pair(p99_and_worst(&d.depth_width, |v| v)));
        table.set("our distance interval, relative width", &column, pair(p99_and_worst(&d.distance_width, |v| v)));
    }
    table
}

fn facts(records: &[Record]) -> Matrix {
    let mut table = Matrix::new("What was asked, and how often answers fail or differ", "n");
    for record in records {
        let (d, column) = (&record.differences, column(record));
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        table.set("vertices of a hull", &column, format!("{:.1}", record.vertices));
        let refused = if record.refused.is_empty() { "none".to_owned() } else { record.refused.join(", ") };
        table.set("families that parry refuses", &column, refused);
        table.set("pairs", &column, d.pairs.to_string());
        table.set("overlapping", &column, percent(record.hit_share));
        table.set("overlapping frames", &column, percent(record.coherent_hit_share));
        table.set("parry's yes or no differs", &column, d.parry_yes_no.to_string());
        table.set("parry gives no contact for a hit", &column, d.parry_no_contact.to_string());
        table.set("our depths that parry's normal disproves", &column, d.disproved.to_string());
        table.set("our contacts that hit a cap", &column, d.capped.to_string());
        table.set("our contacts that rounding stopped", &column, d.stalled.to_string());
    }
    table
}

/// Two significant digits, as targets are written.
fn significant(value: f64) -> String {
    // NaN and zero take the branch of the many.
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
