//! glTF files as exporters and converters write them: Meshopt, missing buffers, restarted strips.

use shapes::gltf;

use super::*;

/// Three points, and their indices as shorts, in 44 bytes.
fn triangle() -> Vec<u8> {
    [floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]), vec![0, 0, 1, 0, 2, 0, 0, 0]].concat()
}

const PRIMITIVE: &str = r#"{"attributes":{"POSITION":0},"indices":1}"#;
const ACCESSORS: &str = r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},{"bufferView":1,"componentType":5123,"type":"SCALAR","count":3}"#;
const VIEWS: &str = r#"{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}"#;
const BUFFERS: &str = r#"{"byteLength":44}"#;

struct Parts<'a> {
    /// Members besides those below, each followed by a comma.
    extra: &'a str,
    primitive: &'a str,
    accessors: &'a str,
    views: &'a str,
    buffers: &'a str,
}

const PLAIN: Parts = Parts { extra: "", primitive: PRIMITIVE, accessors: ACCESSORS, views: VIEWS, buffers: BUFFERS };

impl Parts<'_> {
    fn json(&self) -> String {
        let Self { extra, primitive, accessors, views, buffers } = self;
        format!(
            r#"{{"asset":{{"version":"2.0"}},{extra}"meshes":[{{"primitives":[{primitive}]}}],"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{buffers}]}}"#
        )
    }

    fn glb(&self, buffer: &[u8]) -> Result<Imported, ImportError> {
        import_file("a.glb", gltf::glb(self.json().as_bytes(), buffer), WHOLE)
    }
}

