//! Formats that are not read, recognised by first bytes or extension. Each error names the format
//! and the remedy: a parser for another format would not.

use std::path::Path;

use crate::encoding::is_utf16;
use crate::fault::Fault;
use crate::format::{Format, NAMES};
use crate::stl;

/// Number of bytes within which the root element of XML and HTML, and the first name in a ZIP
/// archive, must appear.
const PROBE: usize = 4096;

#[derive(Debug, PartialEq, Eq)]
struct Unread {
    name: &'static str,
    /// Extensions, in lower case. Those that other kinds of files have too are left out.
    extensions: &'static [&'static str],
    /// A program that reads it, besides the one that wrote it; `None` if few do.
    converter: Option<&'static str>,
}

const fn format(name: &'static str, extensions: &'static [&'static str]) -> Unread {
    Unread { name, extensions, converter: None }
}

impl Unread {
    const fn in_program(self, converter: &'static str) -> Self {
        Self { converter: Some(converter), ..self }
    }
}

const FBX: Unread = format("FBX", &["fbx"]).in_program("Blender");
const USD: Unread = format("USD", &["usd", "usda", "usdc", "usdz"]).in_program("Blender");
const BLEND: Unread = format("Blender's own format", &["blend"]).in_program("Blender");

const UNREAD: [Unread; 41] = [
    FBX,
    USD,
    BLEND,
    format("3D Studio", &["3ds"]).in_program("MeshLab"),
    format("3MF", &["3mf"]).in_program("MeshLab"),
    format("Alembic", &["abc"]).in_program("Blender"),
    format("AMF", &["amf"]).in_program("FreeCAD"),
    format("Draco", &["drc"]),
    format("OFF", &["off"]).in_program("MeshLab"),
    format("OpenCTM", &["ctm"]),
    format("U3D", &["u3d"]),
    format("VRML", &["wrl", "wrz", "vrml"]).in_program("MeshLab"),
    format("X3D", &["x3d", "x3db", "x3dv"]).in_program("MeshLab"),
    format("3ds Max", &["max", "ase"]),
    format("Cinema 4D", &["c4d"]),
    format("LightWave", &["lwo", "lws"]),
    format("MagicaVoxel", &["vox"]),
    format("Maya", &["ma", "mb"]),
    format("Modo", &["lxo"]),
    format("Rhino", &["3dm"]),
    format("SketchUp", &["skp"]),
    format("ACIS", &["sat"]),
    format("AutoCAD", &["dwg", "dxf"]).in_program("FreeCAD"),
    format("BREP", &["brep", "brp"]).in_program("FreeCAD"),
    format("CATIA", &["catpart", "catproduct"]),
    format("FreeCAD", &["fcstd"]).in_program("FreeCAD"),
    format("Fusion", &["f3d"]),
    format("IFC", &["ifc"]).in_program("FreeCAD"),
    format("IGES", &["iges", "igs"]).in_program("FreeCAD"),
    format("Inventor", &["ipt", "iam"]),
    format("JT", &["jt"]),
    format("Parasolid", &["x_t", "x_b"]),
    format("SolidWorks", &["sldprt", "sldasm"]),
    format("STEP", &["step", "stp"]).in_program("FreeCAD"),
    format("MESH (of OGRE or Medit)", &["mesh"]),
    format("Quake", &["md2", "md3", "md5mesh"]),
    format("Valve's SMD", &["smd"]),
    format("VTK", &["vtk", "vtp", "vtu"]),
    format("E57", &["e57"]),
    format("LAS", &["las", "laz"]),
    format("PCD", &["pcd"]),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Foreign {
    Scene(&'static Unread),
    /// COLLADA, with the extension of another format.
    Misnamed,
    LfsPointer,
    Packed(&'static str),
    Image,
    /// A page of a web site, often a login page or a preview.
    WebPage,
}

/// Fails for formats that are not supported, Git LFS pointers, and UTF-16 other than OBJ.
pub fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, Fault> {
    let format = Format::detect(path, bytes);
    // The first 80 bytes of a binary STL file are a comment, which may hold anything.
    if format == Format::Stl && stl::has_binary_length(bytes) {
        return Ok(format);
    }
    // Any XML is left to the reader of COLLADA, which reports what it is.
    if format == Format::Collada && !bytes.starts_with(b"version ") && !is_utf16(bytes) {
        return Ok(format);
    }
    let by_name = || of_extension(path).map(Foreign::Scene);
    let found = match of_content(bytes) {
        // Some formats are archives.
        Some(packed @ Foreign::Packed(_)) => by_name().or(Some(packed)),
        found => found.or_else(by_name),
    };
    match found {
        Some(foreign) => Err(fault(foreign)),
        None if format != Format::Obj && is_utf16(bytes) => Err(Fault::Utf16),
        None => Ok(format),
    }
}

/// Whether the file is a Git LFS pointer: a short text for a large file that was not downloaded.
pub fn is_lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(b"version https://git-lfs.github.com/spec/v1")
}

pub const LFS_REMEDY: &str = "run `git lfs pull`";

fn fault(foreign: Foreign) -> Fault {
    Fault::format(match foreign {
        Foreign::Scene(Unread { name, converter, .. }) => {
            let program = converter.map_or(String::new(), |converter| format!(", or in {converter},"));
            format!(
                "the file is {name}, which is not supported; expected {NAMES}: open it in the program that wrote it{program} and export it as one of these"
            )
        }
        Foreign::Misnamed => "the file is COLLADA, with the extension of another format: rename it to .dae".to_owned(),
        Foreign::LfsPointer => format!("the file is a Git LFS pointer, not the mesh itself: {LFS_REMEDY}"),
        Foreign::Packed(kind) => format!("the file is {kind}; expected {NAMES}: unpack it"),
        Foreign::Image => {
            format!(
                "the file is an image; expected {NAMES}: name a mesh, or bake a terrain with `bake build --terrain`"
            )
        }
        Foreign::WebPage => format!("the file is a web page; expected {NAMES}: download the mesh itself"),
    })
}

fn of_content(bytes: &[u8]) -> Option<Foreign> {
    if is_lfs_pointer(bytes) {
        return Some(Foreign::LfsPointer);
    }
    let probe = bytes.get(..PROBE).unwrap_or(bytes);
    let has = |word: &[u8]| memchr::memmem::find(probe, word).is_some();
    match probe {
        [b'K', b'a', b'y', b'd', b'a', b'r', b'a', b' ', b'F', b'B', b'X', ..] => return Some(Foreign::Scene(&FBX)),
        [b'P', b'X', b'R', b'-', b'U', b'S', b'D', b'C', ..] => return Some(Foreign::Scene(&USD)),
        [b'B', b'L', b'E', b'N', b'D', b'E', b'R', b'-' | b'_' | b'1', ..] => return Some(Foreign::Scene(&BLEND)),
        [b'P', b'K', 3, 4, ..] => {
            let is_usdz = [&b".usdc"[..], b".usda", b".usd"].into_iter().any(has);
            return Some(if is_usdz { Foreign::Scene(&USD) } else { Foreign::Packed("a ZIP archive") });
        }
        [0x89, b'P', b'N', b'G', ..] => return Some(Foreign::Image),
        [0x1F, 0x8B, 8, ..] => return Some(Foreign::Packed("compressed with gzip")),
        [0x28, 0xB5, 0x2F, 0xFD, ..] => return Some(Foreign::Packed("compressed with Zstandard")),
        _ => {}
    }
    let text = probe.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(probe).trim_ascii_start();
    let starts = |word: &[u8]| text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    if starts(b"#usda ") {
        return Some(Foreign::Scene(&USD));
    }
    if starts(b"; FBX ") {
        return Some(Foreign::Scene(&FBX));
    }
    if starts(b"<") {
        if has(b"<COLLADA") {
            return Some(Foreign::Misnamed);
        }
        if starts(b"<!DOCTYPE html") || starts(b"<html") {
            return Some(Foreign::WebPage);
        }
    }
    None
}

fn of_extension(path: &Path) -> Option<&'static Unread> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    UNREAD.iter().find(|format| format.extensions.contains(&extension.as_str()))
}

/// Name of the format of a file, if its extension belongs to meshes or scenes that are not
/// supported.
pub fn unread_format(path: &Path) -> Option<&'static str> {
    of_extension(path).map(|format| format.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_in_lower_case_and_of_one_format() {
        let all: Vec<&str> = UNREAD.iter().flat_map(|format| format.extensions).copied().collect();
        for (index, extension) in all.iter().enumerate() {
            assert_eq!(extension.to_ascii_lowercase(), *extension);
            assert!(!all[..index].contains(extension) && !crate::EXTENSIONS.contains(extension), "{extension}");
        }
    }
}
