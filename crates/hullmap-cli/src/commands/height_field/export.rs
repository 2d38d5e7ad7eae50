//! `bake export`: writes height fields as OBJ, or as raw numbers.

use std::fmt::Write;
use std::path::Path;

use hullmap::HeightField;

use super::open::open;
use crate::args::export::{ExportArgs, Format};
use crate::mesh_file::place;
use crate::outcome::{Exit, Failure};
use crate::pack_file::{folder_of, make_folder};
use crate::terminal::Output;
use hullmap_bake::number::grouped;

/// Extension of raw numbers: little-endian f32, row by row, the row with the least y first.
const RAW: &str = "f32";

pub fn run(args: &ExportArgs, out: &mut Output) -> Result<Exit, Failure> {
    let ([path], Some(target)) = (args.packs.as_slice(), &args.out) else {
        return Err(Failure::usage("a height field is exported by itself, to a file: name one, and --out"));
    };
    if args.target.is_some() || args.into.is_some() || args.parts || !args.hulls.is_empty() {
        let message = format!("{}: --for, --into, --hull and --parts are for packs; leave them out", path.display());
        return Err(Failure::usage(message));
    }
    let is_raw = target.extension().is_some_and(|extension| extension == RAW);
    let is_obj = target.extension().is_some_and(|extension| extension == Format::Obj.extension());
    let field = open(path)?;
    let bytes = match args.format {
        Some(Format::Obj) => obj(&field),
        None if is_obj => obj(&field),
        None if is_raw => raw(&field),
        _ => {
            let message =
                format!("--out {}: a height field becomes .obj or .{RAW}; name such a file", target.display());
            return Err(Failure::usage(message));
        }
    };
    put(target, &bytes, args.force)?;
    let layout = field.layout();
    let (columns, rows) = (grouped(layout.columns as u64), grouped(layout.rows as u64));
    out.line(format_args!("{}: {columns} x {rows} vertices, {} bytes", target.display(), grouped(bytes.len() as u64)))?;
    Ok(Exit::Done)
}

fn put(target: &Path, bytes: &[u8], force: bool) -> Result<(), Failure> {
    make_folder(folder_of(target)).map_err(|error| place::cannot_write(target, &error))?;
    place::put(target, bytes, force)
}

/// Skips triangles of holes. All vertices are written, in the order of the grid.
fn obj(field: &HeightField) -> Vec<u8> {
    let layout = field.layout();
    let mut text = String::new();
    for row in 0..layout.rows {
        for vertex in (0..layout.columns).filter_map(|column| field.vertex(column, row)) {
            let _ = writeln!(text, "v {} {} {}", vertex.x, vertex.y, vertex.z as f32);
        }
    }
    for triangle in (0..field.triangle_count()).filter(|triangle| field.triangle(*triangle).is_some()) {
        let [a, b, c] = layout.corners(triangle).map(|[column, row]| layout.vertex(column, row) + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}

/// The heights; NaN where no cell around a vertex has ground.
fn raw(field: &HeightField) -> Vec<u8> {
    let layout = field.layout();
    let places = (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
    let height = |(column, row): (usize, usize)| {
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 1).min(count);
        let [across, along] = layout.cells();
        let has_ground = near(row, along).any(|row| near(column, across).any(|column| !field.is_hole(column, row)));
        field.vertex(column, row).filter(|_| has_ground).map_or(f32::NAN, |vertex| vertex.z as f32)
    };
    places.flat_map(|place| height(place).to_le_bytes()).collect()
}
