//! A triangle mesh or height field, its source and its verification, before any of it is HTML.

use std::path::Path;

use hullmap::height_field::Layout;
use hullmap::{Asset, EdgeClass, HeightField, TriangleMesh};
use serde::Serialize;

use crate::DisplayMesh;
use crate::display_mesh::{EncodedMesh, MAX_TRIANGLES, encoded_edges};
use crate::html::{count, short};
use crate::input::{Frame, Remarks, Up};
use crate::picture::picture_from_above;
use crate::relief::relief;
use crate::verdict::{FAILED, Verdict};

/// Maximum width and height of a relief on its page and on its card, in pixels.
const RELIEF: usize = 1024;
const THUMBNAIL: usize = 160;

/// Everything that a page needs from outside.
#[derive(Debug)]
pub struct SurfaceInput<'a> {
    /// The file.
    pub path: &'a Path,
    /// Its contents.
    pub asset: &'a Asset,
    /// Name of the source; `None` if it was not found.
    pub source: Option<String>,
    /// The build options, in words.
    pub options: String,
    /// Sentences for the reader.
    pub remarks: Remarks,
    /// Rays and points that were compared; `None` if nothing was.
    pub checks: Option<Checks>,
    /// Number of T-junctions of a triangle mesh.
    pub t_junctions: usize,
    /// Up axis and unit.
    pub frame: Frame,
}

/// Comparisons by brute force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Checks {
    /// Number of rays.
    pub rays: usize,
    /// Number of rays that hit the surface.
    pub ray_hits: usize,
    /// Number of points whose nearest triangle was searched for; `None` for a height field.
    pub points: Option<usize>,
    /// Seed of both.
    pub seed: u64,
    /// Number of wrong answers and entries.
    pub mismatches: usize,
}

/// Everything that a page shows.
#[derive(Debug)]
pub struct SurfaceReport {
    /// The file.
    pub file: String,
    /// Faults, warnings and notes.
    pub remarks: Remarks,
    /// Number of triangles.
    pub triangle_count: usize,
    pub(crate) vertex_count: usize,
    pub(crate) bytes: usize,
    pub(crate) source: Option<String>,
    pub(crate) recorded_source: String,
    pub(crate) options: String,
    pub(crate) format_version: u32,
    pub(crate) checks: Option<Checks>,
    pub(crate) headline: String,
    pub(crate) facts: Vec<(&'static str, String)>,
    /// For the card.
    pub(crate) picture: String,
    pub(crate) view: View,
}

#[derive(Debug)]
pub(crate) enum View {
    Wireframe(DrawnTriangles),
    /// A PNG as a `data:` URL.
    Relief(String),
}

#[derive(Debug, Serialize)]
pub(crate) struct DrawnTriangles {
    up: Up,
    mesh: EncodedMesh,
    classes: Vec<DrawnClass>,
}

#[derive(Debug, Serialize)]
pub(crate) struct DrawnClass {
    pub(crate) name: &'static str,
    /// Number of edges in the whole mesh; an edge that triangles share counts once.
    pub(crate) count: usize,
    /// The edges that are drawn: two 16-bit corner indices each.
    edges: String,
}

impl SurfaceReport {
    /// Gathers what the page shows, in O(n log n) for n triangles.
    pub fn new(input: SurfaceInput) -> Self {
        let SurfaceInput { path, asset, source, options, remarks, checks, t_junctions, frame } = input;
        let bytes = asset.bytes().len();
        let (view, picture, [triangle_count, vertex_count], mut headline, facts) = match asset {
            // It has a page of its own.
            Asset::Pack(_) => (View::Relief(String::new()), String::new(), [0, 0], String::new(), Vec::new()),
            Asset::TriangleMesh(mesh) => {
                let (drawn, picture) = DrawnTriangles::new(mesh, frame.up);
                let facts = mesh_facts(mesh, bytes, t_junctions);
                let counts = [mesh.triangle_count(), mesh.vertex_count()];
                let [x, y, z] = drawn.mesh.size.map(|side| short(side.into()));
                let triangles = count(counts[0] as u64);
                let headline = format!(
                    "A level of {triangles} triangles, kept as they are. It measures {x} × {y} × {z} {}.",
                    frame.unit
                );
                (View::Wireframe(drawn), picture, counts, headline, facts)
            }
            Asset::HeightField(field) => {
                let Layout { columns, rows, .. } = *field.layout();
                let counts = [field.triangle_count() - 2 * field.hole_count(), columns * rows];
                let [x, y, z] = (field.bounds()[1] - field.bounds()[0]).to_array().map(short);
                let headline = format!(
                    "A terrain of {columns} × {rows} heights, kept as they are. It measures {x} × {y} × {z} units."
                );
                let view = View::Relief(relief(field, RELIEF));
                (view, relief(field, THUMBNAIL), counts, headline, field_facts(field, bytes))
            }
        };
        if !remarks.faults.is_empty() {
            headline = FAILED.to_owned();
        } else if source.is_none() {
            headline += " Its source was not found, so nothing was compared with it.";
        }
        Self {
            file: path.display().to_string(),
            remarks,
            triangle_count,
            vertex_count,
            bytes,
            source,
            recorded_source: asset.source_path().to_owned(),
            options,
            format_version: asset.header().format_version,
            checks,
            headline,
            facts,
            picture,
            view,
        }
    }

