//! The comparison with parry3d in benches/README.md: its chart and its tables, both from a
//! committed result of `contact-table`.

use crate::{
    chart::{Chart, Scale, Series},
    csv,
    matrix::Matrix,
};

/// Vertex counts of the chart.
const COUNTS: std::ops::RangeInclusive<usize> = 32..=8_192;

/// Lines of the chart: name, query, column of the CSV, and colour.
const LINES: [(&str, &str, &str, &str); 4] = [
    ("parry3d contact", "contact", "parry_ns", "#c2410c"),
    ("parry3d yes/no", "intersects", "parry_ns", "#e59866"),
    ("hullmap contact", "contact", "hullmap_ns", "#1f5f99"),
    ("hullmap yes/no", "intersects", "hullmap_ns", "#5fa8dc"),
];

/// Draws the lines of `text`, the CSV that `contact-table` writes. `source` names the machine and
/// the date. Fails if the CSV is malformed or has no value for a line.
pub fn chart(text: &str, source: &str) -> Result<Chart, String> {
    let series = LINES.map(|(name, query, column, colour)| -> Result<Series, String> {
        let mut points = times(text, query, column)?;
        points.retain(|[n, _]| COUNTS.contains(&(*n as usize)));
        Ok(Series { name: name.to_owned(), points, colour: Some(colour.to_owned()) })
    });
    Ok(Chart {
        title: "Time of a query on two hulls".to_owned(),
        subtitle: format!("{source}; one thread; a third each penetrating, near touching, separated"),
        x_label: "vertices of each hull".to_owned(),
        y_label: "time, \u{b5}s".to_owned(),
        legend_title: String::new(),
        scale: Scale::Logarithmic,
        series: series.into_iter().collect::<Result<_, _>>()?,
    })
}

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
    fn lines_hold_the_values_of_all_poses() {
        let chart = chart(CSV, "somewhere").unwrap();
        let points: Vec<_> = chart.series.iter().map(|s| s.points.clone()).collect();
        assert_eq!(points, [[[32.0, 2.0]], [[32.0, 0.7]], [[32.0, 1.0]], [[32.0, 0.3]]]);
    }

    #[test]
    fn missing_values_are_errors() {
        assert!(chart("n,query,poses\n32,contact,all\n", "").unwrap_err().contains("parry_ns"));
        assert!(chart("n\n32\n", "").unwrap_err().contains("no times"));
    }

    #[test]
    fn tables_hold_times_and_their_ratio() {
        let markdown = table(CSV, "contact").unwrap().to_markdown();
        assert!(markdown.contains("| hullmap, \u{b5}s | 0.00 | 1.00 |"), "{markdown}");
        assert!(markdown.contains("| parry3d / hullmap | 2.00 | 2.00 |"), "{markdown}");
    }
}
