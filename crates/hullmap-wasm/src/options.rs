//! Options of a bake: from a JavaScript object, and as the text that a pack records.
//!
//! The text is that of the command, so that a pack baked in a browser has the same bytes as one
//! that `bake build` wrote with the same options. `tests/node.mjs` compares them.

use hullmap_bake::IndexKind;
use hullmap_bake::simplify::Limit;
use hullmap_import::{ImportOptions, Split, Vertices};
use js_sys::{Object, Reflect};
use wasm_bindgen::prelude::*;

use crate::object::error;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Options of `bake`, with the names and values of the command's options. */
export interface BakeOptions {
    /** One hull for the file, for each object, or for each named collision part. Default "none". */
    split?: "none" | "object" | "auto";
    /** Use the vertices that elements reference, or all vertices. Default "referenced". */
    vertices?: "referenced" | "all";
    /** Direction index. Default "tree". */
    index?: "tree" | "medium" | "compact" | "binary" | "cubemap" | "none";
    /** Replace each hull by an enclosing one with at most this many vertices, 4 or more. */
    maxVertices?: number;
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "BakeOptions")]
    pub type BakeOptions;
}

/// The options of a bake.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    split: Split,
    vertices: Vertices,
    /// The direction index.
    pub index: IndexKind,
    max_vertices: Option<u32>,
}

const KEYS: &str = "split, vertices, index, maxVertices";

impl Options {
    /// Reads a JavaScript object. Missing and undefined properties have their defaults.
    ///
    /// # Errors
    /// A property is unknown, or has an invalid value.
    pub fn read(given: Option<&BakeOptions>) -> Result<Self, JsError> {
        let mut options =
            Self { split: Split::None, vertices: Vertices::Referenced, index: IndexKind::Tree, max_vertices: None };
        let Some(given) = given.map(AsRef::<JsValue>::as_ref).filter(|given| !given.is_null()) else {
            return Ok(options);
        };
        let Some(object) = given.dyn_ref::<Object>() else {
            return Err(error(format!("the options must be an object with the properties {KEYS}")));
        };
        for key in Object::keys(object).iter() {
            let value = Reflect::get(object, &key).unwrap_or(JsValue::UNDEFINED);
            if value.is_undefined() {
                continue;
            }
            let (key, word) = (key.as_string().unwrap_or_default(), value.as_string().unwrap_or_default());
            let invalid = |expected: &str| Err(error(format!("invalid value of option {key}: expected {expected}")));
            match (key.as_str(), word.as_str()) {
                ("split", "none") => options.split = Split::None,
                ("split", "object") => options.split = Split::Object,
                ("split", "auto") => options.split = Split::Auto,
                ("split", _) => return invalid("none, object or auto"),
                ("vertices", "referenced") => options.vertices = Vertices::Referenced,
                ("vertices", "all") => options.vertices = Vertices::All,
                ("vertices", _) => return invalid("referenced or all"),
                ("index", word) => match word.parse() {
                    Ok(kind) => options.index = kind,
                    Err(_) => return invalid("tree, medium, compact, binary, cubemap or none"),
                },
                ("maxVertices", _) => match value.as_f64().filter(|n| n.fract() == 0.0) {
                    Some(count) if (4.0..=f64::from(u32::MAX)).contains(&count) => {
                        options.max_vertices = Some(count as u32);
                    }
                    _ => return invalid("a whole number of 4 or more"),
                },
                _ => return Err(error(format!("unknown option {key}: the options are {KEYS}"))),
            }
        }
        Ok(options)
    }

    /// How the source is read.
    pub fn import(&self) -> ImportOptions {
        ImportOptions { split: self.split, vertices: self.vertices, ..ImportOptions::DEFAULT }
    }

    /// How far hulls are simplified.
    pub fn limit(&self) -> Option<Limit> {
        self.max_vertices.map(|count| Limit::Vertices(count as usize))
    }

    /// The text that a pack records.
    pub fn record(&self) -> String {
        let split = match self.split {
            Split::None => "none",
            Split::Object => "object",
            Split::Auto => "auto",
        };
        let vertices = match self.vertices {
            Vertices::Referenced => "referenced",
            Vertices::All => "all",
        };
        let index = match self.index {
            kind if kind.is_tree() => format!("tree {}", kind.leaf_size()),
            kind => kind.to_string(),
        };
        let limit = self.max_vertices.map_or_else(String::new, |count| format!(", max_vertices {count}"));
        format!("split {split}, vertices {vertices}, index {index}{limit}")
    }
}
