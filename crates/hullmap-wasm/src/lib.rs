//! hullmap for the browser: opens packs and answers queries on hulls, or bakes meshes into packs.
//!
//! This is the border to JavaScript. Numbers go in and out as typed arrays, answers as plain
//! objects, errors as `Error` with the message of the Rust library. The npm package made of it
//! (`./build`) has TypeScript types. Its two modules are builds with one feature each.
//!
//! | module | feature | concept |
//! |---|---|---|
//! | `bake` | `bake` | a mesh file or arrays to a pack or a level |
//! | `options` | `bake` | options of a bake: a JavaScript object to the options of the command |
//! | `pack` | `queries` | packs and hulls |
//! | `level` | `queries` | triangle meshes and height fields |
//! | `shape` | `queries` | bodies of queries; rays |
//! | `pair` | `queries` | queries on two bodies |
//! | `motion` | `queries` | two bodies of which one moves and turns |
//! | `object` | `queries` | answers as plain JavaScript objects |
//! | `input` | both | arrays and strings from JavaScript, and the errors about them |

#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "bake")]
mod bake;
mod input;
#[cfg(feature = "queries")]
mod level;
#[cfg(feature = "queries")]
mod motion;
#[cfg(feature = "queries")]
mod object;
#[cfg(feature = "bake")]
mod options;
#[cfg(feature = "queries")]
mod pack;
#[cfg(feature = "queries")]
mod pair;
#[cfg(feature = "queries")]
mod shape;

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn console_error(text: &str);
}

/// Writes the message of a panic to the console: the exception says only `unreachable`.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| {
        console_error(&format!("hullmap: internal error, please report it: {panic}"));
    }));
}

/// Version of the package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}
