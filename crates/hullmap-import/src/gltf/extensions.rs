//! glTF 2.0: extensions that a file may require, and remedies for all others.
//!
//! A required extension that is not listed here may change the geometry, so the file is rejected.

/// Extensions whose names start with one of these have no effect on the meshes of a scene:
/// materials, textures and images, lights, sounds, physics, and data about the model.
const HARMLESS_PREFIXES: [&str; 29] = [
    "ADOBE_materials_",
    "BLENDER_physics",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_texture_",
    "GOOGLE_texture_",
    "KHR_audio",
    "KHR_collision_shapes",
    "KHR_image_",
    "KHR_implicit_shapes",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_physics_",
    "KHR_rigid_bodies",
    "KHR_texture_",
    "KHR_xmp",
    "MAXAR_collision_geometry",
    "MSFT_audio_",
    "MSFT_collision_primitives",
    "MSFT_packing_",
    "MSFT_physics_",
    "MSFT_rigid_bodies",
    "MSFT_texture_",
    "NV_materials_",
    "OMI_audio_",
    "OMI_collider",
    "OMI_physics_",
    "VRMC_materials_",
    "VRMC_springBone",
];

/// Single extensions without an effect on the geometry of the default scene at rest.
const HARMLESS: [&str; 17] = [
    // Shaders, as glTF 1.0 had them, and how they blend. Files converted from 1.0 require them.
    "KHR_blend",
    "KHR_techniques_webgl",
    // Data about vertices, primitives and the whole, and lines drawn over the edges of triangles.
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    // Motion and behaviour after loading, and attributes of nodes that viewers use.
    "KHR_animation_pointer",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "VRM",
    "VRMC_node_constraint",
    "VRMC_vrm",
    // Coarser levels of a mesh. The scene has the finest level.
    "MSFT_lod",
];

/// Compressed triangles and buffer views, integer positions, and indices that restart a strip.
const SUPPORTED: [&str; 6] = [
    "EXT_mesh_primitive_restart",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_mesh_primitive_restart",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
];

/// Prefixes for shapes other than meshes: splats, volumes, and formulas.
const SHAPES: [&str; 3] = ["EXT_implicit_", "EXT_primitive_voxels", "KHR_gaussian_splatting"];

/// Extension that draws a mesh once for each entry of an accessor.
pub const INSTANCING: &str = "EXT_mesh_gpu_instancing";

pub fn may_be_required(extension: &str) -> bool {
    HARMLESS_PREFIXES.iter().any(|prefix| extension.starts_with(prefix))
        || [&HARMLESS[..], &SUPPORTED].concat().contains(&extension)
}

/// Whether the extension lets the largest index of its type restart a strip.
pub fn allows_restart(extension: &str) -> bool {
    extension.ends_with("_mesh_primitive_restart") && SUPPORTED.contains(&extension)
}

pub fn remedy(extension: &str) -> &'static str {
    match extension {
        INSTANCING => "export the instances as nodes",
        "KHR_accessor_float64" => "export it with 32-bit positions",
        _ if SHAPES.iter().any(|prefix| extension.starts_with(prefix)) => {
            "its shapes are not meshes: convert them to triangles, and export those"
        }
        _ => "it may change the geometry: export the shape as plain triangles",
    }
}
