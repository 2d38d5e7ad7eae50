//! Reads bytes as a source file of any format.

use std::path::Path;

use hullmap_import::{EXTENSIONS, ImportOptions, Limits, SourceFile, Split, UpAxis, Vertices};

/// Low limits, so that a few bytes cannot request all of the fuzzer's memory.
const LIMITS: Limits = Limits { objects: 1 << 10, repeated_vertices: 1 << 16, ..Limits::DEFAULT };

/// Imports a file. The first byte selects the format, the second the options. Panics if a point is
/// not finite, a number is out of range, two hulls have the same name, or an error does not name
/// the file.
pub fn import(data: &[u8]) {
    let [format, choice, bytes @ ..] = data else { return };
    let file = format!("fuzzed.{}", EXTENSIONS[usize::from(*format) % EXTENSIONS.len()]);
    let options = options(*choice);
    let source = SourceFile::alone(bytes.to_vec());
    let mut imported = match hullmap_import::import(&file, "fuzzed", Path::new(&file), &source, &options, &LIMITS) {
        Ok(imported) => imported,
        Err(error) => {
            let text = error.to_string();
            assert!(text.starts_with(&file) && !text.contains('\n'), "{text}");
            return;
        }
    };
    assert_eq!(imported.point_sets.len(), imported.faces.len());
    assert!(!imported.point_sets.is_empty());
    imported.give_triangles();
    let mut names: Vec<&str> = imported.point_sets.iter().map(|set| set.name.as_str()).collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
    for set in &imported.point_sets {
        assert!(!set.positions.is_empty());
        assert_eq!(set.positions.len(), set.source_vertices.len());
        assert!(set.positions.iter().flatten().all(|x| x.is_finite()), "{set:?}");
        assert!(set.origin.iter().all(|x| x.is_finite()), "{set:?}");
        assert!(set.source_vertices.iter().all(|&vertex| (vertex as usize) < imported.vertex_count), "{set:?}");
        assert!(set.triangles.iter().flatten().all(|&point| (point as usize) < set.positions.len()), "{set:?}");
    }
}

fn options(choice: u8) -> ImportOptions {
    let is_set = |bit: u8| choice >> bit & 1 == 1;
    ImportOptions {
        split: [Split::None, Split::Object, Split::Auto, Split::Auto][usize::from(choice & 3)],
        vertices: if is_set(2) { Vertices::All } else { Vertices::Referenced },
        unit_scale: if is_set(3) { 0.0254 } else { 1.0 },
        up_axis: [UpAxis::Keep, UpAxis::YToZ, UpAxis::ZToY, UpAxis::Keep][usize::from(choice >> 4 & 3)],
        recentre: is_set(6),
    }
}
