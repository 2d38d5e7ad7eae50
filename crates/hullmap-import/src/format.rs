//! Source formats, and how a file's format is recognised.

use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Obj,
    Gltf,
    Stl,
    Ply,
    Collada,
    /// MuJoCo's MSH.
    Msh,
}

/// File name extensions of source files, in lower case.
pub const EXTENSIONS: [&str; 7] = ["obj", "gltf", "glb", "stl", "ply", "dae", "msh"];

const FORMATS: [Format; EXTENSIONS.len()] =
    [Format::Obj, Format::Gltf, Format::Gltf, Format::Stl, Format::Ply, Format::Collada, Format::Msh];

/// Names of the formats, for messages.
pub const NAMES: &str = "OBJ, glTF, GLB, STL, PLY, COLLADA or MSH";

impl Format {
    /// Format of a file, by its extension in any case. If the extension is unknown, the first bytes
    /// decide: `glTF`, `ply`, or else OBJ, which has no signature.
    pub fn detect(path: &Path, bytes: &[u8]) -> Self {
        Self::of_extension(path).unwrap_or(match bytes {
            [b'g', b'l', b'T', b'F', ..] => Self::Gltf,
            [b'p', b'l', b'y', b'\r' | b'\n', ..] => Self::Ply,
            _ => Self::Obj,
        })
    }

    fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let known = EXTENSIONS.iter().zip(FORMATS).find(|(known, _)| **known == extension);
        known.map(|(_, format)| format)
    }
}

/// Whether the extension of a file is one of [`EXTENSIONS`], in any case.
pub fn is_source(path: &Path) -> bool {
    Format::of_extension(path).is_some()
}

/// Whether y points up in files of this format, by their extension. glTF states it. OBJ states
/// nothing, and most programs that read it take y for up. In the other formats z is up by custom.
pub fn is_y_up(path: &Path) -> bool {
    matches!(Format::of_extension(path), Some(Format::Gltf | Format::Obj))
}

/// Whether the importer's lengths are metres, by the extension: glTF is in metres, and the unit
/// that a COLLADA file states is applied.
pub fn is_in_metres(path: &Path) -> bool {
    matches!(Format::of_extension(path), Some(Format::Gltf | Format::Collada))
}

/// Whether a file has the extension of glTF buffers, `.bin`, in any case.
pub fn is_buffer(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bin"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_takes_precedence_over_the_bytes() {
        for (name, bytes, format) in [
            ("a.obj", &b"glTF"[..], Format::Obj),
            ("a.v2.GLB", b"", Format::Gltf),
            ("a.gltf", b"", Format::Gltf),
            ("a.Stl", b"", Format::Stl),
            ("a.ply", b"", Format::Ply),
            ("a.DAE", b"", Format::Collada),
            ("a.msh", b"", Format::Msh),
            ("a.txt", b"ply\r\n", Format::Ply),
            ("a.txt", b"glTF", Format::Gltf),
            ("a.txt", b"plywood", Format::Obj),
            ("a", b"v 0 0 0", Format::Obj),
        ] {
            assert_eq!(Format::detect(Path::new(name), bytes), format, "{name}");
            assert_eq!(is_source(Path::new(name)), !name.ends_with("txt") && name != "a", "{name}");
        }
        assert!(EXTENSIONS.iter().all(|extension| is_source(&Path::new("x").with_extension(extension))));
        let axes = EXTENSIONS.map(|extension| is_y_up(&Path::new("x").with_extension(extension)));
        assert_eq!(axes, [true, true, true, false, false, false, false], "{EXTENSIONS:?}");
        assert!(is_in_metres(Path::new("a.GLB")) && !is_in_metres(Path::new("a.obj")));
        assert!(is_buffer(Path::new("a.BIN")) && !is_buffer(Path::new("a.obj")));
    }
}
