use hullmap::TriangleMesh;
use serde::Serialize;

use crate::options::BuildOptions;
use crate::outcome::Failure;
use crate::sheet_description::{FileDescription, count_materials, list_materials};
use crate::table::shortest;
use crate::terminal::Output;
use crate::triangle_mesh::{MeshSummary, t_junctions_of};
use hullmap_bake::number::grouped;

/// Description of a triangle mesh. Field names are the JSON's.
#[derive(Debug, Serialize)]
pub struct MeshDescription {
    #[serde(flatten)]
    file: FileDescription,
    warnings: Vec<String>,
    triangle_mesh: MeshContents,
}

#[derive(Debug, Serialize)]
struct MeshContents {
    #[serde(flatten)]
    summary: MeshSummary,
    bounds: [[f32; 3]; 2],
    material_counts: Vec<MaterialCount>,
    positions: Option<Vec<[f32; 3]>>,
    corners: Option<Vec<[u32; 3]>>,
    edge_classes: Option<Vec<[&'static str; 3]>>,
}

#[derive(Debug, Serialize)]
struct MaterialCount {
    number: u16,
    triangles: usize,
}

/// Describes a mesh. T-junctions are counted here, because the file does not state them.
pub fn describe(file: String, mesh: &TriangleMesh, warnings: Vec<String>, has_vertices: bool) -> MeshDescription {
    let triangles = 0..mesh.triangle_count();
    let materials = count_materials(triangles.clone().filter_map(|triangle| mesh.material(triangle)));
    let summary = MeshSummary { t_junctions: Some(t_junctions_of(mesh).count), ..MeshSummary::of_file(mesh) };
    let positions = || (0..mesh.vertex_count()).filter_map(|at| mesh.vertex(at)).map(|at| at.to_array()).collect();
    let classes = |triangle: usize| mesh.edge_classes(triangle).map(|own| own.map(hullmap::EdgeClass::as_str));
    MeshDescription {
        file: FileDescription::new(file, mesh.header(), mesh.bytes().len(), mesh.source_path(), mesh.options()),
        warnings,
        triangle_mesh: MeshContents {
            summary,
            bounds: mesh.bounds().map(|corner| corner.to_array()),
            material_counts: materials
                .into_iter()
                .map(|(number, triangles)| MaterialCount { number, triangles })
                .collect(),
            positions: has_vertices.then(positions),
            corners: has_vertices.then(|| triangles.clone().filter_map(|at| mesh.corners(at)).collect()),
            edge_classes: has_vertices.then(|| triangles.filter_map(classes).collect()),
        },
    }
}

pub fn write_text(report: &MeshDescription, out: &mut Output) -> Result<(), Failure> {
    let MeshContents { summary, bounds, material_counts, .. } = &report.triangle_mesh;
    let number = |value: usize| grouped(value as u64);
    let [low, high] = bounds.map(|corner| corner.map(shortest).join(" "));
    let edges = &summary.edges;
    let options = BuildOptions::recorded_in_words(&report.file.options);
    let mut rows = report.file.rows("triangle mesh", options, ("triangle", summary.triangles)).to_vec();
    rows.extend(report.warnings.iter().map(|warning| ("warning".to_owned(), warning.clone())));
    let edges = [
        (edges.border, "border"),
        (edges.flat, "flat"),
        (edges.convex, "convex"),
        (edges.concave, "concave"),
        (edges.non_manifold, "non-manifold"),
        (edges.reversed, "reversed"),
    ];
    let materials = material_counts.iter().map(|material| (material.number, material.triangles)).collect();
    let contents = [
        ("triangles", number(summary.triangles)),
        ("vertices", format!("{}, {} merged", number(summary.vertices), number(summary.merged))),
        ("bounds", format!("{low} to {high}")),
        ("flaws", summary.flaws().to_string()),
        ("edges of triangles", edges.map(|(count, class)| format!("{} {class}", number(count))).join(", ")),
        ("materials", list_materials(&materials)),
    ];
    rows.extend(contents.map(|(name, value)| (name.to_owned(), value)));
    report.file.write_text(rows, out)
}
