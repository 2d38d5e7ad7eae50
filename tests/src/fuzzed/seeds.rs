//! First inputs of the fuzz targets. Without them, nearly all inputs fail the first check.

use hullmap_import::EXTENSIONS;
use shapes::{collada, gltf, mesh::Mesh, msh, obj, ply, rng::SplitMix64, solids, stl};

use super::change_pack;
use crate::hostile::{samples, sheets};

/// Number of random inputs for each target that reads numbers.
const DRAWN: usize = 64;

/// Maximum length of a random input, in bytes.
const MAX_DRAWN_LEN: usize = 400;

/// Maximum size of a pack, in bytes.
const MAX_PACK_LEN: usize = 4096;

/// Number of inputs for each mesh and field: as it is, and with a few changed words.
const VARIANTS: u32 = 8;

/// Names and bytes of the first inputs of a target; empty for an unknown target.
pub fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let random = |seed: u64| {
        let mut rng = SplitMix64::new(seed);
        let drawn = |index: usize| {
            let bytes = (0..8 + rng.below(MAX_DRAWN_LEN)).map(|_| rng.next_u64() as u8).collect();
            (format!("drawn-{index:02}"), bytes)
        };
        (0..DRAWN).map(drawn).collect()
    };
    match target {
        "open_and_query" => samples::small()
            .into_iter()
            .filter(|sample| sample.file.len() <= MAX_PACK_LEN)
            .map(|sample| (sample.name.replace([' ', ','], "-"), sample.file))
            .collect(),
        "open_sheets" => sheets::small()
            .into_iter()
            .filter(|sample| sample.file.len() <= MAX_PACK_LEN)
            .flat_map(|sample| (0..VARIANTS).map(move |variant| variant_of(&sample, variant)))
            .collect(),
        "solver" => random(1),
        "build_open_verify" => random(2),
        "import" => source_files(),
        _ => Vec::new(),
    }
}

/// A sample, or the sample with a few changed words.
fn variant_of(sample: &samples::Sample, variant: u32) -> (String, Vec<u8>) {
    let mut file = sample.file.clone();
    if variant > 0 {
        change_pack(&mut file, variant);
    }
    (format!("{}-{variant}", sample.name.replace([' ', ','], "-")), file)
}

/// OBJ elements other than plain faces: named objects, negative indices, lines, points, continued
/// lines, all forms of numbers.
const OBJ: &str = "o UCX_a_01\nv 0 0 0\nv 1 0 .5e1 1\nv +1. 1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3 \\\n 4\n\
                   o UCX_a_02\nv 0 0 1\nv 1 0 1\nf -1 -2 1\nl 1 5\np 6\ng convcol-col\ns off\nusemtl m\n# end";

/// PLY elements other than vertices and faces.
const PLY: &str = "ply\r\nformat ascii 1.0\r\nobj_info none\r\nelement vertex 3\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n\
                   element tristrips 1\r\nproperty list int int vertex_indices\r\nelement edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n\
                   element face 1\r\nproperty list uchar int vertex_index\r\nend_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n4 0 1 2 -1\r\n0 1\r\n3 0 1 2\r\n";

/// glTF files that meshopt compresses, with integers and with exponents.
const PACKED: [&[u8]; 2] = [
    include_bytes!("../../../crates/hullmap-import/src/tests/meshopt/ext-integers.glb"),
    include_bytes!("../../../crates/hullmap-import/src/tests/meshopt/khr-exponents.glb"),
];

/// Shapes of colliders of both extensions, as members of a document.
const SHAPES: &str = r#""extensions": {
    "KHR_implicit_shapes": {"shapes": [{"type": "box", "box": {"size": [1, 2, 3]}}, {"type": "sphere"}, {"type": "capsule"},
        {"type": "cylinder", "cylinder": {"height": 2, "radiusTop": 0, "radiusBottom": 1}}, {"type": "plane"}]},
    "OMI_physics_shape": {"shapes": [{"type": "convex", "convex": {"mesh": 0}}, {"type": "trimesh", "trimesh": {"mesh": 1}}]}},"#;

