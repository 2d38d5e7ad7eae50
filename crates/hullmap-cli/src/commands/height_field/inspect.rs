//! `bake inspect`: describes height fields.

use std::collections::BTreeMap;

use hullmap::{EdgeClass, HeightField};
use serde::Serialize;

use super::open::open;
use crate::args::InspectArgs;
use crate::outcome::{Exit, Failure};
use crate::table::grouped;
use crate::terminal::{self, Output};

/// Maximum number of materials in the text.
const MATERIALS_IN_TEXT: usize = 8;

/// Description of a height field. Field names are the JSON's; lengths are in source units.
#[derive(Debug, Serialize)]
struct Description {
    file: String,
    format_version: u32,
    bytes: u64,
    source: String,
    /// The recorded build options.
    options: String,
    /// XXH3-128 of the source, 32 hexadecimal digits.
    source_hash: String,
    height_field: Contents,
}

#[derive(Debug, Serialize)]
struct Contents {
    columns: usize,
    rows: usize,
    origin: [f64; 2],
    spacing: [f64; 2],
    diagonal: &'static str,
    /// Least and greatest height.
    heights: [f64; 2],
    holes: usize,
    /// Number of triangles, without those of holes.
    triangles: usize,
    /// Number of edges of triangles of each class; an edge of two triangles counts for both.
    edges: BTreeMap<&'static str, usize>,
    /// Number of cells of each material, holes left out.
    materials: BTreeMap<u16, usize>,
    /// Heights, row by row, the row with the least y first, with `--vertices`.
    vertices: Option<Vec<f64>>,
}

/// Runs the command. Files that are not valid are reported, and the others described.
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
        write_text(&description, out)?;
    }
    Ok(exit)
}

fn describe(file: String, field: &HeightField, has_vertices: bool) -> Description {
    let (header, layout) = (field.header(), field.layout());
    let (mut edges, mut materials) = (BTreeMap::new(), BTreeMap::new());
    for triangle in 0..field.triangle_count() {
        for class in field.edge_classes(triangle).into_iter().flatten() {
            *edges.entry(EdgeClass::as_str(class)).or_default() += 1;
        }
        if triangle.is_multiple_of(2)
            && let Some(material) = field.material(triangle)
        {
            *materials.entry(material).or_default() += 1;
        }
    }
    let places = || (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
    let heights = || places().filter_map(|(column, row)| field.vertex(column, row)).map(|vertex| vertex.z).collect();
    let holes = field.hole_count();
    Description {
        file,
        format_version: header.format_version,
        bytes: field.bytes().len() as u64,
        source: field.source_path().to_owned(),
        options: field.options().to_owned(),
        source_hash: format!("{:032x}", header.source_hash),
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

/// Names and values of the facts about a height field.
pub fn facts(file: &str, field: &HeightField) -> Vec<(String, String)> {
    describe(file.to_owned(), field, false).facts()
}

impl Description {
    fn facts(&self) -> Vec<(String, String)> {
        let Contents { columns, rows, origin, spacing, diagonal, heights, holes, triangles, edges, materials, .. } =
            &self.height_field;
        let number = |value: usize| grouped(value as u64);
        let cells = (columns - 1) * (rows - 1);
        let each = self.bytes as f64 / cells as f64;
        let edges: Vec<String> = edges.iter().map(|(class, count)| format!("{} {class}", number(*count))).collect();
        let listed = materials.iter().take(MATERIALS_IN_TEXT);
        let listed: Vec<String> = listed.map(|(material, count)| format!("{} of {material}", number(*count))).collect();
        let more = if materials.len() > MATERIALS_IN_TEXT { ", …" } else { "" };
        let facts = [
            ("format version", format!("{}, a height field", self.format_version)),
            ("bytes", format!("{} ({each:.1} per cell)", grouped(self.bytes))),
            ("source", format!("{} (xxh3 {})", self.source, self.source_hash)),
            ("options", self.options.clone()),
            ("vertices", format!("{} along x, {} along y", number(*columns), number(*rows))),
            ("origin", format!("{} {}", origin[0], origin[1])),
            ("spacing", format!("{} {}", spacing[0], spacing[1])),
            ("diagonals", (*diagonal).to_owned()),
            ("heights", format!("{} to {}", heights[0], heights[1])),
            ("holes", format!("{} of {} cells", number(*holes), number(cells))),
            ("triangles", number(*triangles)),
            ("edges of triangles", edges.join(", ")),
            ("materials", format!("{}{more}", listed.join(", "))),
        ];
        facts.map(|(name, value)| (name.to_owned(), value)).into()
    }
}

fn write_text(description: &Description, out: &mut Output) -> Result<(), Failure> {
    out.line(&description.file)?;
    for (name, value) in description.facts() {
        out.line(format_args!("  {name:<18} {value}"))?;
    }
    Ok(())
}
