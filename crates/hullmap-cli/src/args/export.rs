//! Arguments of `bake export`.

use std::path::PathBuf;

use clap::ValueEnum;
use hullmap_import::UpAxis;

use super::usd::UsdArgs;
use crate::scene::colliders::Draft;

#[derive(Debug, clap::Args)]
pub struct ExportArgs {
    /// Baked files, or folders of them [default: `output` of hullmap.toml]
    #[arg(required = true, value_name = "FILE|DIR")]
    pub packs: Vec<PathBuf>,
    /// File to write, or folder [default: standard output]
    ///
    /// A folder if several files are written
    #[arg(short, long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Write obj, stl, glb, json or f32 [default: as --out]
    ///
    /// Without it, the extension of --out decides, or the engine
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// Use the names and files of an engine
    ///
    /// One of unreal, godot, khr-physics, omi, both, mjcf, urdf, sdf or usd
    #[arg(long = "for", value_enum, value_name = "ENGINE")]
    pub target: Option<Target>,
    /// Add the hulls to this glTF file, as colliders
    ///
    /// They go below the nodes of their objects. Requires --for khr-physics, omi, both, godot, or
    /// unreal, which also takes an OBJ file
    #[arg(long, value_name = "FILE", requires = "target")]
    pub into: Option<PathBuf>,
    /// With --into, write static colliders, without masses
    #[arg(long = "static", hide_short_help = true, requires = "into")]
    pub is_static: bool,
    /// Draft of KHR_physics_rigid_bodies
    #[arg(long = "set draft", value_enum, default_value_t = Draft::October2025, value_name = "2025-10|2026-06")]
    pub draft: Draft,
    /// Export only this hull, by name or index; repeatable
    #[arg(long = "hull", value_name = "NAME")]
    pub hulls: Vec<String>,
    /// Write one file per hull to a folder
    ///
    /// Files are named after the hulls
    #[arg(long)]
    pub parts: bool,
    /// Name of the mesh, node, body, link or prim
    ///
    /// The render mesh of Unreal, the node of Godot, the body of MJCF, the link of URDF and SDF, or
    /// the prim of the mesh in USD; one pack only
    #[arg(long, value_name = "NAME", requires = "target")]
    pub name: Option<String>,
    /// Also draw the hulls, in glTF with colliders
    #[arg(long = "visible", hide_short_help = true)]
    pub is_visible: bool,
    /// Prefix of file names in MJCF, URDF and SDF, for instance package://robot/meshes/
    #[arg(long = "set mesh_prefix", value_name = "PREFIX")]
    pub mesh_prefix: Option<String>,
    /// Density for masses: kg per cubic unit; default 1000
    ///
    /// For MJCF, URDF, SDF and USD, and with --into. Units are the pack's, or with --into the glTF
    /// file's; in USD, the default is 1000 per cubic metre
    #[arg(long, hide_short_help = true, value_name = "DENSITY", value_parser = density)]
    pub density: Option<f64>,
    /// Rotate about x: y-to-z or z-to-y
    ///
    /// z-to-y turns a z-up hull into a y-up mesh
    #[arg(long, hide_short_help = true, value_enum, default_value_t = UpAxis::Keep, value_name = "TURN")]
    pub up_axis: UpAxis,
    #[command(flatten)]
    pub usd: UsdArgs,
    /// Replace files that bake did not write, or edited ones
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Formats of exported meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Wavefront OBJ
    Obj,
    /// Binary STL
    Stl,
    /// Binary glTF 2.0
    Glb,
    /// JSON
    Json,
    /// Heights of a height field, as raw numbers
    F32,
}

impl Format {
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Glb => "glb",
            Self::Json => "json",
            Self::F32 => "f32",
        }
    }
}

/// Engines and documents with rules of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Meshes named `UCX_<render mesh>_<nn>`
    Unreal,
    /// glTF with `OMI_physics_body`
    Godot,
    /// glTF with `KHR_physics_rigid_bodies`
    KhrPhysics,
    /// glTF with `OMI_physics_body`
    Omi,
    /// glTF with both extensions
    Both,
    /// A MuJoCo model and its mesh files
    Mjcf,
    /// A link and its mesh files
    Urdf,
    /// A model of one link for Gazebo, and its mesh files
    Sdf,
    /// A layer over a stage
    Usd,
}

impl Target {
    /// Whether it is a document that names mesh files and states the mass.
    pub fn is_document(self) -> bool {
        matches!(self, Self::Mjcf | Self::Urdf | Self::Sdf)
    }

    /// Whether it is glTF with colliders by an extension.
    pub fn is_physics(self) -> bool {
        matches!(self, Self::Godot | Self::KhrPhysics | Self::Omi | Self::Both)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Unreal => "Unreal",
            Self::Godot => "Godot",
            Self::KhrPhysics => "KHR_physics_rigid_bodies",
            Self::Omi => "OMI_physics_body",
            Self::Both => "glTF physics",
            Self::Mjcf => "MuJoCo",
            Self::Urdf => "URDF",
            Self::Sdf => "SDF",
            Self::Usd => "USD",
        }
    }
}

fn density(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|density: &f64| *density > 0.0 && density.is_finite());
    found.ok_or_else(|| "expected a number above 0, such as 1000 or 2700".to_owned())
}