/// Nodes with colliders of every kind.
const COLLIDERS: &str = r#"{"mesh": 1, "children": [1, 2, 3, 4]},
    {"name": "a", "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"node": 5, "convexHull": true}}}}},
    {"name": "b", "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 3}}}}, "scale": [1, 2, 1]},
    {"name": "c", "extensions": {"OMI_physics_body": {"collider": {"shape": 1}, "motion": {"type": "dynamic"}}}},
    {"name": "d", "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"mesh": 0}}}}},
    {"mesh": 0, "children": [6]}, {"mesh": 1, "translation": [0, 1, 0]}"#;

/// COLLADA as exporters write it: a unit, sources with strides, polygons of all kinds, nodes with
/// transforms, and an instance of a node.
const DAE: &str = r##"<?xml version="1.0"?><COLLADA xmlns="x" version="1.4.1"><asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="15">0 0 0 1 0 0 1 1 0 0 1 0 .5 .5 1e0</float_array>
<technique_common><accessor source="#a" count="5" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#p" offset="1"/><vcount>4 3</vcount><p>0 0 1 1 2 2 3 3 0 0 1 1 4 4</p></polylist>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>1 2 4</p></triangles>
<polygons count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>2 3 4</p></polygons></mesh></geometry></library_geometries>
<library_nodes><node id="n"><scale>1 -1 1</scale><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node><translate>1 2 3</translate><rotate>0 0 1 90</rotate><instance_geometry url="#g"/>
<node><matrix>1 0 0 0 0 1 0 0 0 0 1 5 0 0 0 1</matrix><instance_node url="#n"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

/// Files of every format. Each starts with a byte for the format and a byte for the options.
fn source_files() -> Vec<(String, Vec<u8>)> {
    let (prism, cone) =
        (solids::extrusion(&solids::regular_polygon(5, 1.0), -1.0, 1.0), solids::cone(6, 1.0, 0.0, 2.0));
    let obj = |mesh: &Mesh| {
        let objects = vec![obj::Object::from_mesh(Some("Cone-convcolonly"), mesh)];
        obj::Document { objects, ..Default::default() }.to_text().into_bytes()
    };
    // One node of each kind: with a matrix; with translation, rotation and scale; below another
    // node; and without a mesh.
    let nodes = r#"{"name": "UCX_a_00", "mesh": 0, "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 3,4,5,1]},
        {"mesh": 1, "translation": [1, 2, 3], "rotation": [0, 0, 1, 0], "scale": [1, -2, 0.5], "children": [2]},
        {"name": "below", "mesh": 0, "children": []}, {"name": "none"}"#;
    let scene = gltf::parts(&[("a", &prism), ("b", &cone)], nodes, "0, 1, 3");
    let colliders = gltf::parts(&[("a", &prism), ("b", &cone)], COLLIDERS, "0").text_with_data();
    let colliders = colliders.replacen('{', &format!("{{{SHAPES}"), 1);
    let texts = stl::text(&[("a", &prism), ("b", &cone)]);
    let files = [
        ("obj", "written-by-hand", OBJ.as_bytes().to_vec()),
        ("obj", "prism", obj(&prism)),
        ("obj", "cone", obj(&cone)),
        ("gltf", "scene", scene.text_with_data().into_bytes()),
        ("gltf", "buffer-missing", scene.text("a.bin").into_bytes()),
        ("glb", "scene", scene.glb()),
        ("glb", "meshopt-integers", PACKED[0].to_vec()),
        ("glb", "meshopt-exponents", PACKED[1].to_vec()),
        ("gltf", "colliders", colliders.into_bytes()),
        ("stl", "two-solids", texts.into_bytes()),
        ("stl", "binary", stl::binary(&prism, "made by hullmap")),
        ("ply", "text", ply::file(&prism, ply::Encoding::Text)),
        ("dae", "by-hand", DAE.as_bytes().to_vec()),
        ("dae", "prism", collada::file(&prism).into_bytes()),
        ("msh", "cone", msh::file(&cone)),
        ("ply", "by-hand", PLY.as_bytes().to_vec()),
        ("ply", "little", ply::file(&cone, ply::Encoding::Little)),
        ("ply", "big", ply::file(&cone, ply::Encoding::Big)),
    ];
    let mut seeds = Vec::new();
    for (extension, name, bytes) in &files {
        let format = EXTENSIONS.iter().position(|known| known == extension).unwrap_or(0) as u8;
        for options in [0b000_0000, 0b100_0001, 0b001_0010, 0b110_1110] {
            seeds.push((format!("{extension}-{name}-{options}"), [&[format, options], &bytes[..]].concat()));
        }
    }
    seeds
}
