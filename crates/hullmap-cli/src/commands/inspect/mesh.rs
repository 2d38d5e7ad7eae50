//! `bake inspect`: the description of a triangle mesh.

use std::collections::BTreeMap;

use hullmap::TriangleMesh;
use serde::Serialize;

use crate::options::BuildOptions;
use crate::outcome::Failure;
use crate::table::{grouped, shortest};
use crate::terminal::Output;
use crate::triangle_mesh::{MeshSummary, t_junctions_of};

/// Maximum number of materials in the text.
const MATERIALS_IN_TEXT: usize = 8;

/// Description of a triangle mesh. Field names are the JSON's.
#[derive(Debug, Serialize)]
pub struct MeshDescription {
    file: String,
    format_version: u32,
    bytes: u64,
    source: String,
    /// The recorded build options.
    options: String,
    /// XXH3-128 of the source, 32 hexadecimal digits.
    source_hash: String,
    /// The recorded warnings.
    warnings: Vec<String>,
    triangle_mesh: MeshContents,
}

#[derive(Debug, Serialize)]
struct MeshContents {
    #[serde(flatten)]
    summary: MeshSummary,
    bounds: [[f32; 3]; 2],
    /// Number of triangles of each material.
    material_counts: Vec<MaterialCount>,
    /// Vertices, with `--vertices`.
    positions: Option<Vec<[f32; 3]>>,
    /// Corners of each triangle, with `--vertices`.
    corners: Option<Vec<[u32; 3]>>,
    /// Classes of the edges of each triangle, with `--vertices`.
    edge_classes: Option<Vec<[&'static str; 3]>>,
}

#[derive(Debug, Serialize)]
struct MaterialCount {
    /// Number of the material.
    number: u16,
    /// Number of triangles.
    triangles: usize,
}

/// Describes a mesh. T-junctions are counted here, because the file does not state them.
pub fn describe(file: String, mesh: &TriangleMesh, warnings: Vec<String>, has_vertices: bool) -> MeshDescription {
    let header = mesh.header();
    let triangles = 0..mesh.triangle_count();
    let mut materials: BTreeMap<u16, usize> = BTreeMap::new();
    for material in triangles.clone().filter_map(|triangle| mesh.material(triangle)) {
        *materials.entry(material).or_default() += 1;
    }
    let summary = MeshSummary { t_junctions: Some(t_junctions_of(mesh).count), ..MeshSummary::of_file(mesh) };
    let positions = || (0..mesh.vertex_count()).filter_map(|at| mesh.vertex(at)).map(|at| at.to_array()).collect();
    let classes = |triangle: usize| mesh.edge_classes(triangle).map(|own| own.map(hullmap::EdgeClass::as_str));
    MeshDescription {
        file,
        format_version: header.format_version,
        bytes: mesh.bytes().len() as u64,
        source: mesh.source_path().to_owned(),
        options: mesh.options().to_owned(),
        source_hash: format!("{:032x}", header.source_hash),
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

/// Writes the description as text.
pub fn write_text(report: &MeshDescription, out: &mut Output) -> Result<(), Failure> {
    let MeshContents { summary, bounds, material_counts, .. } = &report.triangle_mesh;
    let number = |value: usize| grouped(value as u64);
    let [low, high] = bounds.map(|corner| corner.map(shortest).join(" "));
    let edges = &summary.edges;
    out.line(format_args!("{}", report.file))?;
    out.line(format_args!("  format version     {}, a triangle mesh", report.format_version))?;
    let each = report.bytes as f64 / summary.triangles.max(1) as f64;
    out.line(format_args!("  bytes              {} ({each:.1} per triangle)", grouped(report.bytes)))?;
    out.line(format_args!("  source             {} (xxh3 {})", report.source, report.source_hash))?;
    let options = BuildOptions::from_recorded(&report.options).map(|options| options.in_words());
    out.line(format_args!("  options            {}", options.as_ref().unwrap_or(&report.options)))?;
    for warning in &report.warnings {
        out.line(format_args!("  warning            {warning}"))?;
    }
    out.line(format_args!("  triangles          {}", number(summary.triangles)))?;
    out.line(format_args!("  vertices           {}, {} merged", number(summary.vertices), number(summary.merged)))?;
    out.line(format_args!("  bounds             {low} to {high}"))?;
    out.line(format_args!("  flaws              {}", summary.flaws()))?;
    out.line(format_args!(
        "  edges of triangles {} border, {} flat, {} convex, {} concave, {} non-manifold, {} reversed",
        number(edges.border),
        number(edges.flat),
        number(edges.convex),
        number(edges.concave),
        number(edges.non_manifold),
        number(edges.reversed)
    ))?;
    let listed = material_counts.iter().take(MATERIALS_IN_TEXT);
    let listed: Vec<String> =
        listed.map(|material| format!("{} of {}", number(material.triangles), material.number)).collect();
    let more = if material_counts.len() > MATERIALS_IN_TEXT { ", …" } else { "" };
    Ok(out.line(format_args!("  materials          {}{more}", listed.join(", ")))?)
}
