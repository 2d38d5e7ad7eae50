//! Triangle meshes and height fields. `pairs` queries them against every kind of shape.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::*;
use crate::exports::{height_field::*, triangle_mesh::*};
use crate::handles::{HeightField, TriangleMesh};
use hullmap::height_field::{Diagonal, Layout};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};

/// A rough floor of squares, as the bytes of a file. Triangle t of the source has the material t.
pub(super) fn mesh_file(cells: usize) -> Vec<u8> {
    let mut rng = SplitMix64::new(39);
    let side = cells + 1;
    let at = |i: usize| i as f32 - cells as f32 / 2.0;
    let positions: Vec<[f32; 3]> =
        (0..side * side).map(|i| [at(i % side), at(i / side), rng.between(-0.3, 0.3) as f32]).collect();
    let corner = |x: usize, y: usize| (y * side + x) as u32;
    let squares = (0..cells * cells).map(|i| (i % cells, i / cells));
    let corners: Vec<[u32; 3]> = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let materials: Vec<u16> = (0..corners.len() as u16).collect();
    let triangles = Triangles { positions: &positions, corners: &corners, materials: &materials };
    write_triangle_mesh(bake_triangle_mesh(&triangles).unwrap(), &Default::default()).unwrap()
}

fn open_mesh(file: &[u8]) -> Owned<TriangleMesh> {
    // SAFETY: the pointers are valid.
    Owned::new(hullmap_triangle_mesh_free, |out| unsafe {
        hullmap_triangle_mesh_from_memory(file.as_ptr(), file.len(), out)
    })
}

#[test]
fn triangles_are_those_of_the_file() {
    let file = mesh_file(4);
    let (mesh, twin) = (open_mesh(&file), hullmap::TriangleMesh::from_bytes(&file).unwrap());
    // SAFETY: the pointers are valid.
    unsafe {
        assert_eq!(hullmap_triangle_mesh_triangle_count(mesh.0), 32);
        assert_eq!(hullmap_triangle_mesh_vertex_count(mesh.0), 25);
        assert_eq!((hullmap_triangle_mesh_triangle_count(null()), hullmap_triangle_mesh_vertex_count(null())), (0, 0));
        let mut found = std::mem::zeroed::<types::MeshTriangle>();
        for index in 0..32 {
            assert_eq!(hullmap_triangle_mesh_triangle(mesh.0, index, &raw mut found), Code::Ok);
            assert_eq!(found.corners, twin.triangle(index).unwrap().corners());
            assert_eq!((found.vertices, found.material), (twin.corners(index).unwrap(), found.source_triangle));
            for edge in 0..3 {
                let beyond = twin.neighbours(index).unwrap()[edge];
                assert_eq!(found.neighbours[edge], beyond.unwrap_or(u32::MAX));
                assert_eq!(found.edge_classes[edge] == types::EdgeClass::Border, beyond.is_none());
            }
        }
        assert_eq!(hullmap_triangle_mesh_triangle(mesh.0, 32, &raw mut found), Code::NotFound);
        assert!(message().contains("triangle 32 is out of range: the mesh has 32"), "{}", message());
    }
}

