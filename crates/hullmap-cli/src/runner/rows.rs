use serde::Serialize;

use crate::outcome::Failure;
use crate::table::{Align, Table, or_dash};
use crate::terminal::Output;
use crate::triangle_mesh::MeshSummary;
use hullmap_bake::number::grouped;
use hullmap_verify::estimates::DecomposedObject;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Baked,
    /// The existing pack is what a bake would write.
    Fresh,
    Failed,
    /// `--check`: the existing pack is not what a bake would write.
    Stale,
    /// `--check`: there is no pack.
    Missing,
    /// A pack whose source is gone.
    Orphaned,
    /// A pack whose source is gone, and that was removed.
    Pruned,
    /// A mesh whose format is not supported.
    Unread,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    Local,
    /// Earlier: `--cache` had it.
    Cache,
}

impl Status {
    /// Name in the table. Failures are in capitals.
    fn word(self) -> &'static str {
        match self {
            Self::Baked => "baked",
            Self::Fresh => "fresh",
            Self::Failed => "FAILED",
            Self::Stale => "stale",
            Self::Missing => "missing",
            Self::Orphaned => "orphaned",
            Self::Pruned => "pruned",
            Self::Unread => "not read",
        }
    }
}

pub const MAX_OBJECTS: usize = 1000;

/// Result of one file. Field names are the JSON's; `None` if the file did not reach that step.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub source: String,
    pub output: String,
    pub status: Status,
    pub reason: Option<String>,
    pub options: Option<String>,
    pub hulls: Option<usize>,
    /// Number of source points, over all hulls.
    pub vertices_in: Option<usize>,
    pub vertices_source: Option<usize>,
    /// Number of vertices that no element references.
    pub vertices_unreferenced: Option<usize>,
    /// Number of points that equal an earlier point.
    pub vertices_duplicate: Option<usize>,
    /// Hull vertices over all hulls.
    pub vertices_hull: Option<usize>,
    /// Rank of each hull: 3 solid, 2 polygon, 1 segment, 0 point.
    pub ranks: Option<Vec<u32>>,
    /// The first [`MAX_OBJECTS`] objects whose meshes were decomposed, or whose parts came with
    /// them; `None` for a pack that was not baked now.
    pub objects: Option<Vec<DecomposedObject>>,
    pub triangle_mesh: Option<MeshSummary>,
    pub height_field: Option<FieldSummary>,
    pub bytes: Option<u64>,
    pub origin: Option<Origin>,
    /// Time from start to end in milliseconds. A thread that waits for others works on another file
    /// meanwhile, so the times of many files add up to more than the whole took.
    pub millis: f64,
    pub notes: Vec<String>,
    /// Findings to act on, each with its remedy.
    pub warnings: Vec<String>,
    pub error: Option<String>,
    /// Whether the fault is the baker's, not the mesh's. Such a failure is not shared.
    #[serde(skip)]
    pub is_internal: bool,
}

/// The contents of a height field. Field names are the JSON's.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FieldSummary {
    pub columns: usize,
    pub rows: usize,
    pub holes: usize,
}

impl Row {
    /// Number of triangles and vertices of a triangle mesh or height field.
    fn surface(&self) -> Option<[usize; 2]> {
        let of_field = |field: &FieldSummary| {
            let cells = field.columns.saturating_sub(1) * field.rows.saturating_sub(1);
            [2 * cells.saturating_sub(field.holes), field.columns * field.rows]
        };
        let of_mesh = self.triangle_mesh.as_ref().map(|mesh| [mesh.triangles, mesh.vertices]);
        of_mesh.or(self.height_field.as_ref().map(of_field))
    }

    pub fn new(source: String, output: String, status: Status) -> Self {
        Self {
            source,
            output,
            status,
            reason: None,
            options: None,
            hulls: None,
            vertices_in: None,
            vertices_source: None,
            vertices_unreferenced: None,
            vertices_duplicate: None,
            vertices_hull: None,
            ranks: None,
            objects: None,
            triangle_mesh: None,
            height_field: None,
            bytes: None,
            origin: None,
            millis: 0.0,
            notes: Vec::new(),
            warnings: Vec::new(),
            error: None,
            is_internal: false,
        }
    }
}

/// Writes one JSON object per line.
pub fn write_json(rows: &[Row], out: &mut Output) -> Result<(), Failure> {
    for row in rows {
        out.json(row)?;
    }
    Ok(out.flush()?)
}

/// Rows of fresh packs and unread meshes are written only if `lists_all`.
pub fn write_table(rows: &[Row], lists_all: bool, is_check: bool, out: &mut Output) -> Result<(), Failure> {
    let is_usual = |row: &Row| matches!(row.status, Status::Fresh | Status::Unread);
    let listed: Vec<&Row> = rows.iter().filter(|row| lists_all || !is_usual(row)).collect();
    if !listed.is_empty() {
        let table = if is_check { check_table(&listed) } else { build_table(&listed) };
        table.write(out)?;
        out.line("")?;
    }
    out.line(summary(rows, is_check))?;
    Ok(out.flush()?)
}

