//! Descriptions of triangle meshes and height fields.

use std::collections::BTreeMap;

use hullmap::height_field::Layout;
use hullmap::{Asset, EdgeClass, HeightField, TriangleMesh};
use serde::Serialize;

use crate::table::shortest;
use crate::terminal::Output;
use hullmap_geometry::number::grouped;
use hullmap_pipeline::open::kept_warnings;
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::triangle_mesh::{EdgeCounts, MeshSummary, t_junctions_of};

const MATERIALS_IN_TEXT: usize = 8;

/// Description of a file. Field names are the JSON's; lengths are in source units.
#[derive(Debug, Serialize)]
pub struct SurfaceDescription {
    file: String,
    format_version: u32,
    bytes: u64,
    source: String,
    options: String,
    /// XXH3-128 of the source, 32 hexadecimal digits.
    source_hash: String,
    warnings: Vec<String>,
    #[serde(flatten)]
    surface: Surface,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    TriangleMesh(MeshContents),
    HeightField(FieldContents),
}

#[derive(Debug, Serialize)]
pub struct MeshContents {
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

#[derive(Debug, Serialize)]
pub struct FieldContents {
    columns: usize,
    rows: usize,
    origin: [f64; 2],
    spacing: [f64; 2],
    diagonal: &'static str,
    heights: [f64; 2],
    holes: usize,
    triangles: usize,
    /// Number of edges of triangles of each class; an edge of two triangles counts for both.
    edges: EdgeCounts,
    material_counts: Vec<MaterialCount>,
    /// Heights, row by row, the row with the least y first, with `--vertices`.
    vertices: Option<Vec<f64>>,
}

impl SurfaceDescription {
    pub fn new(file: String, asset: &Asset, surface: Surface) -> Self {
        Self {
            file,
            format_version: asset.header().format_version,
            bytes: asset.bytes().len() as u64,
            source: asset.source_path().to_owned(),
            options: asset.options().to_owned(),
            source_hash: format!("{:032x}", asset.header().source_hash),
            warnings: kept_warnings(asset),
            surface,
        }
    }
}

impl Surface {
    /// T-junctions are counted here, because the file does not state them.
    pub fn of_mesh(mesh: &TriangleMesh, has_vertices: bool) -> Self {
        let triangles = 0..mesh.triangle_count();
        let positions = || (0..mesh.vertex_count()).filter_map(|at| mesh.vertex(at)).map(|at| at.to_array()).collect();
        let classes = |triangle: usize| mesh.edge_classes(triangle).map(|own| own.map(EdgeClass::as_str));
        Self::TriangleMesh(MeshContents {
            summary: MeshSummary { t_junctions: Some(t_junctions_of(mesh).count), ..MeshSummary::of_file(mesh) },
            bounds: mesh.bounds().map(|corner| corner.to_array()),
            material_counts: count_materials(triangles.clone().filter_map(|triangle| mesh.material(triangle))),
            positions: has_vertices.then(positions),
            corners: has_vertices.then(|| triangles.clone().filter_map(|at| mesh.corners(at)).collect()),
            edge_classes: has_vertices.then(|| triangles.filter_map(classes).collect()),
        })
    }

    pub fn of_field(field: &HeightField, has_vertices: bool) -> Self {
        let (Layout { columns, rows, origin, spacing, diagonal }, holes) = (*field.layout(), field.hole_count());
        let triangles = 0..field.triangle_count();
        let mut edges = EdgeCounts::default();
        let classes = triangles.clone().filter_map(|triangle| field.edge_classes(triangle));
        classes.flatten().for_each(|class| edges.add(class, 1));
        let places = || (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let heights = || places().filter_map(|(column, row)| field.vertex(column, row)).map(|at| at.z).collect();
        Self::HeightField(FieldContents {
            columns,
            rows,
            origin,
            spacing,
            diagonal: diagonal.as_str(),
            heights: field.bounds().map(|corner| corner.z),
            holes,
            triangles: field.triangle_count() - 2 * holes,
            edges,
            material_counts: count_materials(triangles.filter_map(|triangle| field.material(triangle))),
            vertices: has_vertices.then(heights),
        })
    }
}

fn count_materials(materials: impl Iterator<Item = u16>) -> Vec<MaterialCount> {
    let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
    materials.for_each(|material| *counts.entry(material).or_default() += 1);
    counts.into_iter().map(|(number, triangles)| MaterialCount { number, triangles }).collect()
}

impl SurfaceDescription {
    pub fn write_text(&self, out: &mut Output) -> Result<(), Failure> {
        let number = |value: usize| grouped(value as u64);
        let (kind, element, count, edges, materials) = match &self.surface {
            Surface::TriangleMesh(mesh) => {
                ("triangle mesh", "triangle", mesh.summary.triangles, mesh.summary.edges, &mesh.material_counts)
            }
            Surface::HeightField(field) => {
                let cells = (field.columns - 1) * (field.rows - 1);
                ("height field", "cell", cells, field.edges, &field.material_counts)
            }
        };
        let each = self.bytes as f64 / count.max(1) as f64;
        let mut rows = vec![
            ("format version", format!("{}, a {kind}", self.format_version)),
            ("bytes", format!("{} ({each:.1} per {element})", grouped(self.bytes))),
            ("source", format!("{} (xxh3 {})", self.source, self.source_hash)),
            ("options", BuildOptions::recorded_in_words(&self.options)),
        ];
        rows.extend(self.warnings.iter().map(|warning| ("warning", warning.clone())));
        rows.extend(self.surface.rows());
        let edges = edges.named().map(|(count, class)| format!("{} {class}", number(count))).join(", ");
        rows.push(("edges of triangles", edges));
        let listed = materials.iter().take(MATERIALS_IN_TEXT);
        let listed: Vec<String> =
            listed.map(|own| format!("{}: {} triangles", own.number, number(own.triangles))).collect();
        let more = if materials.len() > MATERIALS_IN_TEXT { ", …" } else { "" };
        rows.push(("materials", format!("{}{more}", listed.join(", "))));
        out.line(&self.file)?;
        for (name, value) in rows {
            out.line(format_args!("  {name:<18} {value}"))?;
        }
        Ok(())
    }
}

impl Surface {
    fn rows(&self) -> Vec<(&'static str, String)> {
        let number = |value: usize| grouped(value as u64);
        match self {
            Self::TriangleMesh(MeshContents { summary, bounds, .. }) => {
                let [low, high] = bounds.map(|corner| corner.map(shortest).join(" "));
                vec![
                    ("triangles", number(summary.triangles)),
                    ("vertices", format!("{}, {} merged", number(summary.vertices), number(summary.merged))),
                    ("bounds", format!("{low} to {high}")),
                    ("flaws", summary.flaws()),
                ]
            }
            Self::HeightField(field) => {
                let FieldContents { columns, rows, origin, spacing, diagonal, heights, holes, triangles, .. } = field;
                vec![
                    ("vertices", format!("{} along x, {} along y", number(*columns), number(*rows))),
                    ("origin", format!("{} {}", origin[0], origin[1])),
                    ("spacing", format!("{} {}", spacing[0], spacing[1])),
                    ("diagonals", (*diagonal).to_owned()),
                    ("heights", format!("{} to {}", heights[0], heights[1])),
                    ("holes", format!("{} of {} cells", number(*holes), number((columns - 1) * (rows - 1)))),
                    ("triangles", number(*triangles)),
                ]
            }
        }
    }
}
