//! Files of formats that are not read, recognised by their first bytes, or else by their extension.
//!
//! Each has an error that names the format and the remedy. Otherwise a renamed file would only get
//! the message of a parser for another format.

use std::path::Path;

use crate::encoding::is_utf16;
use crate::fault::Fault;
use crate::format::{Format, NAMES};
use crate::stl;

/// Number of bytes within which the root element of XML and HTML, and the first name in a ZIP
/// archive, must appear.
const PROBE: usize = 4096;

/// Scene formats that no reader here supports.
const FBX: &str = "FBX";
const COLLADA: &str = "COLLADA";
const USD: &str = "USD";
const BLEND: &str = "Blender's own format (.blend)";

/// What a file holds instead of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Foreign {
    /// A scene in a format with this name.
    Scene(&'static str),
    /// A Git LFS pointer.
    LfsPointer,
    /// An archive or compressed file of this kind.
    Packed(&'static str),
    /// A page of a web site, often of one that asks for a login or shows a preview.
    WebPage,
}

/// Format of a file that a reader can be tried on.
///
/// # Errors
/// The file is in a format that is not supported, is a Git LFS pointer, or is UTF-16 in a format
/// other than OBJ.
///
/// # Complexity
/// O(1).
pub fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, Fault> {
    let format = Format::of(path, bytes);
    // The first 80 bytes of a binary STL file are a comment, which may hold anything.
    if format == Format::Stl && stl::has_binary_length(bytes) {
        return Ok(format);
    }
    match of_content(bytes).or_else(|| of_extension(path)) {
        Some(foreign) => Err(fault(foreign)),
        None if format != Format::Obj && is_utf16(bytes) => Err(Fault::Utf16),
        None => Ok(format),
    }
}

/// Whether the file is a Git LFS pointer: a short text in place of a large file that Git did not
/// download.
pub fn is_lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(b"version https://git-lfs.github.com/spec/v1")
}

/// Remedy for a Git LFS pointer.
pub const LFS_REMEDY: &str = "run `git lfs pull`";

fn fault(foreign: Foreign) -> Fault {
    Fault::format(match foreign {
        Foreign::Scene(name) => format!(
            "the file is {name}, which is not supported; expected {NAMES}: open it in the program that wrote it, or in Blender, and export it as GLB"
        ),
        Foreign::LfsPointer => format!("the file is a Git LFS pointer, not the mesh itself: {LFS_REMEDY}"),
        Foreign::Packed(kind) => format!("the file is {kind}; expected {NAMES}: unpack it"),
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
        [b'K', b'a', b'y', b'd', b'a', b'r', b'a', b' ', b'F', b'B', b'X', ..] => return Some(Foreign::Scene(FBX)),
        [b'P', b'X', b'R', b'-', b'U', b'S', b'D', b'C', ..] => return Some(Foreign::Scene(USD)),
        [b'B', b'L', b'E', b'N', b'D', b'E', b'R', b'-' | b'_' | b'1', ..] => return Some(Foreign::Scene(BLEND)),
        [b'P', b'K', 3, 4, ..] => {
            let is_usdz = [&b".usdc"[..], b".usda", b".usd"].into_iter().any(has);
            return Some(if is_usdz { Foreign::Scene(USD) } else { Foreign::Packed("a ZIP archive") });
        }
        [0x1F, 0x8B, 8, ..] => return Some(Foreign::Packed("compressed with gzip")),
        [0x28, 0xB5, 0x2F, 0xFD, ..] => return Some(Foreign::Packed("compressed with Zstandard")),
        _ => {}
    }
    let text = probe.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(probe).trim_ascii_start();
    let starts = |word: &[u8]| text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    if starts(b"#usda ") {
        return Some(Foreign::Scene(USD));
    }
    if starts(b"; FBX ") {
        return Some(Foreign::Scene(FBX));
    }
    if starts(b"<") {
        if has(b"<COLLADA") {
            return Some(Foreign::Scene(COLLADA));
        }
        if starts(b"<!DOCTYPE html") || starts(b"<html") {
            return Some(Foreign::WebPage);
        }
    }
    None
}

fn of_extension(path: &Path) -> Option<Foreign> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(Foreign::Scene(match extension.as_str() {
        "fbx" => FBX,
        "dae" => COLLADA,
        "usd" | "usda" | "usdc" | "usdz" => USD,
        "blend" => BLEND,
        _ => return None,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(name: &str, bytes: &[u8]) -> String {
        match format_of(Path::new(name), bytes) {
            Ok(format) => format!("{format:?}"),
            Err(fault) => fault.to_string(),
        }
    }

    #[test]
    fn foreign_content_is_named_behind_every_extension() {
        let zip = |name: &str| [b"PK\x03\x04\x0A\0\0\0\0\0", &[0; 20][..], name.as_bytes()].concat();
        let files: [(&[u8], &str); 16] = [
            (b"Kaydara FBX Binary  \0\x1A\0", "the file is FBX"),
            (b"; FBX 7.3.0 project file\n", "the file is FBX"),
            (b"<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"\">", "the file is COLLADA"),
            (b"\xEF\xBB\xBF <COLLADA>", "the file is COLLADA"),
            (b"#usda 1.0\n(\n)", "the file is USD"),
            (b"PXR-USDC\0\x08", "the file is USD"),
            (&zip("scene.usdc"), "the file is USD"),
            (&zip("mesh.obj"), "a ZIP archive"),
            (b"BLENDER-v300REND", "Blender's own format"),
            (b"BLENDER_V248REND", "Blender's own format"),
            (b"BLENDER17-01v0500REND", "Blender's own format"),
            (b"\x1F\x8B\x08\0", "compressed with gzip"),
            (b"\x28\xB5\x2F\xFD\0", "compressed with Zstandard"),
            (b"\n<!doctype HTML><html>", "a web page"),
            (b"<html lang=\"en\">", "a web page"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "run `git lfs pull`"),
        ];
        for (bytes, expected) in files {
            for name in ["a.obj", "a.gltf", "a.glb", "a.stl", "a.ply", "a.fbx", "a.txt", "a"] {
                let message = message(name, bytes);
                assert!(message.contains(expected), "{name}, {}: {message}", bytes.escape_ascii());
            }
        }
    }

    #[test]
    fn foreign_extensions_are_named_whatever_the_content() {
        for (name, expected) in [
            ("a.FBX", "the file is FBX"),
            ("a.dae", "the file is COLLADA"),
            ("a.usd", "the file is USD"),
            ("a.usdz", "the file is USD"),
            ("a.blend", "Blender's own format"),
        ] {
            for bytes in [&b""[..], b"v 0 0 0\n"] {
                assert!(message(name, bytes).contains(expected), "{name}");
            }
        }
    }

    #[test]
    fn files_of_a_supported_format_pass() {
        let mut stl = b"PK\x03\x04 in the comment of a binary file".to_vec();
        stl.resize(84 + 50, 0);
        stl[80] = 1;
        assert_eq!(message("a.stl", &stl), "Stl");
        for bytes in [&b"# Blender 4.0\nv 0 0 0\n"[..], b"# see <COLLADA>\n", b"\xFF\xFEv\0", b"", b"<"] {
            assert_eq!(message("a.obj", bytes), "Obj");
        }
        assert!(message("a.ply", b"\xFF\xFEp\0l\0y\0").contains("UTF-16"));
        assert!(message("a.gltf", b"\xFE\xFF\0{").contains("UTF-16"));
    }
}
