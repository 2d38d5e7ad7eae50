//! Tables of the scenes, and their CSV.

use super::race::{Cell, Engine, Order, SceneQuery};
use crate::{csv::Csv, eviction::last_level_bytes, matrix::Matrix};

/// All measurements of one scene.
#[derive(Clone, Debug)]
pub struct Record {
    /// Number of different hulls.
    pub hulls: usize,
    /// Vertices of each.
    pub vertices: usize,
    /// Name of the index.
    pub index: String,
    /// Bytes of the packs.
    pub bytes: usize,
    /// Times.
    pub cells: Vec<Cell>,
}

impl Record {
    /// Whether the packs are larger than the last-level cache; `None` if its size is unknown.
    pub fn exceeds_cache(&self) -> Option<bool> {
        last_level_bytes().map(|bytes| self.bytes > bytes)
    }

    fn row(&self) -> String {
        let mark = if self.exceeds_cache() == Some(true) { "*" } else { "" };
        let mebibytes = self.bytes as f64 / f64::from(1 << 20);
        format!("{} × {}, {}: {mebibytes:.1} MiB{mark}", self.hulls, self.vertices, self.index)
    }
}

/// A table for each query and order, in nanoseconds, one row for each scene. A star marks packs
/// that are larger than the last-level cache.
pub fn all(records: &[Record]) -> Vec<Matrix> {
    let orders = [Order::Random, Order::Crowd];
    let kinds = orders.into_iter().flat_map(|order| SceneQuery::ALL.map(|query| (order, query)));
    kinds
        .filter_map(|(order, query)| {
            let mut table = Matrix::new(
                &format!("{}, {}: ns per query", query.name(), order.name()),
                "hulls × vertices, index: packs",
            );
            let mut is_empty = true;
            for record in records {
                for cell in record.cells.iter().filter(|cell| cell.order == order && cell.query == query) {
                    table.set(&record.row(), cell.engine.name(), format!("{:.0}", cell.ns));
                    is_empty = false;
                }
            }
            (!is_empty).then_some(table)
        })
        .collect()
}

/// One line for each cell.
pub fn to_csv(records: &[Record]) -> Csv {
    let mut csv = Csv::new(&["hulls", "vertices", "index", "bytes", "order", "query", "engine", "ns"]);
    for record in records {
        for cell in &record.cells {
            csv.line(&[
                record.hulls.to_string(),
                record.vertices.to_string(),
                record.index.clone(),
                record.bytes.to_string(),
                cell.order.name().to_owned(),
                cell.query.name().to_owned(),
                cell.engine.name().to_owned(),
                format!("{:.1}", cell.ns),
            ]);
        }
    }
    csv
}

/// Meaning of the star in the tables on this machine.
pub fn legend() -> String {
    let cache = last_level_bytes().map_or("unknown".to_owned(), |bytes| format!("{} MiB", bytes >> 20));
    format!(
        "Last-level cache: {cache}. A star marks packs that are larger. {} and {} are hullmap, one query after the \
         other and in a batch, in one thread.\n",
        Engine::Loop.name(),
        Engine::Batch.name()
    )
}
