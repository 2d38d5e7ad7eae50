//! COLLADA 1.4 and 1.5: the geometry that the scene shows.
//!
//! 1. The scene's nodes are walked in their order, and transforms are multiplied (`scene`). An
//!    `instance_node` stands for the node that it names.
//! 2. Each instance of a geometry adds its transformed positions and its primitives (`geometry`):
//!    triangles, polygons, fans, strips and lines. Holes do not affect a hull, and are left out.
//! 3. Positions are multiplied by `unit meter`, so they are in metres. The up axis is not applied,
//!    as a note states: decision 17.
//!
//! Skins are read in their bind pose. Materials, animations and physics are skipped.
//!
//! # Reference
//! Khronos, "COLLADA: Digital Asset Schema Release 1.4.1" (2008).

mod geometry;
mod scene;
mod xml;

use roxmltree::{Document, ParsingOptions};

use crate::fault::{Fault, LineFault, excerpt};
use crate::limits::Limits;
use crate::mesh::SourceMesh;

/// A node takes about 100 bytes of memory, but as few as four of the file.
const MAX_NODES: u32 = 1 << 18;

/// Complexity: O(bytes), plus instances within `limits`.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<SourceMesh, LineFault> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text =
        std::str::from_utf8(text).map_err(|_| LineFault::of_file("the file is not UTF-8 text: save it as UTF-8"))?;
    if text.trim().is_empty() {
        return Err(LineFault::of_file("the file is empty; expected a COLLADA file: export it again"));
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let line = error.pos().row as usize;
        let fault = match error {
            roxmltree::Error::NodesLimitReached => {
                Fault::format(format!("the file has more than {MAX_NODES} XML nodes: split it"))
            }
            roxmltree::Error::DtdDetected => Fault::format(
                "the file has a document type definition, whose entities can expand without bound: remove <!DOCTYPE>",
            ),
            error => Fault::format(format!("invalid XML: {}; export the file again", excerpt(&error.to_string()))),
        };
        fault.at_line(line)
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        let name = excerpt(root.tag_name().name());
        return Err(LineFault::of_file(format!("the root is `{name}`, not `COLLADA`: check the extension")));
    }
    scene::read(&document, limits)
}
