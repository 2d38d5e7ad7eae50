//! Measurements of support queries, and their tables: by mode for terminals, by family for
//! markdown, one line each for CSV.

use shapes::families::Family;

use crate::{
    csv::Csv,
    matrix::Matrix,
    measure::{Mode, Timing},
    rivals::{DEFAULT_INDEX, is_ours},
};

/// One rival on one hull.
#[derive(Clone, Debug)]
pub struct Record {
    /// Family of the hull.
    pub family: Family,
    /// Requested number of points.
    pub n: usize,
    /// Vertices of the hull.
    pub vertices: usize,
    /// The rival.
    pub rival: String,
    /// Bytes in addition to the coordinates.
    pub index_bytes: usize,
    /// Time to build the index, in milliseconds.
    pub build_ms: Option<f64>,
    /// Maximum regret of its answers, relative to the diameter.
    pub max_regret: f64,
    /// Times, mode by mode.
    pub timings: Vec<(Mode, Timing)>,
}

impl Record {
    fn median_ns(&self, mode: Mode) -> Option<f64> {
        self.timings.iter().find(|(m, _)| *m == mode).map(|(_, timing)| timing.median_ns)
    }
}

/// All records of one run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// In the order of measurement.
    pub records: Vec<Record>,
}

impl Report {
    /// Time of the fastest rival that is not ours on the same hull, in nanoseconds.
    fn best_other_ns(&self, like: &Record, mode: Mode) -> Option<f64> {
        self.records
            .iter()
            .filter(|r| r.family == like.family && r.n == like.n && !is_ours(&r.rival))
            .filter_map(|r| r.median_ns(mode))
            .min_by(f64::total_cmp)
    }

    fn families(&self) -> Vec<Family> {
        let mut families = Vec::new();
        for record in &self.records {
            if !families.contains(&record.family) {
                families.push(record.family);
            }
        }
        families
    }

    fn records_of(&self, family: Family) -> impl Iterator<Item = &Record> {
        self.records.iter().filter(move |r| r.family == family)
    }

    fn modes(&self) -> impl Iterator<Item = Mode> {
        Mode::ALL.into_iter().filter(|&mode| self.records.iter().any(|r| r.median_ns(mode).is_some()))
    }

    /// For each family a table in nanoseconds for each mode, then exactness, bytes and build time.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for family in self.families() {
            for mode in self.modes() {
                text += &self.mode_table(family, mode).to_text();
                text.push('\n');
            }
            for table in self.fact_tables(family) {
                text += &table.to_text();
                text.push('\n');
            }
        }
        text
    }

    fn mode_table(&self, family: Family, mode: Mode) -> Matrix {
        let mut table = Matrix::new(&format!("{}, {}, ns per query", family.name(), mode.name()), "n");
        for record in self.records_of(family) {
            if let Some(ns) = record.median_ns(mode) {
                table.set(&record.rival, &record.n.to_string(), nanos(ns));
            }
        }
        for record in self.records_of(family).filter(|r| r.rival == DEFAULT_INDEX) {
            let Some(ns) = record.median_ns(mode) else { continue };
            if let Some(other) = self.best_other_ns(record, mode) {
                table.set("faster than the best other by", &record.n.to_string(), ratio(other / ns));
            }
        }
        table
    }

    fn fact_tables(&self, family: Family) -> [Matrix; 3] {
        let table = |what: &str| Matrix::new(&format!("{}, {what}", family.name()), "n");
        let mut regret = table("maximum regret, relative to the diameter");
        let mut bytes = table("bytes per vertex in addition to the coordinates");
        let mut build = table("time to build the index, ms");
        for record in self.records_of(family) {
            let (row, column) = (&record.rival, record.n.to_string());
            regret.set(row, &column, format!("{:.0e}", record.max_regret));
            bytes.set(row, &column, format!("{:.0}", record.index_bytes as f64 / record.vertices as f64));
            if let Some(ms) = record.build_ms {
                build.set(row, &column, format!("{ms:.1}"));
            }
        }
        [regret, bytes, build]
    }

    /// One table for each family: all modes in a cell, then the maximum regret and the bytes of the
    /// largest hull.
    pub fn to_markdown(&self) -> String {
        let modes: Vec<&str> = self.modes().map(Mode::name).collect();
        let mut text = format!(
            "Cells: {} in ns per query. Regret: maximum over all n, relative to the diameter. Bytes (in addition to the \
             coordinates) and time to build the index: at the largest n.\n",
            modes.join(" / ")
        );
        for family in self.families() {
            let mut table = Matrix::new(family.name(), "n");
            for record in self.records_of(family) {
                let cell: Vec<String> = self.modes().filter_map(|m| record.median_ns(m)).map(nanos).collect();
                table.set(&record.rival, &record.n.to_string(), cell.join(" / "));
            }
            for record in self.records_of(family) {
                let name = &record.rival;
                let same = || self.records_of(family).filter(|r| r.rival == record.rival);
                let regret = same().map(|r| r.max_regret).fold(0.0, f64::max);
                table.set(name, "regret", format!("{regret:.0e}"));
                table.set(name, "B/vertex", format!("{:.0}", record.index_bytes as f64 / record.vertices as f64));
                if let Some(ms) = record.build_ms {
                    table.set(name, "build, ms", format!("{ms:.1}"));
                }
            }
            let ratios = |record: &Record| {
                let ratio = |m| Some(ratio(self.best_other_ns(record, m)? / record.median_ns(m)?));
                self.modes().filter_map(ratio).collect::<Vec<_>>().join(" / ")
            };
            for record in self.records_of(family).filter(|r| r.rival == DEFAULT_INDEX) {
                let column = record.n.to_string();
                table.set(&format!("{DEFAULT_INDEX}, times the best other"), &column, ratios(record));
            }
            text += &format!("\n{}", table.to_markdown());
        }
        text
    }

    /// One line for each family, n, rival and mode, after a header line.
    ///
    /// `to_best` is the time over the time of the fastest rival that is not ours.
    pub fn to_csv(&self) -> Csv {
        let mut csv = Csv::new(&[
            "family",
            "n",
            "vertices",
            "rival",
            "mode",
            "ns",
            "ns_quartile_1",
            "ns_quartile_3",
            "to_best",
            "index_bytes",
            "build_ms",
            "max_regret",
        ]);
        for record in &self.records {
            for (mode, timing) in &record.timings {
                let to_best = self.best_other_ns(record, *mode);
                csv.line(&[
                    record.family.name().to_owned(),
                    record.n.to_string(),
                    record.vertices.to_string(),
                    record.rival.clone(),
                    mode.name().to_owned(),
                    format!("{:.3}", timing.median_ns),
                    format!("{:.3}", timing.quartiles_ns[0]),
                    format!("{:.3}", timing.quartiles_ns[1]),
                    to_best.map_or(String::new(), |other| format!("{:.4}", timing.median_ns / other)),
                    record.index_bytes.to_string(),
                    record.build_ms.map_or(String::new(), |ms| format!("{ms:.3}")),
                    format!("{:e}", record.max_regret),
                ]);
            }
        }
        csv
    }
}

fn nanos(ns: f64) -> String {
    if ns < 10.0 { format!("{ns:.1}") } else { format!("{ns:.0}") }
}

fn ratio(times: f64) -> String {
    if times < 10.0 { format!("{times:.2}") } else { format!("{times:.0}") }
}