/// Views with a compressed copy by the extension were rejected.
#[test]
fn the_fallback_of_meshopt_compression_is_read() {
    for (name, extra) in [
        ("EXT_meshopt_compression", ""),
        ("EXT_meshopt_compression", r#""extensionsRequired":["EXT_meshopt_compression"],"#),
        ("KHR_meshopt_compression", ""),
    ] {
        let extension = format!(
            r#""extensions":{{"{name}":{{"buffer":0,"byteLength":9,"byteStride":12,"count":3,"mode":"ATTRIBUTES"}}}}"#
        );
        let views = format!(
            r#"{{"buffer":1,"byteLength":36,{extension}}},{{"buffer":1,"byteOffset":36,"byteLength":6,{extension}}}"#
        );
        // The first buffer has the compressed data, and is missing.
        let fallback = format!(r#""byteLength":44,"extensions":{{"{name}":{{"fallback":true}}}}"#);
        let buffers = format!(r#"{{"uri":"compressed.bin","byteLength":18}},{{"uri":"fallback.bin",{fallback}}}"#);
        let json = Parts { extra, views: &views, buffers: &buffers, ..PLAIN }.json().into_bytes();
        assert_eq!(crate::gltf::buffer_paths(&json).unwrap(), ["fallback.bin"]);
        let mut source = SourceFile::alone(json);
        source.beside = vec![("fallback.bin".to_owned(), triangle())];
        let imported = import_source("a.gltf", &source, WHOLE).unwrap();
        assert_eq!(triangles(&imported), [[0, 1, 2]], "{name}");

        // A placeholder has no bytes, so the compressed data is read, which is damaged here.
        let buffers = format!(r#"{{"byteLength":18}},{{{fallback}}}"#);
        let damaged = Parts { extra, views: &views, buffers: &buffers, ..PLAIN }.glb(&[0; 44]);
        fails(damaged, &format!("buffer view 0, compressed by {name}, is damaged"));
    }
}

/// A missing buffer of animations or images rejected the file.
#[test]
fn buffers_without_positions_or_indices_may_be_missing() {
    let buffers = format!(
        r#"{BUFFERS},{{"uri":"animation.bin","byteLength":1e9}},{{"uri":"https://host/image.bin","byteLength":5}},{{"byteLength":7}},{{"uri":"data:;base64,%","byteLength":1}}"#
    );
    let views = format!(r#"{VIEWS},{{"buffer":1,"byteLength":100}}"#);
    let accessors = format!(r#"{ACCESSORS},{{"bufferView":2,"componentType":5126,"type":"VEC3","count":8}}"#);
    let parts = Parts { buffers: &buffers, views: &views, accessors: &accessors, ..PLAIN };
    assert_eq!(triangles(&parts.glb(&triangle()).unwrap()), [[0, 1, 2]]);
    assert!(crate::gltf::buffer_paths(parts.json().as_bytes()).unwrap().is_empty());

    let extra = r#""nodes":[{"mesh":0},{"mesh":1}],"scenes":[{"nodes":[0]}],"#;
    let primitive = format!(r#"{PRIMITIVE}]}},{{"primitives":[{{"attributes":{{"POSITION":2}}}}"#);
    let parts = Parts { extra, primitive: &primitive, ..parts };
    assert_eq!(triangles(&parts.glb(&triangle()).unwrap()), [[0, 1, 2]]);
    let extra = extra.replace("[0]", "[0,1]");
    let parts = Parts { extra: &extra, ..parts };
    assert_eq!(crate::gltf::buffer_paths(parts.json().as_bytes()).unwrap(), ["animation.bin"]);
    fails(parts.glb(&triangle()), "buffer 1 (animation.bin) is missing");

    // Sparse replacements are required.
    let accessors = r#"{"componentType":5126,"type":"VEC3","count":3,"sparse":{"count":1,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":0}}}"#;
    let parts = Parts { accessors, extra: "", primitive: r#"{"attributes":{"POSITION":0}}"#, ..parts };
    assert_eq!(crate::gltf::buffer_paths(parts.json().as_bytes()).unwrap(), ["animation.bin"]);
}

#[test]
fn a_git_lfs_pointer_in_place_of_a_buffer_is_named() {
    let mut source =
        SourceFile::alone(Parts { buffers: r#"{"uri":"a.bin","byteLength":44}"#, ..PLAIN }.json().into_bytes());
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 44\n";
    source.beside = vec![("a.bin".to_owned(), pointer.to_vec())];
    let error = import_source("a.gltf", &source, WHOLE).unwrap_err().to_string();
    assert!(error.contains("buffer 0 (a.bin) is a Git LFS pointer") && error.contains("git lfs pull"), "{error}");
}

fn strip(mode: u32, indices: &[u8], vertex_count: usize, extra: &str) -> Result<Imported, ImportError> {
    let mut buffer = indices.to_vec();
    buffer.resize(indices.len().next_multiple_of(4), 0);
    let start = buffer.len();
    for vertex in 0..vertex_count {
        let [x, y] = [(vertex % 20) as f32, (vertex / 20) as f32];
        buffer.extend([x, y, x * y].iter().flat_map(|x| x.to_le_bytes()));
    }
    let views = format!(
        r#"{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#,
        indices.len(),
        12 * vertex_count
    );
    let accessors = format!(
        r#"{{"bufferView":1,"componentType":5126,"type":"VEC3","count":{vertex_count}}},{{"bufferView":0,"componentType":5121,"type":"SCALAR","count":{}}}"#,
        indices.len()
    );
    let primitive = format!(r#"{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}}"#);
    let buffers = format!(r#"{{"byteLength":{}}}"#, buffer.len());
    Parts { extra, primitive: &primitive, accessors: &accessors, views: &views, buffers: &buffers }.glb(&buffer)
}

/// The restart index was an index out of range.
#[test]
fn the_restart_index_starts_a_new_strip() {
    const RESTART: u8 = 255;
    let indices = [0, 1, 2, 3, RESTART, 4, 5, 6, 7, RESTART, RESTART, 8, 9, RESTART];
    for (mode, expected) in [
        (5, &[[0, 1, 2], [2, 1, 3], [4, 5, 6], [6, 5, 7]][..]),
        (6, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
        (3, &[]),
        (2, &[]),
    ] {
        let imported = strip(mode, &indices, 10, "").unwrap();
        assert_eq!(triangles(&imported), expected, "{mode}");
        let points = if expected.is_empty() { 10 } else { 8 };
        assert_eq!(imported.point_count(), points, "{mode}");
        has_note(&imported, "restart index: 4");
    }
    for mode in [0, 1, 4] {
        fails(strip(mode, &indices, 10, ""), "corner 4 has the vertex index 255, which is out of range");
    }
}

#[test]
fn the_restart_index_is_rejected_where_it_is_a_vertex_too() {
    let indices = [0, 1, 2, 255, 3, 4, 5];
    for mode in [2, 3, 5, 6] {
        fails(strip(mode, &indices, 256, ""), "corner 3 has the index 255: some readers take it for vertex 255");
    }
    for name in ["KHR_mesh_primitive_restart", "EXT_mesh_primitive_restart"] {
        let extra = format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],"#);
        assert_eq!(triangles(&strip(5, &indices, 256, &extra).unwrap()), [[0, 1, 2], [3, 4, 5]]);
    }
    assert_eq!(strip(0, &indices, 256, "").unwrap().point_count(), 7);
}

#[test]
fn colliders_count_against_the_limit_on_repetition() {
    let collider = r#"{"extensions":{"KHR_physics_rigid_bodies":{"collider":{"geometry":{"mesh":1}}}}}"#;
    let nodes = vec![collider; 30_000].join(",");
    let roots = (0..30_000).map(|index| index.to_string()).collect::<Vec<_>>().join(",");
    let text = section_file("a.gltf", &format!(r#"{{"scenes":[{{"nodes":[{roots}]}}],"nodes":[{nodes}],MESHES}}"#));
    let (source, limits) =
        (SourceFile::alone(text.into_bytes()), Limits { repeated_vertices: 10_000, ..Limits::DEFAULT });
    fails(crate::import("a.gltf", "a", Path::new("a.gltf"), &source, &AUTO, &limits), "max_instanced");
}
