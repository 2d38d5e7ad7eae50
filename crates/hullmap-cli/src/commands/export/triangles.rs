//! `bake export` of triangle meshes: the triangles, in the order of the source.

use std::path::Path;

use hullmap::TriangleMesh;
use hullmap_import::UpAxis;

use super::{Export, ExportedFile};
use crate::args::export::Format;
use crate::mesh_file::body::{Body, rotated};
use crate::mesh_file::{glb, obj, stl};
use crate::outcome::Failure;

const UNUSED: u32 = u32::MAX;

impl Export<'_> {
    /// The alternative, where triangle meshes cannot be exported in this form.
    pub(super) fn unfit_for_levels(&self) -> Option<&'static str> {
        let args = self.args;
        if args.target.is_some() || args.into.is_some() {
            Some("leave out --for, or bake its source without --keep-triangles")
        } else if !args.hulls.is_empty() || args.parts {
            Some("leave out --hull and --parts")
        } else if self.format == Format::Json {
            Some("name another format, or print its triangles by `bake inspect --json --vertices`")
        } else {
            None
        }
    }

    pub(super) fn triangles(&self, path: &Path, mesh: &TriangleMesh) -> Result<Vec<ExportedFile>, Failure> {
        let (args, file) = (self.args, path.display());
        if let Some(remedy) = self.unfit_for_levels() {
            return Err(Failure::usage(format!("{file}: is a triangle mesh, which has no hulls; {remedy}")));
        }
        let fault = |message: String| Failure::rejected(format!("{file}: {message}"));
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let (body, materials) = body(mesh, &stem, args.up_axis);
        let bytes = match self.format {
            Format::Obj => obj::write_triangles(&body, &materials),
            Format::Stl => stl::write_triangles(&body).map_err(fault)?,
            Format::Glb => glb::write(std::slice::from_ref(&body)).map_err(fault)?,
            // It has no hulls.
            Format::Json => Vec::new(),
        };
        let counts = Some([0, body.positions.len(), body.polygons.len()]);
        Ok(vec![ExportedFile { name: String::new(), bytes, counts }])
    }
}

/// The triangles in the order of the source, with the material of each, and the vertices in the
/// order of their first triangle. So the exported file bakes to the same triangles.
fn body(mesh: &TriangleMesh, name: &str, up_axis: UpAxis) -> (Body, Vec<u16>) {
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
    let body = Body {
        name: name.to_owned(),
        rank: 3,
        part: 0,
        origin: [0.0; 3],
        positions,
        polygons,
        primitive: None,
        mesh: None,
    };
    (body, materials)
}
