//! `bake export`: files that another crate judges. `tests/cases/assets.md` bakes exported hulls
//! again.

use std::fs;

use hullmap::Pack;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::command::bake_line as bake;
use hullmap_testkit::files::workspace;
use hullmap_testkit::packs::{self, point_set};

/// A second opinion on GLB: the crate `gltf` validates the file.
#[test]
fn glb_files_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    let flat = point_set("flat", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let segment = point_set("segment", &[[0.0; 3], [1.0, 2.0, 3.0]]);
    let point = point_set("point", &[[1.0, 2.0, 3.0]]);
    let solid = point_set("a \"name\"\n", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let bytes = packs::bytes(&[solid, flat, segment, point], IndexKind::None, &SourceRecord::default()).unwrap();
    fs::write(folder.path().join("x.hullmap"), &bytes).unwrap();
    bake(&folder, "export x.hullmap --out x.glb").expect(0);
    let file = gltf::Gltf::open(folder.path().join("x.glb")).unwrap();
    let buffer = file.blob.as_deref().unwrap();
    let meshes: Vec<_> = file.meshes().map(|mesh| mesh.primitives().next().unwrap()).collect();
    let modes: Vec<gltf::mesh::Mode> = meshes.iter().map(gltf::Primitive::mode).collect();
    use gltf::mesh::Mode::{Lines, Points, Triangles};
    assert_eq!(modes, [Triangles, Triangles, Lines, Points]);
    let pack = Pack::from_bytes(&bytes).unwrap();
    let names: Vec<&str> = file.nodes().filter_map(|node| node.name()).collect();
    assert!(names.iter().copied().eq(pack.hulls().map(|hull| hull.name())), "{names:?}");
    for (hull, primitive) in pack.hulls().zip(&meshes) {
        let reader = primitive.reader(|_| Some(buffer));
        let read: Vec<[u32; 3]> = reader.read_positions().unwrap().map(|p| p.map(f32::to_bits)).collect();
        assert!(read.into_iter().eq(hull.vertices().map(|vertex| vertex.to_array().map(f32::to_bits))));
        let bounds = primitive.bounding_box();
        assert_eq!([bounds.min, bounds.max], hull.bounds().map(|corner| corner.to_array()));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert!(indices.iter().all(|index| (*index as usize) < hull.vertex_count()));
        assert_eq!(indices.len(), [1, 2, 6, 12][hull.rank() as usize], "{}", hull.name());
    }
}

/// The crate validates a file into which colliders are exported.
#[test]
fn glb_files_with_colliders_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(workspace().join("tests/cases/meshes/model.glb"), folder.path().join("m.glb")).unwrap();
    bake(&folder, "build m.glb --split object --out . --quiet").expect(0);
    bake(&folder, "export m.hullmap --into m.glb --for both --out out.glb").expect(0);
    let document = gltf::Gltf::open(folder.path().join("out.glb")).unwrap();
    assert_eq!(document.default_scene().unwrap().nodes().count(), 1);
    assert!(document.nodes().len() > 4 && document.meshes().len() > 2);
}
