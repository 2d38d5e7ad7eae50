//! Options of a bake: from a JavaScript object to the keys and values of `hullmap.toml`, and back
//! in messages.

use js_sys::{Object, Reflect};
use wasm_bindgen::prelude::*;

use crate::input::error;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Called with the share of a bake that is done, from 0 to 1. `false` ends the bake with an error. */
export type OnProgress = (share: number) => unknown;

/** Options of `bake` and `bakeMesh`: the options of the command. docs/COMMAND.md describes them. */
export interface BakeOptions {
    /** Name of the hull; only of `bakeMesh`. Default "mesh". */
    name?: string;
    /** One hull for the file, for each object, or for each named collision part. Default "none". */
    split?: "none" | "object" | "auto";
    /** Use the vertices that elements reference, or all vertices. Default "referenced". */
    vertices?: "referenced" | "all";
    /** Direction index. Default "tree". */
    index?: "tree" | "medium" | "compact" | "binary" | "cubemap" | "none";
    /** Factor of all coordinates, above 0. Default 1. */
    unitScale?: number;
    /** Rotation about x: "y-to-z" turns a y-up mesh into a z-up mesh. Default "keep". */
    upAxis?: "keep" | "y-to-z" | "z-to-y";
    /** Move the origin to the centre of the bounds. Default false. */
    recentre?: boolean;
    /** Decompose a concave mesh into convex parts. Default false. */
    decompose?: boolean;
    /**
     * Replace each hull by an enclosing one with at most this many vertices, 4 or more; default: the exact hull. With
     * `decompose`, of each part; default: 64, or 255 if one part is enough.
     */
    maxVertices?: number | "none";
    /**
     * Replace each hull by an enclosing one that extends at most this far beyond it: a length, or a
     * share of the diagonal, such as "1%". With `decompose`, maximum protrusion of a part; default "2%".
     */
    maxError?: number | `${number}%` | `${number}mm` | "none";
    /** Maximum number of parts; the search then looks for the smallest error. */
    maxParts?: number | "none";
    /**
     * The solid of an open mesh: its inside, after its holes are closed; or its walls only, so that openings stay
     * open. "auto": open surfaces are walls if half of their area has faces on both sides, a hole has more than an
     * eighth of it, or all holes together more than all of it; watertight surfaces are solid.
     */
    solid?: "auto" | "closed" | "walls";
    /** Thickness of the parts of walls: a length, or a share of the diagonal. Default "0.5%". */
    wall?: number | `${number}%` | "none";
    /** Record a box, sphere, capsule or cylinder for each part that it can replace. Default false. */
    primitives?: boolean;
    /** Simplify hulls and parts to the limits of an engine. Default "none". */
    forEngine?: "none" | "physx" | "physx-gpu" | "jolt" | "box3d" | "unity" | "unreal" | "newton" | "mujoco-warp";
    /** Leave out data that only manifolds and hints need. Default false. */
    lean?: boolean;
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "BakeOptions")]
    pub type BakeOptions;
}

/// The options of a bake, by the keys of `hullmap.toml`.
#[derive(Clone, Debug, Default)]
pub struct Options {
    name: Option<String>,
    pairs: Vec<(String, String)>,
}

impl Options {
    /// Reads a JavaScript object. Properties that are undefined or null have their defaults.
    ///
    /// # Errors
    /// A property has a value that is not a word, number or truth value, or it cannot work in
    /// WebAssembly.
    pub fn read(given: Option<&BakeOptions>) -> Result<Self, JsError> {
        let mut options = Self::default();
        let Some(given) = given.map(AsRef::<JsValue>::as_ref).filter(|given| !given.is_null()) else {
            return Ok(options);
        };
        let Some(object) = given.dyn_ref::<Object>() else {
            return Err(error("the options must be an object, such as { maxVertices: 64 }"));
        };
        for key in Object::keys(object).iter() {
            let value = Reflect::get(object, &key).unwrap_or(JsValue::UNDEFINED);
            if value.is_undefined() || value.is_null() {
                continue;
            }
            let key = key.as_string().unwrap_or_default();
            let text = match (value.as_string(), value.as_f64(), value.as_bool()) {
                (Some(word), ..) => word,
                (_, Some(number), _) => number.to_string(),
                (.., Some(is_on)) => is_on.to_string(),
                _ => return Err(error(format!("option {key}: expected a word, a number or a truth value"))),
            };
            match key.as_str() {
                "name" => options.name = Some(text),
                "decomposeSeconds" => {
                    let remedy = "leave out the option; a larger maxError takes less time";
                    return Err(error(format!("option {key}: WebAssembly has no clock to stop a search: {remedy}")));
                }
                _ if key.contains('_') => {
                    let meant = camel_case(&key);
                    return Err(error(format!("unknown option {key}: write it as in JavaScript, {meant}")));
                }
                _ => options.pairs.push((snake_case(&key), text)),
            }
        }
        Ok(options)
    }

    /// Name of a hull that comes from no file.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Keys and values.
    pub fn pairs(&self) -> Vec<(&str, &str)> {
        self.pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
    }
}

/// A message of the command, with the options by their names in JavaScript: `--max-vertices`
/// becomes `maxVertices`, and so does `max_vertices` in a message about options.
pub fn in_javascript(message: &str, is_about_options: bool) -> String {
    let message = &message
        .replace("use TriangleMesh (Python), bake_level (Rust), or `bake build --keep-triangles`", "use bakeLevel");
    if is_about_options {
        return camel_case(message);
    }
    hullmap_pipeline::without_flags(message, camel_case)
}

/// `maxVertices` of `max_vertices`.
fn camel_case(text: &str) -> String {
    let mut words = text.split('_');
    let mut out = words.next().unwrap_or_default().to_owned();
    for word in words {
        let mut letters = word.chars();
        out.extend(letters.next().map(|first| first.to_ascii_uppercase()));
        out += letters.as_str();
    }
    out
}

/// `max_vertices` of `maxVertices`.
fn snake_case(key: &str) -> String {
    let mut out = String::with_capacity(key.len() + 4);
    for c in key.chars() {
        if c.is_ascii_uppercase() {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
    }
    out
}
