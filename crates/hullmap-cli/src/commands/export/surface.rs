//! `bake export` of triangle meshes, in the order of the source, and of height fields.

use std::fmt::Write as _;
use std::path::Path;

use hullmap::{Asset, HeightField, TriangleMesh};
use hullmap_format::header::FileKind;
use hullmap_import::UpAxis;

use super::{Export, ExportedFile};
use crate::args::export::Format;
use hullmap_pipeline::mesh_file::body::{Body, rotated};
use hullmap_pipeline::mesh_file::seal::{SEAL, sealed};
use hullmap_pipeline::mesh_file::{glb, obj, stl};
use hullmap_pipeline::open::noun;
use hullmap_pipeline::outcome::Failure;

const UNUSED: u32 = u32::MAX;

impl Export<'_> {
    /// The alternative, where a file of this kind cannot be exported in this form.
    pub(super) fn unfit(&self, kind: FileKind) -> Option<&'static str> {
        let args = self.args;
        if kind == FileKind::Pack {
            None
        } else if args.target.is_some() || args.into.is_some() {
            Some("leave out --for and --into, or bake hulls of its source")
        } else if !args.hulls.is_empty() || args.parts {
            Some("leave out --hull and --parts")
        } else if self.format == Format::Json {
            Some("name another format, or print its contents by `bake inspect --json --vertices`")
        } else if self.format == Format::F32 && kind != FileKind::HeightField {
            Some("name another format: f32 is for height fields")
        } else {
            None
        }
    }

    pub(super) fn surface(&self, path: &Path, asset: &Asset) -> Result<Vec<ExportedFile>, Failure> {
        let (args, file, kind) = (self.args, path.display(), asset.header().kind);
        if let Some(remedy) = self.unfit(kind) {
            return Err(Failure::usage(format!("{file}: is a {}, which has no hulls; {remedy}", noun(kind))));
        }
        let fault = |message: String| Failure::rejected(format!("{file}: {message}"));
        let (mut body, mut materials) = (Body::default(), Vec::new());
        match asset {
            // It has hulls.
            Asset::Pack(_) => {}
            Asset::TriangleMesh(mesh) => (body, materials) = of_mesh(mesh, args.up_axis),
            Asset::HeightField(field) => body = of_field(field, args.up_axis),
        }
        body.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = match (self.format, asset) {
            // Coordinates of georeferenced grids need more digits than f32 has.
            (Format::Obj, Asset::HeightField(field)) => field_obj(field, &body, args.up_axis),
            (Format::F32, Asset::HeightField(field)) => heights(field),
            (Format::Obj, _) => obj::write_triangles(&body, &materials),
            (Format::Stl, _) => stl::write_triangles(&body).map_err(fault)?,
            (Format::Glb, _) => glb::write(std::slice::from_ref(&body)).map_err(fault)?,
            (Format::Json | Format::F32, _) => Vec::new(),
        };
        let counts = Some([0, body.positions.len(), body.polygons.len()]);
        Ok(vec![ExportedFile { name: String::new(), bytes, counts }])
    }
}

/// The triangles in the order of the source, with the material of each, and the vertices in the
/// order of their first triangle. So the exported file bakes to the same triangles.
fn of_mesh(mesh: &TriangleMesh, up_axis: UpAxis) -> (Body, Vec<u16>) {
    let mut order: Vec<usize> = (0..mesh.triangle_count()).collect();
    order.sort_by_key(|&triangle| mesh.source_triangle(triangle));
    let mut numbers = vec![UNUSED; mesh.vertex_count()];
    let (mut positions, mut polygons) = (Vec::with_capacity(numbers.len()), Vec::with_capacity(order.len()));
    for corners in order.iter().filter_map(|&triangle| mesh.corners(triangle)) {
        let mut number = |corner: u32| {
            let at = corner as usize;
            if numbers[at] == UNUSED {
                numbers[at] = positions.len() as u32;
                positions.push(rotated(mesh.vertex(at).unwrap_or_default().to_array(), up_axis));
            }
            numbers[at]
        };
        polygons.push(corners.map(&mut number).to_vec());
    }
    let materials = order.iter().filter_map(|&triangle| mesh.material(triangle)).collect();
    (Body { rank: 3, positions, polygons, ..Body::default() }, materials)
}

fn places(field: &HeightField) -> impl Iterator<Item = (usize, usize)> {
    let (columns, rows) = (field.layout().columns, field.layout().rows);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)))
}

/// All vertices in the order of the grid, and the triangles that are not in holes.
fn of_field(field: &HeightField, up_axis: UpAxis) -> Body {
    let layout = field.layout();
    let vertices = places(field).filter_map(|(column, row)| field.vertex(column, row));
    let triangles = (0..field.triangle_count()).filter(|triangle| field.triangle(*triangle).is_some());
    let corners = |triangle| layout.corners(triangle).map(|[column, row]| layout.vertex(column, row) as u32).to_vec();
    Body {
        rank: 3,
        positions: vertices.map(|vertex| rotated(vertex.as_vec3().to_array(), up_axis)).collect(),
        polygons: triangles.map(corners).collect(),
        ..Body::default()
    }
}

fn field_obj(field: &HeightField, body: &Body, up_axis: UpAxis) -> Vec<u8> {
    let mut text = format!("# Height field, {SEAL}\n");
    for vertex in places(field).filter_map(|(column, row)| field.vertex(column, row)) {
        let [x, y, z] = rotated(vertex.to_array(), up_axis);
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in body.triangles() {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    sealed(text.into_bytes())
}

/// Little-endian f32, the row with the least y first; NaN where no cell around a vertex has ground.
fn heights(field: &HeightField) -> Vec<u8> {
    let height = |(column, row): (usize, usize)| {
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 1).min(count);
        let [across, along] = field.layout().cells();
        let has_ground = near(row, along).any(|row| near(column, across).any(|column| !field.is_hole(column, row)));
        field.vertex(column, row).filter(|_| has_ground).map_or(f32::NAN, |vertex| vertex.z as f32)
    };
    places(field).flat_map(|place| height(place).to_le_bytes()).collect()
}
