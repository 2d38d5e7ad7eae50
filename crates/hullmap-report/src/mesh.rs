//! A triangle mesh, its source and its verification, before any of it is HTML.

use std::path::Path;

use hullmap::{EdgeClass, TriangleMesh};
use serde::Serialize;

use crate::DisplayMesh;
use crate::display_mesh::{EncodedMesh, MAX_TRIANGLES, encoded_edges};
use crate::html::count;
use crate::input::{Remarks, Up};
use crate::pack_page::Verdict;
use crate::picture::picture;

/// Everything that a page needs from outside.
#[derive(Debug)]
pub struct MeshInput<'a> {
    /// The file.
    pub path: &'a Path,
    /// The mesh in it.
    pub mesh: &'a TriangleMesh,
    /// Name of the source; `None` if it was not found.
    pub source: Option<String>,
    /// The build options, in words.
    pub options: String,
    /// Sentences for the reader.
    pub remarks: Remarks,
    /// Rays and points that were compared; `None` if nothing was.
    pub checks: Option<Checks>,
    /// Number of T-junctions.
    pub t_junctions: usize,
    /// The axis that points up.
    pub up: Up,
}

/// Comparisons by brute force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Checks {
    /// Number of rays.
    pub rays: usize,
    /// Number of rays that hit the mesh.
    pub ray_hits: usize,
    /// Number of points whose nearest triangle was searched for.
    pub points: usize,
    /// Seed of both.
    pub seed: u64,
    /// Number of wrong answers and entries.
    pub mismatches: usize,
}

/// Everything that a page shows.
#[derive(Debug)]
pub struct MeshReport {
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
    pub(crate) facts: Vec<(&'static str, String)>,
    pub(crate) picture: String,
    pub(crate) drawn: DrawnTriangles,
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

impl MeshReport {
    /// Gathers what the page shows, in O(n log n) for n triangles.
    pub fn new(input: MeshInput) -> Self {
        let MeshInput { path, mesh, source, options, remarks, checks, t_junctions, up } = input;
        let vertices = (0..mesh.vertex_count()).filter_map(|vertex| mesh.vertex(vertex));
        let whole = DisplayMesh {
            points: vertices.map(|vertex| vertex.to_array()).collect(),
            triangles: (0..mesh.triangle_count()).filter_map(|triangle| mesh.corners(triangle)).collect(),
            ..DisplayMesh::default()
        };
        let triangles = 0..mesh.triangle_count();
        let groups = edges_by_class(triangles.filter_map(|at| mesh.corners(at).zip(mesh.edge_classes(at))));
        let (thinned, drawn) = whole.with_groups(MAX_TRIANGLES, &groups);
        let classes = EdgeClass::ALL.iter().zip(&groups).zip(&drawn);
        let classes: Vec<DrawnClass> = classes
            .map(|((class, whole), drawn)| DrawnClass {
                name: class.as_str(),
                count: whole.len(),
                edges: encoded_edges(drawn),
            })
            .collect();
        let picture = picture(&[], std::slice::from_ref(&thinned), up);
        let bytes = mesh.bytes().len();
        Self {
            file: path.display().to_string(),
            remarks,
            triangle_count: mesh.triangle_count(),
            vertex_count: mesh.vertex_count(),
            bytes,
            source,
            recorded_source: mesh.source_path().to_owned(),
            options,
            format_version: mesh.header().format_version,
            checks,
            facts: facts(mesh, bytes, t_junctions),
            picture,
            drawn: DrawnTriangles { up, mesh: thinned.encoded(&whole), classes },
        }
    }

    pub(crate) fn verdict(&self) -> Verdict {
        if !self.remarks.faults.is_empty() {
            Verdict::Failed
        } else if self.source.is_none() {
            Verdict::ExactForTheStoredTriangles
        } else {
            Verdict::Exact
        }
    }
}

impl DrawnTriangles {
    pub(crate) fn classes(&self) -> &[DrawnClass] {
        &self.classes
    }

    pub(crate) fn shown(&self) -> usize {
        self.mesh.shown
    }
}

/// The edges of each class, each once, in the order of [`EdgeClass::ALL`], in O(n log n).
/// `triangles` are corners, and the classes of the edges from each to the next.
pub fn edges_by_class(triangles: impl IntoIterator<Item = ([u32; 3], [EdgeClass; 3])>) -> Vec<Vec<[u32; 2]>> {
    let mut groups = vec![Vec::new(); EdgeClass::ALL.len()];
    for ([a, b, c], classes) in triangles {
        for ([from, to], class) in [[a, b], [b, c], [c, a]].into_iter().zip(classes) {
            groups[usize::from(class.code())].push([from.min(to), from.max(to)]);
        }
    }
    for edges in &mut groups {
        edges.sort_unstable();
        edges.dedup();
    }
    groups
}

fn facts(mesh: &TriangleMesh, bytes: usize, t_junctions: usize) -> Vec<(&'static str, String)> {
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