fn build_table(rows: &[&Row]) -> Table {
    let has_triangles = rows.iter().any(|row| row.surface().is_some());
    let triangles = has_triangles.then_some(("triangles", Align::Right));
    let columns: Vec<(&str, Align)> =
        [("source", Align::Left), ("pack", Align::Left), ("hulls", Align::Right), ("points", Align::Right)]
            .into_iter()
            .chain([("vertices", Align::Right), ("rank", Align::Right)])
            .chain(triangles)
            .chain([("bytes", Align::Right), ("ms", Align::Right), ("status", Align::Left)])
            .collect();
    let mut table = Table::new(&columns);
    let number = |value: Option<usize>| or_dash(value, |value| grouped(value as u64));
    for row in rows {
        let [triangles, vertices] = row.surface().map_or([None; 2], |counts| counts.map(Some));
        let mut cells = vec![
            row.source.clone(),
            row.output.clone(),
            number(row.hulls),
            number(row.vertices_in),
            number(row.vertices_hull.or(vertices)),
            or_dash(row.ranks.as_deref(), ranks),
        ];
        if has_triangles {
            cells.push(number(triangles));
        }
        cells.extend([or_dash(row.bytes, grouped), format!("{:.1}", row.millis), row.status.word().to_owned()]);
        table.push(cells);
    }
    table
}

fn check_table(rows: &[&Row]) -> Table {
    let columns = [("status", Align::Left), ("pack", Align::Left), ("why", Align::Left)];
    let mut table = Table::new(&columns);
    for row in rows {
        let why = row.error.as_ref().or(row.reason.as_ref());
        table.push(vec![row.status.word().to_owned(), row.output.clone(), or_dash(why, String::clone)]);
    }
    table
}

/// `3 baked, 9 fresh, 0 failed; 12 hulls in 34 567 bytes`. Triangles are counted if there are any.
fn summary(rows: &[Row], is_check: bool) -> String {
    let count = |status| rows.iter().filter(|row| row.status == status).count();
    let always = if is_check {
        [Status::Fresh, Status::Stale, Status::Missing].as_slice()
    } else {
        &[Status::Baked, Status::Fresh, Status::Failed]
    };
    let rare = [Status::Failed, Status::Orphaned, Status::Pruned, Status::Unread];
    let rare = rare.into_iter().filter(|status| !always.contains(status) && count(*status) > 0);
    let counts = always.iter().copied().chain(rare);
    let cached = rows.iter().filter(|row| row.origin == Some(Origin::Cache)).count() as u64;
    let counts: Vec<String> = counts
        .map(|status| {
            let text = format!("{} {}", grouped(count(status) as u64), status.word().to_lowercase());
            let has_cached = status == Status::Baked && cached > 0;
            if has_cached { format!("{text} ({} from the cache)", grouped(cached)) } else { text }
        })
        .collect();
    if is_check {
        return counts.join(", ");
    }
    let bytes: u64 = rows.iter().filter_map(|row| row.bytes).sum();
    let hulls: usize = rows.iter().filter_map(|row| row.hulls).sum();
    let noun = if hulls == 1 { "hull" } else { "hulls" };
    let triangles: usize = rows.iter().filter_map(Row::surface).map(|[triangles, _]| triangles).sum();
    let contents = match (hulls, triangles) {
        (_, 0) => format!("{} {noun}", grouped(hulls as u64)),
        (0, _) => format!("{} triangles", grouped(triangles as u64)),
        _ => format!("{} {noun} and {} triangles", grouped(hulls as u64), grouped(triangles as u64)),
    };
    format!("{}; {contents} in {} bytes", counts.join(", "), grouped(bytes))
}

fn ranks(ranks: &[u32]) -> String {
    match (ranks.iter().min(), ranks.iter().max()) {
        (Some(min), Some(max)) if min < max => format!("{min}-{max}"),
        (Some(min), _) => min.to_string(),
        _ => "-".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        let row = |status| Row::new("a.obj".to_owned(), "a.hullmap".to_owned(), status);
        [Status::Fresh, Status::Baked, Status::Failed, Status::Fresh, Status::Orphaned].map(row).to_vec()
    }

    fn table(lists_fresh: bool, is_check: bool) -> String {
        let mut out = Vec::new();
        write_table(&rows(), lists_fresh, is_check, &mut Output::new(&mut out)).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn fresh_files_are_counted_but_listed_only_with_verbose() {
        let text = table(false, false);
        assert_eq!(text.lines().count(), 1 + 3 + 2, "{text}");
        assert!(text.ends_with("\n\n1 baked, 2 fresh, 1 failed, 1 orphaned; 0 hulls in 0 bytes\n"), "{text}");
        assert_eq!(table(true, false).lines().count(), 1 + 5 + 2);
        let mut out = Vec::new();
        write_table(&rows()[..1], false, false, &mut Output::new(&mut out)).unwrap();
        assert_eq!(out, b"0 baked, 1 fresh, 0 failed; 0 hulls in 0 bytes\n");
    }

    #[test]
    fn triangles_are_counted_beside_hulls() {
        let mut rows = rows();
        rows[1].triangle_mesh = Some(MeshSummary { triangles: 1200, ..MeshSummary::default() });
        assert!(summary(&rows, false).ends_with("; 1 200 triangles in 0 bytes"), "{}", summary(&rows, false));
        rows[0].hulls = Some(2);
        assert!(summary(&rows, false).ends_with("; 2 hulls and 1 200 triangles in 0 bytes"));
    }

    #[test]
    fn a_check_counts_what_is_stale() {
        let text = table(false, true);
        assert!(text.ends_with("\n\n2 fresh, 0 stale, 0 missing, 1 failed, 1 orphaned\n"), "{text}");
    }
}
