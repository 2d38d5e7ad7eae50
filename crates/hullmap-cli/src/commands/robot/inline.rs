//! Meshes that a description contains, as files: their packs name a source like all packs.

use std::collections::{BTreeMap, BTreeSet};

use hullmap_robot::{Description, Geometry, Unresolved};

use super::target::Target;
use hullmap_pipeline::mesh_file::names::token;
use hullmap_pipeline::mesh_file::obj;
use hullmap_pipeline::mesh_file::place::OutputFile;

/// Afterwards, each mesh of the description leads to its file.
pub fn extract(description: &mut Description, target: &Target) -> Vec<OutputFile> {
    let (mut known, mut taken) = (BTreeMap::new(), BTreeSet::new());
    let mut outputs = Vec::new();
    let shapes = description.links.iter_mut().flat_map(|link| link.collisions.iter_mut().chain(&mut link.visuals));
    for shape in shapes {
        let Geometry::Mesh(mesh) = &mut shape.geometry else { continue };
        let Err(Unresolved::Inline(own)) = &mesh.file else { continue };
        let path = known.entry(own.name.clone()).or_insert_with(|| {
            let stem = token(&own.name).to_lowercase();
            let numbered = (2_u32..).map(|number| format!("{stem}_{number}_inline.obj"));
            let free =
                std::iter::once(format!("{stem}_inline.obj")).chain(numbered).find(|name| taken.insert(name.clone()));
            let path = target.meshes.join(free.unwrap_or_default());
            outputs.push(OutputFile {
                path: path.clone(),
                bytes: obj::write_inline(&own.name, &own.vertices, &own.triangles),
            });
            path
        });
        mesh.file = Ok(path.clone());
    }
    outputs
}