/// Damaged files, and files of other kinds with what the message says; then the file as it is, from
/// a path. Returns the opened file.
fn judge_files<T>(
    file: &[u8],
    other: &[u8],
    expected: &str,
    from_memory: unsafe extern "C" fn(*const u8, usize, *mut *mut T) -> Code,
    open: unsafe extern "C" fn(*const c_char, *mut *mut T) -> Code,
    free: unsafe extern "C" fn(*mut T),
) -> Owned<T> {
    let mut handle = null_mut::<T>();
    // SAFETY: the pointers are valid, or NULL.
    unsafe {
        let mut memory = |bytes: &[u8]| from_memory(bytes.as_ptr(), bytes.len(), &raw mut handle);
        for cut in (0..file.len()).step_by(17) {
            assert_eq!(memory(&file[..cut]), Code::InvalidPack);
        }
        assert_eq!(memory(other), Code::InvalidPack);
        assert!(message().contains(expected), "{}", message());
        assert_eq!(from_memory(null(), 5, &raw mut handle), Code::Null);
        assert_eq!(open(c"no/such/file".as_ptr(), &raw mut handle), Code::Io);
        assert!(handle.is_null());
        free(null_mut());
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    std::fs::write(&path, file).unwrap();
    let path = std::ffi::CString::new(path.to_str().unwrap()).unwrap();
    // SAFETY: the pointers are valid.
    Owned::new(free, |out| unsafe { open(path.as_ptr(), out) })
}

#[test]
fn wrong_files_are_errors() {
    let (mesh, field, pack) = (mesh_file(2), field_file(), file());
    let opened = judge_files(
        &mesh,
        &pack,
        "not a hullmap triangle mesh",
        hullmap_triangle_mesh_from_memory,
        hullmap_triangle_mesh_open,
        hullmap_triangle_mesh_free,
    );
    // SAFETY: the pointer is valid.
    assert_eq!(unsafe { hullmap_triangle_mesh_triangle_count(opened.0) }, 8);
    let opened = judge_files(
        &field,
        &mesh,
        "not a hullmap height field",
        hullmap_height_field_from_memory,
        hullmap_height_field_open,
        hullmap_height_field_free,
    );
    // SAFETY: the pointer is valid.
    assert_eq!(unsafe { hullmap_height_field_triangle_count(opened.0) }, 32);
    let mut shape = null_mut::<Shape>();
    // SAFETY: the pointers are valid, or NULL.
    assert_eq!(unsafe { hullmap_shape_triangle_mesh(null(), &raw mut shape) }, Code::Null);
}

/// A rough field of four by four cells, of which the last is a hole.
fn field_file() -> Vec<u8> {
    let mut rng = SplitMix64::new(41);
    let diagonal = Diagonal::Falling;
    let layout = Layout { columns: 5, rows: 5, origin: [-2.0, -2.0], spacing: [1.0, 1.0], diagonal };
    let heights: Vec<f32> = (0..25).map(|_| rng.between(-0.3, 0.3) as f32).collect();
    let holes: Vec<bool> = (0..16).map(|cell| cell == 15).collect();
    let materials: Vec<u16> = (0..16).collect();
    let grid = HeightGrid { layout, heights: &heights, holes: &holes, materials: &materials };
    write_height_field(bake_height_field(&grid).unwrap(), &Default::default()).unwrap()
}

fn open_field(file: &[u8]) -> Owned<HeightField> {
    // SAFETY: the pointers are valid.
    Owned::new(hullmap_height_field_free, |out| unsafe {
        hullmap_height_field_from_memory(file.as_ptr(), file.len(), out)
    })
}

#[test]
fn a_field_has_its_grid_triangles_and_ground() {
    let file = field_file();
    let (field, twin) = (open_field(&file), hullmap::HeightField::from_bytes(&file).unwrap());
    // SAFETY: the pointers are valid, or NULL.
    unsafe {
        let mut layout = std::mem::zeroed::<types::FieldLayout>();
        assert_eq!(hullmap_height_field_layout(field.0, &raw mut layout), Code::Ok);
        assert_eq!((layout.columns, layout.rows, layout.holes), (5, 5, 1));
        assert_eq!((layout.origin, layout.spacing), ([-2.0; 2], [1.0; 2]));
        assert_eq!(layout.diagonal, types::Diagonal::Falling);
        assert_eq!(hullmap_height_field_triangle_count(field.0), 32);
        assert_eq!(hullmap_height_field_triangle_count(null()), 0);
        let mut found = std::mem::zeroed::<types::MeshTriangle>();
        for index in 0..30 {
            assert_eq!(hullmap_height_field_triangle(field.0, index, &raw mut found), Code::Ok);
            assert_eq!(found.corners, twin.triangle(index).unwrap().corners());
            assert_eq!((found.source_triangle as usize, found.material as usize), (index, index / 2));
            for (corner, vertex) in found.corners.iter().zip(found.vertices) {
                assert_eq!((corner.x, corner.y), (f64::from(vertex % 5) - 2.0, f64::from(vertex / 5) - 2.0));
            }
            for edge in 0..3 {
                let beyond = twin.neighbours(index).unwrap()[edge];
                assert_eq!(found.neighbours[edge], beyond.map_or(u32::MAX, |triangle| triangle as u32));
                assert_eq!(found.edge_classes[edge] == types::EdgeClass::Border, beyond.is_none());
            }
        }
        assert_eq!(hullmap_height_field_triangle(field.0, 30, &raw mut found), Code::NotFound);
        assert!(message().contains("triangle 30 is in a hole of the field"), "{}", message());
        assert_eq!(hullmap_height_field_triangle(field.0, 32, &raw mut found), Code::NotFound);
        assert!(message().contains("triangle 32 is out of range: the field has 32"), "{}", message());
        let mut ground = std::mem::zeroed::<types::Ground>();
        let expected = twin.height_at(0.3, -0.8).unwrap();
        assert_eq!(hullmap_height_field_height_at(field.0, 0.3, -0.8, &raw mut ground), Code::Ok);
        assert_eq!((ground.height, ground.triangle), (expected.height, expected.triangle));
        assert_eq!(ground.normal, expected.normal);
        for (x, y) in [(1.5, 1.5), (9.0, 0.0), (f64::NAN, 0.0)] {
            assert_eq!(hullmap_height_field_height_at(field.0, x, y, &raw mut ground), Code::NotFound);
        }
    }
}

/// A mesh and a field as shapes, whose own handles are freed, and the same by the crate for Rust.
pub(super) fn sheets() -> Vec<(Owned<Shape>, SharedGeometry)> {
    let (mesh_file, field_file) = (mesh_file(4), field_file());
    let (mesh, field) = (open_mesh(&mesh_file), open_field(&field_file));
    // SAFETY: the pointers are valid.
    let shapes = unsafe {
        [
            Owned::new(hullmap_shape_free, |out| hullmap_shape_triangle_mesh(mesh.0, out)),
            Owned::new(hullmap_shape_free, |out| hullmap_shape_height_field(field.0, out)),
        ]
    };
    let twins = [
        Arc::new(hullmap::TriangleMesh::from_bytes(&mesh_file).unwrap()).into(),
        Arc::new(hullmap::HeightField::from_bytes(&field_file).unwrap()).into(),
    ];
    shapes.into_iter().zip(twins).collect()
}

#[test]
fn a_level_carries_a_box_and_has_no_support_points() {
    let mesh = open_mesh(&mesh_file(4));
    // SAFETY: the pointers are valid.
    let ground = Owned::new(hullmap_shape_free, |out| unsafe { hullmap_shape_triangle_mesh(mesh.0, out) });
    let half = DVec3 { x: 0.5, y: 0.5, z: 0.5 };
    // SAFETY: the pointers are valid.
    let die = Owned::new(hullmap_shape_free, |out| unsafe { hullmap_shape_cuboid(half, out) });
    let at = |z: f64| types::Pose { translation: DVec3 { x: 0.2, y: 0.1, z }, ..IDENTITY };
    let mut hit = types::RayHit::default();
    let mut bounds = types::Bounds::default();
    // SAFETY: the pointers are valid.
    unsafe {
        let (from, down) = (DVec3 { x: 0.2, y: 0.1, z: 3.0 }, DVec3 { x: 0.0, y: 0.0, z: -1.0 });
        assert_eq!(hullmap_ray(ground.0, from, down, null(), &raw mut hit), Code::Ok);
        assert!(hit.hit && (2.6..3.4).contains(&hit.t) && hit.part < 32, "{hit:?}");
        let above = at(1.0);
        assert_eq!(hullmap_bounds(ground.0, &raw const above, &raw mut bounds), Code::Ok);
        assert!((bounds.min.x + 1.8).abs() < 1e-6 && (bounds.max.y - 2.1).abs() < 1e-6, "{bounds:?}");
        let points = manifold();
        let mut shown = std::mem::zeroed::<types::ManifoldPoints>();
        let pose = at(0.6);
        let code = hullmap_manifold_update(points.0, ground.0, die.0, &raw const pose, null(), &raw mut shown);
        assert_eq!(code, Code::Ok, "{}", message());
        // The rough floor touches the box with a few of its peaks.
        assert!(shown.touching > 0 && shown.pairs >= shown.touching, "{shown:?}");
        assert!(shown.count >= shown.touching as usize, "{shown:?}");
        let mut support = types::SupportPoint::default();
        assert_eq!(hullmap_support(ground.0, &raw const half, 1, &raw mut support), Code::Unsupported);
        assert!(message().contains("a triangle mesh has no support point"), "{}", message());
    }
}