    pub(crate) fn verdict(&self) -> Verdict {
        if !self.remarks.faults.is_empty() {
            Verdict::Failed
        } else if self.source.is_none() {
            Verdict::SourceNotFound
        } else {
            Verdict::Exact
        }
    }
}

impl DrawnTriangles {
    /// The triangles as far as they are drawn, and a still picture of them.
    fn new(mesh: &TriangleMesh, up: Up) -> (Self, String) {
        let vertices = (0..mesh.vertex_count()).filter_map(|vertex| mesh.vertex(vertex));
        let whole = DisplayMesh {
            points: vertices.map(|vertex| vertex.to_array()).collect(),
            triangles: (0..mesh.triangle_count()).filter_map(|triangle| mesh.corners(triangle)).collect(),
            ..DisplayMesh::default()
        };
        let triangles = 0..mesh.triangle_count();
        let groups = EdgeClass::group(triangles.filter_map(|at| mesh.corners(at).zip(mesh.edge_classes(at))));
        let (thinned, drawn) = whole.with_groups(MAX_TRIANGLES, &groups);
        let classes = EdgeClass::ALL.iter().zip(&groups).zip(&drawn);
        let classes: Vec<DrawnClass> = classes
            .map(|((class, whole), drawn)| DrawnClass {
                name: class.as_str(),
                count: whole.len(),
                edges: encoded_edges(drawn),
            })
            .collect();
        let picture = picture_from_above(&thinned, up);
        (Self { up, mesh: thinned.encoded(&whole), classes }, picture)
    }

    pub(crate) fn classes(&self) -> &[DrawnClass] {
        &self.classes
    }

    pub(crate) fn shown(&self) -> usize {
        self.mesh.shown
    }
}

fn mesh_facts(mesh: &TriangleMesh, bytes: usize, t_junctions: usize) -> Vec<(&'static str, String)> {
    let number = |value: usize| count(value as u64);
    let mut materials: Vec<u16> = (0..mesh.triangle_count()).filter_map(|at| mesh.material(at)).collect();
    materials.sort_unstable();
    materials.dedup();
    vec![
        ("Triangles", number(mesh.triangle_count())),
        ("Vertices", number(mesh.vertex_count())),
        ("File", format!("{} bytes", number(bytes))),
        ("Bytes per triangle", format!("{:.1}", bytes as f64 / mesh.triangle_count().max(1) as f64)),
        ("Materials", number(materials.len())),
        ("Merged vertices", number(mesh.merged_count())),
        ("Degenerate triangles", number(mesh.degenerate_count())),
        ("Duplicate triangles", number(mesh.duplicate_count())),
        ("T-junctions", number(t_junctions)),
    ]
}

fn field_facts(field: &HeightField, bytes: usize) -> Vec<(&'static str, String)> {
    let number = |value: usize| count(value as u64);
    let Layout { columns, rows, origin, spacing, diagonal } = *field.layout();
    let cells = columns.saturating_sub(1) * rows.saturating_sub(1);
    let [low, high] = field.bounds().map(|corner| corner.z);
    vec![
        ("Vertices", format!("{} along x, {} along y", number(columns), number(rows))),
        ("Holes", format!("{} of {} cells", number(field.hole_count()), number(cells))),
        ("File", format!("{} bytes", number(bytes))),
        ("Bytes per cell", format!("{:.1}", bytes as f64 / cells.max(1) as f64)),
        ("Heights", format!("{low} to {high}")),
        ("Origin", format!("{} {}", origin[0], origin[1])),
        ("Spacing", format!("{} {}", spacing[0], spacing[1])),
        ("Diagonals", diagonal.as_str().to_owned()),
    ]
}
