//! `bake inspect`: describes height fields.

use std::collections::BTreeMap;

use hullmap::{EdgeClass, HeightField};
use serde::Serialize;

use super::open::open;
use crate::args::InspectArgs;
use crate::outcome::{Exit, Failure};
use crate::sheet_description::{FileDescription, Row, count_materials, list_materials};
use crate::terminal::{self, Output};
use hullmap_bake::number::grouped;

/// Description of a height field. Field names are the JSON's; lengths are in source units.
#[derive(Debug, Serialize)]
struct Description {
    #[serde(flatten)]
    file: FileDescription,
    height_field: Contents,
}

#[derive(Debug, Serialize)]
struct Contents {
    columns: usize,
    rows: usize,
    origin: [f64; 2],
    spacing: [f64; 2],
    diagonal: &'static str,
    heights: [f64; 2],
    holes: usize,
    triangles: usize,
    /// Number of edges of triangles of each class; an edge of two triangles counts for both.
    edges: BTreeMap<&'static str, usize>,
    materials: BTreeMap<u16, usize>,
    /// Heights, row by row, the row with the least y first, with `--vertices`.
    vertices: Option<Vec<f64>>,
}

pub fn run(args: &InspectArgs, out: &mut Output) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    for (index, path) in args.inputs.iter().enumerate() {
        let field = match open(path) {
            Ok(field) => field,
            Err(failure) => {
                exit = exit.max(failure.exit);
                terminal::error(failure);
                continue;
            }
        };
        let description = describe(path.display().to_string(), &field, args.vertices);
        if args.json {
            out.json(&description)?;
            continue;
        }
        if index > 0 {
            out.line("")?;
        }
        description.file.write_text(description.rows(), out)?;
    }
    Ok(exit)
}

fn describe(file: String, field: &HeightField, has_vertices: bool) -> Description {
    let (layout, triangles) = (field.layout(), 0..field.triangle_count());
    let mut edges = BTreeMap::new();
    for class in triangles.clone().filter_map(|triangle| field.edge_classes(triangle)).flatten() {
        *edges.entry(EdgeClass::as_str(class)).or_default() += 1;
    }
    // One triangle of each cell.
    let materials = count_materials(triangles.step_by(2).filter_map(|triangle| field.material(triangle)));
    let places = || (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
    let heights = || places().filter_map(|(column, row)| field.vertex(column, row)).map(|vertex| vertex.z).collect();
    let holes = field.hole_count();
    Description {
        file: FileDescription::new(file, field.header(), field.bytes().len(), field.source_path(), field.options()),
        height_field: Contents {
            columns: layout.columns,
            rows: layout.rows,
            origin: layout.origin,
            spacing: layout.spacing,
            diagonal: layout.diagonal.as_str(),
            heights: field.bounds().map(|corner| corner.z),
            holes,
            triangles: field.triangle_count() - 2 * holes,
            edges,
            materials,
            vertices: has_vertices.then(heights),
        },
    }
}

pub fn facts(file: &str, field: &HeightField) -> Vec<Row> {
    describe(file.to_owned(), field, false).rows()
}

impl Description {
    fn rows(&self) -> Vec<Row> {
        let Contents { columns, rows, origin, spacing, diagonal, heights, holes, triangles, edges, materials, .. } =
            &self.height_field;
        let number = |value: usize| grouped(value as u64);
        let cells = (columns - 1) * (rows - 1);
        let edges: Vec<String> = edges.iter().map(|(class, count)| format!("{} {class}", number(*count))).collect();
        let contents = [
            ("vertices", format!("{} along x, {} along y", number(*columns), number(*rows))),
            ("origin", format!("{} {}", origin[0], origin[1])),
            ("spacing", format!("{} {}", spacing[0], spacing[1])),
            ("diagonals", (*diagonal).to_owned()),
            ("heights", format!("{} to {}", heights[0], heights[1])),
            ("holes", format!("{} of {} cells", number(*holes), number(cells))),
            ("triangles", number(*triangles)),
            ("edges of triangles", edges.join(", ")),
            ("materials", list_materials(materials)),
        ];
        let mut rows = self.file.rows("height field", self.file.options.clone(), ("cell", cells)).to_vec();
        rows.extend(contents.map(|(name, value)| (name.to_owned(), value)));
        rows
    }
}
