//! Results of a build, one row per file.

use serde::Serialize;

use crate::triangle_mesh::MeshSummary;
use hullmap_bake::parts::estimates::DecomposedObject;

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
    pub fn word(self) -> &'static str {
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
    /// Whether the baker is at fault, and not the mesh. Such a failure is not shared.
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
    pub fn surface(&self) -> Option<[usize; 2]> {
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
